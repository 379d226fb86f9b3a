//! Inputs of a simulation: loads, actuator efforts, controllers and prescribed motions, evaluated
//! at the times and states that the simulation requests.

use super::control_law::{Measured, actuator_motion};
use super::controller::{Controller, ControllerInput};
use super::guide::Guide;
use super::job::{Feed, Job};
use super::motors::Motors;
use super::reference::{References, own_signal};
use super::sampled_loop::Tuning;
use super::stop::Stop;
use crate::error::Error;
use crate::names::Names;
use crate::{Instants, Tracked};
use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::{Forward, Inputs, Simulation, View};
use stiction_core::kinematics::{Bodies, State, Target};
use stiction_core::spatial::{Mat3, Pose, Vec3};
use stiction_format::{Law, Signal};

/// Update interval of inverse-dynamics efforts if there is no controller, s.
const UPDATE: f64 = 1e-3;

/// Time between two instants, as a fraction of a sampling period, below which they count as the
/// same instant.
const SAME: f64 = 1e-6;

/// Source of the motion of a prescribed actuator.
#[derive(Clone, Debug)]
enum MotionSource<'a> {
    /// Signal that the motion defines for this actuator.
    Signal(&'a Signal),
    /// Inverse kinematics of the whole mechanism along the motion, for the actuator with this
    /// index.
    Guide(usize),
    /// Constant position, rad or m: the actuator is locked.
    Stays(f64),
}

/// Largest valid number of controller samples in a checkpoint. A larger number shows that the
/// checkpoint is invalid.
const COUNTABLE: f64 = 1e15;

/// Inputs of a simulation, and their state between samples of the controller.
pub(super) struct Acting<'a> {
    forward: &'a Forward,
    job: &'a Job<'a>,
    sources: Vec<MotionSource<'a>>,
    /// Mechanism that follows the motion, for prescribed actuators without their own signal in the
    /// motion.
    leader: Option<Guide<'a>>,
    /// Reference motions of all actuators that follow the motion.
    references: References<'a>,
    /// Mechanism that follows the motion at the samples of the results, for reference poses of
    /// bodies. `None` if [`Self::references`] already computes this motion, if the mechanism cannot
    /// follow the motion, or if not all actuators follow the motion.
    in_space: Option<Guide<'a>>,
    controller: Option<Controller<'a>>,
    motors: Motors,
    /// Actuator efforts that stay constant between two samples of the controller, N or N m.
    kept: Vec<f64>,
    /// Number of samples of the controller taken so far.
    samples: usize,
    /// Sample times of the results, s.
    instants: Instants,
    /// State of [`Self::leader`] at the start of the current step.
    leader_from: Vec<f64>,
    period: Option<f64>,
    /// Time of the next change of a payload, s; infinite if no payload is picked up or placed
    /// later.
    pub(super) payload_change: f64,
    /// True if the controller acts in continuous time.
    is_continuous: bool,
    /// Indices of the actuators whose control law has an integral part, which the simulation
    /// integrates.
    integrating: Vec<usize>,
    /// Indices of the actuators whose effort the continuous controller limits.
    limited: Vec<usize>,
    /// State of [`Self::references`] at the start of the current step, for a continuous controller.
    reference_from: Vec<f64>,
    /// Function that returns true once the user has asked to stop the simulation.
    stopped: &'a dyn Fn() -> bool,
    /// True once the user has asked to stop the simulation.
    pub(super) is_stopped: bool,
    /// First error in the evaluation of the inputs.
    pub(super) failed: Option<Error>,
    /// Error of the last evaluation of the loads, if a formula had no value in that state. The
    /// simulation avoids that state by a shorter step if it can.
    pub(super) without_load: Option<Error>,
}

/// Returns a pose of NaN, which represents an unknown pose.
fn unknown() -> Pose<f64> {
    let nan = Vec3::new(f64::NAN, f64::NAN, f64::NAN);
    Pose { rotation: Mat3 { columns: [nan; 3] }, position: nan }
}

/// Returns the indices of the actuators with a prescribed motion, followed by those of the locked
/// actuators. The targets of [`Acting`] have the same order.
pub(super) fn prescribed(job: &Job<'_>) -> Vec<usize> {
    let moved = job.prescribed.iter().filter(|a| !job.locked.contains(a));
    moved.chain(&job.locked).copied().collect()
}

