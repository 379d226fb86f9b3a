//! Keys of joints.

use super::friction::JOINT_FRICTION;
use crate::expression::Measure::{AngularCompliance, Compliance, Length, Pitch};
use crate::fields::Shape::{
    Actuated, Axis, Choice, Name, Quantity, Range, Rotation, Start, Table, Vector,
};
use crate::fields::{Field, field, joined, required};

/// Symbols of the joint types.
pub(crate) const JOINT_TYPES: &[&str] = &["R", "P", "H", "C", "U", "S", "E", "fixed", "free"];

const AT: Field =
    field("at", Vector(Length), "The joint's origin in the frame of `from`; by default [0, 0, 0].");
const TO_AT: Field = field(
    "to_at",
    Vector(Length),
    "The joint's origin in the frame of `to`; by default [0, 0, 0].",
);
const AXIS: Field = field(
    "axis",
    Axis,
    "Axis of an R, P, H or C joint, first axis of a U joint, or normal of an E joint, in the frame \
     of `from`: \"x\", \"y\", \"z\", \"-x\", … or a vector. Required for these types; joints of \
     type S, fixed and free need no axis.",
);
const SECOND_AXIS: Field = field(
    "second_axis",
    Axis,
    "Second axis of a U joint at zero coordinates, in the frame of `from`, perpendicular to \
     `axis`; required for U joints.",
);
const X_AXIS: Field = field(
    "x_axis",
    Axis,
    "Direction of the x axis of the joint's frame, in the frame of `from`, perpendicular to \
     `axis`. By default the x axis of `from`, turned by the smallest rotation that takes the z \
     axis to `axis`.",
);
const TURN: Field = field(
    "turn",
    Rotation,
    "Rotation of the frame of `to` relative to that of `from` at zero coordinates; by default no \
     rotation.",
);
const ACTUATED: Field = field(
    "actuated",
    Actuated,
    "`true` if the joint has an actuator, or the names of its actuated degrees of freedom; by default false.",
);
const START: Field = field(
    "start",
    Start,
    "Initial guess of the coordinates, for the assembly: one quantity (R, P, H), a list (C: [angle, \
     slide], U: [first, second], E: [x, y, angle]), a rotation (S), a pose (free).",
);
const PITCH: Field = field(
    "pitch",
    Quantity(Pitch),
    "Advance of an H joint per angle, for example \"5 mm/rev\"; required for H joints, not allowed \
     for others.",
);
const FRICTION: Field =
    field("friction", Table(JOINT_FRICTION), "Friction that depends on the joint's own reaction.");
const COMPLIANCE: Field = field(
    "compliance",
    Table(JOINT_COMPLIANCE),
    "Compliance of the joint; it determines only how redundant constraints share a load.",
);

const RANGE: Field = field(
    "range",
    Range,
    "Range that the joint should not leave: [least, greatest]. For C, U and E joints, a table by \
     degree of freedom, such as { slide = [0, \"50 mm\"] }; `tilt` of a U joint is the angle \
     between the directions in the two bodies that are normal to both axes at zero coordinates; \
     `tilt` of an S joint is the angle between the z axes of its two frames. Runs report motions \
     that leave the range; the results do not change.",
);

/// Keys of the compliances of a joint.
pub(crate) const JOINT_COMPLIANCE: &[Field] = &[
    field(
        "radial",
        Quantity(Compliance),
        "Displacement perpendicular to the axis per unit of force; for an S joint, displacement in \
         any direction. All compliances are at least 0; by default 0, rigid.",
    ),
    field("axial", Quantity(Compliance), "Displacement along the axis per unit of force."),
    field("bending", Quantity(AngularCompliance), "Tilt angle of the axis per unit of moment."),
    field(
        "torsional",
        Quantity(AngularCompliance),
        "Angle of twist about the axis per unit of moment; for a U joint, about the common normal \
         of its axes.",
    ),
];

/// Keys for the type of a joint and the bodies that it connects.
const ENDS: &[Field] = &[
    required(
        "type",
        Choice(JOINT_TYPES),
        "R revolute, P prismatic, H helical, C cylindrical, U universal, S spherical, E planar, fixed, \
         free.",
    ),
    required("from", Name, "The predecessor: the body that exerts the joint reactions on `to`."),
    required("to", Name, "The successor."),
];

/// Keys of a joint.
pub(crate) const JOINT: &[Field] = &joined::<15>(ENDS, LEG_JOINT);

/// Keys of a joint of a leg. The type and the bodies of this joint follow from the key `chain` of
/// the leg.
pub(crate) const LEG_JOINT: &[Field] = &[
    AT,
    TO_AT,
    AXIS,
    SECOND_AXIS,
    X_AXIS,
    TURN,
    ACTUATED,
    START,
    PITCH,
    FRICTION,
    COMPLIANCE,
    RANGE,
];
