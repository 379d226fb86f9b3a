//! A mechanism on its way through time: steps, events, and the account of energy.

use super::Forward;
use super::error::{Competitor, ForwardError};
use super::evaluate::Instant;
use super::inputs::{Inputs, View};
use super::integrator::{Steps, Tolerance};
use super::project::Anchor;
use super::rub::{Contact, is_smooth, norm};
use super::stick::Choice;
use crate::kinematics::State;
use crate::mechanism::JointId;
use crate::topology::Role;

/// How accurately, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Error of a step in units of the numbers themselves.
    pub relative: f64,
    /// Error of a step, rad and rad/s, or in characteristic lengths.
    pub absolute: f64,
    /// The longest step, s. Where nothing moves steps grow to it, and inputs between its stages are
    /// not seen.
    pub longest_step: f64,
    /// Steps shorter than this, s, end the simulation.
    pub shortest_step: f64,
    /// Whether other solutions are looked for where uniqueness is not certain.
    pub look_for_others: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            relative: 1e-10,
            absolute: 1e-12,
            longest_step: 0.1,
            shortest_step: 1e-14,
            look_for_others: true,
        }
    }
}

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// s.
    pub time: f64,
    /// What.
    pub kind: EventKind,
}

/// What can happen.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// A contact stops and sticks.
    Sticks {
        /// Index of the contact among all.
        contact: usize,
        /// Its joint.
        joint: JointId,
    },
    /// A contact begins to slide, or slides back.
    Slides {
        /// Index of the contact among all.
        contact: usize,
        /// Its joint.
        joint: JointId,
        /// Where to, along its freedoms.
        direction: [f64; 3],
    },
    /// More contacts stick than are needed to hold the mechanism: how they share the load does not follow
    /// from the laws. They share it in proportion to what they can bear (least squares); where that is
    /// beyond a limit, otherwise within all limits; where there is no room left, within 1e-5 of them.
    SharesNotUnique {
        /// How many shares are open.
        redundant: usize,
    },
    /// Other motions satisfy all laws as well; the one that goes on is connected with no friction.
    NotUnique {
        /// The joint whose load differs most.
        joint: JointId,
        /// See [`Instant::coupling`].
        coupling: f64,
        /// The others that were found.
        others: Vec<Competitor>,
    },
}

/// Work done since the start, J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energies {
    /// By each actuator.
    pub drives: Vec<f64>,
    /// By all loads.
    pub loads: f64,
    /// Dissipated in dampers.
    pub dampers: f64,
    /// Dissipated in each contact; of bristles with what they store.
    pub contacts: Vec<f64>,
    /// All powers summed as magnitudes.
    pub turnover: f64,
}

/// Contacts slower than this part of the fastest rest.
const REST: f64 = 1e-10;
/// How far beyond its limit friction is where a contact lets go: more than the search forgives.
const LET_GO: f64 = 1e-9;
/// Conditions that are as close to dependent as this: stages of steps are moved onto the loops, too.
const NEAR_SINGULAR: f64 = 0.2;
/// Events at one time, at most.
const EVENTS_AT_ONCE: usize = 200;

/// A mechanism on its way through time.
#[derive(Clone, Debug)]
pub struct Simulation<'a> {
    model: &'a Forward,
    settings: Settings,
    now: Instant,
    modes: Vec<Contact>,
    anchors: Vec<Anchor>,
    frozen: Vec<bool>,
    bristles: Vec<[f64; 3]>,
    grips: Vec<f64>,
    shares: Vec<[f64; 3]>,
    overload: f64,
    energies: Energies,
    energy_at_start: f64,
    fastest: f64,
    /// Of the tree, lengths in characteristic lengths.
    fastest_rate: f64,
    step: f64,
    events: Vec<Event>,
    told_of_others: bool,
    told_of_shares: usize,
    stalled: usize,
    steps: Steps,
    scales: Vec<f64>,
    evaluations: usize,
}

