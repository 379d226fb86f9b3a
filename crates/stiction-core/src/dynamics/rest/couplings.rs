//! Bounds of the influence of friction on normal forces.
//!
//! Equation (R2) of the book's theory.

use super::map::FrictionMap;
use crate::friction_problem::uniqueness::radius_bound;
use crate::linalg::largest;
use crate::linalg::{SparseMatrix, triangular_blocks};
use core::cell::OnceCell;
use nalgebra::DVector;

/// Bounds of the influence of friction on normal forces, see [`FrictionMap::couplings`].
pub(super) struct Couplings {
    bounds: SparseMatrix,
    /// Bounds of the influence of friction on friction limits: [`Self::bounds`], with each row
    /// multiplied by the larger friction coefficient of its interface.
    of_limits: SparseMatrix,
    /// Transpose of [`Self::bounds`].
    influencing: OnceCell<SparseMatrix>,
    /// Block triangular form of [`Self::of_limits`].
    blocks: OnceCell<Vec<DiagonalBlock>>,
    /// Upper bound of the spectral radius of [`Self::of_limits`], once it is known.
    radius: OnceCell<f64>,
}

/// Diagonal block of a block triangular matrix.
struct DiagonalBlock {
    /// Interfaces of the block, in ascending order.
    interfaces: Vec<usize>,
    matrix: SparseMatrix,
}

/// Influence of a friction force on a friction limit that counts as round-off.
const ROUND_OFF: f64 = 1e-14;
/// Number of interfaces in a diagonal block from which the block is solved by iteration, because
/// the cost of elimination grows with the cube of this number.
const LARGE: usize = 65;
/// Largest number of iterations for such systems; each of them needs two matrix products.
const ITERATIONS: usize = 60;
/// Largest number of fixed-point steps. If more steps are needed, a direct solution is faster.
const STEPS: usize = 16;

impl Couplings {
    pub(super) fn new(map: &FrictionMap<'_>, bounds: SparseMatrix) -> Self {
        let largest: Vec<f64> = (0..map.interfaces())
            .map(|interface| {
                let [forward, backward] = map.coefficients(interface);
                forward.max(backward)
            })
            .collect();
        let of_limits = bounds.scaled(&largest, &vec![1.0; largest.len()]);
        let (influencing, blocks, radius) = Default::default();
        Self { bounds, of_limits, influencing, blocks, radius }
    }

    /// Returns the bounds for a selection of the interfaces, see [`FrictionMap::restricted`].
    pub(super) fn restricted(&self, map: &FrictionMap<'_>, interfaces: &[usize]) -> Self {
        Self::new(map, self.bounds.select(interfaces))
    }

    /// Returns the bounds of the influence of the friction of one interface on the normal forces,
    /// as pairs of interface and bound.
    pub(super) fn column(&self, interface: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.bounds.column(interface)
    }

    /// Returns the transposed matrix of bounds. Its columns list the interfaces whose friction
    /// influences the normal force of each interface.
    pub(super) fn influencing(&self) -> &SparseMatrix {
        self.influencing.get_or_init(|| self.bounds.transpose())
    }

    /// Returns an upper bound of the spectral radius of the influence on friction limits.
    pub(super) fn radius(&self) -> f64 {
        *self.radius.get_or_init(|| {
            // The spectral radius of a block triangular matrix is that of a diagonal block.
            let radii = self.blocks().iter().map(|block| {
                match block.matrix.to_dense().as_slice() {
                    [entry] if entry.is_finite() => *entry,
                    // The transpose has the same spectral radius.
                    matrix => radius_bound(matrix, block.interfaces.len(), &mut Default::default()),
                }
            });
            radii.fold(0.0, f64::max)
        })
    }

    /// Returns groups of interfaces. The friction of a group influences no friction limit of an
    /// earlier group, except for round-off.
    pub(super) fn groups(&self) -> Vec<Vec<usize>> {
        triangular_blocks(self.of_limits.ncols(), |column| {
            let counts = |entry: f64| entry > ROUND_OFF || entry.is_nan();
            self.of_limits
                .column(column)
                .filter(move |(_, entry)| counts(*entry))
                .map(|(row, _)| row)
        })
    }

    fn blocks(&self) -> &[DiagonalBlock] {
        self.blocks.get_or_init(|| {
            let count = self.of_limits.ncols();
            let rows = |column| self.of_limits.column(column).map(|(row, _)| row);
            let each = triangular_blocks(count, rows).into_iter().map(|interfaces| {
                let matrix = self.of_limits.select(&interfaces);
                DiagonalBlock { interfaces, matrix }
            });
            each.collect()
        })
    }

    /// Solves `x = constants + part M x` with the influence `M` on friction limits. The spectral
    /// radius of `part M` must be below one.
    pub(super) fn fixed_point(&self, part: f64, constants: &[f64]) -> Option<Vec<f64>> {
        let mut solution = constants.to_vec();
        // Weak couplings converge in a few steps.
        for _ in 0..STEPS {
            let mut next = self.of_limits.times(&solution);
            let (mut change, mut largest) = (0.0_f64, 0.0_f64);
            for ((next, constant), before) in next.iter_mut().zip(constants).zip(&solution) {
                *next = constant + *next * part;
                change = change.max((*next - before).abs());
                largest = largest.max(next.abs());
            }
            solution = next;
            if change <= f64::EPSILON * largest {
                return Some(solution);
            }
        }
        self.solve(part, constants, &solution)
    }

