//! Friction compensation of a controller at reversals and at rest of its reference.

use std::fmt;

/// Compensation of friction near reversals and at rest of the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transition {
    /// Friction in the direction of the reference rate; at rest, in the direction of the reference
    /// acceleration. If the acceleration is also zero, the friction of the last motion is
    /// maintained.
    Sign,
    /// Like [`Self::Sign`], but at rest the maintained friction decays by one percent per sample.
    Fade,
    /// Friction multiplied by tanh(v / w), where v is the reference rate of the actuator. The field
    /// is the ratio of w to the largest magnitude of v.
    Tanh(f64),
}

/// Factor by which [`Transition::Fade`] multiplies the maintained friction in each sample at rest.
/// It equals the default of the exported code.
const FADE: f64 = 0.99;

impl Transition {
    /// Parses `sign`, `fade`, or the width of the tanh in percent, such as `5%`.
    ///
    /// # Errors
    /// Message with the expected forms, if the text has none of them.
    pub fn parse(text: &str) -> Result<Self, String> {
        let expected = "expected `sign`, `fade` or a width between 0 and 100 percent such as `5%`";
        match text.trim() {
            "sign" => Ok(Self::Sign),
            "fade" => Ok(Self::Fade),
            other => {
                let percent = other.strip_suffix('%').and_then(|number| number.trim().parse().ok());
                let percent: f64 = percent.ok_or(expected)?;
                match percent > 0.0 && percent <= 100.0 {
                    true => Ok(Self::Tanh(0.01 * percent)),
                    false => Err(expected.to_owned()),
                }
            }
        }
    }

    /// Factor that multiplies the friction of an actuator. `rate` is the reference rate of the
    /// actuator, `fastest` the largest magnitude of this rate, and `held` the result of
    /// [`Self::next_held`].
    pub(super) fn factor(self, rate: f64, fastest: f64, held: f64) -> f64 {
        match self {
            Self::Sign => 1.0,
            Self::Fade => held,
            Self::Tanh(_) if fastest <= 0.0 => 0.0,
            Self::Tanh(width) => (rate.abs() / (width * fastest)).tanh(),
        }
    }

    /// Returns the factor `held` of [`Self::factor`] for the next sample. With [`Self::Fade`], the
    /// factor decreases while the reference rests; otherwise it is 1.
    pub(super) fn next_held(self, held: f64, rests: bool) -> f64 {
        match (self, rests) {
            (Self::Fade, true) => held * FADE,
            _ => 1.0,
        }
    }
}

impl fmt::Display for Transition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sign => write!(f, "sign"),
            Self::Fade => write!(f, "fade"),
            Self::Tanh(width) => write!(f, "tanh {}%", (1e6 * width).round() / 1e4),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_follow_their_definitions() {
        assert_eq!(Transition::parse("5 %"), Ok(Transition::Tanh(0.05)));
        assert_eq!(Transition::parse("fade"), Ok(Transition::Fade));
        for wrong in ["0%", "101%", "5", "nan%", "tanh"] {
            assert!(Transition::parse(wrong).is_err(), "{wrong}");
        }
        let tanh = Transition::Tanh(0.1);
        assert_eq!(tanh.to_string(), "tanh 10%");
        assert_eq!(tanh.factor(0.2, 2.0, 1.0), 1.0_f64.tanh());
        assert_eq!(tanh.factor(0.0, 2.0, 1.0), 0.0);
        assert_eq!(tanh.factor(1.0, 0.0, 1.0), 0.0);
        assert_eq!(Transition::Sign.factor(0.0, 2.0, 0.5), 1.0);
        let once = Transition::Fade.next_held(1.0, true);
        assert_eq!(Transition::Fade.factor(0.0, 2.0, once), 0.99);
        assert_eq!(Transition::Fade.next_held(once, false), 1.0);
    }
}
