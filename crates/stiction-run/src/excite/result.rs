//! The result of a design.

use super::limits::Used;
use super::precision::{Confounded, Expected};

/// Quality of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Natural logarithm of the determinant of the information matrix of the base parameters, in units of their
    /// sizes in the model.
    pub log_det: f64,
    /// Condition number of the weighted base regressor in these units.
    pub condition: f64,
}

/// Designed motion with its limits and the precision that its logs promise.
#[derive(Clone, Debug)]
pub struct Excitation {
    /// Names of the coordinates, with their units.
    pub coordinates: Vec<(String, &'static str)>,
    /// Position at which every period begins and ends at rest, rad or m.
    pub centre: Vec<f64>,
    /// Coefficients of sines and cosines of each coordinate, the first harmonic first.
    pub coefficients: Vec<[Vec<f64>; 2]>,
    /// Frequency of the first harmonic, Hz.
    pub frequency: f64,
    /// Number of periods.
    pub periods: usize,
    /// Duration, s.
    pub duration: f64,
    /// Time between samples, s.
    pub step: f64,
    /// Seed of the random start.
    pub seed: u64,
    /// Names of the loads with which the motion is repeated; empty for the robot alone.
    pub payloads: Vec<String>,
    /// Quality of the random start.
    pub start: Quality,
    /// Quality of the result.
    pub quality: Quality,
    /// Steps of the search.
    pub steps: usize,
    /// Parts of all limits that the motion uses, on the fine grid.
    pub limits: Vec<Used>,
    /// Standard deviation of the measured effort of each actuator: name, value, unit.
    pub noise: Vec<(String, f64, &'static str)>,
    /// True if the noise is an assumption.
    pub is_noise_assumed: bool,
    /// Expected standard deviations.
    pub expected: Vec<Expected>,
    /// Chosen parameters without effect on the efforts.
    pub without_effect: Vec<String>,
    /// Pairs of friction parameters of one bearing.
    pub pairs: Vec<Confounded>,
    /// Things to know before the motion is used.
    pub cautions: Vec<String>,
    /// Names of all other parameters, which identification shall hold.
    pub held: Vec<String>,
    /// True if all inertial parameters are among them.
    pub holds_inertia: bool,
    /// Names of all inertial parameters.
    pub(super) inertias: Vec<String>,
    /// True if efforts are measured at the motors.
    pub at_motors: bool,
    /// Reference: times, s, then positions, rates and accelerations of all coordinates.
    pub reference: Vec<(f64, [Vec<f64>; 3])>,
    /// The same of the actuators; `None` if these are the coordinates.
    pub actuators: Option<Actuators>,
}

/// Motion of the actuators at the times of the reference.
#[derive(Clone, Debug)]
pub struct Actuators {
    /// Names with their units.
    pub names: Vec<(String, &'static str)>,
    /// Positions, rates and accelerations at each time.
    pub rows: Vec<[Vec<f64>; 3]>,
}
