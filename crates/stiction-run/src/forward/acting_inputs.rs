//! Inputs of a simulation: loads, actuator efforts, controllers and prescribed motions.

use super::controller::{Controller, Told};
use super::guide::Guide;
use super::job::{Feed, Job};
use super::motors::Motors;
use super::reference::{Wanted, own_course};
use crate::Instants;
use crate::error::Error;
use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::{Forward, Inputs, View};
use stiction_core::kinematics::{Bodies, State, Target};
use stiction_format::Signal;

/// Update interval of the inverse-dynamics efforts without a controller, s.
const UPDATE: f64 = 1e-3;

/// Fraction of a sampling period below which the distance of two instants is rounding.
const SAME: f64 = 1e-6;

/// Source of a prescribed actuator's motion.
#[derive(Clone, Debug)]
enum Way<'a> {
    /// A signal of its own in the motion.
    Signal(&'a Signal),
    /// The motion of the whole mechanism, for the actuator with this index.
    Guide(usize),
    /// Locked at this position.
    Stays(f64),
}

/// Largest plausible number of samples; larger numbers indicate an invalid checkpoint.
const COUNTABLE: f64 = 1e15;

/// Inputs of a simulation.
pub(super) struct Acting<'a> {
    forward: &'a Forward,
    job: &'a Job<'a>,
    ways: Vec<Way<'a>>,
    /// Motion of the whole mechanism, for prescribed actuators without a signal of their own.
    leader: Option<Guide<'a>>,
    /// Reference motions of the actuators that follow the motion.
    wanted: Wanted<'a>,
    controller: Option<Controller<'a>>,
    motors: Motors,
    /// Efforts held between two samples, N or N m.
    kept: Vec<f64>,
    /// Number of samples taken so far.
    samples: usize,
    /// Sample times of the results, s.
    instants: Instants,
    /// State of [`Self::leader`] at the start of the present step.
    led_from: Vec<f64>,
    period: Option<f64>,
    /// Returns true once the user wants to stop the simulation.
    stopped: &'a dyn Fn() -> bool,
    /// True once the user has asked to stop.
    pub(super) is_stopped: bool,
    /// First error in the evaluation of the inputs.
    pub(super) failed: Option<Error>,
}

/// Actuators with a prescribed motion, in the order of [`Acting`]'s targets.
pub(super) fn prescribed(job: &Job<'_>) -> Vec<usize> {
    let moved = job.prescribed.iter().filter(|a| !job.locked.contains(a));
    moved.chain(&job.locked).copied().collect()
}

impl<'a> Acting<'a> {
    /// Creates the inputs before the first sample; the mechanism starts at `state`.
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
        let ways: Vec<Way<'a>> = prescribed(job)
            .into_iter()
            .map(|actuator| {
                let (joint, dof) = actuators[actuator];
                if job.locked.contains(&actuator) {
                    return Way::Stays(forward.joint_coordinate(state, &bodies, joint, dof));
                }
                own_course(job, forward, actuator).map_or(Way::Guide(actuator), Way::Signal)
            })
            .collect();
        let is_led = ways.iter().any(|way| matches!(way, Way::Guide(_)));
        let leader = if is_led { Guide::new(job)? } else { None };
        let controller = match job.control {
            Some(control) => Some(Controller::new(job, control, forward, (state, &bodies))?),
            None => None,
        };
        let period = match job.control {
            Some(control) => Some(control.period),
            None if matches!(job.drives, Feed::Inverse) => Some(UPDATE),
            None => None,
        };
        let starts = actuators
            .iter()
            .map(|(joint, dof)| forward.joint_coordinate(state, &bodies, *joint, *dof));
        let wanted = Wanted::new(job, forward, &starts.collect::<Vec<_>>())?;
        Ok(Self {
            forward,
            job,
            ways,
            leader,
            stopped,
            is_stopped: false,
            wanted,
            controller,
            motors: Motors::new(forward.mechanism()),
            kept: vec![0.0; actuators.len()],
            samples: 0,
            instants: job.instants()?,
            led_from: Vec::new(),
            period,
            failed: None,
        })
    }

    /// Time of the next sample; that of a row of the results if both differ by rounding only.
    fn next_sample(&self) -> Option<f64> {
        let period = self.period?;
        let time = self.job.from + self.samples as f64 * period;
        let row = ((time - self.job.from) / self.job.step).round();
        let row = self.instants.at(row as usize);
        Some(if (time - row).abs() < SAME * period { row } else { time })
    }

    /// State of the inputs between samples, as numbers.
    pub(super) fn save(&self) -> Vec<f64> {
        let mut numbers = vec![self.samples as f64];
        numbers.extend_from_slice(&self.kept);
        self.wanted.save(&mut numbers);
        numbers.extend_from_slice(&self.led_from);
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
        let mut rest = self.wanted.restore(rest)?;
        if let Some(leader) = &mut self.leader {
            let all = rest;
            rest = leader.restore(rest)?;
            self.led_from = all[..all.len() - rest.len()].to_vec();
        }
        match &mut self.controller {
            Some(controller) => controller.restore(rest),
            None => rest.is_empty().then_some(()),
        }
    }

    /// Reference motions of the actuators; zeros for those that follow none.
    pub(super) fn wanted_at(&mut self, time: f64) -> Result<&[Target<f64>], Error> {
        self.wanted.at(self.forward, time)
    }

    /// Moves the motion of the whole mechanism to a time, s, from the start of the present step.
    /// The result depends on that start and the time only, not on earlier evaluations.
    fn lead(&mut self, time: f64) {
        let Some(leader) = &mut self.leader else { return };
        if !self.led_from.is_empty() && leader.restore(&self.led_from).is_none() {
            self.failed.get_or_insert(Error::Mark);
        }
        if let Err(error) = leader.go_to(time) {
            self.failed.get_or_insert(error);
        }
    }

    fn given_at(&self, time: f64, efforts: &mut [f64]) {
        if let Feed::Given(drives) = self.job.drives {
            for (actuator, signal) in &drives.efforts {
                efforts[*actuator] = signal.at(time).value;
            }
        }
    }

    fn sample(&mut self, view: &View<'_>) -> Result<(), Error> {
        let (time, forward) = (view.time, self.forward);
        let mut feed = vec![0.0; self.kept.len()];
        let mut friction = vec![0.0; self.kept.len()];
        let wanted = self.wanted.at(forward, time)?.to_vec();
        let with_friction = self
            .job
            .control
            .is_some_and(|control| control.friction == stiction_format::FrictionFeed::Reference);
        if (with_friction || matches!(self.job.drives, Feed::Inverse))
            && let Some(guide) = self.wanted.guide()
        {
            let (with, without) = guide.drives()?;
            let (mut with, mut without) = (with.to_vec(), without.to_vec());
            self.motors.add(&mut with, &wanted, self.job.friction);
            self.motors.add(&mut without, &wanted, false);
            for (index, (with, without)) in with.iter().zip(without).enumerate() {
                friction[index] = with - without;
                if matches!(self.job.drives, Feed::Inverse) {
                    feed[index] = *with;
                }
            }
        }
        self.given_at(time, &mut feed);
        let Some(controller) = &mut self.controller else {
            self.kept = feed;
            return Ok(());
        };
        let actual: Vec<(f64, f64)> = (0..self.kept.len())
            .map(|index| (view.actuator_coordinate(index), view.actuator_rate(index)))
            .collect();
        let loads: Vec<AppliedLoad<f64>> = self.job.load.at(time).collect();
        let (wanted, feed, friction) = (&wanted, &feed, &friction);
        let told = Told { time, actual: &actual, wanted, feed, friction, loads: &loads };
        self.kept = controller.sample(&told)?;
        Ok(())
    }
}

