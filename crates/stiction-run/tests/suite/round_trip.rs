//! Models that are written in other formats and read again are equivalent to the original.

use crate::common::{default_job, model, model_of};
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodyId, JointId, Mechanism};
use stiction_core::spatial::{Pose, Vec3};
use stiction_format::{ImportOptions, ModelFile, Source, gallery, import};
use stiction_run::exchange::{Home, mjcf, sdf, urdf};

#[derive(Clone, Copy, Debug)]
enum Format {
    Mjcf,
    Sdf,
    Urdf,
}

/// Converts a model to a format and back to a model.
fn round_trip(original: &ModelFile, format: Format) -> ModelFile {
    model_of(&original.name, &imported(original, format))
}

/// Converts a model to a format and back, and returns the text of the resulting model.
fn imported(original: &ModelFile, format: Format) -> String {
    imported_with(original, format, ImportOptions::default())
}

/// Converts a model to a format and, with these options, back; returns the text of the resulting model.
fn imported_with(original: &ModelFile, format: Format, options: ImportOptions) -> String {
    let job = default_job(original, FrictionMode::Off);
    let home = Home::of(&job).unwrap();
    let (text, yaml) = match format {
        Format::Mjcf => (mjcf(&home).unwrap().text, None),
        Format::Sdf => (sdf(&home).unwrap().text, None),
        Format::Urdf => {
            let written = urdf(&home).unwrap();
            (written.text, written.yaml)
        }
    };
    let name = &original.name;
    let files = |file: &str| {
        let beside = yaml.clone().filter(|_| file == format!("{name}.yaml"));
        beside.map(String::into_bytes).ok_or("there is no such file".to_owned())
    };
    let source = Source::new(format!("{name}.xml"), text.clone());
    let imported = import(&source, options, &files)
        .unwrap_or_else(|errors| panic!("{name} {format:?}: {errors}\n{text}"));
    imported.text
}

fn body(mechanism: &Mechanism, name: &str) -> BodyId {
    let found = mechanism.bodies().iter().position(|body| body.name == name);
    BodyId(found.unwrap_or_else(|| panic!("no body {name}")))
}

fn joint(mechanism: &Mechanism, name: &str) -> JointId {
    let found = mechanism.joints().iter().position(|joint| joint.name == name);
    JointId(found.unwrap_or_else(|| panic!("no joint {name}")))
}

/// Returns the coordinate of `to` that corresponds by name to a coordinate of `from`.
fn same(coordinate: Coordinate, from: &Mechanism, to: &Mechanism) -> Coordinate {
    let there = |id: BodyId| body(to, &from.bodies()[id.0].name);
    match coordinate {
        Coordinate::Position { body, axis } => Coordinate::Position { body: there(body), axis },
        Coordinate::RotationVector { body, axis } => {
            Coordinate::RotationVector { body: there(body), axis }
        }
        Coordinate::Angle { body, order, index } => {
            Coordinate::Angle { body: there(body), order, index }
        }
        Coordinate::Joint { joint: id, dof } => {
            Coordinate::Joint { joint: joint(to, &from.joints()[id.0].name), dof }
        }
    }
}

/// Reaction of a joint.
struct Reaction {
    name: String,
    /// True for each component that is statically determinate: force and moment about the joint's
    /// origin, world axes.
    determined: [bool; 6],
    origin: Vec3<f64>,
    force: Vec3<f64>,
    /// Moment about the origin of the world, N m.
    moment: Vec3<f64>,
}

struct Results {
    /// Name of each actuator with its efforts without and with friction.
    efforts: Vec<(String, f64, f64)>,
    reactions: Vec<Reaction>,
    /// True if statics determines all reactions, and therefore the friction.
    is_determined: bool,
}

