//! Forward dynamics, by name.

mod inputs;
mod run;

pub use run::{Event, Interface, JointMotion, Run, Sample, Samples};

use crate::error::Error;
use crate::explain;
use crate::names::Names;
use crate::robot::Robot;
use crate::stream::{Sender, Stream};
use inputs::{Efforts, Start};
use std::sync::Arc;
use stiction_core::dynamics::FrictionMode;
use stiction_core::forward::{Known, Method, Settings};
use stiction_core::kinematics::Coordinate;
use stiction_core::mechanism::JointId;
use stiction_format::{Control, Drives, LoadCase, ModelFile, Motion};
use stiction_run::forward::{Ending, Feed, Job, Outcome, Start as JobStart, arrange};

/// Forward dynamics of a robot: options, then [`run`](Self::run) or [`samples`](Self::samples).
///
/// Without options, the robot follows its default motion under a computed-torque controller that
/// knows the mechanism but not its friction. If [`drives`](Self::drives) or
/// [`prescribe`](Self::prescribe) is set, there is no controller unless one is given. A robot
/// without a motion starts at rest in its home position.
#[derive(Clone, Debug)]
pub struct Forward {
    robot: Robot,
    /// The model with actuators on all locked joints.
    model: Arc<ModelFile>,
    /// Names of this model. Locked joints are actuators, whose efforts hold them.
    names: Arc<Names>,
    motion: Option<(Motion, String)>,
    load: (LoadCase, String),
    drives: Option<(Efforts, String)>,
    controller: Option<Option<(Control, String)>>,
    locked: Vec<(JointId, usize)>,
    prescribed: Vec<(JointId, usize)>,
    start: Start,
    friction: bool,
    until: Option<f64>,
    step: Option<f64>,
    settings: Settings,
}

/// Default duration of a simulation without a motion, s.
const USUAL_DURATION: f64 = 10.0;
/// Time between samples, s, unless the motion states another.
const USUAL_STEP: f64 = 0.01;
/// Controller samples of a simulation, at most.
const MOST_CONTROLLER_SAMPLES: f64 = 1e9;

impl Forward {
    pub(crate) fn new(robot: Robot) -> Self {
        let friction = robot.model().default_friction != Some(FrictionMode::Off);
        let mut forward = Self {
            model: Arc::clone(robot.shared_model()),
            names: Arc::clone(robot.names()),
            motion: robot.default_motion(),
            load: robot.default_load(),
            drives: None,
            controller: None,
            locked: Vec::new(),
            prescribed: Vec::new(),
            start: Start::Motion,
            friction,
            until: None,
            step: None,
            settings: Settings::default(),
            robot,
        };
        forward.arrange();
        forward
    }

    fn arrange(&mut self) {
        self.model = Arc::new(arrange(self.robot.model(), self.friction, &self.locked));
        self.names = Arc::new(Names::new(&self.model.mechanism));
    }

    /// Sets the motion: its name in the model, the name of a file, or assignments. The robot starts on it,
    /// and controllers follow it.
    ///
    /// # Errors
    /// There is no such motion, or the file or the assignments are defective.
    pub fn motion(mut self, motion: &str) -> Result<Self, Error> {
        self.motion = Some(self.robot.parse_motion(motion)?);
        Ok(self)
    }

    /// Sets the load: its name in the model, or assignments such as `"platform.fz = -100 N"`.
    ///
    /// # Errors
    /// There is no such load, or the assignments are defective.
    pub fn load(mut self, load: &str) -> Result<Self, Error> {
        self.load = self.robot.parse_load(load)?;
        Ok(self)
    }

    /// Sets the efforts of actuators: assignments such as `"leg1.P = 50 N; leg2.P = 20 N"`, the name of a
    /// file, `inverse` (the efforts of inverse dynamics for the motion), or `none`.
    ///
    /// # Errors
    /// There is no such actuator, or the file or the assignments are defective.
    pub fn drives(mut self, drives: &str) -> Result<Self, Error> {
        self.drives = Some(match drives {
            "inverse" => (Efforts::Inverse, "of inverse dynamics".to_owned()),
            text => {
                let (drives, name) = self.robot.parse_drives(&self.model, text)?;
                (Efforts::Given(drives), name)
            }
        });
        Ok(self)
    }

    /// Sets the controller: `pd`, `computed-torque`, `computed-torque+friction`, the name of a TOML file,
    /// assignments such as `"type = pd; period = 2 ms; leg1.P.limit = 300 N"`, or `none`.
    ///
    /// # Errors
    /// The file or the assignments are defective.
    pub fn controller(mut self, controller: &str) -> Result<Self, Error> {
        self.controller = Some(match controller {
            "none" => None,
            text => Some(self.robot.parse_controller(&self.model, text)?),
        });
        Ok(self)
    }

