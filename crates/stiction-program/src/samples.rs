//! Random states of motion for value numbering.

use crate::error::RecordError;
use stiction_core::dynamics::{AppliedLoad, Forces, InverseDynamics};
use stiction_core::kinematics::{State, Target};
use stiction_core::random::Random;
use stiction_core::spatial::Vec3;

/// Number of usual samples; extreme samples follow them. Value numbering needs many samples, because it distinguishes the conditions
/// of branches by a random pattern over all samples.
pub(crate) const SAMPLES: usize = 40;
/// Number of extreme samples in addition to [`SAMPLES`], see [`StateRange::Wide`].
const EXTREME: usize = 40;
/// Largest number of different positions of the signal near which samples are taken.
const POSITIONS: usize = 10;

/// Random state of the tree with its prescribed values and loads.
pub(crate) struct Sample {
    pub(crate) state: State<f64>,
    pub(crate) targets: Vec<Target<f64>>,
    pub(crate) loads: Vec<AppliedLoad<f64>>,
    /// True for an extreme state without loads.
    pub(crate) is_extreme: bool,
}

/// Range of the rates, accelerations and loads of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StateRange {
    /// Rates up to 1, accelerations up to 10, and loads up to 100, in SI units.
    Usual,
    /// In addition to [`Self::Usual`], rates between 1e-6 and 1e3, accelerations between 1e-2 and
    /// 1e7, and no loads. Programs that are not compared with the general solver at run time must
    /// contain all branches that are taken at any such state: those of tables of friction at low
    /// and high speeds, and of axial forces of both signs.
    Wide,
}

/// Creates random states along a signal: positions near those of the signal, with random rates,
/// accelerations and loads. Fails if the solver cannot follow the signal.
pub(crate) fn samples(
    solver: &InverseDynamics,
    signal: &[Vec<Target<f64>>],
    loads: &[AppliedLoad<f64>],
) -> Result<Vec<Sample>, RecordError> {
    seeded_samples(1, StateRange::Usual, solver, signal, loads)
}

/// Creates random states as [`samples`] does, which are different for each `seed`.
pub(crate) fn seeded_samples(
    seed: u64,
    range: StateRange,
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
    let count = SAMPLES + if range == StateRange::Wide { EXTREME } else { 0 };
    let mut samples = Vec::with_capacity(count);
    for k in 0..count {
        let is_extreme = k >= SAMPLES;
        let (speed, push) = match is_extreme {
            true => extremes(&mut random),
            false => (1.0, 1.0),
        };
        let position = k % POSITIONS.min(signal.len());
        let mut targets = signal[position].clone();
        for target in &mut targets {
            // A small random offset avoids special positions of the signal.
            target.value += 0.01 * length.min(1.0) * random.number();
            target.rate = speed * random.number();
            target.acceleration = 10.0 * push * random.number();
        }
        solver.move_to(&targets).map_err(|error| RecordError::Signal { position, error })?;
        let strength = if is_extreme { 0.0 } else { 100.0 };
        let mut force = || strength * random.number();
        let mut vector = || Vec3::new(force(), force(), force());
        let any =
            |load: &AppliedLoad<f64>| AppliedLoad { force: vector(), moment: vector(), ..*load };
        let loads = loads.iter().map(any).collect();
        samples.push(Sample { state: solver.state().clone(), targets, loads, is_extreme });
    }
    Ok(samples)
}

/// Returns true if an interface moves so slowly that the solver takes it for one at rest. Programs do
/// not know this limit of the speed.
pub(crate) fn creeps(forces: &Forces) -> bool {
    forces.interfaces.iter().any(|state| !state.slides && state.velocity != 0.0)
}

/// Returns random factors of rates and accelerations of an extreme state. Accelerations are not
/// less than the centripetal ones, in which they would be lost by rounding.
pub(crate) fn extremes(random: &mut Random) -> (f64, f64) {
    let speed = 10_f64.powf(-1.5 + 4.5 * random.number());
    let push = 10_f64.powf(3.0 * random.number());
    (speed, push.max(speed * speed))
}
