//! Complete state of a simulation as plain numbers.

use super::between::LastStep;
use super::economy::Economy;
use super::method_change::QUIET;
use super::scratch::Scratch;
use super::stepping::Stepping;
use super::{Event, Settings, Simulation};
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::data::FrictionDistribution;
use crate::forward::error::ForwardError;
use crate::forward::inputs::InputState;
use crate::forward::instant::Instant;
use crate::forward::integrator::Steps;
use crate::forward::project::Anchor;
use crate::forward::{Account, Energies, Forward, InterfaceSample};
use crate::kinematics::{Bodies, State};
use crate::spatial::{Mat3, Pose, Twist, Vec3, Wrench};

/// Complete state of a simulation. A resumed simulation continues bit for bit as if it had not been
/// interrupted. The checkpoint contains the integrated internal states of the inputs, but no other
/// state of controllers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checkpoint {
    /// State of the simulation. The meaning and order of the numbers are internal and may change
    /// between versions.
    pub numbers: Vec<f64>,
    /// Events before this state. The list may be cleared; the event list of a resumed simulation is
    /// then initially empty.
    pub events: Vec<Event>,
}

/// First number of a checkpoint: the version of its format.
pub(super) const FORMAT: f64 = 16.0;

/// Largest valid count. A larger number means that the checkpoint is invalid.
const COUNTABLE: f64 = 1e15;

/// Largest valid number of internal states of the inputs, and of switching functions.
const MOST_INPUTS: usize = 1_000_000;

/// Writer or reader of the numbers of a checkpoint. Both use the same sequence of calls, which
/// guarantees the same order of the numbers.
pub(super) enum Tape<'a> {
    Out(&'a mut Vec<f64>),
    /// Reader: the remaining numbers, and a flag that is set if a number is missing or a count is
    /// invalid.
    In(std::slice::Iter<'a, f64>, bool),
}

impl Tape<'_> {
    fn number(&mut self, x: &mut f64) {
        match self {
            Self::Out(numbers) => numbers.push(*x),
            Self::In(rest, wrong) => match rest.next() {
                Some(number) => *x = *number,
                None => *wrong = true,
            },
        }
    }

    fn numbers<'x>(&mut self, all: impl IntoIterator<Item = &'x mut f64>) {
        all.into_iter().for_each(|x| self.number(x));
    }

    fn count(&mut self, x: &mut usize) {
        let mut number = *x as f64;
        self.number(&mut number);
        if let Self::In(_, wrong) = self {
            *wrong |= !(0.0..=COUNTABLE).contains(&number);
        }
        *x = number as usize;
    }

    fn flag(&mut self, x: &mut bool) {
        let mut number = f64::from(u8::from(*x));
        self.number(&mut number);
        *x = number != 0.0;
    }

    fn vector(&mut self, v: &mut Vec3<f64>) {
        self.numbers([&mut v.x, &mut v.y, &mut v.z]);
    }

    fn twist(&mut self, t: &mut Twist<f64>) {
        self.vector(&mut t.angular);
        self.vector(&mut t.linear);
    }

    fn wrench(&mut self, w: &mut Wrench<f64>) {
        self.vector(&mut w.force);
        self.vector(&mut w.moment);
    }

    fn pose(&mut self, pose: &mut Pose<f64>) {
        let mut columns = pose.rotation.columns;
        columns.iter_mut().for_each(|c| self.vector(c));
        pose.rotation = Mat3::from_columns(columns[0], columns[1], columns[2]);
        self.vector(&mut pose.position);
    }

    fn option(&mut self, x: &mut Option<f64>) {
        let mut some = x.is_some();
        self.flag(&mut some);
        let mut number = x.unwrap_or(0.0);
        self.number(&mut number);
        *x = some.then_some(number);
    }

    fn mode(&mut self, mode: &mut InterfaceMode) {
        let (mut kind, mut direction) = match *mode {
            InterfaceMode::Smooth => (0, [0.0; 3]),
            InterfaceMode::Slides(d) => (1, d),
            InterfaceMode::Sticks => (2, [0.0; 3]),
            InterfaceMode::AtLimit(d) => (3, d),
        };
        self.count(&mut kind);
        self.numbers(&mut direction);
        *mode = match kind {
            0 => InterfaceMode::Smooth,
            1 => InterfaceMode::Slides(direction),
            2 => InterfaceMode::Sticks,
            _ => InterfaceMode::AtLimit(direction),
        };
    }
}

