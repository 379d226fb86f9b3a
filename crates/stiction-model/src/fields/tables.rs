//! The tables of the model file.

use super::Shape::{
    Actuated, Axis, Choice, Inertia, List, Loads, Motions, Name, Named, Names, OneOrMore, Pairs,
    Parameters, Quantities, Quantity, Rotation, Start, Table, Text, Vector,
};
use super::{Field, field, required};
use crate::measure::Measure::{
    Acceleration, Angle, AngularCompliance, Compliance, Damping, Force, Frequency, Length, Mass,
    Moment, Number, PerLength, PerSpeed, Pitch, Speed, Stiffness, Time, Viscous,
};

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

/// Joint types by symbol.
pub(crate) const JOINT_TYPES: &[&str] = &["R", "P", "H", "C", "U", "S", "E", "fixed", "free"];

const AT: Field =
    field("at", Vector(Length), "The joint's origin in the frame of `from`; by default [0, 0, 0].");
const TO_AT: Field = field(
    "to_at",
    Vector(Length),
    "The joint's origin in the frame of `to`; by default [0, 0, 0].",
);
const AXIS: Field = field(
    "axis",
    Axis,
    "Axis of an R, P, H, C joint, first axis of a U joint, normal of an E joint, in the frame of \
     `from`: \"x\", \"y\", \"z\", \"-x\", … or a vector. Required but for S, fixed and free.",
);
const SECOND_AXIS: Field = field(
    "second_axis",
    Axis,
    "Second axis of a U joint at zero coordinates, in the frame of `from`, at right angles to `axis`; \
     required there.",
);
const X_AXIS: Field = field(
    "x_axis",
    Axis,
    "Direction x of the joint's frame, in the frame of `from`, at right angles to `axis`. By default \
     the smallest turn that takes z to the axis takes x to it.",
);
const TURN: Field = field(
    "turn",
    Rotation,
    "Rotation of the frame of `to` relative to that of `from` at zero coordinates; by default none.",
);
const ACTUATED: Field = field(
    "actuated",
    Actuated,
    "Whether the joint is driven; or the names of its driven freedoms.",
);
const START: Field = field(
    "start",
    Start,
    "First guess of the coordinates, for the assembly: one quantity (R, P, H), a list (C: [angle, \
     slide], U: [first, second], E: [x, y, angle]), a rotation (S), a pose (free).",
);
const PITCH: Field = field(
    "pitch",
    Quantity(Pitch),
    "Advance of an H joint, for example \"5 mm/rev\"; required there.",
);
const FRICTION: Field =
    field("friction", Table(JOINT_FRICTION), "Friction that grows with the joint's own reaction.");
const COMPLIANCE: Field = field(
    "compliance",
    Table(JOINT_COMPLIANCE),
    "How much the joint gives under load: it decides how redundant constraints share a load.",
);

/// What a joint gives to.
pub(crate) const JOINT_COMPLIANCE: &[Field] = &[
    field(
        "radial",
        Quantity(Compliance),
        "Displacement across the axis for each unit of force; of an S joint in all directions. At \
         least 0, as all of these; by default 0, rigid.",
    ),
    field("axial", Quantity(Compliance), "Displacement along the axis for each unit of force."),
    field(
        "bending",
        Quantity(AngularCompliance),
        "Angle by which the axis tilts for each unit of moment.",
    ),
    field(
        "torsional",
        Quantity(AngularCompliance),
        "Angle of twist about the axis for each unit of moment; of a U joint about the common normal \
         of its axes.",
    ),
];

/// A joint.
pub(crate) const JOINT: &[Field] = &[
    required(
        "type",
        Choice(JOINT_TYPES),
        "R revolute, P prismatic, H helical, C cylindrical, U universal, S spherical, E planar, fixed, \
         free.",
    ),
    required("from", Name, "The predecessor: the reaction is that of this body on `to`."),
    required("to", Name, "The successor: the body on the other side."),
    AT,
    TO_AT,
    AXIS,
    SECOND_AXIS,
    X_AXIS,
    TURN,
    ACTUATED,
    START,
    PITCH,
    FRICTION,
    COMPLIANCE,
];

/// A joint of a leg: type and bodies are in the chain.
pub(crate) const LEG_JOINT: &[Field] =
    &[AT, TO_AT, AXIS, SECOND_AXIS, X_AXIS, TURN, ACTUATED, START, PITCH, FRICTION, COMPLIANCE];

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
pub(crate) const FRICTION_LAWS: &[&str] = &["coulomb", "stribeck", "exponential", "dahl", "lugre"];

