//! Continuation from the frictionless solution to the given friction coefficients.
//!
//! Equation (F8) of the book's theory.

/// Friction locking: the solution branch ends at a fraction of the friction coefficients, where the
/// normal loads grow without bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lock {
    /// Fraction of the given friction coefficients at which the solution branch ends.
    pub(crate) part: f64,
    /// Index of the interface whose normal load has grown most.
    pub(crate) interface: usize,
}

/// The first step may extend to the fraction of the friction coefficients at which the coupling
/// bound reaches this value. The solution is unique while the bound is below one.
const CERTAIN: f64 = 0.99;

/// Step sizes of the continuation, as fractions of the given friction coefficients.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepPolicy {
    /// Size of the first step, unless [`Self::with_bound`] extends it.
    pub(crate) first: f64,
    /// Factor by which the step size is multiplied after a successful step.
    pub(crate) growth: f64,
    /// Largest step, relative to the fraction of the friction coefficients reached so far.
    pub(crate) longest: f64,
    /// Step size below which the continuation stops. If the fraction of the friction coefficients
    /// reached so far exceeds one, this size is relative to that fraction.
    pub(crate) shortest: f64,
    /// Largest number of steps, failed ones included.
    pub(crate) most: usize,
}

impl StepPolicy {
    /// Extends the first step to the fraction of the friction coefficients up to which the coupling
    /// `bound` guarantees a unique solution, but not beyond `until`. `bound` refers to the full
    /// friction coefficients.
    pub(crate) fn with_bound(self, bound: f64, until: f64) -> Self {
        let certain = if bound > 0.0 { CERTAIN / bound } else { f64::INFINITY };
        Self { first: certain.min(until).max(self.first), ..self }
    }
}

/// Solution branch, parametrised by the fraction of the friction coefficients.
pub(crate) trait Branch {
    /// Solves with the fraction `part` of the friction coefficients, starting from the last
    /// accepted solution. Returns `true` if it finds a solution on the same branch, that is, with
    /// the same sign of the determinant.
    fn correct(&mut self, part: f64) -> bool;

    /// Accepts the solution of the last [`Self::correct`].
    fn accept(&mut self);

    /// Returns to the last accepted solution.
    fn reject(&mut self);

    /// Index of the interface whose normal load has the largest growth factor since the
    /// frictionless solution.
    fn fastest_growing(&self) -> usize;
}

/// Follows a solution branch from the frictionless solution to `until` times the given friction
/// coefficients, halving steps that fail. Returns the number of steps.
///
/// # Errors
/// Returns the [`Lock`] at which the branch ends if no further step succeeds, because the
/// determinant of the coupled system vanishes there, or if the number of steps exceeds its limit.
pub(crate) fn follow(
    branch: &mut impl Branch,
    policy: StepPolicy,
    until: f64,
) -> Result<usize, Lock> {
    let (mut part, mut step) = (0.0, policy.first);
    for steps in 1..=policy.most {
        if part > 0.0 {
            step = step.min(policy.longest * part);
        }
        let next = f64::min(part + step, until);
        if branch.correct(next) {
            branch.accept();
            part = next;
            step *= policy.growth;
            if part >= until {
                return Ok(steps);
            }
            continue;
        }
        branch.reject();
        step *= 0.5;
        if step < policy.shortest * part.max(1.0) {
            break;
        }
    }
    Err(Lock { part, interface: branch.fastest_growing() })
}

/// Index of the normal load with the largest growth factor between the lists `start` and `now`.
pub(crate) fn fastest_growing(start: &[f64], now: &[f64]) -> usize {
    let size = start.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let growth = |k: usize| now[k] / (start[k] + 1e-12 * size);
    (0..start.len()).max_by(|&a, &b| growth(a).total_cmp(&growth(b))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Branch on which corrections converge only in steps of at most `reach`, and only up to `end`.
    struct Narrow {
        reach: f64,
        end: f64,
        at: f64,
        trial: f64,
    }

    impl Branch for Narrow {
        fn correct(&mut self, part: f64) -> bool {
            self.trial = part;
            part - self.at < self.reach && part < self.end
        }
        fn accept(&mut self) {
            self.at = self.trial;
        }
        fn reject(&mut self) {}
        fn fastest_growing(&self) -> usize {
            0
        }
    }

    #[test]
    fn the_number_of_steps_is_bounded() {
        let policy = StepPolicy {
            first: 0.1,
            growth: 1.5,
            longest: f64::INFINITY,
            shortest: 1e-6,
            most: 300,
        };
        let mut wide = Narrow { reach: 0.2, end: f64::INFINITY, at: 0.0, trial: 0.0 };
        assert!(follow(&mut wide, policy, 1.0).is_ok_and(|steps| steps < 30));
        assert_eq!(wide.at, 1.0);
        // The end of the branch is located to within the shortest step.
        let mut ends = Narrow { reach: 0.2, end: 0.7, at: 0.0, trial: 0.0 };
        let lock = follow(&mut ends, policy, 1.0).unwrap_err();
        assert!(0.7 - lock.part < 2e-6 && lock.part < 0.7, "{lock:?}");
        // The continuation makes at most 300 steps, each shorter than 1e-5.
        let mut narrow = Narrow { reach: 1e-5, end: f64::INFINITY, at: 0.0, trial: 0.0 };
        let lock = follow(&mut narrow, policy, 1.0).unwrap_err();
        assert!(lock.part < 300.0 * 1e-5, "{lock:?}");
    }
}