/// What a step ended with.
enum Ending {
    /// Nothing happened.
    Smooth,
    /// A contact's velocity is zero.
    Stops(usize),
    /// A contact's friction is at its limit.
    LetsGo,
}

impl Forward {
    /// Starts at a state, which is moved to where loops are closed.
    ///
    /// # Errors
    /// See [`ForwardError`].
    pub fn start(
        &self,
        time: f64,
        state: State<f64>,
        settings: Settings,
        inputs: &mut dyn Inputs,
    ) -> Result<Simulation<'_>, ForwardError> {
        Simulation::new(self, time, state, settings, inputs)
    }
}

impl<'a> Simulation<'a> {
    fn new(
        model: &'a Forward,
        time: f64,
        mut state: State<f64>,
        settings: Settings,
        inputs: &mut dyn Inputs,
    ) -> Result<Self, ForwardError> {
        let contacts = &model.parameters.contacts;
        let bristles = vec![[0.0; 3]; contacts.len()];
        let frozen = vec![false; model.topology.freedoms()];
        let targets = model.targets(time, inputs);
        model.project(time, &mut state, &targets, &[], &frozen)?;
        let mut bodies = crate::kinematics::Bodies::new(&model.topology);
        bodies.place(&model.topology, &model.parameters, &state.coordinates);
        bodies.move_with(&model.topology, &state.rates);
        inputs.change(&View { time, state: &state, bodies: &bodies, topology: &model.topology });
        let mut ground = model.ground(time, state, &bristles, (&[], &[]), inputs);
        let fastest = ground.velocities.iter().map(|v| norm(*v)).fold(0.0, f64::max);
        let mut modes = Vec::with_capacity(contacts.len());
        let mut resting = Vec::new();
        for (index, contact) in contacts.iter().enumerate() {
            let velocity = ground.velocities[index];
            let speed = norm(velocity);
            modes.push(if is_smooth(contact) {
                Contact::Smooth
            } else if speed <= REST * fastest {
                resting.push(index);
                Contact::Sticks
            } else {
                Contact::Slides(velocity.map(|v| v / speed))
            });
        }
        let Choice { modes, solved } = model.choose(&mut ground, &modes, &resting)?;
        let (grips, shares) = (ground.grips.clone(), ground.shares.clone());
        let overload = ground.overload;
        let now = model.instant(ground, &modes, &solved);
        let energies = Energies {
            drives: vec![0.0; model.topology.actuators.len()],
            contacts: vec![0.0; contacts.len()],
            ..Energies::default()
        };
        let mut simulation = Self {
            model,
            settings,
            energy_at_start: now.account.kinetic + now.account.potential,
            now,
            modes: modes.clone(),
            anchors: Vec::new(),
            frozen,
            bristles,
            grips,
            shares,
            overload,
            energies,
            fastest,
            fastest_rate: 0.0,
            step: 0.0,
            events: Vec::new(),
            told_of_others: false,
            told_of_shares: 0,
            stalled: 0,
            steps: Steps::default(),
            scales: Vec::new(),
            evaluations: 0,
        };
        simulation.scales = simulation.error_scales();
        simulation.hold(inputs)?;
        simulation.look_for_others(inputs)?;
        simulation.step = 1e-4 * settings.longest_step.min(1.0);
        Ok(simulation)
    }

    /// Everything at the present instant.
    pub fn instant(&self) -> &Instant {
        &self.now
    }

    /// What happened since the start.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// What each contact does.
    pub fn contacts(&self) -> &[Contact] {
        &self.modes
    }

    /// Work since the start.
    pub fn energies(&self) -> &Energies {
        &self.energies
    }

    /// Kinetic and potential energy less what was put in and plus what was dissipated since the start:
    /// what is lost to errors, J.
    pub fn energy_error(&self) -> f64 {
        let Energies { drives, loads, dampers, contacts, .. } = &self.energies;
        let now = self.now.account.kinetic + self.now.account.potential;
        let put_in = drives.iter().sum::<f64>() + loads;
        now - self.energy_at_start - put_in + dampers + contacts.iter().sum::<f64>()
    }

