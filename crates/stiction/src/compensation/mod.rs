//! Comparison of control laws on a simulated robot with friction.

mod compensator;
mod result;
mod sensors;
mod transition;

pub use compensator::Compensator;
pub use result::{Compared, LawResult};
pub use transition::Transition;

use crate::error::Error;
use crate::export::Recorded;
use crate::forward::Forward;
use crate::robot::Robot;
use compensator::{Controller, Instant, Model, best_constants, split};
use sensors::{Imperfections, Sensors};
use std::f64::consts::TAU;
use std::sync::{Arc, Mutex, PoisonError};
use stiction_core::kinematics::Target;
use stiction_core::random::Random;
use stiction_program::{Feedforward, Tunable};
use stiction_run::identify::Progress;
use stiction_run::number;

/// Default sampling period, s.
const PERIOD: f64 = 1e-3;
/// Number of instants of the motion at which the friction of the model is evaluated to fit the
/// constant friction of each actuator.
const FITTED: u32 = 2000;
/// Maximum number of controller samples in one simulation.
const MOST_SAMPLES: f64 = 1e7;

/// Comparison of control laws on a robot whose joints have friction; see
/// [`Robot::compensation`].
///
/// The plant is the simulation of [`Robot::forward`] with friction. The controller samples it through sensors of
/// given resolution and noise, and knows the friction coefficients to a given accuracy.
#[derive(Clone, Debug)]
pub struct Compensation {
    robot: Robot,
    motion: Option<String>,
    load: String,
    laws: Vec<Compensator>,
    transitions: Vec<Transition>,
    bandwidth: f64,
    damping: f64,
    period: f64,
    known_to: f64,
    seed: u64,
    imperfections: Imperfections,
    delay: f64,
}

impl Compensation {
    pub(crate) fn of(robot: &Robot) -> Self {
        Self {
            robot: robot.clone(),
            motion: None,
            load: "none".to_owned(),
            laws: Compensator::ALL.to_vec(),
            transitions: vec![Transition::Sign],
            bandwidth: 5.0,
            damping: 1.0,
            period: PERIOD,
            known_to: 0.1,
            seed: 1,
            imperfections: Imperfections::default(),
            delay: 0.0,
        }
    }

    /// Sets the motion, as in [`Robot::inverse`]. Default: the default motion of the model.
    pub fn motion(mut self, motion: &str) -> Self {
        self.motion = Some(motion.to_owned());
        self
    }

    /// Sets a load that acts on the plant but is unknown to all controllers; none by default.
    pub fn load(mut self, load: &str) -> Self {
        load.clone_into(&mut self.load);
        self
    }

    /// Sets the control laws; all by default.
    pub fn laws(mut self, laws: &[Compensator]) -> Self {
        self.laws = laws.to_vec();
        self
    }

    /// Sets the transitions, which determine how friction is compensated at reversals and at rest.
    /// Each law that compensates friction is simulated with each transition. Default: only
    /// [`Transition::Sign`].
    pub fn transitions(mut self, transitions: &[Transition]) -> Self {
        self.transitions = transitions.to_vec();
        self
    }

    /// Sets the bandwidth of the position control, Hz; 5 by default. The control is critically damped.
    pub fn bandwidth(mut self, bandwidth: f64) -> Self {
        self.bandwidth = bandwidth;
        self
    }

    /// Sets the time between two samples of the controller, s; 1 ms by default.
    pub fn period(mut self, period: f64) -> Self {
        self.period = period;
        self
    }

    /// Sets the relative accuracy to which the controller knows each coefficient of friction, and the seed of the
    /// random errors; 0.1 and 1 by default.
    pub fn known_to(mut self, relative: f64, seed: u64) -> Self {
        (self.known_to, self.seed) = (relative, seed);
        self
    }

    /// Sets the increment of the encoders and the standard deviation of the position noise, in m or
    /// rad. Both are zero by default; the controller then also receives exact rates.
    pub fn sensors(mut self, resolution: f64, noise: f64) -> Self {
        (self.imperfections.resolution, self.imperfections.noise) = (resolution, noise);
        self
    }

    /// Sets the delay between a measurement and the effort computed from it, s, rounded to whole
    /// periods; zero by default.
    pub fn delay(mut self, delay: f64) -> Self {
        self.delay = delay;
        self
    }

