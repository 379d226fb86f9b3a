//! Drive trains: motor, gear or screw, and what they lose, between a motor and a joint coordinate.
//!
//! Equations (G1), (G2) of the book's theory.

mod mesh;
mod motor;
mod spec;

pub use mesh::Mesh;
pub use motor::Motor;
pub use spec::DriveTrainSpec;
pub(super) use spec::check_shares;

use super::JointId;
use core::f64::consts::TAU;

/// Drive train of one motor: a rotary motor with a transmission to one degree of freedom of a joint.
///
/// With the transmission `n`, the motor turns by `n q`, and its torque
///
/// ```text
/// tau_m = J n q'' + c sgn(n q') + b n q' + tau_g
/// ```
///
/// accelerates the rotor, overcomes the friction of the motor, and enters the gear as `tau_g`. The gear
/// exerts its share of the joint's effort `tau_o`: `tau_g = tau_o / (n efficiency)` where it drives the joint,
/// and `tau_g = backward_efficiency tau_o / n` where the joint drives it.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveTrain {
    /// Name, unique among drive trains.
    pub name: String,
    /// Joint that it drives.
    pub joint: JointId,
    /// Index of the degree of freedom in the joint.
    pub dof: usize,
    /// Revolutions of the motor per revolution of the joint or, with a lead, of the screw or pulley; not zero.
    pub ratio: f64,
    /// Travel per revolution of the screw or pulley, m; only for a degree of freedom that translates, not zero.
    pub lead: Option<f64>,
    /// Part of the effort of the degree of freedom that it exerts; one unless several motors share it.
    pub share: f64,
    /// Moment of inertia of all that turns with the motor, about its axis, kg m^2; not negative.
    pub rotor_inertia: f64,
    /// Loss that depends on the load.
    pub gear: GearLoss,
    /// Friction on the side of the motor.
    pub motor_friction: MotorFriction,
    /// Torque per current, N m/A; positive.
    pub torque_constant: Option<f64>,
    /// Limits of the motor.
    pub limits: MotorLimits,
}

/// Load-dependent loss of a gear or screw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GearLoss {
    /// Efficiencies.
    Efficiency {
        /// Output power over input power while the motor drives the joint; above zero, at most one.
        forward: f64,
        /// Input power over output power while the joint drives the motor; at most one. At or below zero the
        /// gear is self-locking: the motor must drive it in both directions.
        backward: f64,
    },
    /// Friction on an inclined flank: a screw or a worm.
    Mesh(Mesh),
}

/// Friction torque on a motor's shaft that does not depend on the load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorFriction {
    /// Constant torque opposing the rotation, N m; not negative. It includes the no-load torque of the gear.
    pub constant: f64,
    /// Torque per angular rate, N m s/rad; not negative.
    pub viscous: f64,
}

/// Limits of a motor; positive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorLimits {
    /// Peak torque, N m.
    pub peak: Option<f64>,
    /// Rated torque, N m: the greatest root mean square over a cycle.
    pub rated: Option<f64>,
    /// Greatest speed, rad/s.
    pub speed: Option<f64>,
}

impl GearLoss {
    /// No loss.
    pub const NONE: Self = Self::Efficiency { forward: 1.0, backward: 1.0 };

    /// Loss of a gear with this efficiency, which loses the same at the same effort in both directions:
    /// the backward efficiency is `2 - 1/efficiency`.
    pub fn of_efficiency(efficiency: f64) -> Self {
        Self::Efficiency { forward: efficiency, backward: 2.0 - efficiency.recip() }
    }

    /// Efficiencies while the motor drives the joint, and while the joint drives the motor.
    pub fn efficiencies(&self) -> (f64, f64) {
        match self {
            Self::Efficiency { forward, backward } => (*forward, *backward),
            Self::Mesh(mesh) => mesh.efficiencies(),
        }
    }
}

impl DriveTrain {
    /// Transmission `n`: angle of the motor over the coordinate of the joint, rad/rad or rad/m.
    pub fn transmission(&self) -> f64 {
        self.lead.map_or(self.ratio, |lead| self.ratio * (TAU / lead))
    }

    /// Inertia of the rotor as the joint coordinate has it, `n^2 J`, kg m^2 or kg.
    pub fn reflected_inertia(&self) -> f64 {
        let n = self.transmission();
        n * n * self.rotor_inertia
    }

    /// True if the motor has friction.
    pub fn has_motor_friction(&self) -> bool {
        self.motor_friction != MotorFriction::default()
    }

    /// Copy without friction in motor and gear.
    pub fn without_friction(&self) -> Self {
        let motor_friction = MotorFriction::default();
        Self { gear: GearLoss::NONE, motor_friction, ..self.clone() }
    }
}
