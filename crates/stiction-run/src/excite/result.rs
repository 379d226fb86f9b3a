//! Result of the design of a motion.

use super::limits::Used;
use super::precision::{Confounded, Expected};

/// Measures of how much information a motion contains about the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Natural logarithm of the determinant of the information matrix, for base parameters in units
    /// of their sizes in the model.
    pub log_det: f64,
    /// Condition number of the weighted base regressor, for base parameters in units of their sizes in the model.
    pub condition: f64,
}

/// Designed motion, its utilisation of the limits, and the expected precision of parameters
/// identified from its logs.
#[derive(Clone, Debug)]
pub struct Excitation {
    /// Names and units of the coordinates of the motion.
    pub coordinates: Vec<(String, &'static str)>,
    /// Position of each coordinate, rad or m, at which every period begins and ends at rest.
    pub centre: Vec<f64>,
    /// Coefficients of the sines and of the cosines of each coordinate, rad or m, beginning with
    /// the first harmonic.
    pub coefficients: Vec<[Vec<f64>; 2]>,
    /// Frequency of the first harmonic, Hz.
    pub frequency: f64,
    /// Number of periods of the motion.
    pub periods: usize,
    /// Duration of the motion, s.
    pub duration: f64,
    /// Time between samples of the reference motion, s.
    pub step: f64,
    /// Seed of the random motion from which the search starts.
    pub seed: u64,
    /// Names of the loads with which the motion is repeated; empty for the robot alone.
    pub payloads: Vec<String>,
    /// Information of the random motion from which the search starts.
    pub start: Quality,
    /// Information of the designed motion.
    pub quality: Quality,
    /// Number of steps of the search.
    pub steps: usize,
    /// Utilisation of all limits by the motion, evaluated on the fine time grid of the final check.
    pub limits: Vec<Used>,
    /// Standard deviation of the measurement noise of each actuator effort: name of the actuator,
    /// value, unit.
    pub noise: Vec<(String, f64, &'static str)>,
    /// True if the values in `noise` are assumed, false if the options set them.
    pub is_noise_assumed: bool,
    /// Expected standard deviations of the base parameters.
    pub expected: Vec<Expected>,
    /// Names of the chosen parameters that have no effect on the efforts.
    pub without_effect: Vec<String>,
    /// Pairs of friction parameters of the same bearing, with the correlation of their errors.
    pub pairs: Vec<Confounded>,
    /// Cautions that the user should read before using the motion.
    pub cautions: Vec<String>,
    /// Names of the parameters that were not chosen. The identification must hold them at their
    /// values in the model.
    pub held: Vec<String>,
    /// True if `held` contains all inertial parameters.
    pub holds_inertia: bool,
    /// Names of all inertial parameters.
    pub(super) inertias: Vec<String>,
    /// True if efforts are measured at the motors.
    pub at_motors: bool,
    /// Reference motion: times, s, each with positions, rates and accelerations of all coordinates.
    pub reference: Vec<(f64, [Vec<f64>; 3])>,
    /// Reference motion of the actuators; `None` if the coordinates are those of the actuators.
    pub actuators: Option<Actuators>,
}

/// Motion of the actuators at the times of the reference.
#[derive(Clone, Debug)]
pub struct Actuators {
    /// Names and units of the actuators' coordinates.
    pub names: Vec<(String, &'static str)>,
    /// Positions, rates and accelerations of the actuators at each time.
    pub rows: Vec<[Vec<f64>; 3]>,
}
