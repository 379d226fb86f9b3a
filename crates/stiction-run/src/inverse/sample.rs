//! What is told of one instant.

use super::efficiency::Backward;
use stiction_core::dynamics::{AppliedLoad, Forces, Shares};
use stiction_core::kinematics::Bodies;
use stiction_core::spatial::Vec3;
use stiction_core::statics::Distances;

/// Everything about one instant.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Time, s.
    pub time: f64,
    /// All forces.
    pub forces: &'a Forces,
    /// Poses, twists and accelerations of all bodies, in world axes about the kernel origin.
    pub bodies: &'a Bodies<f64>,
    /// The kernel origin in the world, m.
    pub origin: Vec3<f64>,
    /// The loads from outside.
    pub loads: &'a [AppliedLoad<f64>],
    /// The largest loop-closure error, m (angles times the characteristic length).
    pub closure: f64,
    /// Distances to singular positions.
    pub distances: Distances,
    /// For each joint and each component of its reaction (force, then moment) whether the balance
    /// alone determines it.
    pub determined_reactions: &'a [[bool; 6]],
    /// For each contact whether its load is determined.
    pub determined_loads: &'a [bool],
    /// For each drive whether it is determined.
    pub determined_drives: &'a [bool],
    /// How strongly friction and reactions are coupled: below one there is no other solution. None
    /// where it is not known.
    pub coupling: Option<f64>,
    /// The factor by which all coefficients can grow before friction locks the mechanism, infinite if
    /// it does not; if that was asked for.
    pub friction_margin: Option<f64>,
    /// What each contact's friction causes of each drive.
    pub shares: &'a Shares<f64>,
    /// For each drive how the load drives it back; nothing without friction.
    pub backward: &'a [Backward],
}
