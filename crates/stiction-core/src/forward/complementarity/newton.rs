//! Newton's method on the nonsmooth equations.

use super::SETTLED;
use super::problem::Cone;
use crate::linalg::RowSpace;

/// What does not get better than this is rounding.
const STAGNATED: f64 = 1e-9;
/// Steps, and how often one is halved until it leads downhill.
const STEPS: usize = 40;
const HALVINGS: usize = 10;
/// Rows of Newton's matrix that add less than this depend on others.
const DEPENDENT: f64 = 1e-11;

impl Cone<'_> {
    /// Newton's method; whether it ends at a solution.
    pub(super) fn newton(&self, x: &mut Vec<f64>, part: f64) -> bool {
        let n = self.count();
        let (mut matrix, mut space) = (Vec::new(), RowSpace::default());
        let mut now = self.residual(x, part, Some(&mut matrix));
        for _ in 0..STEPS {
            if now.missed() <= SETTLED {
                return true;
            }
            if !now.missed().is_finite() || matrix.iter().any(|x| !x.is_finite()) {
                return false;
            }
            space.decompose(&matrix, n, n, DEPENDENT);
            let step = space.shortest(&now.values);
            let mut better = None;
            let mut by = 1.0;
            for _ in 0..HALVINGS {
                let trial: Vec<f64> = x.iter().zip(&step).map(|(x, s)| x - by * s).collect();
                let there = self.residual(&trial, part, None);
                if there.square() < (1.0 - 0.1 * by) * now.square() {
                    better = Some(trial);
                    break;
                }
                by *= 0.5;
            }
            let Some(trial) = better else { return now.missed() <= STAGNATED };
            *x = trial;
            now = self.residual(x, part, Some(&mut matrix));
        }
        now.missed() <= STAGNATED
    }
}
