//! Excursions of a motion beyond the ranges of joints and the strokes of gas springs.

use serde_json::{Value, json};
use std::f64::consts::TAU;
use stiction_core::joint::JointType;
use stiction_core::kinematics::Bodies;
use stiction_core::mechanism::{JointId, Mechanism, RangeOf};
use stiction_core::spatial::Vec3;
use stiction_draw::numbers::number;

/// Largest number of excursions that are stored for each range; further excursions are only
/// counted.
const KEPT: usize = 1000;
/// An excess over a range counts as a rounding error if it is at most this fraction of the width of
/// the range.
const ROUNDING: f64 = 1e-9;

/// Value of a quantity, rad or m, and its rate, rad/s or m/s; `None` if the rate is unknown.
pub(crate) type ValueAndRate = (f64, Option<f64>);

/// Quantity for which the model declares a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ranged {
    /// Joint coordinate, given by the joint and the index of the degree of freedom in this joint.
    Dof(JointId, usize),
    /// Quantity computed from the poses of the bodies.
    Measured(Measured),
}

/// Quantity with a declared range that is not a joint coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Measured {
    /// Tilt of a joint.
    Tilt(JointId, JointType),
    /// Length of a gas spring, given by the indices of two bodies and the end of the spring on each
    /// body, in the frame of the body, m.
    Length([usize; 2], [Vec3<f64>; 2]),
}

impl Measured {
    /// Lists all quantities of a mechanism that have a range, with their names, SI units and ranges.
    pub(crate) fn all(mechanism: &Mechanism) -> Vec<(Self, String, &'static str, (f64, f64))> {
        let tilts = mechanism.joints().iter().enumerate().flat_map(|(index, joint)| {
            let tilts = joint.ranges.iter().filter(|range| range.of == RangeOf::Tilt);
            tilts.map(move |range| {
                let tilt = Self::Tilt(JointId(index), joint.joint_type);
                (tilt, joint.range_name(RangeOf::Tilt), "rad", range.limits)
            })
        });
        let lengths = mechanism.springs().iter().filter_map(|spring| {
            let length = Self::Length(spring.ends.map(|body| body.0), spring.points);
            Some((length, format!("{}.length", spring.name), "m", spring.lengths?))
        });
        tilts.chain(lengths).collect()
    }

    /// Returns the value of the quantity for given poses of the bodies, rad or m.
    pub(crate) fn value(self, bodies: &Bodies<f64>) -> f64 {
        match self {
            Self::Tilt(joint, joint_type) => {
                match (bodies.frame_j.get(joint.0), bodies.frame_k.get(joint.0)) {
                    (Some(j), Some(k)) => RangeOf::tilt(joint_type, j, k),
                    _ => f64::NAN,
                }
            }
            Self::Length(ends, points) => match ends.map(|body| bodies.pose.get(body)) {
                [Some(a), Some(b)] => (b.apply(points[1]) - a.apply(points[0])).norm(),
                _ => f64::NAN,
            },
        }
    }
}

/// Time interval in which a quantity is outside of its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Excursion {
    /// Time at which the quantity leaves the range, s.
    pub(crate) from: f64,
    /// Time at which the quantity returns to the range, s; the time of the last sample if it does
    /// not return.
    pub(crate) until: f64,
    /// True if the quantity returns to the range.
    pub(crate) returns: bool,
    /// Largest excess over the range, rad or m: at a sample, or between two samples if the quantity
    /// is within its range at both of them.
    pub(crate) beyond: f64,
    /// Time of the largest excess, s.
    pub(crate) time: f64,
    /// True if the quantity is above its range; false if it is below.
    pub(crate) above: bool,
}

/// Range of a quantity, and excursions of the quantity beyond this range along a run.
#[derive(Clone, Debug)]
pub(crate) struct Watched {
    pub(crate) name: String,
    pub(crate) of: Ranged,
    translates: bool,
    pub(crate) limits: (f64, f64),
    least: f64,
    greatest: f64,
    /// Full turns, rad, added to an angle so that its value at the first sample is closest to the
    /// middle of the range; `None` before the first sample.
    turns: Option<f64>,
    last: Option<(f64, ValueAndRate)>,
    pub(crate) excursions: Vec<Excursion>,
    /// Total number of excursions, including those that are not stored.
    count: usize,
    outside: bool,
}

