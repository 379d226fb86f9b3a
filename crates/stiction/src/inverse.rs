//! Inverse dynamics along a motion, by name.

use crate::error::Error;
use crate::explain;
use crate::names::Names;
use crate::robot::Robot;
use crate::stream::{Sender, Stream};
use std::num::NonZeroUsize;
use std::sync::Arc;
use stiction_core::dynamics::FrictionMode;
use stiction_core::mechanism::Motor;
use stiction_core::spatial::{Pose, Vec3};
use stiction_format::{LoadCase, Motion};
use stiction_run::inverse::{Job, Verdict};

/// Inverse dynamics of a robot along a motion: options, then [`samples`](Self::samples),
/// [`each`](Self::each) or [`collect`](Self::collect).
///
/// Without options: the model's default motion, load and friction, on one thread.
#[derive(Clone, Debug)]
pub struct Inverse {
    robot: Robot,
    motion: Option<(Motion, String)>,
    load: (LoadCase, String),
    friction: FrictionMode,
    step: Option<f64>,
    friction_margin: bool,
    threads: NonZeroUsize,
}

impl Inverse {
    pub(crate) fn new(robot: Robot) -> Self {
        let motion = robot.default_motion();
        let load = robot.default_load();
        let friction = robot.model().default_friction.unwrap_or_default();
        let threads = NonZeroUsize::MIN;
        Self { robot, motion, load, friction, step: None, friction_margin: false, threads }
    }

    /// Sets the motion: its name in the model, the name of a file (CSV or TOML), or assignments such as
    /// `"platform.x = 5 mm*sin(2*pi*t); duration = 2 s"`.
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

    /// Sets how friction is coupled with the reactions that cause it: converged, one pass, or off.
    pub fn friction(mut self, friction: FrictionMode) -> Self {
        self.friction = friction;
        self
    }

    /// Sets the time between samples, s. Default: that of the motion, else 0.01 s.
    pub fn step(mut self, step: f64) -> Self {
        self.step = Some(step);
        self
    }

    /// Sets the number of threads that compute. Results do not depend on it, to the last bit.
    pub fn threads(mut self, threads: NonZeroUsize) -> Self {
        self.threads = threads;
        self
    }

    /// Asks for the friction margin to jamming: the factor by which all friction coefficients can grow
    /// before friction locks the mechanism.
    pub fn friction_margin(mut self, ask: bool) -> Self {
        self.friction_margin = ask;
        self
    }

    /// Converts the request to that of `stiction_run`, as its tables, plots and summaries require.
    ///
    /// # Errors
    /// The model has no default motion, and none was given.
    pub fn job(&self) -> Result<Job<'_>, Error> {
        let (motion, name) = self.motion.as_ref().ok_or_else(|| self.robot.motion_missing())?;
        Ok(Job {
            model: self.robot.model(),
            motion,
            motion_name: name.clone(),
            load: &self.load.0,
            load_name: self.load.1.clone(),
            friction: self.friction,
            step: self.step,
            friction_margin: self.friction_margin,
        })
    }

    /// Starts the computation and returns its samples one by one, in the order of time.
    ///
    /// The computation runs on a thread of its own, at most 64 samples ahead, so that memory is
    /// bounded for any duration. It stops when the iterator is dropped.
    ///
    /// # Errors
    /// The model has no default motion, and none was given.
    pub fn samples(&self) -> Result<Samples, Error> {
        self.job()?;
        let request = self.clone();
        let stream = Stream::start(move |sender: &Sender<Sample>| {
            request.compute(|sample| sender.send(sample), &|| sender.is_stopped())
        })?;
        Ok(Samples { stream })
    }

    /// Computes all samples on the calling thread and passes each to `receive`, in the order of
    /// time. Stops at the first error that `receive` returns.
    ///
    /// # Errors
    /// The motion cannot be followed, or there are no finite efforts; or the error of `receive`.
    pub fn each(
        &self,
        mut receive: impl FnMut(Sample) -> Result<(), Error>,
    ) -> Result<Verdict, Error> {
        let mut failed = None;
        let outcome = self.compute(
            |sample| {
                receive(sample).map_err(|error| {
                    let message = error.message();
                    failed = Some(error);
                    message
                })
            },
            &|| false,
        );
        match failed {
            Some(error) => Err(error),
            None => outcome,
        }
    }

    /// Computes all samples and keeps them in memory.
    ///
    /// # Errors
    /// As [`Inverse::each`].
    pub fn collect(&self) -> Result<Vec<Sample>, Error> {
        let mut all = Vec::new();
        self.each(|sample| {
            all.push(sample);
            Ok(())
        })?;
        Ok(all)
    }

    fn compute(
        &self,
        mut receive: impl FnMut(Sample) -> Result<(), String>,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Verdict, Error> {
        let job = self.job()?;
        let names = self.robot.names();
        job.run_on(
            self.threads.get(),
            |sample| receive(Sample::new(Arc::clone(names), sample)),
            |_phase, _done, _of| !is_stopped(),
        )
        .map_err(explain::inverse)
    }
}

/// Iterator over the samples of inverse dynamics; see [`Inverse::samples`].
pub struct Samples {
    stream: Stream<Sample, Verdict>,
}

impl Samples {
    /// Results for the whole motion (mobility, uniqueness, passages of singular positions), once
    /// the iterator has returned all samples.
    pub fn verdict(&self) -> Option<&Verdict> {
        self.stream.result()
    }
}

impl Iterator for Samples {
    type Item = Result<Sample, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        self.stream.next()
    }
}

