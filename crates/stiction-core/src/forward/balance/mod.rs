//! Equations of motion with constraints: accelerations and reactions for given joint wrenches.
//!
//! With the mass matrix `M` of the spanning tree, the bias `h` of inertia, gravity and loads, given
//! efforts `f`, and the constraints `J a = r`:
//!
//! ```text
//! M a + h = f + J^T l
//! ```
//!
//! The null space `Z` of `J` decouples the equations: accelerations follow from `J` and `Z^T M Z`,
//! then the multipliers `l` from the independent rows. `M` may be singular, but `Z^T M Z` must not
//! be: each motion that the constraints allow must have inertia, except the passive spin of a
//! single body, see [`passive_spins`]. Dependent rows are redundant constraints. They do not affect
//! the accelerations, and [`redundancy`] determines their reactions by a declared rule.
//!
//! Equations (D1) and (D2) of the book's theory.

mod cholesky;
mod passive_spins;
mod redundancy;
mod respond;
mod response;
mod sparse;
mod stages;

pub(super) use cholesky::{factor, solve_factored};
pub(super) use redundancy::reactions;
pub(super) use respond::Workspace;
pub(super) use response::Response;

use super::Forward;
use super::constraint_jacobian::ConstraintRows;
use super::constraint_rank::Contradiction;
use super::data::Data;
use crate::linalg::RowSpace;
use passive_spins::{fastest_body, is_passive_spin};
use redundancy::RedundancyResolution;
use sparse::SparseBalance;

/// A constraint row counts as linearly dependent if its component orthogonal to the span of the
/// other rows is below this fraction of its norm. This fraction equals the rank threshold in
/// `statics/rank.rs`.
pub(super) const DEPENDENT: f64 = 1e-10;

/// A dependent row contradicts the other rows if its relative residual exceeds this value. Smaller
/// residuals are due to round-off and to rates that slightly violate the constraints.
const CONTRADICTS: f64 = 1e-6;

/// Motion without inertia, identified by the body that is fastest in this motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Massless {
    pub(super) body: usize,
}

/// Factorised equations of motion at one configuration, for a given set of constraints.
#[derive(Clone, Debug, Default)]
pub(super) struct Balance {
    pub(super) rows: ConstraintRows,
    /// Sparse factorisation; `None` if the model uses only dense linear algebra.
    sparse: Option<Box<SparseBalance>>,
    /// True if the equations are always factorised densely, for example in a search for stick-slip
    /// modes.
    pub(super) stays_dense: bool,
    /// True if the sparse factorisation is valid at the present configuration. The dense quantities
    /// below then belong to an earlier configuration and must not be used.
    is_sparse: bool,
    /// Mass matrix of the spanning tree, row-major.
    mass: Vec<f64>,
    space: RowSpace,
    scaled: Vec<f64>,
    /// Basis of the null space of the constraint rows: accelerations that the constraints allow,
    /// orthonormal in scaled DOFs.
    basis: Vec<f64>,
    /// Momentum of each basis vector of the null space: the columns of `M Z`.
    momenta: Vec<f64>,
    /// Lower triangle of the Cholesky factor of `Z^T M Z`, row-major.
    factor: Vec<f64>,
    /// Rates of the spanning tree in each passive spin without inertia. The magnitude of the rates
    /// is arbitrary.
    passive_spins: Vec<Vec<f64>>,
    /// Rule that distributes the reactions of redundant constraints.
    pub(super) redundancy: RedundancyResolution,
}

impl Balance {
    /// Factorises the equations of motion densely.
    ///
    /// # Errors
    /// Returns a motion without inertia, unless the motion is the passive spin of a single body.
    pub(super) fn new(
        model: &Forward,
        data: &Data,
        rows: ConstraintRows,
    ) -> Result<Self, Massless> {
        let mut balance = Self { rows, ..Self::default() };
        balance.update_densely(model, data, &mut Workspace::default())?;
        Ok(balance)
    }

    /// Factorises the equations of motion again for the constraint rows in `rows`, sparsely if
    /// possible and densely otherwise, reusing the buffers. The constraint Jacobian need not be
    /// computed beforehand.
    ///
    /// # Errors
    /// See [`Self::new`].
    pub(super) fn update(
        &mut self,
        model: &Forward,
        data: &Data,
        workspace: &mut Workspace,
    ) -> Result<(), Massless> {
        if self.sparse.is_none() && !self.stays_dense {
            self.sparse = SparseBalance::new(model).map(Box::new);
        }
        let Self { rows, sparse, .. } = self;
        if let Some(sparse) = sparse
            && sparse.update(model, data, rows)
        {
            self.is_sparse = true;
            self.passive_spins.clear();
            self.redundancy = RedundancyResolution::default();
            return Ok(());
        }
        self.rows.fill_matrix(&model.topology, &model.parameters, &data.bodies);
        self.update_densely(model, data, workspace)
    }

