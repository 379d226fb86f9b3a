//! Source code, compiled and run by the tests.

mod adapters;
mod agreement;
mod behaviour;
mod compiler;
mod fmu;
mod functions;
mod speed;

use crate::common::{Loop, Robot, gallery_loop, machine, model};
use compiler::{Code, SANITIZERS, STRICT};
use stiction_program::emit::{Labels, Language, Precision, SourceOptions, TestVector};
use stiction_program::{Feedforward, Tunable};

/// Robots of the gallery that have a program. The actuators of the others, 3upu-singular, griffis-duffy and zhang2018,
/// do not determine the motion.
const ROBOTS: [&str; 14] = [
    "3rps",
    "3rrr",
    "3upu",
    "4ups-upu",
    "6sps",
    "andrews",
    "bricard",
    "delta",
    "five-bar",
    "four-bar",
    "gough",
    "slider-crank",
    "spherical-3rrr",
    "zhang2018-regular",
];

pub(crate) fn labels(name: &str, robot: &Loop) -> Labels {
    let (mechanism, parameters) = (robot.solver.mechanism(), robot.solver.parameters());
    let joints = mechanism.joints();
    let mut labels =
        Labels { model: name.to_owned(), version: "0".to_owned(), ..Labels::default() };
    for (joint, dof) in mechanism.actuators() {
        let joint = &joints[joint.0];
        let units = match joint.joint_type.dofs()[dof].translates() {
            true => ("m", "N"),
            false => ("rad", "N m"),
        };
        labels.coordinates.push((joint.name.clone(), units.0));
        labels.actuators.push((joint.name.clone(), units.1));
    }
    labels.joints = joints.iter().map(|joint| joint.name.clone()).collect();
    let name_of = |joint: usize| joints[joint].name.clone();
    labels.interfaces = parameters.interfaces.iter().map(|i| name_of(i.joint)).collect();
    labels.bodies = mechanism.bodies().iter().map(|body| body.name.clone()).collect();
    labels
}

/// Options of a variant with a precision, with or without its own sine and cosine.
fn variant(name: &str, precision: Precision, own_math: bool) -> SourceOptions {
    SourceOptions { precision, own_math, ..SourceOptions::new(name) }
}

/// Checks that the code compiles without warnings as C and C++, and reproduces the solver's forces,
/// with sanitizers.
fn check(names: &[&str], count: usize, all: bool) {
    for name in names {
        check_robot(name, &gallery_loop(name).unwrap(), count, all);
    }
}

fn check_robot(name: &str, robot: &Loop, count: usize, all: bool) {
    let tunables = Tunable::frictions(robot.solver.parameters());
    let program = Feedforward::record(&robot.solver, &robot.signal, &tunables).unwrap();
    let vectors = TestVector::random(&robot.solver, &robot.signal, count, 7);
    assert!(vectors.len() > count / 2, "{name}: {}", vectors.len());
    for (precision, own_math) in [
        (Precision::Double, false),
        (Precision::Float, true),
        (Precision::Double, true),
        (Precision::Float, false),
    ] {
        let options = variant(name, precision, own_math);
        let files = program.files(Language::C, &labels(name, robot), &options, &vectors).unwrap();
        let folder = format!("{name}-{precision:?}-{own_math}");
        let Some(code) = Code::new(&folder, &options.name, &files) else { return };
        code.selftest(&[&STRICT[..], &["-std=c99"], &SANITIZERS].concat());
        if all || precision == Precision::Float {
            code.selftest(&[&STRICT[..], &["-x", "c++", "-O0"]].concat());
        }
        if !all && own_math {
            break;
        }
    }
}

#[test]
fn generated_c_reproduces_the_solver() {
    check(&["five-bar", "zhang2018-regular"], 100, false);
}

