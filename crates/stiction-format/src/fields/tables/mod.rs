//! Keys of all tables of the model file.

mod actuator;
mod drives;
mod friction;
mod gearing;
mod joint;
mod legs;
mod load;
mod motion;
mod spring;

pub(crate) use actuator::{ACTUATOR, LEG_ACTUATOR, MESH, MOTOR_FRICTION, MOTOR_LIMITS, ROTOR_AXIS};
pub(crate) use drives::{CHANNEL, CONTROL, DRIVES};
pub(crate) use friction::{BACKWARD_LAW, INTERFACE, JOINT_FRICTION};
pub(crate) use gearing::GEARING;
pub(crate) use joint::{JOINT, JOINT_COMPLIANCE, JOINT_TYPES, LEG_JOINT};
pub(crate) use legs::{LEGS, PLACE};
pub(crate) use load::{BODY_LOAD, LOAD, PAYLOAD};
pub(crate) use motion::{ANGULAR_LIMITS, BODY_MOTION, LIMITS, MOTION, ORDERS, WAYPOINT};
pub(crate) use spring::{BUSHING, SPRING};

use super::Shape::{
    Choice, Inertia, List, Loads, Motions, Name, Named, OneOrMore, Parameters, Quantity, Rotation,
    Table, Text, Vector,
};
use super::{Field, field, required};
use crate::expression::Measure::{Acceleration, Length, Mass, Number};

/// Top-level keys of the model file, including the names of its tables.
pub(crate) const MODEL: &[Field] = &[
    field("name", Text, "Name of the mechanism; by default the name of the file."),
    field("title", Text, "One-line description."),
    field("source", Text, "Source of the numbers, such as a data sheet or a paper."),
    required(
        "gravity",
        Vector(Acceleration),
        "Acceleration of gravity in world axes; [0, 0, 0] for none.",
    ),
    field(
        "characteristic_length",
        Quantity(Length),
        "Characteristic length: it makes moments comparable to forces and angles to lengths; by \
         default a mean distance between the joints and centres of mass of the bodies.",
    ),
    field("base", Table(POSE), "Pose of the ground's frame in the world."),
    field(
        "parameters",
        Parameters,
        "Named quantities that expressions can use. They can refer to each other.",
    ),
    field("bodies", Named(BODY), "Moving bodies. The body `ground` is predefined."),
    field("joints", Named(JOINT), "The joints, each between two bodies."),
    field(
        "actuators",
        Named(ACTUATOR),
        "Drive trains: motors with their gears or screws. Each drives one degree of freedom of a \
         joint, or several joints together.",
    ),
    field(
        "gearings",
        Named(GEARING),
        "Rigid gearings: constraints between the coordinates of joints.",
    ),
    field(
        "springs",
        Named(SPRING),
        "Springs and dampers: between points of two bodies, gas springs, and springs on joints.",
    ),
    field("bushings", Named(BUSHING), "Elastic connections between frames of two bodies."),
    field("legs", OneOrMore(LEGS), "Equal legs around an axis: a short form for symmetric robots."),
    field("motions", Motions(MOTION), "Prescribed motions."),
    field("loads", Loads(LOAD), "External forces and moments."),
    field(
        "default",
        Table(DEFAULT),
        "Motion, load and friction mode that commands use by default.",
    ),
];

/// Keys of a pose.
pub(crate) const POSE: &[Field] = &[
    field("position", Vector(Length), "The origin; by default [0, 0, 0]."),
    field("rotation", Rotation, "The orientation; by default no rotation."),
];

const HOME: Field = field(
    "home",
    Table(POSE),
    "Initial guess of the body's pose in the ground's frame, for the assembly. For bodies of legs, \
     the pose is in the frame of `from`, rotated by the leg's angle.",
);

/// Keys of a body.
pub(crate) const BODY: &[Field] = &[
    field("mass", Quantity(Mass), "Mass; by default 0."),
    field(
        "com",
        Vector(Length),
        "Centre of mass in the frame of the body; required if the body \
        has a mass.",
    ),
    field(
        "inertia",
        Inertia,
        "Inertia about the centre of mass, in the body's axes: the diagonal [xx, yy, zz], or a \
         table of the tensor's entries {xx, yy, zz, xy, xz, yz}, whose missing entries are 0; \
         required if the body has a mass.",
    ),
    HOME,
    field(
        "visual",
        List(VISUAL),
        "Meshes that reports show in place of the body's symbol. Results do not depend on them.",
    ),
];

/// Keys of a mesh that shows a body.
pub(crate) const VISUAL: &[Field] = &[
    required(
        "mesh",
        Text,
        "File of the mesh, relative to the model file: STL, OBJ, GLB, or glTF with its data embedded.",
    ),
    field(
        "scale",
        Vector(Number),
        "Scale factors of the three coordinates of the mesh; by default [1, 1, 1], for a mesh in \
         metres.",
    ),
    field(
        "position",
        Vector(Length),
        "Origin of the mesh in the frame of the body; by default [0, \
        0, 0].",
    ),
    field(
        "rotation",
        Rotation,
        "Orientation of the mesh in the frame of the body; by default no \
        rotation.",
    ),
];

/// Keys of the table `default`: the motion, load and friction mode that a command uses unless its
/// arguments specify others.
pub(crate) const DEFAULT: &[Field] = &[
    field("motion", Name, "Name of the motion."),
    field("load", Name, "Name of the load."),
    field(
        "friction",
        Choice(FRICTION_MODES),
        "Friction mode: on (converged), off, one-pass (decoupled).",
    ),
];

/// Names of the friction modes.
pub(crate) const FRICTION_MODES: &[&str] = &["on", "off", "one-pass"];

/// Names of the coordinate axes.
pub(crate) const AXES: &[&str] = &["x", "y", "z", "-x", "-y", "-z"];

/// Keys of the entries of an inertia tensor, each with its row and column index.
pub(crate) const TENSOR: &[(&str, usize, usize)] =
    &[("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2)];