    /// Repeats the dense factorisation for the present constraint rows, reusing the buffers. The
    /// constraint Jacobian of these rows must have been computed beforehand.
    ///
    /// # Errors
    /// See [`Self::new`].
    pub(super) fn update_densely(
        &mut self,
        model: &Forward,
        data: &Data,
        workspace: &mut Workspace,
    ) -> Result<(), Massless> {
        let n = model.topology.dofs();
        self.is_sparse = false;
        let Self { rows, mass, space, scaled, basis, momenta, factor, passive_spins, .. } = self;
        data.masses.matrix_into(&model.topology, &data.bodies, mass);
        rows.scale_into(&model.columns, scaled);
        space.decompose(scaled, rows.rows.len(), n, DEPENDENT);
        space.null_space_into(basis);
        for vector in basis.chunks_exact_mut(n.max(1)) {
            vector.iter_mut().zip(&model.columns).for_each(|(x, c)| *x *= c);
        }
        passive_spins.clear();
        let may_lack_inertia = |rates: &[f64]| is_passive_spin(model, data, rates);
        let results = (passive_spins, momenta, factor);
        cholesky::factor_into(mass, basis, n, &may_lack_inertia, results)
            .map_err(|rates| Massless { body: fastest_body(model, data, &rates).0 })?;
        self.check_passive_spins(model, data, None)?;
        let Self { rows, space, redundancy, .. } = self;
        if rows.rows.len() == space.rank() {
            if !redundancy.self_stresses.is_empty() {
                *redundancy = RedundancyResolution::default();
            }
            return Ok(());
        }
        let dependencies = self.space.dependencies();
        let mut self_stresses = Vec::with_capacity(dependencies.len());
        for mut multipliers in dependencies {
            multipliers.iter_mut().zip(&self.rows.rows).for_each(|(m, row)| *m *= row.scale);
            self_stresses.push(self.self_stress(model, data, multipliers, workspace));
        }
        self.redundancy = RedundancyResolution::new(model, data, &self.rows, self_stresses);
        Ok(())
    }

    /// Replaces a sparse factorisation by the dense one, reusing the buffers. Does nothing if the
    /// factorisation is already dense.
    ///
    /// # Errors
    /// See [`Self::new`].
    pub(super) fn make_dense(&mut self, model: &Forward, data: &Data) -> Result<(), Massless> {
        if self.is_sparse {
            self.rows.fill_matrix(&model.topology, &model.parameters, &data.bodies);
            self.update_densely(model, data, &mut Workspace::default())?;
        }
        Ok(())
    }

    /// Returns the sparse factorisation if it is valid at the present configuration.
    fn sparse(&self) -> Option<&SparseBalance> {
        self.sparse.as_deref().filter(|_| self.is_sparse)
    }

    /// Returns true if the equations of motion are factorised sparsely.
    pub(super) fn is_sparse(&self) -> bool {
        self.is_sparse
    }

    /// Returns a basis of the tree rates that the constraints allow, one vector after the other.
    /// Requires a dense factorisation.
    pub(super) fn null_space(&self) -> &[f64] {
        &self.basis
    }

    /// Returns the mobility: the number of DOFs that the constraints leave. `n` is the number of
    /// DOFs of the spanning tree.
    pub(super) fn mobility(&self, n: usize) -> usize {
        self.sparse().map_or_else(|| n - self.space.rank(), SparseBalance::mobility)
    }

    /// Returns the singularity index of the constraint rows, between zero and one.
    pub(super) fn distance(&self) -> f64 {
        self.sparse().map_or_else(|| self.space.least_part(), SparseBalance::distance)
    }

    /// Returns the number of redundant constraints.
    pub(super) fn redundant(&self) -> usize {
        let dense = || self.redundancy.self_stresses.len();
        self.sparse().map_or_else(dense, SparseBalance::redundant)
    }

    /// Returns true if any constraint is redundant.
    pub(super) fn is_redundant(&self) -> bool {
        self.redundant() > 0
    }

    /// Finds a constraint row that no accelerations satisfy: a dependent row whose right-hand side
    /// contradicts the other rows. Requires a dense factorisation.
    pub(super) fn contradiction(&self, model: &Forward, data: &Data) -> Option<Contradiction> {
        if self.space.rank() == self.rows.rows.len() {
            return None;
        }
        let right: Vec<f64> = self.rows.rows.iter().map(|r| r.right * r.scale).collect();
        let mut nearest = self.space.shortest(&right);
        nearest.iter_mut().zip(&model.columns).for_each(|(a, c)| *a *= c);
        contradiction_of((model, data), &self.rows, &nearest)
    }
}

/// Finds the constraint row with the largest residual if the least-squares accelerations `nearest`
/// do not satisfy all rows.
pub(super) fn contradiction_of(
    (model, data): (&Forward, &Data),
    rows: &ConstraintRows,
    nearest: &[f64],
) -> Option<Contradiction> {
    let of = (&*model.topology, &model.parameters);
    let residuals: Vec<f64> = rows
        .rows
        .iter()
        .enumerate()
        .map(|(k, row)| row.scale * (rows.product(of, &data.bodies, k, nearest) - row.right))
        .collect();
    // Right-hand sides contain squares of rates. If these squares cancel, the right-hand sides are
    // round-off relative to the largest squared rate.
    let fastest = model.fastest(data);
    let rights = rows.rows.iter().map(|row| (row.scale * row.right).abs());
    let size = rights.fold(fastest * fastest, f64::max);
    let row =
        (0..residuals.len()).max_by(|a, b| residuals[*a].abs().total_cmp(&residuals[*b].abs()))?;
    let (by, scale) = (residuals[row].abs(), rows.rows[row].scale);
    let translates = scale != 1.0;
    (by > CONTRADICTS * size).then_some(Contradiction { row, by: by / scale, translates })
}

/// Fills a list with `count` copies of a value, reusing the buffer.
fn fill<T: Clone>(list: &mut Vec<T>, count: usize, with: T) {
    list.clear();
    list.resize(count, with);
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