impl<'a> Simulation<'a> {
    /// Returns the complete state. If results are shown at an instant within a step, the checkpoint
    /// contains the state at the start of this step, so that a resumed simulation takes the same
    /// steps. Inputs must save their own state at the start of the step, see
    /// [`Inputs::begin_step`](crate::forward::Inputs::begin_step).
    pub fn checkpoint(&mut self) -> Checkpoint {
        Checkpoint { numbers: self.checkpoint_numbers(), events: self.recorded_events().to_vec() }
    }

    /// Returns the numbers of [`Self::checkpoint`], without a copy of the events.
    pub fn checkpoint_numbers(&mut self) -> Vec<f64> {
        let mut numbers = Vec::with_capacity(1 + self.last_step.numbers.len());
        numbers.push(FORMAT);
        match self.last_step.shows {
            true => numbers.extend_from_slice(&self.last_step.numbers),
            false => self.pass(&mut Tape::Out(&mut numbers)),
        }
        numbers
    }

    /// Returns the events that [`Self::checkpoint`] would store if it were called now.
    pub fn recorded_events(&self) -> &[Event] {
        let LastStep { shows, events, .. } = self.last_step;
        if shows { &self.events[..events] } else { &self.events }
    }

    /// Restores the state from numbers that [`Self::pass`] wrote.
    pub(super) fn take_state(&mut self, numbers: &[f64]) {
        self.pass(&mut Tape::In(numbers.iter(), false));
        self.place();
    }

    /// Recomputes the poses and twists of the bodies.
    fn place(&mut self) {
        let Forward { topology, parameters, .. } = self.model;
        let Instant { state, bodies, .. } = &mut self.now;
        bodies.place(topology, parameters, &state.coordinates);
        bodies.move_with(topology, &state.rates);
    }

