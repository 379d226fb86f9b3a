//! Bound on the coupling of friction and normal loads. If it is below one, the solution is unique.
//!
//! Equations (F6) and (F7) of the book's theory.

use super::influence::{Influence, InfluenceMatrix, Two};
use super::normal_load::Configuration;
use super::small_system::{Four, blocks_of, solve_in_place};
use crate::linalg::{VectorHistory, triangular_blocks};
use crate::scalar::{Lanes, Scalar};
use nalgebra::{DMatrix, DVector};

/// Largest number of undamped power iterations, which converge faster than damped ones. Every
/// iterate yields a valid bound.
const PLAIN: usize = 30;
/// Largest number of damped power iterations, which converge for every matrix. Every iterate yields
/// a valid bound.
const DAMPED: usize = 60;
/// Relative changes of the bound in one iteration below this value count as round-off.
const STILL: f64 = 1e-13;
/// The iteration stops after this number of successive iterations in which the bound changes only
/// by round-off.
const REPEATED: usize = 3;

/// Largest number of steps of inverse iteration.
const INVERSE: usize = 6;
/// Inverse iteration has converged if the relative difference of lower and upper bound is at most
/// this value.
const CONVERGED: f64 = 1e-13;

/// Number of interfaces from which the matrix is reduced to block triangular form, and from which
/// power iterations precede inverse iteration, whose cost grows with the third power of this
/// number.
const LARGE: usize = 40;
/// Largest number of these power iterations.
const POWERS: usize = 80;
/// Entries up to this fraction of the largest entry are round-off of zeros where the matrix is
/// reduced to block triangular form.
const ROUND_OFF: f64 = 1e-14;
/// Largest number of interfaces in a block of this form, because blocks are also solved by
/// elimination.
const LARGEST_BLOCK: usize = 100;

/// Least component of the vectors of inverse iteration, whose greatest component is one.
const LEAST: f64 = 1e-9;

/// Buffers of [`coupling_bound`].
#[derive(Clone, Debug, Default)]
pub(crate) struct BoundWorkspace {
    interfaces: Vec<(usize, f64)>,
    /// Coupling matrix, row by row.
    matrix: Vec<f64>,
    vectors: RadiusWorkspace,
}

/// Buffers of [`radius_bound`].
#[derive(Clone, Debug, Default)]
pub(crate) struct RadiusWorkspace {
    columns: Vec<Four>,
    x: Vec<Four>,
    next: Vec<Four>,
    /// Eigenvectors of the last inverse iterations, from which the starting vector of the next one
    /// is extrapolated.
    known: VectorHistory,
    solution: Vec<f64>,
    product: Vec<f64>,
    shifted: Vec<Four>,
    /// Largest bound that is accepted without refinement.
    accepted: f64,
}

/// Starting vector for the computation of a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BoundStart {
    /// Vector of ones: the bound does not depend on earlier bounds.
    New,
    /// Extrapolation of the eigenvectors from the computation of the previous bounds.
    Last,
}

impl BoundWorkspace {
    /// Sets the starting vector of the next bound.
    pub(crate) fn start(&mut self, start: BoundStart) {
        if start == BoundStart::New {
            self.vectors.known.forget();
        }
    }

    /// Accepts any bound up to this value, so that the iteration may stop before it finds the
    /// smallest one.
    pub(crate) fn accept_up_to(&mut self, bound: f64) {
        self.vectors.accepted = bound;
    }
}

/// Computes a bound on the spectral radius of the coupling matrix. Entry (i, j) bounds the change
/// of the normal load of interface i per newton of change of the normal load of interface j,
/// through the friction at j. Load maps are seminorms of the wrench, and wrenches are affine in
/// friction. If the spectral radius is below one, the solution therefore exists and is unique
/// (Banach's fixed-point theorem in the maximum norm weighted by the eigenvector of the matrix).
///
/// `interfaces` lists the interfaces by index, each with its friction coefficient; `influence` is
/// the change of the joint wrenches per unit of normal load.
pub(crate) fn coupling_bound(
    at: Configuration<'_>,
    interfaces: impl Iterator<Item = (usize, f64)>,
    influence: &mut impl Influence,
    workspace: &mut BoundWorkspace,
) -> f64 {
    let BoundWorkspace { interfaces: known, matrix, vectors } = workspace;
    known.clear();
    known.extend(interfaces);
    let count = known.len();
    matrix.clear();
    matrix.resize(count * count, 0.0);
    if count > 0 {
        influence.visit(|row, column, wrench| {
            let (interface, own) = known[row];
            matrix[row * count + column] = at.largest_load_change(interface, wrench, own);
        });
    }
    radius_bound(matrix, count, vectors)
}

