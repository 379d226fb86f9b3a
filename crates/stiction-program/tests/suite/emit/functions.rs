//! Kinematics, reactions, holding efforts, loads, derivatives and forward dynamics of the source
//! code, compared with the general solver.

use super::compiler::{Code, SANITIZERS, STRICT, rust_program};
use super::labels;
use crate::common::{Loop, Robot, gallery_loop, model};
use stiction_core::dynamics::{AppliedLoad, FrictionMode, LoadAxes};
use stiction_core::kinematics::Target;
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::Vec3;
use stiction_program::emit::{Functions, Language, Precision, SourceOptions, TestVector};
use stiction_program::{Feedforward, RecordError, Tunable};

/// Force and moment on a body, N and N m.
const WRENCH: [f64; 6] = [10.0, -20.0, 30.0, 1.0, -2.0, 0.5];

/// Results of the general solver, after the numbers of the state: efforts, efforts under a load on
/// the last body, reactions, holding efforts, poses, twists.
fn row(robot: &Loop, vector: &TestVector) -> Vec<f64> {
    let TestVector { positions, rates, accelerations, efforts } = vector;
    let targets = |moves: f64| -> Vec<Target<f64>> {
        let each = (0..positions.len()).map(|k| Target {
            value: positions[k],
            rate: moves * rates[k],
            acceleration: moves * accelerations[k],
        });
        each.collect()
    };
    let mut solver = robot.solver.clone();
    solver.settings_mut().friction = FrictionMode::Converged;
    solver.move_to(&robot.signal[0]).unwrap();
    solver.move_to(&targets(1.0)).unwrap();
    let mut row = [&positions[..], rates, accelerations, efforts].concat();
    let numbers = |v: Vec3<f64>| [v.x, v.y, v.z];
    let last = BodyId(solver.mechanism().bodies().len() - 1);
    let vector = |first: usize| Vec3::new(WRENCH[first], WRENCH[first + 1], WRENCH[first + 2]);
    let (point, axes) = (Vec3::zero(), LoadAxes::World);
    let load = AppliedLoad { body: last, point, axes, force: vector(0), moment: vector(3) };
    row.extend(&solver.solve(&[load]).unwrap().efforts);
    let forces = solver.solve(&[]).unwrap();
    for (force, moment) in &forces.reactions {
        row.extend([numbers(*force), numbers(*moment)].concat());
    }
    let (bodies, origin) = (solver.bodies().clone(), solver.parameters().origin);
    solver.settings_mut().friction = FrictionMode::Off;
    solver.move_to(&targets(0.0)).unwrap();
    row.extend(&solver.solve(&[]).unwrap().efforts);
    for pose in &bodies.pose[1..] {
        row.extend(numbers(pose.position + origin));
        let [x, y, z] = pose.rotation.columns.map(numbers);
        row.extend((0..3).flat_map(|k| [x[k], y[k], z[k]]));
    }
    for (pose, twist) in bodies.pose.iter().zip(&bodies.twist).skip(1) {
        row.extend(numbers(twist.velocity_at(pose.position)));
        row.extend(numbers(twist.angular));
    }
    row
}

/// Formats rows of numbers, in the brackets of the language.
fn table(rows: &[Vec<f64>], [open, close]: [&str; 2]) -> String {
    let line = |row: &Vec<f64>| {
        let numbers: Vec<String> = row.iter().map(|x| format!("{x:?}")).collect();
        format!("{open}{}{close},\n", numbers.join(", "))
    };
    rows.iter().map(line).collect()
}

struct Case {
    program: Feedforward,
    options: SourceOptions,
    robot: Loop,
    rows: Vec<Vec<f64>>,
}

fn case(name: &str, precision: Precision) -> Case {
    let robot = gallery_loop(name).unwrap();
    let mut tunables = Tunable::frictions(robot.solver.parameters());
    // The program sorts loads behind all other parameters.
    tunables.insert(0, Tunable::Wrench(BodyId(robot.solver.mechanism().bodies().len() - 1)));
    let program = Feedforward::record(&robot.solver, &robot.signal, &tunables).unwrap();
    let functions =
        Functions { kinematics: true, reactions: true, derivatives: true, accelerations: true };
    let options = SourceOptions { functions, precision, ..SourceOptions::new(name) };
    let refused = program.files(Language::C, &labels(name, &robot), &options, &[]).unwrap_err();
    assert_eq!(refused, RecordError::NoDerivatives);
    let program = program.with_derivatives(&robot.solver, &robot.signal).unwrap();
    // Differences of efforts approximate derivatives only if they do not reverse a joint.
    let mut vectors = TestVector::random(&robot.solver, &robot.signal, 30, 11);
    vectors.retain(|vector| vector.rates.iter().all(|rate| (1e-2..10.0).contains(&rate.abs())));
    assert!(vectors.len() > 15, "{name}: {}", vectors.len());
    let rows = vectors.iter().map(|vector| row(&robot, vector)).collect();
    Case { program, options, robot, rows }
}

