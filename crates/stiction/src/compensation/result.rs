//! Results of a comparison of control laws: numbers, table, JSON and curves.

use super::compensator::{Compensator, Record};
use super::transition::Transition;
use crate::error::Error;
use crate::forward::Run;
use serde_json::{Value, json};
use std::fmt::{self, Write};
use stiction_core::forward::EventKind;
use stiction_run::comparison::Reel;
use stiction_run::compensation::{Controllers, Tracking};
use stiction_run::{SpacePoint, Tracked};

/// Rates below this fraction of the largest reference rate count as rest.
const REST: f64 = 1e-4;

/// Results of a comparison of control laws; see
/// [`Robot::compensation`](crate::Robot::compensation).
#[derive(Clone, Debug)]
pub struct Compared {
    /// Name of the model.
    pub robot: String,
    /// Name of the motion.
    pub motion: String,
    /// Name of the load.
    pub load: String,
    /// Duration of the motion, s.
    pub duration: f64,
    /// Time between samples of the controller, s.
    pub period: f64,
    /// Bandwidth of the position control, Hz.
    pub bandwidth: f64,
    /// Relative accuracy to which the controller knows the friction coefficients.
    pub known_to: f64,
    /// Increment of the encoders, m or rad.
    pub resolution: f64,
    /// Standard deviation of the position noise, m or rad.
    pub noise: f64,
    /// Delay between measurement and effort, s.
    pub delay: f64,
    /// Actuators with the units of their positions and efforts.
    pub actuators: Vec<(String, &'static str, &'static str)>,
    pub(super) tracked: Vec<Tracked>,
    /// Result of each control law.
    pub laws: Vec<LawResult>,
}

/// Result of one control law, simulated with one transition.
#[derive(Clone, Debug)]
pub struct LawResult {
    /// The control law.
    pub law: Compensator,
    /// Compensation of friction at reversals and at rest.
    pub transition: Transition,
    /// Root mean square of the tracking error of each actuator, m or rad.
    pub rms: Vec<f64>,
    /// Largest tracking error of each actuator, m or rad.
    pub peak: Vec<f64>,
    /// Largest effort of each actuator, N or N m.
    pub effort: Vec<f64>,
    /// Largest change of each actuator's effort between two samples, N or N m.
    pub change: Vec<f64>,
    /// Work of all actuators from the start to the end of the simulation, J.
    pub work: f64,
    /// Number of stick onsets of friction interfaces.
    pub sticks: usize,
    /// Number of reversals of actuators beyond those of the reference, due to limit cycles and chatter.
    pub reversals: usize,
    /// Time, s, at which the simulation ended early, and the reason; `None` if it did not end
    /// early.
    pub ended: Option<(f64, String)>,
    /// Time, s, and tracking errors of all samples.
    pub errors: Vec<(f64, Vec<f64>)>,
    pub(super) space: Vec<(f64, Vec<SpacePoint>)>,
    /// Moving robot; `None` without samples.
    reel: Option<Reel>,
}

/// Counts changes of sign between rates whose magnitude exceeds a threshold.
fn reversals(rates: impl Iterator<Item = f64>, threshold: f64) -> usize {
    let (mut last, mut count) = (0.0, 0);
    for rate in rates.filter(|rate| rate.abs() > threshold) {
        if rate * last < 0.0 {
            count += 1;
        }
        last = rate;
    }
    count
}

impl LawResult {
    pub(super) fn new<'a>(
        (law, transition): (Compensator, Transition),
        records: &[Record],
        (run, reel): (&Run, Option<Reel>),
        actuators: impl Iterator<Item = &'a String>,
    ) -> Result<Self, Error> {
        let last = run.last()?;
        let work = actuators.map(|name| last.work(name)).sum::<Result<f64, Error>>()?;
        let count = records.first().map_or(0, |record| record.errors.len());
        let over = |of: &dyn Fn(&Record) -> f64| records.iter().map(of).fold(0.0_f64, f64::max);
        let peak = |k: usize| over(&|record| record.errors[k].abs());
        let rms = |k: usize| {
            let sum: f64 = records.iter().map(|record| record.errors[k].powi(2)).sum();
            (sum / records.len().max(1) as f64).sqrt()
        };
        let change = |k: usize| {
            let steps = records.windows(2).map(|pair| pair[1].efforts[k] - pair[0].efforts[k]);
            steps.fold(0.0_f64, |most, step| most.max(step.abs()))
        };
        let more = |k: usize| {
            let threshold = REST * over(&|record| record.rates[1][k].abs());
            let of = |which: usize| {
                reversals(records.iter().map(|record| record.rates[which][k]), threshold)
            };
            of(0).saturating_sub(of(1))
        };
        let is_onset =
            |event: &&crate::forward::Event| matches!(event.kind, EventKind::Sticks { .. });
        Ok(Self {
            law,
            transition,
            rms: (0..count).map(rms).collect(),
            peak: (0..count).map(peak).collect(),
            effort: (0..count).map(|k| over(&|record| record.efforts[k].abs())).collect(),
            change: (0..count).map(change).collect(),
            work,
            sticks: run.events().iter().filter(is_onset).count(),
            reversals: (0..count).map(more).sum(),
            ended: run.ended().err().map(|error| (last.time, error.message())),
            errors: records.iter().map(|record| (record.time, record.errors.clone())).collect(),
            space: run.samples().iter().map(|at| (at.time, at.space.clone())).collect(),
            reel,
        })
    }
}

