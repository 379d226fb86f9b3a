//! Event-driven steps: error control, first event, projection onto the loop constraints.

use super::between::Interpolation;
use super::locate::Ending;
use super::method_change::DENSE;
use super::packing::parts;
use super::rest::{Approach, PASSED, SLOW};
use super::scratch::Scratch;
use super::{Method, REST, Settings, Simulation};
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::coupling::CERTAIN;
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::instant::Instant;
use crate::forward::integrator::{Order, Tolerance};

/// Singularity index below which all stages of a step are projected onto the loop constraints, not
/// only its end.
pub(super) const NEAR_SINGULAR: f64 = 0.2;

/// Singularity index below which the start of a motion counts as singular.
const SINGULAR: f64 = 1e-9;

/// Stability bound of Hairer's stiffness test for this integration method. A step is limited by
/// stability if its estimated stiffness exceeds this value.
const BOUNDED_BY_STABILITY: f64 = 6.1;
/// Number of steps limited by stability after which the problem counts as stiff.
const STIFF: usize = 15;
/// Number of consecutive steps not limited by stability that resets the count of steps limited by
/// stability.
const CALM: usize = 6;

/// Relative error of normal loads at the stages of a step, as a fraction of the tolerance of the
/// step.
const AT_STAGES: f64 = 0.1;
/// Relative error of normal loads at the end of a step, as a fraction of the tolerance of the step.
const AT_END: f64 = 1e-4;

/// Step size, s, below which the simulation changes to time stepping if a stage of a step has no
/// accelerations.
const LOST: f64 = 1e-6;

/// Number of consecutive short steps after which the event-driven method counts as too slow. A step
/// is short if the motion in it, at the largest rate so far, is below [`SHORT_WAY`].
const CRAWLING: usize = 200;
/// Largest motion in a short step, rad or characteristic lengths. The motion in a usual step of
/// this method is a thousand times larger.
const SHORT_WAY: f64 = 2e-4;

/// Longest step of a mechanism with friction, as a fraction of the longest step in the settings.
/// The search for events samples each step only at a few instants, so steps must not be too long.
const FREQUENT: f64 = 0.1;

/// Distance from the end of a shortened step to the event, as a fraction of the step, below which a
/// linear correction along the derivative moves the end to the event. The error of the correction
/// is of second order and below round-off.
const NUDGE: f64 = 1e-7;