/// Computes the forces at an instant of the default motion of `original`; `None` if the robot
/// cannot carry its load.
fn forces(original: &ModelFile, model: &ModelFile, t: f64) -> Option<Results> {
    let job = default_job(original, FrictionMode::Off);
    let mechanism = &model.mechanism;
    let coordinates: Vec<Coordinate> = job
        .motion
        .coordinates
        .iter()
        .map(|(coordinate, _)| same(*coordinate, &original.mechanism, mechanism))
        .collect();
    let targets: Vec<Target<f64>> = job.motion.at(t).collect();
    let solve = |friction| {
        let settings = Settings { friction, ..Settings::default() };
        let (mechanism, homes) = (mechanism.clone(), &model.initial_poses);
        InverseDynamics::new(mechanism, homes, &coordinates, &targets, settings)
            .unwrap_or_else(|error| panic!("{}: {error}", original.name))
    };
    let loads: Vec<_> = job
        .load
        .at(t)
        .map(|mut load| {
            load.body = body(mechanism, &original.mechanism.bodies()[load.body.0].name);
            load
        })
        .collect();
    let mut with = solve(FrictionMode::Converged);
    let frictional = with.solve(&loads).map(|forces| forces.efforts.clone());
    let mut without = solve(FrictionMode::Off);
    let forces = without.solve(&loads).ok()?.clone();
    let frictional = frictional.unwrap_or_else(|_| vec![f64::NAN; forces.efforts.len()]);
    let efforts = mechanism.actuators().zip(forces.efforts.iter().zip(frictional));
    let name = |joint: JointId| mechanism.joints()[joint.0].name.clone();
    let efforts = efforts.map(|((joint, _), (a, b))| (name(joint), *a, b)).collect();
    let flags = without.statics().determined_reactions();
    let reactions = (0..mechanism.joints().len()).map(|index| {
        let (force, moment) = forces.reactions[index];
        let origin = without.bodies().frame_j[index].position;
        let moment = moment + origin.cross(force);
        Reaction { name: name(JointId(index)), determined: flags[index], origin, force, moment }
    });
    let is_determined = flags.iter().flatten().all(|flag| *flag);
    Some(Results { efforts, reactions: reactions.collect(), is_determined })
}

#[test]
fn the_gallery_returns_from_each_format() {
    let (mut compared, mut frictions) = (0, 0);
    for name in gallery::names() {
        let original = model(name);
        // The conversion makes the ground's frame the world frame, so a model with another base has
        // other body coordinates.
        if original.mechanism.base() != Pose::identity() {
            continue;
        }
        for format in [Format::Mjcf, Format::Sdf, Format::Urdf] {
            let again = round_trip(&original, format);
            assert_eq!(again.default_friction, original.default_friction, "{name} {format:?}");
            let legs = [("gough", 6), ("3rps", 3), ("delta", 3), ("3rrr", 3)];
            if let Some((_, count)) = legs.iter().find(|(known, _)| *known == name) {
                assert_eq!(again.legs.len(), *count, "{name} {format:?}");
            }
            for t in [0.0, 0.3] {
                let Some(expected) = forces(&original, &original, t) else { continue };
                let found = forces(&original, &again, t);
                let found = found.unwrap_or_else(|| panic!("{name} {format:?}: no forces"));
                let what = |name: &str| format!("{} {format:?} {name} at {t} s", original.name);
                let size = expected.efforts.iter().map(|(_, e, _)| e.abs()).fold(1.0, f64::max);
                assert_eq!(found.efforts.len(), expected.efforts.len(), "{}", what("motors"));
                for (name, effort, frictional) in &expected.efforts {
                    let own = found.efforts.iter().find(|(other, ..)| other == name);
                    let (_, a, b) = own.unwrap_or_else(|| panic!("no motor {name}"));
                    assert!((a - effort).abs() < 1e-10 * size, "{}: {a} {effort}", what(name));
                    // Redundant reactions are distributed differently if the format needs
                    // additional joints.
                    if expected.is_determined && found.is_determined {
                        // Coupled friction amplifies rounding.
                        let good = (b - frictional).abs() < 1e-8 * size;
                        let both = b.is_nan() && frictional.is_nan();
                        assert!(good || both, "{}: {b} {frictional}", what(name));
                        frictions += 1;
                    }
                }
                for own in &expected.reactions {
                    // A format may divide a joint into several.
                    let again = found.reactions.iter().find(|other| other.name == own.name);
                    let Some(again) = again else { continue };
                    // Both reactions refer to the same point, so that a moment is compared where it
                    // is determined.
                    let six = |joint: &Reaction| {
                        let moment = joint.moment + -own.origin.cross(joint.force);
                        [joint.force.to_array(), moment.to_array()].concat()
                    };
                    let (a, b) = (six(again), six(own));
                    let size = b.iter().map(|part| part.abs()).fold(size, f64::max);
                    for k in (0..6).filter(|k| own.determined[*k]) {
                        let good = (a[k] - b[k]).abs() < 1e-10 * size;
                        assert!(good, "{} {k}: {} {}", what(&own.name), a[k], b[k]);
                        compared += 1;
                    }
                }
            }
        }
    }
    // Some thousand components are compared in all formats together.
    assert!(compared > 3000 && frictions > 50, "{compared} {frictions}");
}

