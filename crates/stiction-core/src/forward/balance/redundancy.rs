//! Distribution of the reactions of redundant constraints.
//!
//! Four criteria apply in sequence, each to the solutions that the previous criteria leave
//! undetermined:
//!
//! 1. least efforts of actuators with prescribed motion;
//! 2. least static frictions relative to the friction limits, or least deviations of the static
//!    frictions from reference values that satisfy all limits; close to singular positions
//!    reactions are terms of this sum, too, see [`Forward::limit_preload`];
//! 3. least elastic energy of declared compliances;
//! 4. least reactions, see [`crate::dynamics::Weighting`].
//!
//! Each criterion minimises a sum of squares, so reactions are linear in the loads.

use super::response::Response;
use crate::forward::Forward;
use crate::forward::constraint_jacobian::ConstraintRows;
use crate::forward::data::{Data, FrictionDistribution};
use crate::kinematics::Bodies;
use crate::linalg::Svd;
use crate::spatial::{Vec3, Wrench};
use crate::statics::DETERMINED;
use nalgebra::{DMatrix, DVector};

/// Quantity whose sum of squares a stage minimises.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Criterion {
    Efforts,
    Frictions,
    Energy,
    Reactions,
}

/// Stage of the distribution: a criterion, and the self-stresses that it determines.
#[derive(Clone, Debug)]
struct Stage {
    criterion: Criterion,
    /// Self-stresses that the earlier criteria leave undetermined, one per column, as coefficients
    /// of the basis `self_stresses`.
    open: DMatrix<f64>,
    response: Svd,
    rank: usize,
}

/// Rule that distributes the reactions of redundant constraints at one configuration.
#[derive(Clone, Debug, Default)]
pub(in crate::forward) struct RedundancyResolution {
    /// Basis of the self-stress states: reactions in equilibrium without external loads.
    pub(in crate::forward) self_stresses: Vec<Response>,
    stages: Vec<Stage>,
}

impl RedundancyResolution {
    /// Creates the rule from a basis of the self-stresses. An empty basis means that no constraint
    /// is redundant.
    pub(in crate::forward) fn new(
        model: &Forward,
        data: &Data,
        rows: &ConstraintRows,
        self_stresses: Vec<Response>,
    ) -> Self {
        let mut stages = Vec::new();
        if self_stresses.is_empty() {
            return Self { self_stresses, stages };
        }
        let multipliers = self_stresses.iter().flat_map(|stress| &stress.multipliers);
        let size = multipliers.fold(0.0_f64, |m, x| m.max(x.abs()));
        let mut open = DMatrix::identity(self_stresses.len(), self_stresses.len());
        use Criterion::{Efforts, Energy, Frictions, Reactions};
        for criterion in [Efforts, Frictions, Energy, Reactions] {
            let applies = match criterion {
                Efforts => rows.rows.iter().any(|row| row.actuated),
                Frictions => rows.rows.iter().any(|row| row.friction_scale.is_some()),
                Energy => model.parameters.compliance.is_some(),
                Reactions => true,
            };
            if !applies {
                continue;
            }
            if open.ncols() == 0 {
                break;
            }
            let columns: Vec<_> = self_stresses
                .iter()
                .map(|stress| {
                    let mut numbers = Vec::new();
                    weigh((model, data), rows, criterion, stress, |number| numbers.push(number));
                    DVector::from_vec(numbers)
                })
                .collect();
            let matrix = DMatrix::from_columns(&columns) * &open;
            let response = Svd::new(&matrix);
            // If the self-stresses do not change the minimised quantity, the entries of the matrix
            // are round-off.
            let rank =
                if matrix.amax() > DETERMINED * size { response.rank(DETERMINED) } else { 0 };
            let rest = response.null_space(rank);
            let next = if rest.is_empty() {
                DMatrix::zeros(self_stresses.len(), 0)
            } else {
                &open * DMatrix::from_columns(&rest)
            };
            stages.push(Stage {
                criterion,
                open: std::mem::replace(&mut open, next),
                response,
                rank,
            });
        }
        Self { self_stresses, stages }
    }

    /// Returns the number of efforts of prescribed actuators that only the minimum-effort criterion
    /// determines, because more DOFs are prescribed than the mechanism has.
    pub(in crate::forward) fn open_efforts(&self) -> usize {
        let stage = self.stages.iter().find(|stage| stage.criterion == Criterion::Efforts);
        stage.map_or(0, |stage| stage.rank)
    }

