//! Finite Fourier series whose periods begin and end at rest.
//!
//! The theory is in equation (X1) of the book:
//! `q(t) = c + sum a_k sin(k w t) + b_k (cos(k w t) - 1)` with `sum k a_k = 0` and
//! `sum k^2 b_k = 0`. At the ends of a period the position is therefore `c`, and rate and
//! acceleration vanish. The motion contains no frequency above the highest harmonic, and successive
//! periods join smoothly.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Fourier series of one coordinate as a linear function of its free coefficients.
#[derive(Clone, Debug)]
pub(super) struct Series {
    /// Angular frequency of the first harmonic, rad/s.
    omega: f64,
    /// Matrix from the free coefficients to the coefficients `a` of the sines; its columns are
    /// orthonormal.
    sines: DMatrix<f64>,
    /// Matrix from the free coefficients to the coefficients `b` of the cosines; its columns are
    /// orthonormal.
    cosines: DMatrix<f64>,
}

/// Factors of the free coefficients in the position, the rate and the acceleration of a coordinate
/// at one time.
pub(super) type Factors = [DVector<f64>; 3];

impl Series {
    /// Creates a series with `frequency`, Hz, of the first harmonic and at least two harmonics.
    pub(super) fn new(frequency: f64, harmonics: usize) -> Self {
        let weights = |power: i32| {
            DVector::from_fn(harmonics, |k, _| ((k + 1) as f64).powi(power)).normalize()
        };
        Self {
            omega: TAU * frequency,
            sines: orthogonal_to(&weights(1)),
            cosines: orthogonal_to(&weights(2)),
        }
    }

    /// Returns the number of free coefficients of one coordinate.
    pub(super) fn free(&self) -> usize {
        self.sines.ncols() + self.cosines.ncols()
    }

    /// Returns the factors of the free coefficients at `time`, s.
    pub(super) fn factors(&self, time: f64) -> Factors {
        let count = self.sines.nrows();
        let derivative = |order: i32| {
            let each = |k: usize| {
                let w = (k + 1) as f64 * self.omega;
                let (sin, cos) = (w * time).sin_cos();
                match order {
                    0 => (sin, cos - 1.0),
                    1 => (w * cos, -w * sin),
                    _ => (-w * w * sin, -w * w * cos),
                }
            };
            let sines = self.sines.tr_mul(&DVector::from_fn(count, |k, _| each(k).0));
            let cosines = self.cosines.tr_mul(&DVector::from_fn(count, |k, _| each(k).1));
            DVector::from_iterator(self.free(), sines.iter().chain(cosines.iter()).copied())
        };
        [derivative(0), derivative(1), derivative(2)]
    }

    /// Returns the coefficients of the sines and of the cosines that follow from the free
    /// coefficients.
    pub(super) fn coefficients(&self, free: &[f64]) -> [Vec<f64>; 2] {
        let (first, second) = free.split_at(self.sines.ncols());
        let of = |basis: &DMatrix<f64>, part: &[f64]| {
            (basis * DVector::from_column_slice(part)).as_slice().to_vec()
        };
        [of(&self.sines, first), of(&self.cosines, second)]
    }
}

/// Returns an orthonormal basis of all vectors orthogonal to a unit vector, by a Householder
/// reflection.
fn orthogonal_to(unit: &DVector<f64>) -> DMatrix<f64> {
    let count = unit.len();
    let mut normal = unit.clone();
    normal[0] += 1.0;
    let square = normal.norm_squared();
    DMatrix::from_fn(count, count - 1, |row, column| {
        let identity = if row == column + 1 { 1.0 } else { 0.0 };
        identity - 2.0 * normal[row] * normal[column + 1] / square
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that every period begins and ends at rest at the centre for any free coefficients,
    /// and that rates and accelerations are the derivatives of the positions.
    #[test]
    fn periods_begin_and_end_at_rest() {
        let series = Series::new(0.4, 5);
        assert_eq!(series.free(), 8);
        let free = DVector::from_fn(8, |k, _| (1.3 * k as f64 + 0.2).sin());
        let at = |t: f64| series.factors(t).map(|factors| factors.dot(&free));
        for t in [0.0, 2.5, 5.0] {
            // The tolerance covers the rounding errors of accelerations, which are sums of about
            // 100 terms.
            assert!(at(t).iter().all(|x| x.abs() < 1e-11), "{:?}", at(t));
        }
        let h = 1e-4;
        for t in [0.3, 1.1, 2.2] {
            let [before, now, after] = [at(t - h), at(t), at(t + h)];
            // The error of central differences is h^2/6 times the third derivative, which is below
            // 1e4.
            for k in 0..2 {
                let slope = (after[k] - before[k]) / (2.0 * h);
                assert!((slope - now[k + 1]).abs() < 1e-4 * (1.0 + now[k + 1].abs()), "{t} {k}");
            }
        }
        // The sum of sines and cosines equals the position from the free coefficients.
        let [a, b] = series.coefficients(free.as_slice());
        let w = |k: usize| TAU * 0.4 * (k + 1) as f64 * 1.1;
        let sum: f64 = (0..5).map(|k| a[k] * w(k).sin() + b[k] * (w(k).cos() - 1.0)).sum();
        assert!((sum - at(1.1)[0]).abs() < 1e-12);
    }
}