    /// Writes the state to a tape, or reads it. Writing does not change a valid state.
    pub(super) fn pass(&mut self, tape: &mut Tape<'_>) {
        let now = &mut self.now;
        tape.number(&mut now.time);
        let State { coordinates, rates, accelerations } = &mut now.state;
        tape.numbers(coordinates.iter_mut().chain(rates).chain(accelerations));
        now.bodies.acceleration.iter_mut().for_each(|t| tape.twist(t));
        tape.numbers(now.drives.iter_mut().chain(&mut now.gearings));
        now.wrenches.iter_mut().for_each(|w| tape.wrench(w));
        for interface in &mut now.interfaces {
            tape.mode(&mut interface.interface);
            tape.numbers(&mut interface.velocity);
            tape.number(&mut interface.load);
            tape.numbers(&mut interface.friction);
            tape.number(&mut interface.limit);
        }
        tape.numbers(now.bristle_rates.iter_mut().flatten());
        let account = &mut now.account;
        tape.numbers([&mut account.kinetic, &mut account.potential, &mut account.exchange]);
        tape.numbers(account.drives.iter_mut().chain(&mut account.interfaces));
        tape.numbers([&mut account.loads, &mut account.dampers]);
        tape.option(&mut now.coupling);
        tape.count(&mut now.redundant);
        tape.count(&mut now.open_drives);
        tape.count(&mut now.mobility);
        tape.number(&mut now.distance);
        let mut gives_way = now.gives_way.map_or(0, |interface| interface + 1);
        tape.count(&mut gives_way);
        now.gives_way = gives_way.checked_sub(1);
        self.modes.iter_mut().for_each(|m| tape.mode(m));
        let mut anchors = self.anchors.len();
        tape.count(&mut anchors);
        let none = Anchor { joint: 0, dof: 0, pose: Pose::identity() };
        // A joint has at most six degrees of freedom, so larger numbers are invalid.
        self.anchors.resize(anchors.min(6 * self.model.topology.joint_types.len()), none);
        for anchor in &mut self.anchors {
            tape.count(&mut anchor.joint);
            tape.count(&mut anchor.dof);
            tape.pose(&mut anchor.pose);
        }
        self.frozen.iter_mut().for_each(|f| tape.flag(f));
        tape.numbers(self.bristles.iter_mut().flatten());
        tape.numbers(&mut self.distribution.scales);
        tape.numbers(self.distribution.reference_frictions.iter_mut().flatten());
        tape.number(&mut self.distribution.reaction_weight);
        let mut reactions = self.distribution.reference_reactions.len();
        tape.count(&mut reactions);
        let joints = self.model.topology.joint_types.len();
        self.distribution.reference_reactions.resize(reactions.min(6 * joints), 0.0);
        tape.numbers(&mut self.distribution.reference_reactions);
        tape.number(&mut self.limit_factor);
        for angle in &mut self.input.angles {
            tape.numbers([&mut angle.value, &mut angle.rate, &mut angle.time]);
        }
        let InputState { values, scales, sides, angles: _ } = &mut self.input;
        let (mut states, mut switches) = (values.len(), sides.len());
        tape.count(&mut states);
        tape.count(&mut switches);
        let (states, switches) = (states.min(MOST_INPUTS), switches.min(MOST_INPUTS));
        values.resize(states, 0.0);
        scales.resize(states, 0.0);
        now.input_rates.resize(states, 0.0);
        tape.numbers(values.iter_mut().chain(scales).chain(&mut now.input_rates));
        sides.resize(switches, false);
        self.switching.resize(switches, false);
        sides.iter_mut().chain(&mut self.switching).for_each(|side| tape.flag(side));
        let mut ahead = Some(self.switch_at).filter(|time| time.is_finite());
        tape.option(&mut ahead);
        self.switch_at = ahead.unwrap_or(f64::INFINITY);
        tape.count(&mut self.switches_at_once.0);
        tape.number(&mut self.switches_at_once.1);
        let mut ended = self.ended_by.map_or(0, |switch| switch + 1);
        tape.count(&mut ended);
        self.ended_by = ended.checked_sub(1);
        let mut shortened = Some(self.shortened_at).filter(|time| time.is_finite());
        tape.option(&mut shortened);
        self.shortened_at = shortened.unwrap_or(f64::NEG_INFINITY);
        tape.count(&mut self.chatter.0);
        tape.numbers([&mut self.chatter.1, &mut self.chatter.2]);
        let energies = &mut self.energies;
        tape.numbers(energies.drives.iter_mut().chain(&mut energies.interfaces));
        tape.numbers([&mut energies.loads, &mut energies.dampers, &mut energies.turnover]);
        tape.numbers([&mut energies.impacts, &mut energies.payloads]);
        tape.numbers([&mut self.energy_at_start, &mut self.fastest, &mut self.fastest_rate]);
        tape.numbers([&mut self.coarsest, &mut self.step]);
        tape.numbers(&mut self.longest_of_lower_order);
        tape.number(&mut self.motion_since_bound);
        tape.number(&mut self.bound_reach);
        tape.flag(&mut self.in_passage);
        tape.flag(&mut self.program_failed);
        tape.flag(&mut self.reported_others);
        tape.count(&mut self.reported_shares);
        tape.count(&mut self.stalled);
        tape.count(&mut self.evaluations);
        tape.count(&mut self.event_rate.0);
        tape.number(&mut self.event_rate.1);
        tape.number(&mut self.dropped);
        tape.numbers([&mut self.jumps.0, &mut self.jumps.1]);
        tape.count(&mut self.stiff.0);
        tape.count(&mut self.stiff.1);
        tape.count(&mut self.crawling);
        tape.count(&mut self.progress.0);
        tape.number(&mut self.progress.1);
        tape.count(&mut self.unsolved_steps);
        tape.count(&mut self.wait);
        let Economy { work, window, phase } = &mut self.economy;
        tape.count(work);
        tape.count(&mut window.0);
        tape.numbers([&mut window.1, &mut phase.0, &mut phase.1]);
        let mut steps = self.stepping.is_some();
        tape.flag(&mut steps);
        let none = Stepping { step: 0.0, quiet: 0, wait: 0, refinements: 0 };
        let stepping = self.stepping.get_or_insert(none);
        tape.number(&mut stepping.step);
        tape.count(&mut stepping.quiet);
        tape.count(&mut stepping.wait);
        tape.count(&mut stepping.refinements);
        if !steps {
            self.stepping = None;
        }
    }
}

