//! Single calls of each kernel, and runs with all tables, for `cargo xtask counts`, which counts
//! their instructions.

use std::hint::black_box;
use std::process::ExitCode;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, Settings};
use stiction_core::kinematics::Target;
use stiction_core::statics::SingularityDistances;
use stiction_format::{ModelFile, Source, gallery, read};
use stiction_program::InverseProgram;
use stiction_run::inverse::{Summary, Tables};
use stiction_run::{Job, Sink};

const ROBOTS: [&str; 2] = ["3rps", "gough"];
const KERNELS: [&str; 6] =
    ["frictionless", "friction", "program-frictionless", "program-friction", "follow", "distances"];
/// Names of the runs: the hexapod along a part of its motion, with ideal actuators and with motors.
const RUNS: [&str; 2] = ["gough/run", "gough/run-geared"];
/// Motors of the hexapod's legs with all properties that cost computing time.
const MOTORS: &str = "
[legs.actuators.P]
lead = \"10 mm/rev\"
rotor_inertia = \"0.9 kg cm^2\"
efficiency = 0.9
motor_friction = { constant = \"30 mN m\", viscous = \"2e-5 N m s/rad\" }
torque_constant = \"0.45 N m/A\"
limits = { rated = \"0.64 N m\", peak = \"1.9 N m\", speed = \"3000 rpm\" }
";
/// Number of samples of a run.
const SAMPLES: f64 = 200.0;
/// Number of calls before the measured call, so that initialisation at first use is not counted.
const BEFORE: usize = 3;

fn main() -> ExitCode {
    // The test harness adds the argument `--bench`.
    let name = std::env::args().skip(1).find(|argument| argument != "--bench");
    let kernels = ROBOTS.iter().flat_map(|robot| KERNELS.map(|kernel| format!("{robot}/{kernel}")));
    let names = kernels.chain(RUNS.map(str::to_owned));
    match name.as_deref() {
        Some("--list") => names.for_each(|name| println!("{name}")),
        // Without a name, all benchmarks run once, to verify that they work.
        None => names.for_each(|name| run(&name)),
        Some(name) if names.clone().any(|known| known == name) => run(name),
        Some(name) => {
            eprintln!("no kernel {name}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// Executes `call` in a function of its own, so that Callgrind counts only its instructions.
#[inline(never)]
fn counted(call: &mut dyn FnMut()) {
    call();
    black_box(());
}

fn measure(mut call: impl FnMut()) {
    (0..BEFORE).for_each(|_| call());
    counted(&mut call);
}

/// Robot at an instant of its motion, with neighbouring positions.
struct Robot {
    solver: InverseDynamics,
    signal: Vec<Vec<Target<f64>>>,
    targets: Vec<Target<f64>>,
    loads: Vec<AppliedLoad<f64>>,
}

/// Reads a model of the gallery with additional text.
fn model(name: &str, more: &str) -> ModelFile {
    let text = gallery::get(name).expect("it is in the gallery").to_owned() + more;
    read(&Source::new(name, text), &|_| Err("no files".into())).expect("it is right")
}

/// Computes inverse dynamics with all tables, as `stiction inverse -o` does.
fn run_with_tables(name: &str) {
    let model = model("gough", if name.ends_with("geared") { MOTORS } else { "" });
    let motion_name = model.default_motion.clone().unwrap();
    let load_name = model.default_load.clone().unwrap();
    let motion = (motion_name.as_str(), model.motion(&motion_name).unwrap());
    let load = (load_name.as_str(), model.load(&load_name).unwrap());
    let step = Some(motion.1.duration / SAMPLES);
    let job = Job { step, ..Job::new(&model, motion, load) };
    counted(&mut || {
        let files = Tables::<Vec<u8>>::files(&job).len();
        let mut tables = Tables::new(&job, vec![Vec::new(); files]).unwrap();
        let mut summary = Summary::new(&job);
        let verdict = job.run(
            |sample| {
                summary.add(sample)?;
                tables.add(sample)
            },
            |_, _, _| true,
        );
        black_box(summary.json(&job, &verdict.unwrap()));
        black_box(tables.finish().unwrap());
    });
}

fn robot(name: &str) -> Robot {
    let model = model(name, "");
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
    if RUNS.contains(&name) {
        return run_with_tables(name);
    }
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
            // The program runs with the inputs of the first position only. Its instruction count
            // does not depend on the inputs, because programs have no branches.
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
                // The positions alternate between two neighbours.
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
