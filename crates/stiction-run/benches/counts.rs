//! One call of each kernel, for `cargo xtask counts`, which counts its instructions.

use std::hint::black_box;
use std::process::ExitCode;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, Settings};
use stiction_core::kinematics::Target;
use stiction_core::statics::SingularityDistances;
use stiction_format::{Source, gallery, read};
use stiction_program::InverseProgram;

const ROBOTS: [&str; 2] = ["3rps", "gough"];
const KERNELS: [&str; 6] =
    ["frictionless", "friction", "program-frictionless", "program-friction", "follow", "distances"];
/// Number of calls before the measured one, so that initialisation at first use is not counted.
const BEFORE: usize = 3;

fn main() -> ExitCode {
    // The harness adds `--bench`.
    let name = std::env::args().skip(1).find(|argument| argument != "--bench");
    let names = ROBOTS.iter().flat_map(|robot| KERNELS.map(|kernel| format!("{robot}/{kernel}")));
    match name.as_deref() {
        Some("--list") => names.for_each(|name| println!("{name}")),
        // When all benchmarks run, it only verifies that everything works.
        None => names.for_each(|name| run(&name)),
        Some(name) if names.clone().any(|known| known == name) => run(name),
        Some(name) => {
            eprintln!("no kernel {name}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// Callgrind counts the instructions inside this function.
#[inline(never)]
fn counted(call: &mut dyn FnMut()) {
    call();
    black_box(());
}

fn measure(mut call: impl FnMut()) {
    (0..BEFORE).for_each(|_| call());
    counted(&mut call);
}

/// A robot at an instant of its motion, and neighbouring positions.
struct Robot {
    solver: InverseDynamics,
    signal: Vec<Vec<Target<f64>>>,
    targets: Vec<Target<f64>>,
    loads: Vec<AppliedLoad<f64>>,
}

fn robot(name: &str) -> Robot {
    let text = gallery::get(name).expect("it is in the gallery");
    let model = read(&Source::new(name, text), &|_| Err("no files".into())).expect("it is right");
    let motion = model.motion(model.default_motion.as_deref().unwrap()).unwrap();
    let load = model.load(model.default_load.as_deref().unwrap()).unwrap();
    let at = |part: f64| motion.at(part * motion.duration).collect::<Vec<_>>();
    let signal: Vec<_> = (0..10).map(|k| at(0.1 * (f64::from(k) + 0.37))).collect();
    let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
    let (mechanism, initial_poses) = (model.mechanism.clone(), &model.initial_poses);
    let settings = Settings::default();
    let mut solver =
        InverseDynamics::new(mechanism, initial_poses, &coordinates, &signal[0], settings).unwrap();
    for targets in &signal[1..4] {
        solver.move_to(targets).unwrap();
    }
    let targets = signal[3].clone();
    Robot { solver, signal, targets, loads: load.at(0.337 * motion.duration).collect() }
}

fn run(name: &str) {
    let (robot_name, kernel_name) = name.split_once('/').unwrap_or((name, ""));
    let Robot { mut solver, signal, targets, loads } = robot(robot_name);
    let friction = match kernel_name {
        "friction" => FrictionMode::Converged,
        _ => FrictionMode::Off,
    };
    match kernel_name {
        "frictionless" | "friction" => {
            let compiled = solver.model().unwrap();
            let parameters = solver.parameters().clone();
            let settings = Settings { friction, ..Settings::default() };
            let mut data = compiled.data(solver.state(), settings);
            measure(|| compiled.evaluate(&parameters, &mut data, &targets, &loads));
        }
        "program-frictionless" | "program-friction" => {
            // The inputs are those of the first position; programs do not branch.
            let mut start = solver.clone();
            start.move_to(&signal[0]).unwrap();
            let program = InverseProgram::record(&start, &signal, &loads).unwrap();
            let mut memory = program.memory(1);
            let mut holds = [false];
            measure(|| {
                program.set(&mut memory, 0, solver.state(), &targets, &loads);
                match kernel_name {
                    "program-friction" => program.run(&mut memory, &mut holds),
                    _ => program.run_frictionless(&mut memory, &mut holds),
                }
            });
            assert!(holds[0], "{name}");
        }
        "follow" => {
            let mut there = true;
            measure(|| {
                // Back and forth.
                let near = if there { &signal[4] } else { &targets };
                there = !there;
                solver.move_to(near).unwrap();
            });
        }
        _ => {
            let mut proximity = SingularityDistances::new(solver.mechanism()).unwrap();
            let (mechanism, parameters) = (solver.mechanism(), solver.parameters());
            measure(|| {
                black_box(proximity.measure(mechanism, parameters, solver.bodies()));
            });
        }
    }
}
