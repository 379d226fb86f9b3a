//! Texts that are read but not run: model files, units, expressions, recordings, options.

use std::sync::{Arc, OnceLock};
use stiction_format::{
    Contents, Control, Diagnostics, ImportOptions, ModelFile, Motion, Signal, Source, Store,
    gallery, import, read,
};

/// Renders messages in all formats.
fn render(diagnostics: &Diagnostics) {
    let plain = diagnostics.render(false);
    assert!(diagnostics.is_empty() || !plain.trim().is_empty(), "a message without words");
    let _ = diagnostics.render(true);
    let _ = diagnostics.to_json().to_string();
}

/// Returns the value of a result, or renders the messages in all formats and returns `None`.
fn accepted<T>(result: Result<T, Diagnostics>) -> Option<T> {
    match result {
        Ok(value) => Some(value),
        Err(diagnostics) => {
            assert!(diagnostics.has_errors(), "refused without an error");
            render(&diagnostics);
            None
        }
    }
}

/// Returns the same table for every file that a text names.
pub(crate) fn files(_: &str) -> Result<Contents, String> {
    Ok("time [s], A, leg1.P\n0, 1, 0.6\n0.5, 1.1, 0.61\n1, 2, 0.62\n".into())
}

/// Returns the model that a text describes, if the text is valid; renders the warnings.
pub(crate) fn model_of(text: &str) -> Option<ModelFile> {
    let model = accepted(read(&Source::new("model.toml", text), &files))?;
    render(&model.warnings);
    Some(model)
}

/// Checks a robot file of another program, which is either converted or rejected with messages. All
/// files that it names have its own content.
pub fn robot_file(text: &str) {
    let load = |_: &str| Ok(text.as_bytes().to_vec());
    for literal in [false, true] {
        let source = Source::new("robot.xml", text);
        if let Some(imported) = accepted(import(&source, ImportOptions { literal }, &load)) {
            for note in &imported.notes {
                assert!(!note.line().trim().is_empty(), "a remark without words");
            }
            assert!(model_of(&imported.text).is_some(), "the model file of an import is refused");
        }
    }
}

/// Returns a robot to which motions, loads and efforts refer; it is read only once.
fn robot() -> &'static ModelFile {
    static ROBOT: OnceLock<ModelFile> = OnceLock::new();
    ROBOT.get_or_init(|| {
        let text = gallery::get("3rps").expect("it is in the gallery");
        model_of(text).expect("the gallery is right")
    })
}

/// Checks that a signal has a finite value or a diagnostic.
fn has_value(signal: &Signal, t: f64) {
    let target = signal.at(t);
    let finite =
        target.value.is_finite() && target.rate.is_finite() && target.acceleration.is_finite();
    match signal.fault_at(t) {
        Some(fault) => render(&fault.into()),
        None => assert!(finite, "no fault at t = {t}, but {target:?}"),
    }
}

fn has_values(motion: &Motion) {
    assert!(motion.start.is_finite(), "start {}", motion.start);
    assert!(motion.duration.is_finite() && motion.duration >= 0.0, "{}", motion.duration);
    for part in [0.0, 0.3, 1.0] {
        let t = motion.start + part * motion.duration;
        for (_, signal) in &motion.coordinates {
            has_value(signal, t);
        }
    }
}

/// Checks a text as a model file.
pub fn model(text: &str) {
    let Some(model) = model_of(text) else { return };
    for (_, motion) in &model.motions {
        has_values(motion);
    }
    for (_, load) in &model.loads {
        for wrench in &load.wrenches {
            wrench.force.iter().chain(&wrench.moment).for_each(|signal| has_value(signal, 0.25));
        }
    }
}

/// Checks a unit after a number, at places where different dimensions are expected.
pub fn unit(text: &str) {
    let quoted = text.replace(['\\', '"', '\n', '\r'], " ");
    model(&format!(
        "gravity = [\"1 {quoted}\", 0, 0]\ncharacteristic_length = \"1 {quoted}\"\n[parameters]\np = \"1 {quoted}\"\n\
         [bodies.a]\nmass = \"1 {quoted}\"\ncom = [\"1 {quoted}\", 0, 0]\ninertia = [\"1 {quoted}\", 1, 1]\n\
         [joints.A]\ntype = \"H\"\nfrom = \"ground\"\nto = \"a\"\naxis = \"z\"\npitch = \"1 {quoted}\"\n\
         start = \"1 {quoted}\"\nfriction = {{ mu = \"1 {quoted}\", viscous = \"1 {quoted}\", radius = \"1 {quoted}\", \
         preload = \"1 {quoted}\", stribeck_velocity = \"1 {quoted}\", mu_static = 2 }}\n\
         [springs.s]\nfrom = \"ground\"\nto = \"a\"\nstiffness = \"1 {quoted}\"\nfree_length = 1\ndamping = \"1 {quoted}\"\n"
    ));
    options(&format!("platform.z = 1 {text}; platform.rx = 2 {text}; duration = 1 {text}"));
}

/// Checks an expression in a motion, in a load, and in a model file.
pub fn expression(text: &str) {
    let robot = robot();
    let motion = format!("platform.z = {text}; platform.rx = {text}; duration = 1");
    if let Some(motion) = accepted(robot.parse_motion(&Source::new("--motion", motion), &files)) {
        has_values(&motion);
    }
    let load = format!("platform.fz = {text}");
    if let Some(load) = accepted(robot.parse_load(&Source::new("--load", load), &files)) {
        for wrench in &load.wrenches {
            wrench.force.iter().for_each(|signal| has_value(signal, 0.25));
        }
    }
    let quoted = text.replace(['\\', '"', '\n', '\r'], " ");
    let one = "[bodies.a]\n[joints.A]\ntype = \"R\"\nfrom = \"ground\"\nto = \"a\"\naxis = \"z\"\n";
    model(&format!(
        "gravity = [\"{quoted}\", 0, 0]\n[parameters]\np = \"{quoted}\"\nq = \"p + {quoted}\"\n{one}\
         [motions.m]\nA = \"{quoted}\"\n[loads.l]\na.fx = \"{quoted}\"\n"
    ));
}