impl LawResult {
    /// Name of the law, followed by its transition if `several` is true and the law compensates
    /// friction.
    fn label(&self, several: bool) -> String {
        match several && self.law.has_friction() {
            true => format!("{}, {}", self.law.name(), self.transition),
            false => self.law.name().to_owned(),
        }
    }
}

impl Compared {
    /// True if the laws that compensate friction were simulated with more than one transition.
    fn has_several(&self) -> bool {
        let mut each = self.laws.iter().filter(|own| own.law.has_friction());
        let first = each.next().map(|own| own.transition);
        each.any(|own| Some(own.transition) != first)
    }

    /// Selects the results for the main table and the curves. True for a law without friction
    /// compensation, and for a law that was simulated with the first transition of the comparison.
    fn is_main(&self, own: &LawResult) -> bool {
        let first = self.laws.iter().find(|own| own.law.has_friction()).map(|own| own.transition);
        !own.law.has_friction() || Some(own.transition) == first
    }

    /// Resolution, noise and delay of the sensors as text; `None` for exact sensors without delay.
    fn sensors(&self) -> Option<String> {
        let is_exact = self.resolution == 0.0 && self.noise == 0.0 && self.delay == 0.0;
        (!is_exact).then(|| {
            format!(
                "encoder resolution {}, noise {} (m or rad), delay {}",
                digits(self.resolution),
                digits(self.noise),
                small(self.delay, "s")
            )
        })
    }

    /// Settings and results of the comparison, as the content of a report about control laws.
    pub fn report(&self) -> Controllers {
        let several = self.has_several();
        let tracking = |own: &LawResult| Tracking {
            label: own.label(several),
            is_drawn: self.is_main(own),
            figures: (0..own.rms.len())
                .map(|k| [own.rms[k], own.peak[k], own.effort[k], own.change[k]])
                .collect(),
            work: own.work,
            sticks: own.sticks,
            reversals: own.reversals,
            ended: own.ended.as_ref().map(|(_, why)| why.clone()),
            errors: own.errors.clone(),
            space: own.space.clone(),
            reel: own.reel.clone(),
        };
        let mut headlines = Vec::new();
        for (than, what) in [
            (Compensator::ComputedTorque, "computed torque"),
            (Compensator::ComputedTorqueCoulomb, "computed torque with constant friction"),
        ] {
            if let Some(ratio) = self.ratio(than, Compensator::ComputedTorqueFriction) {
                let small = format!(
                    "rms error of {what}, divided by the rms error with the model's friction"
                );
                headlines.push((digits(ratio), small));
            }
        }
        let sensors = self.sensors().map_or(String::new(), |sensors| format!(", {sensors}"));
        let about = format!(
            "Motion {} ({} s), load {}; controllers every {}, bandwidth {} Hz, friction coefficients known to \
             within {} %{sensors}.",
            self.motion,
            digits(self.duration),
            self.load,
            small(self.period, "s"),
            digits(self.bandwidth),
            digits(100.0 * self.known_to)
        );
        let mut options = self.to_json();
        if let Some(all) = options.as_object_mut() {
            let is_result = |key: &str| key.starts_with("improvement");
            let other = ["model", "actuators", "controllers"];
            all.retain(|key, _| !is_result(key) && !other.contains(&key.as_str()));
        }
        let tracking = self.laws.iter().map(tracking).collect();
        let (actuators, tracked) = (self.actuators.clone(), self.tracked.clone());
        Controllers { about, headlines, actuators, tracked, tracking, options }
    }

    /// Ratio of the rms tracking error of law `of` to that of law `to`: the geometric mean of the
    /// ratios of all actuators. `None` if one of the laws was not simulated, ended early or has no
    /// error.
    pub fn ratio(&self, of: Compensator, to: Compensator) -> Option<f64> {
        let find = |law| self.laws.iter().find(|own| own.law == law && own.ended.is_none());
        let (of, to) = (find(of)?, find(to)?);
        let ratios = of.rms.iter().zip(&to.rms).map(|(of, to)| (of / to).ln());
        let mean = (ratios.sum::<f64>() / of.rms.len() as f64).exp();
        mean.is_finite().then_some(mean)
    }

