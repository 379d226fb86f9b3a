//! Continuation from the frictionless solution to the given friction coefficients.
//!
//! Equation (F8) of the book's theory.

/// Limit point at which friction locks the mechanism: the solution branch ends, and the loads
/// diverge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lock {
    /// Fraction of the given coefficients.
    pub(crate) part: f64,
    /// Index of the interface with the largest growth of the normal load.
    pub(crate) interface: usize,
}

/// Coupling bound at the end of the first step; the solution is unique there.
const CERTAIN: f64 = 0.99;

/// Step sizes of the fraction of the given coefficients.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepPolicy {
    /// Shortest first step.
    pub(crate) first: f64,
    /// Growth of a step after a success.
    pub(crate) growth: f64,
    /// Longest step, relative to the current fraction.
    pub(crate) longest: f64,
    /// Shortest step, relative to the current fraction if that exceeds one.
    pub(crate) shortest: f64,
}

impl StepPolicy {
    /// Sets the first step to the largest fraction, up to `until`, with a unique solution by a
    /// bound on the coupling.
    pub(crate) fn with_bound(self, bound: f64, until: f64) -> Self {
        let certain = if bound > 0.0 { CERTAIN / bound } else { f64::INFINITY };
        Self { first: certain.min(until).max(self.first), ..self }
    }
}

/// A solution that depends on the fraction of the friction coefficients.
pub(crate) trait Branch {
    /// Solves with this fraction of the coefficients from the last accepted solution. Returns
    /// `true` for a solution on the same branch: the determinant has the same sign.
    fn correct(&mut self, part: f64) -> bool;

    /// Accepts the solution of the last [`Self::correct`].
    fn accept(&mut self);

    /// Returns to the last accepted solution.
    fn reject(&mut self);

    /// Index of the interface with the largest growth of the normal load since the frictionless
    /// solution.
    fn fastest_growing(&self) -> usize;
}

/// Follows a branch from the frictionless solution to `until` times the given coefficients, halving steps that fail.
///
/// # Errors
/// The lock at which steps no longer succeed: the determinant of the coupled system vanishes there.
pub(crate) fn follow(branch: &mut impl Branch, policy: StepPolicy, until: f64) -> Result<(), Lock> {
    let (mut part, mut step) = (0.0, policy.first);
    while part < until {
        if part > 0.0 {
            step = step.min(policy.longest * part);
        }
        let next = f64::min(part + step, until);
        if branch.correct(next) {
            branch.accept();
            part = next;
            step *= policy.growth;
            continue;
        }
        branch.reject();
        step *= 0.5;
        if step < policy.shortest * part.max(1.0) {
            return Err(Lock { part, interface: branch.fastest_growing() });
        }
    }
    Ok(())
}

/// Index of the normal load with the largest ratio to its value in `start`.
pub(crate) fn fastest_growing(start: &[f64], now: &[f64]) -> usize {
    let size = start.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let growth = |k: usize| now[k] / (start[k] + 1e-12 * size);
    (0..start.len()).max_by(|&a, &b| growth(a).total_cmp(&growth(b))).unwrap_or(0)
}
