//! Keys of drive trains.

use crate::expression::Measure::{
    Angle, AngularDamping, AngularSpeed, Inertia, Lead, Length, Moment, Number, TorquePerCurrent,
};
use crate::fields::Shape::{Axis, Coefficients, Name, Quantity, Table};
use crate::fields::{Field, field, joined, required};

/// Keys of a drive train of a leg. The table of the drive train has the name of the joint that the
/// motor drives.
pub(crate) const LEG_ACTUATOR: &[Field] = &[
    field(
        "ratio",
        Quantity(Number),
        "Revolutions of the motor per revolution of the joint or, with `lead`, of the screw or pulley; not 0, \
         by default 1.",
    ),
    field(
        "lead",
        Quantity(Lead),
        "Travel per revolution of the screw or pulley, for example \"10 mm/rev\" or, for a belt, \
         \"2*pi*20 mm\"; required if the joint translates, not allowed if it rotates.",
    ),
    field(
        "rotor_inertia",
        Quantity(Inertia),
        "Moment of inertia of the rotor and all parts that turn with it, about its axis, at least \
         0; by default 0.",
    ),
    field(
        "efficiency",
        Quantity(Number),
        "Ratio of output to input power of the gear while the motor drives the joint, above 0 and at most 1; by \
         default 1.",
    ),
    field(
        "backward_efficiency",
        Quantity(Number),
        "Ratio of the power at the motor to the power at the joint while the joint drives the motor, at most 1; \
         the gear is self-locking if this value is 0 or negative. By default 2 - 1/`efficiency`: \
         the same loss at the same load in both directions.",
    ),
    field(
        "mesh",
        Table(MESH),
        "Geometry and friction of a screw or worm, instead of the efficiencies.",
    ),
    field("motor_friction", Table(MOTOR_FRICTION), "Friction at the shaft of the motor."),
    field(
        "torque_constant",
        Quantity(TorquePerCurrent),
        "Torque per current of the motor, greater than 0; required for results or logs that \
         contain the current.",
    ),
    field(
        "limits",
        Table(MOTOR_LIMITS),
        "Limits of the motor; results list the limits that are exceeded.",
    ),
    field(
        "rotor_axis",
        Table(ROTOR_AXIS),
        "Axis of the rotor and the body that carries it; the gyroscopic torque and the reactions \
         of the spinning rotor are then included. Mass and inertia of this body must include those \
         of the rotor. By default the results include only the inertia of the rotor that is \
         reflected to the joint.",
    ),
    field(
        "share",
        Quantity(Number),
        "Part of the joint's effort that this motor exerts, from 0 to 1; by default 1. Required if \
         several motors drive one degree of freedom; the shares of these motors must sum to 1. If \
         more motors than joints drive several joints together, `share` is a weight: the efforts \
         of the motors are those with the least sum of effort^2/`share`.",
    ),
];

/// Keys of the table of a drive train.
pub(crate) const ACTUATOR: &[Field] = &joined::<13>(
    &[
        field(
            "joint",
            Name,
            "Joint that the motor drives; if the joint has several degrees of freedom, followed by \
             the name of one, as in \"spindle.slide\". The drive train makes the joint actuated. \
             Required unless `joints` is given.",
        ),
        field(
            "joints",
            Coefficients,
            "Joints that the motor drives together, given instead of `joint`: each joint with a \
             coefficient other than 0. With { a = 1, b = -1 }, the motor turns by `ratio`*(a - b). \
             These joints need as many independent motors as there are joints. The `lead` applies \
             to joints that translate.",
        ),
    ],
    LEG_ACTUATOR,
);

/// Keys of the axis of a rotor.
pub(crate) const ROTOR_AXIS: &[Field] = &[
    required(
        "body",
        Name,
        "Body that carries the motor; in legs, it can also be a body of the \
        chain.",
    ),
    required(
        "axis",
        Axis,
        "Direction of the axis of the rotor in the frame of the body. If the transmission is \
         positive, the rotor turns in the positive sense about it while the joint moves forward.",
    ),
];

/// Keys of the friction of a motor.
pub(crate) const MOTOR_FRICTION: &[Field] = &[
    field(
        "constant",
        Quantity(Moment),
        "Torque that opposes the rotation at any speed, including the no-load torque of the gear, \
         at least 0; by default 0.",
    ),
    field(
        "viscous",
        Quantity(AngularDamping),
        "Viscous coefficient: torque divided by speed, at least 0; by default 0.",
    ),
];

/// Keys of the limits of a motor.
pub(crate) const MOTOR_LIMITS: &[Field] = &[
    field(
        "peak",
        Quantity(Moment),
        "Greatest permitted torque, greater than 0; by default no \
        limit.",
    ),
    field(
        "rated",
        Quantity(Moment),
        "Greatest permitted root mean square of the torque over the motion, greater than 0; by \
         default no limit.",
    ),
    field(
        "speed",
        Quantity(AngularSpeed),
        "Greatest permitted speed, greater than 0; by default \
        no limit.",
    ),
];

/// Keys of the friction in the mesh of a screw or worm.
pub(crate) const MESH: &[Field] = &[
    required("mu", Quantity(Number), "Friction coefficient of the flanks, at least 0."),
    field(
        "lead_angle",
        Quantity(Angle),
        "Lead angle of the flanks, between 0 and 90 degrees; required unless it follows from \
         `radius` and `lead`.",
    ),
    field(
        "radius",
        Quantity(Length),
        "Mean radius of the flanks of a screw, greater than 0; it determines the lead angle \
         together with `lead`, and replaces `lead_angle`.",
    ),
    required(
        "flank_angle",
        Quantity(Angle),
        "Half the angle between the flanks of a screw in a section along the axis, from 0 (a \
         square thread) to below 90 degrees; for a worm, its axial pressure angle.",
    ),
];
