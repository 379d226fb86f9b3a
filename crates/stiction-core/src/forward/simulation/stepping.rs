//! The nonsmooth time stepper at work: steps twice with half the length, by their difference shortened and
//! lengthened; when it begins and when it ends.

use super::{Energies, Event, EventKind, Method, Simulation};
use crate::forward::Forward;
use crate::forward::affine_friction::{InterfaceMode, norm};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::instant::{Account, Instant, InterfaceSample};
use crate::forward::project::Anchor;
use crate::forward::time_stepping::{StepStart, TimeStep};
use crate::kinematics::State;
use crate::mechanism::JointId;
use crate::parameters::Parameters;

/// Steps without a change of what sticks and what slides before the events are tried again.
pub(super) const QUIET: usize = 8;
/// The wait doubles each time that the events have proved hopeless, up to this.
pub(super) const LONGEST_WAIT: usize = 4096;
/// The first step, s.
pub(super) const FIRST: f64 = 1e-6;
/// Events so many in number within steps so short on average, s, are left to the time stepper.
const MANY: usize = 40;
pub(super) const DENSE: f64 = 5e-5;
/// Rates below this part of those without friction are none.
const STILL: f64 = 1e-9;
/// Velocities that change by more than this part of the fastest in a step that is as short as can be, and
/// by the same in one half of it, jump.
const JUMP: f64 = 1e-4;
const SHORTEST_BEFORE_JUMP: f64 = 1e-8;

/// The state of the time stepper.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stepping {
    pub(super) step: f64,
    pub(super) quiet: usize,
    pub(super) wait: usize,
}

struct Landed {
    leap: TimeStep,
    state: State<f64>,
    anchors: Vec<Anchor>,
    frozen: Vec<bool>,
}

