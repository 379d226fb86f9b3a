//! Who bears what where more constraints hold than are needed: the declared rule.
//!
//! First the least drives (among those that are prescribed), then the least frictions that hold, each in
//! units of what it can bear, or the least changes of shares that are known to be within all limits; then the least reactions by the
//! declared compliances, then by the default: see [`crate::dynamics::Weighting`]. All of it is linear in what
//! acts.

use super::response::Response;
use super::scene::Scene;
use crate::forward::constraint_jacobian::Rows;
use crate::linalg::Svd;
use crate::statics::DETERMINED;
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
pub(in crate::forward) struct Spread {
    /// Ways in which joints load each other and nothing else.
    pub(in crate::forward) stresses: Vec<Response>,
    stages: Vec<Stage>,
}

impl Spread {
    pub(in crate::forward) fn new(scene: &Scene<'_>, rows: &Rows, stresses: Vec<Response>) -> Self {
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
    pub(in crate::forward) fn open_drives(&self) -> usize {
        let stage = self.stages.iter().find(|stage| stage.measure == Measure::Drives);
        stage.map_or(0, |stage| stage.rank)
    }

    /// Moves a response to the least one.
    pub(in crate::forward) fn apply(
        &self,
        scene: &Scene<'_>,
        rows: &Rows,
        whole: bool,
        room: &mut Room,
        response: &mut Response,
    ) {
        let Room { now, along, amounts } = room;
        for Stage { measure, open, response: answer, rank } in &self.stages {
            now.clear();
            weigh(scene, rows, *measure, response, |number| now.push(number));
            if whole && *measure == Measure::Grips {
                let held = rows.rows.iter().filter_map(|row| row.grip.map(|g| row.share / g));
                now.iter_mut().zip(held).for_each(|(now, share)| *now -= share);
            }
            // Least squares by the singular vectors.
            along.clear();
            along.resize(answer.v.nrows(), 0.0);
            for k in 0..*rank {
                let own = answer.u.column(k);
                let sum: f64 = own.iter().zip(&*now).map(|(u, x)| u * x).sum();
                let amount = sum / answer.singular_values[k];
                along.iter_mut().zip(answer.v.column(k).iter()).for_each(|(x, v)| *x += amount * v);
            }
            amounts.clear();
            amounts.resize(open.nrows(), 0.0);
            for (column, x) in open.column_iter().zip(&*along) {
                amounts.iter_mut().zip(column.iter()).for_each(|(a, o)| *a -= o * x);
            }
            for (stress, amount) in self.stresses.iter().zip(&*amounts) {
                response.add(stress, *amount);
            }
        }
    }
}

/// Room for applying the rule.
#[derive(Clone, Debug, Default)]
pub(in crate::forward) struct Room {
    now: Vec<f64>,
    along: Vec<f64>,
    amounts: Vec<f64>,
}

fn weighed(scene: &Scene<'_>, rows: &Rows, measure: Measure, response: &Response) -> DVector<f64> {
    let mut numbers = Vec::new();
    weigh(scene, rows, measure, response, |number| numbers.push(number));
    DVector::from_vec(numbers)
}

/// All reactions as numbers whose sum of squares is least.
fn weigh(
    scene: &Scene<'_>,
    rows: &Rows,
    measure: Measure,
    response: &Response,
    mut put: impl FnMut(f64),
) {
    let length = scene.parameters.length;
    let multipliers = rows.rows.iter().zip(&response.multipliers);
    match measure {
        Measure::Grips => {
            multipliers.filter_map(|(row, m)| row.grip.map(|grip| m / grip)).for_each(put);
        }
        Measure::Drives => {
            // Rotary ones over the length: the inverse of what makes their rates comparable.
            let weight = |is_length: bool| if is_length { 1.0 } else { 1.0 / length };
            let drives = multipliers.filter(|(row, _)| row.drives);
            drives.map(|(row, m)| m * weight(row.scale != 1.0)).for_each(put);
        }
        Measure::Compliances | Measure::Default => {
            for (joint, wrench) in response.wrenches.iter().enumerate() {
                let j = &scene.bodies.frame_j[joint];
                let (force, moment) =
                    (wrench.force, wrench.moment_about(j.position) * (1.0 / length));
                let weights = match (&scene.parameters.compliance, measure) {
                    (Some(all), Measure::Compliances) => all[joint],
                    _ => {
                        force.to_array().into_iter().chain(moment.to_array()).for_each(&mut put);
                        continue;
                    }
                };
                let square = length * length;
                for (v, w) in [(force, weights.force), (moment, weights.moment * square)] {
                    let own = j.rotation.transpose_mul(v).to_array();
                    own.iter().zip(w.to_array()).for_each(|(v, w)| put(v * w.sqrt()));
                }
            }
        }
    }
}
