//! Random states of motion for value numbering.

use crate::error::RecordError;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics};
use stiction_core::kinematics::{State, Target};
use stiction_core::random::Random;
use stiction_core::spatial::Vec3;

/// Number of samples. Value numbering needs many samples, because it distinguishes the conditions
/// of branches by a random pattern over all samples.
const SAMPLES: usize = 40;
/// Largest number of different positions of the signal near which samples are taken.
const POSITIONS: usize = 10;

/// Random state of the tree with its prescribed values and loads.
pub(crate) struct Sample {
    pub(crate) state: State<f64>,
    pub(crate) targets: Vec<Target<f64>>,
    pub(crate) loads: Vec<AppliedLoad<f64>>,
}

/// Creates random states along a signal: positions near those of the signal, with random rates,
/// accelerations and loads. Fails if the solver cannot follow the signal.
pub(crate) fn samples(
    solver: &InverseDynamics,
    signal: &[Vec<Target<f64>>],
    loads: &[AppliedLoad<f64>],
) -> Result<Vec<Sample>, RecordError> {
    seeded_samples(1, solver, signal, loads)
}

/// Creates random states as [`samples`] does, which are different for each `seed`.
pub(crate) fn seeded_samples(
    seed: u64,
    solver: &InverseDynamics,
    signal: &[Vec<Target<f64>>],
    loads: &[AppliedLoad<f64>],
) -> Result<Vec<Sample>, RecordError> {
    let mut random = Random::new(seed);
    let mut solver = solver.clone();
    let length = solver.mechanism().characteristic_length();
    if !solver.mechanism().gearings().is_empty() {
        return Err(RecordError::Gearings);
    }
    if signal.is_empty() {
        return Err(RecordError::EmptySignal);
    }
    let mut samples = Vec::with_capacity(SAMPLES);
    for k in 0..SAMPLES {
        let position = k % POSITIONS.min(signal.len());
        let mut targets = signal[position].clone();
        for target in &mut targets {
            // A small random offset avoids special positions of the signal.
            target.value += 0.01 * length.min(1.0) * random.number();
            target.rate = random.number();
            target.acceleration = 10.0 * random.number();
        }
        solver.move_to(&targets).map_err(|error| RecordError::Signal { position, error })?;
        let mut force = || 100.0 * random.number();
        let mut vector = || Vec3::new(force(), force(), force());
        let any =
            |load: &AppliedLoad<f64>| AppliedLoad { force: vector(), moment: vector(), ..*load };
        let loads = loads.iter().map(any).collect();
        samples.push(Sample { state: solver.state().clone(), targets, loads });
    }
    Ok(samples)
}
