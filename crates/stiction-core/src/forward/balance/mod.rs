//! Accelerations and reactions together, for known efforts in the joints.
//!
//! With the tree's mass matrix `M`, what inertia and loads demand `h`, known efforts `f`, and the
//! conditions `J a = r`:
//!
//! ```text
//! M a + h = f + J^T l
//! ```
//!
//! The null space `Z` of `J` splits it: accelerations from `J` and `Z^T M Z`, then multipliers from
//! the independent rows. `M` need not be invertible, only `Z^T M Z`: what moves must weigh something.
//! Dependent rows are redundant constraints: the accelerations do not need them, and their reactions
//! follow from the declared rule ([`spread`]).
//!
//! Equations (D1) and (D2) of the book's theory.

mod cholesky;
mod idle;
mod redundancy;
mod respond;
mod response;
mod scene;

pub(super) use cholesky::{factor, solve_factored};
pub(super) use respond::{Four, Scratch};
pub(super) use response::Response;
pub(super) use scene::Scene;

use super::constraint_jacobian::Rows;
use crate::linalg::RowSpace;
use cholesky::factorise;
use idle::moving;
use redundancy::Spread;

/// Rows that add less than this, relative to the largest, depend on the others: the rule of
/// [`crate::statics::RANK_TOLERANCE`].
pub(super) const DEPENDENT: f64 = 1e-10;

/// Dependent rows that are missed by more than this part of the largest value contradict the others; less is
/// rounding, and what rates are off by.
const CONTRADICTS: f64 = 1e-6;

/// Something can move without inertia: the body that does so most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Massless {
    pub(super) body: usize,
}

/// The decomposed balance at one position under one set of conditions.
#[derive(Clone, Debug, Default)]
pub(super) struct Balance {
    pub(super) rows: Rows,
    space: RowSpace,
    scaled: Vec<f64>,
    /// Orthonormal vectors of scaled accelerations that no row resists, unscaled then.
    basis: Vec<f64>,
    /// The momentum of each of these.
    moved: Vec<f64>,
    /// The lower triangle of the Cholesky factor of `Z^T M Z`, row by row.
    factor: Vec<f64>,
    /// Spins of single bodies that have no inertia about that axis, as rates of the tree: they keep their rate.
    idle: Vec<Vec<f64>>,
    /// Who bears what where constraints are redundant.
    pub(super) spread: Spread,
}

impl Balance {
    pub(super) fn new(scene: &Scene<'_>, rows: Rows) -> Result<Self, Massless> {
        let mut balance = Self { rows, ..Self::default() };
        balance.update(scene, &mut Scratch::default())?;
        Ok(balance)
    }

    /// Decomposes anew for its rows, in the room that is there.
    pub(super) fn update(
        &mut self,
        scene: &Scene<'_>,
        scratch: &mut Scratch,
    ) -> Result<(), Massless> {
        let n = scene.topology.dofs();
        let Self { rows, space, scaled, basis, moved, factor, idle, .. } = self;
        scaled.clone_from(&rows.matrix);
        for (row, entries) in rows.rows.iter().zip(scaled.chunks_exact_mut(n.max(1))) {
            for (entry, column) in entries.iter_mut().zip(scene.columns) {
                *entry *= row.scale * column;
            }
        }
        space.decompose(scaled, rows.rows.len(), n, DEPENDENT);
        space.null_space_into(basis);
        for vector in basis.chunks_exact_mut(n.max(1)) {
            vector.iter_mut().zip(scene.columns).for_each(|(x, c)| *x *= c);
        }
        idle.clear();
        let may = |rates: &[f64]| moving(scene, rates).1;
        factorise(&scene.masses.matrix, basis, n, &may, (idle, moved, factor))
            .map_err(|rates| Massless { body: moving(scene, &rates).0 })?;
        self.pushed(scene, None)?;
        let Self { rows, space, spread, .. } = self;
        if rows.rows.len() == space.rank() {
            if !spread.stresses.is_empty() {
                *spread = Spread::default();
            }
            return Ok(());
        }
        let dependencies = self.space.dependencies();
        let mut stresses = Vec::with_capacity(dependencies.len());
        for mut multipliers in dependencies {
            multipliers.iter_mut().zip(&self.rows.rows).for_each(|(m, row)| *m *= row.scale);
            stresses.push(self.load(scene, multipliers, scratch));
        }
        self.spread = Spread::new(scene, &self.rows, stresses);
        Ok(())
    }

    /// How many freedoms are left.
    pub(super) fn mobility(&self, n: usize) -> usize {
        n - self.space.rank()
    }

    /// How far the conditions are from being dependent, between zero and one.
    pub(super) fn distance(&self) -> f64 {
        self.space.least_part()
    }

    /// The row that no acceleration satisfies, if there is one, and by how much the nearest misses it, m/s^2
    /// or rad/s^2: a dependent row whose value is not the one that the others give it.
    pub(super) fn contradiction(&self, scene: &Scene<'_>) -> Option<(usize, f64)> {
        let n = scene.topology.dofs();
        if self.space.rank() == self.rows.rows.len() {
            return None;
        }
        let right: Vec<f64> = self.rows.rows.iter().map(|r| r.right * r.scale).collect();
        let mut nearest = self.space.shortest(&right);
        nearest.iter_mut().zip(scene.columns).for_each(|(a, c)| *a *= c);
        let each = self.rows.rows.iter().zip(self.rows.matrix.chunks_exact(n.max(1)));
        let missed: Vec<f64> =
            each.map(|(row, entries)| row.scale * (dot(entries, &nearest) - row.right)).collect();
        // Where all values are rounding they are so of terms in the squares of rates.
        let fastest = scene.fastest();
        let size = right.iter().fold(fastest * fastest, |m, x| m.max(x.abs()));
        let worst =
            (0..missed.len()).max_by(|a, b| missed[*a].abs().total_cmp(&missed[*b].abs()))?;
        let by = missed[worst].abs();
        (by > CONTRADICTS * size).then(|| (worst, by / self.rows.rows[worst].scale))
    }
}

fn fill<T: Clone>(list: &mut Vec<T>, count: usize, with: T) {
    list.clear();
    list.resize(count, with);
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
