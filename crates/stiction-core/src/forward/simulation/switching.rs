//! Detection of sign changes of the switching functions of the inputs: a step ends where a
//! switching function changes its sign.

use super::between::Interpolation;
use super::{Event, EventKind, Method, Simulation};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;

/// Number of sampling instants of the switching functions within a step, in addition to its ends.
const SAMPLES: usize = 3;
/// The minimum of a switching function between two samples is searched for if the tangents at the
/// samples intersect below this fraction of the smaller sample.
const NEAR_ZERO: f64 = 0.2;
/// Number of golden-section iterations in the search for a minimum.
const SECTIONS: usize = 24;
/// Longest time step, s, at the end of which a switching function may have the wrong sign.
const CHATTER: f64 = 1e-5;
/// Largest number of sign changes per switching function at one instant. If the signs change more
/// often, they do not settle, and the simulation changes to time stepping or, if the method is
/// fixed, returns an error.
const MOST_AT_ONCE: usize = 3;
/// Largest number of sign changes in rapid succession; more sign changes count as chattering and
/// are an error.
const MOST_CHANGES: usize = 2000;
/// Longest time, s, between two sign changes that count as being in rapid succession.
const QUICK: f64 = 4.0 * CHATTER;
/// Fraction of the interval between two samples over which the slope at each sample is computed.
const SLOPE: f64 = 1e-3;
/// If a function is zero at the start of an interval, its sign is evaluated at this fraction of the
/// interval.
const BEYOND: f64 = 1e-6;
/// Length of the interval in which a sign change is located, as a fraction of the step.
const FINE: f64 = 1e-14;

/// Values of the switching functions at an instant. The values of functions whose stored sign is
/// negative are multiplied by -1, so that a negative value always indicates a sign change.
struct SwitchValues {
    time: f64,
    values: Vec<f64>,
}

impl<'a> Simulation<'a> {
    /// Returns the switching function that ended the simulation before the requested time, if any;
    /// see [`Inputs::ends_at`].
    pub fn ended_by(&self) -> Option<usize> {
        self.ended_by.filter(|_| !self.last_step.shows)
    }

    /// Returns true if the simulation has ended and the present results are those at its end.
    pub(super) fn is_over(&self) -> bool {
        self.ended_by().is_some()
    }

    /// Ends the simulation at its start if a switching function with [`Inputs::ends_at`] is
    /// negative at the start.
    pub(super) fn end_at_start(&mut self, inputs: &dyn Inputs) {
        let ends = |k: &usize| !self.input.sides[*k] && inputs.ends_at(*k);
        self.ended_by = (0..self.input.sides.len()).find(ends);
        if let Some(switch) = self.ended_by {
            self.events.push(Event { time: self.now.time, kind: EventKind::Ends { switch } });
        }
    }

    /// Searches the last step for the first sign change of a switching function. If a sign change
    /// is found, restores the state at the start of the step, so that the next step ends at the
    /// sign change, and returns true.
    pub(super) fn goes_back_to_switch(
        &mut self,
        inputs: &mut dyn Inputs,
    ) -> Result<bool, ForwardError> {
        if self.input.sides.is_empty() || self.now.time == self.switch_at {
            return Ok(false);
        }
        let Some((time, switching)) = self.first_switch(inputs)? else { return Ok(false) };
        let from = self.last_step.numbers[0];
        let ends = (0..switching.len()).any(|k| switching[k] && inputs.ends_at(k));
        let is_short = self.now.time - from <= CHATTER || self.shortened_at == from;
        // The simulation may have left time stepping at the end of the step.
        let was_time_step = matches!(self.last_step.interpolation, Interpolation::Chord);
        if time >= self.now.time || was_time_step && is_short && !ends {
            // Short time steps may end shortly after the sign change.
            (self.switch_at, self.switching) = (self.now.time, switching);
            return Ok(false);
        }
        let numbers = std::mem::take(&mut self.last_step.numbers);
        // Repeated evaluations are counted, so that a simulation that only repeats steps is
        // detected as stalled.
        let evaluations = self.evaluations;
        self.take_state(&numbers);
        self.evaluations = evaluations;
        self.last_step.numbers = numbers;
        self.events.truncate(self.last_step.events);
        self.workspace.loads.clear();
        self.workspace.conditions_hold = false;
        (self.switch_at, self.switching) = (time, switching);
        if time > self.now.time {
            return Ok(true);
        }
        if let Some(stepping) = &mut self.stepping
            && !ends
        {
            // The function may change back and forth: take shorter time steps without locating the
            // sign change.
            self.shortened_at = from;
            (stepping.step, self.switch_at) = (CHATTER.min(stepping.step), f64::INFINITY);
            return Ok(true);
        }
        self.switch(inputs)?;
        Ok(true)
    }