    /// Adds self-stresses to a response so that the sum satisfies all criteria. If `whole` (see
    /// [`Balance::respond`](super::Balance::respond)), static frictions deviate as little as
    /// possible from their reference values; otherwise they deviate as little as possible from
    /// zero.
    pub(in crate::forward) fn apply(
        &self,
        (model, data): (&Forward, &Data),
        rows: &ConstraintRows,
        whole: bool,
        workspace: &mut Workspace,
        response: &mut Response,
    ) {
        let Workspace { now, along, amounts } = workspace;
        for Stage { criterion, open, response: answer, rank } in &self.stages {
            now.clear();
            weigh((model, data), rows, *criterion, response, |number| now.push(number));
            if whole && *criterion == Criterion::Frictions {
                let FrictionDistribution { reaction_weight, reference_reactions, .. } =
                    &data.distribution;
                let frictions = rows
                    .rows
                    .iter()
                    .filter_map(|row| row.friction_scale.map(|s| row.reference / s));
                let references =
                    frictions.chain(reference_reactions.iter().map(|r| reaction_weight * r));
                now.iter_mut().zip(references).for_each(|(now, reference)| *now -= reference);
            }
            // Least-squares solution from the singular value decomposition.
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
            for (stress, amount) in self.self_stresses.iter().zip(&*amounts) {
                response.add(stress, *amount);
            }
        }
    }
}

/// Buffers of [`RedundancyResolution::apply`].
#[derive(Clone, Debug, Default)]
pub(in crate::forward) struct Workspace {
    now: Vec<f64>,
    along: Vec<f64>,
    amounts: Vec<f64>,
}

/// Calls `put` with the reactions of all joints: forces, N, and moments divided by the
/// characteristic length, N, in the axes of the joint, six numbers for each joint.
pub(in crate::forward) fn reactions(
    (model, bodies): (&Forward, &Bodies<f64>),
    wrenches: &[Wrench<f64>],
    mut put: impl FnMut(f64),
) {
    for (joint, vectors) in joint_vectors((model, bodies), wrenches) {
        let rotation = &bodies.frame_j[joint].rotation;
        for vector in vectors {
            rotation.transpose_mul(vector).to_array().into_iter().for_each(&mut put);
        }
    }
}

/// Returns the index of each joint with its force, N, and its moment about the joint divided by the
/// characteristic length, N, in world axes.
fn joint_vectors<'a>(
    (model, bodies): (&'a Forward, &'a Bodies<f64>),
    wrenches: &'a [Wrench<f64>],
) -> impl Iterator<Item = (usize, [Vec3<f64>; 2])> {
    // The joints of added motor shafts are not part of the machine and are excluded.
    let own = model.mechanism.joints().len();
    wrenches.iter().take(own).enumerate().map(|(joint, wrench)| {
        let moment = wrench.moment_about(bodies.frame_j[joint].position);
        (joint, [wrench.force, moment * (1.0 / model.parameters.length)])
    })
}

/// Calls `put` with each number whose square is a term of the sum that a criterion minimises.
fn weigh(
    (model, data): (&Forward, &Data),
    rows: &ConstraintRows,
    criterion: Criterion,
    response: &Response,
    mut put: impl FnMut(f64),
) {
    let length = model.parameters.length;
    let multipliers = rows.rows.iter().zip(&response.multipliers);
    match criterion {
        Criterion::Frictions => {
            multipliers.filter_map(|(row, m)| row.friction_scale.map(|s| m / s)).for_each(&mut put);
            let weight = data.distribution.reaction_weight;
            if weight > 0.0 {
                let each = |number| put(weight * number);
                reactions((model, &data.bodies), &response.wrenches, each);
            }
        }
        Criterion::Efforts => {
            // Torques are divided by the characteristic length.
            let weight = |is_length: bool| if is_length { 1.0 } else { 1.0 / length };
            let actuated = multipliers.filter(|(row, _)| row.actuated);
            actuated.map(|(row, m)| m * weight(row.scale != 1.0)).for_each(put);
        }
        Criterion::Energy | Criterion::Reactions => {
            for (joint, [force, moment]) in joint_vectors((model, &data.bodies), &response.wrenches)
            {
                let rotation = &data.bodies.frame_j[joint].rotation;
                let weights = match (&model.parameters.compliance, criterion) {
                    (Some(all), Criterion::Energy) => all[joint],
                    _ => {
                        force.to_array().into_iter().chain(moment.to_array()).for_each(&mut put);
                        continue;
                    }
                };
                let square = length * length;
                for (v, w) in [(force, weights.force), (moment, weights.moment * square)] {
                    let own = rotation.transpose_mul(v).to_array();
                    own.iter().zip(w.to_array()).for_each(|(v, w)| put(v * w.sqrt()));
                }
            }
        }
    }
}
