//! Keys of springs and bushings.

use super::POSE;
use crate::expression::Measure::{
    Angle, AngularDamping, AngularStiffness, Damping, Force, Length, Moment, Number, Stiffness,
};
use crate::fields::Shape::{LinearOrAngular, Name, Quantity, SixBySix, Table, Vector};
use crate::fields::{Field, field, required};

/// Keys of a spring.
pub(crate) const SPRING: &[Field] = &[
    field("from", Name, "The body at one end; required without a `joint`."),
    field("to", Name, "The body at the other end; required without a `joint`."),
    field(
        "at",
        Vector(Length),
        "Attachment point on body `from`, in its frame; by default [0, 0, 0].",
    ),
    field(
        "to_at",
        Vector(Length),
        "Attachment point on body `to`, in its frame; by default [0, 0, 0].",
    ),
    field(
        "joint",
        Name,
        "Joint on which the spring acts, instead of `from` and `to`; of a joint with several degrees of freedom one of \
         them, such as \"leg1.U.first\".",
    ),
    field(
        "stiffness",
        LinearOrAngular(Stiffness, AngularStiffness),
        "Force per elongation along the line between the ends, or effort per change of the joint coordinate; at least \
         0, by default 0.",
    ),
    field(
        "free_length",
        Quantity(Length),
        "Length between the ends at which only the preload acts, at least 0; required with a stiffness between points.",
    ),
    field(
        "rest",
        LinearOrAngular(Length, Angle),
        "Coordinate of the joint at which only the preload acts; required with a stiffness on a joint.",
    ),
    field(
        "preload",
        LinearOrAngular(Force, Moment),
        "Force at the free length, positive if it pushes the ends apart, or effort at `rest`, positive towards larger \
         coordinates; by default 0.",
    ),
    field(
        "damping",
        LinearOrAngular(Damping, AngularDamping),
        "Force over rate of the length, or effort over rate of the joint, at least 0; by default 0.",
    ),
    field(
        "extension_force",
        Quantity(Force),
        "Makes it a gas spring between points: its force at the extended length (F1 of data sheets), at least 0.",
    ),
    field(
        "progression",
        Quantity(Number),
        "Force of the gas spring at the end of the stroke over its extension force (x = F2/F1), at least 1; linear over \
         the stroke; by default 1.",
    ),
    field(
        "extended_length",
        Quantity(Length),
        "Length between the ends of the extended gas spring; required there.",
    ),
    field(
        "stroke",
        Quantity(Length),
        "Stroke of the gas spring; required there. Runs report where its length leaves the stroke; its force is \
         continued linearly.",
    ),
];

/// Keys of a bushing.
pub(crate) const BUSHING: &[Field] = &[
    required("from", Name, "The body of the first frame."),
    required("to", Name, "The body of the second frame."),
    field("frame", Table(POSE), "The first frame in `from`; by default its own."),
    field("to_frame", Table(POSE), "The second frame in `to`; by default its own."),
    field(
        "stiffness",
        SixBySix(Stiffness),
        "Stiffness matrix in the axes of the first frame, displacements x y z before rotations: its diagonal, or 6 rows \
         of 6; symmetric, without negative eigenvalues; by default 0.",
    ),
    field(
        "damping",
        SixBySix(Damping),
        "Damping matrix in the same form, for the velocity and angular velocity of the second frame relative to the \
         first; by default 0.",
    ),
];
