//! Fixed-point iteration on the normal loads, accelerated by Anderson's method.
//!
//! Each iteration computes the normal loads for given friction by one solution of the equations of
//! motion, without an influence matrix. If its map is a contraction, the iteration converges to the
//! solution on the branch that begins at zero friction; otherwise Newton's method is used.

use crate::linalg::largest;

/// Largest number of iterations.
const STEPS: usize = 16;
/// The iteration has converged if the relative change of the loads is below this value.
const SETTLED: f64 = 1e-14;
/// Once the changes of the loads stop decreasing, a relative change below this value counts as
/// round-off.
const STAGNATED: f64 = 1e-12;
/// The map counts as a contraction up to this ratio of the change of `map(x)` to the change of `x`.
/// The determinant of the coupled system is then positive. The distance to 1 is a margin for
/// directions that the iteration has not explored.
const CONTRACTS: f64 = 0.5;
/// Number of earlier iterations that Anderson's method combines.
const MEMORY: usize = 3;

/// Buffers of the fixed-point iteration.
#[derive(Clone, Debug, Default)]
pub(crate) struct FixedPoint {
    mapped: Vec<f64>,
    residual: Vec<f64>,
    /// Normal loads and residual of the previous iteration.
    before: (Vec<f64>, Vec<f64>),
    /// Changes of the normal loads in the latest iterations, one vector per iteration.
    points: Vec<Vec<f64>>,
    /// Changes of the residual in the latest iterations, one vector per iteration.
    residuals: Vec<Vec<f64>>,
}

impl FixedPoint {
    /// Solves `x = map(x)` to a relative error of `tolerance`, or to round-off if that is larger,
    /// starting from `x`, which becomes the solution. Returns `false` if the
    /// map does not contract along the iteration, or if the iteration does not converge. After a
    /// success, the last argument of `map` agrees with the solution up to the tolerance.
    pub(crate) fn solve(
        &mut self,
        x: &mut Vec<f64>,
        tolerance: f64,
        mut map: impl FnMut(&[f64], &mut Vec<f64>),
    ) -> bool {
        let Self { mapped, residual, before, points, residuals } = self;
        let mut used = 0;
        let mut smallest = f64::INFINITY;
        for step in 0..STEPS {
            map(x, mapped);
            residual.clear();
            residual.extend(mapped.iter().zip(&*x).map(|(f, x)| f - x));
            let (change, size) = (largest(residual), largest(mapped));
            if !(change.is_finite() && size.is_finite()) {
                return false;
            }
            let settled = change <= SETTLED.max(tolerance) * size;
            let stagnates = change >= 0.5 * smallest && change <= STAGNATED * size;
            if settled || stagnates {
                x.clone_from(mapped);
                return true;
            }
            smallest = smallest.min(change);
            if step > 0 {
                // Changes of `x` and of the residual since the previous iteration.
                let place = (step - 1) % MEMORY;
                used = used.max(place + 1);
                points.resize_with(MEMORY, Vec::new);
                residuals.resize_with(MEMORY, Vec::new);
                difference(&mut points[place], x, &before.0);
                difference(&mut residuals[place], residual, &before.1);
                // The change of `map(x)` is the sum of the changes of `x` and of the residual.
                let moved = points[place].iter().zip(&residuals[place]);
                let mapped = moved.fold(0.0_f64, |m, (p, r)| m.max((p + r).abs()));
                if mapped > CONTRACTS * largest(&points[place]) && change > STAGNATED * size {
                    return false;
                }
            }
            before.0.clone_from(x);
            before.1.clone_from(residual);
            let amounts = least_squares(&residuals[..used], residual);
            x.iter_mut().zip(&*residual).for_each(|(x, r)| *x += r);
            for ((point, change), amount) in points.iter().zip(&*residuals).zip(&amounts[..used]) {
                let moved = point.iter().zip(change);
                x.iter_mut().zip(moved).for_each(|(x, (p, r))| *x -= amount * (p + r));
            }
        }
        false
    }
}

