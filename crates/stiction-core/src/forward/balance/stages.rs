//! Intermediate quantities in the computation of a response.

use crate::spatial::{Twist, Wrench};

/// Response of the mechanism to given efforts, with intermediate quantities.
#[derive(Clone, Debug)]
pub(super) struct Stages<T> {
    /// Generalised forces on the spanning tree. Initially all forces; after the accelerations are
    /// known, the component that the constraints must balance.
    pub(super) forces: Vec<T>,
    /// Accelerations as coefficients of the null-space basis.
    pub(super) along: Vec<T>,
    pub(super) accelerations: Vec<T>,
    pub(super) multipliers: Vec<T>,
    /// Acceleration of each body due to the accelerations of the tree coordinates, without
    /// velocity-dependent terms.
    pub(super) twists: Vec<Twist<T>>,
    /// Wrench that the joints must exert on each body, about the reference point in world axes.
    pub(super) demand: Vec<Wrench<T>>,
    /// Wrench that the joints must exert on each body at zero acceleration of the spanning tree and
    /// with zero multipliers.
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