    /// Updates the stored signs of the switching functions that change their sign at the present
    /// instant.
    pub(super) fn switch(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        if self.now.time != self.switch_at {
            return Ok(());
        }
        self.switch_at = f64::INFINITY;
        self.workspace.knows_inputs = false;
        for k in 0..self.switching.len() {
            if !std::mem::take(&mut self.switching[k]) {
                continue;
            }
            self.input.sides[k] = !self.input.sides[k];
            self.check_chatter(k, inputs)?;
            if !self.input.sides[k] && inputs.ends_at(k) && self.ended_by.is_none() {
                self.ended_by = Some(k);
                let kind = EventKind::Ends { switch: k };
                self.events.push(Event { time: self.now.time, kind });
            }
        }
        if self.stepping.is_some() {
            return Ok(());
        }
        let (count, since) = self.switches_at_once;
        let count = if since == self.now.time { count + 1 } else { 1 };
        self.switches_at_once = (count, self.now.time);
        let chatters = count > MOST_AT_ONCE * self.switching.len();
        if self.settings.method == Method::Automatic && (self.is_dense() || chatters) {
            self.wait_longer();
            self.begin_stepping();
            return Ok(());
        }
        if chatters {
            return Err(self.stalled_error());
        }
        match self.on_input_change(inputs) {
            Err(error) if self.may_step(&error) => self.begin_stepping(),
            other => other?,
        }
        self.count_turns();
        Ok(())
    }

    /// Returns true if a switching function has just changed its sign, so that inputs may jump
    /// within the next step too.
    pub(super) fn is_switching(&self) -> bool {
        let (count, _, last) = self.chatter;
        count > 0 && self.now.time - last <= QUICK
    }

    /// Returns an error if the sign of a switching function changes too often in rapid succession.
    fn check_chatter(&mut self, switch: usize, inputs: &dyn Inputs) -> Result<(), ForwardError> {
        let (count, first, last) = &mut self.chatter;
        let time = self.now.time;
        if time - *last > QUICK {
            (*count, *first) = (0, time);
        }
        (*count, *last) = (*count + 1, time);
        if *count <= MOST_CHANGES {
            return Ok(());
        }
        let (count, span) = (*count, time - *first);
        Err(ForwardError::Chatter { time, what: inputs.switch_name(switch), count, span })
    }

