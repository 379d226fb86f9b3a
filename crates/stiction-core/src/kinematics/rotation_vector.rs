//! Rotation vectors (axis times angle) and their derivatives.
//!
//! Equation (K6) of the book's theory.

use super::coordinate::Target;
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Vec3};

impl Target<f64> {
    /// Computes the three components of the rotation vector of `rotation`, with their first and
    /// second time derivatives. The angular velocity `omega` (rad/s) and the angular acceleration
    /// `alpha` (rad/s^2) are given in the axes of the fixed frame.
    pub fn of_rotation(rotation: Mat3<f64>, omega: Vec3<f64>, alpha: Vec3<f64>) -> [Self; 3] {
        let vector = RotationVector::of(rotation);
        let matrix = vector.rate_matrix();
        let (value, rate) = (vector.value.to_array(), (matrix * omega).to_array());
        let acceleration = (matrix * alpha + vector.rate_matrix_change(omega) * omega).to_array();
        std::array::from_fn(|k| Self {
            value: value[k],
            rate: rate[k],
            acceleration: acceleration[k],
        })
    }
}

/// A rotation vector `r` of length `a`. For the angular velocity `omega`, the rate of the vector is
/// `r' = omega - r x omega / 2 + c r x (r x omega)`, with the coefficient
/// `c = 1/a^2 - (1 + cos a) / (2 a sin a)`.
pub(crate) struct RotationVector<T> {
    pub(crate) value: Vec3<T>,
    /// Coefficient `c` in the formula for the rate of the vector.
    coefficient: T,
    /// Derivative of the coefficient `c` divided by the length `a` of the vector, `(dc/da) / a`.
    slope: T,
}

impl<T: Scalar> RotationVector<T> {
    pub(crate) fn of(rotation: Mat3<T>) -> Self {
        let w = rotation.skew_part();
        let half = T::from_f64(0.5);
        let sine = w.norm();
        let angle = sine.atan2((rotation.trace() - T::one()) * half);
        // Power series near zero. At the angle 0.1, where the formulas switch, both are accurate
        // to 1e-13.
        let large = angle - T::from_f64(0.1);
        let safe = large.if_positive(angle, T::one());
        let (s, c) = safe.sin_cos();
        let a2 = safe * safe;
        let versine = T::one() + c;
        let closed = a2.recip() - versine * half / (safe * s);
        // `(dc/da) / a`, since the derivative of (1 + cos a)/sin a is -(1 + cos a)/sin^2 a.
        let closed_slope =
            T::from_f64(-2.0) / (a2 * a2) + versine * half * (s + safe) / (a2 * safe * s * s);
        let x = w.norm_squared();
        // Power series of a^2 and of a / sin a in x = sin^2 a.
        let asin2 = x * series(
            x,
            &[1.0, 1.0 / 3.0, 8.0 / 45.0, 4.0 / 35.0, 128.0 / 1575.0, 128.0 / 2079.0],
        );
        let ratio = series(
            x,
            &[
                1.0,
                1.0 / 6.0,
                3.0 / 40.0,
                15.0 / 336.0,
                105.0 / 3456.0,
                945.0 / 42240.0,
                10395.0 / 599_040.0,
            ],
        );
        let small = series(
            asin2,
            &[1.0 / 12.0, 1.0 / 720.0, 1.0 / 30_240.0, 1.0 / 1_209_600.0, 1.0 / 47_900_160.0],
        );
        let small_slope =
            series(asin2, &[1.0 / 360.0, 1.0 / 7560.0, 1.0 / 201_600.0, 1.0 / 5_987_520.0]);
        let safe_sine = large.if_positive(sine, T::one());
        Self {
            value: w * large.if_positive(angle / safe_sine, ratio),
            coefficient: large.if_positive(closed, small),
            slope: large.if_positive(closed_slope, small_slope),
        }
    }

    /// Returns the matrix `A` that maps the angular velocity to the rate of the vector, `r' = A
    /// omega`.
    pub(crate) fn rate_matrix(&self) -> Mat3<T> {
        self.matrix(|r, e| {
            e - r.cross(e) * T::from_f64(0.5) + r.cross(r.cross(e)) * self.coefficient
        })
    }

    /// Computes the time derivative of [`Self::rate_matrix`] at the angular velocity `omega`
    /// (rad/s).
    pub(super) fn rate_matrix_change(&self, omega: Vec3<T>) -> Mat3<T> {
        let rate = self.rate_matrix() * omega;
        let change = self.slope * self.value.dot(rate);
        self.matrix(|r, e| {
            (rate.cross(r.cross(e)) + r.cross(rate.cross(e))) * self.coefficient
                + r.cross(r.cross(e)) * change
                - rate.cross(e) * T::from_f64(0.5)
        })
    }

