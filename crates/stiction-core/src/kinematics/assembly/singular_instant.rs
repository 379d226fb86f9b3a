//! Continuation of a motion to a singular configuration.
//!
//! At some configurations, such as the flat position of a parallelogram, several branches of motion
//! intersect. Loops and prescribed coordinates do not determine the rates there, although these are
//! the limits of unique rates at neighbouring instants. Before such an instant, rates and
//! accelerations are known to about the round-off divided by the third power of the distance, so
//! they are extrapolated from instants that are not too close.

use super::{Assembly, CLOSED_AT_WORST};
use crate::kinematics::bodies::State;
use crate::kinematics::coordinate::Target;
use crate::kinematics::dof;
use crate::kinematics::system::column_scales;
use crate::linalg::{Decomposition, largest};
use crate::parameters::Parameters;
use std::sync::Arc;

/// Numbers of halvings of the distance between the instants from which the motion is extrapolated;
/// negative numbers are doublings.
const HALVINGS: core::ops::RangeInclusive<i32> = -8..=5;
/// Smallest singular value, relative to the largest, of a configuration from which the motion is
/// followed by more than one step to each instant. Rates and accelerations are less accurate closer
/// to a singular configuration.
const FAR: f64 = 2e-5;
/// Negligible change of a rate, as a fraction of the largest rate and of the change of rates in the
/// whole step. Rates that are extrapolated across a kink or a jump of the motion differ by more.
const SAME: f64 = 1e-4;
/// Largest correction of an extrapolated coordinate, rad or characteristic lengths.
const NEGLIGIBLE: f64 = 1e-6;
/// A configuration without a pivot below this value is not singular; pivots are about as large as
/// singular values, or larger.
const SUSPICIOUS: f64 = 1e-5;
/// Number of corrections of the extrapolated coordinates. One is sufficient if the extrapolation is
/// accurate to 1e-7, and a second one shows that no errors remain.
const CORRECTIONS: usize = 3;

/// Coordinates, rates and accelerations at the singular instant.
struct Continued {
    state: State<f64>,
    /// Difference of the accelerations from those extrapolated from other instants.
    uncertainty: f64,
    /// Largest negligible change of a rate.
    tolerance: f64,
}

impl Assembly {
    /// Moves to the configuration at the time `next`, s, by extrapolation of the motion that led
    /// there. The motion began at the time `from` with the state [`Self::start`], and is to be
    /// followed to `to`. Returns false and does not move if there is no such smooth motion.
    pub(super) fn continue_to(
        &mut self,
        parameters: &Parameters<f64>,
        (from, to): (f64, f64),
        next: f64,
        motion: &mut impl FnMut(f64, &mut [Target<f64>]),
    ) -> bool {
        if !self.is_determined() {
            return false;
        }
        let Some(continued) = self.extrapolated(parameters, (from, to), next, motion) else {
            return false;
        };
        let mut singular = self.clone();
        singular.extrapolation.forget();
        singular.state = continued.state;
        motion(next, &mut singular.targets);
        if !singular.project(parameters, continued.tolerance) {
            return false;
        }
        *self = singular;
        true
    }

    /// Places the bodies, and decomposes the scaled equations for rates.
    fn decomposed(&mut self, parameters: &Parameters<f64>) -> Decomposition {
        self.place(parameters);
        let Self { kinematics, model, .. } = &mut *self;
        kinematics.linearise(&model.topology, parameters, &model.constraints);
        dof::decompose(self.scaled_jacobian(parameters))
    }

    /// Extrapolates the motion to the time `next` from three earlier instants. Their distance is a
    /// third of the step from `from` to `to`, s, doubled or halved until the difference of two
    /// successive extrapolations is smallest: at large distances the extrapolation is inaccurate, at
    /// small distances the rates before the singular instant are.
    fn extrapolated(
        &self,
        parameters: &Parameters<f64>,
        (from, to): (f64, f64),
        next: f64,
        motion: &mut impl FnMut(f64, &mut [Target<f64>]),
    ) -> Option<Continued> {
        let span = to - from;
        let mut start = self.clone();
        start.extrapolation.forget();
        start.state.clone_from(&self.start);
        motion(from, &mut start.targets);
        let is_far = is_far(&start.decomposed(parameters));
        let mut best: Option<Continued> = None;
        let mut last: Option<State<f64>> = None;
        for halvings in HALVINGS {
            let step = span / 3.0 * 0.5_f64.powi(halvings);
            let state = start.extrapolated_by(parameters, (step, is_far), (from, next), motion);
            if let (Some(coarse), Some(fine)) = (last, &state) {
                let uncertainty = difference(&coarse.accelerations, &fine.accelerations);
                let change = largest(&fine.rates) + span.abs() * largest(&fine.accelerations);
                let tolerance = SAME * change;
                let is_same =
                    difference(&coarse.rates, &fine.rates) <= tolerance && uncertainty.is_finite();
                if is_same && best.as_ref().is_none_or(|best| uncertainty < best.uncertainty) {
                    best = Some(Continued { state: coarse, uncertainty, tolerance });
                }
            }
            last = state;
        }
        best
    }