/// Legs with motors, springs and ranges.
const DRIVEN_LEGS: &str = r#"
name = "driven"
gravity = [0, 0, "-9.81 m/s^2"]
[bodies.platform]
mass = "5 kg"
com = [0, 0, "10 mm"]
inertia = ["0.02 kg m^2", "0.02 kg m^2", "0.03 kg m^2"]
home = { position = [0, 0, "550 mm"] }
[legs]
chain = "R cylinder P rod S"
to = "platform"
angles = ["0 deg", "120 deg", "240 deg"]
foot = ["450 mm", 0, 0]
tip = ["150 mm", 0, 0]
[legs.joints.R]
axis = "y"
start = "-28 deg"
[legs.joints.P]
axis = "z"
start = "626 mm"
range = ["500 mm", "800 mm"]
[legs.actuators.P]
lead = "10 mm/rev"
rotor_inertia = "1e-5 kg m^2"
efficiency = 0.9
[legs.springs.R]
joint = "R"
stiffness = "3 N m/rad"
rest = "-0.2 rad"
[legs.springs.gas]
from = "cylinder"
at = [0, 0, "20 mm"]
to = "rod"
to_at = [0, 0, "-10 mm"]
stiffness = "100 N/m"
free_length = "300 mm"
[legs.bodies.cylinder]
mass = "5 kg"
com = [0, 0, "170 mm"]
inertia = ["0.05 kg m^2", "0.05 kg m^2", "0.002 kg m^2"]
[legs.bodies.rod]
mass = "2 kg"
com = [0, 0, "-128 mm"]
inertia = ["0.02 kg m^2", "0.02 kg m^2", "0.0005 kg m^2"]
[motions.lift]
platform.z = "550 mm + 20 mm*sin(2*pi*t)"
platform.rx = "3 deg*sin(2*pi*t)"
platform.ry = 0
[loads.none]
[default]
motion = "lift"
load = "none"
"#;

#[test]
fn motors_and_springs_of_legs_return_with_them() {
    let original = model_of("driven", DRIVEN_LEGS);
    for format in [Format::Mjcf, Format::Sdf, Format::Urdf] {
        let text = imported(&original, format);
        let again = model_of("driven", &text);
        assert_eq!(again.legs, original.legs, "{format:?}");
        for table in ["[actuators", "[springs", "[bodies.\"", "[joints"] {
            assert!(!text.contains(table), "{format:?} {table}\n{text}");
        }
        let [a, b] = [&original, &again].map(|model| forces(&original, model, 0.3).unwrap());
        for ((name, a, _), (other, b, _)) in a.efforts.iter().zip(&b.efforts) {
            assert_eq!(name, other);
            assert!((a - b).abs() < 1e-10 * a.abs().max(1.0), "{format:?} {name}: {a} {b}");
        }
    }
}

