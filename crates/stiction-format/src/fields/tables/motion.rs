//! Motions.

use crate::expression::Measure::{Angle, Length, Time};
use crate::fields::Shape::{Choice, Quantity, Text};
use crate::fields::{Field, field};

/// Keys of a motion, besides its coordinates.
pub(crate) const MOTION: &[Field] = &[
    field("title", Text, "One-line description."),
    field("start", Quantity(Time), "Time of the first sample; by default 0."),
    field(
        "duration",
        Quantity(Time),
        "Duration; by default 1 s. With 0 the motion is a single pose.",
    ),
    field("step", Quantity(Time), "Time between samples of the result."),
    field(
        "file",
        Text,
        "CSV file with samples, instead of expressions; its path is relative to the model file.",
    ),
];

/// Coordinates of a body in a motion.
pub(crate) const BODY_MOTION: &[Field] = &[
    field("x", Quantity(Length), "x of the body's origin in the ground's frame."),
    field("y", Quantity(Length), "y of the body's origin."),
    field("z", Quantity(Length), "z of the body's origin."),
    field("rx", Quantity(Angle), "Intrinsic rotation angle about x."),
    field("ry", Quantity(Angle), "Intrinsic rotation angle about y."),
    field("rz", Quantity(Angle), "Intrinsic rotation angle about z."),
    field("r1", Quantity(Angle), "First intrinsic angle, whatever the order."),
    field("r2", Quantity(Angle), "Second intrinsic angle."),
    field("r3", Quantity(Angle), "Third intrinsic angle."),
    field("rvx", Quantity(Angle), "x of the rotation vector."),
    field("rvy", Quantity(Angle), "y of the rotation vector."),
    field("rvz", Quantity(Angle), "z of the rotation vector."),
    field("order", Choice(ORDERS), "Order of the intrinsic angles; by default xyz."),
];

/// Orders of intrinsic angles.
pub(crate) const ORDERS: &[&str] =
    &["xyz", "yzx", "zxy", "xzy", "zyx", "yxz", "xyx", "yzy", "zxz", "xzx", "zyz", "yxy"];