impl<'a> Acting<'a> {
    /// Creates the inputs before the first sample; `state` is the initial state of the mechanism.
    pub(super) fn new(
        job: &'a Job<'a>,
        forward: &'a Forward,
        state: &State<f64>,
        stopped: &'a dyn Fn() -> bool,
    ) -> Result<Self, Error> {
        let mut bodies = Bodies::new(forward.topology());
        bodies.place(forward.topology(), forward.parameters(), &state.coordinates);
        bodies.move_with(forward.topology(), &state.rates);
        bodies.accelerate(forward.topology(), &state.accelerations);
        let actuators: Vec<_> = forward.mechanism().actuators().collect();
        let sources: Vec<MotionSource<'a>> = prescribed(job)
            .into_iter()
            .map(|actuator| {
                let (joint, dof) = actuators[actuator];
                if job.locked.contains(&actuator) {
                    return MotionSource::Stays(
                        forward.joint_coordinate(state, &bodies, joint, dof),
                    );
                }
                own_signal(job, forward, actuator)
                    .map_or(MotionSource::Guide(actuator), MotionSource::Signal)
            })
            .collect();
        let is_guided = sources.iter().any(|way| matches!(way, MotionSource::Guide(_)));
        let leader = if is_guided { Guide::new(job)? } else { None };
        let controller = match job.control {
            Some(control) => Some(Controller::new(job, control, forward, (state, &bodies))?),
            None => None,
        };
        let is_continuous = job.control.is_some_and(|control| control.period == 0.0);
        let period = match job.control {
            Some(control) if !is_continuous => Some(control.period),
            None if job.law.is_some() => job.law.map(|law| law.period),
            _ if matches!(job.drives, Feed::Inverse) => Some(UPDATE),
            _ => None,
        };
        let taken = prescribed(job);
        let gains = controller.iter().filter(|_| is_continuous).flat_map(|c| &c.gains).enumerate();
        let gains = gains.filter(|(actuator, _)| !taken.contains(actuator));
        let (mut integrating, mut limited) = (Vec::new(), Vec::new());
        for (actuator, gains) in gains {
            if gains.integral > 0.0 {
                integrating.push(actuator);
            }
            if gains.limit.is_finite() {
                limited.push(actuator);
            }
        }
        let starts = actuators
            .iter()
            .map(|(joint, dof)| forward.joint_coordinate(state, &bodies, *joint, *dof));
        let references = References::new(job, forward, &starts.collect::<Vec<_>>())?;
        // If this reference cannot be computed, the results lack only the tracking error in space.
        let in_space = match job.follows_in_space() && !references.is_guided() {
            true => Guide::new(job).ok().flatten(),
            false => None,
        };
        Ok(Self {
            forward,
            job,
            sources,
            leader,
            stopped,
            is_stopped: false,
            references,
            in_space,
            controller,
            motors: Motors::new(forward.mechanism()),
            kept: vec![0.0; actuators.len()],
            samples: 0,
            instants: job.instants()?,
            leader_from: Vec::new(),
            period,
            payload_change: f64::INFINITY,
            is_continuous,
            integrating,
            limited,
            reference_from: Vec::new(),
            failed: None,
            without_load: None,
        })
    }

    /// Returns the stability of the controller at the start.
    pub(super) fn tuning(&self) -> Tuning {
        self.controller.as_ref().map(|controller| controller.tuning).unwrap_or_default()
    }

    /// Returns the time of the next sample of the controller, s; `None` without a sampling period.
    /// If the time differs from that of a result row by rounding only, the time of the row is
    /// returned.
    fn next_sample(&self) -> Option<f64> {
        let period = self.period?;
        let time = self.job.from + self.samples as f64 * period;
        let row = ((time - self.job.from) / self.job.step).round();
        let row = self.instants.at(row as usize);
        Some(if (time - row).abs() < SAME * period { row } else { time })
    }

    /// Returns the state of the inputs between two samples, as numbers for a checkpoint.
    pub(super) fn save(&self) -> Vec<f64> {
        let mut numbers = vec![self.samples as f64];
        numbers.extend_from_slice(&self.kept);
        self.references.save(&mut numbers);
        numbers.push(f64::from(u8::from(self.in_space.is_some())));
        if let Some(guide) = &self.in_space {
            guide.save(&mut numbers);
        }
        numbers.push(self.reference_from.len() as f64);
        numbers.extend_from_slice(&self.reference_from);
        numbers.extend_from_slice(&self.leader_from);
        if let Some(controller) = &self.controller {
            controller.save(&mut numbers);
        }
        numbers
    }