/// Text that is read a few bytes at a time, like a long file.
#[derive(Debug)]
struct Stored(String);

impl Store for Stored {
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<usize, String> {
        let rest = self.0.as_bytes().get(offset as usize..).unwrap_or_default();
        let count = rest.len().min(buffer.len()).min(37);
        buffer[..count].copy_from_slice(&rest[..count]);
        Ok(count)
    }
}

/// Checks that a text read as a whole and in pieces gives equal results or equal messages.
fn in_pieces<T>(
    text: &str,
    parse: impl Fn(&dyn Fn(&str) -> Result<Contents, String>) -> Result<T, Diagnostics>,
) -> Option<[T; 2]> {
    let stored = || Contents::Stored(Arc::new(Stored(text.to_owned())));
    match (parse(&|_| Ok(text.into())), parse(&|_| Ok(stored()))) {
        (Ok(whole), Ok(stored)) => Some([whole, stored]),
        (Err(whole), Err(stored)) => {
            // If a file is read as a whole, content that is not text is reported at once.
            assert!(
                text.contains('\0') || whole.to_string() == stored.to_string(),
                "{whole}{stored}"
            );
            None
        }
        (whole, stored) => panic!(
            "accepted as a whole: {}, in pieces: {}; {:?} {:?}",
            whole.is_ok(),
            stored.is_ok(),
            whole.err(),
            stored.err()
        ),
    }
}

/// Checks that signals read as a whole and in pieces have identical values.
fn same_values<'a>(mut pairs: impl Iterator<Item = (&'a Signal, &'a Signal)>, t: f64) {
    let bits = |signal: &Signal| {
        let target = signal.at(t);
        [target.value, target.rate, target.acceleration].map(f64::to_bits)
    };
    assert!(pairs.all(|(whole, stored)| bits(whole) == bits(stored)), "other values at {t}");
}

/// Checks CSV samples of a motion and of efforts, read as a whole and in pieces.
pub fn recording(text: &str) {
    let robot = robot();
    if let Some(motion) = accepted(robot.read_motion(&Source::new("motion.csv", text), &files)) {
        has_values(&motion);
        if let Some(samples) = &motion.samples {
            assert!(samples.iter().all(|t| t.is_finite()), "a time that is not finite");
            let later = samples.iter().skip(1);
            assert!(samples.iter().zip(later).all(|(a, b)| a < b), "times that do not increase");
        }
    }
    let motions = in_pieces(text, |own| robot.parse_motion(&Source::new("--motion", "m.csv"), own));
    if let Some([whole, stored]) = motions {
        has_values(&stored);
        assert_eq!(whole.samples, stored.samples);
        for part in [-0.1, 0.0, 0.3, 0.77, 1.0, 1.2] {
            let t = whole.start + part * whole.duration;
            let pairs = whole.coordinates.iter().zip(&stored.coordinates);
            same_values(pairs.map(|((_, whole), (_, stored))| (whole, stored)), t);
        }
    }
    let drives = in_pieces(text, |own| robot.parse_drives(&Source::new("--drives", "d.csv"), own));
    if let Some([whole, stored]) = drives {
        stored.efforts.iter().for_each(|(_, signal)| has_value(signal, 0.3));
        let pairs = whole.efforts.iter().zip(&stored.efforts);
        same_values(pairs.map(|((_, whole), (_, stored))| (whole, stored)), 0.3);
    }
}

/// Checks values of `--motion`, `--from` and `--load`, and the same texts as TOML files.
pub fn options(text: &str) {
    let robot = robot();
    let own = |_: &str| Ok(text.into());
    for source in [Source::new("--motion", text), Source::new("--motion", "m.toml")] {
        let files: &dyn Fn(&str) -> _ = if source.text == text { &files } else { &own };
        if let Some(motion) = accepted(robot.parse_motion(&source, files)) {
            has_values(&motion);
        }
    }
    for source in [Source::new("--load", text), Source::new("--load", "l.toml")] {
        if let Some(load) = accepted(robot.parse_load(&source, &own)) {
            for wrench in &load.wrenches {
                assert!(wrench.point.to_array().iter().all(|x| x.is_finite()));
                wrench.force.iter().chain(&wrench.moment).for_each(|c| has_value(c, 0.25));
            }
        }
    }
}

/// Checks values of `--drives` and `--controller`, and the same texts as TOML files.
pub fn drives(text: &str) {
    let robot = robot();
    let own = |_: &str| Ok(text.into());
    for source in [Source::new("--drives", text), Source::new("--drives", "d.toml")] {
        if let Some(drives) = accepted(robot.parse_drives(&source, &own)) {
            drives.efforts.iter().for_each(|(_, signal)| has_value(signal, 0.25));
        }
    }
    for source in [Source::new("--controller", text), Source::new("--controller", "c.toml")] {
        if let Some(control) = accepted(robot.parse_control(&source, &own)) {
            let bandwidth = control.bandwidth.unwrap_or(Control::USUAL_BANDWIDTH);
            let numbers = [control.period, bandwidth, control.damping];
            assert!(numbers.iter().all(|x| x.is_finite()), "{control:?}");
            assert!(control.period > 0.0, "{control:?}");
        }
    }
}
