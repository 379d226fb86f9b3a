//! Inequalities for samples at rest. The friction at rest is not determined; only its limits are
//! known.
//!
//! Equation (I9) of the book's theory.

use super::map::Map;
use super::{Estimate, Normal, Problem};
use crate::block::{Block, Dwells};
use nalgebra::{DMatrix, DVector};

/// Number of standard deviations of the noise by which an effort at rest may exceed its bound. The
/// bounds are extremes of measured efforts and therefore contain extremes of the noise.
const SLACK: f64 = 2.0;

/// Half-space `offset - direction . z <= 0` in the space of the free coordinates `z`; `weight`
/// multiplies the square of a violation.
#[derive(Clone, Debug)]
pub(super) struct HalfSpace {
    offset: f64,
    direction: DVector<f64>,
    weight: f64,
}

impl HalfSpace {
    /// Returns the violation of the inequality at `z`; zero inside the half-space.
    fn violation(&self, z: &DVector<f64>) -> f64 {
        (self.offset - self.direction.dot(z)).max(0.0)
    }

    /// Adds half the weighted square of the violation at `z`, its gradient and its Hessian to those
    /// of the objective. The added value and gradient are continuous.
    pub(super) fn add(
        &self,
        z: &DVector<f64>,
        (value, gradient, hessian): (&mut f64, &mut DVector<f64>, &mut DMatrix<f64>),
    ) {
        let violation = self.violation(z);
        if violation > 0.0 {
            *value += 0.5 * self.weight * violation * violation;
            gradient.axpy(-self.weight * violation, &self.direction, 1.0);
            hessian.ger(self.weight, &self.direction, &self.direction, 1.0);
        }
    }
}

impl Dwells {
    /// Returns the two inequalities of each dwell. An inequality has the sign of the effort, the
    /// index of its bound in [`Dwells::bounds`], and the coefficients of the parameters (columns)
    /// for all dwells (rows).
    fn sides(&self) -> [(f64, usize, DMatrix<f64>); 2] {
        // With friction at its positive limit the effort must reach the greatest bound, with
        // friction at its negative limit the least bound.
        [(1.0, 1), (-1.0, 0)].map(|(sign, bound)| (sign, bound, &self.limits + &self.matrix * sign))
    }
}

impl Normal {
    /// Computes the covariance of the gradient of the half-spaces that are violated at `z`. Each
    /// violated half-space counts as one sample.
    pub(super) fn limit_errors(&self, z: &DVector<f64>) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(z.len(), z.len());
        for limit in self.limits.iter().filter(|limit| limit.violation(z) > 0.0) {
            sum.ger(limit.weight, &limit.direction, &limit.direction, 1.0);
        }
        sum
    }
}

impl Problem<'_> {
    /// Returns the half-spaces of all dwells. `noise` is the standard deviation of each actuator's
    /// effort, N or N m.
    pub(super) fn limits(&self, map: &Map, shift: &DVector<f64>, noise: &[f64]) -> Vec<HalfSpace> {
        let offset = &map.base - shift;
        let mut all = Vec::new();
        for block in self.blocks {
            for (dwells, noise) in block.dwells.iter().zip(noise) {
                let rows = dwells.bounds.len();
                for (sign, bound, matrix) in dwells.sides() {
                    let fixed = &matrix * &offset;
                    let columns = map.columns(&matrix, 0..rows);
                    for (row, bounds) in dwells.bounds.iter().enumerate() {
                        all.push(HalfSpace {
                            offset: sign * bounds[bound] - SLACK * noise - fixed[row],
                            direction: columns.row(row).transpose(),
                            weight: noise.powi(-2),
                        });
                    }
                }
            }
        }
        all
    }

    /// Returns, for each dwell of each block, the largest excess of the efforts at rest over the
    /// limits of static friction that follow from `estimate`. The excess is in standard deviations;
    /// it is zero within all limits. `estimate` must come from a fit without these limits.
    pub fn excesses(&self, estimate: &Estimate) -> Vec<Vec<f64>> {
        let at = DVector::from_column_slice(&estimate.values) - self.shift();
        let of_block = |block: &Block| {
            let count = block.dwells.iter().map(|dwells| dwells.bounds.len()).max().unwrap_or(0);
            let mut all = vec![0.0; count];
            for (dwells, noise) in block.dwells.iter().zip(&estimate.noise) {
                for (sign, bound, matrix) in dwells.sides() {
                    for ((excess, row), bounds) in
                        all.iter_mut().zip(matrix.row_iter()).zip(&dwells.bounds)
                    {
                        let beyond =
                            sign * bounds[bound] - SLACK * noise - row.transpose().dot(&at);
                        let variance = (row * &estimate.covariance * row.transpose())[(0, 0)];
                        let sigma = (variance.max(0.0) + noise * noise).sqrt();
                        *excess = f64::max(*excess, beyond / sigma);
                    }
                }
            }
            all
        };
        self.blocks.iter().map(of_block).collect()
    }
}
