//! Sparse decomposition of the constraint rows. It determines the rank of the rows, and the
//! minimum-norm change of the tree coordinates that changes the constraints by given values.

use super::closures::{Buffers, Closures, Place};
use crate::forward::Forward;
use crate::forward::constraint_jacobian::ConstraintRows;
use crate::kinematics::Bodies;
use crate::linalg::{BLOCK, Part};
use crate::topology::Role;

/// Constraint rows at one configuration, decomposed in linear time for chains of loops.
#[derive(Clone, Debug)]
pub(in crate::forward) struct SparseRows {
    closures: Closures,
    /// Weight of each DOF of the spanning tree: one if the DOF may change, zero otherwise.
    weights: Vec<f64>,
    /// DOFs of the spanning tree that a row prescribes directly, each with the index of this row.
    prescribed: Vec<(usize, usize)>,
    right: Vec<Part>,
    buffers: Buffers,
}

impl SparseRows {
    /// Allocates the decomposition for a model. Returns `None` if the model is not suited to the
    /// sparse decomposition.
    pub(in crate::forward) fn new(model: &Forward) -> Option<Self> {
        Some(Self {
            closures: Closures::clone(model.projections.as_ref()?),
            weights: Vec::new(),
            prescribed: Vec::new(),
            right: Vec::new(),
            buffers: Buffers::default(),
        })
    }

    /// Decomposes the constraint rows, whose Jacobian need not be filled. `frozen` is true for each
    /// DOF that must not change; an empty list freezes no DOF. Returns false if the dense
    /// decomposition must be used instead.
    pub(in crate::forward) fn decompose(
        &mut self,
        model: &Forward,
        bodies: &Bodies<f64>,
        rows: &ConstraintRows,
        frozen: &[bool],
    ) -> bool {
        let topology = &model.topology;
        let Self { closures, weights, prescribed, .. } = self;
        if !closures.assign(topology, &rows.rows) {
            return false;
        }
        weights.clear();
        weights.resize(topology.dofs(), 1.0);
        weights.iter_mut().zip(frozen).filter(|(_, f)| **f).for_each(|(weight, _)| *weight = 0.0);
        prescribed.clear();
        for (index, row) in rows.rows.iter().enumerate() {
            if closures.places[index].is_some() {
                continue;
            }
            let (Role::Tree { node }, Some(dof)) = (topology.role[row.joint], row.dof) else {
                return false;
            };
            let tree_dof = topology.nodes[node].tree_dofs.start + dof;
            if weights[tree_dof] == 0.0 {
                return false;
            }
            weights[tree_dof] = 0.0;
            prescribed.push((tree_dof, index));
        }
        for (index, row) in rows.rows.iter().enumerate() {
            let Some(at) = closures.places[index] else { continue };
            let mut square = 0.0;
            row.each_entry((topology, &model.parameters), bodies, |d, entry| {
                let entry = entry * model.columns[d];
                closures.add(d, at, entry);
                square += weights[d] * entry * entry;
            });
            closures.set_size(at, row.scale * square.sqrt());
        }
        // Temporarily moves the row locations out of the system, because the function `units`
        // borrows them. The factorisation does not use them.
        let places = std::mem::take(&mut closures.places);
        let units = |put: &mut dyn FnMut(Place, Place, f64)| {
            // With these diagonal entries, the entries of the scaled matrix are of order one.
            for (row, place) in rows.rows.iter().zip(&places) {
                place.iter().for_each(|at| put(*at, *at, 1.0 / (row.scale * row.scale)));
            }
        };
        let is_factored = closures.factor(weights.iter().copied(), &units);
        closures.places = places;
        is_factored
    }

    /// Returns the number of independent rows.
    pub(in crate::forward) fn rank(&self) -> usize {
        self.closures.rank + self.prescribed.len()
    }

    /// Returns the singularity index of the constraint rows, between zero and one.
    pub(in crate::forward) fn distance(&self) -> f64 {
        self.closures.distance
    }

    /// Computes the change `step` of the tree DOFs, rad or m, for which the products of the
    /// constraint rows with the change equal `values`. Among all such changes, selects the one with
    /// the smallest norm, after division of each component by the scale of the DOF in `columns`.
    pub(in crate::forward) fn shortest(
        &mut self,
        columns: &[f64],
        values: &[f64],
        step: &mut Vec<f64>,
    ) {
        let Self { closures, weights, prescribed, right, buffers, .. } = self;
        step.clear();
        step.resize(columns.len(), 0.0);
        for &(tree_dof, row) in &*prescribed {
            step[tree_dof] = values[row];
        }
        right.clear();
        right.resize(closures.count(), [0.0; BLOCK]);
        for (value, place) in values.iter().zip(&closures.places) {
            if let Some(at) = place {
                right[at.block][at.row] = *value;
            }
        }
        closures.scaled(right);
        closures.add_product(|d| step[d] / columns[d], -1.0, right);
        closures.solve(right, buffers);
        for (d, (step, column)) in step.iter_mut().zip(columns).enumerate() {
            if weights[d] > 0.0 {
                *step = column * closures.along(d, right);
            }
        }
    }
}
