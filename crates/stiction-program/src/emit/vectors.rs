//! Test vectors for generated source code, computed by the general solver.

use super::TestVector;
use crate::samples::{creeps, extremes};
use stiction_core::dynamics::{FrictionMode, InverseDynamics};
use stiction_core::kinematics::Target;
use stiction_core::random::Random;
use stiction_core::statics::Constraints;

/// Smallest singularity index of a test state, because rounding errors grow near singular
/// positions. If half of the index at the home position is smaller, that value is the limit
/// instead.
const CLEAR: f64 = 0.05;
/// Smallest sliding speed of a test state, as a fraction of the largest speed, because the sign of
/// a speed near zero is uncertain. Interfaces that never slide are excepted, see [`NEVER`].
const SLIDES: f64 = 1e-3;
/// Smallest value for the largest rate of a test state, rad/s or m/s, because code in single
/// precision takes lower rates for rest.
const MOVES: f64 = 1e-5;
/// Smallest value for the largest effort of a test state, as a fraction of the median of the
/// largest efforts of all test states.
const NOTABLE: f64 = 0.05;
/// Sliding speed, as a fraction of the largest speed, below which the speed is a rounding error of
/// an interface that never slides.
const NEVER: f64 = 1e-12;

impl TestVector {
    /// Creates `count` test vectors at random states near the positions of `signal`, with the
    /// efforts that the solver computes with friction coupled to the reactions. The first position
    /// of `signal` is the home position, from which the solver moves to each state. A state is
    /// skipped if the solver cannot reach it, if it is near a singular position, if a friction
    /// interface is almost at rest, or if the efforts vanish. States at which friction may have
    /// several solutions are used only if there are no others. At most `20 count` states are tried,
    /// so the result may contain fewer than `count` vectors.
    pub fn random(
        solver: &InverseDynamics,
        signal: &[Vec<Target<f64>>],
        count: usize,
        seed: u64,
    ) -> Vec<Self> {
        let mut random = Random::new(seed);
        let mut home = solver.clone();
        let Some(first) = signal.first().filter(|first| home.move_to(first).is_ok()) else {
            return Vec::new();
        };
        debug_assert_eq!(first.len(), home.constraints().coordinates().len());
        home.settings_mut().friction = FrictionMode::Converged;
        let width = 0.05 * home.mechanism().characteristic_length().min(1.0);
        let clear = CLEAR.min(0.5 * index(&home));
        let (mut unique, mut others) = (Vec::with_capacity(count), Vec::new());
        for k in 0..20 * count {
            if unique.len() == count || unique.is_empty() && others.len() == count {
                break;
            }
            let (speed, push) = if k % 4 == 3 { extremes(&mut random) } else { (1.0, 1.0) };
            let about = |target: &Target<f64>| Target {
                value: target.value + width * random.number(),
                rate: speed * random.number(),
                acceleration: 10.0 * push * random.number(),
            };
            let targets: Vec<Target<f64>> = signal[k % signal.len()].iter().map(about).collect();
            match Self::at((&home, first), &targets, clear) {
                Some((vector, true)) => unique.push(vector),
                Some((vector, false)) => others.push(vector),
                None => {}
            }
        }
        let mut found = if unique.is_empty() { others } else { unique };
        // If all efforts of a state vanish by coincidence, they provide no scale for rounding
        // errors.
        let mut sizes: Vec<f64> = found.iter().map(Self::largest).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        let usual = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
        found.retain(|vector| vector.largest() >= NOTABLE * usual);
        found
    }

    /// Magnitude of the largest effort, N or N m.
    fn largest(&self) -> f64 {
        self.efforts.iter().fold(0.0, |max, effort| max.max(effort.abs()))
    }

    /// Creates the test vector for the prescribed values `targets`, to which the solver moves from
    /// the home position. The second value is true if friction certainly has a single solution.
    /// Returns `None` if the state is not suitable, see [`Self::random`].
    fn at(
        (home, start): (&InverseDynamics, &[Target<f64>]),
        targets: &[Target<f64>],
        clear: f64,
    ) -> Option<(Self, bool)> {
        let mut solver = home.clone();
        // The solver moves along a straight line, as the generated code does, because a jump may
        // end in another assembly mode.
        let from: Vec<f64> = start.iter().map(|target| target.value).collect();
        let on_the_line = |part: f64, line: &mut [Target<f64>]| {
            for ((at, target), from) in line.iter_mut().zip(targets).zip(&from) {
                at.value = from + (target.value - from) * part;
                (at.rate, at.acceleration) = (target.value - from, 0.0);
            }
        };
        solver.follow(0.0, 1.0, on_the_line).ok()?;
        solver.move_to(targets).ok()?;
        let is_clear = index(&solver) > clear;
        let forces = solver.solve(&[]).ok()?;
        let speeds = forces.interfaces.iter().map(|interface| interface.velocity.abs());
        let fastest = speeds.clone().fold(0.0, f64::max);
        let mut moving = speeds.map(|speed| speed / fastest);
        let moves = targets.iter().any(|target| target.rate.abs() >= MOVES);
        let slide = fastest == 0.0 || moving.all(|part| !(NEVER..=SLIDES).contains(&part));
        let of = |f: fn(&Target<f64>) -> f64| targets.iter().map(f).collect();
        if !is_clear || !moves || !slide || creeps(forces) {
            return None;
        }
        let vector = Self {
            positions: of(|target| target.value),
            rates: of(|target| target.rate),
            accelerations: of(|target| target.acceleration),
            efforts: forces.efforts.clone(),
        };
        Some((vector, solver.coupling().is_some_and(|bound| bound < 1.0)))
    }
}

/// Returns the smaller of the type 1 and type 2 singularity indices at the present position of the
/// solver. Near a singular position of either type, different assembly modes are close to each
/// other.
fn index(solver: &InverseDynamics) -> f64 {
    let (statics, spins) = (solver.statics(), solver.idle_axes().len());
    let of_legs = Constraints::new(&statics).leg_distance(spins);
    statics.actuation_distance(spins).min(of_legs.unwrap_or(1.0))
}
