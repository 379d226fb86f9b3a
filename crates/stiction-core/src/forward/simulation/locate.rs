//! Location of the first event within a step.

use super::packing::parts;
use super::{REST, Simulation};
use crate::forward::affine_friction::{InterfaceMode, dot, norm};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::instant::Instant;
use crate::forward::stick::rounding_of_friction;
use std::convert::Infallible;

/// Relative excess of the friction over its limit at which a sticking interface begins to slip. The
/// value is larger than the excess that the mode search permits.
pub(super) const SLIP_EXCESS: f64 = 1e-9;
/// Relative margin to the friction limit above which slip onset within a step is excluded, if every
/// sticking interface has this margin at all stages of the step. Stages are less accurate than the
/// end of a step, but their error is far below this margin.
const FAR_FROM_LIMIT: f64 = 0.01;

/// Between two samples, the margin may fall to zero and rise again. The search for such a dip is
/// skipped if the relative margin exceeds this value at both samples. For comparison: if a friction
/// that varies sinusoidally just reaches its limit at the peak, the margin an eighth of a period
/// from the peak is 1 - cos(45 deg) = 0.29.
const DEEPEST_DIP: f64 = 0.3;
/// Fraction of the interval between two samples over which the slope at each end is computed.
const BESIDE: f64 = 1e-4;
/// Number of golden-section iterations. They locate the minimum of a dip within 0.618^30 = 5e-7 of
/// the interval; the error of a smooth minimum value is proportional to the square of this
/// fraction.
const DIP_SECTIONS: usize = 30;

/// Reason why a step ends.
pub(super) enum Ending {
    /// The step ends without an event.
    Smooth,
    /// The sliding velocity of the interface with this index reaches zero.
    Stops(usize),
    /// The friction of a sticking interface reaches its limit.
    SlipOnset,
    /// The sliding speed of a ball or plate is much smaller at the end of the step than at its
    /// start, so the step may have missed a stick onset. The value is the estimated time of this
    /// onset, in seconds after the start of the step. Shorter steps must approach the onset.
    Passes(f64),
}

