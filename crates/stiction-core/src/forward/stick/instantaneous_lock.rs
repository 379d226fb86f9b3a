//! Interfaces that cannot stick although their joint is instantaneously at rest, at a dead centre.
//!
//! At a dead centre the rate of a joint is zero for any motion of the mechanism, but an instant
//! later it is not. Sticking then contradicts the loop constraints: the row of the sticking
//! interface depends on the rows of the loops but requires a different right-hand side. For a
//! self-stress `y` of the rows, `y^T J = 0`, accelerations with `J a = r` exist only if `y^T r =
//! 0`. Otherwise a sticking interface `k` with a component in the self-stress must accelerate, by
//! `-y^T r / y_k`.

use crate::forward::Forward;
use crate::forward::constraint_jacobian::StickingDof;
use crate::forward::data::Data;
use crate::forward::solve::Solved;

/// Fraction of the squared rates below which the contradiction `y^T r` counts as round-off.
const ROUND_OFF: f64 = 1e-6;
/// Fraction of the largest right-hand side below which the contradiction counts as round-off.
/// Right-hand sides contain prescribed accelerations, also while the mechanism is at rest.
const ROUNDED: f64 = 1e-10;
/// Relative component of a self-stress below which a DOF does not belong to the self-stress.
const PART: f64 = 1e-6;

impl Forward {
    /// Finds a sticking interface that the loop constraints force to move, as described in the
    /// module documentation. Returns the index of the interface and the direction of its motion.
    pub(in crate::forward) fn instantaneous_lock(
        &self,
        data: &Data,
        solved: &Solved,
    ) -> Option<(usize, [f64; 3])> {
        let (rows, stresses) =
            (&solved.balance.rows.rows, &solved.balance.redundancy.self_stresses);
        if solved.sticking.is_empty() || stresses.is_empty() {
            return None;
        }
        let first = self.topology.closures();
        let square = self.fastest(data).powi(2);
        for stress in stresses {
            let each = rows.iter().zip(&stress.multipliers);
            // Right-hand sides are multiplied by the row scales, so multipliers are divided by
            // them.
            let (mut sum, mut right, mut largest) = (0.0, 0.0_f64, 0.0_f64);
            for (row, amount) in each {
                sum += amount * row.right;
                right = right.max((row.right * row.scale).abs());
                largest = largest.max((amount / row.scale).abs());
            }
            if sum.abs() <= (ROUND_OFF * square).max(ROUNDED * right) * largest {
                continue;
            }
            let amount = |dof: &StickingDof| {
                stress.multipliers[first + dof.row] / rows[first + dof.row].scale
            };
            let dofs = solved.sticking.iter();
            let Some(dof) = dofs.max_by(|a, b| amount(a).abs().total_cmp(&amount(b).abs())) else {
                continue;
            };
            if amount(dof).abs() <= PART * largest {
                continue;
            }
            let moves = -sum / stress.multipliers[first + dof.row];
            let mut direction = [0.0; 3];
            direction[dof.place] = moves.signum();
            return Some((dof.interface, direction));
        }
        None
    }
}
