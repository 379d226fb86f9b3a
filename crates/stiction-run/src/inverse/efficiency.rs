//! Efficiency: the fraction of the work that is transmitted while the actuators drive the load, or
//! while the load back-drives the actuators.
//!
//! The definition is equation (E3) of the book's theory.

use crate::names::{Names, listed};
use crate::statistics::Least;
use serde_json::{Map, Value, json};
use std::fmt::{self, Write};
use stiction_core::dynamics::{AppliedLoad, Forces, InverseDynamics, InverseError, Mirror};
use stiction_draw::numbers::{number, percent};

/// Powers below this fraction of the exchanged power count as rounding errors. The same fraction
/// applies to work.
const ROUNDING: f64 = 1e-9;
/// Largest number of actuators that the text summary names.
const NAMED: usize = 3;

/// Result of back-driving one actuator at one pose, in the direction of motion in which the load
/// can drive it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Backward {
    /// The load drives the actuator in neither direction of motion.
    Undriven,
    /// The load drives the actuator; friction dissipates some of the power.
    Driven {
        /// Power that the actuator would absorb without friction, W; positive.
        given: f64,
        /// Power that the actuator absorbs with friction, W. If this power is not positive, the
        /// load alone cannot back-drive the actuator.
        left: f64,
    },
    /// Friction jams the mechanism in the direction in which the load could drive the actuator,
    /// regardless of the efforts.
    Locked,
    /// The forces in the direction in which the load could drive the actuator could not be
    /// computed.
    Unknown,
}

/// Evaluates back-driving at the pose of a solved mechanism, in the direction of motion and in the
/// opposite direction. For the opposite direction, only the rates are reversed; loads and
/// accelerations are unchanged.
pub(super) fn evaluate_back_driving(
    solver: &mut InverseDynamics,
    mirror: &mut Mirror,
    loads: &[AppliedLoad<f64>],
    backward: &mut Vec<Backward>,
) {
    let powers = |solver: &InverseDynamics, efforts: &[f64], sense: f64| -> Vec<(f64, f64)> {
        let drives = solver.forces().efforts_frictionless.iter().zip(efforts);
        let at_rates = drives.zip(solver.actuator_rates().map(|rate| sense * rate));
        // Power absorbed by the actuator.
        at_rates.map(|((without, with), rate)| (-without * rate, -with * rate)).collect()
    };
    let forces = solver.forces();
    let rounding = ROUNDING * forces.power.turnover;
    let driven = |(given, left): (f64, f64)| {
        if given > rounding { Backward::Driven { given, left } } else { Backward::Undriven }
    };
    let ahead = powers(solver, &forces.efforts, 1.0);
    backward.clear();
    backward.extend(ahead.iter().copied().map(driven));
    // If an actuator delivers power in the motion without friction, the load drives this actuator
    // in the reversed motion.
    let works = |(given, _): &(f64, f64)| *given < -rounding;
    if !ahead.iter().any(works) {
        return;
    }
    let back = match solver.reversed_efforts() {
        Some(efforts) => Ok(powers(solver, &efforts, -1.0)),
        None => {
            let mirror = mirror.of(solver);
            match mirror.solve(loads) {
                Ok(forces) => {
                    let efforts = forces.efforts.clone();
                    Ok(powers(mirror, &efforts, 1.0))
                }
                Err(error) => Err(error),
            }
        }
    };
    for (k, backward) in backward.iter_mut().enumerate().filter(|(k, _)| works(&ahead[*k])) {
        *backward = match &back {
            Ok(powers) => driven(powers[k]),
            Err(InverseError::Locked { .. }) => Backward::Locked,
            Err(_) => Backward::Unknown,
        };
    }
}

/// Results of back-driving for one actuator along a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct BackDriving {
    /// Number of samples at which the load could drive the actuator, in one of both directions of
    /// motion, if there were no friction.
    samples: usize,
    /// Number of samples at which the load could drive the actuator without friction, but friction
    /// dissipates all power of the load or jams the mechanism.
    stopped: usize,
    /// Number of samples at which the result of back-driving is unknown.
    unknown: usize,
    least: Least,
    given: f64,
    left: f64,
}

