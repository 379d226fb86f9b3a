//! Values of motions and loads.

use stiction_core::dynamics::LoadAxes;
use stiction_core::kinematics::{AngleOrder, Coordinate, Target};
use stiction_core::mechanism::{BodyId, JointId};
use stiction_core::spatial::Vec3;
use stiction_format::{Contents, ModelFile, Motion, Source, read};

const ROBOT: &str = r#"
gravity = [0, 0, 0]
[parameters]
stroke = "20 mm"
[bodies.platform]
[bodies."leg1.rod"]
[joints."leg1.P"]
type = "P"
from = "ground"
to = "leg1.rod"
axis = "z"
[joints."leg1.C"]
type = "C"
from = "leg1.rod"
to = "platform"
axis = "z"
"#;

const PLATFORM: BodyId = BodyId(1);

fn model(text: &str) -> ModelFile {
    model_with(text, &[])
}

fn model_with(text: &str, files: &[(&str, &str)]) -> ModelFile {
    let fetch = |name: &str| {
        let file = files.iter().find(|(known, _)| *known == name);
        file.map(|(_, text)| Contents::from(*text)).ok_or_else(|| "no such file".to_owned())
    };
    read(&Source::new("robot.toml", format!("{ROBOT}{text}")), &fetch)
        .unwrap_or_else(|diagnostics| panic!("{diagnostics}"))
}

fn no_files(_: &str) -> Result<Contents, String> {
    Err("no files".to_owned())
}

fn coordinates(motion: &Motion) -> Vec<Coordinate> {
    motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect()
}

#[test]
fn expressions_in_the_file() {
    let model = model(
        r#"
[motions.all]
title = "everything"
start = "100 ms"
duration = "2 s"
step = "5 ms"
platform.x = "stroke*sin(2*pi*t)"
platform.ry = "10 deg/s*t"
platform.rvz = 0.1
leg1.P = "1 cm + 1 cm/s*t"
leg1.C.angle = "10 deg"
leg1.C.slide = "t^2*1 m"
[motions.short]
[default]
motion = "all"
"#,
    );
    let motion = model.motion("all").unwrap();
    assert_eq!((motion.start, motion.duration, motion.step), (0.1, 2.0, Some(0.005)));
    assert_eq!(motion.title, "everything");
    assert_eq!(
        coordinates(motion),
        [
            Coordinate::Position { body: PLATFORM, axis: 0 },
            Coordinate::Angle { body: PLATFORM, order: AngleOrder::XYZ, index: 1 },
            Coordinate::RotationVector { body: PLATFORM, axis: 2 },
            Coordinate::Joint { joint: JointId(0), dof: 0 },
            Coordinate::Joint { joint: JointId(1), dof: 0 },
            Coordinate::Joint { joint: JointId(1), dof: 1 },
        ]
    );
    let targets: Vec<_> = motion.at(0.5).collect();
    let omega = std::f64::consts::TAU;
    let expected = Target {
        value: 0.02 * (omega * 0.5).sin(),
        rate: 0.02 * omega * (omega * 0.5).cos(),
        acceleration: -0.02 * omega * omega * (omega * 0.5).sin(),
    };
    assert!((targets[0].value - expected.value).abs() < 1e-17);
    assert!((targets[0].rate - expected.rate).abs() < 1e-16);
    assert!((targets[0].acceleration - expected.acceleration).abs() < 1e-15);
    assert_eq!(targets[5], Target { value: 0.25, rate: 1.0, acceleration: 2.0 });
    let short = model.motion("short").unwrap();
    assert_eq!((short.start, short.duration, short.step), (0.0, 1.0, None));
    assert_eq!(model.default_motion.as_deref(), Some("all"));
    assert_eq!(model.default_load, None);
}

/// Angles are addressed by their axis if it is unique, and always by their number.
#[test]
fn orders_of_angles() {
    let model = model(
        r#"
[motions.zyx]
platform = { order = "zyx", rx = "1", r1 = "2" }
[motions.zxz]
platform.r1 = 1
platform.r3 = 3
platform.order = "zxz"
"#,
    );
    let angle = |name: &str, index| {
        let order = AngleOrder::from_name(name).unwrap();
        Coordinate::Angle { body: PLATFORM, order, index }
    };
    let zyx = model.motion("zyx").unwrap();
    assert_eq!(coordinates(zyx), [angle("zyx", 2), angle("zyx", 0)]);
    assert_eq!(coordinates(model.motion("zxz").unwrap()), [angle("zxz", 0), angle("zxz", 2)]);
}

