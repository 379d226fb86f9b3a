//! Contacts that cannot stick although they stand: at a dead centre.
//!
//! There the joint's rate is zero whatever the mechanism does, but an instant later it is not. What sticking asks
//! of the accelerations then contradicts the loops: the row that holds it depends on theirs, and the value that
//! it should have is another than theirs. With a self-stress `y` of the rows, `y^T J = 0`, accelerations with
//! `J a = r` exist only if `y^T r = 0`; if not, a held contact of the self-stress moves, by `-y^T r / y_k`.

use super::Forward;
use super::situation::Situation;
use super::solve::Solved;

/// Less than this part of the squares of rates is rounding.
const MOVES: f64 = 1e-6;
/// Held freedoms with less than this part of a self-stress are not of it.
const PART: f64 = 1e-6;

impl Forward {
    /// A contact that is held and must move, and where to.
    pub(super) fn gives_way(
        &self,
        situation: &Situation,
        solved: &Solved,
    ) -> Option<(usize, [f64; 3])> {
        let (rows, stresses) = (&solved.balance.rows.rows, &solved.balance.spread.stresses);
        if solved.holding.is_empty() || stresses.is_empty() {
            return None;
        }
        let first = self.topology.constraints;
        let square = self.scene(situation).fastest().powi(2);
        for stress in stresses {
            let each = rows.iter().zip(&stress.multipliers);
            // Multipliers over scales go with values times scales.
            let (mut sum, mut most) = (0.0, 0.0_f64);
            for (row, amount) in each {
                sum += amount * row.right;
                most = most.max((amount / row.scale).abs());
            }
            if sum.abs() <= MOVES * square * most {
                continue;
            }
            let amount = |&(_, _, row): &(usize, usize, usize)| {
                stress.multipliers[first + row] / rows[first + row].scale
            };
            let holds = solved.holding.iter();
            let Some(held) = holds.max_by(|a, b| amount(a).abs().total_cmp(&amount(b).abs()))
            else {
                continue;
            };
            if amount(held).abs() <= PART * most {
                continue;
            }
            let (interface, place, row) = *held;
            let moves = -sum / stress.multipliers[first + row];
            let mut way = [0.0; 3];
            way[place] = moves.signum();
            return Some((interface, way));
        }
        None
    }
}
