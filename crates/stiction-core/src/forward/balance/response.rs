//! Accelerations, multipliers and wrenches that answer an effort.

use crate::spatial::Wrench;

/// What answers an effort: all that is linear in it.
#[derive(Debug, Default)]
pub(in crate::forward) struct Response {
    /// Of the tree.
    pub(in crate::forward) accelerations: Vec<f64>,
    /// Of all rows.
    pub(in crate::forward) multipliers: Vec<f64>,
    /// Each joint's complete wrench, predecessor on successor, about the kernel origin.
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

    /// Into the room that is there.
    fn clone_from(&mut self, other: &Self) {
        self.accelerations.clone_from(&other.accelerations);
        self.multipliers.clone_from(&other.multipliers);
        self.wrenches.clone_from(&other.wrenches);
    }
}

impl Response {
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