    /// Extrapolates the motion from the present configuration at the time `from` to `next`, from the
    /// instants one, two and three `step`s before `next`. `None` if the motion cannot be followed to
    /// these instants.
    fn extrapolated_by(
        &self,
        parameters: &Parameters<f64>,
        (step, is_far): (f64, bool),
        (from, next): (f64, f64),
        motion: &mut impl FnMut(f64, &mut [Target<f64>]),
    ) -> Option<State<f64>> {
        let mut scout = self.clone();
        let mut now = from;
        let mut earlier = Vec::with_capacity(3);
        for steps in 1..=3 {
            let time = next - f64::from(steps) * step;
            if is_far {
                scout.follow_regular(parameters, (now, time), motion).ok()?;
            } else {
                motion(time, &mut scout.targets);
                scout.step_smoothly(parameters, time - now, false).ok()?;
            }
            earlier.push(scout.state.clone());
            now = time;
        }
        let mut state = earlier[0].clone();
        let mut moved = vec![0.0; state.rates.len()];
        for (dof, moved) in moved.iter_mut().enumerate() {
            let rates = [0, 1, 2].map(|k: usize| earlier[k].rates[dof]);
            let accelerations = [0, 1, 2].map(|k: usize| step * earlier[k].accelerations[dof]);
            let [integral, rate, slope] = extrapolate(rates, accelerations);
            *moved = step * integral;
            (state.rates[dof], state.accelerations[dof]) = (rate, slope / step);
        }
        let topology = &self.model.topology;
        let turning = (&state.rates[..], &earlier[0].rates[..]);
        State::add_bracket(topology, &mut moved, step * step / 12.0, turning);
        state.advance_far(topology, &moved);
        Some(state)
    }

    /// Returns `true` if loops and prescribed coordinates do not determine the rates at the
    /// configuration for which rates were last computed. Does not allocate unless a pivot is small.
    pub(super) fn is_singular(&self, parameters: &Parameters<f64>) -> bool {
        let Self { kinematics, model, row_scales, .. } = self;
        let pivot = kinematics.smallest_pivot(model, row_scales, parameters.length);
        pivot.is_some_and(|pivot| pivot < SUSPICIOUS) && {
            let decomposition = dof::decompose(self.scaled_jacobian(parameters));
            decomposition.rank() < model.topology.dofs()
        }
    }

    /// Returns `true` if the mechanism stands still, which it can do at a singular configuration too.
    pub(super) fn rests(&self) -> bool {
        self.state.rates.iter().chain(&self.state.accelerations).all(|value| *value == 0.0)
    }

    /// Corrects coordinates, rates and accelerations by the smallest changes with which they
    /// satisfy loops and prescribed coordinates. Returns false if the configuration is not singular,
    /// if a coordinate or a rate (by more than `tolerance`) changes, as after a jump of the motion,
    /// if the loops stay open, or if rates or accelerations violate the equations.
    fn project(&mut self, parameters: &Parameters<f64>, tolerance: f64) -> bool {
        let topology = Arc::clone(&self.model.topology);
        let constraints = Arc::clone(&self.model.constraints);
        let mut decomposition = self.decomposed(parameters);
        if is_far(&decomposition) {
            return false;
        }
        for _ in 0..CORRECTIONS {
            let errors: Vec<f64> = self.kinematics.errors().iter().map(|error| -error).collect();
            let step = self.smallest_solution(parameters, &decomposition, &errors);
            if !self.is_negligible(parameters, &step) {
                return false;
            }
            self.state.advance(&topology, &step);
            decomposition = self.decomposed(parameters);
        }
        if self.scaled_error() > CLOSED_AT_WORST.max(self.state.round_off()) {
            return false;
        }
        self.kinematics.right_of_rates(&constraints, &self.targets);
        let mut rates = self.state.rates.clone();
        let missed = self.correct(parameters, &decomposition, &mut rates);
        let is_small = difference(&rates, &self.state.rates) <= tolerance && missed <= tolerance;
        self.state.rates = rates;
        self.kinematics.move_with(&topology, &self.state);

        self.kinematics.right_of_accelerations(&topology, parameters, &constraints, &self.targets);
        let mut accelerations = core::mem::take(&mut self.state.accelerations);
        let missed = self.correct(parameters, &decomposition, &mut accelerations);
        self.state.accelerations = accelerations;
        self.kinematics.move_with(&topology, &self.state);
        let size = largest(&self.state.rates).powi(2) + largest(&self.state.accelerations);
        is_small && missed <= SAME * size
    }

