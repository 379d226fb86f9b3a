//! Time-stepping method: step control, velocity jumps, results at the ends of steps.

use super::between::Interpolation;
use super::halving::{EXTRAPOLATED, SMOOTH, same_slip};
use super::{Energies, Event, EventKind, Method, RateJump, Simulation};
use crate::forward::Forward;
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::data::FrictionDistribution;
use crate::forward::error::ForwardError;
use crate::forward::inputs::{InputState, Inputs};
use crate::forward::instant::{Account, Instant, InterfaceSample};
use crate::forward::project::Anchor;
use crate::forward::time_stepping::{StepStart, TimeStep};
use crate::kinematics::{Bodies, State};
use crate::mechanism::JointId;

/// Length, s, of the first time step after a change to the time-stepping method. Steps that are not
/// longer are neither extrapolated nor shortened because of the error of their rates.
pub(super) const FIRST: f64 = 1e-6;
/// Changes of the rates in a time step count as round-off if they are below this fraction of the
/// largest rate that the step would reach without friction.
const STILL: f64 = 1e-9;
/// Fraction of the largest rate above which a change of velocity counts as a jump, if it happens
/// almost completely within one half of a step of length [`SHORTEST_BEFORE_JUMP`].
const JUMP: f64 = 1e-4;
/// Length, s, of the steps in which jumps are detected. Longer steps with a jump are shortened.
const SHORTEST_BEFORE_JUMP: f64 = 1e-8;
/// Largest number of consecutive velocity jumps that are located however dense they are.
pub(super) const JUMPS: f64 = 40.0;
/// Time, s, after which one more jump is located.
const JUMP_INTERVAL: f64 = 0.02;
/// Largest error of a smooth step because of its rates, as a multiple of the error because of its
/// coordinates. Steps are therefore at most ten times shorter than the coordinates require.
const OF_RATES: f64 = 100.0;
/// Largest ratio between the changes of the rates in the two halves of a step for which the
/// acceleration counts as steady.
const STEADY: f64 = 1.2;
/// Length, s, above which an acceleration may count as steady. Shorter steps occur near jumps.
const SHORTEST_STEADY: f64 = 1e-5;
/// Length, s, to which a step may be shortened because of the error of the rates at a transition.
const SHORTEST_AT_TRANSITION: f64 = 1e-7;
/// End of a step before a stop or reversal, as a fraction of the estimated time to it.
const BEFORE_STOP: f64 = 0.98;
/// Number of steps without a reversal or stick-slip transition after which one more step at a
/// transition may be shortened because of the error of the rates. Where transitions follow each
/// other more densely, their steps are not shortened for this reason.
const REFINEMENT: usize = 8;
/// The same number for a step that ends before a stop or reversal, which needs only two more steps.
const STOP: usize = 2;
/// Upper limit of [`Stepping::refinements`], and its value at the start.
pub(super) const REFINEMENTS: usize = 4 * REFINEMENT;
/// Longer steps, s, that are tried if the shortest step has no solution. The change of velocity in
/// such a step is recorded as a jump.
const LONGER: [f64; 4] = [1e-6, 1e-5, 1e-4, 1e-3];
/// Smallest jump of a joint rate that an event lists, as a fraction of the largest jump.
const SMALL_PART: f64 = 1e-3;

/// Step control of the time-stepping method.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stepping {
    /// Length of the next step, s.
    pub(super) step: f64,
    /// Number of consecutive steps without a stick-slip transition.
    pub(super) quiet: usize,
    /// Number of steps without a stick-slip transition after which the simulation tries the
    /// event-driven method again.
    pub(super) wait: usize,
    /// Remaining budget for shorter steps at transitions: each step without a transition adds one, and
    /// each shortened step takes [`REFINEMENT`], or [`STOP`] if it ends before a stop.
    pub(super) refinements: usize,
}

