//! Keys of actuator efforts and of controllers.

use crate::expression::Measure::{
    Damping, Force, Frequency, IntegralGain, Length, Number, Stiffness, Time,
};
use crate::fields::Shape::{Choice, Quantity, Text};
use crate::fields::{Field, field, required};

/// Keys of a table of prescribed actuator efforts, besides the names of actuators.
pub(crate) const DRIVES: &[Field] = &[field("title", Text, "One-line description.")];

/// Keys of a controller, besides the names of actuators.
pub(crate) const CONTROL: &[Field] = &[
    field("title", Text, "One-line description."),
    required("type", Choice(CONTROL_TYPES), "Control law."),
    field(
        "friction",
        Choice(FEED_MODES),
        "Friction compensation of computed torque: off (none; the default), reference (friction of \
         the reference motion), or measured (friction of the measured motion).",
    ),
    field(
        "period",
        Quantity(Time),
        "Sampling period; by default 1 ms. With 0, a controller of type pd or pid is continuous in \
         time.",
    ),
    field(
        "bandwidth",
        Quantity(Frequency),
        "Natural frequency of the closed loop without friction; by default 10 Hz, or less if the \
         period requires it.",
    ),
    field("damping", Quantity(Number), "Damping ratio of the closed loop; by default 1."),
    field(
        "rate",
        Choice(RATE_MODES),
        "Source of the rates: measured, or the difference of two measured positions (the default \
         if `resolution` is given).",
    ),
    field("kp", Quantity(Stiffness), "Position gain for the types pd and pid."),
    field("kd", Quantity(Damping), "Rate gain for the types pd and pid."),
    field("ki", Quantity(IntegralGain), "Integral gain for the type pid."),
    field(
        "tracking",
        Quantity(Time),
        "Time constant with which the integral part follows a saturated effort (anti-windup by \
         back-calculation); by default kp/ki.",
    ),
    field(
        "resolution",
        Quantity(Length),
        "Resolution of the measured position; by default the \
        measurement is exact.",
    ),
    field("limit", Quantity(Force), "Largest effort of the actuator; by default no limit."),
];

/// Keys of a controller that can also be set for a single actuator.
pub(crate) const CHANNEL: &[&str] = &["kp", "kd", "ki", "tracking", "resolution", "limit"];

/// Types of controllers.
const CONTROL_TYPES: &[&str] = &["pd", "pid", "computed-torque"];

/// Modes of friction compensation of a computed-torque controller: none, or the friction of the
/// reference motion or of the measured motion.
const FEED_MODES: &[&str] = &["off", "reference", "measured"];

/// Sources of the rates that a controller uses: measured rates, or differences of measured
/// positions.
const RATE_MODES: &[&str] = &["measured", "difference"];