const RECORDING: &str = "\u{feff}# recorded on a Tuesday\r\n\r\ntime [ms], \"platform.x [mm]\", leg1.P [m], d(leg1.P) [mm/s], platform.r1 [deg]\r\n\
    0, 0, 1, 0, 0\r\n100, 10, 1.1, 2000, 10\r\n# a pause\r\n200, 40, 1.4, 4e3, 20\r\n300, 90, 1.9, 6000, 30\r\n";

/// The samples lie on parabolas, which all splines reproduce.
#[test]
fn recordings_are_interpolated() {
    let model = model_with(
        "[motions.recorded]\nfile = \"data/motion.csv\"\nplatform.order = \"zyx\"\nstep = \"1 ms\"",
        &[("data/motion.csv", RECORDING)],
    );
    let motion = model.motion("recorded").unwrap();
    assert_eq!((motion.start, motion.duration, motion.step), (0.0, 0.3, Some(0.001)));
    let samples: Vec<f64> = motion.samples.iter().flat_map(|samples| samples.iter()).collect();
    assert_eq!(samples, [0.0, 0.1, 0.2, 0.3]);
    let order = AngleOrder::from_name("zyx").unwrap();
    assert_eq!(coordinates(motion)[2], Coordinate::Angle { body: PLATFORM, order, index: 0 });
    insta::assert_snapshot!(motion.interpolation.as_ref().unwrap());
    for k in 0..=30 {
        let t = f64::from(k) * 0.01;
        let targets: Vec<_> = motion.at(t).collect();
        // Rounding of numbers of order one; the acceleration over steps of 0.1 s.
        assert!((targets[0].value - t * t).abs() < 1e-15);
        assert!((targets[1].value - (1.0 + 10.0 * t * t)).abs() < 1e-14);
        assert!((targets[1].rate - 20.0 * t).abs() < 1e-12);
        assert!((targets[1].acceleration - 20.0).abs() < 1e-10);
        assert!((targets[2].value - (t * 100.0).to_radians()).abs() < 1e-15);
    }
    assert_eq!(motion.at(0.2).next().unwrap().value, 0.04);
    // A file with the same content gives the same motion.
    let source = Source::new("motion.csv", RECORDING);
    let again = model.read_motion(&source, &no_files).unwrap();
    assert_eq!(again.samples, motion.samples);
}

#[test]
fn motions_from_a_line() {
    let model = model("[motions.still]\nplatform.x = 0\n");
    let parse = |text: &str| {
        let files = |name: &str| match name {
            "a.csv" => Ok(RECORDING.into()),
            "a.toml" => Ok("leg1.P = \"stroke\"\nduration = \"3 s\"".into()),
            _ => Err("no such file".to_owned()),
        };
        model.parse_motion(&Source::new("--motion", text), &files)
    };
    let motion =
        parse("platform.x = stroke*t; leg1.C.angle = '20 deg'; duration = 2 s; title = a b")
            .unwrap();
    assert_eq!(motion.duration, 2.0);
    assert_eq!(motion.title, "a b");
    assert_eq!(motion.at(2.0).map(|x| x.value).collect::<Vec<_>>(), [0.04, 20f64.to_radians()]);
    assert_eq!(parse(" still ").unwrap().coordinates.len(), 1);
    assert_eq!(parse("a.csv").unwrap().coordinates.len(), 3);
    assert_eq!(parse("a.toml").unwrap().duration, 3.0);
    assert!(parse("b.csv").is_err());
    assert!(parse("").is_err());
}