impl Watched {
    fn new(name: String, of: Ranged, translates: bool, limits: (f64, f64)) -> Self {
        Self {
            name,
            of,
            translates,
            limits,
            least: f64::INFINITY,
            greatest: f64::NEG_INFINITY,
            turns: None,
            last: None,
            excursions: Vec::new(),
            count: 0,
            outside: false,
        }
    }

    /// Returns the SI unit of the quantity.
    pub(crate) fn unit(&self) -> &'static str {
        if self.translates { "m" } else { "rad" }
    }

    fn add(&mut self, time: f64, (value, rate): ValueAndRate) {
        let (least, greatest) = self.limits;
        let is_turning = !self.translates && matches!(self.of, Ranged::Dof(..));
        let turns = *self.turns.get_or_insert_with(|| match is_turning {
            true => TAU * ((0.5 * (least + greatest) - value) / TAU).round(),
            false => 0.0,
        });
        let value = value + turns;
        (self.least, self.greatest) = (self.least.min(value), self.greatest.max(value));
        let allowed = ROUNDING * (greatest - least);
        let (below, above) = (least - value, value - greatest);
        let beyond = below.max(above);
        let is_outside = beyond > allowed;
        let limit = if above > below { greatest } else { least };
        match (self.outside, is_outside) {
            (false, true) => {
                let from = self.crossing(time, (value, rate), limit).unwrap_or(time);
                let above = above > below;
                let first = Excursion { from, until: time, returns: false, beyond, time, above };
                self.count += 1;
                if self.excursions.len() < KEPT {
                    self.excursions.push(first);
                }
            }
            (true, true) => {
                if let Some(last) = self.excursions.last_mut().filter(|_| self.count <= KEPT) {
                    last.until = time;
                    if beyond > last.beyond {
                        (last.beyond, last.time) = (beyond, time);
                    }
                }
            }
            (true, false) => {
                let above = self.excursions.last().is_some_and(|last| last.above);
                let limit = if above { greatest } else { least };
                let until = self.crossing(time, (value, rate), limit).unwrap_or(time);
                if let Some(last) = self.excursions.last_mut().filter(|_| self.count <= KEPT) {
                    (last.until, last.returns) = (until, true);
                }
            }
            (false, false) => self.add_between(time, (value, rate)),
        }
        self.outside = is_outside;
        self.last = Some((time, (value, rate)));
    }

    /// Adds an excursion between two samples that are both inside the range, if the cubic through
    /// the values and rates at both samples leaves the range.
    fn add_between(&mut self, time: f64, now: ValueAndRate) {
        let (least, greatest) = self.limits;
        let Some((before, (old, Some(old_rate)))) = self.last else { return };
        let (value, Some(rate)) = now else { return };
        let (h, rise) = (time - before, value - old);
        // The cubic is old + u rise + u (1 - u) (a (1 - u) + b u), where u is the fraction of the
        // step. Its extremes are the roots of the derivative.
        let (a, b) = (old_rate * h - rise, rise - rate * h);
        let at = |u: f64| old + u * rise + u * (1.0 - u) * (a * (1.0 - u) + b * u);
        let (c2, c1, c0) = (3.0 * (a - b), 2.0 * (b - 2.0 * a), rise + a);
        let root = (c1 * c1 - 4.0 * c2 * c0).max(0.0).sqrt();
        // This form of both roots is numerically stable.
        let q = -0.5 * (c1 + root.copysign(c1));
        let extremes = [q / c2, c0 / q].into_iter().filter(|u| *u > 0.0 && *u < 1.0);
        let beyond = |u: f64| (least - at(u)).max(at(u) - greatest);
        let Some(worst) = extremes.max_by(|u, v| beyond(*u).total_cmp(&beyond(*v))) else { return };
        if beyond(worst) <= ROUNDING * (greatest - least) {
            return;
        }
        let above = at(worst) > greatest;
        let limit = if above { greatest } else { least };
        let middle = (before + worst * h, at(worst));
        let slope = Some(0.0);
        let from = self.crossing(middle.0, (middle.1, slope), limit).unwrap_or(before);
        let last = self.last.replace((middle.0, (middle.1, slope)));
        let until = self.crossing(time, now, limit).unwrap_or(time);
        self.last = last;
        (self.least, self.greatest) = (self.least.min(middle.1), self.greatest.max(middle.1));
        self.count += 1;
        if self.excursions.len() < KEPT {
            let beyond = beyond(worst);
            self.excursions.push(Excursion {
                from,
                until,
                returns: true,
                beyond,
                time: middle.0,
                above,
            });
        }
    }

    /// Returns the time, s, at which the quantity crosses `limit` between the last added sample and
    /// the sample at `time`, s; `None` if there is no crossing. The time is interpolated by the
    /// cubic through values and rates, or linearly if the rates are unknown.
    fn crossing(&self, time: f64, (value, rate): ValueAndRate, limit: f64) -> Option<f64> {
        let (before, (old, old_rate)) = self.last?;
        let (h, rise) = (time - before, value - old);
        let rates = old_rate.zip(rate).unwrap_or((rise / h, rise / h));
        let at = |u: f64| {
            let (a, b) = (rates.0 * h - rise, rise - rates.1 * h);
            old + u * rise + u * (1.0 - u) * (a * (1.0 - u) + b * u) - limit
        };
        let (mut low, mut high) = (0.0, 1.0);
        if at(low) * at(high) > 0.0 {
            return None;
        }
        // Bisection of the fraction of the step, to the last digit.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if at(low) * at(middle) <= 0.0 { high = middle } else { low = middle }
        }
        Some(before + 0.5 * (low + high) * h)
    }

    /// Returns the excursion with the largest excess.
    fn worst(&self) -> Option<&Excursion> {
        self.excursions.iter().reduce(|a, b| if b.beyond > a.beyond { b } else { a })
    }

    /// Formats a value in the unit of messages, mm or deg.
    fn in_words(&self, value: f64) -> String {
        match self.translates {
            true => format!("{} mm", number(1e3 * value)),
            false => format!("{} deg", number(value.to_degrees())),
        }
    }

    /// Formats the range, for example `-20 deg to 35 deg`.
    pub(crate) fn limits_in_words(&self) -> String {
        format!("{} to {}", self.in_words(self.limits.0), self.in_words(self.limits.1))
    }

    fn caution(&self) -> Option<String> {
        let worst = self.worst()?;
        let first = self.excursions.first()?;
        let side = if worst.above { "exceeds" } else { "falls below" };
        let range = match self.of {
            Ranged::Measured(Measured::Length(..)) => "stroke",
            _ => "range",
        };
        let mut text = format!(
            "{} {side} its {range} of {} by {} at t = {} s",
            self.name,
            self.limits_in_words(),
            self.in_words(worst.beyond),
            number(worst.time),
        );
        text += &match self.count {
            1 if first.returns => {
                format!("; outside from t = {} to {} s", number(first.from), number(first.until))
            }
            1 => format!("; outside from t = {} s on", number(first.from)),
            n => format!("; outside {n} times, first from t = {} s", number(first.from)),
        };
        Some(text)
    }

    fn json(&self) -> Value {
        let excursions = self.excursions.iter().map(|excursion| {
            json!({
                "from": excursion.from,
                "until": excursion.until,
                "returns": excursion.returns,
                "beyond": excursion.beyond,
                "time": excursion.time,
                "side": if excursion.above { "above" } else { "below" },
            })
        });
        let is_known = self.least <= self.greatest;
        json!({
            "name": self.name,
            "unit": self.unit(),
            "limits": [self.limits.0, self.limits.1],
            "least": is_known.then_some(self.least),
            "greatest": is_known.then_some(self.greatest),
            "excursions": excursions.collect::<Vec<_>>(),
            "count": self.count,
        })
    }
}

