//! Indices of colours by meaning, the same in all plots of runs.

/// Results: efforts, positions, the work of actuators.
pub const RESULT: usize = 0;
/// Quantity for comparison: the effort without friction, the reference, or the second of two runs. Dashed.
///
/// A neutral colour, because results may have the colour of a leg.
pub const REFERENCE: usize = usize::MAX - 1;
/// Measured data of a log: the colour of text.
pub const MEASURED: usize = usize::MAX - 2;
/// External loads.
pub const LOAD: usize = 2;
/// Friction and the energy that it dissipates.
pub const FRICTION: usize = 3;
/// Kinetic energy, or the total stored energy.
pub const ENERGY: usize = 4;
/// Potential energy.
pub const POTENTIAL: usize = 5;
/// Intervals, limits and errors.
pub const LIMIT: usize = 6;
/// Constraints of the loops.
pub const CONSTRAINT: usize = 7;
/// Quantity of an actuator: the colour of its leg in pictures of the mechanism, as the panel or bar states it; that of
/// a result outside the legs.
pub const OF_LEG: usize = usize::MAX;

/// First of the colours of legs.
pub(super) const LEGS: usize = usize::MAX - 64;

/// Colour of a joint of this leg in a panel that shows several legs: the colour that the leg has in pictures of the robot.
pub const fn of_leg(leg: usize) -> usize {
    LEGS + leg % crate::drawing::BRANCHES.len()
}
