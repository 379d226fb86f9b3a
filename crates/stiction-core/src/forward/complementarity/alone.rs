//! The law of one member while all others do what they do.

use super::laws::Smooth;
use crate::forward::affine_friction::norm;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// The block of one member: `rates = free - V diag(values) V^T friction`, `V` orthogonal.
pub(super) struct Alone {
    pub(super) vectors: Matrix3<f64>,
    pub(super) values: Vector3<f64>,
}

impl Alone {
    pub(super) fn new(change: &[f64], places: &Range<usize>, n: usize) -> Self {
        let count = places.len();
        let entry = |i: usize, j: usize| match (i < count, j < count) {
            (true, true) => -change[(places.start + i) * n + places.start + j],
            _ => 0.0,
        };
        // Symmetric but for rounding.
        let block = Matrix3::from_fn(|i, j| 0.5 * (entry(i, j) + entry(j, i)));
        let eigen = block.symmetric_eigen();
        let least = 1e-13 * eigen.eigenvalues.amax();
        let values = eigen.eigenvalues.map(|value| if value > least { value } else { 0.0 });
        Self { vectors: eigen.eigenvectors, values }
    }

    /// Coulomb's law of this member alone: friction `g`, at most `most`, where the rate without any of it is
    /// `free`; near `before` where it holds.
    pub(super) fn settle(
        &self,
        free: [f64; 3],
        most: f64,
        viscous: f64,
        before: [f64; 3],
    ) -> [f64; 3] {
        if most <= 0.0 {
            return [0.0; 3];
        }
        // With viscous friction, too, rates are less and harder to change.
        let less = self.values.map(|w| 1.0 / (1.0 + viscous * w));
        let values = self.values.component_mul(&less);
        let free = (self.vectors.transpose() * Vector3::from(free)).component_mul(&less);
        let before = self.vectors.transpose() * Vector3::from(before);
        let holding = Vector3::from_fn(|k, _| match values[k] {
            0.0 => before[k],
            w => free[k] / w,
        });
        let bounded = |g: Vector3<f64>| g.norm() <= most;
        let none = values.iter().zip(free.iter()).all(|(w, b)| *w > 0.0 || *b == 0.0);
        if none && bounded(holding) {
            return (self.vectors * holding).into();
        }
        // It slides at the speed `x` in the direction `d`: `(x + most W) d = free`.
        let along = |x: f64| {
            Vector3::from_fn(|k, _| {
                let by = x + most * values[k];
                if by > 0.0 { free[k] / by } else { 0.0 }
            })
        };
        let (mut low, mut high) = (0.0, free.norm());
        if along(0.0).norm() > 1.0 || !none {
            for _ in 0..200 {
                let middle = if low > 0.0 { (low * high).sqrt() } else { 1e-3 * high };
                if !(middle > low && middle < high) || high < 1e-300 || high - low <= 1e-15 * high {
                    break;
                }
                if along(middle).norm() > 1.0 { low = middle } else { high = middle }
            }
        } else {
            high = 0.0;
        }
        (self.vectors * (along(high) * most)).into()
    }
}

/// Friction of a smooth law where the velocity is `free - friction / softness`.
pub(super) fn settle_smooth(
    law: &dyn Smooth,
    load: f64,
    free: [f64; 3],
    softness: f64,
    start: [f64; 3],
    count: usize,
) -> [f64; 3] {
    if softness <= 0.0 {
        return law.friction(load, start);
    }
    // The friction grows with the velocity, so half of the change is always a step forward.
    let mut velocity = start;
    let mut damping = 1.0;
    let mut before = f64::INFINITY;
    for _ in 0..30 {
        let friction = law.friction(load, velocity);
        let mut off = [0.0; 3];
        for k in 0..count {
            off[k] = velocity[k] - free[k] + friction[k] / softness;
        }
        let size = norm(off);
        if size <= 1e-12 * norm(free) {
            break;
        }
        // The slope along the error.
        let step = 1e-6 * size;
        let ahead = law.friction(load, [0, 1, 2].map(|k| velocity[k] + step * off[k] / size));
        let slope: f64 = (0..count).map(|k| (ahead[k] - friction[k]) / step * off[k] / size).sum();
        if size > before {
            damping *= 0.5;
        }
        before = size;
        let by = damping / (1.0 + slope.max(0.0) / softness);
        for k in 0..count {
            velocity[k] -= by * off[k];
        }
    }
    let mut friction = [0.0; 3];
    for k in 0..count {
        friction[k] = (free[k] - velocity[k]) * softness;
    }
    friction
}