/// Result of a time step after projection onto the constraints.
pub(super) struct StepResult {
    pub(super) time_step: TimeStep,
    pub(super) state: State<f64>,
    pub(super) anchors: Vec<Anchor>,
    pub(super) frozen: Vec<bool>,
}

impl Simulation<'_> {
    /// Returns the present integration scheme: event-driven or time-stepping.
    pub fn method(&self) -> Method {
        if self.shown().stepping.is_some() { Method::TimeStepping } else { Method::EventDriven }
    }

    /// Returns true if any joint has friction.
    pub(super) fn has_friction(&self) -> bool {
        !self.modes.is_empty()
    }

    /// Returns the locks of the interfaces that stick both before and after the step: anchors,
    /// which keep their previous poses, and a flag for each degree of freedom of the spanning tree
    /// that is true if the degree of freedom is locked.
    pub(super) fn places_of(
        &self,
        before: &[InterfaceMode],
        after: &[InterfaceMode],
    ) -> (Vec<Anchor>, Vec<bool>) {
        let still =
            |c: &usize| before[*c] == InterfaceMode::Sticks && after[*c] == InterfaceMode::Sticks;
        let sticks: Vec<usize> = (0..after.len()).filter(still).collect();
        let (mut anchors, frozen) = self.holds_of(&sticks);
        keep_poses(&mut anchors, &self.anchors);
        (anchors, frozen)
    }

    /// Computes one time step and projects the state at its end onto the loop constraints.
    pub(super) fn land(
        &mut self,
        time: f64,
        step: f64,
        from: &State<f64>,
        (modes, bristles, near): (&[InterfaceMode], &[[f64; 3]], &[[f64; 3]]),
        (input, inputs): (&InputState, &mut dyn Inputs),
    ) -> Result<StepResult, ForwardError> {
        self.evaluations += 1;
        let model = self.model;
        let mut time_step = model.time_step(
            time,
            step,
            StepStart { state: from, modes, bristles, frictions: near, input },
            inputs,
        )?;
        if let Some(stands) = self.sticking_at_reversals(modes, &time_step) {
            let near = &time_step.frictions;
            let held = model.time_step(
                time,
                step,
                StepStart { state: from, modes: &stands, bristles, frictions: near, input },
                inputs,
            );
            let stays = |time_step: &TimeStep| {
                let each = modes.iter().zip(&stands).zip(&time_step.modes);
                each.into_iter().any(|((a, b), after)| a != b && *after == InterfaceMode::Sticks)
            };
            if let Ok(held) = held
                && stays(&held)
            {
                time_step = held;
            }
        }
        let mut state = time_step.state.clone();
        let targets = model.targets(time + step, inputs);
        let (anchors, mut frozen) = self.places_of(modes, &time_step.modes);
        let at_rest = from.rates.iter().all(|rate| *rate == 0.0);
        if at_rest && self.change(from, &state) <= STILL * time_step.free_rate {
            // The mechanism stays at rest: locks all degrees of freedom so that round-off does not
            // move them.
            frozen.fill(true);
        }
        self.restore(from, &mut state, &frozen);
        let time = time + step;
        if frozen.iter().all(|f| *f) {
            return Ok(StepResult { time_step, state, anchors, frozen });
        }
        let locks = (&anchors[..], &frozen[..]);
        let mut yields = model.project_yielding(time, &mut state, &targets, locks)?;
        // Interfaces that stick at the end of the step must have zero velocity at the new
        // configuration as well.
        let all: Vec<usize> = (0..time_step.modes.len())
            .filter(|&c| time_step.modes[c] == InterfaceMode::Sticks)
            .collect();
        let (_, frozen) = self.holds_of(&all);
        let locks = (&anchors[..], &frozen[..]);
        yields |= model.project_yielding(time, &mut state, &targets, locks)?;
        // Locks that have yielded hold at the positions where the loops close.
        let anchors = if yields { Vec::new() } else { anchors };
        if !state.coordinates.iter().chain(&state.rates).all(|x| x.is_finite()) {
            return Err(ForwardError::NotFinite { time, what: "a coordinate or a rate" });
        }
        // Joints that stick at a dead centre permit the present rates, but not those an instant later.
        // The locks that then stop the mechanism dissipate its energy.
        let rates = from.rates.iter().zip(&model.columns);
        let fastest = rates.map(|(rate, column)| rate.abs() / column).fold(0.0, f64::max);
        let stops = fastest > 0.0 && self.change(&time_step.state, &state) > JUMP * fastest;
        time_step.is_impulsive |= stops;
        Ok(StepResult { time_step, state, anchors, frozen })
    }

    /// Returns the modes at the start of a step, with stick instead of slip for each interface that
    /// reverses its slip within the step and has static friction above its sliding friction. Such
    /// an interface passes through zero velocity, where static friction may lock it. Returns `None`
    /// if there is no such interface.
    fn sticking_at_reversals(
        &self,
        modes: &[InterfaceMode],
        time_step: &TimeStep,
    ) -> Option<Vec<InterfaceMode>> {
        let mut stands = modes.to_vec();
        for (interface, mode) in stands.iter_mut().enumerate() {
            let (InterfaceMode::Slides(before), InterfaceMode::Slides(after)) =
                (*mode, time_step.modes[interface])
            else {
                continue;
            };
            let turns = before.iter().zip(after).map(|(a, b)| a * b).sum::<f64>() < 0.0;
            let law = self.model.parameters.interfaces[interface].law_towards(after[0]);
            if turns && law.at_rest() > law.coefficient(norm(time_step.velocities[interface])) {
                *mode = InterfaceMode::Sticks;
            }
        }
        (stands != modes).then_some(stands)
    }

    /// Resets the coordinates of locked degrees of freedom to the coordinates in `from`, and sets
    /// the rates of these degrees of freedom to zero.
    fn restore(&self, from: &State<f64>, state: &mut State<f64>, frozen: &[bool]) {
        for (rate, frozen) in state.rates.iter_mut().zip(frozen) {
            if *frozen {
                *rate = 0.0;
            }
        }
        for node in &self.model.topology.nodes {
            if frozen[node.tree_dofs.clone()].iter().all(|f| *f) {
                let range = node.coordinates.clone();
                state.coordinates[range.clone()].copy_from_slice(&from.coordinates[range]);
            }
        }
    }

    pub(super) fn step_through(
        &mut self,
        end: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let Some(mut stepping) = self.stepping.clone() else { return Ok(()) };
        self.last_step.interpolation = Interpolation::Chord;
        let time = self.now.time;
        let from = self.now.state.clone();
        let (modes, bristles) = (self.modes.clone(), self.bristles.clone());
        let shortest = self.settings.shortest_step.max(16.0 * f64::EPSILON * time.abs());
        let longest = self.longest_step(time, inputs);
        let mut longer = LONGER.iter().filter(|step| **step <= longest.min(end - time));
        // Error of the shortest step, if it has no solution.
        let mut unsolved = None;
        // Length of a valid step that is tried again with a shorter length.
        let mut valid = None;
        // Length of a step that ends before a stop or reversal, and the rest of the step that it replaces.
        let mut before_stop = None;
        loop {
            let is_last_resort = unsolved.is_some();
            let left = end - time;
            let mut step = stepping.step.min(longest).min(left);
            if left - step < 0.01 * step {
                step = left;
            }
            let shortened = step < stepping.step;
            let half = 0.5 * step;
            let tried = self.two_halves(time, half, &from, (&modes, &bristles), inputs);
            self.unsolved_steps += usize::from(tried.is_err());
            let (whole, first, second) = match tried {
                Ok(tried) => tried,
                Err(_) if let Some(step) = valid.take() => {
                    (stepping.step, stepping.refinements) = (step, 0);
                    continue;
                }
                Err(_) if !is_last_resort && 0.25 * step >= shortest => {
                    stepping.step = 0.25 * step;
                    continue;
                }
                // During an impact, short steps may have no frictions that satisfy all laws, while
                // a longer step may have them.
                Err(error) => {
                    // Errors of longer steps are about states that the mechanism does not reach.
                    let error = unsolved.get_or_insert(error);
                    stepping.step = *longer.next().ok_or_else(|| error.clone())?;
                    continue;
                }
            };
            let each = [&whole, &first, &second].map(|result| &result.time_step.modes[..]);
            let transition = !each.iter().all(|after| same_slip(&modes, after));
            let apart = self.apart(&whole, &second, step);
            // Where velocities grow without bound before they jump, steps with accurate rates would
            // become shorter and shorter, and never reach the jump. Coordinates limit the steps much
            // less there.
            let refines = step > FIRST && !self.has_stiff_laws() && !self.is_switching();
            // The velocities jump if their change in one half of the step is nearly as large as
            // their change in the whole step.
            let all = self.change(&from, &whole.state).max(self.change(&from, &second.state));
            let [early, late] = [(&from, &first.state), (&first.state, &second.state)]
                .map(|(from, to)| self.change(from, to));
            let one = early.max(late);
            // Jumps are compared with the largest rate so far, or with the natural rate times `JUMP`
            // if that is larger.
            let slow = self.fastest_rate.max(JUMP * self.natural_rate());
            let moves = all > STILL * whole.time_step.free_rate;
            let jumps = moves && one > 0.75 * all && all > JUMP * slow;
            let located = jumps && self.jumps_left(time) >= 1.0;
            let smooth = refines && !transition && (located || !jumps);
            let of_rates = if refines { self.rates_apart(&whole, &second) } else { 0.0 };
            let of_smooth = (of_rates / SMOOTH).min(OF_RATES * apart);
            let error = if smooth { apart.max(of_smooth) } else { apart };
            if (error > 1.0 || located) && step > SHORTEST_BEFORE_JUMP && !is_last_resort {
                let factor = if error > 1.0 { (0.8 / error.sqrt()).clamp(0.1, 0.7) } else { 0.25 };
                stepping.step = (step * factor).max(0.9 * SHORTEST_BEFORE_JUMP);
                continue;
            }
            let accurate = error <= 1.0 && !jumps && !is_last_resort;
            let to = if step == left { end } else { time + step };
            let steady = step > SHORTEST_STEADY && one <= STEADY * early.min(late);
            let most = if steady { EXTRAPOLATED } else { SMOOTH };
            let (second, extrapolated) = if smooth && accurate && of_rates <= most {
                self.extrapolated(to, &whole, &first, second, inputs)
            } else {
                (second, false)
            };
            let stops = self.stops(&whole, step);
            let mut refinement = None;
            if refines && accurate && !extrapolated && (transition || smooth) {
                let shorter = step * (0.8 / of_rates).clamp(0.1, 0.7);
                refinement = match self.of_stops(&whole, &stops) {
                    Some((error, time)) if error > 1.0 => Some((BEFORE_STOP * time, true)),
                    _ if of_rates > 1.0 => Some((shorter, false)),
                    _ => None,
                };
            }
            if let Some((shorter, divides)) = refinement
                && let shorter = shorter.max(SHORTEST_AT_TRANSITION)
                && let cost = if divides { STOP } else { REFINEMENT }
                && shorter < step
                && stepping.refinements >= cost
            {
                stepping.refinements -= cost;
                stepping.step = shorter;
                valid = Some(step);
                before_stop = divides.then_some((shorter, step - shorter));
                continue;
            }
            let (mut first, mut second) = (first, second);
            if located || is_last_resort {
                self.jumps = ((self.jumps_left(time) - 1.0).max(0.0), time);
                self.record_jump(&second.time_step, &second.state, time, all);
            }
            let is_impulsive = first.time_step.is_impulsive || second.time_step.is_impulsive;
            if is_impulsive && (jumps || is_last_resort) {
                self.account_for_jump(&mut first, &mut second);
            }
            let grow = if error > 0.0 { (0.8 / error.sqrt()).clamp(0.3, 2.0) } else { 2.0 };
            let next = step * grow;
            // The rest of a step that a stop divides has the same friction as the whole step. A shorter
            // step after a reversal could end between the reversal and the instant to which the
            // friction after the reversal would delay it; friction would stop the motion there.
            let rest = before_stop.filter(|(length, _)| *length == step);
            let next = rest.map_or(next, |(_, rest)| next.max(rest));
            stepping.step = if shortened { next.max(stepping.step) } else { next };
            if step >= super::LEAST_PROGRESS * self.settings.longest_step {
                self.unsolved_steps = 0;
            }
            let before = self.modes.clone();
            self.add(&first.time_step.work);
            self.settle(to, second, inputs);
            let stops: Vec<_> = stops.iter().map(|(k, after)| (*k, time + after)).collect();
            self.record_mode_changes(&before, &stops);
            let same = before
                .iter()
                .zip(&self.modes)
                .all(|(a, b)| std::mem::discriminant(a) == std::mem::discriminant(b));
            stepping.quiet = if same { stepping.quiet + 1 } else { 0 };
            let earned = usize::from(!transition);
            stepping.refinements = REFINEMENTS.min(stepping.refinements + earned);
            self.stepping = Some(stepping);
            return self.leave_stepping(inputs);
        }
    }

    /// Returns the number of velocity jumps that may be located from `time`, s, on. A jump is located,
    /// by shorter steps, if this number is at least one. A jump takes about
    /// thirty steps to locate. Where friction makes a mechanism jump thousands of times in a second,
    /// jumps lie within longer steps, whose error of the coordinates alone is controlled.
    fn jumps_left(&self, time: f64) -> f64 {
        let (left, since) = self.jumps;
        (left + (time - since) / JUMP_INTERVAL).min(JUMPS)
    }

    /// Records a velocity jump as an event. `change` is the largest change of a rate in the step,
    /// which starts at `time`, s, and ends in `state`.
    fn record_jump(&mut self, step: &TimeStep, state: &State<f64>, time: f64, change: f64) {
        let most = (0..step.loads.len()).max_by(|a, b| step.loads[*a].total_cmp(&step.loads[*b]));
        let joint = most.map_or(JointId(0), |c| self.model.reported_joint(c));
        let rates = self.rate_jumps(state);
        self.events.push(Event { time, kind: EventKind::Jump { joint, change, rates } });
    }

    /// Lists the joint rates that differ between the present instant and `after`, sorted by
    /// decreasing change. Omits changes below [`SMALL_PART`] of the largest one; for this
    /// comparison lengths are in characteristic lengths.
    fn rate_jumps(&self, after: &State<f64>) -> Vec<RateJump> {
        let (topology, parameters) = (&self.model.topology, &self.model.parameters);
        let mut bodies = Bodies::new(topology);
        bodies.place(topology, parameters, &after.coordinates);
        bodies.move_with(topology, &after.rates);
        let mut jumps = Vec::new();
        let joints = self.model.mechanism.joints().len();
        for (index, joint_type) in topology.joint_types[..joints].iter().enumerate() {
            if !joint_type.has_scalar_coordinates() {
                continue;
            }
            let before = self.now.bodies.joint_rates(topology, index);
            let after = bodies.joint_rates(topology, index);
            for (dof, own) in joint_type.dofs().iter().enumerate() {
                let scale = if own.translates() { parameters.length } else { 1.0 };
                let (before, after) = (before[dof], after[dof]);
                let size = (after - before).abs() / scale;
                jumps.push((size, RateJump { joint: JointId(index), dof, before, after }));
            }
        }
        jumps.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let least = SMALL_PART * jumps.first().map_or(0.0, |(size, _)| *size);
        jumps.into_iter().filter(|(size, _)| *size > least).map(|(_, jump)| jump).collect()
    }

    fn add(&mut self, work: &Energies) {
        let energies = &mut self.energies;
        let sum = |to: &mut [f64], from: &[f64]| {
            to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
        };
        sum(&mut energies.drives, &work.drives);
        sum(&mut energies.interfaces, &work.interfaces);
        energies.loads += work.loads;
        energies.dampers += work.dampers;
        let each = work.drives.iter().chain(&work.interfaces).map(|w| w.abs());
        energies.turnover += each.sum::<f64>() + work.loads.abs() + work.dampers.abs();
    }

    /// Sets the end of a step as the present instant.
    pub(super) fn settle(&mut self, time: f64, result: StepResult, inputs: &mut dyn Inputs) {
        let StepResult { time_step, state, anchors, frozen } = result;
        self.add(&time_step.work);
        self.bristles.clone_from(&time_step.bristles);
        self.input.values.clone_from(&time_step.input_states);
        self.modes.clone_from(&time_step.modes);
        self.frozen = frozen;
        let before = self.now.account.potential;
        self.now = self.model.instant_of(time, time_step, state, (&self.input, inputs));
        self.energies.turnover += (self.now.account.potential - before).abs();
        // Interfaces that stuck before the step keep their anchors; other interfaces that stick are
        // anchored at the present pose.
        let sticks: Vec<usize> =
            (0..self.modes.len()).filter(|&c| self.modes[c] == InterfaceMode::Sticks).collect();
        let (mut all, _) = self.holds_of(&sticks);
        keep_poses(&mut all, &anchors);
        self.anchors = all;
        self.still();
        self.keep_fastest();
    }
}

