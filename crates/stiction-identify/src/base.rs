//! Base parameters: the combinations of parameters that efforts determine.
//!
//! Source: Gautier, *Numerical calculation of the base inertial parameters of robots*, J. Robotic
//! Systems 8 (1991). Equation (I2) of the book's theory.

use crate::parameter::Parameter;
use nalgebra::DMatrix;

/// Combination of parameters: one of them, and multiples of others that act as it does.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Index of the parameter with coefficient one.
    pub leader: usize,
    /// Indices and coefficients of the others.
    pub others: Vec<(usize, f64)>,
}

/// Combinations that a set of rows determines, by QR decomposition with column pivoting.
#[derive(Clone, Debug)]
pub struct BaseParameters {
    /// The combinations; their number is the rank.
    pub combinations: Vec<Combination>,
    /// Parameters without any effect.
    pub without_effect: Vec<usize>,
    /// Ratio of the smallest pivot that counts to the largest that does not; infinite if all count.
    /// A rank is certain if it is large.
    pub gap: f64,
}

/// Pivot, relative to the first, below which a column depends on those before.
const NEGLIGIBLE: f64 = 1e-8;
/// Coefficient of a combination, in units of the parameters' scales, that is round-off.
const ROUND_OFF: f64 = 1e-7;

impl BaseParameters {
    /// Combinations that the rows of `matrix` determine; a column for each parameter.
    pub fn of(matrix: &DMatrix<f64>, parameters: &[Parameter]) -> Self {
        let count = matrix.ncols();
        let norms: Vec<f64> = matrix.column_iter().map(|column| column.norm()).collect();
        // A column counts relative to those of the same kind: efforts per scale of the parameter.
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

    /// Number of combinations.
    pub fn rank(&self) -> usize {
        self.combinations.len()
    }

    /// The combinations of more than one parameter.
    pub fn shared(&self) -> impl Iterator<Item = &Combination> {
        self.combinations.iter().filter(|c| !c.others.is_empty())
    }

    /// True if the parameter is determined by itself, in no combination with others.
    pub fn is_alone(&self, parameter: usize) -> bool {
        self.combinations.iter().any(|c| c.leader == parameter && c.others.is_empty())
    }
}

impl Combination {
    /// Value of the combination.
    pub fn value(&self, values: &[f64]) -> f64 {
        values[self.leader] + self.others.iter().map(|(k, c)| c * values[*k]).sum::<f64>()
    }

    /// The combination in words, such as `crank.mx + 0.2 rod.mass`, with at most `most` terms.
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

/// The triangular factor of a tall matrix, which has the same column dependences.
fn compressed(matrix: DMatrix<f64>) -> DMatrix<f64> {
    if matrix.nrows() > 2 * matrix.ncols() { matrix.qr().r() } else { matrix }
}
