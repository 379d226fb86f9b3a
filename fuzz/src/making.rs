//! Models generated from the fuzzer's bytes, which serve as a sequence of choices.
//!
//! Models are text, so that a finding can be read, reduced by hand, and preserved when this code
//! changes.

use arbitrary::Unstructured;
use std::fmt::Write as _;
use stiction_format::gallery;

/// Writes a model to the file named by the variable `STICTION_FUZZ_TEXT`, if it is set, because the
/// bytes of a finding are not readable.
pub fn keep(text: &str) {
    if let Some(file) = std::env::var_os("STICTION_FUZZ_TEXT") {
        std::fs::write(file, text).expect("the text can be written");
    }
}

/// Sequence of choices. After its end, every choice selects the first alternative.
struct Choices<'a>(Unstructured<'a>);

impl Choices<'_> {
    fn below(&mut self, count: usize) -> usize {
        if count == 0 { 0 } else { self.0.int_in_range(0..=count - 1).unwrap_or(0) }
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// True with a probability of one in `times`.
    fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == 1 % times
    }

    /// Returns a plausible number or, with a probability of one in `wild`, an implausible one.
    fn number(&mut self, wild: usize) -> String {
        const USUAL: [&str; 16] = [
            "0.1", "1", "0.3", "0.02", "2", "-0.1", "0.5", "-0.25", "0.7", "10", "-1", "3", "0.05",
            "-0.4", "1e-3", "100",
        ];
        const ODD: [&str; 18] = [
            "0", "-0.0", "5e-324", "1e-308", "1e-300", "1e30", "-1e30", "1e-200", "1e29", "1e-155",
            "1e25", "1e-30", "1e20", "-1e20", "1e-20", "1e12", "1e-12", "1e-9",
        ];
        if self.once_in(wild) {
            return self.one(&ODD).to_owned();
        }
        match self.below(4) {
            0 => format!("{}", (self.below(4001) as f64 - 2000.0) / 1000.0),
            _ => self.one(&USUAL).to_owned(),
        }
    }

    /// Returns a nonnegative number, implausible with a probability of one in `wild`.
    fn amount(&mut self, wild: usize) -> String {
        self.number(wild).trim_start_matches('-').to_owned()
    }

    fn vector(&mut self, wild: usize) -> String {
        format!("[{}, {}, {}]", self.number(wild), self.number(wild), self.number(wild))
    }

    fn axis(&mut self, wild: usize) -> String {
        match self.below(4) {
            0 => self.vector(wild),
            _ => format!("{:?}", self.one(&["z", "x", "y", "-z", "-x"])),
        }
    }

    fn signal(&mut self, wild: usize) -> String {
        let (a, b) = (self.number(wild), self.number(wild));
        match self.below(12) {
            0..=2 => format!("{a}*sin({b}*t)"),
            3 => a,
            4 => format!("{a} + {b}*t"),
            5 => format!("{a}*t^2"),
            6 => format!("{a}*smooth(t, 0, {b})"),
            7 => format!("{a}*exp({b}*t)"),
            8 => format!("{a}/({b} + t)"),
            9 => format!("abs({a}*t - {b})"),
            10 => format!("sqrt({a} + {b}*t)"),
            _ => format!("{a}*t^{b}"),
        }
    }
}

const TYPES: [&str; 12] = ["R", "P", "R", "P", "H", "C", "U", "S", "E", "fixed", "free", "R"];

/// Names of a joint type's degrees of freedom.
fn dofs(joint_type: &str) -> &'static [&'static str] {
    match joint_type {
        "R" | "P" | "H" => &[""],
        "C" => &[".angle", ".slide"],
        "U" => &[".first", ".second"],
        "E" => &[".x", ".y", ".angle"],
        _ => &[],
    }
}

