//! Loads.

use crate::expression::Measure::{Force, Length, Moment};
use crate::fields::Shape::{Choice, Quantity, Text, Vector};
use crate::fields::{Field, field};

/// A load case, besides its bodies.
pub(crate) const LOAD: &[Field] = &[field("title", Text, "One line that says what it is.")];

/// What may stand behind the name of a body in a load.
pub(crate) const BODY_LOAD: &[Field] = &[
    field("force", Vector(Force), "Force; components may change with the time `t`."),
    field("moment", Vector(Moment), "Moment about the point `at`."),
    field(
        "at",
        Vector(Length),
        "Where the force acts, in the body's frame; by default its origin.",
    ),
    field(
        "axes",
        Choice(&["world", "body"]),
        "Whether the components are along the world's axes (the default) or turn with the body.",
    ),
    field("fx", Quantity(Force), "x component of the force, instead of `force`."),
    field("fy", Quantity(Force), "y component of the force."),
    field("fz", Quantity(Force), "z component of the force."),
    field("mx", Quantity(Moment), "x component of the moment, instead of `moment`."),
    field("my", Quantity(Moment), "y component of the moment."),
    field("mz", Quantity(Moment), "z component of the moment."),
];
