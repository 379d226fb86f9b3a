//! What drives actuators: efforts, controllers.

use crate::expression::Measure::{Damping, Force, Frequency, Length, Number, Stiffness, Time};
use crate::fields::Shape::{Choice, Quantity, Text};
use crate::fields::{Field, field, required};

/// Efforts of actuators, besides the actuators.
pub(crate) const DRIVES: &[Field] = &[field("title", Text, "One line that says what they are.")];

/// A controller, besides its actuators.
pub(crate) const CONTROL: &[Field] = &[
    field("title", Text, "One line that says what it is."),
    required("type", Choice(CONTROL_TYPES), "How efforts follow from what is measured."),
    field(
        "friction",
        Choice(FEED_MODES),
        "Whether computed torque contains friction, and for which motion: off (the default), reference, \
         measured.",
    ),
    field("period", Quantity(Time), "Time between two samples of the controller; by default 1 ms."),
    field(
        "bandwidth",
        Quantity(Frequency),
        "Natural frequency of the closed loop without friction; by default 10 Hz.",
    ),
    field("damping", Quantity(Number), "Damping ratio of the closed loop; by default 1."),
    field(
        "rate",
        Choice(RATE_MODES),
        "Whether rates are measured, or differences of two measured positions; the default, with a \
         `resolution`.",
    ),
    field("kp", Quantity(Stiffness), "Effort for an error of position, by `type = \"pd\"`."),
    field("kd", Quantity(Damping), "Effort for an error of the rate, by `type = \"pd\"`."),
    field("resolution", Quantity(Length), "Step of the measured position; by default none."),
    field("limit", Quantity(Force), "Greatest effort; by default none."),
];

/// What may stand behind the name of an actuator in a controller.
pub(crate) const CHANNEL: &[&str] = &["kp", "kd", "resolution", "limit"];

/// Types of controllers.
const CONTROL_TYPES: &[&str] = &["pd", "computed-torque"];

/// Where computed torque takes friction from.
const FEED_MODES: &[&str] = &["off", "reference", "measured"];

/// How rates are measured.
const RATE_MODES: &[&str] = &["measured", "difference"];
