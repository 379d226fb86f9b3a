//! Torque, power and losses of a motor for a given effort and motion at the output of its gear.
//!
//! Equations (G3), (G4), (G6) of the book's theory.

use super::{DriveTrain, RotorAxis};
use crate::spatial::{Pose, Twist};

/// Torque and power balance of a motor and its gear at one instant:
/// `power = output + rotor_power + friction_power + gear_loss`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motor {
    /// Torque that the motor's current produces, N m. At rest, the value excludes friction and gear
    /// loss.
    pub torque: f64,
    /// Least and greatest torque, N m. At rest, these are the limits of the torques that hold the
    /// joint. In motion, they differ only if the joint's effort is given as an interval.
    pub torque_bounds: (f64, f64),
    /// Angular rate of the motor, rad/s.
    pub speed: f64,
    /// Angular acceleration of the motor relative to the body that carries it, rad/s^2.
    pub acceleration: f64,
    /// Effort that this motor exerts at the output of its gear, N or N m.
    pub effort: f64,
    /// Mechanical power of the motor, W.
    pub power: f64,
    /// Mechanical power that the gear delivers to the joint, W.
    pub output: f64,
    /// Power that accelerates the rotor, W. If only the reflected inertia acts, this is the rate of
    /// change of the rotor's kinetic energy.
    pub rotor_power: f64,
    /// Power dissipated by the friction of the motor, W.
    pub friction_power: f64,
    /// Power dissipated in the gear, W.
    pub gear_loss: f64,
}

impl Motor {
    /// Returns `true` if friction holds the joint at rest without motor torque: `torque_bounds`
    /// then include zero.
    pub fn holds_without_power(&self) -> bool {
        let (low, high) = self.torque_bounds;
        low <= 0.0 && high >= 0.0
    }
}

impl DriveTrain {
    /// Computes torque and power balance of the motor from the motion and the effort at the output
    /// of its gear.
    ///
    /// `effort` (N or N m, from [`MotorMap`](super::MotorMap)) and its interval `bounds` belong to
    /// the gear's output, and so do the rate and acceleration of the output coordinate. The rate is
    /// `None` at rest, where static friction of motor and gear admits an interval of torques.
    /// `carrier` is the angular acceleration (rad/s^2) of the body that carries the rotor, about
    /// the rotor's axis; zero if only the reflected inertia acts.
    pub fn motor(
        &self,
        effort: f64,
        bounds: (f64, f64),
        rate: Option<f64>,
        acceleration: f64,
        carrier: f64,
    ) -> Motor {
        let n = self.transmission();
        let acceleration = n * acceleration;
        let inertial = self.rotor_inertia * (acceleration + carrier);
        let friction = self.motor_friction;
        let Some(rate) = rate else {
            let mut interval = (f64::INFINITY, f64::NEG_INFINITY);
            for effort in candidates(bounds) {
                for input in self.inputs(effort) {
                    interval = (interval.0.min(input), interval.1.max(input));
                }
            }
            return Motor {
                torque: inertial + effort / n,
                torque_bounds: (
                    inertial + interval.0 - friction.constant,
                    inertial + interval.1 + friction.constant,
                ),
                acceleration,
                effort,
                ..Motor::default()
            };
        };
        let speed = n * rate;
        let resistance = friction.constant * sign(speed) + friction.viscous * speed;
        let input = |effort: f64| {
            let [driving, driven] = self.inputs(effort);
            if effort * rate > 0.0 { driving } else { driven }
        };
        let torque = |effort: f64| inertial + resistance + input(effort);
        let mut interval = (f64::INFINITY, f64::NEG_INFINITY);
        for effort in candidates(bounds) {
            let torque = torque(effort);
            interval = (interval.0.min(torque), interval.1.max(torque));
        }
        let output = effort * rate;
        Motor {
            torque: torque(effort),
            torque_bounds: interval,
            speed,
            acceleration,
            effort,
            power: torque(effort) * speed,
            output,
            rotor_power: inertial * speed,
            friction_power: resistance * speed,
            gear_loss: input(effort) * speed - output,
        }
    }

    /// Computes the angular acceleration (rad/s^2) of the body that carries the rotor, about the
    /// rotor's axis, from the poses and accelerations of all bodies. Returns zero if only the
    /// reflected inertia acts.
    pub fn acceleration_of_carrier(
        &self,
        poses: &[Pose<f64>],
        accelerations: &[Twist<f64>],
    ) -> f64 {
        self.rotor_axis.map_or(0.0, |RotorAxis { body, axis }| {
            (poses[body.0].rotation * axis).dot(accelerations[body.0].angular)
        })
    }

    /// Computes two torques (N m) at the input of the gear for an effort at its output: the first
    /// applies while the motor drives the load, the second while the load drives the motor.
    fn inputs(&self, effort: f64) -> [f64; 2] {
        let (forward, backward) = self.gear.efficiencies();
        let ideal = effort / self.transmission();
        [ideal / forward, times(ideal, backward)]
    }
}

/// Multiplies an effort by a factor. Returns zero for a zero factor, even if the effort is
/// infinite.
pub(super) fn times(effort: f64, factor: f64) -> f64 {
    if factor == 0.0 { 0.0 } else { effort * factor }
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Lists the efforts at which a piecewise linear function with a kink at zero can have its extreme
/// values in an interval: the ends of the interval, and zero if it lies between the ends.
fn candidates((low, high): (f64, f64)) -> impl Iterator<Item = f64> {
    let kink = (low < 0.0 && high > 0.0).then_some(0.0);
    [low, high].into_iter().chain(kink)
}