fn friction(choices: &mut Choices<'_>, wild: usize, out: &mut String) {
    if choices.once_in(2) {
        return;
    }
    let mut keys = vec![format!("mu = {}", choices.amount(wild))];
    let mut may = |choices: &mut Choices<'_>, key: &str, often: usize| {
        if !choices.once_in(often) {
            keys.push(format!("{key} = {}", choices.amount(wild)));
        }
    };
    may(choices, "radius", 12);
    if choices.once_in(3) {
        may(choices, "viscous", 2);
        may(choices, "preload", 2);
        may(choices, "bending_span", 2);
        may(choices, "collar_radius", 2);
        may(choices, "torsion_arm", 2);
    }
    match choices.below(8) {
        0 => may(choices, "mu_static", 9),
        1 => {
            may(choices, "mu_static", 9);
            may(choices, "stribeck_velocity", 9);
            may(choices, "stribeck_exponent", 2);
        }
        2 => {
            keys.push("regularised = \"tanh\"".to_owned());
            keys.push(format!("regularisation_velocity = {}", choices.amount(wild)));
        }
        3 => {
            keys.push("law = \"lugre\"".to_owned());
            for key in ["sigma0", "sigma1", "sigma2"] {
                keys.push(format!("{key} = {}", choices.amount(wild)));
            }
        }
        4 => keys.push(format!("backward = {{ mu = {} }}", choices.amount(wild))),
        5 => keys.push(format!("combine = {:?}", choices.one(&["pads", "root-sum-square", "sum"]))),
        _ => {}
    }
    let _ = writeln!(out, "friction = {{ {} }}", keys.join(", "));
}

/// Writes the keys of a joint other than its two bodies.
fn joint(choices: &mut Choices<'_>, joint_type: &str, wild: usize, driven: bool, out: &mut String) {
    if !matches!(joint_type, "S" | "fixed" | "free") || choices.once_in(20) {
        let _ = writeln!(out, "axis = {}", choices.axis(wild));
    }
    if joint_type == "U" {
        let _ = writeln!(out, "second_axis = {}", choices.axis(wild));
    }
    if joint_type == "H" {
        let _ = writeln!(out, "pitch = {}", choices.number(wild));
    }
    if driven {
        let _ = writeln!(out, "actuated = true");
    }
    if dofs(joint_type).len() == 1 && choices.once_in(4) {
        let _ = writeln!(out, "start = {}", choices.number(wild));
    }
    friction(choices, wild, out);
    if choices.once_in(8) {
        let keys = ["radial", "axial", "bending", "torsional"];
        let all = keys.map(|key| format!("{key} = {}", choices.amount(wild)));
        let _ = writeln!(out, "compliance = {{ {} }}", all.join(", "));
    }
}

/// Generates a mechanism with bodies, joints of all types, closed loops or legs, springs, a motion
/// and a load.
pub fn mechanism(bytes: &[u8]) -> String {
    let mut choices = Choices(Unstructured::new(bytes));
    let c = &mut choices;
    // Some models contain almost no implausible numbers, because a single one often causes early
    // rejection.
    let wild = c.one(&[1_000_000, 40, 200, 12]);
    let mut out = format!("gravity = {}\n", c.vector(wild));
    if c.once_in(6) {
        let _ = writeln!(out, "characteristic_length = {}", c.amount(wild));
    }
    if c.once_in(6) {
        let _ = writeln!(
            out,
            "[base]\nposition = {}\nrotation = {{ axis = {}, angle = {} }}",
            c.vector(wild),
            c.axis(wild),
            c.number(wild)
        );
    }
    let bodies = 1 + c.below(4);
    for body in 0..bodies {
        let _ = writeln!(out, "[bodies.b{body}]");
        if !c.once_in(10) {
            let m = c.amount(wild);
            let (i, k) = (c.amount(wild), c.amount(wild));
            let _ =
                writeln!(out, "mass = {m}\ncom = {}\ninertia = [{i}, {i}, {k}]", c.vector(wild));
        }
    }
    // Joints: first a tree, then loops. The frames of all bodies coincide at zero coordinates, so
    // that every loop is closed there.
    let mut driven = Vec::new();
    let loops = c.below(3);
    for index in 0..bodies + loops {
        let joint_type = c.one(&TYPES);
        let (from, to) = match index < bodies {
            true => (c.below(index + 1), index + 1),
            false => (c.below(bodies + 1), c.below(bodies + 1)),
        };
        let name = |body: usize| match body {
            0 => "ground".to_owned(),
            body => format!("b{}", body - 1),
        };
        let place = c.vector(wild);
        let other = if c.once_in(8) { c.vector(wild) } else { place.clone() };
        let _ = writeln!(
            out,
            "[joints.J{index}]\ntype = {joint_type:?}\nfrom = {:?}\nto = {:?}\nat = {place}\nto_at = {other}",
            name(from),
            name(to)
        );
        let has_drive = !dofs(joint_type).is_empty() && (index < bodies || c.once_in(4));
        let has_drive = has_drive && !c.once_in(4);
        joint(c, joint_type, wild, has_drive, &mut out);
        if has_drive {
            driven.extend(dofs(joint_type).iter().map(|own| format!("J{index}{own}")));
        }
    }
    if c.once_in(5) {
        legs(c, wild, &mut out, &mut driven);
    }
    if c.once_in(5) {
        let _ = writeln!(
            out,
            "[springs.s]\nfrom = \"ground\"\nto = \"b0\"\nat = {}\nto_at = {}\nstiffness = {}\nfree_length = {}\ndamping = {}",
            c.vector(wild),
            c.vector(wild),
            c.amount(wild),
            c.amount(wild),
            c.amount(wild)
        );
    }
    motion(c, wild, &driven, &mut out);
    if !c.once_in(3) {
        let _ = writeln!(
            out,
            "[loads.l]\nb0 = {{ force = [{:?}, {}, {}], moment = {}, at = {} }}\n[default]\nload = \"l\"",
            c.signal(wild),
            c.number(wild),
            c.number(wild),
            c.vector(wild),
            c.vector(wild)
        );
    }
    out
}

