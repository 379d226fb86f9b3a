//! Forward dynamics with access to inputs and results by name.

mod inputs;
mod run;

pub(crate) use run::named;
pub use run::{BodyVelocity, Event, Interface, JointMotion, Run, Sample};

use crate::error::Error;
use crate::names::Names;
use crate::request::{Loaded, Request, Sampled};
use crate::robot::Robot;
use inputs::{Efforts, Start};
use std::sync::Arc;
use stiction_core::dynamics::FrictionMode;
use stiction_core::forward::{Known, Method, Settings};
use stiction_core::kinematics::Coordinate;
use stiction_core::mechanism::JointId;
use stiction_format::{Control, ModelFile, Source};
use stiction_run::comparison::Reel;
use stiction_run::forward::{
    Animation, ControlLaw, Ending, Feed, Job, Measured, Outcome, Recorder, RunCheckpoint,
    Sample as Record, Start as JobStart, Stop, StopFunction, arrange,
};
use stiction_run::number;
use stiction_run::{Sink, SinkError};

/// Request for forward dynamics (a simulation) of a robot. Set the options, then call
/// [`run`](Self::run) or [`samples`](Request::samples).
///
/// Without options, the robot follows its default motion under a computed-torque controller that
/// knows the mechanism but not its friction. If efforts, a control law, a prescribed motion, or
/// initial coordinates or rates are set, there is no controller unless
/// [`controller`](Self::controller) sets one. A robot without a motion starts at rest in its home
/// position.
pub type Forward = Request<Simulation>;

/// Options of forward dynamics.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// Model as simulated: without friction if friction is off, and with additional actuators on
    /// locked joints.
    model: Arc<ModelFile>,
    /// Names of the bodies, joints, actuators and friction interfaces of `model`, including the
    /// additional actuators that hold locked joints in place.
    names: Arc<Names>,
    drives: Option<(Efforts, String)>,
    controller: Option<Option<(Control, String)>>,
    law: Option<ControlLaw>,
    locked: Vec<(JointId, usize)>,
    prescribed: Vec<(JointId, usize)>,
    stops: Vec<Stop>,
    start: Start,
    friction: bool,
    until: Option<f64>,
    settings: Settings,
}

impl Loaded for Simulation {}

/// Default duration of a simulation without a motion, s.
const USUAL_DURATION: f64 = 10.0;
/// Time between samples, s, unless the motion specifies a time step.
const USUAL_STEP: f64 = 0.01;
/// Maximum number of controller samples in a simulation.
const MOST_CONTROLLER_SAMPLES: f64 = 1e9;

impl Forward {
    pub(crate) fn of(robot: &Robot) -> Self {
        let task = Simulation {
            model: Arc::clone(robot.shared_model()),
            names: Arc::clone(robot.names()),
            drives: None,
            controller: None,
            law: None,
            locked: Vec::new(),
            prescribed: Vec::new(),
            stops: Vec::new(),
            start: Start::Motion,
            friction: robot.model().default_friction != Some(FrictionMode::Off),
            until: None,
            settings: Settings::default(),
        };
        let mut forward = Self::new(robot, task);
        forward.arrange();
        forward
    }

    fn arrange(&mut self) {
        let Simulation { friction, locked, .. } = &self.task;
        self.task.model = Arc::new(arrange(self.robot.model(), *friction, locked));
        self.task.names = Arc::new(Names::new(&self.task.model.mechanism));
    }

    /// Sets the efforts of actuators: assignments such as `"leg1.P = 50 N; leg2.P = 20 N"`, which may depend on
    /// measured coordinates and rates (`"A = -200 N m/rad*A - 5 N m s/rad*d(A)"`), the name of a file,
    /// `inverse` (the efforts of inverse dynamics for the motion), or `none`.
    ///
    /// # Errors
    /// There is no such actuator, or the file or the assignments are defective.
    pub fn drives(mut self, drives: &str) -> Result<Self, Error> {
        self.task.drives = Some(match drives {
            "inverse" => (Efforts::Inverse, "of inverse dynamics".to_owned()),
            text => {
                let (drives, name) = self.robot.parse_drives(&self.task.model, text)?;
                (Efforts::Given(drives), name)
            }
        });
        Ok(self)
    }

