//! Indices of colours, each with one meaning in all plots of runs.

/// Colour of results: efforts, positions, the work of actuators.
pub const RESULT: usize = 0;
/// Colour of a quantity for comparison: the effort without friction, the reference, or the second
/// of two runs. Its line is dashed.
///
/// The colour is neutral, because results may have the colour of a leg.
pub const REFERENCE: usize = usize::MAX - 1;
/// Colour of the measured data of a log, which is also that of text.
pub const MEASURED: usize = usize::MAX - 2;
/// Colour of external loads.
pub const LOAD: usize = 2;
/// Colour of friction and of the energy that it dissipates.
pub const FRICTION: usize = 3;
/// Colour of the kinetic energy, or of the total stored energy.
pub const ENERGY: usize = 4;
/// Colour of the potential energy.
pub const POTENTIAL: usize = 5;
/// Colour of intervals, limits and errors.
pub const LIMIT: usize = 6;
/// Colour of the singularity index of the loop constraints.
pub const CONSTRAINT: usize = 7;
/// Colour of a quantity of an actuator. The panel or bar states the leg of the actuator; the colour
/// is then that of this leg in pictures of the mechanism. Without a leg, the colour is that of a
/// result.
pub const OF_LEG: usize = usize::MAX;

/// Index of the colour of the first leg; the colours of the other legs have the following indices.
pub(super) const LEGS: usize = usize::MAX - 64;

/// Returns the colour index for a curve of the leg `leg` in a panel that shows several legs.
/// Pictures of the robot show the leg in the same colour.
pub const fn of_leg(leg: usize) -> usize {
    LEGS + leg % crate::drawing::BRANCHES.len()
}
