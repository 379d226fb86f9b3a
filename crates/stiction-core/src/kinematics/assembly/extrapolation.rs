//! Extrapolation of a motion from two positions, and the accuracy of Newton steps with the matrix of the last position.

/// Factor by which a step with the matrix of the last position is expected to reduce the error, before
/// the first such step.
const UNKNOWN: f64 = 1e-3;
/// Factor by which the expected factor decreases with each position at which no such step was taken.
const HOPE: f64 = 0.7;

/// State of the extrapolation. It depends on the previous positions, and so do results, within round-off.
/// Extrapolation must be off if an assembly is to continue with bitwise identical results from its position alone.
#[derive(Clone, Debug)]
pub(super) struct Extrapolation {
    is_active: bool,
    /// Duration of the last step, s, if the state before it is known.
    step: Option<f64>,
    reduction: f64,
}

impl Default for Extrapolation {
    fn default() -> Self {
        Self { is_active: false, step: None, reduction: UNKNOWN }
    }
}

impl Extrapolation {
    pub(super) fn is_active(&self) -> bool {
        self.is_active
    }

    pub(super) fn activate(&mut self) {
        self.is_active = true;
    }

    /// Forgets the last step, after the position has changed in another way.
    pub(super) fn forget(&mut self) {
        self.step = None;
    }

    /// Returns the duration of the last step, s, and forgets it.
    pub(super) fn take(&mut self) -> Option<f64> {
        self.step.take()
    }

    /// Records a step of this duration, s.
    pub(super) fn stepped(&mut self, step: f64) {
        self.step = (self.is_active && step != 0.0).then_some(step);
    }

    /// True if a step with the matrix of the last position is expected to reduce the error to this limit.
    pub(super) fn suffices(&mut self, error: f64, limit: f64) -> bool {
        let suffices = error * self.reduction < limit;
        if !suffices {
            self.reduction *= HOPE;
        }
        suffices
    }

    /// Records the errors before and after a step with the matrix of the last position; errors below the limit
    /// are round-off.
    pub(super) fn add(&mut self, before: f64, after: f64, limit: f64) {
        if after.is_nan() || after > limit {
            let reduction = after / before;
            self.reduction = if reduction < 1.0 { reduction } else { 1.0 };
        }
    }
}