fn difference(to: &mut Vec<f64>, a: &[f64], b: &[f64]) {
    to.clear();
    to.extend(a.iter().zip(b).map(|(a, b)| a - b));
}

/// Computes the coefficients of the linear combination of `vectors` that is nearest to `right`.
/// Linearly dependent vectors get the coefficient zero.
fn least_squares(vectors: &[Vec<f64>], right: &[f64]) -> [f64; MEMORY] {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let count = vectors.len();
    let mut matrix = [[0.0; MEMORY]; MEMORY];
    let mut amounts = [0.0; MEMORY];
    for (i, a) in vectors.iter().enumerate() {
        for (j, b) in vectors[..=i].iter().enumerate() {
            matrix[i][j] = product(a, b);
        }
        amounts[i] = product(a, right);
    }
    // Cholesky decomposition of the Gram matrix. It squares the condition number of the vectors;
    // the next iteration removes the resulting error.
    let mut kept = [true; MEMORY];
    for i in 0..count {
        for j in 0..i {
            let sum: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            matrix[i][j] = if kept[j] { (matrix[i][j] - sum) / matrix[j][j] } else { 0.0 };
        }
        let sum: f64 = (0..i).map(|k| matrix[i][k] * matrix[i][k]).sum();
        kept[i] = matrix[i][i] - sum > 1e-10 * matrix[i][i];
        matrix[i][i] = if kept[i] { (matrix[i][i] - sum).sqrt() } else { 1.0 };
        let sum: f64 = (0..i).map(|k| matrix[i][k] * amounts[k]).sum();
        amounts[i] = if kept[i] { (amounts[i] - sum) / matrix[i][i] } else { 0.0 };
    }
    for i in (0..count).rev() {
        let sum: f64 = (i + 1..count).map(|k| matrix[k][i] * amounts[k]).sum();
        amounts[i] = if kept[i] { (amounts[i] - sum) / matrix[i][i] } else { 0.0 };
    }
    amounts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates an affine map that scales by the given factors along rotated axes.
    fn map(factors: [f64; 3]) -> impl Fn(&[f64], &mut Vec<f64>) {
        move |x: &[f64], out: &mut Vec<f64>| {
            let (a, b) = (0.6 * x[0] + 0.8 * x[1], -0.8 * x[0] + 0.6 * x[1]);
            let (a, b, c) = (factors[0] * a, factors[1] * b, factors[2] * x[2]);
            out.clear();
            out.extend([1.0 + 0.6 * a - 0.8 * b, 2.0 + 0.8 * a + 0.6 * b, 3.0 + c]);
        }
    }

    #[test]
    fn contractions_are_solved() {
        for factors in [[0.0, 0.0, 0.0], [0.3, -0.2, 0.1], [0.4, 0.4, -0.4]] {
            let (mut x, mut out) = (vec![1.0; 3], Vec::new());
            let map = map(factors);
            assert!(FixedPoint::default().solve(&mut x, 0.0, &map));
            map(&x, &mut out);
            let apart = x.iter().zip(&out).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(apart < 1e-13, "{factors:?}: {apart:e}");
        }
    }

    /// Checks that the last evaluation of the map is at the solution, even if all loads vanish.
    #[test]
    fn vanishing_loads_are_evaluated() {
        let (mut x, mut last) = (vec![1.0; 3], Vec::new());
        let solved = FixedPoint::default().solve(&mut x, 0.0, |x, out| {
            last = x.to_vec();
            out.clear();
            out.extend([0.0; 3]);
        });
        assert!(solved);
        assert_eq!((&x, &last), (&vec![0.0; 3], &vec![0.0; 3]));
    }

    /// Checks that a map that does not contract is rejected. Anderson's method would find a
    /// solution, but not on the branch that begins at zero friction.
    #[test]
    fn other_maps_are_refused() {
        assert!(!FixedPoint::default().solve(&mut vec![1.0; 3], 0.0, map([3.0, 0.1, 0.1])));
    }
}