/// Gearings, motors of several joints, springs, bushings and ranges.
const GEARED: &str = r#"
name = "geared"
gravity = [0, 0, -9.81]
[bodies.a]
mass = 1
com = [0.1, 0, 0]
inertia = [0.01, 0.01, 0.01]
[bodies.b]
mass = 1
com = [0.1, 0.02, 0]
inertia = [0.01, 0.01, 0.01]
[bodies.c]
mass = 1
com = [0.1, 0, 0.03]
inertia = [0.01, 0.01, 0.01]
[bodies.d]
mass = 1
com = [0.1, 0, 0]
inertia = [0.01, 0.01, 0.01]
[joints.A]
type = "R"
from = "ground"
to = "a"
axis = "y"
range = [-1, 2]
friction = { mu = 0.1, radius = "10 mm" }
[joints.B]
type = "P"
from = "a"
to = "b"
axis = "x"
[joints.C]
type = "R"
from = "ground"
to = "c"
axis = "z"
[joints.D]
type = "R"
from = "c"
to = "d"
axis = "x"
range = [-0.5, 0.75]
[gearings.G]
joints = { A = "20 mm/rad", B = -1 }
offset = "5 mm"
[gearings.H]
joints = { A = 1, C = 2, D = -3 }
offset = "0.1 rad"
[actuators.M]
joints = { A = 1, C = 1 }
ratio = 5
rotor_inertia = "1e-3 kg m^2"
motor_friction = { constant = "0.01 N m", viscous = "1e-4 N m s/rad" }
efficiency = 0.9
limits = { peak = "2 N m", speed = "300 rad/s" }
[actuators.N]
joints = { A = 1, C = -1 }
ratio = 5
[springs.S]
joint = "D"
stiffness = "2 N m/rad"
rest = "0.2 rad"
preload = "0.1 N m"
damping = "0.01 N m s/rad"
[bushings.Q]
from = "ground"
to = "d"
stiffness = [1, 2, 3, 4, 5, 6]
[motions.m]
duration = "1 s"
A = "0.3*sin(t/(1 s)) + 0.2"
C = "0.3*sin(t/(1 s)) + 0.1"
[loads.none]
[default]
motion = "m"
load = "none"
"#;

#[test]
fn gearings_and_motors_return_from_each_format() {
    let original = model_of("geared", GEARED);
    let expected = forces(&original, &original, 0.3).unwrap();
    let own = |model: &ModelFile| {
        let mechanism = &model.mechanism;
        let trains = mechanism.drive_trains().iter().map(|train| {
            let kept = (train.rotor_inertia, train.motor_friction, train.gear, train.limits);
            (train.name.clone(), train.transmission(), kept)
        });
        let gearings = mechanism.gearings().iter().map(|own| (own.name.clone(), own.offset));
        let ranges = mechanism.joints().iter().map(|own| (own.name.clone(), own.ranges.clone()));
        let springs = mechanism
            .joint_springs()
            .iter()
            .map(|own| (own.name.clone(), own.stiffness, own.rest, own.preload, own.damping));
        let mut ranges: Vec<_> = ranges.collect();
        ranges.sort_by(|a, b| a.0.cmp(&b.0));
        let stiffness: Vec<_> = mechanism.bushings().iter().map(|own| own.stiffness).collect();
        (
            trains.collect::<Vec<_>>(),
            gearings.collect::<Vec<_>>(),
            ranges,
            springs.collect::<Vec<_>>(),
            stiffness,
        )
    };
    for format in [Format::Mjcf, Format::Sdf, Format::Urdf] {
        let again = round_trip(&original, format);
        assert_eq!(own(&again), own(&original), "{format:?}");
        let found = forces(&original, &again, 0.3).unwrap();
        for (name, effort, frictional) in &expected.efforts {
            let (_, a, b) = found.efforts.iter().find(|(other, ..)| other == name).unwrap();
            // The efforts are some N m and contain the rounding errors of rotated frames.
            assert!((a - effort).abs() < 1e-12, "{format:?} {name}: {a} {effort}");
            assert!((b - frictional).abs() < 1e-12, "{format:?} {name}: {b} {frictional}");
        }
    }
}

