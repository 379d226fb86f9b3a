//! Torque, speed and power of a motor over time, and the utilisation of its limits.

use crate::statistics::{Integral, Size};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use stiction_core::mechanism::DriveTrain;
use stiction_draw::numbers::number;

/// Multiple of a limit above which the limit counts as exceeded. A smaller excess is a rounding
/// error.
const WITHIN: f64 = 1.0 + 1e-9;

/// Statistics of the torque, speed and power of one motor along a motion.
#[derive(Clone, Debug, Default)]
pub(crate) struct MotorLoad {
    pub(crate) torque: Size,
    pub(crate) speed: Size,
    pub(crate) power: Size,
    squares: Integral,
    pub(crate) work: Integral,
    pub(crate) supplied: Integral,
    /// Time, s, that the motor spends at speeds of each order of magnitude.
    speeds: Speeds,
}

/// Speed, as a fraction of the peak speed, below which a motor counts as being at rest. A sticking
/// axis in a simulation keeps a rate due to rounding.
const STILL: f64 = 1e-9;

/// Time that a motor spends at speeds of each order of magnitude. The least speed at which a motor
/// counts as turning depends on the peak speed, which is known only at the end of the motion.
#[derive(Clone, Debug, Default)]
struct Speeds {
    last: Option<(f64, i32)>,
    /// Time, s, for each power of ten of the speed in rad/s.
    times: BTreeMap<i32, f64>,
}

impl Speeds {
    fn add(&mut self, time: f64, speed: f64) {
        // A speed of zero has the least order, `i32::MIN`.
        let order = speed.abs().log10().floor() as i32;
        if let Some((before, last)) = self.last {
            let half = 0.5 * (time - before);
            *self.times.entry(last).or_default() += half;
            *self.times.entry(order).or_default() += half;
        }
        self.last = Some((time, order));
    }

    /// Returns the fraction of the time at speeds of the same order of magnitude as `limit`, rad/s,
    /// or above.
    fn part_above(&self, limit: f64) -> f64 {
        let least = limit.log10().floor() as i32;
        let turns = |order: i32| order > i32::MIN && order >= least;
        let all: f64 = self.times.values().sum();
        if all > 0.0 {
            let above: f64 =
                self.times.iter().filter(|(order, _)| turns(**order)).map(|(_, t)| t).sum();
            above / all
        } else {
            self.last.map_or(0.0, |(_, order)| f64::from(u8::from(turns(order))))
        }
    }
}

/// Limit of a motor, and the value that the limited quantity attains along the motion.
struct Reached {
    key: &'static str,
    words: &'static str,
    unit: &'static str,
    limit: f64,
    value: f64,
}

impl MotorLoad {
    /// Adds a sample at a time, s, with torque, N m, and speed, rad/s.
    pub(crate) fn add(&mut self, time: f64, torque: f64, speed: f64) {
        let power = torque * speed;
        self.torque.add(time, torque);
        self.speed.add(time, speed);
        self.power.add(time, power);
        self.squares.add(time, torque * torque);
        self.work.add(time, power);
        self.supplied.add(time, power.max(0.0));
        self.speeds.add(time, speed);
    }

    /// Returns the root mean square of the torque over time, N m.
    pub(crate) fn rms(&self) -> f64 {
        self.squares.mean().sqrt()
    }

    /// Returns the fraction of the time in which the motor turns. A motor turns if its speed
    /// exceeds the rounding error of the peak speed.
    pub(crate) fn duty(&self) -> f64 {
        self.speeds.part_above(STILL * self.speed.peak.abs())
    }

    /// Returns the declared limits of the motor, each with the value that the limited quantity
    /// attains along the motion.
    fn reached(&self, train: &DriveTrain) -> Vec<Reached> {
        let limits = train.limits;
        let all = [
            ("rated", "rated rms torque", "N m", limits.rated, self.rms()),
            ("peak", "peak torque", "N m", limits.peak, self.torque.peak.abs()),
            ("speed", "speed limit", "rad/s", limits.speed, self.speed.peak.abs()),
        ];
        let given = |(key, words, unit, limit, value)| {
            Option::map(limit, |limit| Reached { key, words, unit, limit, value })
        };
        all.into_iter().filter_map(given).collect()
    }

