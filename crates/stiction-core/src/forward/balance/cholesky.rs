//! Cholesky decomposition of the mass matrix projected onto the motions that the constraints allow,
//! including motions without inertia.

use super::{dot, fill};
use crate::scalar::Scalar;

/// The inertia of a motion counts as round-off if it is below this fraction of the largest inertia
/// among the basis motions.
const NEGLIGIBLE: f64 = 1e-14;

/// Returns the Cholesky factor of `Z^T M Z`. `matrix` is the mass matrix `M`, `n` by `n`,
/// row-major; `basis` contains the columns of `Z`, `n` numbers each, one after the other. Pivoting
/// reorders these columns so that motions without inertia come last, where round-off does not hide
/// small pivots. If `may_lack_inertia` accepts a motion without inertia, the motion is appended to
/// `spins` and assigned an arbitrary inertia; its rate then stays constant as long as no load acts
/// on it.
///
/// # Errors
/// Returns the rates of a motion without inertia that `may_lack_inertia` rejects.
pub(in crate::forward) fn factor(
    matrix: &[f64],
    basis: &mut [f64],
    n: usize,
    may_lack_inertia: &dyn Fn(&[f64]) -> bool,
    spins: &mut Vec<Vec<f64>>,
) -> Result<Vec<f64>, Vec<f64>> {
    let mut factor = Vec::new();
    factor_into(matrix, basis, n, may_lack_inertia, (spins, &mut Vec::new(), &mut factor))?;
    Ok(factor)
}

/// Computes the Cholesky factor like [`factor`], reusing the buffers, and writes the momenta `M Z`
/// to `momenta`.
///
/// # Errors
/// See [`factor`].
pub(super) fn factor_into(
    matrix: &[f64],
    basis: &mut [f64],
    n: usize,
    may_lack_inertia: &dyn Fn(&[f64]) -> bool,
    (spins, momenta, factor): (&mut Vec<Vec<f64>>, &mut Vec<f64>, &mut Vec<f64>),
) -> Result<(), Vec<f64>> {
    let n = n.max(1);
    let free = basis.len() / n;
    momenta.clear();
    for z in basis.chunks_exact(n) {
        momenta.extend(matrix.chunks_exact(n).map(|row| dot(row, z)));
    }
    fill(factor, free * free, 0.0);
    for (i, momentum) in momenta.chunks_exact(n).enumerate() {
        for (j, other) in basis.chunks_exact(n).enumerate().skip(i) {
            let entry = dot(momentum, other);
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
                momenta.swap(i * n + k, other * n + k);
            }
        }
        let rest = factor[i * free + i];
        if rest > NEGLIGIBLE * largest {
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
        // The motion without inertia is this basis vector minus its inertial coupling to the
        // preceding basis vectors.
        let mut with: Vec<f64> = (0..i).map(|k| factor[i * free + k]).collect();
        for k in (0..i).rev() {
            let after: f64 = (k + 1..i).map(|m| factor[m * free + k] * with[m]).sum();
            with[k] = (with[k] - after) / factor[k * free + k];
        }
        let mut rates = basis[i * n..(i + 1) * n].to_vec();
        for (vector, amount) in basis.chunks_exact(n).zip(&with) {
            rates.iter_mut().zip(vector).for_each(|(r, z)| *r -= amount * z);
        }
        if !may_lack_inertia(&rates) {
            return Err(rates);
        }
        spins.push(rates);
        factor[i * free + i] = if largest > 0.0 { largest.sqrt() } else { 1.0 };
        for j in i + 1..free {
            factor[j * free + i] = 0.0;
        }
    }
    Ok(())
}

/// Solves `L L^T x = right` in place, where `factor` is the lower triangle `L`.
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