    /// Prescribes the motion of an actuator: it follows the motion exactly, and its effort is a result.
    ///
    /// # Errors
    /// There is no such joint, or it has no actuator, or it is locked.
    pub fn prescribe(mut self, joint: &str) -> Result<Self, Error> {
        for dof in self.dofs_of(joint)? {
            self.refuse_both(joint, self.locked.contains(&dof))?;
            if self.robot.mechanism().actuators().all(|actuator| actuator != dof) {
                return Err(Error::input(format!("joint `{joint}` has no actuator")).with_help(
                    "a prescribed joint needs one: add `actuated = true` to the joint",
                ));
            }
            if !self.prescribed.contains(&dof) {
                self.prescribed.push(dof);
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
            self.refuse_both(joint, self.prescribed.contains(&dof))?;
            if !self.locked.contains(&dof) {
                self.locked.push(dof);
            }
        }
        let before: Vec<_> = self.model.mechanism.actuators().collect();
        self.arrange();
        let after: Vec<_> = self.model.mechanism.actuators().collect();
        let place = |old: usize| after.iter().position(|new| *new == before[old]).unwrap_or(old);
        if let Some((Efforts::Given(drives), _)) = &mut self.drives {
            inputs::renumber_drives(drives, place);
        }
        if let Some(Some((control, _))) = &mut self.controller {
            inputs::renumber_control(control, after.len(), place);
        }
        Ok(self)
    }

    /// Sets a coordinate at the start, m or rad, at rest unless [`rate`](Self::rate) sets its rate.
    /// `coordinate` is a joint's name, or one like `platform.x` of a body. Coordinates that are not set
    /// follow from the loops and from the model's home position.
    ///
    /// # Errors
    /// There is no such coordinate.
    pub fn at(mut self, coordinate: &str, value: f64) -> Result<Self, Error> {
        let known = self.known(coordinate)?;
        known.value = Some(value);
        known.rate.get_or_insert(0.0);
        Ok(self)
    }

    /// Sets the rate of a coordinate at the start, m/s or rad/s.
    ///
    /// # Errors
    /// There is no such coordinate.
    pub fn rate(mut self, coordinate: &str, rate: f64) -> Result<Self, Error> {
        self.known(coordinate)?.rate = Some(rate);
        Ok(self)
    }

    fn known(&mut self, name: &str) -> Result<&mut Known, Error> {
        let motion = self.robot.parse_state(&format!("{name} = 0; duration = 0"))?;
        let coordinate: Coordinate = match motion.coordinates.first() {
            Some((coordinate, _)) => *coordinate,
            None => return Err(Error::input(format!("`{name}` is no coordinate"))),
        };
        if !matches!(self.start, Start::Known(_)) {
            self.start = Start::Known(Vec::new());
        }
        let Start::Known(all) = &mut self.start else {
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

    /// Sets the start: `motion` (position and rates of the motion), `rest` (its position, at rest), or
    /// assignments such as `"A = 60 deg + 2 rad/s*t"`, whose values and rates at t = 0 count.
    ///
    /// # Errors
    /// The assignments are defective.
    pub fn from(mut self, start: &str) -> Result<Self, Error> {
        self.start = match start {
            "motion" => Start::Motion,
            "rest" => Start::AtRest,
            text => Start::Given(self.robot.parse_state(text)?),
        };
        Ok(self)
    }

    /// Sets the end, s. Default: the end of the motion if a controller or an actuator follows it,
    /// else 10 s after the start.
    pub fn until(mut self, time: f64) -> Self {
        self.until = Some(time);
        self
    }

    /// Sets the time between samples, s. Default: that of the motion, else 0.01 s. It does not change the
    /// steps of integration.
    pub fn step(mut self, step: f64) -> Self {
        self.step = Some(step);
        self
    }

    /// Switches joint friction on or off. Default: as the model says, else on.
    pub fn friction(mut self, on: bool) -> Self {
        self.friction = on;
        self.arrange();
        self
    }

    /// Sets the integration scheme: event-driven, time-stepping, or automatic.
    pub fn method(mut self, method: Method) -> Self {
        self.settings.method = method;
        self
    }

    /// Sets the relative error of a step of integration; that of a time step is a thousand times as large.
    ///
    /// # Errors
    /// It is not between 1e-14 and 1e-2.
    pub fn tolerance(mut self, tolerance: f64) -> Result<Self, Error> {
        if !(1e-14..=1e-2).contains(&tolerance) {
            return Err(Error::input(format!("the tolerance is {tolerance}"))
                .with_help("give a relative error between 1e-14 and 1e-2, for example 1e-10")
                .with_option("tolerance"));
        }
        let usual = Settings::default();
        let factor = tolerance / usual.relative;
        self.settings.relative = tolerance;
        self.settings.absolute = usual.absolute * factor;
        self.settings.time_step_tolerance = usual.time_step_tolerance * factor;
        Ok(self)
    }

    /// Adds the default controller if the other options require it.
    ///
    /// # Errors
    /// The default controller does not fit the model.
    fn with_defaults(mut self) -> Result<Self, Error> {
        if self.controller.is_none() {
            let is_free = self.model.mechanism.actuators().any(|a| !self.locked.contains(&a));
            let moves = self.motion.as_ref().is_some_and(|(motion, _)| motion.duration > 0.0);
            let alone = self.drives.is_none() && self.prescribed.is_empty();
            let is_set = matches!(self.start, Start::Known(_));
            self = match alone && is_free && moves && !is_set {
                true => self.controller("computed-torque")?,
                false => self.controller("none")?,
            };
        }
        Ok(self)
    }

    /// Completes and checks the options.
    ///
    /// # Errors
    /// Options contradict each other, or an input has no finite value at some time.
    pub fn plan(&self) -> Result<Plan, Error> {
        let plan = Plan { request: self.clone().with_defaults()? };
        plan.checked_job()?;
        Ok(plan)
    }

    /// Simulates, and keeps all samples in memory.
    ///
    /// A simulation that stops early is no error: [`Run::ended`] gives the reason and the time.
    ///
    /// # Errors
    /// The options contradict each other, or the robot cannot start.
    pub fn run(&self) -> Result<Run, Error> {
        let plan = self.plan()?;
        let mut samples = Vec::new();
        let outcome = plan.compute(
            |sample| {
                samples.push(sample);
                Ok(())
            },
            &|| false,
        )?;
        Ok(Run::new(samples, outcome, &self.names))
    }

    /// Starts the simulation and returns its samples one by one, in the order of time.
    ///
    /// It runs on a thread of its own, at most 64 samples ahead, so that memory is bounded for any
    /// duration. It stops when the iterator is dropped. A simulation that cannot continue ends with
    /// an error.
    ///
    /// # Errors
    /// The options contradict each other.
    pub fn samples(&self) -> Result<Samples, Error> {
        let plan = self.plan()?;
        let stream = Stream::start(move |sender: &Sender<Sample>| {
            let outcome = plan.compute(|sample| sender.send(sample), &|| sender.is_stopped())?;
            match outcome.ending {
                Ending::Failed(error) => Err(explain::forward(*error)),
                _ => Ok(run::named(&plan.request.names, &outcome.events)),
            }
        })?;
        Ok(Samples { stream })
    }
}

/// A complete, consistent request for a simulation; see [`Forward::plan`].
#[derive(Clone, Debug)]
pub struct Plan {
    request: Forward,
}

impl Plan {
    /// Converts the request to that of `stiction_run`, as its tables, plots and summaries require.
    pub fn job(&self) -> Job<'_> {
        let request = &self.request;
        let motion = request.motion.as_ref().map(|(motion, _)| motion);
        let start = match (&request.start, motion) {
            (Start::Known(known), _) => JobStart::Known(known),
            (Start::Given(given), _) => JobStart::Given(given),
            (_, None) => JobStart::Home,
            (Start::AtRest, Some(_)) => JobStart::AtRest,
            (Start::Motion, Some(_)) => JobStart::Moving,
        };
        let from = motion.map_or(0.0, |motion| motion.start);
        let (drives, drives_name) = match &request.drives {
            None => (Feed::Given(&NO_DRIVES), "none"),
            Some((Efforts::Inverse, name)) => (Feed::Inverse, name.as_str()),
            Some((Efforts::Given(drives), name)) => (Feed::Given(drives), name.as_str()),
        };
        let control = request.controller.as_ref().and_then(Option::as_ref);
        let mechanism = &request.model.mechanism;
        let index = |of: &(JointId, usize)| mechanism.actuators().position(|known| known == *of);
        let mut job = Job {
            model: &request.model,
            motion,
            motion_name: request.motion.as_ref().map_or("none", |(_, name)| name).to_owned(),
            load: &request.load.0,
            load_name: request.load.1.clone(),
            drives,
            drives_name: drives_name.to_owned(),
            control: control.map(|(control, _)| control),
            control_name: control.map_or("none", |(_, name)| name).to_owned(),
            prescribed: request.prescribed.iter().filter_map(index).collect(),
            locked: request.locked.iter().filter_map(index).collect(),
            start,
            from,
            until: from + USUAL_DURATION,
            step: request.step.or(motion.and_then(|motion| motion.step)).unwrap_or(USUAL_STEP),
            settings: request.settings,
            friction: request.friction,
        };
        let recorded = match &request.drives {
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
        job.until = request.until.unwrap_or(job.until);
        job
    }

    fn checked_job(&self) -> Result<Job<'_>, Error> {
        let request = &self.request;
        let job = self.job();
        inputs::check(request, &job)?;
        Ok(job)
    }

    fn compute(
        &self,
        mut receive: impl FnMut(Sample) -> Result<(), String>,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Outcome, Error> {
        let job = self.job();
        let names = &self.request.names;
        job.run(
            |sample| receive(Sample::new(Arc::clone(names), sample)),
            |_done, _of, _checkpoint| Ok(()),
            is_stopped,
            None,
        )
        .map_err(explain::forward)
    }
}

/// No efforts at all.
static NO_DRIVES: Drives =
    Drives { title: String::new(), efforts: Vec::new(), samples: None, interpolation: None };