    fn matrix(&self, column: impl Fn(Vec3<T>, Vec3<T>) -> Vec3<T>) -> Mat3<T> {
        Mat3::from_columns(
            column(self.value, Vec3::unit(0)),
            column(self.value, Vec3::unit(1)),
            column(self.value, Vec3::unit(2)),
        )
    }
}

/// Evaluates a polynomial in `x`; the coefficients are in ascending powers.
fn series<T: Scalar>(x: T, coefficients: &[f64]) -> T {
    let mut sum = T::zero();
    for &coefficient in coefficients.iter().rev() {
        sum = sum * x + T::from_f64(coefficient);
    }
    sum
}

/// Prescribed orientation `exp(r)` with its angular velocity and acceleration. The length of the
/// prescribed vector `r` may exceed half a turn and even full turns. A rotation vector computed
/// from an orientation is at most half a turn long.
pub(super) struct Orientation<T> {
    /// Rotation matrix `exp(r)`.
    pub(super) rotation: Mat3<T>,
    /// Angular velocity, rad/s.
    pub(super) rate: Vec3<T>,
    /// Angular acceleration, rad/s^2.
    pub(super) acceleration: Vec3<T>,
}

impl<T: Scalar> Orientation<T> {
    /// Computes the orientation from a rotation vector and its first and second time derivatives.
    /// The angular velocity is `omega = r' + b r x r' + d r x (r x r')` with `a = |r|`, `b = (1 -
    /// cos a)/a^2`, `d = (a - sin a)/a^3`.
    pub(super) fn of(r: Vec3<T>, rate: Vec3<T>, acceleration: Vec3<T>) -> Self {
        let a2 = r.norm_squared();
        let number = T::from_f64;
        // Power series for `a^2` below 1, closed forms otherwise.
        let large = a2 - T::one();
        let safe2 = large.if_positive(a2, T::one());
        let a = safe2.norm_of_square();
        let (s, c) = a.sin_cos();
        let choose = |closed: T, terms: &[f64]| large.if_positive(closed, series(a2, terms));
        let over2 = safe2.recip();
        let sinc = choose(s / a, &SINC);
        let b = choose((T::one() - c) * over2, &B);
        let d = choose((a - s) * over2 / a, &D);
        // Derivatives of `b` and `d`, divided by `a`: `(db/da) / a` and `(dd/da) / a`.
        let b_slope = choose((a * s - (T::one() - c) * number(2.0)) * over2 * over2, &B_SLOPE);
        let d_slope =
            choose((s * number(3.0) - a * (c + number(2.0))) * over2 * over2 / a, &D_SLOPE);

        let column = |e: Vec3<T>| e + r.cross(e) * sinc + r.cross(r.cross(e)) * b;
        let rotation =
            Mat3::from_columns(column(Vec3::unit(0)), column(Vec3::unit(1)), column(Vec3::unit(2)));
        let apply = |v: Vec3<T>| v + r.cross(v) * b + r.cross(r.cross(v)) * d;
        let growth = r.dot(rate);
        let change = r.cross(rate) * (b_slope * growth)
            + r.cross(r.cross(rate)) * (d_slope * growth)
            + rate.cross(r.cross(rate)) * d;
        Self { rotation, rate: apply(rate), acceleration: apply(acceleration) + change }
    }
}

/// Coefficients `(-1)^n / (2n + 1)!` of the powers of `a^2` in the series of `sin a / a`. The
/// constants that follow contain those of `b`, `d` and their slopes in [`Orientation::of`].
const SINC: [f64; 9] = alternating(1, false);
const B: [f64; 9] = alternating(2, false);
const D: [f64; 9] = alternating(3, false);
const B_SLOPE: [f64; 9] = alternating(2, true);
const D_SLOPE: [f64; 9] = alternating(3, true);