    /// Restores the state written by [`Self::save`]; `None` if the numbers belong to another
    /// simulation.
    pub(super) fn restore(&mut self, numbers: &[f64]) -> Option<()> {
        let (first, rest) = numbers.split_first()?;
        let (kept, rest) = rest.split_at_checked(self.kept.len())?;
        if !(0.0..=COUNTABLE).contains(first) {
            return None;
        }
        self.samples = *first as usize;
        self.kept.copy_from_slice(kept);
        let (has_space, mut rest) = self.references.restore(rest)?.split_first()?;
        if *has_space == 1.0 {
            rest = self.in_space.as_mut()?.restore(rest)?;
        } else {
            self.in_space = None;
        }
        let (&count, rest) = rest.split_first()?;
        let (reference_from, mut rest) = rest.split_at_checked(count as usize)?;
        self.reference_from = reference_from.to_vec();
        if let Some(leader) = &mut self.leader {
            let all = rest;
            rest = leader.restore(rest)?;
            self.leader_from = all[..all.len() - rest.len()].to_vec();
        }
        match &mut self.controller {
            Some(controller) => controller.restore(rest),
            None => rest.is_empty().then_some(()),
        }
    }

    /// Returns the reference motions of all actuators at `time`, s, with zeros for actuators that
    /// follow no motion.
    pub(super) fn references_at(&mut self, time: f64) -> Result<&[Target<f64>], Error> {
        // A continuous controller evaluates references at times in any order, so each evaluation
        // restarts from the state at the start of the step.
        if !self.reference_from.is_empty()
            && self.references.restore(&self.reference_from).is_none()
        {
            return Err(Error::Checkpoint);
        }
        self.references.at(time)
    }

    /// Replaces `poses` by the reference poses of `bodies` in the world at a sample of the results
    /// at `time`, s. The references of the actuators at this sample must be computed by
    /// [`Self::references_at`] first. The poses are NaN from the first sample at which the
    /// mechanism cannot follow the motion.
    pub(super) fn reference_poses(
        &mut self,
        time: f64,
        bodies: &[Tracked],
        poses: &mut Vec<Pose<f64>>,
    ) {
        if self.in_space.as_mut().is_some_and(|guide| guide.go_to(time).is_err()) {
            self.in_space = None;
        }
        poses.clear();
        match self.references.guide().or(self.in_space.as_mut()) {
            Some(guide) => poses.extend(guide.poses(bodies)),
            None => poses.extend(bodies.iter().map(|_| unknown())),
        }
    }

    /// Returns the errors of an actuator in position, m or rad, and in rate, m/s or rad/s:
    /// reference minus measured value.
    fn error(&self, view: &View<'_>, reference: &[Target<f64>], actuator: usize) -> (f64, f64) {
        let Target { value, rate, .. } = reference[actuator];
        (value - view.actuator_coordinate(actuator), rate - view.actuator_rate(actuator))
    }

    /// Adds the efforts of the continuous controller to the feed-forward efforts in `efforts`. The
    /// efforts are not limited yet.
    fn demand(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        let reference = match self.references_at(view.time) {
            Ok(reference) => reference.to_vec(),
            Err(error) => {
                self.failed.get_or_insert(error);
                return;
            }
        };
        let Some(controller) = &self.controller else { return };
        for (actuator, effort) in efforts.iter_mut().enumerate() {
            let state = self.integrating.iter().position(|own| *own == actuator);
            let integral = state.map_or(0.0, |state| view.states()[state]);
            let errors = self.error(view, &reference, actuator);
            *effort += controller.gains[actuator].effort(errors, integral);
        }
    }

    /// Writes the feed-forward efforts of all actuators to `efforts`.
    fn feed(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        if self.period.is_some() {
            efforts.copy_from_slice(&self.kept);
        } else {
            self.given_at(view, self.law_sides(view), efforts);
        }
    }

