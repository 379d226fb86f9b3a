//! Keys of drive trains.

use crate::expression::Measure::{
    Angle, AngularDamping, AngularSpeed, Inertia, Lead, Length, Moment, Number, TorquePerCurrent,
};
use crate::fields::Shape::{Axis, Coefficients, Name, Quantity, Table};
use crate::fields::{Field, field, joined, required};

/// Keys of a drive train of a leg; the joint is the name of its table.
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
        "Travel per revolution of the screw or pulley, for example \"10 mm/rev\" or, for a belt, \"2*pi*20 mm\"; \
         required for a joint that translates, not allowed for others.",
    ),
    field(
        "rotor_inertia",
        Quantity(Inertia),
        "Moment of inertia of all that turns with the motor, about its axis, at least 0; by default 0.",
    ),
    field(
        "efficiency",
        Quantity(Number),
        "Output power over input power of the gear while the motor drives the joint, above 0 and at most 1; \
         by default 1.",
    ),
    field(
        "backward_efficiency",
        Quantity(Number),
        "Power at the motor over power at the joint while the joint drives the motor, at most 1; at or below \
         0 the gear is self-locking. By default 2 - 1/`efficiency`: the same loss at the same load in both \
         directions.",
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
        "Torque per current, greater than 0; required for the current.",
    ),
    field(
        "limits",
        Table(MOTOR_LIMITS),
        "Limits of the motor; results name those that are exceeded.",
    ),
    field(
        "rotor_axis",
        Table(ROTOR_AXIS),
        "Axis and carrying body of a spinning rotor, whose gyroscopic torque and reactions then count; mass and \
         inertia of the body include those of the rotor. By default the rotor is only reflected to the joint.",
    ),
    field(
        "share",
        Quantity(Number),
        "Part of the joint's effort that this motor exerts, from 0 to 1; by default 1. Required where several \
         motors drive one degree of freedom; their shares sum to 1. Where more motors than joints share the efforts \
         of several joints, the weight of this one: the sum of effort^2/`share` is least.",
    ),
];

/// Keys of a drive train.
pub(crate) const ACTUATOR: &[Field] = &joined::<13>(
    &[
        field(
            "joint",
            Name,
            "Joint that it drives, followed by the degree of freedom where the joint has several: \"spindle.slide\". \
             The drive train actuates it. Required unless it has `joints`.",
        ),
        field(
            "joints",
            Coefficients,
            "Joints that it drives together, each with its coefficient, not 0: with { a = 1, b = -1 } the motor turns by \
             `ratio`*(a - b). It takes as many independent motors as joints. The `lead` applies to joints that \
             translate. Instead of `joint`.",
        ),
    ],
    LEG_ACTUATOR,
);

/// Keys of the axis of a rotor.
pub(crate) const ROTOR_AXIS: &[Field] = &[
    required("body", Name, "Body that carries the motor; in legs also a body of the chain."),
    required(
        "axis",
        Axis,
        "Direction in the body's frame about which the motor turns forward: in the positive sense as the joint moves \
         forward, if the transmission is positive.",
    ),
];

/// Keys of the friction of a motor.
pub(crate) const MOTOR_FRICTION: &[Field] = &[
    field(
        "constant",
        Quantity(Moment),
        "Torque that opposes the rotation at any speed, the no-load torque of the gear included, at least 0; \
         by default 0.",
    ),
    field("viscous", Quantity(AngularDamping), "Torque over speed, at least 0; by default 0."),
];

/// Keys of the limits of a motor.
pub(crate) const MOTOR_LIMITS: &[Field] = &[
    field("peak", Quantity(Moment), "Greatest torque, greater than 0; by default none."),
    field(
        "rated",
        Quantity(Moment),
        "Greatest root mean square of the torque over the motion, greater than 0; by default none.",
    ),
    field("speed", Quantity(AngularSpeed), "Greatest speed, greater than 0; by default none."),
];

/// Keys of the friction in the mesh of a screw or worm.
pub(crate) const MESH: &[Field] = &[
    required("mu", Quantity(Number), "Coefficient of friction, at least 0."),
    field(
        "lead_angle",
        Quantity(Angle),
        "Slope of the flank, between 0 and 90 degrees; required unless `radius` and `lead` give it.",
    ),
    field(
        "radius",
        Quantity(Length),
        "Mean radius of the flanks of a screw with a `lead`, instead of `lead_angle`; greater than 0.",
    ),
    required(
        "flank_angle",
        Quantity(Angle),
        "Half the angle between the flanks in a section along the axis, from 0 (a square thread) to below 90 \
         degrees; of a worm its axial pressure angle.",
    ),
];
