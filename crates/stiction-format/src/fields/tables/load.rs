//! Loads.

use crate::expression::Measure::{Force, Length, Moment};
use crate::fields::Shape::{Choice, Quantity, Text, Vector};
use crate::fields::{Field, field};

/// Keys of a load case, without its bodies.
pub(crate) const LOAD: &[Field] = &[field("title", Text, "One-line description.")];

/// Keys of the load on a body.
pub(crate) const BODY_LOAD: &[Field] = &[
    field("force", Vector(Force), "Force; components can be expressions in the time `t`."),
    field("moment", Vector(Moment), "Moment about the point `at`."),
    field(
        "at",
        Vector(Length),
        "Point of application in the frame of the body; by default its origin.",
    ),
    field(
        "axes",
        Choice(&["world", "body"]),
        "Axes of the components: those of the world (the default) or of the body.",
    ),
    field("fx", Quantity(Force), "x component of the force, instead of `force`."),
    field("fy", Quantity(Force), "y component of the force."),
    field("fz", Quantity(Force), "z component of the force."),
    field("mx", Quantity(Moment), "x component of the moment, instead of `moment`."),
    field("my", Quantity(Moment), "y component of the moment."),
    field("mz", Quantity(Moment), "z component of the moment."),
];
