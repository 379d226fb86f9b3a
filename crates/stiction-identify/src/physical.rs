//! Inertial parameters of bodies, and a divergence that keeps them physical.
//!
//! The pseudo-inertia of a body is the 4x4 matrix `[S h; h^T m]` with the second moments `S` of its
//! mass about its origin, `S = tr(I)/2 - I`. A mass distribution exists if and only if the
//! pseudo-inertia is positive definite.
//!
//! Sources: Wensing, Kim, Slotine, *Linear matrix inequalities for physically consistent inertial
//! parameter identification*, RA-L 2018; Lee, Wensing, Park, *Geometric robot dynamic identification*,
//! T-RO 2020 (the divergence).

use crate::parameter::{INERTIA_ENTRIES, Parameter};
use nalgebra::{Matrix4, SMatrix, SVector};
use stiction_core::mechanism::Body;
use stiction_core::spatial::{Mat3, Vec3};

/// Inertial parameters of a body: mass, first moments, inertia about the origin (xx, yy, zz, xy,
/// yz, xz).
pub type Inertial = [f64; 10];

/// Collects the inertial parameters of all bodies from `values`, the values of `parameters`. Each
/// entry begins with the index of the body.
pub fn bodies(parameters: &[Parameter], values: &[f64]) -> Vec<(usize, Inertial)> {
    let mut all: Vec<(usize, Vec<f64>)> = Vec::new();
    for (parameter, &value) in parameters.iter().zip(values) {
        let Some(body) = parameter.body() else { continue };
        match all.last_mut() {
            Some((last, own)) if *last == body => own.push(value),
            _ => all.push((body, vec![value])),
        }
    }
    all.into_iter().filter_map(|(body, own)| Some((body, own.try_into().ok()?))).collect()
}

/// Computes mass, centre of mass, and inertia tensor about the centre of mass from inertial
/// parameters. The mass must not be zero.
pub fn central(inertial: &Inertial) -> (f64, Vec3<f64>, Mat3<f64>) {
    let [mass, hx, hy, hz, ..] = *inertial;
    let com = Vec3::new(hx, hy, hz) * mass.recip();
    let square = com.dot(com);
    let outer = Mat3::from_columns(com * com.x, com * com.y, com * com.z);
    let away = (Mat3::diagonal(Vec3::new(square, square, square)) + outer * -1.0) * mass;
    (mass, com, about(inertial) + away * -1.0)
}

fn about(inertial: &Inertial) -> Mat3<f64> {
    let [.., xx, yy, zz, xy, yz, xz] = *inertial;
    Mat3::from_columns(Vec3::new(xx, xy, xz), Vec3::new(xy, yy, yz), Vec3::new(xz, yz, zz))
}

