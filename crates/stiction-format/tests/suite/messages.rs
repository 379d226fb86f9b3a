//! Snapshots of error messages.

use stiction_format::{Diagnostics, Source, read};

fn messages(name: &str) -> Diagnostics {
    let path = format!("{}/tests/wrong/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let files = |_: &str| Err("no such file".to_owned());
    match read(&Source::new(name, text), &files) {
        Ok(model) => model.warnings,
        Err(diagnostics) => diagnostics,
    }
}

macro_rules! wrong_files {
    ($($name:ident)*) => {
        $(
            #[test]
            fn $name() {
                insta::assert_snapshot!(messages(concat!(stringify!($name), ".toml")).to_string());
            }
        )*
    };
}

wrong_files! {
    syntax keys units parameters misnamed bodies joints friction springs joint_springs mechanism disconnected suspicious legs chains lost_legs twice motions
}

mod given {
    use stiction_format::{Diagnostics, ModelFile, Source, read};

    fn robot() -> ModelFile {
        let text = include_str!("../wrong/robot.toml");
        read(&Source::new("robot.toml", text), &|_| Err(String::new())).unwrap()
    }

    /// Messages about several texts, one after the other.
    fn each<T>(texts: &[&str], parse: impl Fn(&Source) -> Result<T, Diagnostics>) -> String {
        let message = |text: &&str| match parse(&Source::new("--given", *text)) {
            Ok(_) => format!("fine: {text}\n"),
            Err(diagnostics) => diagnostics.to_string(),
        };
        texts.iter().map(message).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn motions() {
        let robot = robot();
        insta::assert_snapshot!(each(
            &[
                "smal",
                "A = 5 mm*sin(2*pi*t); B.angle = 30 deg",
                "A = 5 mm*sin(2*pi*t; B.angle = 30 degrees; duration = 2 m",
                "A 5 mm*t = 3; = 3; A =; B.slide = 1 mm; B.slide = 2 mm; platform.order = xyx; platform.rx = 1",
                "motion.csv",
                "A = 1 mm/(t - 0.5); B = 1",
                "B.slide = 1 mm; B = 2 mm; B.slide.x = 2",
                "A = \"1 mm*t",
                "A = wdth*t; C = 3; platform.X = 3; duration = \"2 s\"",
                "A = [1, 2]",
            ],
            |source| robot.parse_motion(source, &|_| Err("no such file".into())),
        ));
    }

    #[test]
    fn loads() {
        let robot = robot();
        insta::assert_snapshot!(each(
            &[
                "light",
                "none",
                "heavy",
                "platform.force = [20 N, 0, 0]; platform.mz = 3 N m; platform.axes = body",
                "platform.force = [20 N, 0]; platform.moment = 3; platfrm.fx = 1 N; platform.fq = 1",
                "A = 3; ground.fx = 1; platform = 3",
            ],
            |source| robot.parse_load(source, &|_| Err("no such file".into())),
        ));
    }

    #[test]
    fn recordings() {
        let robot = robot();
        let many: String = (0..40).map(|i| format!("{i},x{i}\n")).collect();
        let files = [
            "",
            "# only a comment\n",
            "time [s], A [mm]\n0, 1\n",
            "time;A\n0;1\n1;2\n",
            "t [ms], A [deg], d(A) [mm], dd(B.angle) [deg/s^2], B.angle [deg], platfrom.x, , A [m]\n0,1,2,3,4,5,6,7\n",
            "A [m], B.angle [Nm], platform.order\n0, 1, 2\n1, 2, 3\n",
            "time,A\n0,1\n0.5,2,3\n0.5,nan\n0.4,1e999\n,\n1,0x10\n",
            "time [s\n0\n1\n",
            &format!("time, A\n{many}"),
            "time, A\n0, 0\n1e-320, 1\n2e-320, 1e29\n",
            "time, A\n0, 0\n1, 1e300\n",
        ];
        insta::assert_snapshot!(each(&files, |source| robot
            .read_motion(&Source::new("motion.csv", source.text.as_str()), &|_| Err(
                String::new()
            ),)));
    }
}

/// Messages in machine-readable form.
#[test]
fn messages_as_json() {
    let json = messages("disconnected.toml").to_json();
    insta::assert_snapshot!(serde_json::to_string_pretty(&json).unwrap());
}

/// Coloured messages differ from plain ones only by escape sequences.
#[test]
fn coloured_messages_differ_only_in_colour() {
    let diagnostics = messages("keys.toml");
    let coloured = diagnostics.render(true);
    assert!(coloured.contains('\u{1b}'));
    let mut plain = String::new();
    let mut rest = coloured.as_str();
    while let Some(at) = rest.find('\u{1b}') {
        plain.push_str(&rest[..at]);
        rest = rest[at..].find('m').map_or("", |end| &rest[at + end + 1..]);
    }
    plain.push_str(rest);
    assert_eq!(plain, diagnostics.render(false));
}

/// Wrong units that are plausible as text: each is reported, without further messages.
#[test]
fn slips_of_units_are_named() {
    let five_bar = stiction_format::gallery::get("five-bar").unwrap();
    for (wrong, right, says) in [
        ("mu = 12", "mu = 0.08", "the friction coefficient 12 of joint `left_elbow`"),
        ("mass = \"800 kg\"", "mass = \"0.5 kg\"", "is its mass in g?"),
        (
            "[100, 100, 100]",
            "[\"1e-4 kg m^2\", \"1e-4 kg m^2\", \"1e-4 kg m^2\"]",
            "are the units of the inertia right?",
        ),
        ("[0, -9810, 0]", "[0, \"-9.81 m/s^2\", 0]", "gravity is 9810 m/s^2"),
        ("60 mm*sin(180*t)", "60 mm*sin(4*pi*t)", "180 rad/s"),
    ] {
        assert!(five_bar.contains(right), "{right}");
        let text = five_bar.replacen(right, wrong, 1);
        let model = read(&Source::new("five-bar.toml", text), &|_| Err(String::new()));
        let warnings = model.unwrap().warnings;
        assert_eq!(warnings.len(), 1, "{wrong}: {warnings}");
        assert!(warnings.to_string().contains(says), "{wrong}: {warnings}");
    }
}

fn said_of(model: &str, changes: &[&str]) -> String {
    let text = stiction_format::gallery::get(model).unwrap();
    let source = Source::new(format!("{model}.toml"), text).with_changes(changes);
    let read = read(&source, &|_| Err(String::new()));
    read.err().map_or(String::new(), |diagnostics| diagnostics.to_string())
}

#[test]
fn advice_on_a_unit_suits_the_quantity() {
    let said = said_of("five-bar", &["tool.mass = 3 kgm"]);
    assert!(said.contains("expected a mass") && !said.contains("kg m"), "{said}");
    let said = said_of("five-bar", &["tool.mass = 3 kilogram"]);
    assert!(said.contains("write `kg`"), "{said}");
    let said = said_of("five-bar", &["tool.mass = 50 %"]);
    assert!(said.contains("expected a mass") && said.contains("a number in percent"), "{said}");
}

/// A drive train whose losses follow from its efficiency.
const WINCH: &str = "\
gravity = [0, 0, 0]
[bodies.drum]
mass = 1
com = [0, 0, 0]
inertia = [1, 1, 1]
[joints.A]
type = \"R\"
from = \"ground\"
to = \"drum\"
axis = \"z\"
[actuators.M]
joint = \"A\"
ratio = 10
efficiency = 0.8
[loads.late]
[[loads.late.payload]]
body = \"drum\"
mass = 2
from = \"15 s\"
[[loads.late.payload]]
body = \"drum\"
mass = 3
until = \"1 s\"
";

fn winch() -> Source {
    Source::new("winch.toml", WINCH)
}

#[test]
fn values_that_follow_from_a_wrong_one_are_not_reported() {
    let files = |_: &str| Err(String::new());
    for (change, help) in [("M.efficiency = 0", ""), ("M.efficiency = 80", "write \"80 %\"")] {
        let said = read(&winch().with_changes([change]), &files).unwrap_err().to_string();
        assert!(said.contains("`efficiency` is") && said.contains(help), "{said}");
        assert!(!said.contains("backward"), "{said}");
    }
    let wrong = ["M.efficiency = 0.8", "M.backward_efficiency = 2"];
    let said = read(&winch().with_changes(wrong), &files).unwrap_err().to_string();
    assert!(said.contains("`backward_efficiency` is 2"), "{said}");
    let controller = Source::new("controller", "type = \"pid\"; ki = -5");
    let model = read(&winch(), &files).unwrap();
    let said = model.parse_control(&controller, &|_| Err(String::new())).unwrap_err().to_string();
    assert!(said.contains("`ki` is -5") && !said.contains("needs an integral gain"), "{said}");
}

#[test]
fn payloads_that_are_never_carried_are_named() {
    let model = read(&winch(), &|_| Err(String::new())).unwrap();
    let load = model.load("late").unwrap();
    let said = |ends: (f64, f64)| load.cautions(&model.mechanism, ends);
    let late = "the payload of 2 kg on `drum` is never carried: it is picked up at 15 s, but the \
                computation ends at 2 s; correct its `from` and `until`";
    assert_eq!(said((0.0, 2.0)), [late]);
    assert_eq!(said((0.0, 15.0)).len(), 1);
    assert_eq!(said((0.0, 15.5)).len(), 0);
    assert!(said((1.0, 20.0))[0].contains("placed at 1 s, but the computation begins at 1 s"));
    assert_eq!((said((0.5, 0.5)).len(), said((1.0, 1.0)).len()), (1, 2));
}