/// Ball joints with ranges of their tilt, at home tilted and turned: one in the tree, one in the tree whose bodies are
/// exchanged there, and one that closes the loop.
const TILTED: &str = r#"
name = "tilted"
gravity = [0, 0, -9.81]
[bodies.crank]
mass = 1
com = [0, 0, 0]
inertia = [0.01, 0.01, 0.01]
[bodies.coupler]
mass = 1
com = [0, 0, 0]
inertia = [0.01, 0.01, 0.001]
[bodies.rocker]
mass = 1
com = [0, 0, 0]
inertia = [0.01, 0.01, 0.01]
[bodies.pendulum]
mass = 1
com = [0, 0, "-100 mm"]
inertia = [0.01, 0.01, 0.01]
[joints.A]
type = "R"
from = "ground"
to = "crank"
axis = "y"
actuated = true
[joints.B]
type = "S"
from = "coupler"
to = "crank"
at = ["10 mm", 0, "-200 mm"]
to_at = ["100 mm", 0, 0]
turn = { xyz = ["20 deg", "5 deg", 0] }
range = { tilt = [0, "50 deg"] }
[joints.C]
type = "S"
from = "coupler"
to = "rocker"
at = [0, "10 mm", "200 mm"]
to_at = [0, 0, "300 mm"]
turn = { xyz = [0, "-30 deg", "10 deg"] }
range = { tilt = ["5 deg", "60 deg"] }
[joints.D]
type = "R"
from = "ground"
to = "rocker"
at = ["400 mm", "50 mm", 0]
axis = [0.1, 1, 0]
[joints.E]
type = "S"
from = "ground"
to = "pendulum"
at = ["-500 mm", 0, 0]
turn = { axis = "x", angle = "-15 deg" }
range = { tilt = [0, "45 deg"] }
[motions.swing]
duration = "1 s"
A = "0.3 rad*sin(t/(1 s))"
coupler.rz = "5 deg"
pendulum.rx = "10 deg"
pendulum.ry = "20 deg*cos(t/(1 s))"
pendulum.rz = "-5 deg"
[loads.none]
[default]
motion = "swing"
load = "none"
"#;

/// The axes from which the tilt of a ball is measured, each in its own body.
#[test]
fn tilts_of_balls_are_measured_from_the_same_axes() {
    let original = model_of("tilted", TILTED);
    let axes = |model: &ModelFile, name: &str| {
        let mechanism = &model.mechanism;
        let own = &mechanism.joints()[joint(mechanism, name).0];
        let body = |id: BodyId| mechanism.bodies()[id.0].name.clone();
        let ends = [own.predecessor, own.successor].map(body);
        let ranges: Vec<_> = own.ranges.iter().map(|range| (range.of, range.limits)).collect();
        (ends, ranges, [own.frame_j, own.frame_k].map(|frame| frame.rotation.columns[2]))
    };
    for format in [Format::Mjcf, Format::Sdf, Format::Urdf] {
        let text = imported(&original, format);
        let again = model_of("tilted", &text);
        for name in ["B", "C", "E"] {
            let (expected, found) = (axes(&original, name), axes(&again, name));
            assert_eq!((&found.0, &found.1), (&expected.0, &expected.1), "{format:?} {name}");
            for (found, expected) in found.2.into_iter().zip(expected.2) {
                let apart = (found + -expected).norm();
                assert!(apart < 1e-12, "{format:?} {name}: {found:?} {expected:?}\n{text}");
            }
        }
    }
}