#[test]
fn loads() {
    let model = model(
        r#"
[loads.none]
title = "nothing"
[loads.some]
platform = { force = ["20 N", 0, "-1 kN*sin(pi*t)"], at = ["10 mm", 0, 0], axes = "body" }
leg1.rod.mz = "3 N m"
"#,
    );
    assert!(model.load("none").unwrap().wrenches.is_empty());
    let some = model.load("some").unwrap();
    let [platform, rod] = some.at(0.5).collect::<Vec<_>>().try_into().unwrap();
    assert_eq!((platform.body, platform.axes), (PLATFORM, LoadAxes::Body));
    assert_eq!(platform.force, Vec3::new(20.0, 0.0, -1000.0));
    assert_eq!(platform.point, Vec3::new(0.01, 0.0, 0.0));
    assert_eq!((rod.body, rod.axes), (BodyId(2), LoadAxes::World));
    assert_eq!(rod.moment, Vec3::new(0.0, 0.0, 3.0));

    let parse = |text: &str| model.parse_load(&Source::new("--load", text), &no_files);
    let given = parse("leg1.rod.force = [20 N, 0, 0]; platform.fz = -100 N*t").unwrap();
    assert_eq!(given.wrenches.len(), 2);
    assert_eq!(given.at(2.0).nth(1).unwrap().force.z, -200.0);
    assert_eq!(parse("none").unwrap().title, "nothing");
    assert!(parse("more").is_err());
    let file = Source::new("load.toml", "title = \"t\"\nplatform.force = [1, 2, 3]");
    assert_eq!(model.read_load(&file).unwrap().wrenches.len(), 1);
}

/// A formula that fails reports its place, including at instants that were not checked in advance.
#[test]
fn formulas_that_fail_later_explain_themselves() {
    let model = model("[motions.m]\nduration = 1\nplatform.x = \"1 m/(t - 3)\"\n");
    let (_, signal) = &model.motion("m").unwrap().coordinates[0];
    assert!(signal.fault_at(1.0).is_none());
    let fault = signal.fault_at(3.0).unwrap();
    assert_eq!(fault.place.unwrap().line_column(), (19, 18));
    assert_eq!(fault.label, "division by zero");
}

/// A motion of zero duration is a single pose, in a file and on a command line.
#[test]
fn zero_duration_is_a_pose() {
    let model =
        model("[motions.pose]\nstart = \"0.5 s\"\nduration = 0\nplatform.x = \"1 m/s*t\"\n");
    let pose = model.motion("pose").unwrap();
    assert_eq!((pose.start, pose.duration), (0.5, 0.0));
    let given = Source::new("--motion", "duration = 0; platform.x = 1 mm");
    let pose = model.parse_motion(&given, &|_| Err(String::new())).unwrap();
    assert_eq!((pose.start, pose.duration, pose.coordinates.len()), (0.0, 0.0, 1));
}

fn cautions_of(formula: &str) -> Vec<String> {
    let text = format!(
        "\n[motions.m]\nduration = \"2 s\"\nleg1.P = {formula:?}\nplatform.ry = \"10 deg/s*t\"\n"
    );
    model(&text).motion("m").unwrap().cautions().collect()
}

/// Tests the time and the rates at kinks of several kinds, at samples and between them.
#[test]
fn jumps_of_rates_are_cautions() {
    for (formula, expected) in [
        ("20 mm*abs(t - 0.5)", "jumps from -0.02 to 0.02 m/s at t = 0.5 s: this needs an infinite"),
        ("min(30 mm/s*t, 10 mm)", "jumps from 0.03 to 0 m/s at t = 0.333333 s: "),
        ("stroke*abs(cos(pi*t))", "m/s at t = 0.5 s, and at one more instant: "),
        ("sqrt((t - 1.2345)^2)*10 mm", "jumps from -0.01 to 0.01 m/s at t = 1.2345 s: "),
        // A pulse of 2 ms between two samples.
        ("max(0 mm, 1 mm - abs(t - 0.7035)*1 m)", "at t = 0.7035 s"),
    ] {
        let cautions = cautions_of(formula);
        assert_eq!(cautions.len(), 1, "{formula}: {cautions:?}");
        assert!(cautions[0].starts_with("the rate of `leg1.P` jumps from "), "{}", cautions[0]);
        assert!(cautions[0].contains(expected), "{formula}: {}", cautions[0]);
    }
}

#[test]
fn continuous_rates_are_no_jumps() {
    for formula in [
        "20 mm*abs(t - 0.5)^3",
        "20 mm*max(0, t - 0.5)^2",
        "stroke*tanh((t - 0.5)*1e5)*abs(1)",
        "stroke*abs(sin(200*t)^2)",
        "stroke*sqrt(1 + t^2)",
        "stroke*abs(t + 1)",
        "min(30 mm*t^3, 1 m)",
    ] {
        assert_eq!(cautions_of(formula), [""; 0], "{formula}");
    }
}