impl Forward {
    /// Resumes a simulation from a checkpoint of a simulation of the same mechanism, with the same
    /// or different settings.
    ///
    /// # Errors
    /// [`ForwardError::Checkpoint`] if the numbers do not belong to a simulation of this mechanism.
    pub fn resume(
        &self,
        checkpoint: &Checkpoint,
        settings: Settings,
    ) -> Result<Simulation<'_>, ForwardError> {
        let topology = &self.topology;
        let (joints, interfaces) = (topology.joint_types.len(), self.parameters.interfaces.len());
        let interface = InterfaceSample {
            interface: InterfaceMode::Smooth,
            velocity: [0.0; 3],
            load: 0.0,
            friction: [0.0; 3],
            limit: 0.0,
        };
        let drives = vec![0.0; topology.actuators.len()];
        let each = vec![0.0; interfaces];
        let now = Instant {
            time: 0.0,
            state: State::new(topology),
            bodies: Bodies::new(topology),
            drives: drives.clone(),
            gearings: vec![0.0; self.mechanism.gearings().len()],
            wrenches: vec![Wrench::zero(); joints],
            interfaces: vec![interface; interfaces],
            bristle_rates: vec![[0.0; 3]; interfaces],
            input_rates: Vec::new(),
            account: Account {
                drives: drives.clone(),
                interfaces: each.clone(),
                ..Account::default()
            },
            coupling: None,
            redundant: 0,
            open_drives: 0,
            mobility: 0,
            distance: 0.0,
            gives_way: None,
            joints: self.mechanism.joints().len(),
        };
        let angles = self.angles(0.0, &now.state, &now.bodies);
        let mut simulation = Simulation {
            model: self,
            settings,
            now,
            modes: vec![InterfaceMode::Smooth; interfaces],
            anchors: Vec::new(),
            frozen: vec![false; topology.dofs()],
            bristles: vec![[0.0; 3]; interfaces],
            distribution: FrictionDistribution::even(interfaces),
            limit_factor: 1.0,
            input: InputState { angles, ..InputState::default() },
            switch_at: f64::INFINITY,
            switching: Vec::new(),
            ended_by: None,
            switches_at_once: (0, 0.0),
            shortened_at: f64::NEG_INFINITY,
            chatter: (0, 0.0, 0.0),
            energies: Energies { drives, interfaces: each, ..Energies::default() },
            energy_at_start: 0.0,
            fastest: 0.0,
            fastest_rate: 0.0,
            coarsest: 0.0,
            step: 0.0,
            longest_of_lower_order: [0.0; 2],
            program_failed: false,
            motion_since_bound: 0.0,
            bound_reach: 1.0,
            events: checkpoint.events.clone(),
            in_passage: false,
            reported_others: false,
            reported_shares: 0,
            stalled: 0,
            steps: Steps::default(),
            scales: Vec::new(),
            evaluations: 0,
            stepping: None,
            event_rate: (0, 0.0),
            dropped: 0.0,
            jumps: (0.0, 0.0),
            stiff: (0, 0),
            crawling: 0,
            progress: (0, 0.0),
            unsolved_steps: 0,
            wait: QUIET,
            economy: Economy::new(0.0),
            workspace: Box::new(Scratch::new(self)),
            lists: Vec::new(),
            last_step: LastStep::default(),
            change_at: f64::INFINITY,
        };
        let Some((&FORMAT, numbers)) = checkpoint.numbers.split_first() else {
            return Err(ForwardError::Checkpoint);
        };
        let mut tape = Tape::In(numbers.iter(), false);
        simulation.pass(&mut tape);
        let Tape::In(rest, wrong) = tape else { return Err(ForwardError::Checkpoint) };
        let joints_fit = simulation.anchors.iter().all(|anchor| {
            let joint_type = topology.joint_types.get(anchor.joint);
            joint_type.is_some_and(|joint_type| anchor.dof < joint_type.dofs().len())
        });
        let sound = numbers.iter().all(|x| x.is_finite());
        if wrong || rest.len() > 0 || !sound || !joints_fit {
            return Err(ForwardError::Checkpoint);
        }
        simulation.place();
        simulation.scales = simulation.error_scales();
        Ok(simulation)
    }
}