    /// How often accelerations were computed.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Goes on to a time.
    ///
    /// # Errors
    /// See [`ForwardError`]; the last good instant stays.
    pub fn advance(&mut self, until: f64, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        while self.now.time < until {
            let change = inputs.next_change(self.now.time).filter(|t| *t <= until);
            let end = change.unwrap_or(until);
            while self.now.time < end {
                self.advance_once(end, inputs)?;
            }
            if change.is_some() {
                let (state, bodies) = (&self.now.state, &self.now.bodies);
                let topology = &self.model.topology;
                inputs.change(&View { time: end, state, bodies, topology });
                self.reconsider(inputs, None)?;
            }
        }
        Ok(())
    }

    /// One step, and what happens at its end.
    fn advance_once(&mut self, end: f64, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let time = self.now.time;
        self.look_along();
        let start = self.pack();
        let first = self.derivative_of(&self.now);
        let longest = self.settings.longest_step;
        loop {
            let left = end - time;
            let mut step = self.step.min(longest).min(left);
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
                        Ok(after) => after,
                        // At its end there is no acceleration: come nearer, if possible.
                        Err(error) => {
                            self.shrink(step, 0.25, Some(error))?;
                            continue;
                        }
                    };
                    self.step = if shortened { next.max(self.step) } else { next };
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

    fn shrink(
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

    fn try_step(
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
    fn finish(
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
            self.commit(&y, arrived);
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
            // A ball or plate passes near rest without stopping, unless it is slow enough.
            let speed = norm(arrived.contacts[contact].velocity);
            if speed > 1e3 * self.settings.absolute.max(REST * self.fastest) {
                ending = Ending::Smooth;
            }
        }
        self.commit(&y, arrived);
        Ok(ending)
    }

    /// How fast a contact slides in its sense, and the change of that.
    fn closing_speed(&self, at: &Instant, contact: usize) -> (f64, f64) {
        let Contact::Slides(direction) = self.modes[contact] else { return (0.0, 1.0) };
        let dot = |v: [f64; 3]| v.iter().zip(direction).map(|(v, d)| v * d).sum::<f64>();
        (dot(at.contacts[contact].velocity), dot(self.surface_acceleration(at, contact)))
    }

    fn surface_acceleration(&self, at: &Instant, contact: usize) -> [f64; 3] {
        let (topology, parameters) = (&self.model.topology, &self.model.parameters);
        let content = &parameters.contacts[contact];
        let (predecessor, successor) = topology.ends[content.joint];
        let own = at.bodies.joint_bias(topology, parameters, content.joint);
        let relative =
            at.bodies.acceleration[successor] - at.bodies.acceleration[predecessor] - own;
        let arms = content.arms(parameters.pitch[content.joint]);
        let freedoms = topology.joint_types[content.joint].freedoms();
        let mut surface = [0.0; 3];
        for ((value, arm), freedom) in
            surface.iter_mut().zip(arms).zip(&freedoms[content.shape.freedoms()])
        {
            *value = arm * relative.power(at.bodies.effort(freedom, content.joint));
        }
        surface
    }

    /// The first event within the last step: its part of the step, and what it is.
    fn first_event(
        &mut self,
        time: f64,
        step: f64,
        arrived: &Instant,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<(f64, Ending)>, ForwardError> {
        let mut suspects = Vec::new();
        let mut holds = false;
        for contact in 0..self.modes.len() {
            match self.modes[contact] {
                Contact::Slides(_) => {
                    let (v0, a0) = self.closing_speed(&self.now, contact);
                    let (v1, a1) = self.closing_speed(arrived, contact);
                    if v1 < 0.0 || dips((v0, a0 * step), (v1, a1 * step)) {
                        suspects.push(contact);
                    }
                }
                Contact::Sticks => holds = true,
                Contact::Smooth | Contact::AtLimit(_) => {}
            }
        }
        if suspects.is_empty() && !holds {
            return Ok(None);
        }
        // The curve between.
        let last = self.derivative_of(arrived);
        let mut steps = std::mem::take(&mut self.steps);
        let prepared = steps.interpolate(time, &last, |t, y| self.derivative(t, y, inputs));
        self.steps = steps;
        prepared?;
        let mut first: Option<(f64, Ending)> = None;
        for contact in suspects {
            if let Some(part) = self.stop_within(time, step, contact, inputs)?
                && first.as_ref().is_none_or(|(before, _)| part < *before)
            {
                first = Some((part, Ending::Stops(contact)));
            }
        }
        if holds {
            let until = first.as_ref().map_or(1.0, |(part, _)| *part);
            if let Some(part) = self.let_go_within(time, step, until, arrived, inputs)? {
                first = Some((part, Ending::LetsGo));
            }
        }
        Ok(first)
    }

    /// The part of the step at which a contact's velocity falls through zero.
    fn stop_within(
        &mut self,
        time: f64,
        step: f64,
        contact: usize,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<f64>, ForwardError> {
        const PIECES: usize = 16;
        let speed = |part: f64| {
            let y = self.steps.at(part);
            let (state, _) = self.unpack(&y);
            let (topology, parameters) = (&self.model.topology, &self.model.parameters);
            let mut bodies = crate::kinematics::Bodies::new(topology);
            bodies.place(topology, parameters, &state.coordinates);
            bodies.move_with(topology, &state.rates);
            let content = &parameters.contacts[contact];
            let velocity = super::rub::surface_velocity(topology, parameters, &bodies, content);
            let Contact::Slides(direction) = self.modes[contact] else { return 1.0 };
            velocity.iter().zip(direction).map(|(v, d)| v * d).sum()
        };
        let _ = (time, step, inputs);
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
        let Some((part, value)) = below else { return Ok(None) };
        let at_before = speed(before);
        if before == 0.0 && at_before <= 0.0 {
            // It leaves rest backwards at once: rounding of what was just decided.
            return Ok((value.abs() > REST * self.fastest).then_some(0.5 * part));
        }
        Ok(Some(root((before, at_before), (part, value), speed)))
    }

    /// The part of the step, up to `until`, at which friction that holds is beyond its limit.
    fn let_go_within(
        &mut self,
        time: f64,
        step: f64,
        until: f64,
        arrived: &Instant,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<f64>, ForwardError> {
        let overload = self.overload;
        let least = |at: &Instant| {
            let sticks = at.contacts.iter().filter(|c| c.contact == Contact::Sticks);
            let relative = sticks.map(|c| {
                let has = norm(c.friction);
                let size = c.limit.max(has).max(f64::MIN_POSITIVE);
                (c.limit * overload * (1.0 + LET_GO) - has) / size
            });
            relative.fold(f64::INFINITY, f64::min)
        };
        let mut before = (0.0, least(&self.now).max(f64::MIN_POSITIVE));
        for piece in 1..=4 {
            let part = until * f64::from(piece) / 4.0;
            let value = if part == 1.0 {
                least(arrived)
            } else {
                let y = self.steps.at(part);
                least(&self.evaluate(time + part * step, &y, inputs, false)?)
            };
            if value < 0.0 {
                let (mut low, mut high) = (before, (part, value));
                // Illinois: an end that stays counts half.
                for _ in 0..60 {
                    if (high.0 - low.0) * step <= 4.0 * f64::EPSILON * (time + step).abs()
                        || high.0 - low.0 < 1e-12
                    {
                        break;
                    }
                    let mut middle = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
                    let margin = 0.01 * (high.0 - low.0);
                    middle = middle.clamp(low.0 + margin, high.0 - margin);
                    let y = self.steps.at(middle);
                    let value = least(&self.evaluate(time + middle * step, &y, inputs, false)?);
                    if value < 0.0 {
                        high = (middle, value);
                        low.1 *= 0.5;
                    } else {
                        low = (middle, value);
                        high.1 *= 0.5;
                    }
                }
                return Ok(Some(high.0));
            }
            before = (part, value);
        }
        Ok(None)
    }

    fn follow_up(&mut self, ending: Ending, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        match ending {
            Ending::Smooth => {
                self.stalled = 0;
                self.look_for_others(inputs)?;
                let slid = self.modes.iter().zip(&self.now.contacts).any(|(mode, moment)| {
                    matches!(mode, Contact::AtLimit(_))
                        && norm(moment.velocity) > REST * self.fastest
                });
                if slid { self.reconsider(inputs, None) } else { Ok(()) }
            }
            Ending::Stops(contact) => self.reconsider(inputs, Some(contact)),
            Ending::LetsGo => self.reconsider(inputs, None),
        }
    }

    /// Decides anew what sticks and what slides among all that is at rest, `stopped` among them.
    fn reconsider(
        &mut self,
        inputs: &mut dyn Inputs,
        stopped: Option<usize>,
    ) -> Result<(), ForwardError> {
        self.stalled += 1;
        let model = self.model;
        let time = self.now.time;
        if self.stalled > EVENTS_AT_ONCE {
            return Err(ForwardError::Stiff {
                time,
                step: 0.0,
                tolerance: self.settings.relative,
                around: match stopped {
                    Some(contact) => {
                        let joint = model.joint_name(model.parameters.contacts[contact].joint);
                        format!(" (joint `{joint}` stops and goes without end)")
                    }
                    None => String::new(),
                },
            });
        }
        let mut state = self.now.state.clone();
        let targets = model.targets(time, inputs);
        if let Some(contact) = stopped {
            // At rest to the last digit, and with it all that it holds.
            let (anchors, frozen) = self.holds_of(&[contact]);
            let frozen: Vec<bool> =
                frozen.iter().zip(&self.frozen).map(|(a, b)| *a || *b).collect();
            let anchors: Vec<Anchor> = self.anchors.iter().copied().chain(anchors).collect();
            model.project(time, &mut state, &targets, &anchors, &frozen)?;
            if self.moves_on(&state) {
                return self.reverse(contact, inputs);
            }
        }
        let mut ground =
            model.ground(time, state, &self.bristles, (&self.grips, &self.shares), inputs);
        if let Some(contact) = stopped
            && !self.takes_freedom(&ground, contact)
        {
            return self.reverse(contact, inputs);
        }
        let before = self.modes.clone();
        let mut modes = self.modes.clone();
        let mut resting = Vec::new();
        for (index, mode) in modes.iter_mut().enumerate() {
            let speed = norm(ground.velocities[index]);
            if *mode == Contact::Smooth {
                continue;
            }
            if speed <= REST * self.fastest || stopped == Some(index) || *mode == Contact::Sticks {
                resting.push(index);
            } else if matches!(mode, Contact::AtLimit(_)) {
                *mode = Contact::Slides(ground.velocities[index].map(|v| v / speed));
            }
        }
        let Choice { modes, solved } = model.choose(&mut ground, &modes, &resting)?;
        self.grips.clone_from(&ground.grips);
        self.shares.clone_from(&ground.shares);
        self.overload = ground.overload;
        self.modes = modes;
        self.now = model.instant(ground, &self.modes, &solved);
        self.tell(&before);
        self.hold(inputs)?;
        self.look_for_others(inputs)?;
        // What begins anew is looked at closely first.
        self.step = (0.1 * self.step).max(1e3 * self.settings.shortest_step);
        Ok(())
    }

    /// Whether these rates are others than the present ones, beyond rounding: then the contact's zero
    /// velocity is one of a dead centre, through which the mechanism moves on.
    fn moves_on(&self, stopped: &State<f64>) -> bool {
        const OTHER: f64 = 1e-6;
        let columns = &self.model.columns;
        let size = |x: &dyn Fn(usize) -> f64| {
            columns.iter().enumerate().map(|(k, c)| (x(k) / c).abs()).fold(0.0, f64::max)
        };
        let rates = &self.now.state.rates;
        let change = size(&|k| stopped.rates[k] - rates[k]);
        change > OTHER * size(&|k| rates[k]) && change > OTHER * self.fastest_rate
    }

    /// Whether the mechanism has less freedom when this contact sticks. At a dead centre it has not: the
    /// contact stands while all moves on.
    fn takes_freedom(&self, ground: &super::evaluate::Ground, contact: usize) -> bool {
        let model = self.model;
        let mut sticks = self.modes.clone();
        sticks[contact] = Contact::Sticks;
        let mobility = |modes: &[Contact]| {
            let (held, _) = model.held(&ground.targets, modes, &[], &[]);
            let rows =
                super::rows::Rows::new(&model.topology, &model.parameters, &ground.bodies, &held);
            let balance = super::balance::Balance::new(&model.scene(ground), rows);
            balance.map_or(0, |balance| balance.mobility(model.topology.freedoms()))
        };
        mobility(&sticks) < mobility(&self.modes)
    }

    /// A contact slides back at once.
    fn reverse(&mut self, contact: usize, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let before = self.modes.clone();
        if let Contact::Slides(direction) = self.modes[contact] {
            self.modes[contact] = Contact::Slides(direction.map(|d| -d));
        }
        let y = self.pack();
        self.now = self.evaluate(self.now.time, &y, inputs, self.settings.look_for_others)?;
        self.tell(&before);
        self.step *= 0.1;
        Ok(())
    }

    fn tell(&mut self, before: &[Contact]) {
        let time = self.now.time;
        for contact in 0..self.modes.len() {
            let joint = JointId(self.model.parameters.contacts[contact].joint);
            let kind = match (before[contact], self.modes[contact]) {
                (Contact::Sticks | Contact::AtLimit(_), Contact::Sticks | Contact::AtLimit(_)) => {
                    continue;
                }
                (_, Contact::Sticks | Contact::AtLimit(_)) => EventKind::Sticks { contact, joint },
                (Contact::Slides(a), Contact::Slides(b)) if a == b => continue,
                (_, Contact::Slides(direction)) => EventKind::Slides { contact, joint, direction },
                _ => continue,
            };
            self.events.push(Event { time, kind });
        }
    }

    /// Anchors of cut joints and frozen freedoms of the tree that these contacts hold.
    fn holds_of(&self, contacts: &[usize]) -> (Vec<Anchor>, Vec<bool>) {
        let topology = &self.model.topology;
        let mut anchors = Vec::new();
        let mut frozen = vec![false; topology.freedoms()];
        for &contact in contacts {
            let content = &self.model.parameters.contacts[contact];
            let joint = content.joint;
            for freedom in content.shape.freedoms() {
                let driven = self.model.prescribed.iter().any(|&a| {
                    (topology.actuators[a].joint, topology.actuators[a].freedom) == (joint, freedom)
                });
                match topology.role[joint] {
                    _ if driven => {}
                    Role::Tree { node } => {
                        frozen[topology.nodes[node].dofs.start + freedom] = true;
                    }
                    Role::Cut { .. } => {
                        let (j, k) =
                            (self.now.bodies.frame_j[joint], self.now.bodies.frame_k[joint]);
                        anchors.push(Anchor { joint, freedom, pose: j.inverse() * k });
                    }
                }
            }
        }
        (anchors, frozen)
    }

    /// Freezes what sticks, and all that cannot move then.
    fn hold(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let model = self.model;
        let sticks: Vec<usize> =
            (0..self.modes.len()).filter(|&c| self.modes[c] == Contact::Sticks).collect();
        (self.anchors, self.frozen) = self.holds_of(&sticks);
        if sticks.is_empty() {
            self.told_of_shares = 0;
            return Ok(());
        }
        let mut state = self.now.state.clone();
        let ground = model.ground(
            self.now.time,
            state.clone(),
            &self.bristles,
            (&self.grips, &self.shares),
            inputs,
        );
        let loads: Vec<f64> = self.now.contacts.iter().map(|c| c.load).collect();
        let solved = model
            .solve(&ground, &self.modes, Some(&loads), true)
            .map_err(|u| model.unsolved(ground.time, u))?;
        // Where nothing is left to move, nothing moves, not even by rounding. A freedom that is immobile
        // while others move may be at a dead centre.
        if model.prescribed.is_empty() && solved.balance.mobility(model.topology.freedoms()) == 0 {
            self.frozen.fill(true);
        }
        for (rate, frozen) in state.rates.iter_mut().zip(&self.frozen) {
            if *frozen {
                *rate = 0.0;
            }
        }
        let redundant = solved.balance.spread.stresses.len();
        let without = self.permanently_redundant(&ground);
        let shares = redundant.saturating_sub(without);
        if shares > 0 && shares != self.told_of_shares {
            let kind = EventKind::SharesNotUnique { redundant: shares };
            self.events.push(Event { time: self.now.time, kind });
        }
        self.told_of_shares = shares;
        let ground =
            model.ground(self.now.time, state, &self.bristles, (&self.grips, &self.shares), inputs);
        self.now = model.instant(ground, &self.modes, &solved);
        self.still();
        Ok(())
    }

    /// How many constraints are redundant where nothing sticks.
    fn permanently_redundant(&self, ground: &super::evaluate::Ground) -> usize {
        let model = self.model;
        let (held, _) = model.held(&ground.targets, &[], &[], &[]);
        let rows =
            super::rows::Rows::new(&model.topology, &model.parameters, &ground.bodies, &held);
        match super::balance::Balance::new(&model.scene(ground), rows) {
            Ok(balance) => balance.spread.stresses.len(),
            Err(_) => 0,
        }
    }

    /// Nothing frozen accelerates, not even by rounding.
    fn still(&mut self) {
        for (acceleration, frozen) in self.now.state.accelerations.iter_mut().zip(&self.frozen) {
            if *frozen {
                *acceleration = 0.0;
            }
        }
    }

    /// Where the solution is not certain to be the only one, others are looked for and told, once for
    /// each stretch of time.
    fn look_for_others(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let Some(coupling) = self.now.coupling.filter(|c| *c >= 1.0) else {
            self.told_of_others = false;
            return Ok(());
        };
        if self.told_of_others || !self.settings.look_for_others {
            return Ok(());
        }
        self.told_of_others = true;
        let model = self.model;
        let time = self.now.time;
        let ground = model.ground(
            time,
            self.now.state.clone(),
            &self.bristles,
            (&self.grips, &self.shares),
            inputs,
        );
        let loads: Vec<f64> = self.now.contacts.iter().map(|c| c.load).collect();
        let solved = model
            .solve(&ground, &self.modes, Some(&loads), false)
            .map_err(|u| model.unsolved(time, u))?;
        let others = model.others(&ground, &self.modes, &solved);
        let Some(other) = others.first() else { return Ok(()) };
        let differs = |c: &usize| (other.loads[*c] - loads[*c]).abs();
        let most = (0..loads.len()).max_by(|a, b| differs(a).total_cmp(&differs(b)));
        let joint = JointId(most.map_or(0, |c| model.parameters.contacts[c].joint));
        let kind = EventKind::NotUnique { joint, coupling, others };
        self.events.push(Event { time, kind });
        Ok(())
    }

    /// Directions of balls and plates are taken afresh at the start of each step.
    fn look_along(&mut self) {
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

    fn commit(&mut self, y: &[f64], arrived: Instant) {
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
    fn arrive(
        &mut self,
        time: f64,
        y: &[f64],
        inputs: &mut dyn Inputs,
    ) -> Result<Instant, ForwardError> {
        self.arrive_with(time, y, inputs, self.settings.look_for_others)
    }

    fn arrive_with(
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

    fn evaluate(
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

    fn derivative(
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

    fn derivative_of(&self, at: &Instant) -> Vec<f64> {
        let state = &at.state;
        let mut rates = vec![0.0; state.coordinates.len()];
        self.model.coordinate_rates(&state.coordinates, &state.rates, &mut rates);
        rates.extend_from_slice(&state.accelerations);
        rates.extend(at.bristle_rates.iter().flatten());
        let account = &at.account;
        rates.extend_from_slice(&account.drives);
        rates.push(account.loads);
        rates.push(account.dampers);
        let powers = account.drives.iter().chain(&account.contacts).map(|p| p.abs());
        rates.push(powers.sum::<f64>() + account.loads.abs() + account.dampers.abs());
        rates.extend_from_slice(&account.contacts);
        rates
    }

    fn pack(&self) -> Vec<f64> {
        let state = &self.now.state;
        let mut y = state.coordinates.clone();
        y.extend_from_slice(&state.rates);
        y.extend(self.bristles.iter().flatten());
        let energies = &self.energies;
        y.extend_from_slice(&energies.drives);
        y.extend([energies.loads, energies.dampers, energies.turnover]);
        y.extend_from_slice(&energies.contacts);
        y
    }

    fn unpack<'y>(&self, y: &'y [f64]) -> (State<f64>, &'y [f64]) {
        let coordinates = self.now.state.coordinates.len();
        let rates = self.now.state.rates.len();
        let state = State {
            coordinates: y[..coordinates].to_vec(),
            rates: y[coordinates..coordinates + rates].to_vec(),
            accelerations: vec![0.0; rates],
        };
        (state, &y[coordinates + rates..])
    }

    /// Errors of coordinates and rates count, lengths in characteristic lengths; bristles by their own
    /// size; energies are quadratures of the same and do not count.
    fn error_scales(&self) -> Vec<f64> {
        let (topology, columns) = (&self.model.topology, &self.model.columns);
        let mut scales = vec![1.0; topology.coordinates()];
        for node in &topology.nodes {
            let dofs = node.dofs.clone();
            for (scale, dof) in scales[node.coordinates.clone()].iter_mut().zip(dofs) {
                *scale = columns[dof];
            }
        }
        scales.extend_from_slice(columns);
        for contact in &self.model.parameters.contacts {
            let bristles = contact.law.bristles.as_ref();
            let size = bristles.map_or(f64::INFINITY, |b| contact.law.at_rest() / b.stiffness);
            scales.extend([size; 3]);
        }
        let energies = self.energies.drives.len() + 3 + self.energies.contacts.len();
        scales.extend(std::iter::repeat_n(f64::INFINITY, energies));
        scales
    }
}

/// Whether the cubic with these values and slopes at 0 and 1 falls below zero between.
fn dips((v0, a0): (f64, f64), (v1, a1): (f64, f64)) -> bool {
    (1..8).any(|k| {
        let x = f64::from(k) / 8.0;
        let y = 1.0 - x;
        let value = v0 * (1.0 + 2.0 * x) * y * y + a0 * x * y * y + v1 * x * x * (3.0 - 2.0 * x)
            - a1 * x * x * y;
        value < 0.0
    })
}

/// Where a function falls through zero, by Illinois's rule.
fn root(mut low: (f64, f64), mut high: (f64, f64), f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..100 {
        if high.0 - low.0 <= 4.0 * f64::EPSILON {
            break;
        }
        let mut middle = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        if !(middle > low.0 && middle < high.0) {
            middle = 0.5 * (low.0 + high.0);
        }
        let value = f(middle);
        if value == 0.0 {
            return middle;
        }
        if value < 0.0 {
            high = (middle, value);
            low.1 *= 0.5;
        } else {
            low = (middle, value);
            high.1 *= 0.5;
        }
    }
    0.5 * (low.0 + high.0)
}
