//! Inverse dynamics along a motion with access to results by name.

use crate::error::Error;
use crate::names::Names;
use crate::request::{Loaded, Request, Sampled};
use crate::robot::Robot;
use std::num::NonZeroUsize;
use std::sync::Arc;
use stiction_core::dynamics::FrictionMode;
use stiction_core::mechanism::Motor;
use stiction_core::spatial::{Pose, Vec3};
use stiction_run::inverse::{Phase, Sample as Record, Verdict};
use stiction_run::{Indices, Job, Sink, SinkError};

/// Request for inverse dynamics of a robot along a motion. Set the options, then call
/// [`samples`](Request::samples), [`each`](Request::each) or [`collect`](Request::collect).
///
/// By default, the request uses the default motion, load and friction of the model, and one thread.
pub type Inverse = Request<InverseDynamics>;

/// Options of inverse dynamics.
#[derive(Clone, Debug)]
pub struct InverseDynamics {
    friction: FrictionMode,
    friction_margin: bool,
    indices: Indices,
    threads: NonZeroUsize,
}

impl Loaded for InverseDynamics {}

impl Inverse {
    pub(crate) fn of(robot: &Robot) -> Self {
        let friction = robot.model().default_friction.unwrap_or_default();
        let threads = NonZeroUsize::MIN;
        Self::new(
            robot,
            InverseDynamics { friction, friction_margin: false, indices: Indices::All, threads },
        )
    }

    /// Sets the coupling of friction with the reactions that cause it: iterated to convergence,
    /// computed in one pass, or off.
    pub fn friction(mut self, friction: FrictionMode) -> Self {
        self.task.friction = friction;
        self
    }

    /// Sets the number of threads. The results are bitwise identical for any number.
    pub fn threads(mut self, threads: NonZeroUsize) -> Self {
        self.task.threads = threads;
        self
    }

    /// Requests the friction margin to jamming: the factor by which all friction coefficients can
    /// increase before friction locks the mechanism.
    pub fn friction_margin(mut self, ask: bool) -> Self {
        self.task.friction_margin = ask;
        self
    }

    /// Selects the samples at which the singularity indices are computed. Default: all samples.
    /// [`Indices::Least`] takes less time and is sufficient for the smallest indices of the motion:
    /// samples that cannot have the smallest index then have NaN.
    pub fn indices(mut self, at: Indices) -> Self {
        self.task.indices = at;
        self
    }

    /// Converts the request to a [`Job`], which the tables, plots and summaries of `stiction_run`
    /// require.
    ///
    /// # Errors
    /// The model has no default motion, and none was set.
    pub fn job(&self) -> Result<Job<'_>, Error> {
        let InverseDynamics { friction, friction_margin, indices, .. } = self.task;
        Ok(Job { friction_margin, indices, ..self.along(friction)? })
    }

    /// Computes all samples and passes them to a sink, such as the tables, plots and summaries of
    /// `stiction_run`. Reports progress: the phase, the number of samples done, and their total
    /// number; stops when `progress` returns `false`.
    ///
    /// # Errors
    /// The motion cannot be followed, there are no finite efforts, or the sink returned an error.
    pub fn record(
        &self,
        mut sink: impl Sink<Record>,
        progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Verdict, Error> {
        let job = self.job()?;
        Ok(job.run_on(self.task.threads.get(), |record| sink.add(record), progress)?)
    }
}

impl Sampled for InverseDynamics {
    type Sample = Sample;
    type Outcome = Verdict;

    fn complete(request: &Inverse) -> Result<Inverse, Error> {
        request.job()?;
        Ok(request.clone())
    }

