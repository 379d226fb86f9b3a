//! Keys of actuator efforts and of controllers.

use crate::expression::Measure::{
    Damping, Force, Frequency, IntegralGain, Length, Number, Stiffness, Time,
};
use crate::fields::Shape::{Choice, Quantity, Text};
use crate::fields::{Field, field, required};

/// Keys of a table of efforts, besides the names of actuators.
pub(crate) const DRIVES: &[Field] = &[field("title", Text, "One-line description.")];

/// Keys of a controller, besides the names of actuators.
pub(crate) const CONTROL: &[Field] = &[
    field("title", Text, "One-line description."),
    required("type", Choice(CONTROL_TYPES), "Control law."),
    field(
        "friction",
        Choice(FEED_MODES),
        "Motion whose friction computed torque compensates: off (none; the default), reference, measured.",
    ),
    field(
        "period",
        Quantity(Time),
        "Sampling period; by default 1 ms. With 0 the controller is continuous in time (pd and pid).",
    ),
    field(
        "bandwidth",
        Quantity(Frequency),
        "Natural frequency of the closed loop without friction; by default 10 Hz.",
    ),
    field("damping", Quantity(Number), "Damping ratio of the closed loop; by default 1."),
    field(
        "rate",
        Choice(RATE_MODES),
        "Source of rates: measured, or difference of two measured positions (the default with a \
         `resolution`).",
    ),
    field("kp", Quantity(Stiffness), "Position gain of a controller of type pd or pid."),
    field("kd", Quantity(Damping), "Rate gain of a controller of type pd or pid."),
    field("ki", Quantity(IntegralGain), "Integral gain of a controller of type pid."),
    field(
        "tracking",
        Quantity(Time),
        "Time constant with which the integral part follows a saturated effort (anti-windup by \
         back-calculation); by default kp/ki.",
    ),
    field("resolution", Quantity(Length), "Resolution of the measured position; by default none."),
    field("limit", Quantity(Force), "Effort limit; by default none."),
];

/// Settings of a controller for one actuator.
pub(crate) const CHANNEL: &[&str] = &["kp", "kd", "ki", "tracking", "resolution", "limit"];

/// Types of controllers.
const CONTROL_TYPES: &[&str] = &["pd", "pid", "computed-torque"];

/// Motion for which computed torque compensates friction.
const FEED_MODES: &[&str] = &["off", "reference", "measured"];

/// Sources of the measured rates.
const RATE_MODES: &[&str] = &["measured", "difference"];