/// All ranges of a mechanism, with the excursions along a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ranges {
    pub(crate) all: Vec<Watched>,
}

impl Ranges {
    pub(crate) fn new(mechanism: &Mechanism) -> Self {
        let dofs = mechanism.joints().iter().enumerate().flat_map(|(index, joint)| {
            joint.ranges.iter().filter_map(move |range| {
                let RangeOf::Dof(dof) = range.of else { return None };
                let of = Ranged::Dof(JointId(index), dof);
                let translates = joint.range_translates(range.of);
                Some(Watched::new(joint.range_name(range.of), of, translates, range.limits))
            })
        });
        let measured = Measured::all(mechanism).into_iter().map(|(of, name, unit, limits)| {
            Watched::new(name, Ranged::Measured(of), unit == "m", limits)
        });
        Self { all: dofs.chain(measured).collect() }
    }

    /// Adds a sample. `measured` returns the value of a quantity that is computed from poses; `dof`
    /// returns the coordinate and the rate of a degree of freedom.
    pub(crate) fn add(
        &mut self,
        time: f64,
        measured: impl Fn(Measured) -> f64,
        dof: impl Fn(JointId, usize) -> Option<ValueAndRate>,
    ) {
        for watched in &mut self.all {
            let moment = match watched.of {
                Ranged::Dof(joint, index) => dof(joint, index),
                Ranged::Measured(of) => Some((measured(of), None)),
            };
            if let Some(moment) = moment.filter(|(value, _)| value.is_finite()) {
                watched.add(time, moment);
            }
        }
    }