/// Computes [`coupling_bound`] from a stored influence matrix, two columns at a time: the wrenches
/// of two columns fit into the registers of every processor, those of four do not.
pub(crate) fn coupling_bound_in_blocks(
    at: Configuration<'_>,
    interfaces: impl Iterator<Item = (usize, f64)>,
    influence: &InfluenceMatrix,
    workspace: &mut BoundWorkspace,
) -> f64 {
    let BoundWorkspace { matrix, vectors, .. } = workspace;
    let count = influence.count();
    matrix.clear();
    for (row, (interface, own)) in interfaces.enumerate() {
        let change = at.largest_load_changes::<Two>(interface, own);
        for pair in 0..count.div_ceil(2) {
            let Lanes(changes) = change(influence.pair(row, pair));
            let left = (count - 2 * pair).min(2);
            matrix.extend_from_slice(&changes[..left]);
        }
    }
    radius_bound(matrix, count, vectors)
}

/// Computes [`coupling_bound`] from the coupling matrix of `count` interfaces, stored row by row.
pub(crate) fn coupling_bound_of(
    matrix: &[f64],
    count: usize,
    workspace: &mut BoundWorkspace,
) -> f64 {
    radius_bound(matrix, count, &mut workspace.vectors)
}

/// Computes an upper bound on the spectral radius of a nonnegative `count` by `count` matrix,
/// stored row by row. The bound is the largest ratio of `(matrix x)_i` to `x_i`, which is valid for
/// any positive `x` (Collatz and Wielandt). Inverse iteration improves `x`; if it fails, power
/// iterations do.
pub(crate) fn radius_bound(matrix: &[f64], count: usize, workspace: &mut RadiusWorkspace) -> f64 {
    if count == 0 {
        return 0.0;
    }
    // Check for NaN explicitly, because comparisons with NaN are false.
    if matrix.iter().any(|entry| !entry.is_finite()) {
        return f64::INFINITY;
    }
    if let Some(bound) = bound_of_blocks(matrix, count, workspace.accepted) {
        workspace.known.forget();
        return bound;
    }
    let mut bound = match bound_by_inverse_iteration(matrix, count, workspace) {
        Ok(bound) => return bound,
        Err(bound) => bound,
    };
    // Store the columns in blocks of four numbers; zero rows at the end have no effect.
    let RadiusWorkspace { columns, x, next, accepted, .. } = workspace;
    let width = blocks_of(count);
    columns.clear();
    columns.resize(width * count, Four::zero());
    for (row, entries) in matrix.chunks_exact(count).enumerate() {
        for (column, entry) in columns.chunks_exact_mut(width).zip(entries) {
            column[row / 4].0[row % 4] = *entry;
        }
    }
    x.clear();
    x.resize(width, Four::one());
    next.clear();
    next.resize(width, Four::zero());
    let mut iterate = |x: &mut [Four], steps, part, stops| {
        let (mut before, mut still) = (f64::INFINITY, 0);
        for _ in 0..steps {
            let ratio = power_step(columns, count, x, next, part);
            bound = bound.min(ratio);
            still = if (ratio - before).abs() <= STILL * ratio { still + 1 } else { 0 };
            before = ratio;
            if (stops && still == REPEATED) || bound <= *accepted {
                break;
            }
        }
        bound
    };
    iterate(x, PLAIN, 1.0, true);
    if iterate(x, DAMPED, 0.5, true) < 1.0 {
        return bound;
    }
    // No bound below one is proven yet: run all iterations without stopping early.
    x.fill(Four::one());
    iterate(x, DAMPED, 0.5, false)
}

