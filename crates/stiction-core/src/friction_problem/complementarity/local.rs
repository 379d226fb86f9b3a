//! Solution of the friction law of one member (friction interface) for fixed friction at all other
//! members.

use super::laws::SmoothFriction;
use crate::friction_problem::surface_vector::norm;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// Surface rate of one member as a function of the member's own friction:
/// `rates = free - V diag(values) V^T friction`. The columns of the orthogonal matrix `V`
/// (`vectors`) are eigenvectors; `free` is the rate for zero friction of this member.
#[derive(Clone)]
pub(super) struct LocalResponse {
    pub(super) vectors: Matrix3<f64>,
    pub(super) values: Vector3<f64>,
}

impl LocalResponse {
    /// Computes the eigenvectors and eigenvalues of one member's negated diagonal block of
    /// `compliance`. This `n` by `n` matrix, stored row by row, contains the change of each surface
    /// rate per unit of friction. `places` are the indices of the member's unknowns. Negative
    /// eigenvalues, and those at round-off, become zero.
    pub(super) fn new(compliance: &[f64], places: &Range<usize>, n: usize) -> Self {
        let count = places.len();
        let entry = |i: usize, j: usize| match (i < count, j < count) {
            (true, true) => -compliance[(places.start + i) * n + places.start + j],
            _ => 0.0,
        };
        // The block is symmetric up to round-off.
        let block = Matrix3::from_fn(|i, j| 0.5 * (entry(i, j) + entry(j, i)));
        let eigen = block.symmetric_eigen();
        let least = 1e-13 * eigen.eigenvalues.amax();
        let values = eigen.eigenvalues.map(|value| if value > least { value } else { 0.0 });
        Self { vectors: eigen.eigenvectors, values }
    }

    /// Computes the dry friction of this member, N, by Coulomb's law with the friction limit
    /// `most`, N. `free` is the surface rate of the member without its own friction, and `viscous`
    /// is the coefficient of viscous friction. Sticking friction keeps the component of `before` in
    /// directions in which friction does not change the rate.
    pub(super) fn dry_friction(
        &self,
        free: [f64; 3],
        most: f64,
        viscous: f64,
        before: [f64; 3],
    ) -> [f64; 3] {
        if most <= 0.0 {
            return [0.0; 3];
        }
        // Viscous friction reduces the rates and the effect of dry friction on them.
        let damped = self.values.map(|w| 1.0 / (1.0 + viscous * w));
        let values = self.values.component_mul(&damped);
        let free = (self.vectors.transpose() * Vector3::from(free)).component_mul(&damped);
        let before = self.vectors.transpose() * Vector3::from(before);
        let sticking = Vector3::from_fn(|k, _| match values[k] {
            0.0 => before[k],
            w => free[k] / w,
        });
        let bounded = |g: Vector3<f64>| g.norm() <= most;
        let can_stick = values.iter().zip(free.iter()).all(|(w, b)| *w > 0.0 || *b == 0.0);
        if can_stick && bounded(sticking) {
            return (self.vectors * sticking).into();
        }
        // Sliding at speed `x` in direction `d` satisfies `(x + most W) d = free`, with the
        // diagonal matrix `W` of `values`.
        let direction = |x: f64| {
            Vector3::from_fn(|k, _| {
                let divisor = x + most * values[k];
                if divisor > 0.0 { free[k] / divisor } else { 0.0 }
            })
        };
        let (mut low, mut high) = (0.0, free.norm());
        if direction(0.0).norm() > 1.0 || !can_stick {
            for _ in 0..200 {
                let middle = if low > 0.0 { (low * high).sqrt() } else { 1e-3 * high };
                if !(middle > low && middle < high) || high < 1e-300 || high - low <= 1e-15 * high {
                    break;
                }
                if direction(middle).norm() > 1.0 { low = middle } else { high = middle }
            }
        } else {
            high = 0.0;
        }
        (self.vectors * (direction(high) * most)).into()
    }
}

/// Solves a smooth friction law together with `velocity = free - friction / factor`, and returns
/// the friction, N. The member carries the normal load `load`, N. `free` is its velocity without
/// this friction, and `factor` is the force per unit change of velocity. The iteration begins at
/// the velocity `start`; only the first `count` components are used.
pub(super) fn smooth_friction(
    law: &dyn SmoothFriction,
    load: f64,
    free: [f64; 3],
    factor: f64,
    start: [f64; 3],
    count: usize,
) -> [f64; 3] {
    if factor <= 0.0 {
        return law.friction(load, start);
    }
    // Friction increases with velocity, so a sufficiently short step always reduces the error.
    let mut velocity = start;
    let mut damping = 1.0;
    let mut before = f64::INFINITY;
    for _ in 0..30 {
        let friction = law.friction(load, velocity);
        let mut error = [0.0; 3];
        for k in 0..count {
            error[k] = velocity[k] - free[k] + friction[k] / factor;
        }
        let size = norm(error);
        if size <= 1e-12 * norm(free) {
            break;
        }
        // Derivative of the friction law in the direction of the error.
        let step = 1e-6 * size;
        let ahead = law.friction(load, [0, 1, 2].map(|k| velocity[k] + step * error[k] / size));
        let slope: f64 =
            (0..count).map(|k| (ahead[k] - friction[k]) / step * error[k] / size).sum();
        if size > before {
            damping *= 0.5;
        }
        before = size;
        let by = damping / (1.0 + slope.max(0.0) / factor);
        for k in 0..count {
            velocity[k] -= by * error[k];
        }
    }
    let mut friction = [0.0; 3];
    for k in 0..count {
        friction[k] = (free[k] - velocity[k]) * factor;
    }
    friction
}