    /// All results as JSON.
    pub fn to_json(&self) -> Value {
        let law = |own: &LawResult| {
            json!({
                "controller": own.law.name(),
                "transition": own.law.has_friction().then(|| own.transition.to_string()),
                "rms_error": own.rms,
                "peak_error": own.peak,
                "peak_effort": own.effort,
                "peak_effort_change": own.change,
                "work": own.work,
                "stick_onsets": own.sticks,
                "extra_reversals": own.reversals,
                "ended": own.ended.as_ref().map(|(time, why)| json!({ "time": time, "reason": why })),
            })
        };
        let actuator = |(name, unit, effort): &(String, &str, &str)| json!({ "name": name, "unit": unit, "effort_unit": effort });
        json!({
            "model": self.robot,
            "motion": self.motion,
            "load": self.load,
            "duration": self.duration,
            "period": self.period,
            "bandwidth": self.bandwidth,
            "known_to": self.known_to,
            "resolution": self.resolution,
            "noise": self.noise,
            "delay": self.delay,
            "actuators": self.actuators.iter().map(actuator).collect::<Vec<_>>(),
            "controllers": self.laws.iter().map(law).collect::<Vec<_>>(),
            "improvement": self.ratio(Compensator::ComputedTorque, Compensator::ComputedTorqueFriction),
            "improvement_over_constants":
                self.ratio(Compensator::ComputedTorqueCoulomb, Compensator::ComputedTorqueFriction),
        })
    }

    /// Tracking errors of all control laws as functions of time, as CSV.
    pub fn errors_csv(&self) -> String {
        let mut text = "time [s]".to_owned();
        let several = self.has_several();
        for own in &self.laws {
            // A comma would begin another column.
            let label = own.label(several).replace(", ", " ");
            for (name, unit, _) in &self.actuators {
                let _ = write!(text, ",{label}: {name} [{unit}]");
            }
        }
        text.push('\n');
        let longest = self.laws.iter().max_by_key(|own| own.errors.len());
        let times = longest.iter().flat_map(|own| own.errors.iter().map(|(time, _)| *time));
        for (k, time) in times.enumerate() {
            let _ = write!(text, "{time}");
            for own in &self.laws {
                // A simulation that ended early has no more rows.
                match own.errors.get(k) {
                    Some((_, errors)) => {
                        for error in errors {
                            let _ = write!(text, ",{error}");
                        }
                    }
                    None => text.push_str(&",".repeat(self.actuators.len())),
                }
            }
            text.push('\n');
        }
        text
    }
}

impl Compared {
    /// Positions, references and tracking errors of the tracked bodies under all control laws as functions of time, as
    /// CSV; empty if no body is tracked.
    pub fn space_csv(&self) -> String {
        if self.tracked.is_empty() {
            return String::new();
        }
        let mut text = "time [s]".to_owned();
        for own in &self.laws {
            // A comma would begin another column.
            let label = own.label(self.has_several()).replace(", ", " ");
            for tracked in &self.tracked {
                for column in SpacePoint::COLUMNS {
                    let _ = write!(text, ",{label}: {}.{column}", tracked.name);
                }
            }
        }
        text.push('\n');
        let longest = self.laws.iter().max_by_key(|own| own.space.len());
        let times = longest.iter().flat_map(|own| own.space.iter().map(|(time, _)| *time));
        for (k, time) in times.enumerate() {
            let _ = write!(text, "{time}");
            for own in &self.laws {
                // A simulation that ended early has no more rows.
                let Some((_, points)) = own.space.get(k) else {
                    text.push_str(&",".repeat(SpacePoint::COLUMNS.len() * self.tracked.len()));
                    continue;
                };
                for at in points {
                    for value in at.values() {
                        let _ = write!(text, ",{value}");
                    }
                }
            }
            text.push('\n');
        }
        text
    }
}

/// Formats a number with four digits and an SI prefix for thousandths and millionths of the unit.
fn small(value: f64, unit: &str) -> String {
    let size = value.abs();
    let (factor, prefix) = match size {
        s if s >= 1.0 || s == 0.0 => (1.0, ""),
        s if s >= 1e-3 => (1e3, "m"),
        _ => (1e6, "u"),
    };
    format!("{} {prefix}{unit}", digits(value * factor))
}