/// Computes the bound from the diagonal blocks of the block triangular form of a large matrix. The
/// friction of a group of interfaces often loads only some other groups: in a row of loops with one
/// actuator, only those between the group and the actuator. Iterations with the whole matrix then
/// converge slowly. Entries that are round-off are neglected, but a bound below one is returned only
/// if these entries cannot raise the spectral radius to one. Returns `None` if the matrix is small,
/// has only one block or a large one, or if the neglected entries matter.
fn bound_of_blocks(matrix: &[f64], count: usize, accepted: f64) -> Option<f64> {
    if count < LARGE {
        return None;
    }
    let negligible = ROUND_OFF * matrix.iter().copied().fold(0.0, f64::max);
    let row = |row: usize| matrix[row * count..(row + 1) * count].iter().copied().enumerate();
    // The transpose has the same diagonal blocks. In the order of the blocks, a row has entries only
    // in its own block and in later ones.
    let blocks = triangular_blocks(count, |own| {
        row(own).filter(|(_, entry)| *entry > negligible).map(|(column, _)| column)
    });
    if blocks.len() == 1 || blocks.iter().any(|block| block.len() > LARGEST_BLOCK) {
        return None;
    }
    let mut workspace = RadiusWorkspace { accepted, ..Default::default() };
    let mut part = Vec::new();
    let mut bound = 0.0_f64;
    for block in &blocks {
        part.clear();
        for own in block {
            part.extend(block.iter().map(|column| matrix[own * count + column]));
        }
        workspace.known.forget();
        bound = bound.max(match part[..] {
            [entry] => entry,
            _ => radius_bound(&part, block.len(), &mut workspace),
        });
    }
    if bound >= 1.0 {
        return Some(bound);
    }
    // With the neglected entries `E` and the others `T`, the spectral radius is below one if the
    // product of the maximum norms of the inverse of `1 - T` and of `E` is below one. The inverse
    // has no negative entries, so its norm is its largest row sum.
    let neglected = (0..count).map(|own| {
        row(own).map(|(_, entry)| entry).filter(|entry| *entry <= negligible).sum::<f64>()
    });
    let neglected = neglected.fold(0.0, f64::max);
    let mut sums = vec![0.0; count];
    for block in blocks.iter().rev() {
        let later = |own: &usize| -> f64 {
            let entries = row(*own).filter(|(_, entry)| *entry > negligible);
            1.0 + entries.map(|(column, entry)| entry * sums[column]).sum::<f64>()
        };
        let right = DVector::from_iterator(block.len(), block.iter().map(later));
        let system = DMatrix::from_fn(block.len(), block.len(), |i, j| {
            f64::from(u8::from(i == j)) - matrix[block[i] * count + block[j]]
        });
        let solution = system.lu().solve(&right)?;
        block.iter().zip(&solution).for_each(|(own, sum)| sums[*own] = *sum);
    }
    let inverse = sums.iter().copied().fold(0.0, f64::max);
    (inverse * neglected < 1.0).then_some(bound)
}

