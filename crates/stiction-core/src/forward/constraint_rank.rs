//! Rank and contradictions of the constraint rows, without the equations of motion.
//!
//! Large mechanisms are decomposed sparsely. The dense factorisation of [`super::balance`] replaces
//! the sparse decomposition if its pivots do not show the rank clearly.

use super::Forward;
use super::affine_friction::InterfaceMode;
use super::balance::contradiction_of;
use super::constraint_jacobian::{ConstrainedDof, ConstraintRows};
use super::data::{Data, FrictionDistribution};
use super::sparse::rows::SparseRows;

/// Constraint row that no accelerations satisfy.
pub(super) struct Contradiction {
    /// Index of the row.
    pub(super) row: usize,
    /// Residual of the row for the least-squares accelerations, m/s^2 or rad/s^2.
    pub(super) by: f64,
    /// True if the row constrains a translation.
    pub(super) translates: bool,
}

impl Forward {
    /// Returns the mobility in the given modes and the number of redundant constraints. Returns
    /// `None` if a body can move without inertia.
    pub(super) fn mobility(&self, data: &Data, modes: &[InterfaceMode]) -> Option<(usize, usize)> {
        let n = self.topology.dofs();
        if let Some((rows, sparse)) = self.sparse_rows(data, modes) {
            return Some((n - sparse.rank(), rows.rows.len() - sparse.rank()));
        }
        let balance = self.balance(data, modes).ok()?;
        Some((balance.mobility(n), balance.redundant()))
    }

    /// Finds a constraint row of loops, gearings or prescribed motions that no accelerations
    /// satisfy. Friction is ignored.
    pub(super) fn contradiction(&self, data: &Data) -> Option<Contradiction> {
        if let Some((rows, mut sparse)) = self.sparse_rows(data, &[]) {
            if sparse.rank() == rows.rows.len() {
                return None;
            }
            let rights: Vec<f64> = rows.rows.iter().map(|row| row.right).collect();
            let mut nearest = Vec::new();
            sparse.shortest(&self.columns, &rights, &mut nearest);
            return contradiction_of((self, data), &rows, &nearest);
        }
        // The solver reports motions without inertia later.
        self.balance(data, &[]).ok()?.contradiction(self, data)
    }

    /// Decomposes the constraint rows in the given modes sparsely. Returns `None` if the dense
    /// decomposition must be used.
    fn sparse_rows(
        &self,
        data: &Data,
        modes: &[InterfaceMode],
    ) -> Option<(ConstraintRows, SparseRows)> {
        let mut sparse = SparseRows::new(self)?;
        let (mut rows, mut constrained) = (ConstraintRows::default(), Vec::<ConstrainedDof>::new());
        let even = FrictionDistribution::default();
        self.constrain(&data.targets, modes, &even, &mut constrained, &mut Vec::new());
        rows.update_rows(&self.topology, &self.parameters, &data.bodies, &constrained);
        sparse.decompose(self, &data.bodies, &rows, &[]).then_some((rows, sparse))
    }
}