/// All results at one instant, by name. SI units, world axes.
#[derive(Clone, Debug)]
pub struct Sample {
    names: Arc<Names>,
    /// Time, s.
    pub time: f64,
    efforts: Vec<f64>,
    efforts_frictionless: Vec<f64>,
    effort_bounds: Vec<(f64, f64)>,
    motors: Vec<Motor>,
    reactions: Vec<Reaction>,
    frictions: Vec<JointFriction>,
    poses: Vec<BodyPose>,
    /// Residual of the power balance, W; zero up to rounding.
    pub power_residual: f64,
    /// Largest loop-closure error, m; angles times the characteristic length.
    pub closure_error: f64,
    /// Singularity index of actuation (type 2), dimensionless; zero at a singular position.
    pub actuation_distance: f64,
    /// Singularity index of the constraints, dimensionless; zero at a singular position.
    pub constraint_distance: f64,
}

/// Complete wrench that a joint's predecessor exerts on its successor: constraint, actuator and friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reaction {
    /// Force, N, world axes.
    pub force: [f64; 3],
    /// Moment about the joint's origin, N m, world axes.
    pub moment: [f64; 3],
    /// `true` if statics determines all components; otherwise they follow from the declared
    /// weighting of a statically indeterminate mechanism.
    pub determined: bool,
}

/// Friction in one friction interface of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointFriction {
    /// Sliding speed at the surface, m/s.
    pub speed: f64,
    /// Normal load, N.
    pub load: f64,
    /// Friction force at the surface, N.
    pub force: f64,
    /// Dissipated power, W.
    pub power: f64,
    /// `true` if statics determines the normal load.
    pub determined: bool,
}

/// Pose of a body in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPose {
    /// Position of the body's origin, m, world axes.
    pub position: [f64; 3],
    /// Rows of the rotation matrix, whose columns are the body's axes in the world.
    pub rotation: [[f64; 3]; 3],
}

impl BodyPose {
    /// Converts a pose relative to the reference point `origin` of the kernel to one in the world.
    pub(crate) fn new(pose: Pose<f64>, origin: Vec3<f64>) -> Self {
        Self {
            position: (pose.position + origin).to_array(),
            rotation: pose.rotation.transpose().columns.map(Vec3::to_array),
        }
    }
}

impl Sample {
    fn new(names: Arc<Names>, sample: &stiction_run::inverse::Sample<'_>) -> Self {
        let forces = sample.forces;
        let reactions = forces.reactions.iter().zip(sample.determined_reactions);
        let frictions = forces.interfaces.iter().zip(sample.determined_loads);
        let poses = sample.bodies.pose.iter().map(|pose| BodyPose::new(*pose, sample.origin));
        Self {
            names,
            time: sample.time,
            efforts: forces.efforts.clone(),
            efforts_frictionless: forces.efforts_frictionless.clone(),
            effort_bounds: forces.effort_bounds.clone(),
            motors: sample.motors.to_vec(),
            reactions: reactions
                .map(|((force, moment), determined)| Reaction {
                    force: force.to_array(),
                    moment: moment.to_array(),
                    determined: determined.iter().all(|component| *component),
                })
                .collect(),
            frictions: frictions
                .map(|(state, determined)| JointFriction {
                    speed: state.velocity,
                    load: state.load,
                    force: state.friction,
                    power: state.power,
                    determined: *determined,
                })
                .collect(),
            poses: poses.collect(),
            power_residual: forces.power.residual(),
            closure_error: sample.closure,
            actuation_distance: sample.distances.actuation,
            constraint_distance: sample.distances.constraint,
        }
    }

    /// Force (N) or torque (N m) of an actuator, friction included.
    ///
    /// # Errors
    /// There is no actuator of that name.
    pub fn effort(&self, actuator: &str) -> Result<f64, Error> {
        Ok(self.efforts[self.names.actuator(actuator)?])
    }

    /// Force (N) or torque (N m) of an actuator without friction.
    ///
    /// # Errors
    /// There is no actuator of that name.
    pub fn effort_frictionless(&self, actuator: &str) -> Result<f64, Error> {
        Ok(self.efforts_frictionless[self.names.actuator(actuator)?])
    }

    /// Least and greatest effort of an actuator that static friction permits at rest, N or N m; both are
    /// the effort itself while all joints slide.
    ///
    /// # Errors
    /// There is no actuator of that name.
    pub fn effort_bounds(&self, actuator: &str) -> Result<(f64, f64), Error> {
        Ok(self.effort_bounds[self.names.actuator(actuator)?])
    }

    /// Torque, speed and power of the motor of a drive train, and what it loses.
    ///
    /// # Errors
    /// There is no drive train of that name.
    pub fn motor(&self, name: &str) -> Result<&Motor, Error> {
        Ok(&self.motors[self.names.motor(name)?])
    }

    /// Efforts of all actuators, N or N m, in the order of [`Robot::actuators`].
    pub fn efforts(&self) -> &[f64] {
        &self.efforts
    }

    /// Reaction in a joint.
    ///
    /// # Errors
    /// There is no joint of that name.
    pub fn reaction(&self, joint: &str) -> Result<Reaction, Error> {
        Ok(self.reactions[self.names.joint(joint)?])
    }

    /// Friction in a friction interface: a joint's name, followed by that of the interface where the joint
    /// has several.
    ///
    /// # Errors
    /// There is no friction interface of that name.
    pub fn friction(&self, interface: &str) -> Result<JointFriction, Error> {
        Ok(self.frictions[self.names.interface(interface)?])
    }

    /// Pose of a body in the world.
    ///
    /// # Errors
    /// There is no body of that name.
    pub fn pose(&self, body: &str) -> Result<BodyPose, Error> {
        Ok(self.poses[self.names.body(body)?])
    }
}