/// Checks that a range of tilt on a turned base is left out rather than measured from another axis.
#[test]
fn tilts_on_a_turned_base_are_not_changed() {
    let text = format!("base = {{ rotation = {{ xyz = [\"90 deg\", 0, 0] }} }}\n{TILTED}");
    let original = model_of("tilted", &text);
    for format in [Format::Mjcf, Format::Sdf, Format::Urdf] {
        let text = imported(&original, format);
        let again = model_of("tilted", &text).mechanism;
        let own = &again.joints()[joint(&again, "E").0];
        assert!(own.ranges.is_empty(), "{format:?}: {:?}\n{text}", own.ranges);
    }
}

/// A body on a joint `J` of a given type between two bodies, with a motor on each degree of freedom, friction, a range, and a
/// spring with a damper on the first degree of freedom.
fn with_one_joint(symbol: &str, is_reversed: bool) -> ModelFile {
    let (from, to) = if is_reversed { ("b", "a") } else { ("a", "b") };
    let (keys, first, motion) = match symbol {
        "H" => (
            "pitch = \"3 mm/rad\"\nfriction = { mu = 0.1, radius = \"8 mm\", flank_angle = \"30 deg\" }\nrange = [-2, 2]",
            "J",
            "J = 0.3 + 0.4*sin(t/(1 s))",
        ),
        "C" => (
            "friction = { mu = 0.1, radius = \"8 mm\", bending_span = \"40 mm\" }\nrange = { slide = [-0.2, 0.3], angle = [-2, 2] }",
            "J.angle",
            "J.angle = 0.3 + 0.4*sin(t/(1 s))\nJ.slide = \"30 mm*cos(t/(1 s))\"",
        ),
        "U" => (
            "second_axis = \"y\"\nfriction = { mu = 0.1, radius = \"8 mm\", first = { mu = 0.2 } }\nrange = { first = [-1, 1], tilt = [0, 2] }",
            "J.first",
            "J.first = 0.3 + 0.4*sin(t/(1 s))\nJ.second = 0.2 - 0.3*t/(1 s)",
        ),
        _ => (
            "x_axis = \"y\"\nfriction = { mu = 0.1, radius = \"8 mm\" }\nrange = { x = [-0.2, 0.3] }",
            "J.x",
            "J.x = \"30 mm*cos(t/(1 s))\"\nJ.y = \"20 mm + 10 mm*t/(1 s)\"\nJ.angle = 0.3 + 0.4*sin(t/(1 s))",
        ),
    };
    let motion = motion.lines().map(|line| {
        let (name, value) = line.split_once(" = ").unwrap();
        format!("{name} = \"{}\"\n", value.trim_matches('"'))
    });
    let motion: String = motion.collect();
    let unit = if symbol == "E" { ("N/m", "N s/m") } else { ("N m/rad", "N m s/rad") };
    let text = format!(
        r#"
name = "one"
gravity = [1, -2, -9]
[bodies.a]
mass = 1
com = [0.1, 0.02, 0]
inertia = [0.01, 0.01, 0.01]
[bodies.b]
mass = 2
com = [0.03, 0.01, 0.1]
inertia = {{ xx = 0.02, yy = 0.03, zz = 0.015, xy = 1e-3 }}
[joints.A]
type = "R"
from = "ground"
to = "a"
axis = "y"
actuated = true
[joints.J]
type = "{symbol}"
from = "{from}"
to = "{to}"
at = ["10 mm", "20 mm", "30 mm"]
to_at = ["-5 mm", 0, "15 mm"]
axis = "x"
actuated = true
{keys}
[springs.S]
joint = "{first}"
stiffness = "2 {}"
rest = 0
damping = "0.1 {}"
[motions.m]
duration = "1 s"
A = "0.2 + 0.3*sin(t/(1 s))"
{motion}
[loads.none]
[default]
motion = "m"
load = "none"
"#,
        unit.0, unit.1
    );
    model_of("one", &text)
}