    /// Returns true if a change of the coordinates is within the accuracy of the extrapolation.
    fn is_negligible(&self, parameters: &Parameters<f64>, step: &[f64]) -> bool {
        let columns = column_scales(&self.model.topology, parameters.length);
        step.iter().zip(columns).all(|(change, scale)| (change / scale).abs() <= NEGLIGIBLE)
    }

    /// Corrects `found`, rates or accelerations of the spanning tree, by the smallest changes with
    /// which they satisfy the equations with the right-hand side that was set last. Returns the
    /// largest scaled residual that remains.
    fn correct(
        &mut self,
        parameters: &Parameters<f64>,
        decomposition: &Decomposition,
        found: &mut [f64],
    ) -> f64 {
        let constraints = Arc::clone(&self.model.constraints);
        self.kinematics.subtract_product(&constraints, found);
        let missing = self.kinematics.right_hand_side();
        let change = self.smallest_solution(parameters, decomposition, missing);
        self.kinematics.subtract_product(&constraints, &change);
        found.iter_mut().zip(change).for_each(|(found, change)| *found += change);
        largest(&self.scaled(self.kinematics.right_hand_side()))
    }

    /// Solves the decomposed equations for rates with the right-hand side `right`; returns the
    /// solution of least scaled norm.
    fn smallest_solution(
        &self,
        parameters: &Parameters<f64>,
        decomposition: &Decomposition,
        right: &[f64],
    ) -> Vec<f64> {
        let solution = decomposition.solve(&self.scaled(right));
        let columns = column_scales(&self.model.topology, parameters.length);
        solution.iter().zip(columns).map(|(value, scale)| value * scale).collect()
    }

    /// Multiplies each row of a right-hand side by its scale factor.
    fn scaled(&self, right: &[f64]) -> Vec<f64> {
        right.iter().zip(&self.row_scales).map(|(right, scale)| right * scale).collect()
    }
}

/// Returns true if the decomposed equations for rates are those of a configuration that is not close
/// to a singular one.
fn is_far(decomposition: &Decomposition) -> bool {
    let last = decomposition.matrix().ncols().checked_sub(1);
    last.is_some_and(|last| decomposition.value(last) >= FAR * decomposition.largest())
}

/// Returns the largest difference of two values at the same place; NaN if any difference is NaN.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    largest(&differences)
}

/// Extrapolates a function of time from the instants -1, -2 and -3 to zero, with its values `at`
/// and its `slopes` at these instants. Returns the integral of the function from -1 to 0, and its
/// value and its slope at zero.
fn extrapolate(at: [f64; 3], slopes: [f64; 3]) -> [f64; 3] {
    // Newton's divided differences with each instant twice. They are multiplied by the integrals,
    // values and slopes of the products of (t + 1), (t + 1), (t + 2), (t + 2) and (t + 3).
    const INTEGRALS: [f64; 6] = [1.0, 1.0 / 2.0, 1.0 / 3.0, 7.0 / 12.0, 31.0 / 30.0, 173.0 / 60.0];
    const VALUES: [f64; 6] = [1.0, 1.0, 1.0, 2.0, 4.0, 12.0];
    const SLOPES: [f64; 6] = [0.0, 1.0, 2.0, 5.0, 12.0, 40.0];
    let instant = |k: usize| -1.0 - (k / 2) as f64;
    let mut differences: [f64; 6] = core::array::from_fn(|k| at[k / 2]);
    for order in 1..6 {
        for k in (order..6).rev() {
            let apart = instant(k) - instant(k - order);
            differences[k] = match apart == 0.0 {
                true => slopes[k / 2],
                false => (differences[k] - differences[k - 1]) / apart,
            };
        }
    }
    [INTEGRALS, VALUES, SLOPES].map(|weights| {
        weights.iter().zip(differences).map(|(weight, difference)| weight * difference).sum()
    })
}

#[cfg(test)]
mod tests {
    use super::extrapolate;

    #[test]
    fn quintic_functions_are_extrapolated_exactly() {
        let coefficients = [0.3, -1.2, 0.7, 2.0, -0.4, 0.9];
        let sum = |terms: &dyn Fn(i32) -> f64| -> f64 {
            (0..6).map(|k| coefficients[k as usize] * terms(k)).sum()
        };
        let at = [-1.0, -2.0, -3.0_f64].map(|t| sum(&|k| t.powi(k)));
        let slopes =
            [-1.0, -2.0, -3.0_f64].map(|t| sum(&|k| f64::from(k) * t.powi((k - 1).max(0))));
        let [integral, value, slope] = extrapolate(at, slopes);
        let expected = sum(&|k| -(-1.0_f64).powi(k + 1) / f64::from(k + 1));
        assert!((integral - expected).abs() < 1e-12, "{integral} {expected}");
        assert!((value - coefficients[0]).abs() < 1e-11, "{value}");
        assert!((slope - coefficients[1]).abs() < 1e-11, "{slope}");
    }
}
