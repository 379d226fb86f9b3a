//! Legs.

use super::BODY;
use super::joint::LEG_JOINT;
use crate::expression::Measure::{Angle, Length};
use crate::fields::Shape::{Axis, List, Name, Named, Names, Quantities, Quantity, Text, Vector};
use crate::fields::{Field, field, required};

const FOOT: Field = field(
    "foot",
    Vector(Length),
    "Origin of the leg's first joint, in the frame of `from` turned by the leg's angle.",
);
const TIP: Field = field(
    "tip",
    Vector(Length),
    "Origin of the leg's last joint, in the frame of `to` turned by the leg's angle.",
);
const LEG_JOINTS: Field = field(
    "joints",
    Named(LEG_JOINT),
    "The joints of the chain by their letter, or letter and number (R1, R2) where one occurs twice.",
);
const LEG_BODIES: Field = field("bodies", Named(BODY), "The bodies of the chain by their names.");

/// A group of equal legs.
pub(crate) const LEGS: &[Field] = &[
    required(
        "chain",
        Text,
        "Joints and the bodies between them, from `from` to `to`: \"R cylinder P* rod S\"; * means \
         actuated. Or the joints alone, \"R P* S\": their bodies are then those of `between`, or are \
         called link1, link2 and so on.",
    ),
    field(
        "between",
        Names,
        "The bodies between the joints of a chain that names joints alone: [\"cylinder\", \"rod\"].",
    ),
    field("from", Name, "The body from which the legs start; by default the ground."),
    required("to", Name, "The body to which they lead."),
    field("about", Axis, "Axis of the placing turns; by default z."),
    FOOT,
    TIP,
    field("angles", Quantities(Angle), "One leg for each of these angles."),
    field(
        "place",
        List(PLACE),
        "One leg for each entry, with its angle and whatever is different there.",
    ),
    LEG_JOINTS,
    LEG_BODIES,
];

/// One leg of a group.
pub(crate) const PLACE: &[Field] = &[
    field("angle", Quantity(Angle), "The leg's angle; by default 0."),
    field("name", Text, "The leg's name; by default leg1, leg2 and so on."),
    FOOT,
    TIP,
    LEG_JOINTS,
    LEG_BODIES,
];
