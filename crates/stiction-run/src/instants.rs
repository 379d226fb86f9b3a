//! Sample times of a motion.

use stiction_format::{Motion, SampleTimes};
use thiserror::Error;

/// Default time between samples, s, for motions that do not define one.
const USUAL_STEP: f64 = 0.01;
/// Limit of the number of samples of a motion; a larger number indicates an error in the step.
const MOST: f64 = 1e9;

/// Sample times of a motion in increasing order.
#[derive(Clone, Debug, PartialEq)]
pub struct Instants {
    kind: Kind,
}

#[derive(Clone, Debug, PartialEq)]
enum Kind {
    /// `count` evenly spaced instants from `start` to `start + span`, s, followed by the instant
    /// `rest`, s, if it is given.
    Even { start: f64, span: f64, count: usize, rest: Option<f64> },
    /// Sample times of a recorded motion.
    Recorded(SampleTimes),
}

/// Error in the choice of sample times.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum InstantsError {
    /// The step is not positive.
    #[error("the time between samples is {0} s, but must be greater than 0")]
    Step(
        /// Requested step, s.
        f64,
    ),
    /// The step yields too many samples.
    #[error(
        "a step of {step:?} s makes {count} samples of this motion; the maximum is {MOST:.0e}",
        count = if count.is_finite() { format!("{count:.1e}") } else { "countless".to_owned() }
    )]
    TooMany {
        /// Requested step, s.
        step: f64,
        /// Number of samples.
        count: f64,
    },
}

impl Instants {
    /// Creates sample times every `step` seconds. Without `step`, the step of the motion is used.
    /// If the motion does not define a step, a recorded motion is sampled at the times of its
    /// recording, and any other motion every 0.01 s. If the step does not divide the duration, the
    /// last part of the motion is not sampled.
    ///
    /// # Errors
    /// See [`InstantsError`].
    pub fn of(motion: &Motion, step: Option<f64>) -> Result<Self, InstantsError> {
        let step = step.or(motion.step);
        if let (None, Some(samples)) = (step, &motion.samples) {
            return Ok(Self { kind: Kind::Recorded(samples.clone()) });
        }
        let step = step.unwrap_or(USUAL_STEP);
        if !(step > 0.0 && step.is_finite()) {
            return Err(InstantsError::Step(step));
        }
        // A step that divides the duration within rounding counts as dividing it exactly.
        let steps = motion.duration / step;
        let divides = (steps - steps.round()).abs() < 1e-9 * steps.max(1.0);
        let whole = if divides { steps.round() } else { steps.floor() };
        if whole >= MOST {
            return Err(InstantsError::TooMany { step, count: whole });
        }
        let span = if divides { motion.duration } else { whole * step };
        let count = whole as usize + 1;
        Ok(Self { kind: Kind::Even { start: motion.start, span, count, rest: None } })
    }

    /// Creates sample times every `step` seconds from `start` to `end`, s. Both ends are samples;
    /// the last step may be shorter.
    ///
    /// # Errors
    /// See [`InstantsError`].
    pub fn up_to(start: f64, end: f64, step: f64) -> Result<Self, InstantsError> {
        let span = Motion { start, duration: (end - start).max(0.0), ..Motion::pose() };
        let mut instants = Self::of(&span, Some(step))?;
        if let Kind::Even { span: reached, rest, .. } = &mut instants.kind
            && *reached < span.duration
        {
            *rest = Some(end);
        }
        Ok(instants)
    }

    /// Returns the number of sample times.
    pub fn count(&self) -> usize {
        match &self.kind {
            Kind::Even { count, rest, .. } => *count + usize::from(rest.is_some()),
            Kind::Recorded(samples) => samples.count(),
        }
    }

    /// Returns the sample time with index `k`, s, or the last sample time if `k` exceeds the last
    /// index. Returns NaN if the file of a recorded motion can no longer be read; evaluating the
    /// motion then returns the error.
    pub fn at(&self, k: usize) -> f64 {
        match &self.kind {
            Kind::Even { rest: Some(end), count, .. } if k >= *count => *end,
            Kind::Even { start, span, count, .. } => {
                // With one multiplication and one division, decimal sample times such as 0.07 are
                // exact.
                let last = count.saturating_sub(1).max(1);
                start + span * k.min(last) as f64 / last as f64
            }
            Kind::Recorded(samples) => samples.at(k),
        }
    }

    /// Iterates over all sample times, s.
    pub fn iter(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.count()).map(|k| self.at(k))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(duration: f64) -> Motion {
        Motion { duration, ..Motion::pose() }
    }

    #[test]
    fn decimal_instants_stay_decimal() {
        let instants = Instants::of(&motion(1.0), None).unwrap();
        assert_eq!(instants.count(), 101);
        for (k, t) in instants.iter().enumerate() {
            assert_eq!(t, k as f64 / 100.0);
        }
    }

    #[test]
    fn a_step_that_does_not_divide() {
        let instants = Instants::of(&motion(1.0), Some(0.3)).unwrap();
        let expected = [0.0, 0.3, 0.6, 0.9];
        assert_eq!(instants.count(), 4);
        for (found, expected) in instants.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn the_end_is_reached_though_the_step_does_not_divide() {
        let all = |end, step| Instants::up_to(0.5, end, step).unwrap().iter().collect::<Vec<_>>();
        let found = all(1.5, 0.3);
        let expected = [0.5, 0.8, 1.1, 1.4, 1.5];
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15);
        }
        assert_eq!(found.last(), Some(&1.5));
        assert_eq!(all(1.5, 0.25), [0.5, 0.75, 1.0, 1.25, 1.5]);
        assert_eq!(all(0.6, 1.0), [0.5, 0.6]);
        assert_eq!(all(0.5, 1.0), [0.5]);
    }

    #[test]
    fn impossible_steps() {
        for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = Instants::of(&motion(1.0), Some(step)).unwrap_err();
            assert!(matches!(error, InstantsError::Step(_)), "{step}");
        }
        let error = Instants::of(&motion(1.0), Some(1e-12)).unwrap_err();
        assert!(matches!(error, InstantsError::TooMany { .. }));
    }

    #[test]
    fn a_motion_without_duration_has_one_sample() {
        let instants = Instants::of(&motion(0.0), None).unwrap();
        assert_eq!(instants.iter().collect::<Vec<_>>(), [0.0]);
    }
}
