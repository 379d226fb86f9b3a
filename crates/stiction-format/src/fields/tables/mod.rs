//! The tables of the model file.

mod drives;
mod friction;
mod joint;
mod legs;
mod load;
mod motion;

pub(crate) use drives::{CHANNEL, CONTROL, DRIVES};
pub(crate) use friction::{BACKWARD_LAW, INTERFACE, JOINT_FRICTION};
pub(crate) use joint::{JOINT, JOINT_COMPLIANCE, JOINT_TYPES, LEG_JOINT};
pub(crate) use legs::{LEGS, PLACE};
pub(crate) use load::{BODY_LOAD, LOAD};
pub(crate) use motion::{BODY_MOTION, MOTION, ORDERS};

use super::Shape::{
    Choice, Inertia, Loads, Motions, Name, Named, OneOrMore, Parameters, Quantity, Rotation, Table,
    Text, Vector,
};
use super::{Field, field, required};
use crate::expression::Measure::{Acceleration, Damping, Length, Mass, Stiffness};

/// The whole file.
pub(crate) const MODEL: &[Field] = &[
    field("name", Text, "Name of the mechanism; by default the name of the file."),
    field("title", Text, "One line that says what it is."),
    field("source", Text, "Where the numbers come from."),
    required(
        "gravity",
        Vector(Acceleration),
        "Acceleration of gravity in world axes; [0, 0, 0] for none.",
    ),
    field(
        "characteristic_length",
        Quantity(Length),
        "The length by which moments and forces, angles and lengths are compared; by default a mean \
         distance between the joints and centres of mass of the bodies.",
    ),
    field("base", Table(POSE), "Where the ground's frame is in the world."),
    field(
        "parameters",
        Parameters,
        "Named quantities, for use in any expression. They may refer to each other.",
    ),
    field("bodies", Named(BODY), "The moving bodies. `ground` is there already."),
    field("joints", Named(JOINT), "The joints, each between two bodies."),
    field("springs", Named(SPRING), "Springs and dampers, each between points of two bodies."),
    field(
        "legs",
        OneOrMore(LEGS),
        "Equal legs around an axis: the short form for symmetric robots.",
    ),
    field("motions", Motions(MOTION), "Prescribed motions."),
    field("loads", Loads(LOAD), "Forces and moments from outside."),
    field("default", Table(DEFAULT), "What is computed when nothing else is asked for."),
];

/// A pose.
pub(crate) const POSE: &[Field] = &[
    field("position", Vector(Length), "The origin; by default [0, 0, 0]."),
    field("rotation", Rotation, "The orientation; by default none."),
];

const HOME: Field = field(
    "home",
    Table(POSE),
    "First guess of the body's pose in the ground's frame, for the assembly. In legs: in the frame \
     of `from`, turned by the leg's angle.",
);

/// A body.
pub(crate) const BODY: &[Field] = &[
    field("mass", Quantity(Mass), "Mass; by default 0."),
    field(
        "com",
        Vector(Length),
        "Centre of mass in the body's frame; required if there is a mass.",
    ),
    field(
        "inertia",
        Inertia,
        "Inertia about the centre of mass, in the body's axes: the diagonal [xx, yy, zz], or a table \
         of the tensor's entries {xx, yy, zz, xy, xz, yz}, missing ones 0; required if there is a \
         mass.",
    ),
    HOME,
];

/// A spring.
pub(crate) const SPRING: &[Field] = &[
    required("from", Name, "The body at one end."),
    required("to", Name, "The body at the other end."),
    field("at", Vector(Length), "The end on `from`, in its frame; by default [0, 0, 0]."),
    field("to_at", Vector(Length), "The end on `to`, in its frame; by default [0, 0, 0]."),
    field(
        "stiffness",
        Quantity(Stiffness),
        "Force over elongation, along the line between the ends, at least 0; by default 0.",
    ),
    field(
        "free_length",
        Quantity(Length),
        "The length at which the spring does not pull, at least 0; required with a stiffness.",
    ),
    field(
        "damping",
        Quantity(Damping),
        "Force over rate of the length, along the same line, at least 0; by default 0.",
    ),
];

/// Defaults.
pub(crate) const DEFAULT: &[Field] = &[
    field("motion", Name, "The motion."),
    field("load", Name, "The load."),
    field(
        "friction",
        Choice(FRICTION_MODES),
        "Whether friction acts: on (converged), off, one-pass.",
    ),
];

/// Friction modes by name.
pub(crate) const FRICTION_MODES: &[&str] = &["on", "off", "one-pass"];

/// Coordinate axes by name.
pub(crate) const AXES: &[&str] = &["x", "y", "z", "-x", "-y", "-z"];

/// The entries of an inertia tensor, with row and column.
pub(crate) const TENSOR: &[(&str, usize, usize)] =
    &[("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2)];
