//! Results of inverse dynamics at one sample.

use super::efficiency::Backward;
use stiction_core::dynamics::{AppliedLoad, Contributions, Forces};
use stiction_core::kinematics::{Bodies, Target};
use stiction_core::mechanism::Motor;
use stiction_core::spatial::Vec3;
use stiction_core::statics::Distances;

/// Results of inverse dynamics at one sample.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Time of the sample, s.
    pub time: f64,
    /// Efforts, reactions, friction and powers at the sample.
    pub forces: Forces,
    /// Poses, twists and accelerations of all bodies, in world axes about the reference point.
    pub bodies: Bodies<f64>,
    /// Position of the reference point in the world, m.
    pub origin: Vec3<f64>,
    /// Coordinates, rates and accelerations of all scalar degrees of freedom of joints, in the order of the
    /// joints, m and rad; angles count full turns.
    pub joints: Vec<Target<f64>>,
    /// External loads on the bodies.
    pub loads: Vec<AppliedLoad<f64>>,
    /// Largest closure error of loops and gearings, m; errors of angles are multiplied by the characteristic length.
    pub closure: f64,
    /// Singularity indices; NaN at samples for which they are not requested, see [`Indices`](crate::Indices).
    pub distances: Distances,
    /// Flags for the reaction of each joint: true for each component that is statically
    /// determinate. The first three components are the force, the last three the moment.
    pub determined_reactions: Vec<[bool; 6]>,
    /// True for each gearing whose effort is statically determinate.
    pub determined_gearings: Vec<bool>,
    /// True for each friction interface whose normal load is statically determinate.
    pub determined_loads: Vec<bool>,
    /// True for each actuator whose effort is statically determinate.
    pub determined_drives: Vec<bool>,
    /// Upper bound of the coupling of friction and reactions, dimensionless; zero without friction.
    /// If the bound is below one, the solution is unique. `None` if the bound is unknown. With
    /// [`Indices::Least`](crate::Indices::Least), this value may be larger than with
    /// [`Indices::All`](crate::Indices::All), but does not exceed the greatest coupling of the
    /// motion.
    pub coupling: Option<f64>,
    /// Factor on all friction coefficients at which the mechanism jams: infinite if it does not
    /// jam, `None` if the factor was not requested or is unknown.
    pub friction_margin: Option<f64>,
    /// Contribution of each friction interface to the effort of each actuator.
    pub shares: Contributions<f64>,
    /// Result of back-driving each actuator by the load; empty without friction.
    pub backward: Vec<Backward>,
    /// State of motor and gear of each drive train, in the order of
    /// [`Mechanism::drive_trains`](stiction_core::mechanism::Mechanism::drive_trains).
    pub motors: Vec<Motor>,
}
