//! Intermediate quantities of a response.

use crate::spatial::{Twist, Wrench};

/// Response with its intermediate quantities.
#[derive(Clone, Debug)]
pub(super) struct Stages<T> {
    /// Generalised forces on the tree: at first all of them, later the component that the constraints must balance.
    pub(super) forces: Vec<T>,
    /// Accelerations as coefficients of the basis of the null space.
    pub(super) along: Vec<T>,
    pub(super) accelerations: Vec<T>,
    pub(super) multipliers: Vec<T>,
    /// Acceleration of each body due to the accelerations of the tree's coordinates.
    pub(super) twists: Vec<Twist<T>>,
    /// Wrench that the joints must exert on each body.
    pub(super) demand: Vec<Wrench<T>>,
    /// Wrench that the joints must exert on each body at zero acceleration of the tree and with zero multipliers.
    pub(super) demand_at_rest: Vec<Wrench<T>>,
    pub(super) wrenches: Vec<Wrench<T>>,
}

impl<T> Default for Stages<T> {
    fn default() -> Self {
        Self {
            forces: Vec::new(),
            along: Vec::new(),
            accelerations: Vec::new(),
            multipliers: Vec::new(),
            twists: Vec::new(),
            demand: Vec::new(),
            demand_at_rest: Vec::new(),
            wrenches: Vec::new(),
        }
    }
}