#[test]
fn generated_functions_reproduce_the_solver() {
    for name in ["five-bar", "zhang2018-regular", "spherical-3rrr"] {
        for precision in [Precision::Double, Precision::Float] {
            let Case { program, options, robot, rows } = case(name, precision);
            let labels = labels(name, &robot);
            let files = program.files(Language::C, &labels, &options, &[]).unwrap();
            let folder = format!("functions-{name}-{precision:?}");
            let Some(code) = Code::new(&folder, &options.name, &files) else { return };
            let main = include_str!("functions.c")
                .replace("WIDTH", &rows[0].len().to_string())
                .replace("ROWS", &rows.len().to_string())
                .replace("DATA", &table(&rows, ["{ ", " }"]))
                .replace("WRENCH", &format!("{WRENCH:?}").replace(['[', ']'], ""));
            code.run_with(
                "functions_main",
                &main,
                &[&STRICT[..], &["-std=c99"], &SANITIZERS].concat(),
            );
        }
    }
}

#[test]
fn generated_functions_in_rust_reproduce_the_solver() {
    let Case { program, options, robot, rows } = case("five-bar", Precision::Double);
    let labels = labels("five-bar", &robot);
    let files = program.files(Language::Rust, &labels, &options, &[]).unwrap();
    let main = include_str!("functions_main.rs")
        .replace("STD_MATH", include_str!("../../../src/emit/templates/std_math.rs"))
        .replace("WIDTH", &rows[0].len().to_string())
        .replace("ROWS", &rows.len().to_string())
        .replace("DATA", &table(&rows, ["[", "]"]))
        .replace("WRENCH", &format!("{WRENCH:?}"));
    rust_program("rust-functions", &files, &main);
}

/// Two massless links, 0.3 m and 0.2 m long, carry a point mass. Stretched or folded, their mass
/// matrix is singular, because the force along the links moves nothing.
const POINT_MASS: &str = r#"
gravity = [0, -9.81, 0]

[bodies.upper]
mass = 0
com = [0, 0, 0]
inertia = [0, 0, 0]

[bodies.lower]
mass = 2
com = [0.2, 0, 0]
inertia = [0, 0, 0]

[joints.A]
type = "R"
from = "ground"
to = "upper"
axis = "z"
actuated = true

[joints.B]
type = "R"
from = "upper"
to = "lower"
at = [0.3, 0, 0]
axis = "z"
start = 1
actuated = true

[motions.swing]
duration = 1
A = "0.5*sin(6*t)"
B = "1 + 0.5*sin(6*t)"

[loads.none]

[default]
motion = "swing"
load = "none"
"#;

/// Forward dynamics returns a code instead of a huge number at positions where rounding errors
/// determine the accelerations.
#[test]
fn singular_mass_matrices_are_refused() {
    let Robot { solver, signal, .. } = Robot::of(&model("point-mass", POINT_MASS), None);
    let program = Feedforward::record(&solver, &signal, &[]).unwrap();
    let program = program.with_derivatives(&solver, &signal).unwrap();
    let robot = Loop { solver, signal };
    let labels = labels("arm", &robot);
    let functions = Functions { accelerations: true, ..Functions::default() };
    for precision in [Precision::Double, Precision::Float] {
        let options = SourceOptions { functions, precision, ..SourceOptions::new("arm") };
        let files = |language| program.files(language, &labels, &options, &[]).unwrap();
        let folder = format!("singular-{precision:?}");
        if let Some(code) = Code::new(&folder, &options.name, &files(Language::C)) {
            let flags = [&STRICT[..], &["-std=c99", "-O2"]].concat();
            code.run_with("singular_main", include_str!("singular.c"), &flags);
        }
        let main = include_str!("singular_main.rs")
            .replace("STD_MATH", include_str!("../../../src/emit/templates/std_math.rs"));
        rust_program(&format!("rust-{folder}"), &files(Language::Rust), &main);
    }
}