/// Formats a number with four significant digits, without an exponent between 1e-3 and 1e6.
fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !(1e-3..1e6).contains(&size) {
        return if size == 0.0 { "0".to_owned() } else { format!("{value:.3e}") };
    }
    let places = (3 - size.log10().floor() as i32).max(0) as usize;
    format!("{value:.places$}")
}

impl Compared {
    /// Writes the table that compares the transitions.
    fn write_transitions(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<25} {:<10} {:<12} {:>11} {:>20} {:>9}",
            "at reversals", "", "actuator", "rms error", "effort change/sample", "reversals"
        )?;
        for own in self.laws.iter().filter(|own| own.law.has_friction()) {
            for (k, (name, unit, _)) in self.actuators.iter().enumerate() {
                let first = |text: String| if k == 0 { text } else { String::new() };
                let shown: String = name.chars().take(12).collect();
                let value = |all: &[f64]| all.get(k).copied();
                let rms = value(&own.rms).map_or("-".to_owned(), |rms| small(rms, unit));
                let change = value(&own.change).map_or("-".to_owned(), digits);
                let (law, transition) =
                    (first(own.law.name().to_owned()), first(own.transition.to_string()));
                let reversals = first(own.reversals.to_string());
                let line = format!(
                    "{law:<25} {transition:<10} {shown:<12} {rms:>11} {change:>20} {reversals:>9}"
                );
                writeln!(f, "{}", line.trim_end())?;
            }
        }
        writeln!(f)
    }
}

impl fmt::Display for Compared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { robot, motion, duration, load, .. } = self;
        writeln!(f, "{robot}: motion {motion} ({} s), load {load}", digits(*duration))?;
        writeln!(
            f,
            "controller every {}, bandwidth {} Hz, friction coefficients known to within {} %",
            small(self.period, "s"),
            digits(self.bandwidth),
            digits(100.0 * self.known_to)
        )?;
        if let Some(sensors) = self.sensors() {
            writeln!(f, "{sensors}")?;
        }
        writeln!(f)?;
        writeln!(
            f,
            "{:<25} {:<12} {:>11} {:>11} {:>9} {:>8} {:>6} {:>9}",
            "controller",
            "actuator",
            "rms error",
            "peak error",
            "effort",
            "work/J",
            "sticks",
            "reversals"
        )?;
        let several = self.has_several();
        for own in self.laws.iter().filter(|own| self.is_main(own)) {
            for (k, (name, unit, _)) in self.actuators.iter().enumerate() {
                let law = if k == 0 { own.law.name() } else { "" };
                let shown: String = name.chars().take(12).collect();
                let value = |all: &[f64], unit: &str| {
                    all.get(k).map_or("-".to_owned(), |value| small(*value, unit))
                };
                let effort_value = own.effort.get(k).map_or("-".to_owned(), |value| digits(*value));
                write!(
                    f,
                    "{law:<25} {shown:<12} {:>11} {:>11} {effort_value:>9}",
                    value(&own.rms, unit),
                    value(&own.peak, unit)
                )?;
                match k {
                    0 => writeln!(
                        f,
                        " {:>8} {:>6} {:>9}",
                        digits(own.work),
                        own.sticks,
                        own.reversals
                    )?,
                    _ => writeln!(f)?,
                }
            }
            if let Some((time, why)) = &own.ended {
                writeln!(f, "  ended at {} s: {why}", digits(*time))?;
            }
        }
        writeln!(f)?;
        if several {
            self.write_transitions(f)?;
        }
        let mut say = |to: Compensator, other: &str| {
            let Some(ratio) = self.ratio(to, Compensator::ComputedTorqueFriction) else {
                return Ok(());
            };
            let (times, word) =
                if ratio < 1.0 { (1.0 / ratio, "larger") } else { (ratio, "smaller") };
            writeln!(
                f,
                "rms error with the model's friction: {} times {word} than with",
                digits(times)
            )?;
            writeln!(f, "  {other}")
        };
        say(Compensator::ComputedTorque, "computed torque without compensation")?;
        say(
            Compensator::ComputedTorqueCoulomb,
            "computed torque with the best constant friction of each actuator",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reversals_ignore_rest() {
        assert_eq!(reversals([1.0, 0.0, -1.0, 1e-9, -2.0, 3.0].into_iter(), 1e-6), 2);
        assert_eq!(reversals([].into_iter(), 0.0), 0);
    }

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!(small(0.001_234_56, "m"), "1.235 mm");
        assert_eq!(small(1.5e-5, "rad"), "15.00 urad");
        assert_eq!(small(0.0, "m"), "0 m");
        assert_eq!(digits(123_456.0), "123456");
        assert_eq!(digits(-0.5), "-0.5000");
    }
}
