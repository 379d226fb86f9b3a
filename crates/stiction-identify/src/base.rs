//! Base parameters: the combinations of parameters that the efforts determine.
//!
//! Source: Gautier, *Numerical calculation of the base inertial parameters of robots*, J. Robotic
//! Systems 8 (1991). Equation (I2) of the book's theory.

use crate::parameter::Parameter;
use nalgebra::DMatrix;

/// Linear combination of parameters that the efforts determine as a whole: one parameter, plus
/// multiples of other parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Index of the parameter with coefficient one.
    pub leader: usize,
    /// Indices and coefficients of the other parameters.
    pub others: Vec<(usize, f64)>,
}

/// Combinations of parameters that the rows of a regression determine, found by QR decomposition
/// with column pivoting.
#[derive(Clone, Debug)]
pub struct BaseParameters {
    /// Combinations that the rows determine; their number is the rank of the regression matrix.
    pub combinations: Vec<Combination>,
    /// Indices of the parameters without any effect on the efforts.
    pub without_effect: Vec<usize>,
    /// Ratio of the smallest pivot that counts as nonzero to the largest pivot that counts as zero;
    /// infinite if no pivot counts as zero, or if the largest of these pivots is exactly zero. The
    /// rank is certain if this ratio is large.
    pub gap: f64,
}

/// A column counts as dependent on the previous columns if its pivot is at most this fraction of
/// the first pivot.
const NEGLIGIBLE: f64 = 1e-8;
/// Coefficients of a combination up to this value, in units of the parameters' scales, count as
/// round-off.
const ROUND_OFF: f64 = 1e-7;

impl BaseParameters {
    /// Finds the combinations that the rows of a regression determine. `matrix` has a column for
    /// each parameter.
    pub fn of(matrix: &DMatrix<f64>, parameters: &[Parameter]) -> Self {
        let count = matrix.ncols();
        let norms: Vec<f64> = matrix.column_iter().map(|column| column.norm()).collect();
        // The effect of a parameter is the norm of its column times its scale, so that parameters
        // of different units are comparable.
        let effects: Vec<f64> = norms.iter().zip(parameters).map(|(n, p)| n * p.scale).collect();
        let largest = effects.iter().copied().fold(0.0, f64::max);
        let (active, without_effect): (Vec<usize>, Vec<usize>) =
            (0..count).partition(|&k| effects[k] > 1e-10 * largest);
        let scaled = DMatrix::from_fn(matrix.nrows(), active.len(), |i, k| {
            matrix[(i, active[k])] / norms[active[k]]
        });
        let factors = compressed(scaled).col_piv_qr();
        let r = factors.r();
        let mut order = DMatrix::from_fn(1, active.len(), |_, k| k as f64);
        factors.p().permute_columns(&mut order);
        let order: Vec<usize> = order.iter().map(|&k| active[k as usize]).collect();
        let pivots: Vec<f64> = (0..r.nrows().min(r.ncols())).map(|k| r[(k, k)].abs()).collect();
        let first = pivots.first().copied().unwrap_or(0.0);
        let rank = pivots.iter().take_while(|pivot| **pivot > NEGLIGIBLE * first).count();
        let gap = match (rank.checked_sub(1), pivots.get(rank)) {
            (Some(last), Some(&next)) if next > 0.0 => pivots[last] / next,
            _ => f64::INFINITY,
        };
        let leading = r.view((0, 0), (rank, rank)).into_owned();
        let rest = r.view((0, rank), (rank, active.len() - rank)).into_owned();
        let dependence =
            leading.solve_upper_triangular(&rest).unwrap_or_else(|| DMatrix::zeros(rank, 0));
        let combinations = (0..rank).map(|row| {
            let leader = order[row];
            let others = (0..dependence.ncols()).filter_map(|k| {
                let other = order[rank + k];
                let coefficient = dependence[(row, k)] * norms[other] / norms[leader];
                let relative = coefficient * parameters[other].scale / parameters[leader].scale;
                (relative.abs() > ROUND_OFF && dependence[(row, k)].abs() > ROUND_OFF)
                    .then_some((other, coefficient))
            });
            Combination { leader, others: others.collect() }
        });
        Self { combinations: combinations.collect(), without_effect, gap }
    }

    /// Returns the number of combinations.
    pub fn rank(&self) -> usize {
        self.combinations.len()
    }

    /// Iterates over the combinations of more than one parameter.
    pub fn shared(&self) -> impl Iterator<Item = &Combination> {
        self.combinations.iter().filter(|c| !c.others.is_empty())
    }

    /// Returns true if a parameter is determined on its own, not only in a combination with others.
    pub fn is_alone(&self, parameter: usize) -> bool {
        self.combinations.iter().any(|c| c.leader == parameter && c.others.is_empty())
    }
}

impl Combination {
    /// Returns the value of the combination for given values of all parameters.
    pub fn value(&self, values: &[f64]) -> f64 {
        values[self.leader] + self.others.iter().map(|(k, c)| c * values[*k]).sum::<f64>()
    }

    /// Describes the combination, such as `crank.mx + 0.2 rod.mass`, with at most `most` terms.
    pub fn words(&self, parameters: &[Parameter], most: usize) -> String {
        let mut text = parameters[self.leader].name.clone();
        for (count, (k, coefficient)) in self.others.iter().enumerate() {
            if count + 1 >= most {
                text += &format!(" + {} more", self.others.len() - count);
                break;
            }
            let sign = if *coefficient < 0.0 { '-' } else { '+' };
            let size = coefficient.abs();
            let rounded = format!("{size:.4}");
            let rounded = rounded.trim_end_matches('0').trim_end_matches('.');
            let name = &parameters[*k].name;
            text += &match rounded {
                "1" => format!(" {sign} {name}"),
                "0" => format!(" {sign} {size:.2e} {name}"),
                rounded => format!(" {sign} {rounded} {name}"),
            };
        }
        text
    }
}

/// Returns the triangular QR factor of a tall matrix. The columns of this factor have the same
/// linear dependencies as the columns of the matrix. Other matrices are returned unchanged.
fn compressed(matrix: DMatrix<f64>) -> DMatrix<f64> {
    if matrix.nrows() > 2 * matrix.ncols() { matrix.qr().r() } else { matrix }
}