/// Properties of a joint that do not depend on the frames of its bodies.
fn properties(model: &ModelFile, name: &str) -> String {
    let mechanism = &model.mechanism;
    let own = &mechanism.joints()[joint(mechanism, name).0];
    let ends = [own.predecessor, own.successor].map(|id| &mechanism.bodies()[id.0].name);
    let springs = mechanism.joint_springs();
    let mut friction = own.friction.clone();
    friction.sort_by_key(|interface| interface.place);
    format!("{:?} {ends:?} {:?} {friction:?} {springs:?}", own.joint_type, own.ranges)
}

#[test]
fn joints_with_motors_friction_and_springs_return_whole() {
    for symbol in ["H", "C", "U", "E"] {
        for is_reversed in [false, true] {
            let original = with_one_joint(symbol, is_reversed);
            let sdf = ["H", "U"].contains(&symbol).then_some((Format::Sdf, false));
            for (format, literal) in
                [(Format::Mjcf, false), (Format::Mjcf, true)].into_iter().chain(sdf)
            {
                let text = imported_with(&original, format, ImportOptions { literal });
                let again = model_of("one", &text);
                let what = format!("{symbol} {is_reversed} {format:?} {literal}");
                assert_eq!(properties(&again, "J"), properties(&original, "J"), "{what}\n{text}");
                let [a, b] =
                    [&original, &again].map(|model| forces(&original, model, 0.3).unwrap());
                assert_eq!(a.efforts.len(), b.efforts.len(), "{what}");
                for ((name, effort, frictional), (other, a, b)) in a.efforts.iter().zip(&b.efforts)
                {
                    assert_eq!(name, other, "{what}");
                    assert!((a - effort).abs() < 1e-12, "{what} {name}: {a} {effort}");
                    assert!((b - frictional).abs() < 1e-10, "{what} {name}: {b} {frictional}");
                    let acts = name != "J" || (effort - frictional).abs() > 1e-9;
                    assert!(acts, "{what}: no friction");
                }
            }
        }
    }
}

/// Massless bodies between joints: `hub` and `cross` carry one body each.
const BETWEEN: &str = r#"
name = "between"
gravity = [1, -2, -9]
[bodies.hub]
[bodies.cross]
[bodies.arm]
mass = 2
com = [0.03, 0.01, 0.1]
inertia = { xx = 0.02, yy = 0.03, zz = 0.015, xy = 1e-3 }
[joints.A]
type = "C"
from = "ground"
to = "hub"
axis = [0.1, 0.2, 1]
actuated = true
friction = { mu = 0.1, radius = "8 mm", bending_span = "40 mm" }
[joints.B]
type = "R"
from = "cross"
to = "hub"
at = [0, 0.1, 0]
axis = "x"
actuated = true
friction = { mu = 0.1, radius = "8 mm" }
[joints.C]
type = "P"
from = "cross"
to = "arm"
at = [0.1, 0, 0]
axis = [1, 0.2, 0]
actuated = true
friction = { mu = 0.1 }
[motions.m]
duration = "1 s"
A.angle = "0.2 + 0.3*sin(t/(1 s))"
A.slide = "0.02 + 0.03*sin(t/(1 s))"
B = "0.3 - 0.4*sin(t/(1 s))"
C = "0.1 - 0.04*sin(t/(1 s))"
[loads.none]
[default]
motion = "m"
load = "none"
"#;

