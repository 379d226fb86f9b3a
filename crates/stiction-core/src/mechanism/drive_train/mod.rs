//! Drive trains: each is a motor with a lossy gear or screw that drives one or several joint
//! coordinates.
//!
//! Equations (G1), (G2) and (G10) of the book's theory.

mod mesh;
mod motor;
mod shared;
mod sharing;
mod spec;

pub use mesh::Mesh;
pub use motor::Motor;
pub use shared::{GearInput, SharedMotors};
pub(super) use sharing::{Group, check_shares, motor_maps};
pub use sharing::{MotorMap, MotorTerm};
pub use spec::DriveTrainSpec;
pub(super) use spec::check_rotors;

use super::{BodyId, GearedDof, JointId};
use crate::spatial::Vec3;
use core::f64::consts::TAU;

/// Drive train: a rotary motor with a transmission to one or several degrees of freedom of joints.
///
/// The output coordinate `u` is the joint coordinate, or a weighted sum of several joint
/// coordinates. With the transmission `n`, the motor turns by `n u`, and its torque
///
/// ```text
/// tau_m = J n u'' + c sgn(n u') + b n u' + tau_g
/// ```
///
/// accelerates the rotor, overcomes the friction of the motor, and drives the gear with the torque
/// `tau_g`. The gear exerts the effort `tau_o` on the output coordinate. While the motor drives the
/// load, `tau_g = tau_o / (n efficiency)`; while the load drives the motor,
/// `tau_g = backward_efficiency tau_o / n`.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveTrain {
    /// Name, unique among the drive trains of the mechanism.
    pub name: String,
    /// Degrees of freedom that the motor drives; at least one, each listed once.
    pub dofs: Vec<GearedDof>,
    /// Nonzero ratio: revolutions of the motor per revolution of the output or, if `lead` is given,
    /// per revolution of the screw or pulley.
    pub ratio: f64,
    /// Nonzero travel per revolution of the screw or pulley, m; only for degrees of freedom that
    /// translate.
    pub lead: Option<f64>,
    /// Weight of this motor if several motors share the efforts of joints, otherwise one. If the
    /// motors share a single degree of freedom, the weight is a fraction: in inverse dynamics, the
    /// fraction of the effort that this motor exerts at the output of its gear; in simulations, the
    /// fraction of the actuator effort that its torque produces.
    pub share: f64,
    /// Moment of inertia of all parts that turn with the motor, about the motor's axis, kg m^2;
    /// nonnegative.
    pub rotor_inertia: f64,
    /// Axis of the rotor, and the body that carries the rotor. If `None`, the rotor acts only by
    /// its reflected inertia at the joint.
    pub rotor_axis: Option<RotorAxis>,
    /// Loss of the gear or screw that depends on the transmitted load.
    pub gear: GearLoss,
    /// Friction at the motor's shaft that does not depend on the load.
    pub motor_friction: MotorFriction,
    /// Torque per unit current, N m/A; positive. `None` if it is not known.
    pub torque_constant: Option<f64>,
    /// Limits on torque and speed of the motor.
    pub limits: MotorLimits,
}

/// Axis about which a rotor spins. The mass and inertia of the carrying body must include those of
/// the rotor at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorAxis {
    /// Body that carries the motor.
    pub body: BodyId,
    /// Unit vector along the axis, in the body's frame. If the transmission is positive, the motor
    /// turns in the positive sense about this vector when the joint moves in the positive
    /// direction.
    pub axis: Vec3<f64>,
}

/// Loss of a gear or screw that depends on the transmitted load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GearLoss {
    /// Two constant efficiencies, one for each direction of power.
    Efficiency {
        /// Output power divided by input power while the motor drives the joint; above zero, at
        /// most one.
        forward: f64,
        /// Input power divided by output power while the joint drives the motor; at most one. If
        /// the value is zero or negative, the gear is self-locking: the motor must drive the gear
        /// in both directions of motion.
        backward: f64,
    },
    /// Friction at the inclined flank of a screw or a worm.
    Mesh(Mesh),
}

/// Friction torque at a motor's shaft that does not depend on the transmitted load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorFriction {
    /// Constant friction torque, including the no-load torque of the gear, N m; nonnegative.
    pub constant: f64,
    /// Viscous friction torque per unit angular rate, N m s/rad; nonnegative.
    pub viscous: f64,
}

