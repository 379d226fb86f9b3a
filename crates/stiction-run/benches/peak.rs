//! Speed of recorded programs relative to the limit of one core. The benchmark counts the
//! operations of a program, and compares them with the additions and multiplications of doubles per
//! second in a loop without other work.

use std::hint::black_box;
use std::time::Instant;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_format::{Source, gallery, read};
use stiction_program::InverseProgram;

const STEPS: u32 = 200_000;
/// Number of batches. The fastest batch counts, because other programs may use the machine.
const BATCHES: usize = 30;

fn main() {
    // Independent chains of operations hide the latency of a single operation.
    let limit = [rate::<16>(), rate::<32>(), rate::<64>()].into_iter().fold(0.0, f64::max);
    println!(
        "additions and multiplications in vectors as this was compiled for: {:.1}e9/s",
        1e-9 * limit
    );
    println!("| program | states at once | operations | time of a state, ns | 1e9 operations/s |");
    println!("| --- | --- | --- | --- | --- |");
    ["3rps", "gough"].into_iter().for_each(program);
}

/// Returns the operations per second in `N` independent chains of one multiplication and one
/// addition.
fn rate<const N: usize>() -> f64 {
    let (factor, term) = (black_box(0.999_999), black_box(1e-6));
    let mut x = black_box([0.5; N]);
    let time = least(1, || {
        for _ in 0..STEPS {
            for x in &mut x {
                *x = *x * factor + term;
            }
        }
        x = black_box(x);
    });
    2.0 * N as f64 * f64::from(STEPS) / time
}

/// Returns the seconds per call in the fastest of several batches.
fn least(count: u32, mut call: impl FnMut()) -> f64 {
    let batch = |_| {
        let begun = Instant::now();
        (0..count).for_each(|_| call());
        begun.elapsed().as_secs_f64() / f64::from(count)
    };
    (0..BATCHES).map(batch).fold(f64::INFINITY, f64::min)
}

/// Measures the frictionless program of a robot.
fn program(name: &str) {
    let text = gallery::get(name).expect("it is in the gallery");
    let model = read(&Source::new(name, text), &|_| Err("no files".into())).expect("it is right");
    let motion = model.motion(model.default_motion.as_deref().unwrap()).unwrap();
    let load = model.load(model.default_load.as_deref().unwrap()).unwrap();
    let loads: Vec<_> = load.at(0.1).collect();
    let at = |part: f64| motion.at(part * motion.duration).collect::<Vec<_>>();
    let signal: Vec<_> = (0..10).map(|k| at(0.1 * (f64::from(k) + 0.37))).collect();
    let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
    let (mechanism, initial_poses) = (model.mechanism.clone(), &model.initial_poses);
    let solver = InverseDynamics::new(
        mechanism,
        initial_poses,
        &coordinates,
        &signal[0],
        Settings::default(),
    )
    .unwrap();
    let program = InverseProgram::record(&solver, &signal, &loads).unwrap();
    let operations = program.operations()[0] as f64;
    for lanes in [1, program.lanes()] {
        let mut memory = program.memory(lanes);
        let mut holds = vec![false; lanes];
        for lane in 0..lanes {
            program.set(&mut memory, lane, solver.state(), &signal[0], &loads);
        }
        let time = least(2000, || program.run_frictionless(&mut memory, &mut holds)) / lanes as f64;
        println!(
            "| {name} | {lanes} | {operations} | {:.0} | {:.1} |",
            1e9 * time,
            1e-9 * operations / time
        );
    }
}