/// Computes the series coefficients `(-1)^n / (2n + k)!`. If `slope` is set, computes the
/// coefficients of the derivative of the series divided by `a`: `(-1)^m 2m / (2m + k)!` with `m =
/// n + 1`.
const fn alternating(k: usize, slope: bool) -> [f64; 9] {
    let mut terms = [0.0; 9];
    let mut n = 0;
    while n < 9 {
        let m = if slope { n + 1 } else { n };
        let mut term = if m % 2 == 0 { 1.0 } else { -1.0 };
        if slope {
            term *= 2.0 * m as f64;
        }
        let mut factor = 2;
        while factor <= 2 * m + k {
            term /= factor as f64;
            factor += 1;
        }
        terms[n] = term;
        n += 1;
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Dual;
    use proptest::prelude::*;

    proptest! {
        /// Checks at `r(t) = r0 + r1 t` that the rate matrix times the angular velocity equals
        /// `r1`, and that `rate_matrix_change` equals the derivative of the rate matrix in dual
        /// numbers. The angular velocity follows from the rotation matrix in dual numbers.
        #[test]
        fn rotation_vector_rates_are_exact(
            r0 in prop::array::uniform3(-1.7..1.7f64),
            r1 in prop::array::uniform3(-1.0..1.0f64),
            shrink in prop::sample::select(vec![1.0, 0.1, 0.06, 0.05, 1e-3, 1e-8]),
        ) {
            let r0 = Vec3::from(r0) * shrink;
            let r1 = Vec3::from(r1);
            prop_assume!(r0.norm() < 3.0);
            type D = Dual<f64, 1>;
            let at = |t: D| Vec3::new(D::from_f64(r0.x), D::from_f64(r0.y), D::from_f64(r0.z))
                + Vec3::new(D::from_f64(r1.x), D::from_f64(r1.y), D::from_f64(r1.z)) * t;
            // `exp` is a power series, whose truncation error is negligible for vectors of this
            // length. The angular velocity follows from `R' R^T`.
            let exp = |r: Vec3<D>| {
                let column = |e: Vec3<D>| {
                    let (mut term, mut sum) = (e, e);
                    for n in 1..40 {
                        term = r.cross(term) * D::from_f64(1.0 / n as f64);
                        sum += term;
                    }
                    sum
                };
                Mat3::from_columns(column(Vec3::unit(0)), column(Vec3::unit(1)), column(Vec3::unit(2)))
            };
            let rotation = exp(at(D::variable(0.0, 0)));
            let value = Mat3 { columns: rotation.columns.map(|c| Vec3::new(c.x.value, c.y.value, c.z.value)) };
            let rate = Mat3 { columns: rotation.columns.map(|c| Vec3::new(c.x.slope[0], c.y.slope[0], c.z.slope[0])) };
            let omega = (rate * value.transpose()).skew_part();

            let vector = RotationVector::of(value);
            prop_assert!((vector.value - r0).norm() < 1e-12);
            let error = (vector.rate_matrix() * omega - r1).norm();
            prop_assert!(error < 1e-11, "rate {error:e}");

            // Evaluation with dual numbers differentiates the matrix.
            let dual = RotationVector::of(rotation).rate_matrix();
            let change = vector.rate_matrix_change(omega);
            for k in 0..3 {
                let c = dual.columns[k];
                let expected = Vec3::new(c.x.slope[0], c.y.slope[0], c.z.slope[0]);
                let error = (change.columns[k] - expected).norm();
                prop_assert!(error < 1e-9, "change {error:e} at {:e}", r0.norm());
            }
        }

        /// Checks the orientation, its angular velocity and its angular acceleration against the
        /// exponential series, for rotations up to more than a full turn.
        #[test]
        fn orientations_are_exact(
            r0 in prop::array::uniform3(-5.0..5.0f64),
            r1 in prop::array::uniform3(-1.0..1.0f64),
            r2 in prop::array::uniform3(-1.0..1.0f64),
            shrink in prop::sample::select(vec![1.0, 0.2, 0.11, 1e-3, 1e-9, 0.0]),
        ) {
            let (r0, r1, r2) = (Vec3::from(r0) * shrink, Vec3::from(r1), Vec3::from(r2));
            // First and second time derivatives by nested dual numbers.
            type D1 = Dual<f64, 1>;
            type D2 = Dual<D1, 1>;
            let t = D2 { value: D1::variable(0.0, 0), slope: [D1::from_f64(1.0)] };
            let lift = |v: Vec3<f64>| v.lift::<D2>();
            let half = D2::from_f64(0.5);
            let r = lift(r0) + lift(r1) * t + lift(r2) * (t * t * half);
            let column = |e: Vec3<D2>| {
                let (mut term, mut sum) = (e, e);
                for n in 1..90 {
                    term = r.cross(term) * D2::from_f64(1.0 / n as f64);
                    sum += term;
                }
                sum
            };
            let columns = [0, 1, 2].map(|k| column(Vec3::unit(k)));
            let pick = |f: &dyn Fn(D2) -> f64| Mat3 {
                columns: columns.map(|c| Vec3::new(f(c.x), f(c.y), f(c.z))),
            };
            let value = pick(&|x| x.value.value);
            let first = pick(&|x| x.value.slope[0]);
            let second = pick(&|x| x.slope[0].slope[0]);
            let found = Orientation::of(r0, r1, r2);
            let differ = |a: Mat3<f64>, b: Mat3<f64>| {
                (0..3).map(|k| (a.columns[k] - b.columns[k]).norm()).fold(0.0, f64::max)
            };
            // The tolerance is wide because terms of the series grow up to about e^8, which costs
            // digits.
            prop_assert!(differ(found.rotation, value) < 1e-11);
            let omega = (first * value.transpose()).skew_part();
            prop_assert!((found.rate - omega).norm() < 1e-10, "{:?} {omega:?}", found.rate);
            let alpha = (second * value.transpose()).skew_part();
            prop_assert!((found.acceleration - alpha).norm() < 1e-9);
        }
    }
}