#[test]
fn massless_bodies_between_joints_return_from_mjcf() {
    let original = model_of("between", BETWEEN);
    let job = default_job(&original, FrictionMode::Off);
    let text = mjcf(&Home::of(&job).unwrap()).unwrap().text;
    assert_eq!(text.matches("<body").count(), 2, "{text}");
    let again = round_trip(&original, Format::Mjcf);
    let names = |model: &ModelFile| {
        let mut names: Vec<_> =
            model.mechanism.bodies().iter().map(|body| body.name.clone()).collect();
        names.sort();
        names
    };
    assert_eq!(names(&again), names(&original));
    for name in ["A", "B", "C"] {
        assert_eq!(properties(&again, name), properties(&original, name));
    }
    let [a, b] = [&original, &again].map(|model| forces(&original, model, 0.3).unwrap());
    for ((name, effort, frictional), (other, a, b)) in a.efforts.iter().zip(&b.efforts) {
        assert_eq!(name, other);
        assert!((a - effort).abs() < 1e-12, "{name}: {a} {effort}");
        assert!((b - frictional).abs() < 1e-10, "{name}: {b} {frictional}");
    }
}

/// Constant friction and damping, with and without a motor.
const DAMPED: &str = r#"
name = "damped"
gravity = [0, 0, -9.81]
[bodies.a]
mass = 1
com = [0.1, 0, 0]
inertia = [0.01, 0.01, 0.01]
[bodies.b]
mass = 1
com = [0.1, 0.02, 0]
inertia = [0.01, 0.01, 0.01]
[joints.A]
type = "R"
from = "ground"
to = "a"
axis = "y"
actuated = true
friction = { mu = 1e-6, preload = "2e7 N", viscous = "0.5 N m s/rad", radius = "10 mm" }
[joints.B]
type = "P"
from = "a"
to = "b"
axis = "x"
friction = { viscous = "3 N s/m", mu = 0 }
[actuators.M]
joint = "B"
lead = "10 mm/rev"
motor_friction = { constant = "0.02 N m" }
[springs.S]
joint = "B"
stiffness = "2 N/m"
rest = 0
damping = "0.5 N s/m"
[motions.m]
duration = "1 s"
A = "0.3*sin(t/(1 s)) + 0.2"
B = "0.03*sin(t/(1 s)) + 0.1"
[loads.none]
[default]
motion = "m"
load = "none"
"#;

#[test]
fn constant_friction_and_damping_are_for_other_programs_too() {
    let original = model_of("damped", DAMPED);
    let job = default_job(&original, FrictionMode::Off);
    let home = Home::of(&job).unwrap();
    let (urdf, sdf) = (urdf(&home).unwrap(), sdf(&home).unwrap());
    let number = |text: &str| text.trim_matches('"').parse::<f64>().unwrap();
    let values = |text: &str, key: &str| -> Vec<f64> {
        let start = format!(" {key}=");
        let all = text.split(&start).skip(1);
        all.map(|rest| number(rest.split([' ', '/']).next().unwrap())).collect()
    };
    let all = [values(&urdf.text, "damping"), values(&urdf.text, "friction")].concat();
    let texts = |key: &str| -> Vec<f64> {
        let start = format!("<{key}>");
        let all = sdf.text.split(&start).skip(1);
        all.map(|rest| number(rest.split('<').next().unwrap())).collect()
    };
    // The friction of the motor at the slide is 0.02 N m at a lead of 10 mm per revolution.
    let expected = [0.5, 3.5, 0.2, 0.02 * std::f64::consts::TAU / 0.01];
    for found in [all, [texts("damping"), texts("friction")].concat()] {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
    for notes in [urdf.notes, sdf.notes] {
        assert!(!notes.iter().any(|note| note.contains("friction is in elements")), "{notes:?}");
    }
    // Both files contain these values a second time, in the elements of this program.
    let expected = forces(&original, &original, 0.3).unwrap();
    for format in [Format::Sdf, Format::Urdf] {
        let found = forces(&original, &round_trip(&original, format), 0.3).unwrap();
        for ((name, effort, frictional), (_, a, b)) in expected.efforts.iter().zip(&found.efforts) {
            assert!((a - effort).abs() < 1e-12, "{format:?} {name}: {a} {effort}");
            assert!((b - frictional).abs() < 1e-9, "{format:?} {name}: {b} {frictional}");
        }
    }
}
