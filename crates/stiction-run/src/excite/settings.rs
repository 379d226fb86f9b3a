//! Options for the design of a motion.

use super::ExciteError;
use stiction_format::Amount;

/// Options for the design of a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct ExciteSettings {
    /// Motion of the model whose coordinates and first position are used; `None` for the default
    /// motion of the model.
    pub motion: Option<String>,
    /// True to design the motion in the coordinates of the actuators; false to design it in the
    /// coordinates of the model's motion.
    pub by_actuators: bool,
    /// Patterns of the names of the parameters that the logs must determine; empty for all
    /// parameters.
    pub parameters: Vec<String>,
    /// Duration of the motion, s, which must be a whole number of periods.
    pub duration: f64,
    /// Frequency of the first harmonic, Hz; `None` if the motion consists of a single period.
    pub base_frequency: Option<f64>,
    /// Number of harmonics, at least two.
    pub harmonics: usize,
    /// Limits on the motion in addition to those of the model.
    pub limits: Vec<LimitSetting>,
    /// Least allowed singularity index, as a fraction of the index at the first position.
    pub margin: f64,
    /// Seed of the random motion from which the search starts.
    pub seed: u64,
    /// Names of the loads with which the motion is repeated; empty for the robot alone.
    pub payloads: Vec<String>,
    /// Standard deviations of the measured efforts, one for each unit (N and N m). If empty, they
    /// are assumed as two percent of the root mean square of each effort.
    pub noise: Vec<Amount>,
    /// Time between samples of the motion, s; `None` for about a hundredth of the period of the
    /// highest harmonic.
    pub step: Option<f64>,
    /// True if efforts are measured at the motors, so that they contain the effort of the rotors.
    pub at_motors: bool,
    /// Largest number of steps of the search.
    pub iterations: usize,
}

impl Default for ExciteSettings {
    fn default() -> Self {
        Self {
            motion: None,
            by_actuators: false,
            parameters: Vec::new(),
            duration: 10.0,
            base_frequency: None,
            harmonics: 5,
            limits: Vec::new(),
            margin: 0.3,
            seed: 1,
            payloads: Vec::new(),
            noise: Vec::new(),
            step: None,
            at_motors: false,
            iterations: 90,
        }
    }
}

/// Limit as written in an option: `NAME = 60 mm`, `NAME = 0 mm..120 mm`, `NAME.speed = 0.5 m/s`,
/// `NAME.acceleration = …` or `NAME.effort = 20 N`. A `*` in the name stands for any text.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitSetting {
    /// Pattern that selects the limited quantities by name.
    pub name: String,
    /// Kind of the limited quantity.
    pub of: Quantity,
    /// Lower end of a range; `None` for a limit on the magnitude.
    pub from: Option<Amount>,
    /// Largest magnitude, or the upper end of a range.
    pub most: Amount,
}

/// Kind of quantity that a limit bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Displacement from the first position, or position if a range is given.
    Travel,
    /// Magnitude of the rate.
    Speed,
    /// Magnitude of the acceleration.
    Acceleration,
    /// Magnitude of the effort.
    Effort,
}

impl LimitSetting {
    /// Parses a limit in the form `NAME = VALUE`.
    ///
    /// # Errors
    /// Returns a message of one line if the text is not a limit.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (key, value) =
            text.split_once('=').ok_or("expected NAME=VALUE, such as `tool.x = 60 mm`")?;
        let key = key.trim();
        let kinds = [
            (".speed", Quantity::Speed),
            (".acceleration", Quantity::Acceleration),
            (".effort", Quantity::Effort),
        ];
        let found = kinds.iter().find_map(|(end, of)| Some((key.strip_suffix(end)?, *of)));
        let (name, of) = found.unwrap_or((key, Quantity::Travel));
        let (from, most) = match value.split_once("..") {
            None => (None, Amount::parse(value)?),
            Some((from, most)) if of == Quantity::Travel => {
                (Some(Amount::parse(from)?), Amount::parse(most)?)
            }
            Some(_) => return Err("only a position can be limited to a range `a..b`".to_owned()),
        };
        if from.is_none() && most.number <= 0.0 {
            return Err(format!("the limit is {value}, but must be positive"));
        }
        if name.is_empty() {
            return Err("the name is missing before `=`".to_owned());
        }
        Ok(Self { name: name.to_owned(), of, from, most })
    }
}

