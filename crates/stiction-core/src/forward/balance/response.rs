//! Accelerations, multipliers and joint wrenches that result from given efforts.

use crate::spatial::Wrench;

/// Response of the mechanism to given joint wrenches. The response is linear in these wrenches if
/// it excludes loads, inertia forces and prescribed accelerations, and affine otherwise.
#[derive(Debug, Default)]
pub(in crate::forward) struct Response {
    /// Accelerations of the spanning tree, rad/s^2 or m/s^2.
    pub(in crate::forward) accelerations: Vec<f64>,
    /// Lagrange multiplier of each constraint row.
    pub(in crate::forward) multipliers: Vec<f64>,
    /// Complete wrench of each joint, exerted by the predecessor on the successor, about the
    /// reference point in world axes.
    pub(in crate::forward) wrenches: Vec<Wrench<f64>>,
}

impl Clone for Response {
    fn clone(&self) -> Self {
        let Self { accelerations, multipliers, wrenches } = self;
        Self {
            accelerations: accelerations.clone(),
            multipliers: multipliers.clone(),
            wrenches: wrenches.clone(),
        }
    }

    /// Copies another response, reusing the buffers.
    fn clone_from(&mut self, other: &Self) {
        self.accelerations.clone_from(&other.accelerations);
        self.multipliers.clone_from(&other.multipliers);
        self.wrenches.clone_from(&other.wrenches);
    }
}

impl Response {
    /// Adds a multiple of another response.
    pub(in crate::forward) fn add(&mut self, other: &Self, amount: f64) {
        let sum = |a: &mut Vec<f64>, b: &[f64]| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += amount * b);
        };
        sum(&mut self.accelerations, &other.accelerations);
        sum(&mut self.multipliers, &other.multipliers);
        for (a, b) in self.wrenches.iter_mut().zip(&other.wrenches) {
            *a += *b * amount;
        }
    }
}
