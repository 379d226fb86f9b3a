//! A model: a mechanism, its motions and its loads.

use crate::diagnostic::Diagnostics;
use crate::parameters::Parameters;
use crate::signal::Signal;
use crate::signal::samples::SampleTimes;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, LoadAxes};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodyId, JointId, Mechanism};
use stiction_core::spatial::{Pose, Vec3};

/// Contents of a model file: a mechanism, its motions and its loads.
#[derive(Clone, Debug)]
pub struct ModelFile {
    /// Name.
    pub name: String,
    /// One line that says what it is; empty where the file says nothing.
    pub title: String,
    /// Where its numbers come from; empty where the file says nothing.
    pub source: String,
    /// The mechanism.
    pub mechanism: Mechanism,
    /// First guesses of poses, in the ground's frame.
    pub initial_poses: Vec<(BodyId, Pose<f64>)>,
    /// Motions by name, in the order of the file.
    pub motions: Vec<(String, Motion)>,
    /// Loads by name, in the order of the file.
    pub loads: Vec<(String, LoadCase)>,
    /// The name of the motion that is meant when nothing is said.
    pub default_motion: Option<String>,
    /// The name of the load that is meant when nothing is said.
    pub default_load: Option<String>,
    /// How friction acts when nothing is said.
    pub default_friction: Option<FrictionMode>,
    /// The legs.
    pub legs: Vec<Leg>,
    /// What a colleague would point at. Warnings never change numbers.
    pub warnings: Diagnostics,
    pub(crate) parameters: Parameters,
}

impl From<Mechanism> for ModelFile {
    /// A mechanism without motions, loads or parameters.
    fn from(mechanism: Mechanism) -> Self {
        Self {
            name: mechanism.name().to_owned(),
            title: String::new(),
            source: String::new(),
            mechanism,
            initial_poses: Vec::new(),
            motions: Vec::new(),
            loads: Vec::new(),
            default_motion: None,
            default_load: None,
            default_friction: None,
            legs: Vec::new(),
            warnings: Diagnostics::new(),
            parameters: Parameters::default(),
        }
    }
}

/// One of the legs that a model's short form describes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Leg {
    /// Its name, which precedes those of its joints and bodies: `leg1` of `leg1.P`.
    pub name: String,
    /// Its joints, from its first body to its last.
    pub joints: Vec<JointId>,
    /// The bodies between them.
    pub bodies: Vec<BodyId>,
}

/// A prescribed motion.
#[derive(Clone, Debug)]
pub struct Motion {
    /// One line that says what it is; may be empty.
    pub title: String,
    /// First instant, s.
    pub start: f64,
    /// Length, s; zero for a single pose.
    pub duration: f64,
    /// Time between samples of the result, s, if the motion says so.
    pub step: Option<f64>,
    /// The instants of the samples from which it comes, s, strictly increasing.
    pub samples: Option<SampleTimes>,
    /// The prescribed coordinates, each with its course in rad or m.
    pub coordinates: Vec<(Coordinate, Signal)>,
    /// How the gaps between samples are filled, in words.
    pub interpolation: Option<String>,
}

impl Motion {
    /// What is prescribed at time `t` (s), in the order of the coordinates.
    pub fn at(&self, t: f64) -> impl Iterator<Item = Target<f64>> + '_ {
        self.coordinates.iter().map(move |(_, signal)| signal.at(t))
    }
}

/// Efforts that actuators exert.
#[derive(Clone, Debug, Default)]
pub struct Drives {
    /// One line that says what they are; may be empty.
    pub title: String,
    /// Efforts by the actuator's index ([`Mechanism::actuators`]), N or N m; the others exert none.
    pub efforts: Vec<(usize, Signal)>,
    /// The instants of the samples from which they come, s, strictly increasing.
    pub samples: Option<SampleTimes>,
    /// How the gaps between samples are filled, in words.
    pub interpolation: Option<String>,
}

/// How a controller computes efforts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlType {
    /// Proportional to errors of position and of rate.
    Pd,
    /// The efforts that inverse dynamics says for the wanted acceleration, corrected by the errors.
    ComputedTorque,
}

/// Where computed torque takes friction from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionFeed {
    /// It knows of no friction.
    Off,
    /// That of the motion that is wanted.
    Reference,
    /// That of the motion that is measured.
    Measured,
}

/// A controller that samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// One line that says what it is; may be empty.
    pub title: String,
    /// How efforts are computed.
    pub control: ControlType,
    /// Where friction comes from.
    pub friction: FrictionFeed,
    /// Time between samples, s.
    pub period: f64,
    /// Natural frequency of the closed loop without friction, rad/s.
    pub bandwidth: f64,
    /// Damping ratio of the same.
    pub damping: f64,
    /// Whether rates are differences of measured positions.
    pub differences: bool,
    /// For each actuator ([`Mechanism::actuators`]) what is its own.
    pub channels: Vec<Channel>,
    /// The actuators that are named, with something of their own.
    pub named: Vec<usize>,
}

/// What of a controller is an actuator's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Effort for an error of position, N/m or N m/rad, if it is given.
    pub proportional: Option<f64>,
    /// Effort for an error of the rate, N s/m or N m s/rad, if it is given.
    pub derivative: Option<f64>,
    /// Step of the measured position, m or rad; zero for none.
    pub resolution: f64,
    /// Greatest effort, N or N m; infinite for none.
    pub limit: f64,
}

/// Forces and moments from outside.
#[derive(Clone, Debug, Default)]
pub struct LoadCase {
    /// One line that says what it is; may be empty.
    pub title: String,
    /// The loads, at most one a body.
    pub wrenches: Vec<AppliedWrench>,
}

impl LoadCase {
    /// The loads at time `t` (s).
    pub fn at(&self, t: f64) -> impl Iterator<Item = AppliedLoad<f64>> + '_ {
        self.wrenches.iter().map(move |wrench| wrench.at(t))
    }
}

/// A force and a moment on a body that may change in time.
#[derive(Clone, Debug)]
pub struct AppliedWrench {
    /// The body.
    pub body: BodyId,
    /// Where the force acts, in the body's frame, m.
    pub point: Vec3<f64>,
    /// The axes of force and moment.
    pub axes: LoadAxes,
    /// Components of the force, N.
    pub force: [Signal; 3],
    /// Components of the moment about the point, N m.
    pub moment: [Signal; 3],
}

impl AppliedWrench {
    /// Force and moment at time `t` (s).
    pub fn at(&self, t: f64) -> AppliedLoad<f64> {
        let vector = |signals: &[Signal; 3]| {
            let [x, y, z] = signals.each_ref().map(|signal| signal.at(t).value);
            Vec3::new(x, y, z)
        };
        AppliedLoad {
            body: self.body,
            point: self.point,
            axes: self.axes,
            force: vector(&self.force),
            moment: vector(&self.moment),
        }
    }
}

impl ModelFile {
    /// The motion with this name.
    pub fn motion(&self, name: &str) -> Option<&Motion> {
        self.motions.iter().find(|(known, _)| known == name).map(|(_, motion)| motion)
    }

    /// The load with this name.
    pub fn load(&self, name: &str) -> Option<&LoadCase> {
        self.loads.iter().find(|(known, _)| known == name).map(|(_, load)| load)
    }

    /// The leg to which a joint belongs.
    pub fn leg_of_joint(&self, joint: JointId) -> Option<&Leg> {
        self.legs.iter().find(|leg| leg.joints.contains(&joint))
    }
}
