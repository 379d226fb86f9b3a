//! Who bears what where more constraints hold than are needed: the declared rule.
//!
//! First the least drives (among those that are prescribed), then the least frictions that hold, each in
//! units of what it can bear, or the least changes of shares that are known to be within all limits; then the least reactions by the
//! declared compliances, then by the default: see [`crate::dynamics::Weighting`]. All of it is linear in what
//! acts.

use super::balance::{Response, Scene};
use super::rows::Rows;
use crate::linalg::Svd;
use crate::mobility::DETERMINED;
use crate::spatial::Vec3;
use nalgebra::{DMatrix, DVector};

/// What is least.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Measure {
    Drives,
    /// Frictions that hold, in units of what they can bear.
    Grips,
    Compliances,
    Default,
}

/// One stage: what is open to it, and how what it measures answers.
#[derive(Clone, Debug)]
struct Stage {
    measure: Measure,
    /// Columns are amounts of the self-stresses.
    open: DMatrix<f64>,
    response: Svd,
    rank: usize,
}

/// The rule at one position.
#[derive(Clone, Debug, Default)]
pub(super) struct Spread {
    /// Ways in which joints load each other and nothing else.
    pub(super) stresses: Vec<Response>,
    stages: Vec<Stage>,
}

impl Spread {
    pub(super) fn new(scene: &Scene<'_>, rows: &Rows, stresses: Vec<Response>) -> Self {
        let mut stages = Vec::new();
        if stresses.is_empty() {
            return Self { stresses, stages };
        }
        let multipliers = stresses.iter().flat_map(|stress| &stress.multipliers);
        let size = multipliers.fold(0.0_f64, |m, x| m.max(x.abs()));
        let mut open = DMatrix::identity(stresses.len(), stresses.len());
        for measure in [Measure::Drives, Measure::Grips, Measure::Compliances, Measure::Default] {
            let absent = match measure {
                Measure::Drives => !rows.rows.iter().any(|row| row.drives),
                Measure::Grips => !rows.rows.iter().any(|row| row.grip.is_some()),
                _ => false,
            };
            if absent {
                continue;
            }
            if measure == Measure::Compliances && scene.parameters.compliance.is_none() {
                continue;
            }
            if open.ncols() == 0 {
                break;
            }
            let columns: Vec<_> =
                stresses.iter().map(|s| weighed(scene, rows, measure, s)).collect();
            let matrix = DMatrix::from_columns(&columns) * &open;
            let response = Svd::new(&matrix);
            // Where self-stresses do not load what is measured all of it is rounding.
            let rank =
                if matrix.amax() > DETERMINED * size { response.rank(DETERMINED) } else { 0 };
            let rest = response.null_space(rank);
            let next = if rest.is_empty() {
                DMatrix::zeros(stresses.len(), 0)
            } else {
                &open * DMatrix::from_columns(&rest)
            };
            stages.push(Stage {
                measure,
                open: std::mem::replace(&mut open, next),
                response,
                rank,
            });
        }
        Self { stresses, stages }
    }

    /// How many drives are open: more freedoms are prescribed than can move, and the rule decides who bears what.
    pub(super) fn open_drives(&self) -> usize {
        let stage = self.stages.iter().find(|stage| stage.measure == Measure::Drives);
        stage.map_or(0, |stage| stage.rank)
    }

    /// Moves a response to the least one.
    pub(super) fn apply(
        &self,
        scene: &Scene<'_>,
        rows: &Rows,
        whole: bool,
        response: &mut Response,
    ) {
        for stage in &self.stages {
            let mut now = weighed(scene, rows, stage.measure, response);
            if whole && stage.measure == Measure::Grips {
                let held = rows.rows.iter().filter_map(|row| row.grip.map(|g| row.share / g));
                now -= DVector::from_vec(held.collect());
            }
            let amounts = &stage.open * -stage.response.solve(&now, stage.rank);
            for (stress, amount) in self.stresses.iter().zip(amounts.iter()) {
                response.add(stress, *amount);
            }
        }
    }
}

/// All reactions as numbers whose sum of squares is least.
fn weighed(scene: &Scene<'_>, rows: &Rows, measure: Measure, response: &Response) -> DVector<f64> {
    let length = scene.parameters.length;
    if measure == Measure::Grips {
        let held = rows.rows.iter().zip(&response.multipliers);
        let numbers = held.filter_map(|(row, m)| row.grip.map(|grip| m / grip));
        return DVector::from_vec(numbers.collect());
    }
    if measure == Measure::Drives {
        // Rotary ones over the length: the inverse of what makes their rates comparable.
        let weight = |is_length: bool| if is_length { 1.0 } else { 1.0 / length };
        let drives = rows.rows.iter().zip(&response.multipliers).filter(|(row, _)| row.drives);
        let numbers: Vec<f64> = drives.map(|(row, m)| m * weight(row.scale != 1.0)).collect();
        return DVector::from_vec(numbers);
    }
    let numbers = response.wrenches.iter().enumerate().flat_map(|(joint, wrench)| {
        let j = &scene.bodies.frame_j[joint];
        let (force, moment) = (wrench.force, wrench.moment_about(j.position) * (1.0 / length));
        let weights = match (&scene.parameters.compliance, measure) {
            (Some(all), Measure::Compliances) => all[joint],
            _ => return [force.to_array(), moment.to_array()].concat(),
        };
        let root = |v: Vec3<f64>, w: Vec3<f64>| {
            let own = j.rotation.transpose_mul(v).to_array();
            own.iter().zip(w.to_array()).map(|(v, w)| v * w.sqrt()).collect::<Vec<f64>>()
        };
        let square = length * length;
        [root(force, weights.force), root(moment, weights.moment * square)].concat()
    });
    DVector::from_iterator(6 * response.wrenches.len(), numbers)
}