    /// Sets the controller: `pd`, `pid`, `computed-torque`, `computed-torque+friction`, the name of a TOML file,
    /// assignments such as `"type = pd; period = 2 ms; leg1.P.limit = 300 N"`, or `none`.
    ///
    /// # Errors
    /// The file or the assignments are defective.
    pub fn controller(mut self, controller: &str) -> Result<Self, Error> {
        self.task.controller = Some(match controller {
            "none" => None,
            text => Some(self.robot.parse_controller(&self.task.model, text)?),
        });
        Ok(self)
    }

    /// Sets a control law: a function of the measured state that returns the efforts of all actuators, in N or N m
    /// and in the order of [`Robot::actuators`]. It is called every `period` seconds; its efforts are added to those
    /// of [`drives`](Self::drives) and held until the next call.
    ///
    /// # Errors
    /// The period is not positive.
    pub fn control_law(
        mut self,
        period: f64,
        law: impl Fn(&Measured<'_>) -> Result<Vec<f64>, Error> + Send + Sync + 'static,
    ) -> Result<Self, Error> {
        if !(period.is_finite() && period > 0.0) {
            return Err(Error::input(format!(
                "the period of the control law is {period} s, but must be finite and greater than 0"
            ))
            .with_help("give the time between two calls in s, for example 1e-3")
            .with_option("period"));
        }
        self.task.law = Some(ControlLaw::new(period, move |measured| Ok(law(measured)?)));
        Ok(self)
    }

    /// Prescribes the motion of the actuators of a joint: they follow the reference motion exactly,
    /// and their efforts are results of the simulation.
    ///
    /// # Errors
    /// There is no such joint, or it has no actuator, or it is locked.
    pub fn prescribe(mut self, joint: &str) -> Result<Self, Error> {
        for dof in self.dofs_of(joint)? {
            self.refuse_both(joint, self.task.locked.contains(&dof))?;
            if self.robot.mechanism().actuators().all(|actuator| actuator != dof) {
                return Err(Error::input(format!("joint `{joint}` has no actuator")).with_help(
                    "a joint with a prescribed motion needs an actuator: add `actuated = true` to the joint",
                ));
            }
            if !self.task.prescribed.contains(&dof) {
                self.task.prescribed.push(dof);
            }
        }
        Ok(self)
    }

    /// Locks a joint at its position at the start, with or without an actuator.
    ///
    /// # Errors
    /// There is no such joint, or it has no scalar coordinate, or its motion is prescribed.
    pub fn hold(mut self, joint: &str) -> Result<Self, Error> {
        for dof in self.dofs_of(joint)? {
            self.refuse_both(joint, self.task.prescribed.contains(&dof))?;
            if !self.task.locked.contains(&dof) {
                self.task.locked.push(dof);
            }
        }
        let before: Vec<_> = self.task.model.mechanism.actuators().collect();
        self.arrange();
        let after: Vec<_> = self.task.model.mechanism.actuators().collect();
        let place = |old: usize| after.iter().position(|new| *new == before[old]).unwrap_or(old);
        if let Some((Efforts::Given(drives), _)) = &mut self.task.drives {
            inputs::renumber_drives(drives, place);
        }
        if let Some(Some((control, _))) = &mut self.task.controller {
            inputs::renumber_control(control, after.len(), place);
        }
        Ok(self)
    }

    /// Sets a coordinate at the start, m or rad; its rate is zero unless [`rate`](Self::rate) sets it. `coordinate`
    /// is the name of a joint, or of a body's coordinate such as `platform.x`. Coordinates that are not set follow
    /// from the loops and from the model's home position.
    ///
    /// # Errors
    /// The coordinate does not exist.
    pub fn at(mut self, coordinate: &str, value: f64) -> Result<Self, Error> {
        let known = self.known(coordinate)?;
        known.value = Some(value);
        known.rate.get_or_insert(0.0);
        Ok(self)
    }

    /// Sets the rate of a coordinate at the start, m/s or rad/s.
    ///
    /// # Errors
    /// The coordinate does not exist.
    pub fn rate(mut self, coordinate: &str, rate: f64) -> Result<Self, Error> {
        self.known(coordinate)?.rate = Some(rate);
        Ok(self)
    }

    fn known(&mut self, name: &str) -> Result<&mut Known, Error> {
        let motion = self.robot.parse_state(&format!("{name} = 0; duration = 0"))?;
        let coordinate: Coordinate = match motion.coordinates.first() {
            Some((coordinate, _)) => *coordinate,
            None => return Err(Error::input(format!("`{name}` is not a coordinate"))),
        };
        if !matches!(self.task.start, Start::Known(_)) {
            self.task.start = Start::Known(Vec::new());
        }
        let Start::Known(all) = &mut self.task.start else {
            return Err(Error::input(format!("`{name}` cannot be set")));
        };
        let index = match all.iter().position(|known| known.coordinate == coordinate) {
            Some(index) => index,
            None => {
                all.push(Known { coordinate, value: None, rate: None });
                all.len() - 1
            }
        };
        Ok(&mut all[index])
    }

    /// Sets the initial state: `motion` (position and rates of the motion), `rest` (position of the
    /// motion, with zero rates), or assignments such as `"A = 60 deg + 2 rad/s*t"`, of which the
    /// values and rates at t = 0 are used. A rate may be given separately, with or without a value:
    /// `"A = 60 deg; d(B) = 2 rad/s"`.
    ///
    /// # Errors
    /// The assignments are defective.
    pub fn from(mut self, start: &str) -> Result<Self, Error> {
        let (rates, values) = inputs::rates_apart(start);
        self.task.start = match start {
            "motion" => Start::Motion,
            "rest" => Start::AtRest,
            text if rates.is_empty() => Start::Given(self.robot.parse_state(text)?),
            _ => Start::Known(Vec::new()),
        };
        if !values.is_empty() && !rates.is_empty() {
            let motion = self.robot.parse_state(&values)?;
            let each = motion.coordinates.iter().zip(motion.at(motion.start));
            let known = each.map(|(&(coordinate, _), target)| {
                // If rates are given separately, a constant specifies a position only.
                let rate = (target.rate != 0.0).then_some(target.rate);
                Known { coordinate, value: Some(target.value), rate }
            });
            self.task.start = Start::Known(known.collect());
        }
        let mut given: Vec<Coordinate> = Vec::new();
        for (name, rate) in rates {
            // The rate times `t` has the unit of the coordinate, so it can be parsed as an
            // assignment.
            let coordinate = self.known(&name)?.coordinate;
            let motion = self.robot.parse_state(&format!("{name} = ({rate})*t"));
            let motion =
                motion.map_err(|error| self.wrong_rate((&name, coordinate), &rate, error))?;
            let target = motion.at(motion.start).next();
            let known = self.known(&name)?;
            if given.contains(&known.coordinate) {
                return Err(Error::input(format!("the rate `d({name})` is given twice"))
                    .with_help("give each rate once")
                    .with_option("from"));
            }
            given.push(known.coordinate);
            known.rate = target.map(|target| target.rate);
        }
        Ok(self)
    }

    /// Returns the error for a rate that is not understood, in terms of what the user has written;
    /// `error` is that of the rate times the time.
    fn wrong_rate(
        &self,
        (name, coordinate): (&str, Coordinate),
        rate: &str,
        error: Error,
    ) -> Error {
        let joints = self.robot.mechanism().joints();
        let types: Vec<_> = joints.iter().map(|joint| joint.joint_type).collect();
        match stiction_format::speed(rate, coordinate.is_angle(&types)) {
            Ok(_) => error,
            Err(why) => Error::input(format!("the rate `d({name})` is `{rate}`: {why}"))
                .with_help("for example \"2 rad/s\" for an angle, or \"50 mm/s\" for a length")
                .with_option("from"),
        }
    }

    /// Sets the start to a later time of the motion, s.
    pub(crate) fn begin_at(mut self, time: f64) -> Result<Self, Error> {
        let Some((motion, _)) = &mut self.motion else { return Err(self.robot.motion_missing()) };
        let end = motion.start + motion.duration;
        if !(motion.start..=end).contains(&time) {
            let start = motion.start;
            return Err(stiction_run::Error::NoSuchTime { time, start, end }.into());
        }
        (motion.start, motion.duration) = (time, end - time);
        Ok(self)
    }

    /// Sets the end time, s. The default is the end of the motion if a controller, feed-forward
    /// efforts or a prescribed actuator follow the motion. Otherwise, the default is the last
    /// sample of recorded efforts or, without recorded efforts, 10 s after the start.
    pub fn until(mut self, time: f64) -> Self {
        self.task.until = Some(time);
        self
    }

    /// Adds a condition that ends the simulation, such as `platform.z < 100 mm` or `d(leg1.P) > 0.5
    /// m/s`. Conditions may contain coordinates, their rates and the time `t`. The instant at which
    /// the condition begins to hold is located to the tolerance of the simulation. This instant is
    /// the last sample, and is recorded as an event. If there are several conditions, the first
    /// that holds ends the simulation.
    ///
    /// # Errors
    /// The condition is defective.
    pub fn stop(mut self, condition: &str) -> Result<Self, Error> {
        let source = Source::new("stop", condition);
        self.task.stops.push(self.task.model.parse_condition(&source)?.into());
        Ok(self)
    }

    /// Adds a function that ends the simulation when its value becomes negative. The function
    /// receives the measured state without reference motions, also at trial states of integration
    /// steps, and therefore must depend only on its argument. The instant is located and recorded
    /// as for a [condition](Self::stop); `name` identifies the function in the recorded event.
    pub fn stop_function(
        mut self,
        name: &str,
        function: impl Fn(&Measured<'_>) -> Result<f64, Error> + Send + Sync + 'static,
    ) -> Self {
        let function = StopFunction::new(name, move |measured| Ok(function(measured)?));
        self.task.stops.push(Stop::Function(function));
        self
    }

    /// Switches joint friction on or off. Default: the setting of the model or, if it has none, on.
    pub fn friction(mut self, on: bool) -> Self {
        self.task.friction = on;
        self.arrange();
        self
    }

    /// Sets the integration scheme: event-driven, time-stepping, or automatic.
    pub fn method(mut self, method: Method) -> Self {
        self.task.settings.method = method;
        self
    }

    /// Sets the tolerance of the relative error of an integration step. The tolerance of a Moreau
    /// time step is a thousand times as large.
    ///
    /// # Errors
    /// The tolerance is not between 1e-14 and 1e-2.
    pub fn tolerance(mut self, tolerance: f64) -> Result<Self, Error> {
        if !(1e-14..=1e-2).contains(&tolerance) {
            return Err(Error::input(format!("the tolerance is {}", number(tolerance)))
                .with_help("give a relative error between 1e-14 and 1e-2, for example 1e-10")
                .with_option("tolerance"));
        }
        let usual = Settings::default();
        let factor = tolerance / usual.relative;
        self.task.settings.relative = tolerance;
        self.task.settings.absolute = usual.absolute * factor;
        self.task.settings.time_step_tolerance = usual.time_step_tolerance * factor;
        Ok(self)
    }

    /// Selects the default controller if none is set: computed torque if the robot has a motion to
    /// follow and no option sets efforts, a control law, a prescribed motion or initial
    /// coordinates; otherwise no controller.
    ///
    /// # Errors
    /// The default controller does not fit the model.
    fn with_defaults(mut self) -> Result<Self, Error> {
        if self.task.controller.is_none() {
            let is_free =
                self.task.model.mechanism.actuators().any(|a| !self.task.locked.contains(&a));
            let moves = self.motion.as_ref().is_some_and(|(motion, _)| motion.duration > 0.0);
            let task = &self.task;
            let alone = task.drives.is_none() && task.prescribed.is_empty() && task.law.is_none();
            let is_set = matches!(self.task.start, Start::Known(_));
            self = match alone && is_free && moves && !is_set {
                true => self.controller("computed-torque")?,
                false => self.controller("none")?,
            };
        }
        Ok(self)
    }

    /// Completes and checks the options, and returns the resulting plan.
    ///
    /// # Errors
    /// Options contradict each other, or an input has no finite value at some time.
    pub fn plan(&self) -> Result<Plan, Error> {
        let plan = Plan { request: self.clone().with_defaults()? };
        inputs::check(&plan.request, &plan.job())?;
        Ok(plan)
    }

    /// Simulates and keeps all samples in memory.
    ///
    /// A simulation that ends early is no error: [`Run::ended`] states the reason and the time.
    ///
    /// # Errors
    /// The options contradict each other, or the robot cannot start.
    pub fn run(&self) -> Result<Run, Error> {
        self.run_until(&|| false)
    }

    /// Simulates as [`Self::run`] does. `stop` is called at every evaluation of the dynamics and ends the simulation
    /// with an error if it returns true.
    pub(crate) fn run_until(&self, stop: &dyn Fn() -> bool) -> Result<Run, Error> {
        let plan = self.plan()?;
        let mut samples = Vec::new();
        let outcome = plan.simulate(
            |sample| {
                samples.push(sample);
                Ok(())
            },
            stop,
        )?;
        Ok(Run::new(samples, outcome, &self.task.names))
    }
}

impl Plan {
    /// Simulates and keeps all samples in memory, with the moving robot for a page of `runs` runs; `None` without
    /// samples. As in [`Forward::run`], a simulation that ends early is no error. `stop` is that of
    /// [`Forward::run_until`].
    pub(crate) fn film(
        &self,
        runs: usize,
        stop: &dyn Fn() -> bool,
    ) -> Result<(Run, Option<Reel>), Error> {
        let job = self.job();
        let mut recorder = Recorder::new(&job, Animation::new(&job, job.instants()?.count()));
        let (names, mut samples) = (self.names(), Vec::new());
        let receive = |record: &Record<'_>, _: &dyn Fn() -> RunCheckpoint| {
            samples.push(Sample::new(Arc::clone(names), record));
            recorder.add(record)
        };
        let outcome = self.record(receive, stop, None)?;
        Ok((Run::new(samples, outcome, names), recorder.sink.reel(runs)))
    }
}

impl Forward {
    /// Returns the name of an option of this request that a plant does not support; `None` if a
    /// plant supports all options.
    pub(crate) fn unfit_for_plant(&self) -> Option<&'static str> {
        let task = &self.task;
        match () {
            () if task.drives.is_some() => Some("given efforts"),
            () if matches!(task.controller, Some(Some(_))) => Some("a controller"),
            () if task.law.is_some() => Some("a control law"),
            () if !task.locked.is_empty() => Some("a locked joint"),
            () if !task.prescribed.is_empty() => Some("a prescribed motion"),
            () if !task.stops.is_empty() => Some("a stop condition"),
            () => None,
        }
    }
}

