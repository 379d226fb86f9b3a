//! Keys of the friction of joints.

use crate::expression::Measure::{
    Angle, Force, Length, Number, PerLength, PerSpeed, Speed, Viscous,
};
use crate::fields::Shape::{Choice, Pairs, Quantity, Table};
use crate::fields::{Field, field, joined};

const MU: Field = field("mu", Quantity(Number), "Coulomb coefficient, at least 0; by default 0.");
const MU_STATIC: Field = field(
    "mu_static",
    Quantity(Number),
    "Static coefficient, at least `mu`; by default equal to `mu`. If `stribeck_velocity` is given, \
     `mu_static` is also the limit of the sliding coefficient at zero speed.",
);
const VISCOUS: Field = field(
    "viscous",
    Quantity(Viscous),
    "Viscous coefficient at the sliding surface: force divided by sliding speed, at least 0; by default 0. For a \
     surface that turns, it can also be given as moment divided by angular rate, such as \"2 mN \
     m s/rad\"; this value is then divided by the square of the radius (for a thread, by radius² + \
     pitch²).",
);
const STRIBECK_VELOCITY: Field = field(
    "stribeck_velocity",
    Quantity(Speed),
    "Sliding speed at which the difference between the coefficient and `mu` is 1/e of `mu_static - mu`; \
     greater than 0.",
);
const STRIBECK_EXPONENT: Field = field(
    "stribeck_exponent",
    Quantity(Number),
    "Exponent of the Stribeck curve, greater than 0; by default 2.",
);
const TABLE: Field = field(
    "table",
    Pairs(Speed, Number),
    "Coefficient as a function of the sliding speed, instead of `mu`: two or more rows [speed, \
     coefficient] with increasing speeds, the first of which is 0; linear between rows, constant \
     beyond the last.",
);
const LAW: Field = field(
    "law",
    Choice(FRICTION_LAWS),
    "Friction law; by default coulomb or stribeck, depending on the other keys. Inverse dynamics \
     evaluates laws with an internal state (dahl, lugre) in steady sliding.",
);
const SIGMA0: Field = field(
    "sigma0",
    Quantity(PerLength),
    "Bristle stiffness of Dahl's law and of the LuGre model, per newton of normal force.",
);
const SIGMA1: Field = field(
    "sigma1",
    Quantity(PerSpeed),
    "Bristle damping of the LuGre model, per newton of normal force.",
);
const SIGMA2: Field = field(
    "sigma2",
    Quantity(Viscous),
    "Viscous coefficient of the LuGre model, another name for `viscous`.",
);
const REGULARISED: Field = field(
    "regularised",
    Choice(&["tanh"]),
    "Multiplies the coefficient by tanh(speed / `regularisation_velocity`). Such an interface creeps \
     instead of sticking.",
);
const REGULARISATION_VELOCITY: Field = field(
    "regularisation_velocity",
    Quantity(Speed),
    "Sliding speed of the regularisation, greater than 0; required with `regularised`.",
);
const BACKWARD: Field = field(
    "backward",
    Table(BACKWARD_LAW),
    "Values for backward sliding that differ from those for forward sliding; not possible for a \
     ball, a plate or a sleeve.",
);
const RADIUS: Field = field(
    "radius",
    Quantity(Length),
    "Radius of the pin, sleeve or ball, mean radius of the thread's flanks, effective radius of a plate, \
     greater than 0; required for interfaces that turn, not allowed for those that translate.",
);
const BENDING_SPAN: Field = field(
    "bending_span",
    Quantity(Length),
    "Distance between the two supports of a pin, sleeve, guide or nut, or distance across a plate, \
     greater than 0. A bending moment then adds a normal force of twice the moment divided by this \
     distance.",
);
const COLLAR_RADIUS: Field = field(
    "collar_radius",
    Quantity(Length),
    "Radius of the collar at which the axial force of a pin acts, at least 0.",
);
const TORSION_ARM: Field = field(
    "torsion_arm",
    Quantity(Length),
    "Lever arm at which a guide carries the moment about its axis, greater than 0.",
);
const PRELOAD: Field = field(
    "preload",
    Quantity(Force),
    "Constant normal force on the sliding surface, at least 0; by default 0.",
);
const COMBINE: Field = field(
    "combine",
    Choice(&["sum", "pads", "root-sum-square"]),
    "Combination of the parts of the normal force: sum of all parts (the default); pads, where \
     lateral force and bending moment are combined at each of two pads; or the root of the sum of \
     squares.",
);
const SUPPORTS: Field = field(
    "supports",
    Choice(&["from", "to"]),
    "Body that carries both supports, half of `bending_span` in front of its joint origin and half behind it; by \
     default `from`.",
);
const GLAND: Field = field(
    "gland",
    Quantity(Length),
    "Position of a single support on `from`, along the axis from the joint's origin; together with \
     `piston`, instead of `bending_span`.",
);
const PISTON: Field = field(
    "piston",
    Quantity(Length),
    "Position of a single support on `to`, along the axis from the joint's origin there.",
);
const FLANK_ANGLE: Field = field(
    "flank_angle",
    Quantity(Angle),
    "Half the angle between the flanks of a thread in a section along its axis, from 0 (a square \
     thread) to below 90 degrees; required for the friction of an H joint.",
);
const SMOOTHING: Field = field(
    "smoothing",
    Quantity(Force),
    "Force that smooths the magnitude of each part x of the normal force near zero: sqrt(x^2 + \
     smoothing^2) - smoothing replaces |x|. By default 0, no smoothing.",
);

/// Names of the friction laws.
const FRICTION_LAWS: &[&str] = &["coulomb", "stribeck", "exponential", "dahl", "lugre"];

/// Keys whose values can differ for backward sliding.
pub(crate) const BACKWARD_LAW: &[Field] =
    &[MU, MU_STATIC, VISCOUS, STRIBECK_VELOCITY, STRIBECK_EXPONENT, TABLE];

/// Keys of a friction interface.
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

/// Keys of the tables for separate friction interfaces of U and C joints.
const PARTS: &[Field] = &[
    field(
        "first",
        Table(INTERFACE),
        "Values at the first axis of a U joint that differ from those \
        of this table.",
    ),
    field(
        "second",
        Table(INTERFACE),
        "Values at the second axis of a U joint that differ from \
        those of this table.",
    ),
    field(
        "angle",
        Table(INTERFACE),
        "Friction of the pin of a C joint, if pin and guide are separate surfaces.",
    ),
    field(
        "slide",
        Table(INTERFACE),
        "Friction of the guide of a C joint, if pin and guide are separate surfaces.",
    ),
];

/// Keys of the friction of a joint.
pub(crate) const JOINT_FRICTION: &[Field] = &joined::<28>(INTERFACE, PARTS);
