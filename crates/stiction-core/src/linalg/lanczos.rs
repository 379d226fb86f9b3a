//! Largest eigenvalue of a symmetric operator and the corresponding eigenvector, by the Lanczos
//! method.

use super::block::{BLOCK, Part};

/// Usual maximum number of Lanczos steps.
pub(crate) const STEPS: usize = 120;
/// Maximum number of Lanczos steps if many eigenvalues may be close to the largest one, as with many
/// similar legs.
pub(crate) const MANY_STEPS: usize = 1500;
/// Number of steps after which convergence is first checked, unless an earlier residual is small.
const FIRST_LOOK: usize = 2;

/// Buffers of the Lanczos method.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lanczos {
    /// Orthonormal basis vectors of all Lanczos steps, one after the other.
    basis: Vec<Part>,
    next: Vec<Part>,
    diagonal: Vec<f64>,
    beside: Vec<f64>,
    room: Room,
}

/// Buffers of [`vector_of`].
#[derive(Clone, Debug, Default)]
struct Room {
    ahead: Vec<f64>,
    back: Vec<f64>,
    vector: Vec<f64>,
}

impl Lanczos {
    /// Computes the eigenvector of the largest eigenvalue of a symmetric positive semidefinite
    /// operator. `apply` applies the operator in place; the iteration begins with `start`. Returns
    /// `None` if the iteration does not converge within `most` steps.
    ///
    /// `accuracy` is the residual at convergence, relative to the eigenvalue. The relative error of
    /// the eigenvalue never exceeds `accuracy`, and is usually of the order of its square.
    pub(crate) fn greatest(
        &mut self,
        start: impl Iterator<Item = Part>,
        (accuracy, most): (f64, usize),
        mut apply: impl FnMut(&mut [Part]),
    ) -> Option<&[Part]> {
        let Self { basis, next, diagonal, beside, room } = self;
        basis.clear();
        diagonal.clear();
        beside.clear();
        basis.extend(start);
        let count = basis.len();
        let over = 1.0 / dot(basis, basis).sqrt();
        scale(basis, over);
        // Upper bound on the largest eigenvalue of the current tridiagonal matrix.
        let mut above = 0.0_f64;
        for step in 0..most {
            let here = step * count;
            next.clear();
            next.extend_from_slice(&basis[here..]);
            apply(next);
            let own = dot(next, &basis[here..]);
            diagonal.push(own);
            // Round-off destroys the orthogonality of the vectors, and copies of eigenvalues
            // appear; the largest eigenvalue and its residual remain accurate (Paige 1972).
            for k in step.saturating_sub(1)..=step {
                let before = &basis[k * count..(k + 1) * count];
                let amount = dot(next, before);
                subtract(next, before, amount);
            }
            let length = dot(next, next).sqrt();
            if !length.is_finite() {
                return None;
            }
            above = match beside.last() {
                None => own,
                // Largest eigenvalue of a 2x2 matrix that bounds the tridiagonal matrix.
                Some(coupling) => 0.5 * (above + own) + (0.5 * (above - own)).hypot(*coupling),
            };
            if step + 1 >= FIRST_LOOK || length <= accuracy * own {
                let value = greatest_root(diagonal, beside, above);
                above = value;
                let tail = vector_of(diagonal, beside, value, room);
                if length * tail <= accuracy * value {
                    // The image of the eigenvector, divided by the eigenvalue, is more accurate.
                    let part = if value > 0.0 { room.vector[step] / value } else { 0.0 };
                    scale(next, part);
                    for (k, amount) in room.vector.iter().enumerate() {
                        subtract(next, &basis[k * count..(k + 1) * count], -amount);
                    }
                    return Some(next);
                }
            }
            beside.push(length);
            scale(next, 1.0 / length);
            basis.extend_from_slice(next);
        }
        None
    }
}