    /// Solves `x = constants + part M x` by elimination of the diagonal blocks of `M`, or by
    /// iteration from `start` in large blocks. Parts of a mechanism that are loaded lightly have
    /// the same relative accuracy as the others.
    fn solve(&self, part: f64, constants: &[f64], start: &[f64]) -> Option<Vec<f64>> {
        let mut solution = constants.to_vec();
        for DiagonalBlock { interfaces: block, matrix: influence } in self.blocks() {
            let of_block = |all: &[f64]| block.iter().map(|&k| all[k]).collect::<Vec<f64>>();
            let right = of_block(&solution);
            let iterated = match block.len() >= LARGE {
                true => iterate(influence, part, &right, of_block(start)),
                false => None,
            };
            let found = match iterated {
                Some(found) => found,
                None => {
                    let mut matrix = influence.to_dense() * -part;
                    (0..block.len()).for_each(|k| matrix[(k, k)] += 1.0);
                    matrix.lu().solve(&DVector::from_vec(right))?.as_slice().to_vec()
                }
            };
            for (&own, amount) in block.iter().zip(&found) {
                solution[own] = *amount;
            }
            // Later blocks depend on this one.
            for (&own, amount) in block.iter().zip(&found) {
                for (row, entry) in self.of_limits.column(own) {
                    if block.binary_search(&row).is_err() {
                        solution[row] += part * entry * amount;
                    }
                }
            }
        }
        Some(solution)
    }
}

/// Solves `x = constants + part M x` from the starting point `x` by the stabilised biconjugate
/// gradient method (van der Vorst 1992). It converges fast even close to the largest possible
/// `part`, where only one eigenvalue of the system is small. `None` if the residual does not
/// decrease to round-off.
fn iterate(
    influence: &SparseMatrix,
    part: f64,
    constants: &[f64],
    mut x: Vec<f64>,
) -> Option<Vec<f64>> {
    let apply = |x: &[f64]| -> Vec<f64> {
        influence.times(x).iter().zip(x).map(|(product, x)| x - part * product).collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let residual = |x: &[f64]| -> Vec<f64> {
        constants.iter().zip(apply(x)).map(|(constant, own)| constant - own).collect()
    };
    let mut left = residual(&x);
    let shadow = left.clone();
    let mut direction = left.clone();
    let mut product = dot(&shadow, &left);
    for _ in 0..ITERATIONS {
        let moved = apply(&direction);
        let alpha = product / dot(&shadow, &moved);
        left.iter_mut().zip(&moved).for_each(|(left, moved)| *left -= alpha * moved);
        let turned = apply(&left);
        let omega = dot(&turned, &left) / dot(&turned, &turned).max(f64::MIN_POSITIVE);
        for ((x, direction), left) in x.iter_mut().zip(&direction).zip(&left) {
            *x += alpha * direction + omega * left;
        }
        left.iter_mut().zip(&turned).for_each(|(left, turned)| *left -= omega * turned);
        let limit = 4.0 * f64::EPSILON * largest(&x);
        if !(alpha.is_finite() && omega.is_finite() && limit.is_finite()) {
            return None;
        }
        if largest(&left) <= limit {
            // Rounding errors separate the residual of the recursion from the true one.
            let left = residual(&x);
            return (left.iter().all(|left| left.abs() <= 4.0 * limit)).then_some(x);
        }
        let next = dot(&shadow, &left);
        let beta = next / product * (alpha / omega);
        for ((direction, left), moved) in direction.iter_mut().zip(&left).zip(&moved) {
            *direction = left + beta * (*direction - omega * moved);
        }
        product = next;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Compares the solutions with those of one dense elimination, for a large block, whose
    /// coupling is close to critical, and a small one that depends on it and is loaded lightly.
    #[test]
    fn solutions_are_accurate_in_each_block() {
        let (large, count) = (80, 100);
        let mut random = Random::new(3);
        let mut entries = Vec::new();
        for column in 0..count {
            let from = if column < large { 0 } else { large };
            let to = if column < large { large } else { count };
            for row in from..to {
                entries.push((row, column, 0.5 + 0.5 * random.number()));
            }
            if column < large {
                entries.push((large + column % (count - large), column, 1e-12));
            }
        }
        let of_limits = SparseMatrix::new((count, count), entries.into_iter());
        let couplings = Couplings {
            bounds: of_limits.clone(),
            of_limits,
            influencing: OnceCell::new(),
            blocks: OnceCell::new(),
            radius: OnceCell::new(),
        };
        assert_eq!(couplings.blocks().len(), 2);
        let part = 0.999 / couplings.radius();
        let constants: Vec<f64> = (0..count)
            .map(|k| if k < large { 1e3 } else { 1e-9 } * (1.5 + random.number()))
            .collect();
        let dense = couplings.of_limits.to_dense() * -part;
        let dense = dense + nalgebra::DMatrix::identity(count, count);
        let expected = dense.lu().solve(&DVector::from_column_slice(&constants)).unwrap();
        let found = couplings.fixed_point(part, &constants).unwrap();
        for (k, (found, expected)) in found.iter().zip(expected.iter()).enumerate() {
            // The condition number is some 1e3.
            assert!((found / expected - 1.0).abs() < 1e-11, "{k}: {found} {expected}");
        }
    }
}