/// Limits of a motor; each is positive if given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorLimits {
    /// Peak torque, N m: the greatest magnitude of the torque at any time.
    pub peak: Option<f64>,
    /// Rated torque, N m: the greatest root mean square of the torque over a cycle of the motion.
    pub rated: Option<f64>,
    /// Greatest magnitude of the speed, rad/s.
    pub speed: Option<f64>,
}

impl GearLoss {
    /// Gear without loss.
    pub const NONE: Self = Self::Efficiency { forward: 1.0, backward: 1.0 };

    /// Creates the loss of a gear from its `efficiency` while the motor drives the load. The power
    /// loss at a given effort is assumed to be the same in both directions of power, so the
    /// efficiency while the load drives the motor is `2 - 1/efficiency`.
    pub fn of_efficiency(efficiency: f64) -> Self {
        Self::Efficiency { forward: efficiency, backward: 2.0 - efficiency.recip() }
    }

    /// Returns two efficiencies: the first applies while the motor drives the joint, the second
    /// while the joint drives the motor.
    pub fn efficiencies(&self) -> (f64, f64) {
        match self {
            Self::Efficiency { forward, backward } => (*forward, *backward),
            Self::Mesh(mesh) => mesh.efficiencies(),
        }
    }
}

impl DriveTrain {
    /// Returns the transmission `n`: angle of the motor per unit of the output coordinate. The unit
    /// is rad/m if all degrees of freedom of the drive train translate, otherwise rad/rad.
    pub fn transmission(&self) -> f64 {
        match self.lead {
            Some(lead) if self.translates() => self.ratio * (TAU / lead),
            _ => self.ratio,
        }
    }

    /// Returns `true` if the output coordinate is a length. This is the case if all degrees of
    /// freedom translate.
    pub fn translates(&self) -> bool {
        self.dofs.iter().all(|driven| driven.translates)
    }

    /// Lists the degrees of freedom on which the output coordinate `u` depends, each with the
    /// derivative `du/dq`. If some of them rotate and others translate, `u` is an angle, and the
    /// derivatives with respect to translations include the lead.
    pub fn output_parts(&self) -> impl Iterator<Item = (JointId, usize, f64)> + '_ {
        let mixed = !self.translates();
        self.dofs.iter().map(move |driven| {
            let turn = match self.lead {
                Some(lead) if mixed && driven.translates => TAU / lead,
                _ => 1.0,
            };
            (driven.joint, driven.dof, driven.coefficient * turn)
        })
    }

    /// Returns the joint and its degree of freedom if the drive train drives a single degree of
    /// freedom, otherwise `None`.
    pub fn only_dof(&self) -> Option<(JointId, usize)> {
        match self.dofs[..] {
            [GearedDof { joint, dof, .. }] => Some((joint, dof)),
            _ => None,
        }
    }

    /// Returns `true` if the drive train drives this degree of freedom.
    pub fn moves(&self, joint: JointId, dof: usize) -> bool {
        self.dofs.iter().any(|driven| (driven.joint, driven.dof) == (joint, dof))
    }

    /// Returns the inertia of the rotor reflected to the output coordinate, `n^2 J`, kg m^2 or kg.
    pub fn reflected_inertia(&self) -> f64 {
        let n = self.transmission();
        n * n * self.rotor_inertia
    }

    /// Returns `true` if the motor has friction.
    pub fn has_motor_friction(&self) -> bool {
        self.motor_friction != MotorFriction::default()
    }

    /// Returns the power losses of the gear per unit of output power: `1/efficiency - 1` while the
    /// motor drives the load, and `1 - backward_efficiency` while the load drives the motor. `None`
    /// for a gear without loss.
    pub fn losses(&self) -> Option<[f64; 2]> {
        let (forward, backward) = self.gear.efficiencies();
        let losses = [forward.recip() - 1.0, 1.0 - backward];
        (losses != [0.0; 2]).then_some(losses)
    }

    /// Returns `true` if the motor or the gear has friction.
    pub fn has_friction(&self) -> bool {
        self.has_motor_friction() || self.losses().is_some()
    }

    /// Returns a copy of the drive train without friction in motor and gear.
    pub fn without_friction(&self) -> Self {
        let motor_friction = MotorFriction::default();
        Self { gear: GearLoss::NONE, motor_friction, ..self.clone() }
    }
}
