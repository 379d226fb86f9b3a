//! Cholesky's decomposition of the mass matrix of what can move, of which some may have no inertia.

use super::{dot, fill};
use crate::scalar::Scalar;

/// Inertia along a freedom below this part of the largest is rounding.
const NOTHING: f64 = 1e-14;

/// Cholesky's factor of `Z^T M Z`, the vectors of `basis` put in an order in which what moves without inertia comes
/// last: without it small pivots on the way would hide it in rounding. Motions without inertia that `may` be are put
/// into `idle` and given some: what does not act on them does not move them then.
///
/// # Errors
/// The rates of a motion without inertia that may not be.
pub(in crate::forward) fn factor(
    matrix: &[f64],
    basis: &mut [f64],
    n: usize,
    may: &dyn Fn(&[f64]) -> bool,
    idle: &mut Vec<Vec<f64>>,
) -> Result<Vec<f64>, Vec<f64>> {
    let mut factor = Vec::new();
    factorise(matrix, basis, n, may, (idle, &mut Vec::new(), &mut factor))?;
    Ok(factor)
}

/// The same in the room that is there; `moved` becomes `M Z`.
pub(super) fn factorise(
    matrix: &[f64],
    basis: &mut [f64],
    n: usize,
    may: &dyn Fn(&[f64]) -> bool,
    (idle, moved, factor): (&mut Vec<Vec<f64>>, &mut Vec<f64>, &mut Vec<f64>),
) -> Result<(), Vec<f64>> {
    let n = n.max(1);
    let free = basis.len() / n;
    moved.clear();
    for z in basis.chunks_exact(n) {
        moved.extend(matrix.chunks_exact(n).map(|row| dot(row, z)));
    }
    fill(factor, free * free, 0.0);
    for (i, moved) in moved.chunks_exact(n).enumerate() {
        for (j, other) in basis.chunks_exact(n).enumerate().skip(i) {
            let entry = dot(moved, other);
            factor[j * free + i] = entry;
            factor[i * free + j] = entry;
        }
    }
    let largest = (0..free).map(|i| factor[i * free + i]).fold(0.0, f64::max);
    for i in 0..free {
        let heaviest = (i..free).max_by(|a, b| {
            let rest = |k: &usize| factor[k * free + k];
            rest(a).total_cmp(&rest(b))
        });
        if let Some(other) = heaviest.filter(|k| *k != i) {
            for k in 0..free {
                factor.swap(i * free + k, other * free + k);
            }
            for k in i..free {
                factor.swap(k * free + i, k * free + other);
            }
            for k in 0..n {
                basis.swap(i * n + k, other * n + k);
                moved.swap(i * n + k, other * n + k);
            }
        }
        let rest = factor[i * free + i];
        if rest > NOTHING * largest {
            let root = rest.sqrt();
            factor[i * free + i] = root;
            for j in i + 1..free {
                factor[j * free + i] /= root;
            }
            for j in i + 1..free {
                let own = factor[j * free + i];
                for k in i + 1..=j {
                    let entry = factor[j * free + k] - own * factor[k * free + i];
                    factor[j * free + k] = entry;
                    factor[k * free + j] = entry;
                }
            }
            continue;
        }
        // The motion itself: this vector less what those before must do along with it.
        let mut with: Vec<f64> = (0..i).map(|k| factor[i * free + k]).collect();
        for k in (0..i).rev() {
            let after: f64 = (k + 1..i).map(|m| factor[m * free + k] * with[m]).sum();
            with[k] = (with[k] - after) / factor[k * free + k];
        }
        let mut rates = basis[i * n..(i + 1) * n].to_vec();
        for (vector, amount) in basis.chunks_exact(n).zip(&with) {
            rates.iter_mut().zip(vector).for_each(|(r, z)| *r -= amount * z);
        }
        if !may(&rates) {
            return Err(rates);
        }
        idle.push(rates);
        factor[i * free + i] = if largest > 0.0 { largest.sqrt() } else { 1.0 };
        for j in i + 1..free {
            factor[j * free + i] = 0.0;
        }
    }
    Ok(())
}

pub(in crate::forward) fn solve_factored<T: Scalar>(factor: &[f64], right: &mut [T]) {
    let free = right.len();
    for i in 0..free {
        let mut sum = right[i];
        for k in 0..i {
            sum -= right[k] * T::from_f64(factor[i * free + k]);
        }
        right[i] = sum / T::from_f64(factor[i * free + i]);
    }
    for i in (0..free).rev() {
        let mut sum = right[i];
        for k in i + 1..free {
            sum -= right[k] * T::from_f64(factor[k * free + i]);
        }
        right[i] = sum / T::from_f64(factor[i * free + i]);
    }
}
