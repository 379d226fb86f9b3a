//! Convergence of the normal loads in programs of forward dynamics.
//!
//! The change in a step approximates the error before the step. A Newton step squares the error. A
//! chord step reduces the error by a constant factor, which follows from the last two steps. One
//! small change is not sufficient, because slowly converging loads may change little at first.
//!
//! Before a second chord step, the rate is known only from a ratio that may happen to be small. It is
//! assumed to be at most of the order of the change in the Newton step, as normal loads are smooth
//! functions of reactions. Close to jamming it is larger, by the factor by which the iteration then
//! magnifies rounding errors.

use crate::inverse::{ROUNDING, SETTLED};

/// If the error after a chord step exceeds this fraction of the error before the step, a Newton
/// step with a new matrix follows.
const SLOW: f64 = 0.03;
/// If a Newton step changes the normal loads by more than this fraction, another Newton step
/// follows.
const FAR: f64 = 0.05;
/// If a step changes the normal loads by at most this fraction, further steps change them by
/// rounding only.
const STILL: f64 = 1e-14;

/// A chord step reduces the error by a factor of about twice the ratio of the changes in the first
/// chord step and in the Newton step before. This factor is a margin. The ratio may still happen to
/// be much smaller than the rate, because the errors of the two steps have different directions.
const CHORD_RATE: f64 = 10.0;

/// State of the iteration in each of `L` lanes.
pub(crate) struct Convergence<const L: usize> {
    /// Changes of the last step relative to the largest normal load.
    changes: [f64; L],
    /// `true` if the last step was a Newton step; `None` before the first step.
    newton: Option<bool>,
    is_slow: bool,
}

impl<const L: usize> Convergence<L> {
    pub(crate) fn new() -> Self {
        Self { changes: [1.0; L], newton: None, is_slow: false }
    }

    /// Returns `true` if the next step must be a Newton step, because a chord step converged slowly
    /// or the last Newton step changed the normal loads too much.
    pub(crate) fn is_slow(&self) -> bool {
        self.is_slow
    }

    /// Checks for each lane whether the normal loads have converged to rounding. `loads` are the
    /// normal loads after and before a Newton step (`newton`) or chord step, `determinant` is that
    /// of the matrix of the step.
    pub(crate) fn after<'a>(
        &mut self,
        newton: bool,
        loads: impl Iterator<Item = (&'a [f64; L], &'a [f64; L])>,
        determinant: &[f64; L],
    ) -> [bool; L] {
        let again = self.newton.replace(newton) == Some(newton);
        let (mut largest, mut change) = ([f64::MIN_POSITIVE; L], [0.0_f64; L]);
        for (now, before) in loads {
            for lane in 0..L {
                let moved = (now[lane] - before[lane]).abs();
                // NaN must not pass as small.
                change[lane] = if moved.is_nan() { f64::INFINITY } else { change[lane].max(moved) };
                largest[lane] = largest[lane].max(now[lane].abs());
            }
        }
        self.is_slow = false;
        core::array::from_fn(|lane| {
            let (before, now) = (self.changes[lane], change[lane] / largest[lane]);
            self.changes[lane] = now;
            let rate = now / before;
            let has_converged = if newton {
                let error = now * now * (rate / before).max(now);
                now <= SETTLED || again && now < 1e-3 && error <= ROUNDING
            } else if again {
                now <= STILL || rate < 0.5 && now * rate / (1.0 - rate) <= ROUNDING
            } else {
                let error = CHORD_RATE * rate * now;
                now <= STILL || error <= ROUNDING && before * now <= ROUNDING
            };
            self.is_slow |= !has_converged && if newton { now > FAR } else { rate > SLOW };
            has_converged && determinant[lane] > 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative changes in a Newton step and in the following chord steps; returns the number of
    /// steps until convergence.
    fn steps(changes: &[f64]) -> Option<usize> {
        let mut convergence = Convergence::<1>::new();
        let is_done = |(step, change): (usize, &f64)| {
            let loads = [([1.0], [1.0 - change])];
            let loads = loads.iter().map(|(now, before)| (now, before));
            convergence.after(step == 0, loads, &[1.0])[0]
        };
        changes.iter().enumerate().map(is_done).position(|done| done).map(|at| at + 1)
    }

    #[test]
    fn the_rate_of_chord_steps_follows_from_the_newton_step() {
        // A ratio of 1e-10 leaves an error of 1e-23, or of 1e-16 if it happens to be small.
        assert_eq!(steps(&[1e-3, 1e-13, 0.0]), Some(2));
        // A ratio of 1e-7 leaves an error of 1e-17, but of 1e-13 if it happens to be small.
        assert_eq!(steps(&[1e-3, 1e-10, 0.0]), Some(3));
        // A ratio of 1e-5 leaves an error of 1e-13.
        assert_eq!(steps(&[1e-3, 1e-8, 1e-13, 0.0]), Some(3));
        assert_eq!(steps(&[1e-3, f64::NAN]), None);
        // A rate that happens to be small is no proof after a large change.
        assert_eq!(steps(&[0.1, 1e-10]), None);
    }

    #[test]
    fn a_ratio_that_happens_to_be_small_is_no_proof() {
        // The rate may be as large as the change in the Newton step. On both sides of the threshold:
        assert_eq!(steps(&[0.01, 0.9e-13, 0.0]), Some(2));
        assert_eq!(steps(&[0.01, 1.1e-13, 0.0]), Some(3));
        // The second chord step shows the true rate, with which the third is the last or not.
        assert_eq!(steps(&[0.01, 1.1e-13, 1.1e-15, 0.0]), Some(3));
        assert_eq!(steps(&[0.01, 1e-10, 5e-12, 2e-13, 0.0]), Some(5));
    }

    #[test]
    fn small_changes_in_a_newton_step_count_as_rounding() {
        assert_eq!(steps(&[1e-9]), Some(1));
    }

    /// Beyond a determinant of zero, the solution of the linearised friction is another than the
    /// one that follows from growing coefficients of friction.
    #[test]
    fn matrices_without_a_positive_determinant_never_settle() {
        let loads = [([1.0; 4], [1.0; 4])];
        let loads = loads.iter().map(|(now, before)| (now, before));
        let determinant = [1.0, 0.0, -1.0, f64::NAN];
        let settled = Convergence::<4>::new().after(true, loads, &determinant);
        assert_eq!(settled, [true, false, false, false]);
    }
}
