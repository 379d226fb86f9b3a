//! Headline figures, which are single numbers such as the peak of an effort.

use crate::motor_load::MotorLoad;
use crate::statistics::Size;
use stiction_core::mechanism::DriveTrain;

/// Headline figure of a run: a single number, such as the peak of an effort.
#[derive(Clone, Debug, PartialEq)]
pub struct Headline {
    /// Name of the headline figure. Figures of different runs are compared if their names and units
    /// are the same.
    pub name: String,
    /// SI unit of the figure.
    pub unit: &'static str,
    /// Value of the figure in SI units.
    pub value: f64,
    /// Time at which the value occurs, s; `None` for a value that belongs to the whole run.
    pub time: Option<f64>,
    /// Magnitude of the terms whose sum is `value`. A value far smaller than `scale` is a rounding
    /// error.
    pub scale: f64,
    /// True if the least value is the worst, as for singularity indices; false if the greatest
    /// value is the worst.
    pub least_is_worst: bool,
}

impl Headline {
    /// Creates a headline figure whose greatest value is the worst. The last argument contains the
    /// time at which the value occurs, s, and the magnitude of the terms whose sum is the value.
    pub(crate) fn new(
        name: String,
        unit: &'static str,
        value: f64,
        (time, scale): (Option<f64>, f64),
    ) -> Self {
        Self { name, unit, value, time, scale, least_is_worst: false }
    }

    /// Returns the value as shown to readers: zero if the value is smaller than its rounding error.
    pub(super) fn shown(&self) -> f64 {
        // Relative error of a sum after several thousand roundings of its terms.
        const ROUNDING: f64 = 1e-12;
        if self.value.abs() < ROUNDING * self.scale { 0.0 } else { self.value }
    }
}

/// Returns the headline figures of each motor: torque, speed and power, and how much of each of its
/// limits the motor uses, in percent.
pub(crate) fn motor_headlines<'a>(
    motors: impl Iterator<Item = (&'a DriveTrain, &'a MotorLoad)>,
) -> impl Iterator<Item = Headline> {
    motors.flat_map(|(train, load)| {
        let name = &train.name;
        let (torque, speed, power) = (&load.torque, &load.speed, &load.power);
        let peak = |what: &str, unit, size: &Size| {
            let at = (Some(size.peak_time), size.peak.abs());
            Headline::new(format!("{name} {what}, peak"), unit, size.peak.abs(), at)
        };
        let rms = load.rms();
        let mut all = vec![
            peak("motor torque", "N m", torque),
            Headline::new(
                format!("{name} motor torque, rms"),
                "N m",
                rms,
                (None, torque.peak.abs()),
            ),
            peak("motor speed", "rad/s", speed),
            peak("motor power", "W", power),
        ];
        all.extend(load.percents(train).map(|(words, percent)| {
            Headline::new(format!("{name} of {words}"), "%", percent, (None, 100.0))
        }));
        all
    })
}