/// Every position of an open chain is within reach.
#[test]
fn generated_c_of_an_open_chain_reproduces_the_solver() {
    let text = "
        gravity = [0, -9.81, 0]
        default = { motion = \"swing\", load = \"pull\" }
        [bodies]
        upper = { mass = 2, com = [0.2, 0, 0], inertia = [0.1, 0.1, 0.1] }
        slider = { mass = 1, com = [0.1, 0, 0], inertia = [0.1, 0.1, 0.1] }
        [joints.R]
        type = \"R\"
        from = \"ground\"
        to = \"upper\"
        axis = \"z\"
        actuated = true
        friction = { mu = 0.1, radius = 0.02 }
        [joints.P]
        type = \"P\"
        from = \"upper\"
        to = \"slider\"
        axis = \"x\"
        actuated = true
        friction = { mu = 0.1 }
        [loads.pull]
        slider = { force = [5, 0, 0] }
        [motions.swing]
        duration = 1
        R = \"sin(2*pi*t)\"
        P = \"0.3 + 0.1*sin(2*pi*t)\"";
    let robot = Loop::of(Robot::of(&model("open chain", text), None)).unwrap();
    check_robot("open-chain", &robot, 50, true);
}

/// The loop of a screw and a guide closes at every position.
#[test]
fn generated_c_of_a_screw_and_a_guide_reproduces_the_solver() {
    let friction = "{ mu = 0.1, radius = \"10 mm\", flank_angle = \"15 deg\" }";
    check_robot("screw", &machine("screw", friction), 50, false);
}

/// At this level of optimisation, compilers follow the sizes of arrays, which are zero for chains
/// without loops.
#[test]
fn generated_c_of_an_open_chain_has_no_warnings_at_low_optimisation() {
    let arm = |name: &str, from: &str, axis: &str| {
        format!(
            "bodies.{name} = {{ mass = 1, com = [0, 0.01, 0.1], inertia = [0.02, 0.02, 0.01] }}\n\
             joints.{name} = {{ type = \"R\", from = \"{from}\", to = \"{name}\", at = [0, 0, 0.2], axis = \"{axis}\", \
             actuated = true, friction = {{ mu = 0.05, radius = 0.02 }} }}\n"
        )
    };
    let arms = [arm("one", "ground", "z"), arm("two", "one", "y"), arm("three", "two", "y")];
    let motion =
        "motions.m = { duration = 1, one = \"0.3 + t\", two = \"0.3 - t\", three = \"0.3 + 2*t\" }";
    let top = "gravity = [0, 0, -9.81]\ndefault = { motion = \"m\", load = \"pull\" }\n\
               loads.pull = { three = { force = [5, 0, 0] } }\n";
    let text = format!("{top}{}{motion}\n", arms.concat());
    let robot = Loop::of(Robot::of(&model("arm", &text), None)).unwrap();
    let program = Feedforward::record(&robot.solver, &robot.signal, &[]).unwrap();
    for precision in [Precision::Double, Precision::Float] {
        let options = variant("arm", precision, false);
        let files = program.files(Language::C, &labels("arm", &robot), &options, &[]).unwrap();
        let Some(code) = Code::new(&format!("arm-{precision:?}"), "arm", &files) else { return };
        for level in ["-O1", "-O2"] {
            code.compile("selftest.c", &[&STRICT[..], &["-std=c99", level]].concat()).unwrap();
        }
    }
}

/// Near the positions in which crank and rod are perpendicular, the pivots of the recording magnify
/// rounding errors; a row of the test vectors of this seed lies there.
#[test]
fn test_vectors_near_badly_pivoted_positions_pass_in_single_precision() {
    for (name, seed) in [("slider-crank", 1), ("zhang2018-regular", 1)] {
        let robot = gallery_loop(name).unwrap();
        let program = Feedforward::record(&robot.solver, &robot.signal, &[]).unwrap();
        let vectors = TestVector::random(&robot.solver, &robot.signal, 200, seed);
        assert!(vectors.len() > 150, "{name}: {}", vectors.len());
        let options = variant(name, Precision::Float, false);
        let files = program.files(Language::C, &labels(name, &robot), &options, &vectors).unwrap();
        let folder = format!("{name}-single-{seed}");
        let Some(code) = Code::new(&folder, &options.name, &files) else { return };
        code.selftest(&[&STRICT[..], &["-std=c99", "-O1"]].concat());
    }
}

/// Rust code, as a module that uses only `core`, reproduces the solver's forces.
#[test]
fn generated_rust_reproduces_the_solver() {
    let robot = gallery_loop("five-bar").unwrap();
    let tunables = Tunable::frictions(robot.solver.parameters());
    let program = Feedforward::record(&robot.solver, &robot.signal, &tunables).unwrap();
    let vectors = TestVector::random(&robot.solver, &robot.signal, 100, 7);
    for precision in [Precision::Double, Precision::Float] {
        let options = variant("five-bar", precision, false);
        let labels = labels("five-bar", &robot);
        let files = program.files(Language::Rust, &labels, &options, &vectors).unwrap();
        compiler::rust_selftest(&format!("rust-{precision:?}"), "five_bar", &files);
    }
}

/// Covers all gallery robots that have a program.
#[test]
#[ignore = "takes minutes"]
fn generated_c_reproduces_the_solver_for_the_gallery() {
    check(&ROBOTS, 300, true);
}

/// The built-in sine and cosine differ by at most 2 units in the last place from those of the
/// library in a wider format, for angles up to 1e4.
#[test]
fn own_sine_and_cosine_are_accurate() {
    let robot = gallery_loop("five-bar").unwrap();
    let program = Feedforward::record(&robot.solver, &robot.signal, &[]).unwrap();
    let options = variant("five-bar", Precision::Double, true);
    let files = program.files(Language::C, &labels("five-bar", &robot), &options, &[]).unwrap();
    let Some(code) = Code::new("sine", "five_bar", &files) else { return };
    code.run_with("sine", include_str!("emit/sine.c"), &["-std=gnu99", "-O2"]);
}

/// Names of a model appear as harmless text, and the same input gives the same bytes.
#[test]
fn hostile_names_do_no_harm() {
    let robot = gallery_loop("five-bar").unwrap();
    let record = || Feedforward::record(&robot.solver, &robot.signal, &[Tunable::Mu(0)]).unwrap();
    let hostile = "*/ #error \"x\" ??/\n\\\u{202e}@NAME@ %n /*";
    let mut labels = labels(hostile, &robot);
    for (name, _) in labels.coordinates.iter_mut().chain(&mut labels.actuators) {
        *name = hostile.to_owned();
    }
    for names in [&mut labels.joints, &mut labels.interfaces, &mut labels.bodies] {
        names.fill(hostile.to_owned());
    }
    let options = SourceOptions::new(hostile);
    let vectors = TestVector::random(&robot.solver, &robot.signal, 3, 1);
    let files = record().files(Language::C, &labels, &options, &vectors).unwrap();
    for file in &files {
        assert!(file.text.is_ascii(), "{}", file.name);
        for harm in ["#error \"x\"", "??/", "%n", "\\\n"] {
            assert!(!file.text.contains(harm), "{}: {harm}", file.name);
        }
        assert!(!file.name.contains(['/', '"', ' ', '*']), "{}", file.name);
    }
    assert_eq!(record().files(Language::C, &labels, &options, &vectors).unwrap(), files);
    let Some(code) = Code::new("hostile", &options.name, &files) else { return };
    code.selftest(&[&STRICT[..], &["-std=c99", "-O0"]].concat());
}

/// The code does not compile with options under which NaN cannot be detected.
#[test]
fn fast_math_is_refused() {
    let robot = gallery_loop("slider-crank").unwrap();
    let program = Feedforward::record(&robot.solver, &robot.signal, &[]).unwrap();
    let options = SourceOptions::new("slider-crank");
    let files = program.files(Language::C, &labels("slider-crank", &robot), &options, &[]).unwrap();
    let Some(code) = Code::new("fast-math", &options.name, &files) else { return };
    for option in ["-ffast-math", "-Ofast", "-ffinite-math-only"] {
        let said = code.compile("selftest.c", &[option]).unwrap_err();
        assert!(said.contains("tests for NaN and infinity"), "{said}");
    }
}

/// Coordinates of the platform as inputs reproduce the solver's forces.
#[test]
fn platform_coordinates_reproduce_the_solver() {
    for name in ["3rps", "five-bar"] {
        let Robot { solver, signal, .. } = Robot::new(name, None);
        let program = Feedforward::record(&solver, &signal, &[]).unwrap();
        let vectors = TestVector::random(&solver, &signal, 100, 7);
        assert!(vectors.len() > 50, "{name}: {}", vectors.len());
        let robot = Loop { solver, signal };
        let options = variant(name, Precision::Double, false);
        let files = program.files(Language::C, &labels(name, &robot), &options, &vectors).unwrap();
        let folder = format!("platform-{name}");
        let Some(code) = Code::new(&folder, &options.name, &files) else { return };
        code.selftest(&[&STRICT[..], &["-std=c99", "-O1"]].concat());
    }
}
