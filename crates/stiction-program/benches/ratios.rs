//! Cost of derivatives in eight directions and of forward dynamics, relative to one evaluation of
//! inverse dynamics with friction. The programs run in alternation. Prints medians of times, and
//! medians of the ratios within a round.

#[path = "../tests/suite/common/mod.rs"]
mod common;

use common::Robot;
use std::hint::black_box;
use std::time::Instant;
use stiction_program::{DerivativeProgram, ForwardProgram, InverseProgram, Quantity};

const ROUNDS: usize = 301;
/// Number of evaluations per round, which take some tenths of a millisecond.
const BATCH: usize = 300;
const DIRECTIONS: usize = 8;

fn main() {
    for name in ["3rps", "gough"] {
        if measure(name).is_none() {
            println!("{name}: no program");
        }
    }
}

fn measure(name: &str) -> Option<()> {
    let Robot { mut solver, signal, loads } = Robot::new(name, None);
    let inverse = InverseProgram::record(&solver, &signal, &loads).ok()?;
    let forward = ForwardProgram::record(&solver, &signal, &loads).ok()?;
    let motion: Vec<Quantity> = (0..signal[0].len())
        .flat_map(|k| [Quantity::Value(k), Quantity::Rate(k), Quantity::Acceleration(k)])
        .collect();
    let interfaces = 0..solver.parameters().interfaces.len();
    let frictions: Vec<Quantity> = interfaces.map(Quantity::Mu).collect();
    let by_motion = DerivativeProgram::record(&solver, &signal, &loads, &motion).ok()?;
    let by_friction = DerivativeProgram::record(&solver, &signal, &loads, &frictions).ok()?;

    let mut states = Vec::new();
    for targets in &signal {
        solver.move_to(targets).ok()?;
        let efforts = solver.solve(&loads).ok()?.efforts.clone();
        states.push((targets.clone(), solver.state().clone(), efforts));
    }
    let mut memory = inverse.memory(1);
    let mut of_forward = forward.memory(1);
    let mut of_motion = by_motion.memory();
    let mut of_friction = by_friction.memory();
    let mut settled = [false];
    let mut one = |k: usize| {
        let (targets, state, _) = &states[k % states.len()];
        inverse.set(&mut memory, 0, state, targets, &loads);
        inverse.run(&mut memory, &mut settled);
    };
    let mut settled_forward = [false];
    let mut accelerations = |k: usize| {
        let (_, state, efforts) = &states[k % states.len()];
        forward.set(&mut of_forward, 0, state, &loads, efforts);
        forward.run(&mut of_forward, &mut settled_forward);
    };
    let slopes = |program: &DerivativeProgram, memory: &mut _, k: usize| {
        let (targets, state, _) = &states[k % states.len()];
        black_box(program.run(memory, state, targets, &loads));
        for _ in (0..DIRECTIONS).step_by(program.lanes()) {
            program.differentiate(memory);
        }
    };
    let mut of_state = |k: usize| slopes(&by_motion, &mut of_motion, k);
    let mut of_coefficients = |k: usize| slopes(&by_friction, &mut of_friction, k);
    let names = ["inverse", "forward", "8 directions of motion", "8 directions of friction"];
    let mut subjects: [&mut dyn FnMut(usize); 4] =
        [&mut one, &mut accelerations, &mut of_state, &mut of_coefficients];
    let mut times = vec![[0.0; 4]; ROUNDS];
    for round in &mut times {
        for (subject, time) in subjects.iter_mut().zip(round) {
            let begun = Instant::now();
            (0..BATCH).for_each(&mut **subject);
            *time = begun.elapsed().as_secs_f64() * 1e9 / BATCH as f64;
        }
    }
    for (k, subject) in names.iter().enumerate() {
        let time = median(times.iter().map(|round| round[k]).collect());
        let ratio = median(times.iter().map(|round| round[k] / round[0]).collect());
        println!("{name}: {subject} {time:.0} ns, {ratio:.2} of one evaluation");
    }
    println!(
        "{name}: operations {:?}, {:?}, {:?}, {:?}",
        inverse.operations(),
        forward.operations(),
        by_motion.operations(),
        by_friction.operations()
    );
    Some(())
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}