impl BackDriving {
    fn add(&mut self, time: f64, backward: Backward) {
        match backward {
            Backward::Undriven => {}
            Backward::Unknown => self.unknown += 1,
            Backward::Locked => {
                self.samples += 1;
                self.stopped += 1;
                self.least.add(time, 0.0);
            }
            Backward::Driven { given, left } => {
                self.samples += 1;
                self.stopped += usize::from(left <= 0.0);
                self.given += given;
                self.left += left.max(0.0);
                self.least.add(time, left.max(0.0) / given);
            }
        }
    }

    fn json(&self) -> Value {
        let is_driven = self.samples > 0;
        json!({
            "samples": self.samples,
            "samples_not_back_driven": self.stopped,
            "samples_not_known": self.unknown,
            "least": is_driven.then_some(self.least.value),
            "time_of_least": is_driven.then_some(self.least.time),
            "mean": (self.given > 0.0).then(|| self.left / self.given),
        })
    }
}

/// Efficiencies along a motion.
#[derive(Clone, Debug)]
pub(super) struct Efficiency {
    last: Option<Powers>,
    samples: usize,
    /// Work of all actuators during the time in which their total power is positive, J.
    delivered: f64,
    /// Energy dissipated during the time in which the total power of the actuators is positive, J.
    dissipated: f64,
    turnover: f64,
    backward: Vec<BackDriving>,
}

#[derive(Clone, Copy, Debug)]
struct Powers {
    time: f64,
    drives: f64,
    dissipated: f64,
    turnover: f64,
}

impl Efficiency {
    pub(super) fn new(drives: usize) -> Self {
        Self {
            last: None,
            samples: 0,
            delivered: 0.0,
            dissipated: 0.0,
            turnover: 0.0,
            backward: vec![BackDriving::default(); drives],
        }
    }

    pub(super) fn add(&mut self, time: f64, forces: &Forces, backward: &[Backward]) {
        for (sum, backward) in self.backward.iter_mut().zip(backward) {
            sum.add(time, *backward);
        }
        let power = &forces.power;
        let (drives, dissipated, turnover) = (power.actuators, power.dissipated, power.turnover);
        let now = Powers { time, drives, dissipated, turnover };
        if let Some(last) = self.last.replace(now) {
            self.integrate(&last, &now);
        }
        self.samples += 1;
    }

    /// Adds the work between two samples by the trapezoidal rule. Delivered work and dissipated
    /// energy are integrated only over the part of the step in which the total power of the
    /// actuators is positive.
    fn integrate(&mut self, a: &Powers, b: &Powers) {
        let step = b.time - a.time;
        self.turnover += 0.5 * (a.turnover + b.turnover) * step;
        // Time at which the linear interpolation of the power between the samples vanishes, as a
        // fraction of the step.
        let zero = || a.drives / (a.drives - b.drives);
        let (from, to) = match (a.drives > 0.0, b.drives > 0.0) {
            (true, true) => (0.0, 1.0),
            (true, false) => (0.0, zero()),
            (false, true) => (zero(), 1.0),
            (false, false) => return,
        };
        let amid = 0.5 * (from + to);
        let duration = (to - from) * step;
        self.delivered += (a.drives + (b.drives - a.drives) * amid) * duration;
        self.dissipated += (a.dissipated + (b.dissipated - a.dissipated) * amid) * duration;
    }

    /// Returns the fraction of the actuators' work that is not dissipated; `None` if they deliver
    /// no work. If the motion has only one sample, returns the fraction of their power instead.
    pub(super) fn forward(&self) -> Option<f64> {
        let (delivered, dissipated, turnover) = match (self.samples, self.last) {
            (1, Some(only)) => (only.drives, only.dissipated, only.turnover),
            _ => (self.delivered, self.dissipated, self.turnover),
        };
        // If the load assists and friction dissipates everything, the transmitted work is zero.
        (delivered > ROUNDING * turnover).then(|| (1.0 - dissipated / delivered).max(0.0))
    }