fn legs(c: &mut Choices<'_>, wild: usize, out: &mut String, driven: &mut Vec<String>) {
    let chain = c.one(&["R P* S", "U P* S", "R* R R", "S P* S", "P* R R", "U* S S", "C* S"]);
    let count = 1 + c.below(3);
    let angles: Vec<String> = (0..count).map(|k| format!("\"{} deg\"", 120 * k)).collect();
    let _ = writeln!(
        out,
        "[legs]\nchain = {chain:?}\nto = \"b0\"\nangles = [{}]\nfoot = {}\ntip = {}",
        angles.join(", "),
        c.vector(wild),
        c.vector(wild)
    );
    if chain == "R P* S" {
        let _ = writeln!(
            out,
            "[legs.joints.R]\naxis = \"y\"\n[legs.joints.P]\naxis = \"z\"\nstart = 0.5"
        );
        friction(c, wild, out);
        driven.extend((1..=count).map(|leg| format!("leg{leg}.P")));
    }
}

fn motion(c: &mut Choices<'_>, wild: usize, driven: &[String], out: &mut String) {
    let _ = writeln!(out, "[motions.m]\nduration = {}", c.amount(wild));
    if c.once_in(10) {
        let _ = writeln!(out, "start = {}", c.number(wild));
    }
    // The coordinates of a joint and those of its degrees of freedom are keys of one table.
    for name in driven {
        if !c.once_in(12) {
            let signal = match c.below(3) {
                0 => "0.1*sin(2*t)".to_owned(),
                _ => c.signal(wild),
            };
            let _ = writeln!(out, "{name} = {signal:?}");
        }
    }
    if c.once_in(5) {
        let which = c.one(&["x", "y", "z", "rx", "rz", "rvx"]);
        let _ = writeln!(out, "b0.{which} = {:?}", c.signal(wild));
    }
}

/// Gallery models that are small enough to be run many times.
const SMALL: [&str; 7] =
    ["four-bar", "slider-crank", "five-bar", "3rps", "zhang2018-regular", "bricard", "3rrr"];

/// Returns a gallery model with some of its numbers replaced.
pub fn damaged(bytes: &[u8]) -> String {
    let mut choices = Choices(Unstructured::new(bytes));
    let c = &mut choices;
    let text = gallery::get(c.one(&SMALL)).expect("it is in the gallery");
    let places = numbers(text);
    let count = 1 + c.below(4);
    let mut edits: Vec<(usize, String)> =
        (0..count).map(|_| (c.below(places.len()), c.number(2))).collect();
    edits.sort_by_key(|(place, _)| *place);
    edits.dedup_by_key(|(place, _)| *place);
    let mut out = String::new();
    let mut done = 0;
    for (place, number) in edits {
        let (start, end) = places[place];
        out += &text[done..start];
        out += &number;
        done = end;
    }
    out + &text[done..]
}

/// Byte ranges of the numbers in a text, outside of names and comments.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let bytes = text.as_bytes();
    let mut places = Vec::new();
    let (mut at, mut in_comment) = (0, false);
    while at < bytes.len() {
        match bytes[at] {
            b'\n' => in_comment = false,
            b'#' => in_comment = true,
            b'0'..=b'9' if !in_comment => {
                let before = at.checked_sub(1).map_or(b' ', |before| bytes[before]);
                let is_free =
                    !(before.is_ascii_alphanumeric() || matches!(before, b'_' | b'.' | b'^'));
                let is_part = |b: &u8| b.is_ascii_digit() || *b == b'.';
                let end = at + bytes[at..].iter().take_while(|b| is_part(b)).count();
                if is_free {
                    places.push((at, end));
                }
                at = end;
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    places
}