    fn compute(
        request: &Inverse,
        receive: &mut dyn FnMut(Sample) -> Result<(), SinkError>,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Verdict, Error> {
        let names = request.robot.names();
        let verdict = request.job()?.run_on(
            request.task.threads.get(),
            |record| receive(Sample::new(Arc::clone(names), record)),
            |_phase, _done, _of| !is_stopped(),
        );
        Ok(verdict?)
    }
}

/// All results at one instant, by name, in SI units and along world axes.
#[derive(Clone, Debug)]
pub struct Sample {
    names: Arc<Names>,
    /// Time, s.
    pub time: f64,
    efforts: Vec<f64>,
    efforts_frictionless: Vec<f64>,
    effort_bounds: Vec<(f64, f64)>,
    motors: Vec<Motor>,
    gearings: Vec<f64>,
    reactions: Vec<Reaction>,
    frictions: Vec<JointFriction>,
    poses: Vec<BodyPose>,
    /// Residual of the power balance, W; zero up to rounding.
    pub power_residual: f64,
    /// Largest loop-closure error, m; angles are multiplied by the characteristic length.
    pub closure_error: f64,
    /// Singularity index of actuation (type 2), dimensionless; zero at a singular position.
    pub actuation_distance: f64,
    /// Singularity index of the constraints, dimensionless; zero at a singular position.
    pub constraint_distance: f64,
}

/// Total wrench that the predecessor of a joint exerts on the successor: the sum of the constraint,
/// actuator and friction wrenches.
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
    /// Converts a pose relative to the solver's reference point `origin` (in the world, m) to a
    /// pose in the world.
    pub(crate) fn new(pose: Pose<f64>, origin: Vec3<f64>) -> Self {
        Self {
            position: (pose.position + origin).to_array(),
            rotation: pose.rotation.transpose().columns.map(Vec3::to_array),
        }
    }
}

impl Sample {
    fn new(names: Arc<Names>, sample: &Record) -> Self {
        let forces = &sample.forces;
        let reactions = forces.reactions.iter().zip(&sample.determined_reactions);
        let frictions = forces.interfaces.iter().zip(&sample.determined_loads);
        let poses = sample.bodies.pose.iter().map(|pose| BodyPose::new(*pose, sample.origin));
        Self {
            names,
            time: sample.time,
            efforts: forces.efforts.clone(),
            efforts_frictionless: forces.efforts_frictionless.clone(),
            effort_bounds: forces.effort_bounds.clone(),
            motors: sample.motors.clone(),
            gearings: forces.gearings.clone(),
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
    /// No actuator has that name.
    pub fn effort(&self, actuator: &str) -> Result<f64, Error> {
        Ok(self.efforts[self.names.actuator(actuator)?])
    }

    /// Force (N) or torque (N m) of an actuator without friction.
    ///
    /// # Errors
    /// No actuator has that name.
    pub fn effort_frictionless(&self, actuator: &str) -> Result<f64, Error> {
        Ok(self.efforts_frictionless[self.names.actuator(actuator)?])
    }

    /// Smallest and largest effort of an actuator that static friction permits at rest, N or N m;
    /// while all joints slide, both equal the effort itself.
    ///
    /// # Errors
    /// No actuator has that name.
    pub fn effort_bounds(&self, actuator: &str) -> Result<(f64, f64), Error> {
        Ok(self.effort_bounds[self.names.actuator(actuator)?])
    }

    /// Torque, speed, power and losses of the motor of a drive train.
    ///
    /// # Errors
    /// No drive train has that name.
    pub fn motor(&self, name: &str) -> Result<&Motor, Error> {
        Ok(&self.motors[self.names.motor(name)?])
    }

    /// Efforts of all actuators, N or N m, in the order of [`Robot::actuators`].
    pub fn efforts(&self) -> &[f64] {
        &self.efforts
    }

    /// Effort of a rigid gearing, N m, or N if its equation is a sum of lengths. The gearing exerts, on each of its
    /// joints, this effort times the coefficient of the joint.
    ///
    /// # Errors
    /// No gearing has that name.
    pub fn gearing_effort(&self, gearing: &str) -> Result<f64, Error> {
        Ok(self.gearings[self.names.gearing(gearing)?])
    }

    /// Force and moment that the predecessor of a joint exerts on the successor.
    ///
    /// # Errors
    /// No joint has that name.
    pub fn reaction(&self, joint: &str) -> Result<Reaction, Error> {
        Ok(self.reactions[self.names.joint(joint)?])
    }

    /// Friction in the friction interface with the given name: the name of the joint, followed by
    /// that of the interface if the joint has several.
    ///
    /// # Errors
    /// No friction interface has that name.
    pub fn friction(&self, interface: &str) -> Result<JointFriction, Error> {
        Ok(self.frictions[self.names.interface(interface)?])
    }

    /// Pose of a body in the world.
    ///
    /// # Errors
    /// No body has that name.
    pub fn pose(&self, body: &str) -> Result<BodyPose, Error> {
        Ok(self.poses[self.names.body(body)?])
    }
}
