//! Keys of load cases.

use crate::expression::Measure::{Force, Length, Mass, Moment, Time};
use crate::fields::Shape::{Choice, Inertia, List, Name, Quantity, Text, Vector};
use crate::fields::{Field, field, required};

/// Keys of a load case, besides the names of bodies.
pub(crate) const LOAD: &[Field] = &[
    field("title", Text, "One-line description."),
    field(
        "payload",
        List(PAYLOAD),
        "Payloads: parts with weight and inertia that the mechanism carries, each a table \
         [[loads.NAME.payload]].",
    ),
];

/// Keys of a payload.
pub(crate) const PAYLOAD: &[Field] = &[
    required("body", Name, "Body to which the part is fixed while it is carried."),
    required("mass", Quantity(Mass), "Mass of the part, greater than 0."),
    field(
        "com",
        Vector(Length),
        "Centre of mass of the part in the frame of the body; by default its origin.",
    ),
    field(
        "inertia",
        Inertia,
        "Inertia of the part about its centre of mass, in the axes of the body; by default 0, a point \
         mass.",
    ),
    field(
        "from",
        Quantity(Time),
        "Time at which the part is picked up; by default the start of the motion.",
    ),
    field(
        "until",
        Quantity(Time),
        "Time at which the part is placed; by default the end of the \
        motion.",
    ),
];

/// Keys of the load on a body.
pub(crate) const BODY_LOAD: &[Field] = &[
    field("force", Vector(Force), "Force; its components can be expressions in the time `t`."),
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
