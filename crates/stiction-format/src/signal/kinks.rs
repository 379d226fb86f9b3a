//! Jumps of the rate of a formula, at kinks of its value.

use super::{Shape, Signal};
use stiction_core::kinematics::Target;

/// Change of the rate, relative to the greatest rate, below which a change is not reported. The
/// continuous rate of `abs(t)^1.5` changes by less within [`WIDTH`].
const RELATIVE: f64 = 1e-3;
/// Duration of the interval, relative to the greatest time, within which a change is a jump.
const WIDTH: f64 = 1e-9;
/// Duration, relative to the greatest time, that an interval may have if the formula has no finite
/// value inside it.
const WIDEST: f64 = 1e-6;
/// Largest number of intervals that are inspected.
const INTERVALS: usize = 20_000;

/// Jump of the rate of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RateJump {
    /// Time of the jump, s.
    pub(crate) time: f64,
    /// Rate before the jump, in SI units.
    pub(crate) before: f64,
    /// Rate after the jump, in SI units.
    pub(crate) after: f64,
}

impl Signal {
    /// Finds the jumps of the rate of a formula from `start` to `start + duration`, s, in order of
    /// time. `step` is the longest time between the inspected instants, s. Other signals have no
    /// jumps, because their rates are continuous.
    pub(crate) fn rate_jumps(&self, start: f64, duration: f64, step: f64) -> Vec<RateJump> {
        match &self.shape {
            Shape::Formula(written) if written.formula.may_have_kinks() => {}
            _ => return Vec::new(),
        }
        let end = start + duration;
        let mut instants = vec![(start, self.at(start))];
        let mut time = start;
        while time < end && instants.len() < INTERVALS {
            time = (time + step).min(self.resolved_until(time)).min(end);
            instants.push((time, self.at(time)));
        }
        let rates = instants.iter().map(|(_, target)| target.rate.abs());
        let fastest = rates.filter(|rate| rate.is_finite()).fold(0.0, f64::max);
        let scale = start.abs().max(end.abs());
        let pairs = instants.windows(2).filter_map(|pair| match pair {
            [a, b] => self.jump_between(*a, *b, RELATIVE * fastest, scale),
            _ => None,
        });
        pairs.collect()
    }

    /// Finds the jump of the rate between two instants by bisection; `None` if the rate changes by
    /// less than `tolerance`, apart from the change that the accelerations explain. `scale` is the
    /// greatest time, s.
    fn jump_between(
        &self,
        mut from: (f64, Target<f64>),
        mut to: (f64, Target<f64>),
        tolerance: f64,
        scale: f64,
    ) -> Option<RateJump> {
        while excess(from, to) > tolerance {
            let middle = 0.5 * (from.0 + to.0);
            let at_middle = (middle, self.at(middle));
            let width = to.0 - from.0;
            let is_finite = at_middle.1.rate.is_finite() && at_middle.1.acceleration.is_finite();
            let widest = if is_finite { WIDTH } else { WIDEST };
            if width <= widest * scale || middle <= from.0 || middle >= to.0 {
                let (before, after) = (from.1.rate, to.1.rate);
                return Some(RateJump { time: to.0, before, after });
            }
            if !is_finite {
                return None;
            }
            match excess(from, at_middle) > excess(at_middle, to) {
                true => to = at_middle,
                false => from = at_middle,
            }
        }
        None
    }
}

/// Returns the change of the rate between two instants that the mean of their accelerations does
/// not explain.
fn excess(from: (f64, Target<f64>), to: (f64, Target<f64>)) -> f64 {
    let explained = 0.5 * (to.0 - from.0) * (from.1.acceleration + to.1.acceleration);
    (to.1.rate - from.1.rate - explained).abs()
}