/// Computes the bound by inverse iteration with the bound as the shift, starting from the
/// extrapolated eigenvector, for many interfaces after power iterations. The iteration keeps the
/// vector positive and converges quadratically if every interface influences every other one (Noda
/// 1971).
///
/// # Errors
/// Returns the least bound of all iterates if lower and upper bound do not converge to each other.
fn bound_by_inverse_iteration(
    matrix: &[f64],
    count: usize,
    workspace: &mut RadiusWorkspace,
) -> Result<f64, f64> {
    let RadiusWorkspace { known, solution: x, product, shifted, accepted, .. } = workspace;
    let width = blocks_of(count);
    let mut best = f64::INFINITY;
    let is_known = known.predict(count, x) && x.iter().all(|x| *x > LEAST);
    if !is_known {
        known.forget();
        x.clear();
        x.resize(count, 1.0);
    }
    let powers = if count < LARGE { 0 } else { POWERS };
    for step in 0..powers + INVERSE {
        let (mut least, mut greatest, mut largest) = (f64::INFINITY, 0.0_f64, 0.0_f64);
        product.clear();
        for (row, own) in matrix.chunks_exact(count).zip(x.iter()) {
            let sum = dot_by_four(row, x);
            let ratio = sum / own;
            (least, greatest, largest) = (least.min(ratio), greatest.max(ratio), largest.max(sum));
            product.push(sum);
        }
        let has_converged = greatest - least <= CONVERGED * greatest;
        if has_converged || greatest <= *accepted {
            if !has_converged {
                // Only converged vectors are smooth along the motion.
                known.forget();
            }
            known.add(x);
            return Ok(greatest);
        }
        best = best.min(greatest);
        if step < powers {
            if !product.iter().all(|sum| *sum > LEAST * largest) {
                break;
            }
            x.iter_mut().zip(&*product).for_each(|(x, sum)| *x = sum / largest);
            continue;
        }
        shifted.clear();
        shifted.resize(width * count, Four::zero());
        for (k, (row, entries)) in
            shifted.chunks_exact_mut(width).zip(matrix.chunks_exact(count)).enumerate()
        {
            for (l, entry) in entries.iter().enumerate() {
                row[l / 4].0[l % 4] = -entry;
            }
            row[k / 4].0[k % 4] += greatest;
        }
        if solve_in_place(shifted, x).is_none() {
            break;
        }
        let largest = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let sign = if x[0] < 0.0 { -1.0 } else { 1.0 };
        x.iter_mut().for_each(|x| *x *= sign / largest);
        // Some component is not positive because of round-off close to the eigenvalue, or because
        // the matrix decouples.
        if !x.iter().all(|x| *x > LEAST) {
            break;
        }
    }
    known.forget();
    Err(best)
}