impl Simulation<'_> {
    /// Advances by one event-driven step and reacts to the event that ends the step, if any.
    pub(super) fn advance_once(
        &mut self,
        end: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        if self.waits() {
            return self.wait_through(end, inputs);
        }
        self.last_step.interpolation = Interpolation::Curve;
        self.last_step.crosses = false;
        self.update_slip_directions();
        let (mut start, mut first) = (self.list(), self.list());
        self.pack_into(&mut start);
        self.derivative_into(&self.now, &mut first);
        let done = self.advance_from(&start, &first, end, inputs);
        self.lists.extend([start, first]);
        self.workspace.loads.clear();
        done
    }

    fn advance_from(
        &mut self,
        start: &[f64],
        first: &[f64],
        end: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let time = self.now.time;
        let approach = self.approach();
        if let Some(Approach::Arrives { interface, within }) = approach
            && within < end - time
        {
            return self.come_to_rest(interface, within, (start, first), inputs);
        }
        let nearest = match approach {
            Some(Approach::Nears { most }) => most,
            _ => f64::INFINITY,
        };
        let longest = self.longest_step(time, inputs);
        let frequent = match self.has_friction() {
            true => FREQUENT * self.settings.longest_step,
            false => f64::INFINITY,
        };
        loop {
            let left = end - time;
            let most = longest.min(nearest).min(left);
            let mut step = self.length_across(self.step.min(most).min(frequent));
            // Avoids a tiny remaining step before `end`.
            if left - step < 0.01 * step || left < 1.01 * step {
                step = left;
            } else if left < 2.0 * step {
                step = 0.5 * left;
            }
            let is_cut = step == left && end == self.change_at;
            let order = self.order_of_step(step, is_cut);
            match self.try_step(order, (start, first), step, inputs) {
                Ok(error) if !self.accepts_order(order, error, step) => {}
                Ok(error) if error <= 1.0 => {
                    let grow = if error > 0.0 { 0.9 * error.powf(-0.125) } else { 6.0 };
                    let next = step * grow.clamp(0.33, 6.0);
                    let accuracy = error * self.attainable_tolerance();
                    let crosses = self.workspace.crosses.is_some();
                    let shortened = step < self.step;
                    let after = match self.finish(start, first, step, end, inputs) {
                        Ok(Some(Ending::Passes(short))) => {
                            self.shrink(short, 0.5, None)?;
                            continue;
                        }
                        Ok(Some(after)) => after,
                        Ok(None) => continue,
                        // No accelerations exist at the end of the step: approach it with a shorter
                        // step, if possible.
                        Err(error) => {
                            self.shrink(step, 0.25, Some(error))?;
                            continue;
                        }
                    };
                    self.last_step.crosses = crosses;
                    if accuracy > self.settings.relative {
                        self.coarsest = self.coarsest.max(accuracy);
                    }
                    self.step = if shortened { next.max(self.step) } else { next };
                    // Near a stick onset, the approach to the stop limits the step, not stability.
                    let near = step >= 0.5 * nearest;
                    let smooth = matches!(after, Ending::Smooth);
                    let stiff = smooth && !near && self.is_stiff(step);
                    // The approach of a plate or ball to its stop takes many steps, but their
                    // number is limited.
                    let nears = nearest.is_finite();
                    let costly = !stiff && smooth && !nears && self.is_costly(end, inputs);
                    if stiff || costly {
                        if costly {
                            self.wait_after_costs()
                        } else {
                            self.wait_longer()
                        }
                        self.begin_stepping();
                        return Ok(());
                    }
                    return self.follow_up(after, time, inputs);
                }
                Ok(error) => {
                    let factor = (0.9 * error.powf(-0.125)).clamp(0.1, 0.9);
                    self.shrink(step, if error.is_finite() { factor } else { 0.1 }, None)?;
                }
                Err(error) => self.shrink(step, 0.25, Some(error))?,
            }
        }
    }

    /// Returns true if the implicit time-stepping method should take over: either stability has
    /// limited many recent steps, for example because of friction on a light rod between balls, or
    /// many consecutive steps were very short. Returns false without friction, and unless the
    /// method is automatic.
    fn is_stiff(&mut self, step: f64) -> bool {
        let mut bounded = step < DENSE;
        if bounded {
            let mut after = self.list();
            self.derivative_into(&self.now, &mut after);
            bounded = self.steps.stiffness(&after, &self.scales) > BOUNDED_BY_STABILITY;
            self.lists.push(after);
        }
        if bounded {
            (self.stiff.0, self.stiff.1) = (self.stiff.0 + 1, 0);
        } else {
            self.stiff.1 += 1;
            if self.stiff.1 >= CALM {
                self.stiff = (0, 0);
            }
        }
        let crawls = step < DENSE && step * self.fastest_rate < SHORT_WAY;
        self.crawling = if crawls { self.crawling + 1 } else { 0 };
        let many = self.stiff.0 >= STIFF || self.crawling >= CRAWLING;
        if many {
            self.stiff = (0, 0);
            self.crawling = 0;
        }
        many && self.has_friction() && self.settings.method == Method::Automatic
    }

    pub(super) fn shrink(
        &mut self,
        step: f64,
        factor: f64,
        error: Option<ForwardError>,
    ) -> Result<(), ForwardError> {
        self.step = step * factor;
        let shortest = self.settings.shortest_step.max(4.0 * f64::EPSILON * self.now.time.abs());
        if let Some(error) = &error
            && self.step < LOST
            && self.may_step(error)
        {
            // Ever shorter steps towards the last instant with accelerations make no progress.
            return Err(error.clone());
        }
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

    /// Returns the tolerance of the error of a step for components of the sizes `scales`.
    pub(super) fn tolerance<'s>(&self, scales: &'s [f64]) -> Tolerance<'s> {
        let Settings { relative, absolute, .. } = self.settings;
        Tolerance { relative, absolute, scales }
    }

    /// Attempts a step with the method of the given order. Returns the estimated error divided by
    /// the tolerated error.
    pub(super) fn try_step(
        &mut self,
        order: Order,
        (start, first): (&[f64], &[f64]),
        step: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<f64, ForwardError> {
        let mut steps = std::mem::take(&mut self.steps);
        let scales = std::mem::take(&mut self.scales);
        let tolerance = self.tolerance(&scales);
        let time = self.now.time;
        self.start_near_present_loads();
        let state = (start, first);
        let result = steps.attempt(order, state, (time, step), &tolerance, |t, y, rates| {
            self.derivative(t, y, rates, inputs)
        });
        self.steps = steps;
        self.scales = scales;
        Ok(result? * self.settings.relative / self.attainable_tolerance())
    }

    /// Accepts a step up to its first event, and returns the reason why the accepted step ends.
    /// Returns `None` if the step must be repeated at a higher order, or by the general solver.
    pub(super) fn finish(
        &mut self,
        start: &[f64],
        first: &[f64],
        step: f64,
        end: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<Ending>, ForwardError> {
        let time = self.now.time;
        let to = if step == end - time { end } else { time + step };
        let mut y = self.list();
        y.clone_from(&self.steps.end);
        let had_failed = self.program_failed;
        let arrived = self.arrive(to, &y, inputs)?;
        let is_doubtful = self.program_failed && !had_failed;
        if is_doubtful || !self.accepts_end(&arrived, step) {
            self.workspace.spare(arrived);
            self.lists.push(y);
            return Ok(None);
        }
        let found = self.first_event(time, step, &arrived, inputs)?;
        let Some((mut part, mut ending)) = found else {
            self.check_step(&y, &arrived, inputs)?;
            self.workspace.before.clone_from(&self.now.state);
            self.commit(&y, arrived);
            self.lists.push(y);
            self.watch_rank(time, inputs)?;
            return Ok(Some(Ending::Smooth));
        };
        // Repeats the step with a length such that it ends at the event.
        let mut arrived = arrived;
        let mut nudge = None;
        for _ in 0..4 {
            let short = part * step;
            let mut error = 0.0;
            if let Some(change) = nudge {
                let mut rates = self.list();
                self.derivative_into(&arrived, &mut rates);
                y.iter_mut().zip(&rates).for_each(|(y, rate)| *y += change * rate);
                self.lists.push(rates);
            } else {
                error = self.try_step(Order::Eight, (start, first), short, inputs)?;
                y.clone_from(&self.steps.end);
            }
            let next = self.arrive(time + short, &y, inputs)?;
            self.workspace.spare(std::mem::replace(&mut arrived, next));
            if self.program_failed && !had_failed {
                self.workspace.spare(arrived);
                self.lists.push(y);
                return Ok(None);
            }
            let Ending::Stops(interface) = ending else { break };
            let (value, slope) = self.closing_speed(&arrived, interface);
            let change = -value / slope;
            let size = change.abs();
            let far = size > 0.1 * short || !size.is_finite() || !error.is_finite();
            if far || size <= 4.0 * f64::EPSILON * (time + short) {
                break;
            }
            part += change / step;
            nudge = (size < NUDGE * short).then_some(change);
        }
        if let Ending::Stops(interface) = ending
            && !self.model.parameters.interfaces[interface].shape.has_one_dof()
        {
            // The velocity of the ball or plate has turned by a right angle. This is no stick onset
            // unless the interface is slow enough. If the interface is much slower than before, the
            // step may have missed a stick onset.
            let speed = norm(arrived.interfaces[interface].velocity);
            if speed > SLOW * self.fastest {
                if speed < PASSED * norm(self.now.interfaces[interface].velocity) {
                    return Ok(Some(Ending::Passes(part * step)));
                }
                ending = Ending::Smooth;
            }
        }
        self.check_step(&y, &arrived, inputs)?;
        self.workspace.before.clone_from(&self.now.state);
        self.commit(&y, arrived);
        self.lists.push(y);
        self.watch_rank(time, inputs)?;
        Ok(Some(ending))
    }

    /// Sets the stored slip directions of balls and plates to the directions of their present
    /// velocities. Called at the start of a step.
    pub(super) fn update_slip_directions(&mut self) {
        let mut largest = 0.0_f64;
        for interface in 0..self.modes.len() {
            if let InterfaceMode::Slides(before) = self.modes[interface]
                && !self.model.parameters.interfaces[interface].shape.has_one_dof()
            {
                let velocity = self.now.interfaces[interface].velocity;
                let speed = norm(velocity);
                if speed > REST * self.fastest {
                    let direction = velocity.map(|v| v / speed);
                    self.modes[interface] = InterfaceMode::Slides(direction);
                    largest = largest.max(norm([0, 1, 2].map(|i| direction[i] - before[i])));
                }
            }
        }
        self.count_turn(largest);
    }

    pub(super) fn commit(&mut self, y: &[f64], arrived: Instant) {
        let (_, _, rest) = parts(&self.now, y);
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
        let (interfaces, states) = energies[drives + 3..].split_at(count);
        self.energies.interfaces.copy_from_slice(interfaces);
        self.input.values.copy_from_slice(states);
        self.count_motion(&arrived);
        self.become_now(arrived);
        self.keep_fastest();
    }

    /// Updates the largest sliding velocity and the largest rate since the start.
    pub(super) fn keep_fastest(&mut self) {
        for interface in &self.now.interfaces {
            self.fastest = self.fastest.max(norm(interface.velocity));
        }
        for (rate, column) in self.now.state.rates.iter().zip(&self.model.columns) {
            self.fastest_rate = self.fastest_rate.max((rate / column).abs());
        }
    }

    pub(super) fn become_now(&mut self, instant: Instant) {
        let before = std::mem::replace(&mut self.now, instant);
        self.workspace.spare(before);
        self.workspace.loads.clear();
    }

    /// Evaluates accelerations and reactions at the end of a step with the state vector `y`, after
    /// projecting it onto the loop constraints.
    pub(super) fn arrive(
        &mut self,
        time: f64,
        y: &[f64],
        inputs: &mut dyn Inputs,
    ) -> Result<Instant, ForwardError> {
        let measure = self.settings.look_for_others && self.needs_bound();
        let mut arrived = self.arrive_with(time, y, inputs, measure)?;
        self.keep_bound(&mut arrived);
        Ok(arrived)
    }

    pub(super) fn arrive_with(
        &mut self,
        time: f64,
        y: &[f64],
        inputs: &mut dyn Inputs,
        measure: bool,
    ) -> Result<Instant, ForwardError> {
        let mut moved = std::mem::take(&mut self.workspace.y);
        moved.clear();
        moved.extend_from_slice(y);
        let done = self.onto_the_loops(time, &mut moved, inputs);
        let arrived = done.and_then(|()| {
            let Scratch { program, projection, .. } = &*self.workspace;
            let distance = program.as_ref().and_then(|_| projection.distance_of_loops());
            let mut instant = self.evaluate_at(time, &moved, inputs, (measure, distance))?;
            // Sparse solvers weight the constraints in another way than the projection.
            instant.distance = distance.unwrap_or(instant.distance);
            Ok(instant)
        });
        self.workspace.y = moved;
        arrived
    }

    /// Projects the coordinates and rates of a state vector onto the loop constraints.
    pub(super) fn onto_the_loops(
        &mut self,
        time: f64,
        y: &mut [f64],
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let model = self.model;
        let Scratch { situation, solved_modes, projection, is_placed, has_masses, .. } =
            &mut *self.workspace;
        solved_modes.clear();
        *is_placed = false;
        let state = &mut situation.state;
        let (coordinates, rest) = y.split_at_mut(state.coordinates.len());
        let rates = &mut rest[..state.rates.len()];
        state.coordinates.copy_from_slice(coordinates);
        state.rates.copy_from_slice(rates);
        model.targets_into(time, inputs, &mut situation.targets);
        let held = (&self.anchors[..], &self.frozen[..]);
        model.project_in(time, state, &situation.targets, held, projection)?;
        coordinates.copy_from_slice(&state.coordinates);
        rates.copy_from_slice(&state.rates);
        projection.swap_bodies(&mut situation.bodies);
        model.move_placed_bodies(situation);
        (*is_placed, *has_masses) = (true, false);
        Ok(())
    }

    /// Sets the present normal loads as the starting point of Newton's method, and resets the
    /// smallest friction margin and the smallest singularity index of the step.
    pub(super) fn start_near_present_loads(&mut self) {
        let each = self.now.interfaces.iter().map(|interface| interface.load);
        self.workspace.loads.start(self.now.time, each);
        self.workspace.margin = f64::INFINITY;
        self.workspace.least_speeds.clear();
        self.workspace.least_speeds.resize(self.modes.len(), f64::INFINITY);
        // At a singular start the accelerations are limits along the branch of motion.
        let distance = self.now.distance;
        self.workspace.nearest = if distance < SINGULAR { f64::INFINITY } else { distance };
    }

    /// Returns true if the last evaluation was at the same state and modes, so that its factorised
    /// equations of motion remain valid: only inputs have changed.
    fn is_factorised_at(&self, coordinates: &[f64], rates: &[f64]) -> bool {
        let Scratch { situation, solved_modes, .. } = &*self.workspace;
        let state = &situation.state;
        // Right-hand sides of constraint rows contain prescribed accelerations, which inputs may
        // change, and the rates.
        self.model.prescribed.is_empty()
            && state.coordinates == coordinates
            && state.rates == rates
            && *solved_modes == self.modes
            && !self.modes.is_empty()
            && situation.distribution == self.distribution
    }

    /// Sets how the next evaluation solves for the normal loads.
    pub(super) fn choose_load_iteration(&mut self) {
        let Scratch { solved, load_tolerance, .. } = &mut *self.workspace;
        solved.is_weak = self.now.coupling.is_some_and(|bound| bound <= CERTAIN);
        solved.load_tolerance = load_tolerance.max(AT_END * self.settings.relative);
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
        if self.workspace.loads.is_empty() {
            self.start_near_present_loads();
        }
        self.workspace.conditions_hold = false;
        let mut instant = self.workspace.instant(model);
        let (coordinates, rates, rest) = parts(&self.now, y);
        if !coordinates.iter().chain(rates).all(|x| x.is_finite()) {
            return Err(ForwardError::NotFinite { time, what: "a coordinate or a rate" });
        }
        let is_factorised = self.is_factorised_at(coordinates, rates);
        self.choose_load_iteration();
        self.set_situation(time, (coordinates, rates, rest));
        let Scratch { situation, is_placed, has_masses, solved, solved_modes, loads, .. } =
            &mut *self.workspace;
        if !*is_placed {
            model.move_bodies(situation);
        }
        model.update_inputs(situation, inputs);
        model.update_masses(situation);
        (*is_placed, *has_masses) = (true, false);
        solved_modes.clear();
        let known = Some(loads.at(time));
        let done = match is_factorised {
            true => model.couple(situation, &self.modes, known, measure, solved),
            false => model.solve_into(situation, &self.modes, known, measure, solved),
        };
        self.economy.spend(solved.continuation_steps());
        done.map_err(|u| model.unsolved(time, u))?;
        solved_modes.extend_from_slice(&self.modes);
        model.instant_into(situation, &self.modes, solved, &mut instant);
        for (acceleration, frozen) in instant.state.accelerations.iter_mut().zip(&self.frozen) {
            if *frozen {
                *acceleration = 0.0;
            }
        }
        match instant.nonfinite() {
            Some(what) => Err(ForwardError::NotFinite { time, what }),
            None => Ok(instant),
        }
    }

    /// Sets time, state, bristle deflections and internal states of the inputs for the next
    /// evaluation. The motion of the bodies remains known where only inputs have changed.
    pub(super) fn set_situation(
        &mut self,
        time: f64,
        (coordinates, rates, rest): (&[f64], &[f64], &[f64]),
    ) {
        let Scratch { situation, is_placed, .. } = &mut *self.workspace;
        *is_placed &= situation.state.coordinates == coordinates && situation.state.rates == rates;
        situation.time = time;
        situation.state.coordinates.copy_from_slice(coordinates);
        situation.state.rates.copy_from_slice(rates);
        let bristles = rest.chunks_exact(3).take(self.modes.len());
        situation.bristles.clear();
        situation.bristles.extend(bristles.map(|z| [z[0], z[1], z[2]]));
        situation.input.clone_from(&self.input);
        let states = rest.len() - self.input.values.len();
        situation.input.values.copy_from_slice(&rest[states..]);
        situation.distribution.clone_from(&self.distribution);
    }

    pub(super) fn derivative(
        &mut self,
        time: f64,
        y: &[f64],
        rates: &mut Vec<f64>,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        // Near singular configurations accelerations have poles off the constraint manifold, but
        // not on it.
        let near = self.workspace.crosses.is_some() || self.now.distance < NEAR_SINGULAR;
        if self.workspace.crosses.is_none() && self.derivative_by_program(time, y, rates, inputs) {
            return Ok(());
        }
        self.workspace.least_speeds.clear();
        // Off the constraint manifold redundant constraints seem independent.
        self.workspace.load_tolerance = AT_STAGES * self.settings.relative;
        let instant = match near || self.now.redundant > 0 {
            true => self.arrive_with(time, y, inputs, false),
            false => self.evaluate(time, y, inputs, false),
        };
        self.workspace.load_tolerance = 0.0;
        let instant = instant?;
        self.derivative_into(&instant, rates);
        self.workspace.margin = self.workspace.margin.min(self.least_margin(&instant));
        self.workspace.nearest = self.workspace.nearest.min(instant.distance);
        let Scratch { loads, solved, .. } = &mut *self.workspace;
        loads.add(time, &solved.coupled.loads);
        self.workspace.spare(instant);
        Ok(())
    }
}