impl Sampled for Simulation {
    type Sample = Sample;
    type Outcome = Vec<Event>;

    fn complete(request: &Forward) -> Result<Forward, Error> {
        Ok(request.plan()?.request)
    }

    fn compute(
        request: &Forward,
        receive: &mut dyn FnMut(Sample) -> Result<(), SinkError>,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Vec<Event>, Error> {
        let outcome = Plan { request: request.clone() }.simulate(receive, is_stopped)?;
        match outcome.ending {
            Ending::Failed(error) => Err((*error).into()),
            _ => Ok(run::named(&request.task.names, &outcome.events)),
        }
    }
}

/// A complete, consistent request for a simulation; see [`Forward::plan`].
#[derive(Clone, Debug)]
pub struct Plan {
    request: Forward,
}

impl Plan {
    /// Names of the bodies, joints, actuators and friction interfaces of the simulated model.
    pub(crate) fn names(&self) -> &Arc<Names> {
        &self.request.task.names
    }

    /// Converts the request to a [`Job`], which the tables, plots and summaries of `stiction_run`
    /// require.
    pub fn job(&self) -> Job<'_> {
        let (request, task) = (&self.request, &self.request.task);
        let motion = request.motion.as_ref().map(|(motion, _)| motion);
        let start = match (&task.start, motion) {
            (Start::Known(known), _) => JobStart::Known(known),
            (Start::Given(given), _) => JobStart::Given(given),
            (_, None) => JobStart::Home,
            (Start::AtRest, Some(_)) => JobStart::AtRest,
            (Start::Motion, Some(_)) => JobStart::Moving,
        };
        let from = motion.map_or(0.0, |motion| motion.start);
        let mechanism = &task.model.mechanism;
        let index = |of: &(JointId, usize)| mechanism.actuators().position(|known| known == *of);
        let mut job = Job {
            motion,
            stops: &task.stops,
            prescribed: task.prescribed.iter().filter_map(index).collect(),
            locked: task.locked.iter().filter_map(index).collect(),
            start,
            from,
            until: from + USUAL_DURATION,
            step: request.step.or(motion.and_then(|motion| motion.step)).unwrap_or(USUAL_STEP),
            settings: task.settings,
            friction: task.friction,
            ..Job::new(&task.model, (&request.load.1, &request.load.0))
        };
        if let Some((_, name)) = &request.motion {
            job.motion_name.clone_from(name);
        }
        if let Some((efforts, name)) = &task.drives {
            job.drives_name.clone_from(name);
            job.drives = match efforts {
                Efforts::Inverse => Feed::Inverse,
                Efforts::Given(drives) => Feed::Given(drives),
            };
        }
        if let Some(Some((control, name))) = &task.controller {
            (job.control, job.control_name) = (Some(control), name.clone());
        }
        if let Some(law) = &task.law {
            job.law = Some(law);
            if job.control.is_none() {
                job.control_name = "of the caller".to_owned();
            }
        }
        let recorded = match &task.drives {
            Some((Efforts::Given(drives), _)) => {
                drives.samples.as_ref().and_then(|samples| samples.ends()).map(|(_, last)| last)
            }
            _ => None,
        };
        match (motion, recorded) {
            (Some(motion), _) if job.follows() => job.until = from + motion.duration,
            (_, Some(last)) => job.until = last,
            _ => {}
        }
        job.until = task.until.unwrap_or(job.until);
        job
    }

    /// Simulates and passes each sample to `receive`, together with a function that creates a
    /// checkpoint. Tables, plots and summaries of `stiction_run` receive the samples through
    /// `Recorder` of that crate. Polls `is_stopped` while samples are computed. If a checkpoint is
    /// given, the simulation continues after the last sample of the checkpoint.
    ///
    /// # Errors
    /// The robot cannot start, or `receive` returned an error. A simulation that fails later is no
    /// error: the outcome contains the reason.
    pub fn record(
        &self,
        receive: impl FnMut(&Record<'_>, &dyn Fn() -> RunCheckpoint) -> Result<(), SinkError>,
        is_stopped: &dyn Fn() -> bool,
        checkpoint: Option<&RunCheckpoint>,
    ) -> Result<Outcome, Error> {
        Ok(self.job().run(receive, is_stopped, checkpoint)?)
    }

    fn simulate(
        &self,
        mut receive: impl FnMut(Sample) -> Result<(), SinkError>,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Outcome, Error> {
        let names = &self.request.task.names;
        let receive = |record: &Record<'_>, _: &dyn Fn() -> RunCheckpoint| {
            receive(Sample::new(Arc::clone(names), record))
        };
        self.record(receive, is_stopped, None)
    }
}