    /// Describes the excursions beyond the ranges, one sentence for each range.
    pub(crate) fn cautions(&self) -> impl Iterator<Item = String> + '_ {
        self.all.iter().filter_map(Watched::caution)
    }

    /// Returns all ranges with their excursions as JSON.
    pub(crate) fn json(&self) -> Value {
        Value::Array(self.all.iter().map(Watched::json).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watched(limits: (f64, f64)) -> Watched {
        Watched::new("J".to_owned(), Ranged::Dof(JointId(0), 0), false, limits)
    }

    /// Checks that the excursion of a sine beyond a range of +-0.5 begins at 30 deg and ends at 150
    /// deg.
    #[test]
    fn excursions_are_located() {
        let mut joint = watched((-0.5, 0.5));
        for k in 0..=400 {
            let t = 0.01 * k as f64;
            joint.add(t, (t.sin(), Some(t.cos())));
        }
        let [first, second] = joint.excursions.as_slice() else { panic!("{joint:?}") };
        let sixth = std::f64::consts::PI / 6.0;
        // The error of the cubic through values and rates is h^4/384.
        assert!((first.from - sixth).abs() < 1e-10, "{first:?}");
        assert!((first.until - 5.0 * sixth).abs() < 1e-10, "{first:?}");
        assert!((first.beyond - 0.5).abs() < 1e-4 && first.above && first.returns);
        assert!((second.from - 7.0 * sixth).abs() < 1e-10 && !second.returns && !second.above);
        let caution = joint.caution().unwrap();
        assert!(caution.starts_with("J exceeds its range of -28.65 deg to 28.65 deg by 28.65 deg"));
    }

    /// Checks that an excursion between two samples is found: with q = 1 - (t - 0.05)^2, the
    /// quantity exceeds 0.9999 within 10 ms around 50 ms.
    #[test]
    fn excursions_between_samples_are_seen() {
        let mut joint = watched((0.0, 0.9999));
        for t in [0.0, 0.1, 0.2] {
            let off: f64 = t - 0.05;
            joint.add(t, (1.0 - off * off, Some(-2.0 * off)));
        }
        let [only] = joint.excursions.as_slice() else { panic!("{joint:?}") };
        assert!((only.beyond - 1e-4).abs() < 1e-12 && (only.time - 0.05).abs() < 1e-12, "{only:?}");
        assert!((only.from - 0.04).abs() < 1e-9 && (only.until - 0.06).abs() < 1e-9, "{only:?}");
        assert!(only.above && only.returns && joint.count == 1);
    }

    /// Tests that a range beyond half a turn also applies to angles that are counted from -180 to
    /// 180 deg.
    #[test]
    fn angles_count_from_the_turn_of_the_range() {
        let mut joint = watched((3.0, 4.0));
        joint.add(0.0, (3.5 - TAU, Some(0.0)));
        joint.add(1.0, (4.1 - TAU, Some(0.0)));
        assert_eq!(joint.excursions.len(), 1);
        assert!((joint.excursions[0].beyond - 0.1).abs() < 1e-12);
    }
}
