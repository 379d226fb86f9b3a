//! Steps of the integrator: tried, shortened, ended at the first event, put back onto the loops.

use super::locate::Ending;
use super::rest::{Approach, PASSED, SLOW};
use super::stepping::{DENSE, LONGEST_WAIT};
use super::{Method, REST, Simulation};
use crate::forward::error::ForwardError;
use crate::forward::evaluate::Instant;
use crate::forward::inputs::Inputs;
use crate::forward::integrator::Tolerance;
use crate::forward::rub::{Contact, norm};

/// Conditions that are as close to dependent as this: stages of steps are moved onto the loops, too.
const NEAR_SINGULAR: f64 = 0.2;

/// Numbers of Hairer's code of this method: what stability allows, so many steps are many, so few others
/// in a row end it.
const BOUNDED_BY_STABILITY: f64 = 6.1;
const STIFF: usize = 15;
const CALM: usize = 6;

impl Simulation<'_> {
    /// One step, and what happens at its end.
    pub(super) fn advance_once(
        &mut self,
        end: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let time = self.now.time;
        self.look_along();
        let start = self.pack();
        let first = self.derivative_of(&self.now);
        let approach = self.approach();
        if let Some(Approach::Arrives { contact, within }) = approach
            && within < end - time
        {
            return self.come_to_rest(contact, within, (&start, &first), inputs);
        }
        let nearest = match approach {
            Some(Approach::Nears { most }) => most,
            _ => f64::INFINITY,
        };
        let longest = self.settings.longest_step;
        loop {
            let left = end - time;
            let mut step = self.step.min(longest).min(nearest).min(left);
            // Not a splinter at the end.
            if left - step < 0.01 * step || left < 1.01 * step {
                step = left;
            } else if left < 2.0 * step {
                step = 0.5 * left;
            }
            match self.try_step(&start, &first, step, inputs) {
                Ok(error) if error <= 1.0 => {
                    let grow = if error > 0.0 { 0.9 * error.powf(-0.125) } else { 6.0 };
                    let next = step * grow.clamp(0.33, 6.0);
                    let shortened = step < self.step;
                    let after = match self.finish(&start, &first, step, end, inputs) {
                        Ok(Ending::Passes(short)) => {
                            self.shrink(short, 0.5, None)?;
                            continue;
                        }
                        Ok(after) => after,
                        // At its end there is no acceleration: come nearer, if possible.
                        Err(error) => {
                            self.shrink(step, 0.25, Some(error))?;
                            continue;
                        }
                    };
                    self.step = if shortened { next.max(self.step) } else { next };
                    // Beside a stop it is the stop that bounds steps.
                    let near = step >= 0.5 * nearest;
                    if matches!(after, Ending::Smooth) && !near && self.is_stiff(step) {
                        self.wait = (2 * self.wait).min(LONGEST_WAIT);
                        self.begin_stepping();
                        return Ok(());
                    }
                    return self.follow_up(after, inputs);
                }
                Ok(error) => {
                    let factor = (0.9 * error.powf(-0.125)).clamp(0.1, 0.9);
                    self.shrink(step, if error.is_finite() { factor } else { 0.1 }, None)?;
                }
                Err(error) => self.shrink(step, 0.25, Some(error))?,
            }
        }
    }

    /// Whether stability has bounded many short steps in a row: friction turns what is light (a rod between
    /// balls) into the direction of sliding within no time. The time stepper is implicit.
    fn is_stiff(&mut self, step: f64) -> bool {
        let after = self.derivative_of(&self.now);
        if step < DENSE && self.steps.stiffness(&after, &self.scales) > BOUNDED_BY_STABILITY {
            (self.stiff.0, self.stiff.1) = (self.stiff.0 + 1, 0);
        } else {
            self.stiff.1 += 1;
            if self.stiff.1 >= CALM {
                self.stiff = (0, 0);
            }
        }
        let many = self.stiff.0 >= STIFF;
        if many {
            self.stiff = (0, 0);
        }
        many && self.rubs() && self.settings.method == Method::Automatic
    }

    pub(super) fn shrink(
        &mut self,
        step: f64,
        factor: f64,
        error: Option<ForwardError>,
    ) -> Result<(), ForwardError> {
        self.step = step * factor;
        let shortest = self.settings.shortest_step.max(4.0 * f64::EPSILON * self.now.time.abs());
        if self.step >= shortest {
            return Ok(());
        }
        self.step = shortest;
        Err(error.unwrap_or_else(|| ForwardError::Stiff {
            time: self.now.time,
            step: shortest,
            tolerance: self.settings.relative,
            around: String::new(),
        }))
    }

    pub(super) fn try_step(
        &mut self,
        start: &[f64],
        first: &[f64],
        step: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<f64, ForwardError> {
        let mut steps = std::mem::take(&mut self.steps);
        let scales = std::mem::take(&mut self.scales);
        let tolerance = Tolerance {
            relative: self.settings.relative,
            absolute: self.settings.absolute,
            scales: &scales,
        };
        let time = self.now.time;
        let result = steps
            .attempt(start, first, (time, step), &tolerance, |t, y| self.derivative(t, y, inputs));
        self.steps = steps;
        self.scales = scales;
        result
    }

    /// Accepts a step up to the first event in it.
    pub(super) fn finish(
        &mut self,
        start: &[f64],
        first: &[f64],
        step: f64,
        end: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<Ending, ForwardError> {
        let time = self.now.time;
        let to = if step == end - time { end } else { time + step };
        let y = self.steps.end.clone();
        let arrived = self.arrive(to, &y, inputs)?;
        let found = self.first_event(time, step, &arrived, inputs)?;
        let Some((mut part, mut ending)) = found else {
            self.steadily(&y, &arrived, inputs)?;
            let before = self.now.state.clone();
            self.commit(&y, arrived);
            self.watch_rank((&before, time), inputs)?;
            return Ok(Ending::Smooth);
        };
        // The step again, to the event.
        let mut arrived = arrived;
        let mut y = y;
        for _ in 0..4 {
            let short = part * step;
            let error = self.try_step(start, first, short, inputs)?;
            y = self.steps.end.clone();
            arrived = self.arrive(time + short, &y, inputs)?;
            let Ending::Stops(contact) = ending else { break };
            let (value, slope) = self.closing_speed(&arrived, contact);
            let change = -value / slope;
            let size = change.abs();
            let far = size > 0.1 * short || !size.is_finite() || !error.is_finite();
            if far || size <= 4.0 * f64::EPSILON * (time + short) {
                break;
            }
            part += change / step;
        }
        if let Ending::Stops(contact) = ending
            && !self.model.parameters.contacts[contact].shape.has_one_freedom()
        {
            // The way of a ball or plate has turned by a right angle: no stop, unless it is slow enough. But
            // what has become much slower may have passed one.
            let speed = norm(arrived.contacts[contact].velocity);
            if speed > SLOW * self.fastest {
                if speed < PASSED * norm(self.now.contacts[contact].velocity) {
                    return Ok(Ending::Passes(part * step));
                }
                ending = Ending::Smooth;
            }
        }
        self.steadily(&y, &arrived, inputs)?;
        let before = self.now.state.clone();
        self.commit(&y, arrived);
        self.watch_rank((&before, time), inputs)?;
        Ok(ending)
    }

    /// Directions of balls and plates are taken afresh at the start of each step.
    pub(super) fn look_along(&mut self) {
        for (contact, mode) in self.modes.iter_mut().enumerate() {
            if let Contact::Slides(direction) = mode
                && !self.model.parameters.contacts[contact].shape.has_one_freedom()
            {
                let velocity = self.now.contacts[contact].velocity;
                let speed = norm(velocity);
                if speed > REST * self.fastest {
                    *direction = velocity.map(|v| v / speed);
                }
            }
        }
    }

    pub(super) fn commit(&mut self, y: &[f64], arrived: Instant) {
        let (_, rest) = self.unpack(y);
        let count = self.modes.len();
        let (bristles, energies) = rest.split_at(3 * count);
        for (to, from) in self.bristles.iter_mut().zip(bristles.chunks_exact(3)) {
            to.copy_from_slice(from);
        }
        let drives = self.energies.drives.len();
        self.energies.drives.copy_from_slice(&energies[..drives]);
        self.energies.loads = energies[drives];
        self.energies.dampers = energies[drives + 1];
        self.energies.turnover = energies[drives + 2];
        self.energies.contacts.copy_from_slice(&energies[drives + 3..]);
        for moment in &arrived.contacts {
            self.fastest = self.fastest.max(norm(moment.velocity));
        }
        for (rate, column) in arrived.state.rates.iter().zip(&self.model.columns) {
            self.fastest_rate = self.fastest_rate.max((rate / column).abs());
        }
        self.now = arrived;
    }

    /// The instant at the end of a step, loops closed.
    pub(super) fn arrive(
        &mut self,
        time: f64,
        y: &[f64],
        inputs: &mut dyn Inputs,
    ) -> Result<Instant, ForwardError> {
        self.arrive_with(time, y, inputs, self.settings.look_for_others)
    }

    pub(super) fn arrive_with(
        &mut self,
        time: f64,
        y: &[f64],
        inputs: &mut dyn Inputs,
        measure: bool,
    ) -> Result<Instant, ForwardError> {
        let mut y = y.to_vec();
        let (mut state, _) = self.unpack(&y);
        let targets = self.model.targets(time, inputs);
        self.model.project(time, &mut state, &targets, &self.anchors, &self.frozen)?;
        let coordinates = state.coordinates.len();
        y[..coordinates].copy_from_slice(&state.coordinates);
        y[coordinates..coordinates + state.rates.len()].copy_from_slice(&state.rates);
        self.evaluate(time, &y, inputs, measure)
    }

    pub(super) fn evaluate(
        &mut self,
        time: f64,
        y: &[f64],
        inputs: &mut dyn Inputs,
        measure: bool,
    ) -> Result<Instant, ForwardError> {
        self.evaluations += 1;
        let model = self.model;
        let (state, rest) = self.unpack(y);
        let numbers = state.coordinates.iter().chain(&state.rates);
        if !numbers.clone().all(|x| x.is_finite()) {
            return Err(ForwardError::NotFinite { time, what: "a coordinate or a rate" });
        }
        let bristles: Vec<[f64; 3]> =
            rest.chunks_exact(3).take(self.modes.len()).map(|z| [z[0], z[1], z[2]]).collect();
        let ground = model.ground(time, state, &bristles, (&self.grips, &self.shares), inputs);
        let loads: Vec<f64> = self.now.contacts.iter().map(|c| c.load).collect();
        let solved = model
            .solve(&ground, &self.modes, Some(&loads), measure)
            .map_err(|u| model.unsolved(time, u))?;
        let mut instant = model.instant(ground, &self.modes, &solved);
        for (acceleration, frozen) in instant.state.accelerations.iter_mut().zip(&self.frozen) {
            if *frozen {
                *acceleration = 0.0;
            }
        }
        if !instant.state.accelerations.iter().all(|a| a.is_finite()) {
            return Err(ForwardError::NotFinite { time, what: "an acceleration" });
        }
        Ok(instant)
    }

    pub(super) fn derivative(
        &mut self,
        time: f64,
        y: &[f64],
        inputs: &mut dyn Inputs,
    ) -> Result<Vec<f64>, ForwardError> {
        // Off the loops' manifold accelerations have poles near singular positions, on it they have none.
        let instant = if self.now.distance < NEAR_SINGULAR {
            self.arrive_with(time, y, inputs, false)?
        } else {
            self.evaluate(time, y, inputs, false)?
        };
        Ok(self.derivative_of(&instant))
    }
}