/// Computes a scalar product with four partial sums.
fn dot_by_four(a: &[f64], b: &[f64]) -> f64 {
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        (0..4).for_each(|k| sums[k] += a[k] * b[k]);
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Performs one damped power iteration. The new vector is the product of matrix and vector,
/// normalised and weighted by `part`, plus the previous vector weighted by `1 - part`. Returns the
/// largest ratio of a component of the product to the same component of the previous vector.
fn power_step(columns: &[Four], count: usize, x: &mut [Four], next: &mut [Four], part: f64) -> f64 {
    next.fill(Four::zero());
    for (k, column) in columns.chunks_exact(x.len()).enumerate() {
        let amount = Four::from_f64(x[k / 4].0[k % 4]);
        next.iter_mut().zip(column).for_each(|(next, entries)| *next += *entries * amount);
    }
    let (mut ratio, mut largest) = (0.0_f64, f64::MIN_POSITIVE);
    for k in 0..count {
        let (next, x) = (next[k / 4].0[k % 4], x[k / 4].0[k % 4]);
        let own = next / x;
        ratio = if own > ratio { own } else { ratio };
        largest = if next > largest { next } else { largest };
    }
    // Damping and a positive lower bound keep the vector positive for any matrix.
    let [kept, added, least] = [1.0 - part, part / largest, 1e-12].map(Four::from_f64);
    for (x, next) in x.iter_mut().zip(next.iter()) {
        *x = kept * *x + added * *next + least;
    }
    ratio
}

#[cfg(test)]
mod tests {
    fn radius_bound(matrix: &[f64]) -> f64 {
        super::radius_bound(matrix, matrix.len().isqrt(), &mut Default::default())
    }

    /// Checks the bound of a large matrix whose blocks influence only earlier blocks, except for
    /// round-off, against the spectral radii of the blocks from dense eigenvalues.
    #[test]
    fn the_bound_of_a_block_triangular_matrix_is_that_of_a_block() {
        let (size, blocks) = (5, 12);
        let count = size * blocks;
        let mut random = crate::random::Random::new(5);
        let matrix: Vec<f64> = (0..count * count)
            .map(|k| {
                let own = 0.1 * random.number().abs();
                if k / count / size <= k % count / size { own } else { 1e-17 * own }
            })
            .collect();
        let radii = (0..blocks).map(|block| {
            let entry = |i, j| matrix[(size * block + i) * count + size * block + j];
            let values = nalgebra::DMatrix::from_fn(size, size, entry).complex_eigenvalues();
            values.iter().map(|value| value.norm()).fold(0.0, f64::max)
        });
        let radius = radii.fold(0.0, f64::max);
        let bound = radius_bound(&matrix);
        assert!((bound / radius - 1.0).abs() < 1e-12, "{bound} {radius}");
    }

    /// Checks that tiny entries are not neglected if a long cycle of large entries amplifies them.
    #[test]
    fn tiny_entries_in_a_strong_cycle_count() {
        let count = 40;
        let mut matrix = vec![0.0; count * count];
        for row in 0..count {
            matrix[row * count + (row + 1) % count] = 3.0;
        }
        matrix[(count - 1) * count] = 2e-14;
        let radius = 3.0 * (2e-14_f64 / 3.0).powf(1.0 / count as f64);
        let bound = radius_bound(&matrix);
        assert!(radius > 1.0 && bound >= radius, "{bound} {radius}");
    }

    /// Checks the bound by inverse iteration against the spectral radius from dense eigenvalues,
    /// for a sequence of slowly changing matrices. Also checks the bound for a matrix that
    /// decouples.
    #[test]
    fn inverse_iteration_agrees_with_dense_eigenvalues() {
        use super::{RadiusWorkspace, bound_by_inverse_iteration};
        use crate::random::Random;
        let mut random = Random::new(7);
        let count = 9;
        let base: Vec<f64> = (0..count * count).map(|_| random.number().abs() * 0.1).collect();
        let mut workspace = RadiusWorkspace::default();
        for step in 0..50 {
            let matrix: Vec<f64> = base
                .iter()
                .enumerate()
                .map(|(k, b)| b * (1.0 + 0.01 * f64::from(step * k as i32 % 7)))
                .collect();
            let found = bound_by_inverse_iteration(&matrix, count, &mut workspace).unwrap();
            // The bound agrees with the spectral radius to round-off.
            let dense = nalgebra::DMatrix::from_row_slice(count, count, &matrix);
            let radius = dense.complex_eigenvalues().iter().fold(0.0_f64, |m, z| m.max(z.norm()));
            assert!((found - radius).abs() <= 1e-13 * radius, "{found} {radius}");
        }
        let decoupled = [0.5, 0.0, 0.0, 0.2];
        assert!((radius_bound(&decoupled) - 0.5).abs() < 1e-9);
    }

    /// Many interfaces: power iterations converge; if two groups decouple, inverse or damped
    /// iterations follow.
    #[test]
    fn bounds_of_many_interfaces_agree_with_dense_eigenvalues() {
        use crate::random::Random;
        let count = 50;
        for decouples in [false, true] {
            let mut random = Random::new(2);
            let entry = |k: usize| {
                let is_beside = (k / count < 20) != (k % count < 20);
                let entry = random.number().abs() * 0.03;
                if decouples && is_beside { 0.0 } else { entry }
            };
            let matrix: Vec<f64> = (0..count * count).map(entry).collect();
            let dense = nalgebra::DMatrix::from_row_slice(count, count, &matrix);
            let radius = dense.complex_eigenvalues().iter().fold(0.0_f64, |m, z| m.max(z.norm()));
            let found = radius_bound(&matrix);
            let error = if decouples { 1e-9 } else { 1e-12 };
            assert!(
                found >= radius * (1.0 - 1e-13) && found <= radius * (1.0 + error),
                "{found} {radius}"
            );
        }
    }

    #[test]
    fn bounds_are_near_the_radius_and_never_below() {
        let rotation = [0.0, 0.5, 0.5, 0.0];
        let nilpotent = [0.0, 3.0, 0.0, 0.0];
        let mixed = [0.1, 0.2, 0.3, 0.2];
        // Undamped power iterations alternate between two vectors with the same ratio.
        let alternating = [0.0, 3.6, 0.225, 0.0];
        assert!((radius_bound(&alternating) - 0.9).abs() < 1e-9);
        assert!((radius_bound(&rotation) - 0.5).abs() < 1e-9);
        assert!(radius_bound(&nilpotent) < 0.1);
        assert!((radius_bound(&mixed) - 0.4).abs() < 1e-6 && radius_bound(&mixed) >= 0.4 - 1e-15);
        assert_eq!(radius_bound(&[]), 0.0);
    }
}