    /// Returns the formulas of efforts that depend on the measured state and are evaluated in
    /// continuous time, each with the index of its actuator.
    fn laws(&self) -> &'a [(usize, Law)] {
        match (self.job.drives, self.period) {
            (Feed::Given(drives), None) => &drives.laws,
            _ => &[],
        }
    }

    /// Returns the sides of the switching functions of the effort formulas, followed by those of
    /// the load formulas. A side is true if the switching function is positive.
    fn law_sides<'v>(&self, view: &View<'v>) -> &'v [bool] {
        let before = self.job.stops.len() + 2 * self.limited.len();
        view.sides().get(before..).unwrap_or_default()
    }

    /// Limits an effort of the continuous controller. The signs of the actuator's two switching
    /// functions decide which limit acts.
    fn limited(&self, view: &View<'_>, actuator: usize, demand: f64) -> f64 {
        let Some(controller) = &self.controller else { return demand };
        let Some(place) = self.limited.iter().position(|own| *own == actuator) else {
            return demand;
        };
        let limit = controller.gains[actuator].limit;
        let first = self.job.stops.len() + 2 * place;
        match view.sides().get(first..first + 2) {
            Some([false, _]) => limit,
            Some([true, false]) => -limit,
            Some(_) => demand,
            // Before the start of the simulation, the signs of the switching functions are unknown.
            None => demand.clamp(-limit, limit),
        }
    }

    /// Moves [`Self::leader`] along the motion to `time`, s, starting from its state at the start
    /// of the current step. The result therefore does not depend on earlier evaluations.
    fn lead(&mut self, time: f64) {
        let Some(leader) = &mut self.leader else { return };
        if !self.leader_from.is_empty() && leader.restore(&self.leader_from).is_none() {
            self.failed.get_or_insert(Error::Checkpoint);
        }
        if let Err(error) = leader.go_to(time) {
            self.failed.get_or_insert(error);
        }
    }

    /// Writes the efforts that signals and formulas define to `efforts`. `sides` contains the side
    /// of each switching function of the formulas, true if positive.
    fn given_at(&self, view: &View<'_>, mut sides: &[bool], efforts: &mut [f64]) {
        if let Feed::Given(drives) = self.job.drives {
            for (actuator, signal) in &drives.efforts {
                efforts[*actuator] = signal.at(view.time).value;
            }
            for (actuator, law) in &drives.laws {
                let (own, rest) = sides.split_at(law.switches().min(sides.len()));
                efforts[*actuator] = law.at(view.time, |c| view.measure(c), own);
                sides = rest;
            }
        }
    }

    fn sample(&mut self, view: &View<'_>) -> Result<(), Error> {
        let time = view.time;
        let mut feed = vec![0.0; self.kept.len()];
        let mut friction = vec![0.0; self.kept.len()];
        let reference = self.references_at(time)?.to_vec();
        let with_friction = self
            .job
            .control
            .is_some_and(|control| control.friction == stiction_format::FrictionFeed::Reference);
        if (with_friction || matches!(self.job.drives, Feed::Inverse))
            && let Some(guide) = self.references.guide()
        {
            let (with, without) = guide.drives()?;
            let (mut with, mut without) = (with.to_vec(), without.to_vec());
            let motion = (&reference[..], guide.bodies());
            self.motors.add(time, &mut with, motion, self.job.friction)?;
            self.motors.add(time, &mut without, motion, false)?;
            for (index, (with, without)) in with.iter().zip(without).enumerate() {
                friction[index] = with - without;
                if matches!(self.job.drives, Feed::Inverse) {
                    feed[index] = *with;
                }
            }
        }
        self.given_at(view, &[], &mut feed);
        if let Some(law) = self.job.law {
            let (positions, rates) = actuator_motion(view, self.kept.len());
            let reference = if self.job.motion.is_some() { &reference[..] } else { &[] };
            let measured = Measured { time, positions: &positions, rates: &rates, reference };
            let efforts = law.efforts(&measured).map_err(Error::Receiver)?;
            feed.iter_mut().zip(efforts).for_each(|(feed, effort)| *feed += effort);
        }
        let Some(controller) = self.controller.as_mut().filter(|_| !self.is_continuous) else {
            self.kept = feed;
            return Ok(());
        };
        let actual: Vec<(f64, f64)> = (0..self.kept.len())
            .map(|index| (view.actuator_coordinate(index), view.actuator_rate(index)))
            .collect();
        let loads = self.job.loads_at(view)?;
        let (reference, feed, friction) = (&reference, &feed, &friction);
        let input =
            ControllerInput { time, actual: &actual, reference, feed, friction, loads: &loads };
        self.kept = controller.sample(&input)?;
        Ok(())
    }
}

