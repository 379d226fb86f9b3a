//! Keys of springs and bushings.

use super::POSE;
use crate::expression::Measure::{
    Angle, AngularDamping, AngularStiffness, Damping, Force, Length, Moment, Number, Stiffness,
};
use crate::fields::Shape::{LinearOrAngular, Name, Quantity, SixBySix, Table, Vector};
use crate::fields::{Field, field, required};

/// Keys of a spring.
pub(crate) const SPRING: &[Field] = &[
    field("from", Name, "The body at one end; required unless `joint` is given."),
    field("to", Name, "The body at the other end; required unless `joint` is given."),
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
        "Joint on which the spring acts, instead of `from` and `to`; for a joint with several \
         degrees of freedom, the name of one, such as \"leg1.U.first\".",
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
        "Length between the ends at which only the preload acts, at least 0; required if a spring \
         between points has a stiffness.",
    ),
    field(
        "rest",
        LinearOrAngular(Length, Angle),
        "Coordinate of the joint at which only the preload acts; required if a spring on a joint \
         has a stiffness.",
    ),
    field(
        "preload",
        LinearOrAngular(Force, Moment),
        "Force at the free length, positive if it pushes the ends apart; or effort at `rest`, \
         positive in the direction of the joint coordinate; by default 0.",
    ),
    field(
        "damping",
        LinearOrAngular(Damping, AngularDamping),
        "Damping coefficient: force divided by the rate of the length, or effort divided by the rate of the joint, \
         at least 0; by default 0.",
    ),
    field(
        "extension_force",
        Quantity(Force),
        "Force of a gas spring at its extended length (F1 in data sheets), at least 0; this key \
         makes the spring a gas spring between points.",
    ),
    field(
        "progression",
        Quantity(Number),
        "Progression of a gas spring: force at the end of the stroke divided by the extension force (x = F2/F1 in \
         data sheets), at least 1; the force is linear over the stroke; by default 1.",
    ),
    field(
        "extended_length",
        Quantity(Length),
        "Length between the ends of the extended gas spring; required for gas springs.",
    ),
    field(
        "stroke",
        Quantity(Length),
        "Stroke of the gas spring; required for gas springs. Runs report motions that leave the \
         stroke; beyond it, the force is continued linearly.",
    ),
];

/// Keys of a bushing.
pub(crate) const BUSHING: &[Field] = &[
    required("from", Name, "The body of the first frame."),
    required("to", Name, "The body of the second frame."),
    field(
        "frame",
        Table(POSE),
        "Pose of the first frame in the frame of `from`; by default the \
        frame of `from` itself.",
    ),
    field(
        "to_frame",
        Table(POSE),
        "Pose of the second frame in the frame of `to`; by default the \
        frame of `to` itself.",
    ),
    field(
        "stiffness",
        SixBySix(Stiffness),
        "Stiffness matrix in the axes of the first frame, with displacements x y z before \
         rotations: its diagonal, or 6 rows of 6 entries; symmetric and positive semidefinite; by \
         default 0.",
    ),
    field(
        "damping",
        SixBySix(Damping),
        "Damping matrix in the same form, for the velocity and angular velocity of the second frame relative to the \
         first; by default 0.",
    ),
];