    fn check(&self) -> Result<(), Error> {
        let refuse = |what: &str, value: f64, help: &str, option: &'static str| {
            Err(Error::input(format!("{what} is {value}")).with_help(help).with_option(option))
        };
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let size = |x: f64| x.is_finite() && x >= 0.0;
        if !positive(self.period) {
            return refuse(
                "the period of the controller in s",
                self.period,
                "give a time, for example 1 ms",
                "period",
            );
        }
        if !positive(self.bandwidth) {
            let help = "give a frequency above 0, for example 5 Hz";
            return refuse("the bandwidth in Hz", self.bandwidth, help, "bandwidth");
        }
        if self.bandwidth * self.period > 0.1 {
            let message = format!(
                "a sampling period of {} s is too long for a bandwidth of {} Hz: the maximum is {} s, a tenth of the \
                 period of this frequency",
                number(self.period),
                number(self.bandwidth),
                number(0.1 / self.bandwidth)
            );
            let help = format!(
                "give a shorter period, or a bandwidth of at most {} Hz",
                number(0.1 / self.period)
            );
            // With the usual period, the bandwidth is at fault.
            let option = if self.period == PERIOD { "bandwidth" } else { "period" };
            return Err(Error::input(message).with_help(help).with_option(option));
        }
        if !(size(self.known_to) && self.known_to < 1.0) {
            let help = "give a relative accuracy below 1, for example 0.1";
            return refuse(
                "the relative accuracy of the friction coefficients",
                self.known_to,
                help,
                "known-to",
            );
        }
        let Imperfections { resolution, noise, .. } = self.imperfections;
        if !size(resolution) {
            return refuse(
                "the resolution of the encoders in m or rad",
                resolution,
                "give a size in m or rad",
                "resolution",
            );
        }
        if !size(noise) {
            return refuse(
                "the noise of the positions in m or rad",
                noise,
                "give a size in m or rad",
                "noise",
            );
        }
        if !(size(self.delay) && self.delay <= 1000.0 * self.period) {
            return refuse(
                "the delay in s",
                self.delay,
                "give a delay of at most 1000 controller periods",
                "delay",
            );
        }
        if self.laws.is_empty() {
            return Err(Error::input("no controller is given").with_option("controller"));
        }
        let is_width = |transition: &Transition| match transition {
            Transition::Tanh(width) => *width > 0.0 && *width <= 1.0,
            Transition::Sign | Transition::Fade => true,
        };
        if self.transitions.is_empty() || !self.transitions.iter().all(is_width) {
            let message =
                "no transition is given, or a width is out of range (greater than 0, at most 1)";
            return Err(Error::input(message).with_option("transition"));
        }
        Ok(())
    }

    fn plant(&self) -> Result<Forward, Error> {
        let mut plant = self.robot.forward().friction(true).load(&self.load)?;
        if let Some(motion) = &self.motion {
            plant = plant.motion(motion)?;
        }
        Ok(plant)
    }

    /// Simulates the robot under each control law.
    ///
    /// # Errors
    /// The options are not valid, or the robot has no feed-forward program (as in [`Robot::export`]). A simulation
    /// that ends early is a result, not an error.
    pub fn run(&self) -> Result<Compared, Error> {
        self.run_with(&|_, _, _| {})
    }

    /// Simulates the robot as [`Self::run`] does. `progress` receives the name of the present step of the computation,
    /// and how many of its samples, of how many, are done.
    ///
    /// # Errors
    /// See [`Self::run`].
    pub fn run_with(&self, progress: Progress<'_>) -> Result<Compared, Error> {
        self.check()?;
        let plant = self.plant()?;
        let Some((motion, name)) = &plant.motion else { return Err(self.robot.motion_missing()) };
        if motion.duration / self.period > MOST_SAMPLES {
            let message = format!("the controller would sample more than {MOST_SAMPLES:.0e} times");
            return Err(Error::input(message)
                .with_help("give a longer period or a shorter motion")
                .with_option("period"));
        }
        let mut export = self.robot.export();
        if let Some(motion) = &self.motion {
            export = export.motion(motion);
        }
        let Recorded { program, labels, .. } = export.record()?;
        let program = Arc::new(program);
        let course = self.course(&program, progress)?;
        let Some((first, _)) = course.first() else {
            return Err(Error::input("the motion has no duration")
                .with_help("use --motion to choose a motion in which the robot moves"));
        };
        let [start, ..] = split(first);
        let model = Model::at(&program, &start)?;
        let constants = best_constants(&course, labels.actuators.len());
        let omega = TAU * self.bandwidth;
        let mut believed = model.clone();
        believed.tune(&self.believed(program.tunables()));
        let delay = (self.delay / self.period).round() as usize;
        let imperfections = Imperfections { delay, ..self.imperfections };
        let controller = Controller {
            law: Compensator::Pd,
            transition: Transition::Sign,
            fastest: fastest(&course, labels.actuators.len()),
            held: 1.0,
            gains: [omega * omega, 2.0 * self.damping * omega],
            masses: masses(&mut model.clone(), &start)?,
            constants,
            measured: model,
            reference: believed,
            sensors: Sensors::new(imperfections, self.period, self.seed),
            records: Vec::new(),
        };
        // The report shows the laws with their first transition.
        let runs = self.laws.len();
        let each = (motion.duration / self.period).ceil() as usize;
        let simulate = |(index, count): (usize, usize),
                        (law, transition): (Compensator, Transition)|
         -> Result<LawResult, Error> {
            let own = Controller { law, transition, ..controller.clone() };
            let shared = Arc::new(Mutex::new(own));
            let own = Arc::clone(&shared);
            let plant = plant.clone().control_law(self.period, move |measured| {
                own.lock().unwrap_or_else(PoisonError::into_inner).efforts(measured)
            })?;
            // Called at every evaluation of the dynamics.
            let keep_on = || {
                let records = &shared.lock().unwrap_or_else(PoisonError::into_inner).records;
                let done = index * each + records.len().min(each);
                progress("simulating the controllers", done, count * each);
                false
            };
            let is_drawn = self.transitions.first() == Some(&transition);
            let (run, reel) = match is_drawn {
                true => plant.plan()?.film(runs, &keep_on)?,
                false => (plant.run_until(&keep_on)?, None),
            };
            let records =
                std::mem::take(&mut shared.lock().unwrap_or_else(PoisonError::into_inner).records);
            let names = labels.actuators.iter().map(|(name, _)| name);
            LawResult::new((law, transition), &records, (&run, reel), names)
        };
        // A law without friction compensation does not depend on the transition and is simulated
        // only once.
        let pairs = self.laws.iter().flat_map(|law| {
            let count = if law.has_friction() { self.transitions.len() } else { 1 };
            self.transitions.iter().take(count).map(|transition| (*law, *transition))
        });
        let pairs: Vec<_> = pairs.collect();
        let count = pairs.len();
        let simulated = pairs.into_iter().enumerate().map(|(k, pair)| simulate((k, count), pair));
        let laws = simulated.collect::<Result<_, _>>()?;
        Ok(Compared {
            tracked: stiction_run::tracked(self.robot.model(), Some(motion)),
            robot: self.robot.name().to_owned(),
            motion: name.clone(),
            load: self.load.clone(),
            duration: motion.duration,
            period: self.period,
            bandwidth: self.bandwidth,
            known_to: self.known_to,
            resolution: self.imperfections.resolution,
            noise: self.imperfections.noise,
            delay: delay as f64 * self.period,
            actuators: labels
                .coordinates
                .iter()
                .zip(&labels.actuators)
                .map(|((name, unit), (_, effort))| (name.clone(), *unit, *effort))
                .collect(),
            laws,
        })
    }

    /// Friction coefficients as the controller knows them, with random errors.
    fn believed(&self, tunables: &[(Tunable, Vec<f64>)]) -> Vec<f64> {
        let mut random = Random::new(self.seed);
        // Discards the first numbers, which are similar for neighbouring seeds.
        for _ in 0..8 {
            random.number();
        }
        let values = tunables.iter().flat_map(|(_, values)| values);
        values.map(|value| value * (1.0 + self.known_to * random.number())).collect()
    }

    /// Computes the reference motions of the actuators along the motion, and the true contribution
    /// of friction to the actuator efforts.
    fn course(
        &self,
        program: &Arc<Feedforward>,
        progress: Progress<'_>,
    ) -> Result<Vec<Instant>, Error> {
        let mut check = self.robot.check_along();
        if let Some(motion) = &self.motion {
            check = check.motion(motion)?;
        }
        let job = check.job()?;
        let mut follower = job.assemble(job.motion.start)?;
        let actuators: Vec<_> = follower.solver.mechanism().actuators().collect();
        let mut course: Vec<Instant> = Vec::new();
        let mut model: Option<Model> = None;
        for k in 0..FITTED {
            progress("computing friction along the motion", k as usize, FITTED as usize);
            let part = f64::from(k) / f64::from(FITTED);
            follower.go_to(job.motion.start + job.motion.duration * part)?;
            let mut targets = Vec::with_capacity(actuators.len());
            for (index, &(joint, dof)) in actuators.iter().enumerate() {
                let found = follower.solver.joint_motion(joint, dof);
                let translates = follower.solver.mechanism().joints()[joint.0].joint_type.dofs()
                    [dof]
                    .translates();
                let before = match course.last() {
                    Some((before, _)) => before[index].value,
                    None => program.home()[index],
                };
                // The solver returns angles within half a turn of zero. Subtracting whole turns
                // makes the angles continuous along the motion.
                let turns = if translates { 0.0 } else { ((found.value - before) / TAU).round() };
                targets.push(Target { value: found.value - turns * TAU, ..found });
            }
            let own = match &mut model {
                Some(own) => own,
                None => {
                    let [q, ..] = split(&targets);
                    model.insert(Model::at(program, &q)?)
                }
            };
            let friction = own.friction(&targets)?;
            course.push((targets, friction));
        }
        Ok(course)
    }
}

/// Largest rate of each actuator along the reference, m/s or rad/s.
fn fastest(course: &[Instant], count: usize) -> Vec<f64> {
    let of = |k: usize| course.iter().fold(0.0, |most: f64, (at, _)| most.max(at[k].rate.abs()));
    (0..count).map(of).collect()
}

/// Effective mass of each actuator: the effort for unit acceleration while the other actuators rest, kg or kg m^2.
fn masses(model: &mut Model, q: &[f64]) -> Result<Vec<f64>, Error> {
    let zero = vec![0.0; q.len()];
    let still = model.ideal(q, &zero, &zero)?;
    (0..q.len())
        .map(|k| {
            let mut acceleration = zero.clone();
            acceleration[k] = 1.0;
            Ok(model.ideal(q, &zero, &acceleration)?[k] - still[k])
        })
        .collect()
}