/// What may be different while sliding backward.
pub(crate) const BACKWARD_LAW: &[Field] =
    &[MU, MU_STATIC, VISCOUS, STRIBECK_VELOCITY, STRIBECK_EXPONENT, TABLE];

/// One sliding contact.
pub(crate) const CONTACT: &[Field] = &[
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

/// The friction of a joint.
pub(crate) const JOINT_FRICTION: &[Field] = &[
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
    field("first", Table(CONTACT), "What is different at the first axis of a U joint."),
    field("second", Table(CONTACT), "What is different at the second axis of a U joint."),
    field("angle", Table(CONTACT), "What is different at the turning contact of a C joint."),
    field("slide", Table(CONTACT), "What is different at the sliding contact of a C joint."),
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

/// A motion, besides its coordinates.
pub(crate) const MOTION: &[Field] = &[
    field("title", Text, "One line that says what it is."),
    field("start", Quantity(Time), "First instant; by default 0."),
    field(
        "duration",
        Quantity(Time),
        "Length; by default 1 s. With 0 the motion is a single pose.",
    ),
    field("step", Quantity(Time), "Time between samples of the result."),
    field("file", Text, "A CSV file with samples, instead of expressions; relative to the model."),
];

/// A load case, besides its bodies.
pub(crate) const LOAD: &[Field] = &[field("title", Text, "One line that says what it is.")];

/// What may stand behind the name of a body in a load.
pub(crate) const BODY_LOAD: &[Field] = &[
    field("force", Vector(Force), "Force; components may change with the time `t`."),
    field("moment", Vector(Moment), "Moment about the point `at`."),
    field(
        "at",
        Vector(Length),
        "Where the force acts, in the body's frame; by default its origin.",
    ),
    field(
        "axes",
        Choice(&["world", "body"]),
        "Whether the components are along the world's axes (the default) or turn with the body.",
    ),
    field("fx", Quantity(Force), "x component of the force, instead of `force`."),
    field("fy", Quantity(Force), "y component of the force."),
    field("fz", Quantity(Force), "z component of the force."),
    field("mx", Quantity(Moment), "x component of the moment, instead of `moment`."),
    field("my", Quantity(Moment), "y component of the moment."),
    field("mz", Quantity(Moment), "z component of the moment."),
];

/// What may stand behind the name of a body in a motion.
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

/// Efforts of actuators, besides the actuators.
pub(crate) const DRIVES: &[Field] = &[field("title", Text, "One line that says what they are.")];

/// A controller, besides its actuators.
pub(crate) const CONTROL: &[Field] = &[
    field("title", Text, "One line that says what it is."),
    required("type", Choice(CONTROL_TYPES), "How efforts follow from what is measured."),
    field(
        "friction",
        Choice(FEED_MODES),
        "Whether computed torque contains friction, and for which motion: off (the default), reference, \
         measured.",
    ),
    field("period", Quantity(Time), "Time between two samples of the controller; by default 1 ms."),
    field(
        "bandwidth",
        Quantity(Frequency),
        "Natural frequency of the closed loop without friction; by default 10 Hz.",
    ),
    field("damping", Quantity(Number), "Damping ratio of the closed loop; by default 1."),
    field(
        "rate",
        Choice(RATE_MODES),
        "Whether rates are measured, or differences of two measured positions; the default, with a \
         `resolution`.",
    ),
    field("kp", Quantity(Stiffness), "Effort for an error of position, by `type = \"pd\"`."),
    field("kd", Quantity(Damping), "Effort for an error of the rate, by `type = \"pd\"`."),
    field("resolution", Quantity(Length), "Step of the measured position; by default none."),
    field("limit", Quantity(Force), "Greatest effort; by default none."),
];

/// What may stand behind the name of an actuator in a controller.
pub(crate) const CHANNEL: &[&str] = &["kp", "kd", "resolution", "limit"];

/// Types of controllers.
pub(crate) const CONTROL_TYPES: &[&str] = &["pd", "computed-torque"];

/// Where computed torque takes friction from.
pub(crate) const FEED_MODES: &[&str] = &["off", "reference", "measured"];

/// How rates are measured.
pub(crate) const RATE_MODES: &[&str] = &["measured", "difference"];

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