fn dot(a: &[Part], b: &[Part]) -> f64 {
    let mut sums = [0.0; BLOCK];
    for (a, b) in a.iter().zip(b) {
        for i in 0..BLOCK {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum()
}

fn scale(vector: &mut [Part], by: f64) {
    vector.iter_mut().flatten().for_each(|x| *x *= by);
}

fn subtract(from: &mut [Part], vector: &[Part], amount: f64) {
    for (from, part) in from.iter_mut().zip(vector) {
        for i in 0..BLOCK {
            from[i] -= amount * part[i];
        }
    }
}

/// Computes the largest eigenvalue of a symmetric tridiagonal matrix with the diagonal `diagonal`
/// and the off-diagonal `beside`. `above` is an upper bound, from which Newton's method on the
/// characteristic polynomial decreases monotonically to the eigenvalue.
fn greatest_root(diagonal: &[f64], beside: &[f64], above: f64) -> f64 {
    // Rounding may reduce `above` slightly below the eigenvalue if the two are equal.
    let mut x = above * (1.0 + 4.0 * f64::EPSILON);
    for _ in 0..100 {
        // The characteristic polynomial is the product of these factors, which are positive above
        // its largest root.
        let (mut factor, mut slope, mut sum) = (f64::INFINITY, 0.0, 0.0);
        for (k, own) in diagonal.iter().enumerate() {
            let coupling = if k == 0 { 0.0 } else { beside[k - 1] * beside[k - 1] };
            let ratio = coupling / factor;
            slope = 1.0 + if k == 0 { 0.0 } else { ratio * slope / factor };
            factor = x - own - ratio;
            sum += slope / factor;
        }
        let step = 1.0 / sum;
        // Rounding may move `x` below the root, where the last factor is negative.
        if !(factor > 0.0 && step > 0.5 * f64::EPSILON * x) {
            break;
        }
        x -= step;
    }
    x
}

/// Computes the unit eigenvector of the largest eigenvalue `value` of a symmetric tridiagonal
/// matrix, stores it in `room.vector`, and returns the magnitude of its last component. Recurrences
/// run from both ends and meet near the largest component. Beyond this component the vector decays;
/// round-off errors decay as well only if the recurrence runs toward the largest component.
fn vector_of(diagonal: &[f64], beside: &[f64], value: f64, room: &mut Room) -> f64 {
    let count = diagonal.len();
    let Room { ahead, back, vector } = room;
    let over = |k: usize, factor: f64| beside[k] * beside[k] / factor;
    ahead.clear();
    back.clear();
    back.resize(count, 0.0);
    for k in 0..count {
        ahead.push(value - diagonal[k] - if k == 0 { 0.0 } else { over(k - 1, ahead[k - 1]) });
    }
    for k in (0..count).rev() {
        let after = if k + 1 == count { 0.0 } else { over(k, back[k + 1]) };
        back[k] = value - diagonal[k] - after;
    }
    let gap = |k: &usize| (ahead[*k] + back[*k] - (value - diagonal[*k])).abs();
    let meeting = (0..count).min_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap_or(0);
    vector.clear();
    vector.resize(count, 0.0);
    vector[meeting] = 1.0;
    for k in (0..meeting).rev() {
        vector[k] = vector[k + 1] * beside[k] / ahead[k];
    }
    for k in meeting + 1..count {
        vector[k] = vector[k - 1] * beside[k - 1] / back[k];
    }
    let over = 1.0 / vector.iter().map(|component| component * component).sum::<f64>().sqrt();
    vector.iter_mut().for_each(|component| *component *= over);
    vector[count - 1].abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Checks the largest eigenvalue, computed from the returned eigenvector, for spectra with
    /// close, double and distant eigenvalues.
    #[test]
    fn the_greatest_of_known_eigenvalues() {
        let mut random = Random::new(5);
        for gap in [0.5, 1e-3, 1e-7, 0.0] {
            let values: Vec<Part> = (0..9)
                .map(|k| core::array::from_fn(|i| 1.0 / (1.0 + (BLOCK * k + i) as f64)))
                .collect();
            let mut values = values;
            values[4][2] = 1.0 - gap;
            // The operator is diagonal in a basis that a reflection produces, so its eigenvectors
            // are known.
            let mut normal: Vec<Part> =
                (0..9).map(|_| core::array::from_fn(|_| random.number())).collect();
            let over = 1.0 / dot(&normal, &normal).sqrt();
            scale(&mut normal, over);
            let reflect = |x: &mut [Part]| {
                let amount = 2.0 * dot(x, &normal);
                subtract(x, &normal, amount);
            };
            let apply = |x: &mut [Part]| {
                reflect(x);
                x.iter_mut().flatten().zip(values.iter().flatten()).for_each(|(x, v)| *x *= v);
                reflect(x);
            };
            let start: Vec<Part> =
                (0..9).map(|_| core::array::from_fn(|_| random.number())).collect();
            let mut room = Lanczos::default();
            let vector = room.greatest(start.iter().copied(), (1e-12, STEPS), apply).unwrap();
            let mut image = vector.to_vec();
            apply(&mut image);
            let value = dot(&image, vector) / dot(vector, vector);
            // The tolerance equals the relative residual at which the iteration stops.
            assert!((value - 1.0).abs() < 1e-12, "{gap}: {value}");
        }
    }
}