impl ExciteSettings {
    /// Returns the frequency of the first harmonic, Hz, and the number of periods.
    pub(super) fn periods(&self) -> Result<(f64, usize), ExciteError> {
        let positive = |value: f64, what: &str| match value > 0.0 && value.is_finite() {
            true => Ok(value),
            false => Err(ExciteError::input(
                format!("the {what} is {value}, but must be positive"),
                format!("give a positive {what}"),
            )),
        };
        let duration = positive(self.duration, "duration")?;
        if self.harmonics < 2 {
            return Err(ExciteError::input(
                "a motion that begins and ends at rest needs at least two harmonics",
                "give --harmonics 2 or more",
            ));
        }
        let frequency = positive(self.base_frequency.unwrap_or(1.0 / duration), "base frequency")?;
        let periods = frequency * duration;
        let whole = periods.round();
        if whole < 1.0 || (periods - whole).abs() > 1e-6 * periods.max(1.0) {
            let near = (periods.floor().max(1.0) / frequency, periods.ceil() / frequency);
            return Err(ExciteError::input(
                format!(
                    "{duration} s are {periods:.4} periods of {frequency} Hz: a motion that ends \
                     at rest needs a whole number of periods"
                ),
                format!("give --duration {:.6} s or {:.6} s", near.0, near.1),
            ));
        }
        Ok((whole / duration, whole as usize))
    }

    /// Returns the time between samples, s, which divides the duration of the motion.
    pub(super) fn sample_step(&self, frequency: f64) -> Result<f64, ExciteError> {
        let highest = frequency * self.harmonics as f64;
        let wanted = self.step.unwrap_or_else(|| round_step(0.01 / highest));
        if wanted.is_nan() || wanted <= 0.0 || wanted * highest > 0.1 {
            return Err(ExciteError::input(
                format!(
                    "a step of {wanted} s does not sample the highest harmonic, {highest:.4} Hz, \
                     at least ten times per period"
                ),
                format!("give --step {:.3} s or less", 0.1 / highest),
            ));
        }
        Ok(self.duration / (self.duration / wanted).round().max(1.0))
    }
}

/// Rounds a positive number down to 1, 2 or 5 times a power of ten.
fn round_step(step: f64) -> f64 {
    let power = 10f64.powi(step.log10().floor() as i32);
    let digit = step / power;
    let rounded = [5.0, 2.0].into_iter().find(|d| *d <= digit * (1.0 + 1e-9)).unwrap_or(1.0);
    rounded * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read() {
        let limit = LimitSetting::parse("leg*.P.speed = 0.5 m/s").unwrap();
        assert_eq!((limit.name.as_str(), limit.of), ("leg*.P", Quantity::Speed));
        assert_eq!(limit.most.to_unit("mm/s"), Ok(500.0));
        let range = LimitSetting::parse("J1=-20 deg..1 rad").unwrap();
        assert_eq!(range.of, Quantity::Travel);
        assert!((range.from.unwrap().to_unit("deg").unwrap() + 20.0).abs() < 1e-12);
        for (bad, why) in [
            ("tool.x", "NAME=VALUE"),
            ("tool.x = -3 mm", "positive"),
            ("tool.x = fast", "number"),
            ("tool.x.speed = 1 m/s..2 m/s", "only a position"),
            (" = 3 mm", "name is missing"),
        ] {
            assert!(LimitSetting::parse(bad).unwrap_err().contains(why), "{bad}");
        }
    }

    #[test]
    fn durations_are_whole_periods() {
        let settings = |duration, base_frequency| ExciteSettings {
            duration,
            base_frequency,
            ..ExciteSettings::default()
        };
        assert_eq!(settings(10.0, None).periods().unwrap(), (0.1, 1));
        assert_eq!(settings(6.0, Some(0.5)).periods().unwrap(), (0.5, 3));
        let error = settings(5.0, Some(0.5)).periods().unwrap_err();
        assert!(error.help.contains("4.0") && error.help.contains("6.0"), "{error:?}");
        assert!(settings(0.0, None).periods().is_err());
        // At 0.1 Hz and 5 harmonics, 20 ms are a hundredth of the period of the highest harmonic.
        assert!((settings(10.0, None).sample_step(0.1).unwrap() - 0.02).abs() < 1e-12);
    }
}