impl Simulation<'_> {
    /// Returns true if the speed of a sliding interface, at all stages of the step that ends at
    /// `arrived`, is at least half of its greater value at both ends. The stages are spread over
    /// the step, so that the speed has no zero between them.
    fn slides_throughout(&self, interface: usize, arrived: &Instant) -> bool {
        let InterfaceMode::Slides(direction) = self.modes[interface] else { return false };
        let [start, end] =
            [&self.now, arrived].map(|at| dot(at.interfaces[interface].velocity, direction));
        let least = self.workspace.least_speeds.get(interface);
        least.is_some_and(|least| least.min(end) > 0.5 * start.max(end))
    }

    /// Returns the speed of an interface along its stored slip direction, m/s, and the time
    /// derivative of this speed, m/s^2. A negative speed means that the slip has reversed.
    pub(super) fn closing_speed(&self, at: &Instant, interface: usize) -> (f64, f64) {
        let InterfaceMode::Slides(direction) = self.modes[interface] else { return (0.0, 1.0) };
        (
            dot(at.interfaces[interface].velocity, direction),
            dot(self.model.surface_acceleration(&at.bodies, interface), direction),
        )
    }

    /// Finds the first event within the step just integrated, which starts at `time` and has the
    /// length `step`, both in s. Returns the time of the event as a fraction of the step, and the
    /// kind of event.
    pub(super) fn first_event(
        &mut self,
        time: f64,
        step: f64,
        arrived: &Instant,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<(f64, Ending)>, ForwardError> {
        let mut suspects = Vec::new();
        let mut prescribed: Option<f64> = None;
        let mut holds = false;
        for interface in 0..self.modes.len() {
            match self.modes[interface] {
                InterfaceMode::Slides(_) if self.slides_throughout(interface, arrived) => {}
                InterfaceMode::Slides(_) => {
                    let (v0, a0) = self.closing_speed(&self.now, interface);
                    let (v1, a1) = self.closing_speed(arrived, interface);
                    if v1 < 0.0 || dips((v0, a0 * step), (v1, a1 * step)) {
                        suspects.push(interface);
                    }
                }
                InterfaceMode::Sticks => {
                    holds = true;
                    if let Some(part) = self.prescribed_slip_onset(interface, (time, step), inputs)
                    {
                        prescribed = Some(prescribed.map_or(part, |before| before.min(part)));
                    }
                }
                InterfaceMode::Smooth | InterfaceMode::AtLimit(_) => {}
            }
        }
        // `margin` is the smallest margin at the stages of the step, which are spread over the
        // whole step.
        holds &= self.workspace.margin.min(self.least_margin(arrived)) < FAR_FROM_LIMIT;
        if suspects.is_empty() && !holds && prescribed.is_none() {
            return Ok(None);
        }
        // Prepares the dense output of the step.
        let mut last = self.list();
        self.derivative_into(arrived, &mut last);
        let mut steps = std::mem::take(&mut self.steps);
        let prepared =
            steps.interpolate(time, &last, |t, y, rates| self.derivative(t, y, rates, inputs));
        self.steps = steps;
        self.lists.push(last);
        prepared?;
        let mut first: Option<(f64, Ending)> = prescribed.map(|part| (part, Ending::SlipOnset));
        for interface in suspects {
            if let Some(part) = self.stop_within(interface)
                && first.as_ref().is_none_or(|(before, _)| part < *before)
            {
                first = Some((part, Ending::Stops(interface)));
            }
        }
        if holds {
            let until = first.as_ref().map_or(1.0, |(part, _)| *part);
            if let Some(part) = self.slip_onset_within(time, step, until, arrived, inputs)? {
                first = Some((part, Ending::SlipOnset));
            }
        }
        Ok(first)
    }

    /// Finds the fraction of the step at which the sliding velocity of an interface decreases
    /// through zero.
    fn stop_within(&self, interface: usize) -> Option<f64> {
        const PIECES: usize = 16;
        let mut y = Vec::new();
        let mut bodies = crate::kinematics::Bodies::new(&self.model.topology);
        let mut speed = |part: f64| {
            self.steps.at(part, &mut y);
            let (coordinates, rates, _) = parts(&self.now, &y);
            let (topology, parameters) = (&self.model.topology, &self.model.parameters);
            bodies.place(topology, parameters, coordinates);
            bodies.move_with(topology, rates);
            let content = &parameters.interfaces[interface];
            let pitch = parameters.pitch[content.joint];
            let velocity = bodies.surface_velocity(topology, content, pitch);
            let InterfaceMode::Slides(direction) = self.modes[interface] else { return 1.0 };
            dot(velocity, direction)
        };
        let mut below = None;
        let mut before = 0.0;
        for piece in 1..=PIECES {
            let part = piece as f64 / PIECES as f64;
            let value = speed(part);
            if value < 0.0 {
                below = Some((part, value));
                break;
            }
            before = part;
        }
        let (part, value) = below?;
        let at_before = speed(before);
        if before == 0.0 && at_before <= 0.0 {
            // The velocity reverses immediately after the start of the step. If the reversed
            // velocity is tiny, it is round-off of the stick-slip decision made at the start.
            return (value.abs() > REST * self.fastest).then_some(0.5 * part);
        }
        // A coarse tolerance suffices, because the shortened step is corrected afterwards.
        let speed = |part| Ok::<f64, Infallible>(speed(part));
        let Ok(part) = crossing((before, at_before), (part, value), 1e-12, speed);
        Some(part)
    }

    /// Returns the smallest relative margin to the friction limit among all sticking interfaces.
    /// The result is negative if a sticking interface exceeds its limit, or if the loop constraints
    /// force it to move (see [`Instant::gives_way`]).
    pub(super) fn least_margin(&self, at: &Instant) -> f64 {
        if at.gives_way.is_some() {
            return -1.0;
        }
        // More than the decision between stick and slip permits, so that an onset is not found
        // twice.
        let rounding = 2.0 * rounding_of_friction(&at.wrenches);
        let sticks = at.interfaces.iter().filter(|c| c.interface == InterfaceMode::Sticks);
        let relative = sticks.map(|c| {
            let has = norm(c.friction);
            let size = c.limit.max(has).max(rounding).max(f64::MIN_POSITIVE);
            (c.limit * self.limit_factor * (1.0 + SLIP_EXCESS) + rounding - has) / size
        });
        relative.fold(f64::INFINITY, f64::min)
    }

    /// Finds the fraction of the step, at most `until`, at which the friction of a sticking
    /// interface exceeds its limit.
    pub(super) fn slip_onset_within(
        &mut self,
        time: f64,
        step: f64,
        until: f64,
        arrived: &Instant,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<f64>, ForwardError> {
        let mut y = self.list();
        let mut low = (0.0, self.least_margin(&self.now).max(f64::MIN_POSITIVE));
        let mut found = None;
        for piece in 1..=4 {
            let part = until * f64::from(piece) / 4.0;
            let value = match part == 1.0 {
                true => self.least_margin(arrived),
                false => self.margin_within((time, step), part, &mut y, inputs)?,
            };
            let fine = (4.0 * f64::EPSILON * (time + step).abs() / step).max(1e-14);
            let margin = |part| self.margin_within((time, step), part, &mut y, inputs);
            found = falls_below(low, (part, value), fine, margin)?;
            if found.is_some() {
                break;
            }
            low = (part, value);
        }
        self.lists.push(y);
        Ok(found)
    }

    /// Returns the smallest relative margin to the friction limit (see [`Self::least_margin`]) at
    /// the fraction `part` of the step.
    fn margin_within(
        &mut self,
        (time, step): (f64, f64),
        part: f64,
        y: &mut Vec<f64>,
        inputs: &mut dyn Inputs,
    ) -> Result<f64, ForwardError> {
        self.steps.at(part, y);
        let at = self.evaluate(time + part * step, y, inputs, false)?;
        let margin = self.least_margin(&at);
        self.workspace.spare(at);
        Ok(margin)
    }
}

/// Finds the first zero of a function between `low` and `high`; the function is positive at `low`.
/// Both bounds are pairs of argument and value. Returns the upper end of an interval of length
/// `fine` around the zero. If the function is convex between the bounds, a dip below zero between
/// two positive values is also found.
pub(super) fn falls_below(
    low: (f64, f64),
    high: (f64, f64),
    fine: f64,
    mut f: impl FnMut(f64) -> Result<f64, ForwardError>,
) -> Result<Option<f64>, ForwardError> {
    if high.1 < 0.0 {
        return Ok(Some(crossing(low, high, fine, f)?));
    }
    let length = high.0 - low.0;
    // If the margin is zero at the start of the interval, it cannot dip to zero later: the
    // interface slips at once or continues to stick.
    if low.1 < SLIP_EXCESS || low.1.min(high.1) > DEEPEST_DIP {
        return Ok(None);
    }
    let beside = BESIDE * length;
    let (mut left, mut right) = (low.0 + beside, high.0 - beside);
    let (falls, rises) = ((f(left)? - low.1) / beside, (high.1 - f(right)?) / beside);
    if falls >= 0.0 || rises <= 0.0 {
        return Ok(None);
    }
    // A convex function lies above its tangents, and therefore above their intersection.
    let meeting = (high.1 - low.1 - rises * length) / (falls - rises);
    if low.1 + falls * meeting > 0.0 {
        return Ok(None);
    }
    // Golden-section search for the minimum.
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let inner = |left: f64, right: f64| right - GOLDEN * (right - left);
    let mut middle = inner(left, right);
    let mut least = f(middle)?;
    for _ in 0..DIP_SECTIONS {
        if least < 0.0 {
            return Ok(Some(crossing(low, (middle, least), fine, f)?));
        }
        let other = left + right - middle;
        let value = f(other)?;
        let (near, far) = if value < least { (other, middle) } else { (middle, other) };
        if far < near {
            left = far
        } else {
            right = far
        }
        (middle, least) = (near, least.min(value));
    }
    Ok(None)
}

/// Finds the zero of a function that is positive at `low` and negative at `high` by the Illinois
/// method. Both bounds are pairs of argument and value. Returns the upper end of an interval of
/// length `fine` around the zero.
pub(super) fn crossing<E>(
    mut low: (f64, f64),
    mut high: (f64, f64),
    fine: f64,
    mut f: impl FnMut(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    for _ in 0..60 {
        if high.0 - low.0 <= fine {
            break;
        }
        let mut middle = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let margin = 0.01 * (high.0 - low.0);
        middle = middle.clamp(low.0 + margin, high.0 - margin);
        let value = f(middle)?;
        // Halve the value at the retained end (Illinois method).
        if value < 0.0 {
            high = (middle, value);
            low.1 *= 0.5;
        } else {
            low = (middle, value);
            high.1 *= 0.5;
        }
    }
    Ok(high.0)
}

/// Returns true if the cubic with values `v0`, `v1` and slopes `a0`, `a1` at 0 and 1 is negative at
/// one or more of the points 1/8, 2/8, ..., 7/8.
fn dips((v0, a0): (f64, f64), (v1, a1): (f64, f64)) -> bool {
    (1..8).any(|k| {
        let x = f64::from(k) / 8.0;
        let y = 1.0 - x;
        let value = v0 * (1.0 + 2.0 * x) * y * y + a0 * x * y * y + v1 * x * x * (3.0 - 2.0 * x)
            - a1 * x * x * y;
        value < 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Searches for the first zero of `f` between 0 and 1, given the values of `f` at 0 and 1.
    fn first(f: impl Fn(f64) -> f64) -> Option<f64> {
        falls_below((0.0, f(0.0)), (1.0, f(1.0)), 1e-13, |x| Ok(f(x))).unwrap()
    }

    #[test]
    fn a_dip_between_two_samples_is_found() {
        // Three functions that fall below zero: a parabola that is negative from 0.3 to 0.4, a
        // parabola that is barely negative near 0.7, and a function with a kink.
        let roots = |a: f64, b: f64| move |x: f64| 0.5 * (x - a) * (x - b);
        assert!((first(roots(0.3, 0.4)).unwrap() - 0.3).abs() < 1e-12);
        assert!((first(roots(0.6999, 0.7001)).unwrap() - 0.6999).abs() < 1e-12);
        assert!((first(|x: f64| 0.2 * (x - 0.61).abs() - 0.002).unwrap() - 0.6).abs() < 1e-12);
        // Three functions without a zero: one with a positive minimum, one that falls, and one that
        // rises.
        assert_eq!(first(|x: f64| 0.2 * (x - 0.6).powi(2) + 1e-6), None);
        assert_eq!(first(|x: f64| 0.2 - 0.1 * x), None);
        assert_eq!(first(|x: f64| 0.1 + 0.1 * x), None);
        assert!((first(|x: f64| 0.2 - x).unwrap() - 0.2).abs() < 1e-12);
    }
}
