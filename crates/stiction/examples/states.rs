//! Efforts of 10 000 neighbouring states, and the time that they take: `cargo run --release -p stiction --example
//! states`.

use std::time::Instant;
use stiction::{Batch, ControlLoop, Error, Outputs, Robot, Workers};

fn main() -> Result<(), Error> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "3rps".to_owned());
    let robot = Robot::builtin(&name)?;
    let states = robot.states().compile()?;
    let (rows, count) = (10_000, states.home().len());
    let (mut q, mut v, mut a) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..rows {
        for (k, home) in states.home().iter().enumerate() {
            let phase = std::f64::consts::TAU * row as f64 / rows as f64 + k as f64;
            q.push(home + 2e-3 * phase.sin());
            v.push(0.01 * phase.cos());
            a.push(-0.1 * phase.sin());
        }
    }

    let batch = Batch { q: &q, v: &v, a: &a };
    let best = |compute: &mut dyn FnMut() -> Result<usize, Error>| -> Result<(f64, usize), Error> {
        let mut best = (f64::INFINITY, 0);
        for _ in 0..10 {
            let start = Instant::now();
            let converged = compute()?;
            best = (best.0.min(start.elapsed().as_secs_f64() * 1e6 / rows as f64), converged);
        }
        Ok(best)
    };
    let (time, converged) = best(&mut || {
        let results = states.inverse_dynamics(batch, Outputs::default(), &Workers::default())?;
        Ok(results.status.iter().filter(|status| status.is_converged()).count())
    })?;
    println!("{name}: {converged} of {rows} states, {time:.3} µs each");

    let ControlLoop { model, mut data, .. } = robot.control_loop()?;
    let (time, converged) = best(&mut || {
        let each = q.chunks_exact(count).zip(v.chunks_exact(count)).zip(a.chunks_exact(count));
        let outcomes = each.map(|((q, v), a)| model.inverse_dynamics(&mut data, q, v, a, &[]));
        Ok(outcomes.filter(|status| status.is_converged()).count())
    })?;
    println!("one after the other in a control loop: {converged} states, {time:.3} µs each");
    Ok(())
}
