//! Keys of legs.

use super::joint::LEG_JOINT;
use super::{BODY, LEG_ACTUATOR, SPRING};
use crate::expression::Measure::{Angle, Length};
use crate::fields::Shape::{
    Axis, List, Name, Named, Names, Quantities, Quantity, Text, Texts, Vector,
};
use crate::fields::{Field, field, required};

const FOOT: Field = field(
    "foot",
    Vector(Length),
    "Origin of the leg's first joint, in the frame of `from` rotated by the leg's angle.",
);
const TIP: Field = field(
    "tip",
    Vector(Length),
    "Origin of the leg's last joint, in the frame of `to` rotated by the leg's angle.",
);
const LEG_JOINTS: Field = field(
    "joints",
    Named(LEG_JOINT),
    "Joints of the chain by letter, or by letter and number (R1, R2) if a letter occurs twice.",
);
const LEG_BODIES: Field = field("bodies", Named(BODY), "Bodies of the chain by name.");
const LEG_ACTUATORS: Field = field(
    "actuators",
    Named(LEG_ACTUATOR),
    "Drive trains of each leg, by the name of the joint of the chain that they drive. They have \
     the names of the joints: leg1.P, leg2.P and so on.",
);

const LEG_SPRINGS: Field = field(
    "springs",
    Named(SPRING),
    "Springs of each leg by name: leg1.NAME, leg2.NAME and so on. Bodies and joints of the leg \
     have their names in the chain; points on the bodies `from` and `to` of the legs are in the \
     frames of these bodies, rotated by the leg's angle.",
);

/// Keys of a group of equal legs.
pub(crate) const LEGS: &[Field] = &[
    required(
        "chain",
        Text,
        "Joints and the bodies between them in order from `from` to `to`, such as \"R cylinder P* \
         rod S\"; * means actuated. Or joints only, \"R P* S\": the names of the bodies are then \
         given by `between`, or are link1, link2 and so on.",
    ),
    field(
        "between",
        Names,
        "Names of the bodies between the joints if `chain` lists only joints: [\"cylinder\", \
         \"rod\"].",
    ),
    field(
        "names",
        Texts,
        "Names of joints and bodies of the chain in the model, with {} in place of the leg's name: \
         { R = \"{}_hinge\", rod = \"{}_rod\" }; by default the leg's name, a dot and the name in \
         the chain.",
    ),
    field("from", Name, "Body from which the legs start; by default the ground."),
    required("to", Name, "Body to which the legs lead."),
    field("about", Axis, "Axis of the rotations that place the legs; by default z."),
    FOOT,
    TIP,
    field("angles", Quantities(Angle), "Angles of the legs: one leg for each angle."),
    field(
        "place",
        List(PLACE),
        "Legs with individual values, instead of `angles`: one leg for each entry.",
    ),
    LEG_JOINTS,
    LEG_BODIES,
    LEG_ACTUATORS,
    LEG_SPRINGS,
];

/// Keys of an entry of `place`, which describes a single leg of a group.
pub(crate) const PLACE: &[Field] = &[
    field("angle", Quantity(Angle), "The leg's angle; by default 0."),
    field("name", Text, "The leg's name; by default leg1, leg2 and so on."),
    FOOT,
    TIP,
    LEG_JOINTS,
    LEG_BODIES,
    LEG_ACTUATORS,
    LEG_SPRINGS,
];