impl Acting<'_> {
    /// Returns an error if the formula of an effort or of a load, or a limit of the controller, has
    /// a kink or a jump at the present state. A linear model does not exist there, because the
    /// derivatives on the two sides differ.
    pub(super) fn refuse_kinks(&mut self, simulation: &Simulation<'_>) -> Result<(), Error> {
        // Distance from a kink, in SI units, that counts as a rounding error.
        const AT_KINK: f64 = 1e-9;
        let view = simulation.view();
        let mut values = Vec::new();
        self.switches(&view, &mut values);
        let first = self.job.stops.len();
        let at = (first..values.len()).find(|k| values[*k].abs() <= AT_KINK);
        match at {
            None => Ok(()),
            Some(switch) => Err(Error::NoLinearModel(format!(
                "{} has a kink or a jump at the operating point (`abs`, `min`, `max`, `sign` or a \
                 limit), so its derivatives on the two sides differ; choose an operating point \
                 beside it, or a smooth formula",
                self.switch_name(switch)
            ))),
        }
    }
}

impl Inputs for Acting<'_> {
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        self.feed(view, efforts);
        if self.is_continuous {
            self.demand(view, efforts);
            for (actuator, effort) in efforts.iter_mut().enumerate() {
                *effort = self.limited(view, actuator, *effort);
            }
        }
        self.is_stopped |= (self.stopped)();
        if self.failed.is_some() || self.is_stopped {
            // Efforts that are not finite stop the simulation at its next step.
            efforts.fill(f64::NAN);
        }
    }

    fn initial_states(&self) -> Vec<(f64, f64)> {
        let gains = self.controller.iter().flat_map(|controller| &controller.gains);
        let scales: Vec<f64> = gains.map(|gains| gains.scale()).collect();
        self.integrating.iter().map(|actuator| (0.0, scales[*actuator])).collect()
    }

    fn state_rates(&mut self, view: &View<'_>, rates: &mut [f64]) {
        if self.integrating.is_empty() {
            return;
        }
        let mut demands = vec![0.0; self.kept.len()];
        self.feed(view, &mut demands);
        self.demand(view, &mut demands);
        let reference = match self.references_at(view.time) {
            Ok(reference) => reference.to_vec(),
            // The method `demand` has recorded the error.
            Err(_) => return,
        };
        let Some(controller) = &self.controller else { return };
        for (rate, &actuator) in rates.iter_mut().zip(&self.integrating) {
            let (error, _) = self.error(view, &reference, actuator);
            let demand = demands[actuator];
            let effort = self.limited(view, actuator, demand);
            *rate = controller.gains[actuator].integral_rate(error, demand, effort);
        }
    }

    fn switches(&mut self, view: &View<'_>, values: &mut Vec<f64>) {
        for stop in self.job.stops {
            let distance = stop.distance(view, self.kept.len());
            values.push(distance.unwrap_or_else(|error| {
                self.failed.get_or_insert(error);
                f64::NAN
            }));
        }
        if !self.limited.is_empty() {
            let mut demands = vec![0.0; self.kept.len()];
            self.feed(view, &mut demands);
            self.demand(view, &mut demands);
            let Some(controller) = &self.controller else { return };
            for &actuator in &self.limited {
                let (demand, limit) = (demands[actuator], controller.gains[actuator].limit);
                values.extend([limit - demand, limit + demand]);
            }
        }
        let mut sides = self.law_sides(view);
        for (_, law) in self.laws() {
            let (own, rest) = sides.split_at(law.switches().min(sides.len()));
            law.switches_at(view.time, |c| view.measure(c), own, values);
            sides = rest;
        }
        self.job.acting_loads().switches(view, sides, values);
    }

    fn ends_at(&self, switch: usize) -> bool {
        switch < self.job.stops.len()
    }

    fn switch_name(&self, switch: usize) -> String {
        let name = |actuator: usize| {
            let names = Names::new(self.forward.mechanism()).drives;
            names.get(actuator).map_or_else(String::new, |(name, _)| name.clone())
        };
        let mut rest = switch.saturating_sub(self.job.stops.len());
        if let Some(actuator) = self.limited.get(rest / 2) {
            return format!("the effort of `{}` at its limit", name(*actuator));
        }
        rest -= 2 * self.limited.len();
        for (actuator, law) in self.laws() {
            if rest < law.switches() {
                return format!("the formula of the effort of `{}`", name(*actuator));
            }
            rest -= law.switches();
        }
        self.job.acting_loads().switch_name(rest).unwrap_or_else(|| "a formula".to_owned())
    }

    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        self.lead(time);
        let mut all = Vec::new();
        if let Some(leader) = &self.leader {
            let zero = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
            all = vec![zero; self.kept.len()];
            leader.actuators(&mut all);
        }
        for (target, way) in targets.iter_mut().zip(&self.sources) {
            *target = match way {
                MotionSource::Signal(signal) => signal.at(time),
                MotionSource::Guide(actuator) => all[*actuator],
                MotionSource::Stays(value) => {
                    Target { value: *value, rate: 0.0, acceleration: 0.0 }
                }
            };
        }
    }

    fn loads(&mut self, view: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        let before: usize = self.laws().iter().map(|(_, law)| law.switches()).sum();
        let sides = self.law_sides(view).get(before..).unwrap_or_default();
        self.without_load = self.job.acting_loads().append(view, sides, loads).err();
    }

    fn next_change(&self, time: f64) -> Option<f64> {
        let sample = self.next_sample().filter(|next| *next > time);
        let recorded = match (self.job.drives, self.period) {
            // With a sampling period, recorded efforts are evaluated only at the samples.
            (Feed::Given(drives), None) => {
                drives.samples.as_ref().and_then(|samples| samples.after(time))
            }
            _ => None,
        };
        let payload =
            Some(self.payload_change).filter(|change| *change > time && change.is_finite());
        [sample, recorded, payload].into_iter().flatten().reduce(f64::min)
    }

    fn steady_until(&self, time: f64) -> f64 {
        let constant = |signal: &Signal| signal.is_constant();
        let loads = self.job.acting_loads().are_steady();
        let efforts = match (self.job.drives, self.period) {
            // Efforts are constant between samples, and each interval ends at a sample.
            (_, Some(_)) => true,
            (Feed::Given(drives), None) => {
                drives.efforts.iter().all(|(_, signal)| constant(signal))
                    && !drives.laws.iter().any(|(_, law)| law.has_time())
            }
            (Feed::Inverse, None) => false,
        };
        let motion = self.job.motion.filter(|_| self.is_continuous);
        let reference = motion.iter().flat_map(|motion| motion.signals()).all(constant);
        let stops = !self.job.stops.iter().any(Stop::has_time);
        if loads && efforts && reference && stops && !self.is_stopped {
            f64::INFINITY
        } else {
            time
        }
    }

    fn are_constant(&self) -> bool {
        let load = self.job.load;
        // With a sampling period, laws of efforts act only at samples.
        let is_held = self.period.is_some() && !self.is_continuous;
        let are_steady = load.laws.is_empty() && self.job.acting_loads().are_steady();
        is_held && are_steady && self.failed.is_none() && !self.is_stopped
    }

    fn seen_until(&self, time: f64) -> f64 {
        let efforts: &[(usize, Signal)] = match (self.job.drives, self.period) {
            (Feed::Given(drives), None) => &drives.efforts,
            // Efforts are constant between samples.
            _ => &[],
        };
        let own = self.sources.iter().filter_map(|way| match way {
            MotionSource::Signal(signal) => Some(*signal),
            MotionSource::Guide(_) | MotionSource::Stays(_) => None,
        });
        let follows = self.leader.is_some() || self.is_continuous;
        let motion = self.job.motion.filter(|_| follows);
        let laws = self.laws().iter().map(|(_, law)| law.resolved_until(time));
        let stops = self.job.stops.iter().map(|stop| stop.resolved_until(time));
        let formulas = laws.chain(stops).fold(self.job.acting_loads().seen_until(time), f64::min);
        let whole = motion.iter().flat_map(|motion| motion.signals());
        let efforts = efforts.iter().map(|(_, signal)| signal);
        efforts
            .chain(whole)
            .chain(own)
            .map(|signal| signal.resolved_until(time))
            .fold(formulas, f64::min)
    }

    fn known_until(&self) -> f64 {
        // Beyond the end of the simulation, the mechanism may be unable to follow the motion.
        let follows = self.leader.is_some() || self.is_continuous && self.references.is_guided();
        if follows { self.job.until } else { f64::INFINITY }
    }

    fn begin_step(&mut self, time: f64) {
        self.lead(time);
        self.leader_from.clear();
        if let Some(leader) = &self.leader {
            leader.save(&mut self.leader_from);
        }
        if self.is_continuous {
            match self.references_at(time) {
                Ok(_) => {
                    self.reference_from.clear();
                    self.references.save(&mut self.reference_from);
                }
                Err(error) => {
                    self.failed.get_or_insert(error);
                }
            }
        }
    }

    fn change(&mut self, view: &View<'_>) {
        if self.next_sample().is_none_or(|next| view.time < next) {
            return;
        }
        self.samples += 1;
        if let Err(error) = self.sample(view) {
            self.failed.get_or_insert(error);
        }
    }
}
