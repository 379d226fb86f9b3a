//! Friction of joints.

use crate::expression::Measure::{
    Angle, Force, Length, Number, PerLength, PerSpeed, Speed, Viscous,
};
use crate::fields::Shape::{Choice, Pairs, Quantity, Table};
use crate::fields::{Field, field, joined};

const MU: Field = field("mu", Quantity(Number), "Coulomb coefficient, at least 0; by default 0.");
const MU_STATIC: Field = field(
    "mu_static",
    Quantity(Number),
    "Coefficient at rest, at least `mu`; by default as while sliding. With `stribeck_velocity` that of \
     the slowest sliding, too.",
);
const VISCOUS: Field = field(
    "viscous",
    Quantity(Viscous),
    "Viscous coefficient at the sliding surface, also of a pin: force over sliding speed, at least 0; by \
     default 0.",
);
const STRIBECK_VELOCITY: Field = field(
    "stribeck_velocity",
    Quantity(Speed),
    "Sliding speed by which the coefficient has come down from `mu_static` to `mu`, but for 1/e of the \
     difference; greater than 0.",
);
const STRIBECK_EXPONENT: Field = field(
    "stribeck_exponent",
    Quantity(Number),
    "Exponent of the Stribeck curve, greater than 0; by default 2.",
);
const TABLE: Field = field(
    "table",
    Pairs(Speed, Number),
    "Coefficients over the sliding speed, instead of `mu`: rows [speed, coefficient] from the speed 0 \
     upwards, two or more, straight between them, constant beyond the last.",
);
const LAW: Field = field(
    "law",
    Choice(FRICTION_LAWS),
    "The kind of friction; by default what the other keys amount to, coulomb or stribeck. \
     Inverse dynamics takes laws with a state (dahl, lugre) as in steady sliding.",
);
const SIGMA0: Field = field(
    "sigma0",
    Quantity(PerLength),
    "Stiffness of the bristles of Dahl's law and of the LuGre model, for each newton of load.",
);
const SIGMA1: Field = field(
    "sigma1",
    Quantity(PerSpeed),
    "Damping of the bristles of the LuGre model, for each newton of load.",
);
const SIGMA2: Field = field(
    "sigma2",
    Quantity(Viscous),
    "Viscous coefficient of the LuGre model: the same as `viscous`.",
);
const REGULARISED: Field = field(
    "regularised",
    Choice(&["tanh"]),
    "The coefficient is multiplied by tanh(speed / `regularisation_velocity`): nothing sticks, it \
     creeps.",
);
const REGULARISATION_VELOCITY: Field = field(
    "regularisation_velocity",
    Quantity(Speed),
    "The sliding speed of the regularisation, greater than 0; required with it.",
);
const BACKWARD: Field = field(
    "backward",
    Table(BACKWARD_LAW),
    "What is different where the contact slides backward; not for a ball or a plate.",
);
const RADIUS: Field = field(
    "radius",
    Quantity(Length),
    "Radius of the pin or ball, mean radius of the thread's flanks, effective radius of a plate, \
     greater than 0; required where a contact turns, refused where it slides straight.",
);
const BENDING_SPAN: Field = field(
    "bending_span",
    Quantity(Length),
    "Distance of the two supports of a pin, guide or nut, or across a plate: bending moments then load \
     the surface with twice the moment over it. Greater than 0.",
);
const COLLAR_RADIUS: Field = field(
    "collar_radius",
    Quantity(Length),
    "Radius at which a collar takes the axial force of a pin, at least 0.",
);
const TORSION_ARM: Field = field(
    "torsion_arm",
    Quantity(Length),
    "Arm at which a guide takes the moment about its axis, greater than 0.",
);
const PRELOAD: Field = field(
    "preload",
    Quantity(Force),
    "Constant load on the sliding surface, at least 0; by default 0.",
);
const COMBINE: Field = field(
    "combine",
    Choice(&["sum", "pads", "root-sum-square"]),
    "How the parts of the load add: all together (the default), lateral force and bending moment at \
     each of two pads, or as the root of their squares.",
);
const SUPPORTS: Field = field(
    "supports",
    Choice(&["from", "to"]),
    "The body on which both supports are, half of `bending_span` before and behind its joint origin; \
     by default `from`.",
);
const GLAND: Field = field(
    "gland",
    Quantity(Length),
    "Place of a single support on `from`, along the axis from the joint's origin; with `piston` \
     instead of `bending_span`.",
);
const PISTON: Field = field(
    "piston",
    Quantity(Length),
    "Place of a single support on `to`, along the axis from the joint's origin there.",
);
const FLANK_ANGLE: Field = field(
    "flank_angle",
    Quantity(Angle),
    "Half the angle between the flanks of a thread in a section along its axis, from 0 (a square thread) to \
     below 90 degrees; required for an H joint.",
);
const SMOOTHING: Field = field(
    "smoothing",
    Quantity(Force),
    "Rounds off the corner of the load where its parts vanish: sqrt(x^2 + smoothing^2) - smoothing. By \
     default the corner is sharp.",
);

/// Friction laws by name.
const FRICTION_LAWS: &[&str] = &["coulomb", "stribeck", "exponential", "dahl", "lugre"];

/// What may be different while sliding backward.
pub(crate) const BACKWARD_LAW: &[Field] =
    &[MU, MU_STATIC, VISCOUS, STRIBECK_VELOCITY, STRIBECK_EXPONENT, TABLE];

/// One sliding contact.
pub(crate) const INTERFACE: &[Field] = &[
    LAW,
    MU,
    MU_STATIC,
    VISCOUS,
    STRIBECK_VELOCITY,
    STRIBECK_EXPONENT,
    TABLE,
    SIGMA0,
    SIGMA1,
    SIGMA2,
    REGULARISED,
    REGULARISATION_VELOCITY,
    BACKWARD,
    RADIUS,
    BENDING_SPAN,
    COLLAR_RADIUS,
    TORSION_ARM,
    PRELOAD,
    COMBINE,
    SUPPORTS,
    GLAND,
    PISTON,
    FLANK_ANGLE,
    SMOOTHING,
];

/// Contacts of joints that have two of them.
const PARTS: &[Field] = &[
    field("first", Table(INTERFACE), "What is different at the first axis of a U joint."),
    field("second", Table(INTERFACE), "What is different at the second axis of a U joint."),
    field("angle", Table(INTERFACE), "What is different at the turning contact of a C joint."),
    field("slide", Table(INTERFACE), "What is different at the sliding contact of a C joint."),
];

/// The friction of a joint.
pub(crate) const JOINT_FRICTION: &[Field] = &joined::<28>(INTERFACE, PARTS);