/// Computes inertial parameters from mass, centre of mass, and inertia tensor about the centre of
/// mass.
pub fn about_origin(mass: f64, com: Vec3<f64>, inertia: Mat3<f64>) -> Inertial {
    let body = Body { name: String::new(), mass, com, inertia };
    let total = crate::parameter::inertia_about_origin(&body);
    let h = com * mass;
    let mut all = [mass, h.x, h.y, h.z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    for (slot, (row, column)) in all[4..].iter_mut().zip(INERTIA_ENTRIES) {
        *slot = total.at(row, column);
    }
    all
}

/// Returns the pseudo-inertia matrix of a body with the given inertial parameters.
pub fn pseudo_inertia(inertial: &Inertial) -> Matrix4<f64> {
    let [mass, hx, hy, hz, xx, yy, zz, xy, yz, xz] = *inertial;
    let half = 0.5 * (xx + yy + zz);
    Matrix4::new(
        half - xx,
        -xy,
        -xz,
        hx, //
        -xy,
        half - yy,
        -yz,
        hy, //
        -xz,
        -yz,
        half - zz,
        hz, //
        hx,
        hy,
        hz,
        mass,
    )
}

/// Returns whether a mass distribution with the given inertial parameters exists.
pub fn is_physical(inertial: &Inertial) -> bool {
    // The scaling makes the verdict independent of units.
    let p = pseudo_inertia(inertial);
    let d = p.diagonal();
    if d.iter().any(|x| *x <= 0.0) {
        return d.iter().all(|x| *x >= 0.0) && p.symmetric_eigenvalues().min() >= -1e-12 * p.norm();
    }
    let scaled = Matrix4::from_fn(|i, j| p[(i, j)] / (d[i] * d[j]).sqrt());
    scaled.symmetric_eigenvalues().min() >= -1e-12
}

/// Prior of a body's inertial parameters, from which the divergence is measured.
#[derive(Clone, Debug)]
pub struct BodyPrior {
    /// Index of the first of the body's ten parameters.
    pub first: usize,
    /// Inverse of the prior's pseudo-inertia.
    inverse: Matrix4<f64>,
    logarithm: f64,
    /// Inertial parameters of the prior, modified so that they are strictly physical.
    pub prior: Inertial,
}

/// Value, gradient and Hessian of the divergence of a body.
#[derive(Clone, Debug)]
pub struct Divergence {
    /// Value of the divergence, dimensionless; zero at the prior.
    pub value: f64,
    /// Gradient of the divergence with respect to the body's ten parameters.
    pub gradient: SVector<f64, 10>,
    /// Hessian of the divergence with respect to the body's ten parameters.
    pub hessian: SMatrix<f64, 10, 10>,
}

impl BodyPrior {
    /// Creates the prior of a body. A rod or a point mass gets second moments of at least mass times `radius` squared
    /// in each direction, so that its pseudo-inertia is positive definite. `None` if that is impossible.
    pub fn new(first: usize, inertial: &Inertial, radius: f64) -> Option<Self> {
        let mut prior = *inertial;
        let floor = prior[0] * radius * radius;
        let (mass, com, inertia) = central(&prior);
        let half = 0.5 * inertia.trace();
        let second =
            nalgebra::Matrix3::from(Mat3::diagonal(Vec3::new(half, half, half)) + inertia * -1.0);
        let eigen = second.symmetric_eigen();
        let lifted = eigen.eigenvalues.map(|x| x.max(floor));
        let second = eigen.eigenvectors
            * nalgebra::Matrix3::from_diagonal(&lifted)
            * eigen.eigenvectors.transpose();
        let trace = second.trace();
        let inertia = nalgebra::Matrix3::from_diagonal_element(trace) - second;
        prior = about_origin(mass, com, Mat3::from(inertia));
        let pseudo = pseudo_inertia(&prior);
        let factor = pseudo.cholesky()?;
        let logarithm = 2.0 * factor.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>();
        Some(Self { first, inverse: factor.inverse(), logarithm, prior })
    }

    /// Computes `tr(P0^-1 P) - log det(P0^-1 P) - 4` and its derivatives for `values`, the values
    /// of all parameters. `P` is the pseudo-inertia of the body, `P0` that of the prior. Returns
    /// `None` outside the physical region.
    pub fn divergence(&self, values: &[f64]) -> Option<Divergence> {
        let own: Inertial = values[self.first..self.first + 10].try_into().ok()?;
        let pseudo = pseudo_inertia(&own);
        let factor = pseudo.cholesky()?;
        let logarithm = 2.0 * factor.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>();
        let inverse = factor.inverse();
        let value = (self.inverse * pseudo).trace() - (logarithm - self.logarithm) - 4.0;
        let basis: [Matrix4<f64>; 10] = std::array::from_fn(|k| {
            let mut unit = [0.0; 10];
            unit[k] = 1.0;
            pseudo_inertia(&unit)
        });
        let slope = self.inverse - inverse;
        let gradient = SVector::from_fn(|k, _| (slope * basis[k]).trace());
        let turned: [Matrix4<f64>; 10] = std::array::from_fn(|k| inverse * basis[k]);
        let hessian = SMatrix::from_fn(|i, k| (turned[i] * turned[k]).trace());
        value.is_finite().then_some(Divergence { value, gradient, hessian })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cuboid() -> Inertial {
        // The cuboid has 3 kg and sides of 0.2, 0.3 and 0.5 m; its centre is not at the origin.
        let i = |a: f64, b: f64| 3.0 / 12.0 * (a * a + b * b);
        let inertia = Mat3::diagonal(Vec3::new(i(0.3, 0.5), i(0.2, 0.5), i(0.2, 0.3)));
        about_origin(3.0, Vec3::new(0.1, -0.2, 0.4), inertia)
    }

    #[test]
    fn central_inverts_about_origin() {
        let (mass, com, inertia) = central(&cuboid());
        assert!((mass - 3.0).abs() < 1e-15 && (com - Vec3::new(0.1, -0.2, 0.4)).norm() < 1e-15);
        assert!((inertia.at(0, 0) - 0.25 * 0.34).abs() < 1e-15 && inertia.at(0, 1).abs() < 1e-15);
    }

    /// Checks the triangle inequality of principal moments of inertia: no mass distribution has a
    /// moment that exceeds the sum of the other two.
    #[test]
    fn physical_means_that_a_mass_distribution_exists() {
        assert!(is_physical(&cuboid()));
        let with = |x| about_origin(1.0, Vec3::zero(), Mat3::diagonal(Vec3::new(x, 1.0, 1.0)));
        assert!(is_physical(&with(1.9)) && !is_physical(&with(2.1)));
        let mut light = cuboid();
        light[0] = 0.1;
        assert!(!is_physical(&light), "the centre of mass would be 3 m away");
    }

    #[test]
    fn derivatives_of_the_divergence_by_differences() {
        let prior = BodyPrior::new(0, &cuboid(), 0.01).unwrap();
        assert!(prior.divergence(&cuboid()).unwrap().value.abs() < 1e-12);
        let at: Vec<f64> = cuboid().iter().enumerate().map(|(k, x)| x + 1e-4 * k as f64).collect();
        let found = prior.divergence(&at).unwrap();
        for k in 0..10 {
            let step = 1e-6;
            let moved = |by: f64| {
                let mut other = at.clone();
                other[k] += by;
                prior.divergence(&other).unwrap()
            };
            let slope = (moved(step).value - moved(-step).value) / (2.0 * step);
            // Central differences of step 1e-6: truncation errors are about 1e-12 times the third
            // derivatives, round-off is about 1e-10.
            assert!((slope - found.gradient[k]).abs() < 1e-6 * (1.0 + slope.abs()), "{k}");
            let bend = (moved(step).gradient - moved(-step).gradient) / (2.0 * step);
            let error = (bend - found.hessian.column(k)).norm();
            assert!(error < 1e-6 * found.hessian.norm(), "{k}: {error}");
        }
    }
}