impl Simulation<'_> {
    /// How time is passed at present: event by event or in steps.
    pub fn method(&self) -> Method {
        if self.stepping.is_some() { Method::TimeStepping } else { Method::EventDriven }
    }

    /// Whether an error of the event-driven method is a reason to go on in steps.
    pub(super) fn may_step(&self, error: &ForwardError) -> bool {
        let holds =
            |c: &InterfaceMode| matches!(c, InterfaceMode::Sticks | InterfaceMode::AtLimit(_));
        self.settings.method == Method::Automatic
            && self.stepping.is_none()
            && match error {
                // Without friction there is nothing that steps of first order do better.
                ForwardError::NoChoice { .. } | ForwardError::Stiff { .. } => {
                    self.affine_frictions()
                }
                // Where something holds, what lets go may have been chosen badly; where all slide there is
                // no acceleration at all.
                ForwardError::NoAcceleration { .. } => self.modes.iter().any(holds),
                _ => false,
            }
    }

    /// Whether anything rubs.
    pub(super) fn affine_frictions(&self) -> bool {
        !self.modes.is_empty()
    }

    /// Whether events have come so close that steps are the better way.
    pub(super) fn is_dense(&mut self) -> bool {
        let (count, since) = self.pace;
        self.pace.0 += 1;
        if count < MANY {
            return false;
        }
        let time = self.now.time;
        self.pace = (0, time);
        self.settings.method == Method::Automatic && time - since < MANY as f64 * DENSE
    }

    pub(super) fn begin_stepping(&mut self) {
        self.stepping = Some(Stepping { step: FIRST, quiet: 0, wait: self.wait });
        let kind = EventKind::Method { method: Method::TimeStepping };
        self.events.push(Event { time: self.now.time, kind });
    }

    /// Anchors and frozen freedoms where these contacts stick; what stuck before keeps its place.
    fn places_of(
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

    /// One step, loops closed after it.
    fn land(
        &mut self,
        time: f64,
        step: f64,
        from: &State<f64>,
        (modes, bristles, near): (&[InterfaceMode], &[[f64; 3]], &[[f64; 3]]),
        inputs: &mut dyn Inputs,
    ) -> Result<Landed, ForwardError> {
        self.evaluations += 1;
        let model = self.model;
        let mut leap = model.time_step(
            time,
            step,
            StepStart { state: from, modes, bristles, frictions: near },
            inputs,
        )?;
        if let Some(stands) = self.stands_while_it_turns(modes, &leap) {
            let near = &leap.frictions;
            let held = model.time_step(
                time,
                step,
                StepStart { state: from, modes: &stands, bristles, frictions: near },
                inputs,
            );
            let stays = |leap: &TimeStep| {
                let each = modes.iter().zip(&stands).zip(&leap.modes);
                each.into_iter().any(|((a, b), after)| a != b && *after == InterfaceMode::Sticks)
            };
            if let Ok(held) = held
                && stays(&held)
            {
                leap = held;
            }
        }
        let mut state = leap.state.clone();
        let targets = model.targets(time + step, inputs);
        let (anchors, mut frozen) = self.places_of(modes, &leap.modes);
        let at_rest = from.rates.iter().all(|rate| *rate == 0.0);
        if at_rest && self.change(from, &state) <= STILL * leap.free_rate {
            // Nothing moves, not even by rounding.
            frozen.fill(true);
        }
        self.restore(from, &mut state, &frozen);
        let time = time + step;
        if frozen.iter().all(|f| *f) {
            return Ok(Landed { leap, state, anchors, frozen });
        }
        model.project(time, &mut state, &targets, &anchors, &frozen)?;
        // What has come to rest is at rest in the new position, too.
        let all: Vec<usize> =
            (0..leap.modes.len()).filter(|&c| leap.modes[c] == InterfaceMode::Sticks).collect();
        let (_, frozen) = self.holds_of(&all);
        model.project(time, &mut state, &targets, &anchors, &frozen)?;
        if !state.coordinates.iter().chain(&state.rates).all(|x| x.is_finite()) {
            return Err(ForwardError::NotFinite { time, what: "a coordinate or a rate" });
        }
        Ok(Landed { leap, state, anchors, frozen })
    }

    /// What contacts do if those that turn back within a step are thought to stand: for an instant they do, and if
    /// friction at rest holds them there they stay. None where friction at rest is no more than in sliding.
    fn stands_while_it_turns(
        &self,
        modes: &[InterfaceMode],
        leap: &TimeStep,
    ) -> Option<Vec<InterfaceMode>> {
        let mut stands = modes.to_vec();
        for (interface, mode) in stands.iter_mut().enumerate() {
            let (InterfaceMode::Slides(before), InterfaceMode::Slides(after)) =
                (*mode, leap.modes[interface])
            else {
                continue;
            };
            let turns = before.iter().zip(after).map(|(a, b)| a * b).sum::<f64>() < 0.0;
            let law = self.model.parameters.interfaces[interface].law_towards(after[0]);
            if turns && law.at_rest() > law.coefficient(norm(leap.velocities[interface])) {
                *mode = InterfaceMode::Sticks;
            }
        }
        (stands != modes).then_some(stands)
    }

    /// Frozen freedoms where they were.
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

    /// The difference of two ends in units of the tolerance: positions, and velocities times the step.
    fn apart(&self, a: &State<f64>, b: &State<f64>, step: f64) -> f64 {
        let tolerance = self.settings.time_step_tolerance;
        let columns = &self.model.columns;
        let count = a.coordinates.len();
        let moved = a.coordinates.iter().zip(&b.coordinates).zip(&self.scales[..count]);
        let moved = moved.map(|((a, b), s)| (a - b).abs() / s);
        let rates = a.rates.iter().zip(&b.rates).zip(columns);
        let rates = rates.map(|((a, b), c)| step * (a - b).abs() / c);
        moved.chain(rates).fold(0.0, f64::max) / tolerance
    }

    /// The largest change of a rate, lengths in characteristic lengths.
    fn change(&self, from: &State<f64>, to: &State<f64>) -> f64 {
        let rates = from.rates.iter().zip(&to.rates).zip(&self.model.columns);
        rates.map(|((a, b), c)| (a - b).abs() / c).fold(0.0, f64::max)
    }

    pub(super) fn step_through(
        &mut self,
        end: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let Some(mut stepping) = self.stepping.clone() else { return Ok(()) };
        let time = self.now.time;
        let from = self.now.state.clone();
        let (modes, bristles) = (self.modes.clone(), self.bristles.clone());
        let shortest = self.settings.shortest_step.max(16.0 * f64::EPSILON * time.abs());
        let longest = self.longest_step(time, inputs);
        loop {
            let left = end - time;
            let mut step = stepping.step.min(longest).min(left);
            if left - step < 0.01 * step {
                step = left;
            }
            let shortened = step < stepping.step;
            let half = 0.5 * step;
            let tried = self.two_halves(time, half, &from, (&modes, &bristles), inputs);
            let (whole, first, second) = match tried {
                Ok(tried) => tried,
                Err(error) => {
                    stepping.step = 0.25 * step;
                    if stepping.step < shortest {
                        return Err(error);
                    }
                    continue;
                }
            };
            let error = self.apart(&whole.state, &second.state, step);
            // A velocity that changes as much in one half as in the whole jumps.
            let all = self.change(&from, &whole.state);
            let one =
                self.change(&from, &first.state).max(self.change(&first.state, &second.state));
            // Slow is what falls freely for a part of the time that its own length takes.
            let Parameters { gravity, length, .. } = &self.model.parameters;
            let slow = self.fastest_rate.max(JUMP * (gravity.norm() / length).sqrt());
            let jumps = one > 0.75 * all && all > JUMP * slow && all > 0.0;
            if (error > 1.0 || jumps) && step > SHORTEST_BEFORE_JUMP {
                let factor = if error > 1.0 { (0.8 / error.sqrt()).clamp(0.1, 0.7) } else { 0.25 };
                stepping.step = (step * factor).max(0.9 * SHORTEST_BEFORE_JUMP);
                continue;
            }
            if jumps {
                self.tell_jump(&second.leap, time, all);
            }
            let grow = if error > 0.0 { (0.8 / error.sqrt()).clamp(0.3, 2.0) } else { 2.0 };
            let next = step * grow;
            stepping.step = if shortened { next.max(stepping.step) } else { next };
            let to = if step == left { end } else { time + step };
            let before = self.modes.clone();
            self.add(&first.leap.work);
            self.settle(to, second, inputs);
            self.tell(&before);
            let same = before
                .iter()
                .zip(&self.modes)
                .all(|(a, b)| std::mem::discriminant(a) == std::mem::discriminant(b));
            stepping.quiet = if same { stepping.quiet + 1 } else { 0 };
            self.stepping = Some(stepping);
            return self.leave_stepping(inputs);
        }
    }

    fn two_halves(
        &mut self,
        time: f64,
        half: f64,
        from: &State<f64>,
        (modes, bristles): (&[InterfaceMode], &[[f64; 3]]),
        inputs: &mut dyn Inputs,
    ) -> Result<(Landed, Landed, Landed), ForwardError> {
        let near: Vec<[f64; 3]> = self.now.interfaces.iter().map(|c| c.friction).collect();
        let whole = self.land(time, 2.0 * half, from, (modes, bristles, &near), inputs)?;
        let near = &whole.leap.frictions;
        let first = self.land(time, half, from, (modes, bristles, near), inputs)?;
        let TimeStep { modes, bristles, frictions, .. } = &first.leap;
        let next = (&modes[..], &bristles[..], &frictions[..]);
        let second = self.land(time + half, half, &first.state, next, inputs)?;
        Ok((whole, first, second))
    }

    fn tell_jump(&mut self, leap: &TimeStep, time: f64, change: f64) {
        let most = (0..leap.loads.len()).max_by(|a, b| leap.loads[*a].total_cmp(&leap.loads[*b]));
        let joint = JointId(most.map_or(0, |c| self.model.parameters.interfaces[c].joint));
        self.events.push(Event { time, kind: EventKind::Jump { joint, change } });
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

    /// The end of a step becomes the present.
    fn settle(&mut self, time: f64, landed: Landed, inputs: &mut dyn Inputs) {
        let Landed { leap, state, anchors, frozen } = landed;
        self.add(&leap.work);
        self.bristles.clone_from(&leap.bristles);
        self.modes.clone_from(&leap.modes);
        self.frozen = frozen;
        let before = self.now.account.potential;
        self.now = self.model.instant_of(time, leap, state, inputs);
        self.energies.turnover += (self.now.account.potential - before).abs();
        // What stuck before is held where it was, what sticks now where it is.
        let sticks: Vec<usize> =
            (0..self.modes.len()).filter(|&c| self.modes[c] == InterfaceMode::Sticks).collect();
        let (mut all, _) = self.holds_of(&sticks);
        keep_poses(&mut all, &anchors);
        self.anchors = all;
        self.still();
        self.keep_fastest();
    }

    /// Goes back to events where nothing has changed for a while and they find what sticks.
    fn leave_stepping(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let Some(stepping) = &mut self.stepping else { return Ok(()) };
        if self.settings.method != Method::Automatic || stepping.quiet < stepping.wait {
            return Ok(());
        }
        let kept = self.clone();
        self.stepping = None;
        self.stalled = 0;
        self.pace = (0, self.now.time);
        self.step = 1e-4 * self.settings.longest_step.min(1.0);
        if self.reconsider(inputs, None).is_ok() {
            let kind = EventKind::Method { method: Method::EventDriven };
            self.events.push(Event { time: self.now.time, kind });
            return Ok(());
        }
        *self = kept;
        if let Some(stepping) = &mut self.stepping {
            stepping.quiet = 0;
            stepping.wait *= 2;
        }
        Ok(())
    }
}

/// What was held before stays where it was.
fn keep_poses(anchors: &mut [Anchor], before: &[Anchor]) {
    for anchor in anchors {
        let same = |a: &&Anchor| (a.joint, a.dof) == (anchor.joint, anchor.dof);
        if let Some(kept) = before.iter().find(same) {
            anchor.pose = kept.pose;
        }
    }
}

impl Forward {
    /// An instant whose accelerations and reactions are the means of the step before it.
    pub(super) fn instant_of(
        &self,
        time: f64,
        leap: TimeStep,
        state: State<f64>,
        inputs: &mut dyn Inputs,
    ) -> Instant {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let accelerations = leap.response.accelerations.clone();
        let situation = self.data(time, state, &leap.bristles, (&[], &[]), inputs);
        let (mut state, mut bodies) = (situation.state, situation.bodies);
        state.accelerations = accelerations;
        bodies.accelerate(topology, &state.accelerations);
        let interfaces: Vec<InterfaceSample> = parameters
            .interfaces
            .iter()
            .enumerate()
            .map(|(k, interface)| InterfaceSample {
                interface: leap.modes[k],
                velocity: leap.velocities[k],
                load: leap.loads[k],
                friction: leap.frictions[k],
                limit: interface.law_towards(leap.frictions[k][0]).at_rest() * leap.loads[k],
            })
            .collect();
        let mut account = Account::default();
        let acting = (&situation.masses, &situation.loads[..]);
        account.update(self, acting, &bodies, &leap.drives, &interfaces);
        Instant {
            time,
            state,
            bodies,
            drives: leap.drives,
            wrenches: leap.response.wrenches,
            interfaces,
            bristle_rates: vec![[0.0; 3]; leap.modes.len()],
            account,
            coupling: None,
            redundant: leap.redundant,
            open_drives: leap.open_drives,
            mobility: leap.mobility,
            distance: leap.distance,
            gives_way: None,
        }
    }
}