impl Inputs for Acting<'_> {
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        if self.period.is_some() {
            efforts.copy_from_slice(&self.kept);
        } else {
            self.given_at(view.time, efforts);
        }
        self.is_stopped |= (self.stopped)();
        if self.failed.is_some() || self.is_stopped {
            // Efforts that are not finite stop the simulation at its next step.
            efforts.fill(f64::NAN);
        }
    }

    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        self.lead(time);
        let mut all = Vec::new();
        if let Some(leader) = &self.leader {
            let zero = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
            all = vec![zero; self.kept.len()];
            leader.actuators(self.forward, &mut all);
        }
        for (target, way) in targets.iter_mut().zip(&self.ways) {
            *target = match way {
                Way::Signal(signal) => signal.at(time),
                Way::Guide(actuator) => all[*actuator],
                Way::Stays(value) => Target { value: *value, rate: 0.0, acceleration: 0.0 },
            };
        }
    }

    fn loads(&mut self, view: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        loads.extend(self.job.load.at(view.time));
    }

    fn next_change(&self, time: f64) -> Option<f64> {
        let sample = self.next_sample().filter(|next| *next > time);
        let recorded = match (self.job.drives, self.period) {
            // With a sampling period, recorded efforts are evaluated at its samples only.
            (Feed::Given(drives), None) => {
                drives.samples.as_ref().and_then(|samples| samples.after(time))
            }
            _ => None,
        };
        [sample, recorded].into_iter().flatten().reduce(f64::min)
    }

    fn steady_until(&self, time: f64) -> f64 {
        let constant = |signal: &Signal| signal.is_constant();
        let loads = self.job.load.signals().all(constant);
        let efforts = match (self.job.drives, self.period) {
            // Efforts are held between samples, and each interval ends at a sample.
            (_, Some(_)) => true,
            (Feed::Given(drives), None) => {
                drives.efforts.iter().all(|(_, signal)| constant(signal))
            }
            (Feed::Inverse, None) => false,
        };
        if loads && efforts && !self.is_stopped { f64::INFINITY } else { time }
    }

    fn seen_until(&self, time: f64) -> f64 {
        let efforts: &[(usize, Signal)] = match (self.job.drives, self.period) {
            (Feed::Given(drives), None) => &drives.efforts,
            // Efforts are held between samples.
            _ => &[],
        };
        let own = self.ways.iter().filter_map(|way| match way {
            Way::Signal(signal) => Some(*signal),
            Way::Guide(_) | Way::Stays(_) => None,
        });
        let motion = self.leader.as_ref().and(self.job.motion);
        let whole = motion.iter().flat_map(|motion| motion.signals());
        let loads = self.job.load.signals();
        loads
            .chain(efforts.iter().map(|(_, signal)| signal))
            .chain(whole)
            .chain(own)
            .map(|signal| signal.resolved_until(time))
            .fold(f64::INFINITY, f64::min)
    }

    fn known_until(&self) -> f64 {
        // Beyond its end the mechanism may be unable to follow the motion.
        if self.leader.is_some() { self.job.until } else { f64::INFINITY }
    }

    fn begin_step(&mut self, time: f64) {
        self.lead(time);
        self.led_from.clear();
        if let Some(leader) = &self.leader {
            leader.save(&mut self.led_from);
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
