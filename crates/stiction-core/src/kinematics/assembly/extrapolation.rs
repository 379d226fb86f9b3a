//! Extrapolation of a motion from three configurations, and prediction of the accuracy of Newton
//! steps that reuse the matrix of the last configuration.

/// Initial estimate of the factor by which a Newton step with the matrix of the last configuration
/// reduces the error.
const UNKNOWN: f64 = 1e-3;
/// Factor applied to the estimated error reduction of a Newton step with the matrix of the last
/// configuration whenever the estimate rules such a step out. The step is thus tried again later.
const HOPE: f64 = 0.7;

/// State of the extrapolation. With extrapolation, the round-off of results depends on the previous
/// configurations. An assembly that must continue with bitwise identical results from its
/// configuration alone therefore must not extrapolate.
#[derive(Clone, Debug)]
pub(super) struct Extrapolation {
    is_active: bool,
    /// Durations of the last two steps, s, newest first; `None` if the state before a step is
    /// unknown.
    steps: [Option<f64>; 2],
    /// Duration of the step that led to the present configuration, s.
    passed: Option<f64>,
    reduction: f64,
}

impl Default for Extrapolation {
    fn default() -> Self {
        Self { is_active: false, steps: [None; 2], passed: None, reduction: UNKNOWN }
    }
}

impl Extrapolation {
    pub(super) fn is_active(&self) -> bool {
        self.is_active
    }

    pub(super) fn activate(&mut self) {
        self.is_active = true;
    }

    /// Clears the step history. Required after any change of the configuration other than a step
    /// along the motion.
    pub(super) fn forget(&mut self) {
        (self.steps, self.passed) = ([None; 2], None);
    }

    /// Begins a step of `step` seconds. Returns two factors, s^2, by which the changes of the
    /// accelerations in the last two steps (newest first) are multiplied. The sum of the two
    /// products corrects the predicted change of the coordinates. Returns `None` if the last step
    /// is unknown. Clears the step history; [`Self::stepped`] restores it and adds the present
    /// step.
    pub(super) fn weights(&mut self, step: f64) -> Option<[f64; 2]> {
        let [last, before] = core::mem::take(&mut self.steps);
        self.passed = last;
        let last = last?;
        // Integrals of the polynomial through the accelerations (Newton's divided differences).
        let cubic = step * step * step / 6.0;
        // After a reversal, configurations may coincide in time.
        let Some(before) = before.filter(|before| before * last > 0.0) else {
            return Some([cubic / last, 0.0]);
        };
        let quartic = (0.5 * step + last) * cubic / (last + before);
        Some([(cubic + quartic) / last, -quartic / before])
    }

    /// Records that the present step has succeeded; `step` is its duration, s.
    pub(super) fn stepped(&mut self, step: f64) {
        if self.is_active && step != 0.0 {
            self.steps = [Some(step), self.passed];
        }
    }

    /// Returns `true` if a Newton step with the matrix of the last configuration is expected to
    /// reduce the error to `limit`.
    pub(super) fn suffices(&mut self, error: f64, limit: f64) -> bool {
        let suffices = error * self.reduction < limit;
        if !suffices {
            self.reduction *= HOPE;
        }
        suffices
    }

    /// Updates the estimated error reduction from the errors before and after a Newton step with
    /// the matrix of the last configuration. Errors below `limit` are round-off and are ignored.
    pub(super) fn add(&mut self, before: f64, after: f64, limit: f64) {
        if after.is_nan() || after > limit {
            let reduction = after / before;
            self.reduction = if reduction < 1.0 { reduction } else { 1.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Extrapolation;

    /// Checks that accelerations that are quadratic in time are extrapolated exactly, for steps of
    /// different durations.
    #[test]
    fn quadratic_accelerations_are_continued_exactly() {
        let mut extrapolation = Extrapolation::default();
        extrapolation.activate();
        let motion =
            |t: f64| [t.powi(4) - t.powi(3), 4.0 * t.powi(3) - 3.0 * t * t, 12.0 * t * t - 6.0 * t];
        let times = [0.0, 0.5, 0.75, 1.5];
        for pair in times[..3].windows(2) {
            let step = pair[1] - pair[0];
            let _ = extrapolation.weights(step);
            extrapolation.stepped(step);
        }
        let step = times[3] - times[2];
        let [newest, oldest] = extrapolation.weights(step).unwrap();
        let [q, v, a] = motion(times[2]);
        let acceleration = |k: usize| motion(times[k])[2];
        let found = q
            + step * (v + 0.5 * step * a)
            + newest * (acceleration(2) - acceleration(1))
            + oldest * (acceleration(1) - acceleration(0));
        assert!((found - motion(times[3])[0]).abs() < 1e-14, "{found}");
        // A motion that goes back and forth passes the same instant twice.
        for step in [0.5, -0.5] {
            let _ = extrapolation.weights(step);
            extrapolation.stepped(step);
        }
        assert_eq!(extrapolation.weights(-0.5), Some([0.125 / 6.0 / 0.5, 0.0]));
        // After a step that did not succeed, no step history is left.
        assert_eq!(extrapolation.weights(step), None);
    }
}
