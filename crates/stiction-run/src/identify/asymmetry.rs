//! Asymmetry of an actuator: difference of its efforts between the two directions of motion.
//!
//! Weight, load-dependent friction and direction-dependent friction can require more effort in one
//! direction of motion than in the other.

use super::prepare::Prepared;
use nalgebra::{DMatrix, DVector};
use stiction_core::mechanism::Mechanism;
use stiction_identify::{Block, Kind, Options, Parameter, Problem, Rows};

/// Difference of the efforts of an actuator between its two directions of motion.
#[derive(Clone, Debug)]
pub struct Asymmetry {
    /// Name of the actuator.
    pub actuator: String,
    /// Asymmetry, N or N m: effort of forward motion plus effort of backward motion at the same speed. It is twice the
    /// part of the effort that keeps its sign when the direction changes.
    pub value: f64,
    /// Standard deviation of the asymmetry, N or N m.
    pub sigma: f64,
    /// Asymmetry of the efforts that the model without friction predicts, N or N m.
    pub frictionless: f64,
    /// Unit of the values, N or N m.
    pub unit: &'static str,
}

/// Smallest fraction of the regression rows of an actuator that must belong to motion in each
/// direction.
const BOTH: f64 = 0.05;

/// Computes the asymmetries of the measured efforts. The efforts of the model without friction,
/// minus their mean, are subtracted from the measured efforts. This removes the variation of weight
/// and inertia forces along the motion.
pub(super) fn of_efforts(
    all: &[Prepared],
    actuators: &[String],
    mechanism: &Mechanism,
) -> Vec<Asymmetry> {
    let joints = mechanism.joints();
    let units = mechanism.actuators().map(|(joint, dof)| {
        if joints[joint.0].joint_type.dofs()[dof].translates() { "N" } else { "N m" }
    });
    let each = actuators.iter().zip(units).enumerate().filter_map(|(channel, (actuator, unit))| {
        let fits = || all.iter().filter(|log| !log.predict);
        let count: usize = fits().map(|log| log.known[channel].len()).sum();
        let sum: f64 = fits().flat_map(|log| &log.known[channel]).sum();
        let mean = sum / count.max(1) as f64;
        let (value, sigma) = constant_part(all, channel, |log| {
            let rows = &log.block.channels[channel];
            let known = DVector::from_column_slice(&log.known[channel]);
            &rows.measured - known.add_scalar(-mean)
        })?;
        let (value, sigma) = (2.0 * value, 2.0 * sigma);
        Some(Asymmetry { actuator: actuator.clone(), value, sigma, frictionless: 2.0 * mean, unit })
    });
    each.collect()
}

/// Estimates the constant part of a signal in the regression rows of an actuator, and its standard
/// deviation. The fit also includes terms proportional to the direction and to the rate of motion.
/// `None` if the rows do not contain motion in both directions.
fn constant_part(
    all: &[Prepared],
    channel: usize,
    signal: impl Fn(&Prepared) -> DVector<f64>,
) -> Option<(f64, f64)> {
    let mut blocks = Vec::new();
    for log in all.iter().filter(|log| !log.predict) {
        let right = signal(log);
        let directions = &log.directions[channel];
        let matrix = DMatrix::from_fn(right.len(), 3, |row, column| match column {
            2 => 1.0,
            column => directions[row][column],
        });
        let steps = log.block.channels[channel].steps.clone();
        let rows = Rows { matrix, measured: right.clone(), right, instruments: None, steps };
        blocks.push(Block::new(vec![rows], log.block.independence));
    }
    let rows = || blocks.iter().map(|block| &block.channels[0]);
    let count = rows().map(Rows::len).sum::<usize>() as f64;
    let signs =
        || rows().flat_map(|rows| rows.matrix.column(0).iter().copied().collect::<Vec<_>>());
    let part =
        |is_in: fn(f64) -> bool| signs().filter(|s| is_in(*s)).count() as f64 / count.max(1.0);
    if part(|s| s > 0.5) < BOTH || part(|s| s < -0.5) < BOTH {
        return None;
    }
    let norm =
        |column: usize| rows().map(|r| r.matrix.column(column).norm_squared()).sum::<f64>().sqrt();
    let size = rows().map(|r| r.right.norm_squared()).sum::<f64>().sqrt();
    let parameters: Vec<Parameter> = (0..3)
        .map(|column| Parameter {
            name: String::new(),
            unit: "",
            // Parameters of this kind may have either sign.
            kind: Kind::Offset(column),
            prior: 0.0,
            scale: (size / norm(column)).max(1e-300),
        })
        .collect();
    let options = Options {
        strength: Some(1.0),
        prior_error: 1.0,
        radius: 1.0,
        held: vec![false; 3],
        tied: Vec::new(),
        bounds: Vec::new(),
        inequalities: Vec::new(),
    };
    let found = Problem { parameters: &parameters, blocks: &blocks, options: &options }.solve();
    Some((found.values[2], found.sigmas[2]))
}