    /// Finds the first sign change within the last step. Returns its time, s, and a flag for each
    /// switching function that is true if the function changes its sign at this time.
    fn first_switch(
        &mut self,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<(f64, Vec<bool>)>, ForwardError> {
        let mut samples = Vec::with_capacity(SAMPLES + 2);
        let (from, to) = (self.last_step.numbers[0], self.now.time);
        let end = self.switch_values(to, inputs)?;
        samples.push(self.switch_values(from, inputs)?);
        for k in 1..=SAMPLES {
            let time = from + (to - from) * k as f64 / (SAMPLES + 1) as f64;
            if time > from && time < to {
                samples.push(self.switch_values(time, inputs)?);
            }
        }
        samples.push(end);
        // Values close to the samples, for computing slopes.
        let mut beside = Vec::with_capacity(samples.len());
        for pair in samples.windows(2) {
            let part = SLOPE * (pair[1].time - pair[0].time);
            let (after, before) = (pair[0].time + part, pair[1].time - part);
            beside.push(if after > pair[0].time && before < pair[1].time {
                Some([self.switch_values(after, inputs)?, self.switch_values(before, inputs)?])
            } else {
                None
            });
        }
        let mut first: Option<(f64, usize)> = None;
        for k in 0..self.input.sides.len() {
            let until = first.map_or(f64::INFINITY, |(time, _)| time);
            if let Some(time) = self.change_of(k, (&samples, &beside), inputs)?
                && time < until
            {
                first = Some((time, k));
            }
        }
        let Some((time, first)) = first else { return Ok(None) };
        let mut switching = vec![false; self.input.sides.len()];
        switching[first] = true;
        Ok(Some((time, switching)))
    }

    /// Finds the first time within the last step, s, at which the switching function `k` changes
    /// its sign. `samples` are the values at several instants of the step, and `beside` the values
    /// shortly after the start and before the end of each interval between samples.
    fn change_of(
        &mut self,
        k: usize,
        (samples, beside): (&[SwitchValues], &[Option<[SwitchValues; 2]>]),
        inputs: &mut dyn Inputs,
    ) -> Result<Option<f64>, ForwardError> {
        let at = |sample: &SwitchValues| (sample.time, sample.values[k]);
        for place in 1..samples.len() {
            let (low, high) = (at(&samples[place - 1]), at(&samples[place]));
            if high.1 < 0.0 {
                return self.change_between(k, low, high, inputs).map(Some);
            }
            if low.1 <= 0.0 {
                continue;
            }
            // Minimum between two samples, possibly close to an end of the interval: the function
            // decreases after the first sample and increases before the second.
            let Some([after, before]) = &beside[place - 1] else { continue };
            let (after, before) = (at(after), at(before));
            for inner in [after, before] {
                if inner.1 < 0.0 {
                    return self.change_between(k, low, inner, inputs).map(Some);
                }
            }
            let part = after.0 - low.0;
            let (falls, rises) = (low.1 - after.1, high.1 - before.1);
            if falls <= 0.0 || rises <= 0.0 {
                continue;
            }
            // A convex function lies above the intersection of its tangents.
            let (length, down, up) = (high.0 - low.0, falls / part, rises / part);
            let meeting = (low.1 - high.1 + up * length) / (down + up);
            let least = low.1 - down * meeting.clamp(0.0, length);
            if least > NEAR_ZERO * low.1.min(high.1) {
                continue;
            }
            const GOLDEN: f64 = 0.618_033_988_749_895;
            let (mut left, mut right) = (low.0, high.0);
            for _ in 0..SECTIONS {
                let length = GOLDEN * (right - left);
                let (a, b) = (right - length, left + length);
                let (fa, fb) = (
                    self.switch_values(a, inputs)?.values[k],
                    self.switch_values(b, inputs)?.values[k],
                );
                for (time, value) in [(a, fa), (b, fb)] {
                    if value < 0.0 {
                        return self.change_between(k, low, (time, value), inputs).map(Some);
                    }
                }
                if fa < fb {
                    right = b;
                } else {
                    left = a;
                }
            }
        }
        Ok(None)
    }

    /// Locates a sign change of the switching function `k` between `low` and `high`, which are
    /// pairs of time and value, by the Illinois method. Returns the upper end of a short interval
    /// around the sign change, s.
    fn change_between(
        &mut self,
        k: usize,
        mut low: (f64, f64),
        high: (f64, f64),
        inputs: &mut dyn Inputs,
    ) -> Result<f64, ForwardError> {
        if low.1 <= 0.0 {
            // The function is zero or negative at the start. If it is negative immediately after
            // the start, its sign changes at the start.
            let inner = low.0 + BEYOND * (high.0 - low.0);
            if inner <= low.0 || self.switch_values(inner, inputs)?.values[k] < 0.0 {
                return Ok(low.0);
            }
            low = (inner, self.switch_values(inner, inputs)?.values[k]);
        }
        let fine = (4.0 * f64::EPSILON * high.0.abs()).max(FINE * (high.0 - low.0));
        super::locate::crossing(low, high, fine, |time| {
            Ok(self.switch_values(time, inputs)?.values[k])
        })
    }

    /// Evaluates the switching functions at a time, s, within the last step.
    fn switch_values(
        &mut self,
        time: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<SwitchValues, ForwardError> {
        let mut values = Vec::with_capacity(self.input.sides.len());
        if time == self.now.time {
            inputs.switches(&self.view(), &mut values);
        } else {
            self.show(time, inputs)?;
            inputs.switches(&self.shown().view(), &mut values);
            self.last_step.shows = false;
        }
        // Uses the stored signs, which are those at the start of the step: a controller sample at
        // the end of the step does not change them.
        for (value, side) in values.iter_mut().zip(&self.input.sides) {
            if !side {
                *value = -*value;
            }
        }
        Ok(SwitchValues { time, values })
    }
}
