//! Keys of motions.

use crate::expression::Measure::{
    Acceleration, Angle, AngularAcceleration, AngularJerk, AngularSpeed, Frequency, Jerk, Length,
    Speed, Time,
};
use crate::fields::Shape::{Choice, Limits, Quantity, Rotation, Text, Waypoints};
use crate::fields::{Field, field};
use crate::signal::law::Law;

/// Keys of a motion, besides its coordinates.
pub(crate) const MOTION: &[Field] = &[
    field("title", Text, "One-line description."),
    field("start", Quantity(Time), "Time of the first sample; by default 0."),
    field(
        "duration",
        Quantity(Time),
        "Duration; by default 1 s. With 0 the motion is a single pose. With `file`, the duration must agree with \
         the time column.",
    ),
    field(
        "rate",
        Quantity(Frequency),
        "Samples per second of `file`, as given by the logger; the time column must agree with it.",
    ),
    field("step", Quantity(Time), "Time between samples of the results."),
    field(
        "filter",
        Quantity(Frequency),
        "Cut-off frequency (-3 dB) of a low-pass filter for the positions of `file`, without phase \
         shift and without ringing at the ends. By default no filter.",
    ),
    field(
        "file",
        Text,
        "CSV file with samples, instead of expressions; its path is relative to the model file.",
    ),
    field(
        "waypoints",
        Waypoints(WAYPOINT),
        "Positions that the mechanism reaches one after another, instead of expressions: a list of tables, each \
         with the coordinates that change. The mechanism stops at a waypoint unless `blend` is given.",
    ),
    field("law", Choice(Law::NAMES), "Motion law between waypoints; by default quintic."),
    field(
        "limits",
        Limits,
        "Limits that determine the durations between waypoints, by the name of a coordinate or of \
         a body. Limits of a body apply to the path of its origin, and limits of `BODY.rotation` \
         apply to its rotation.",
    ),
];

/// Keys of a waypoint, besides its coordinates.
pub(crate) const WAYPOINT: &[Field] = &[
    field("at", Quantity(Time), "Time of arrival."),
    field("duration", Quantity(Time), "Duration of the move that leads to this waypoint."),
    field(
        "dwell",
        Quantity(Time),
        "Time at rest at this waypoint, after the arrival; by default 0.",
    ),
    field("law", Choice(Law::NAMES), "Motion law of the move to this waypoint."),
    field(
        "blend",
        Quantity(Time),
        "Overlap of the moves to and from this waypoint: the next move begins before this one ends, so \
         that the path rounds the corner and misses the waypoint; by default 0, a stop.",
    ),
];

/// Keys of the limits of a translation.
pub(crate) const LIMITS: &[Field] = &[
    field("speed", Quantity(Speed), "Greatest permitted speed."),
    field("acceleration", Quantity(Acceleration), "Greatest permitted acceleration."),
    field("jerk", Quantity(Jerk), "Greatest permitted jerk."),
];

/// Keys of the limits of a rotation.
pub(crate) const ANGULAR_LIMITS: &[Field] = &[
    field("speed", Quantity(AngularSpeed), "Greatest permitted angular speed."),
    field(
        "acceleration",
        Quantity(AngularAcceleration),
        "Greatest permitted angular acceleration.",
    ),
    field("jerk", Quantity(AngularJerk), "Greatest permitted angular jerk."),
];

/// Coordinates of a body, as keys of a motion.
pub(crate) const BODY_MOTION: &[Field] = &[
    field("x", Quantity(Length), "x of the body's origin in the ground's frame."),
    field("y", Quantity(Length), "y of the body's origin in the ground's frame."),
    field("z", Quantity(Length), "z of the body's origin in the ground's frame."),
    field("rx", Quantity(Angle), "Intrinsic rotation angle about x."),
    field("ry", Quantity(Angle), "Intrinsic rotation angle about y."),
    field("rz", Quantity(Angle), "Intrinsic rotation angle about z."),
    field("r1", Quantity(Angle), "First intrinsic rotation angle in the order `order`."),
    field("r2", Quantity(Angle), "Second intrinsic rotation angle in the order `order`."),
    field("r3", Quantity(Angle), "Third intrinsic rotation angle in the order `order`."),
    field("rvx", Quantity(Angle), "x of the rotation vector."),
    field("rvy", Quantity(Angle), "y of the rotation vector."),
    field("rvz", Quantity(Angle), "z of the rotation vector."),
    field(
        "rotation",
        Rotation,
        "In waypoints: the orientation. Between two orientations, the body turns about a fixed \
         axis by the smaller angle.",
    ),
    field("order", Choice(ORDERS), "Order of the intrinsic rotation angles; by default xyz."),
];

/// Permitted orders of the axes of three intrinsic rotations.
pub(crate) const ORDERS: &[&str] =
    &["xyz", "yzx", "zxy", "xzy", "zyx", "yxz", "xyx", "yzy", "zxz", "xzx", "zyz", "yxy"];