    /// Returns a caution for each limit that is exceeded.
    pub(crate) fn cautions(&self, train: &DriveTrain) -> Vec<String> {
        let over = self.reached(train).into_iter().filter(Reached::is_exceeded);
        let line = |Reached { words, unit, limit, value, .. }: Reached| {
            let (percent, value, limit) = (excess(value / limit), number(value), number(limit));
            format!("{}: {percent} of {words} ({value} of {limit} {unit})", train.name)
        };
        over.map(line).collect()
    }

    /// Returns the name and the utilisation, percent, of each limit.
    pub(crate) fn percents(
        &self,
        train: &DriveTrain,
    ) -> impl Iterator<Item = (&'static str, f64)> + use<> {
        let reached = self.reached(train).into_iter();
        reached.map(|reached| (reached.words, 100.0 * reached.value / reached.limit))
    }

    /// Returns the limits and the attained values as JSON.
    pub(crate) fn limits_json(&self, train: &DriveTrain) -> Value {
        let entry = |reached: Reached| {
            let exceeded = reached.is_exceeded();
            let Reached { key, unit, limit, value, .. } = reached;
            let entry =
                json!({ "unit": unit, "limit": limit, "reached": value, "exceeded": exceeded });
            (key.to_owned(), entry)
        };
        Value::Object(self.reached(train).into_iter().map(entry).collect::<Map<_, _>>())
    }

    /// Returns torque, speed, current, power and work as JSON.
    pub(crate) fn json(&self, train: &DriveTrain) -> Map<String, Value> {
        let size = |size: &Size, unit: &str, rms: f64| json!({ "unit": unit, "peak": size.peak, "peak_time": size.peak_time, "rms": rms });
        let rms = self.rms();
        let current = train.torque_constant.map(|constant| {
            json!({
                "unit": "A",
                "peak": self.torque.peak / constant,
                "peak_time": self.torque.peak_time,
                "rms": rms / constant,
            })
        });
        let entries = [
            ("motor_torque", size(&self.torque, "N m", rms)),
            ("motor_speed", size(&self.speed, "rad/s", self.speed.rms())),
            ("current", json!(current)),
            ("motor_power", size(&self.power, "W", self.power.rms())),
            ("work", json!(self.work.value)),
            ("work_supplied", json!(self.supplied.value)),
            ("work_returned", json!(self.supplied.value - self.work.value)),
            ("duty", json!(self.duty())),
            ("limits", self.limits_json(train)),
        ];
        entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
    }
}

impl Reached {
    fn is_exceeded(&self) -> bool {
        self.value > self.limit * WITHIN
    }
}

/// Formats a ratio above one in percent, with enough decimals to show more than 100.
fn excess(ratio: f64) -> String {
    let shown = |digits: usize| format!("{:.digits$}", ratio * 100.0);
    let clear = |text: &String| text.parse::<f64>().is_ok_and(|shown| shown > 100.0);
    format!("{} %", (0..6).map(shown).find(clear).unwrap_or_else(|| shown(6)))
}

#[cfg(test)]
mod tests {
    use super::{MotorLoad, excess};

    /// Checks that a motor counts as being at rest while its rate is only a rounding error. The
    /// motor turns half of the time.
    #[test]
    fn rounding_is_standstill() {
        let mut load = MotorLoad::default();
        for k in 0..=1000 {
            let turns = k <= 500;
            load.add(0.001 * f64::from(k), 1.0, if turns { 20.0 } else { 3e-13 });
        }
        assert!((load.duty() - 0.5).abs() < 1e-3, "{}", load.duty());
        let mut still = MotorLoad::default();
        still.add(0.0, 1.0, 0.0);
        assert_eq!(still.duty(), 0.0);
        still.add(1.0, 1.0, 0.0);
        assert_eq!(still.duty(), 0.0);
        let mut turns = MotorLoad::default();
        turns.add(0.0, 1.0, 0.1);
        assert_eq!(turns.duty(), 1.0);
    }

    #[test]
    fn exceeded_limits_are_above_100_percent() {
        assert_eq!(excess(1.1238), "112 %");
        assert_eq!(excess(1.0004), "100.04 %");
    }
}