/// Resets the pose of each anchor that is also in the list `before` to its pose in that list.
fn keep_poses(anchors: &mut [Anchor], before: &[Anchor]) {
    for anchor in anchors {
        let same = |a: &&Anchor| (a.joint, a.dof) == (anchor.joint, anchor.dof);
        if let Some(kept) = before.iter().find(same) {
            anchor.pose = kept.pose;
        }
    }
}

impl Forward {
    /// Computes the results at the end of a time step. Accelerations and reactions are means over
    /// the step.
    pub(super) fn instant_of(
        &self,
        time: f64,
        time_step: TimeStep,
        state: State<f64>,
        (input, inputs): (&InputState, &mut dyn Inputs),
    ) -> Instant {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let accelerations = time_step.response.accelerations.clone();
        let situation = self.data(
            time,
            state,
            &time_step.bristles,
            &FrictionDistribution::default(),
            (input, inputs),
        );
        let (mut state, mut bodies) = (situation.state, situation.bodies);
        state.accelerations = accelerations;
        bodies.accelerate(topology, &state.accelerations);
        let interfaces: Vec<InterfaceSample> = parameters
            .interfaces
            .iter()
            .enumerate()
            .map(|(k, interface)| InterfaceSample {
                interface: time_step.modes[k],
                velocity: time_step.velocities[k],
                load: time_step.loads[k],
                friction: time_step.frictions[k],
                limit: interface.law_towards(time_step.frictions[k][0]).at_rest()
                    * time_step.loads[k],
            })
            .collect();
        let mut account = Account::default();
        let acting = (&situation.masses, &situation.loads[..]);
        account.update(self, acting, &bodies, &time_step.drives, &interfaces);
        Instant {
            time,
            state,
            bodies,
            drives: time_step.drives,
            gearings: self.gearing_efforts(&time_step.response).collect(),
            wrenches: time_step.response.wrenches,
            interfaces,
            bristle_rates: vec![[0.0; 3]; time_step.modes.len()],
            input_rates: situation.input_rates,
            account,
            coupling: None,
            redundant: time_step.redundant,
            open_drives: time_step.open_drives,
            mobility: time_step.mobility,
            distance: time_step.distance,
            gives_way: None,
            joints: self.mechanism.joints().len(),
        }
    }
}
