//! Matrix of the system with its scale factors, and its elimination order.

use super::Kinematics;
use crate::kinematics::model::KinematicModel;
use crate::kinematics::motion_constraints::MotionConstraints;
use crate::linalg::{Entry, Plan, RankDeficient, Scales, SparseMatrix};
use crate::topology::Topology;

/// Returns the scale factors of the columns: `length` (m) for translations and 1 for rotations. The
/// factors make rates of lengths and rates of angles comparable.
pub(crate) fn column_scales(topology: &Topology, length: f64) -> Vec<f64> {
    let translates = |tree_dof: &crate::topology::TreeDof| topology.tree_dof_translates(tree_dof);
    topology
        .tree_dofs
        .iter()
        .map(|tree_dof| if translates(tree_dof) { length } else { 1.0 })
        .collect()
}

impl Kinematics<f64> {
    /// Chooses independent rows and the elimination order of the system by the values of its
    /// entries. Call [`Self::linearise`] before.
    ///
    /// # Errors
    /// Returns [`RankDeficient`] if loops and prescribed coordinates leave some degrees of freedom
    /// of the spanning tree undetermined.
    pub(in crate::kinematics) fn plan(
        &self,
        topology: &Topology,
        motion_constraints: &MotionConstraints,
        length: f64,
    ) -> Result<Plan, RankDeficient> {
        let rows = motion_constraints.row_scales(length);
        let columns = column_scales(topology, length);
        let scales = Scales { rows: &rows, columns: &columns };
        let (count, dofs) = (motion_constraints.row_count(), topology.dofs());
        Plan::new(count, dofs, motion_constraints.entries(), &self.entries, scales)
    }

    /// Returns the smallest magnitude of the pivots of the last factorisation, with rows multiplied by
    /// `rows` and columns by [`column_scales`]. `None` if the factors belong to another
    /// configuration. Does not allocate.
    pub(in crate::kinematics) fn smallest_pivot(
        &self,
        model: &KinematicModel,
        rows: &[f64],
        length: f64,
    ) -> Option<f64> {
        let topology = model.topology();
        let translates = |column: usize| topology.tree_dof_translates(&topology.tree_dofs[column]);
        let scale = |row: usize, column| rows[row] * if translates(column) { length } else { 1.0 };
        self.is_factored.then(|| model.rates.smallest_pivot(&self.factors, scale))
    }

    /// Returns the matrix of the system, with rows and columns multiplied by the scale factors
    /// `rows` and `columns`. Call [`Self::linearise`] before.
    pub(in crate::kinematics) fn scaled_matrix(
        &self,
        motion_constraints: &MotionConstraints,
        rows: &[f64],
        columns: &[f64],
    ) -> SparseMatrix {
        let entries = motion_constraints.entries.iter().zip(&self.entries).map(|(entry, value)| {
            let &Entry { row, column, .. } = entry;
            (row, column, value * rows[row] * columns[column])
        });
        SparseMatrix::new((rows.len(), columns.len()), entries)
    }
}