    pub(super) fn json(&self, names: &Names) -> Value {
        let each = names.drives.iter().zip(&self.backward);
        let backward: Map<String, Value> =
            each.map(|((name, _), backward)| (name.clone(), backward.json())).collect();
        json!({ "forward": self.forward(), "backward": backward })
    }

    /// Writes the efficiencies in one line; writes nothing if there is no result.
    pub(super) fn write(&self, out: &mut impl Write, names: &Names) -> fmt::Result {
        let forward = self.forward().map(|part| format!("forward {}", percent(Some(part))));
        let pairs = || names.drives.iter().map(|(name, _)| name).zip(&self.backward);
        let mut stopped: Vec<_> = pairs().filter(|(_, back)| back.stopped > 0).collect();
        let worst = pairs().filter(|(_, back)| back.samples > 0);
        let worst = worst.min_by(|a, b| a.1.least.value.total_cmp(&b.1.least.value));
        let backward = if stopped.is_empty() {
            worst.map(|(name, back)| {
                let (part, time) = (percent(Some(back.least.value)), number(back.least.time));
                format!("backward at least {part} ({name} at t = {time} s)")
            })
        } else {
            // The list begins with the actuators for which friction most often dissipates all
            // power.
            stopped.sort_by_key(|(_, back)| std::cmp::Reverse(back.stopped));
            let words = stopped.iter().enumerate().map(|(k, (name, back))| {
                let unit = if k == 0 { " samples" } else { "" };
                format!("{name} at {} of {}{unit}", back.stopped, back.samples)
            });
            Some(format!("cannot be back-driven by the load: {}", listed(words, NAMED)))
        };
        let words: Vec<String> = forward.into_iter().chain(backward).collect();
        if words.is_empty() {
            return Ok(());
        }
        writeln!(out, "efficiency: {}", words.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that work counts only while the actuators deliver power. Their power is `2 - t`
    /// watts, which is positive for the first two seconds, and 0.1 W is dissipated.
    #[test]
    fn only_work_that_is_delivered_counts() {
        let mut efficiency = Efficiency::new(0);
        let at = |time: f64| Powers { time, drives: 2.0 - time, dissipated: 0.1, turnover: 1.0 };
        // The power of the actuators changes its sign within a step.
        for (a, b) in [(0.0, 1.5), (1.5, 3.0), (3.0, 4.0)] {
            efficiency.integrate(&at(a), &at(b));
        }
        assert!((efficiency.delivered - 2.0).abs() < 1e-15);
        assert!((efficiency.dissipated - 0.2).abs() < 1e-15);
        assert!((efficiency.forward().unwrap() - 0.9).abs() < 1e-15);
    }

    #[test]
    fn absorbing_actuators_have_no_efficiency() {
        let mut efficiency = Efficiency::new(0);
        let at = |time: f64| Powers { time, drives: -1.0, dissipated: 0.1, turnover: 1.0 };
        efficiency.integrate(&at(0.0), &at(1.0));
        assert_eq!(efficiency.forward(), None);
    }

    #[test]
    fn fully_dissipated_power_is_not_back_driven() {
        let mut back = BackDriving::default();
        back.add(0.0, Backward::Driven { given: 2.0, left: 1.0 });
        back.add(1.0, Backward::Driven { given: 2.0, left: -1.0 });
        back.add(2.0, Backward::Locked);
        back.add(3.0, Backward::Undriven);
        back.add(4.0, Backward::Unknown);
        assert_eq!((back.samples, back.stopped, back.unknown), (3, 2, 1));
        assert_eq!((back.least.value, back.least.time), (0.0, 1.0));
        assert_eq!((back.given, back.left), (4.0, 1.0));
    }
}
