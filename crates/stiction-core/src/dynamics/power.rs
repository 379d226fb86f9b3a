//! Power balance: an independent check of the forces.
//!
//! Equation (E1) of the book's theory.

use super::rotor::RotorMotion;
use super::spring::spring_powers;
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::statics::AppliedLoad;
use crate::topology::{Actuator, Topology};

/// Powers at one instant, W: `actuators + loads = energy + dissipated`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power {
    /// Power of the actuators, W.
    pub actuators: f64,
    /// Power of external loads and springs on the bodies, W.
    pub loads: f64,
    /// Rate of change of kinetic and gravitational energy, W. For spinning rotors it contains only
    /// the power that the carrying bodies supply.
    pub energy: f64,
    /// Power dissipated by friction, W; nonnegative.
    pub dissipated: f64,
    /// Scale of the residual, W: the sum of the absolute values of all products of force and
    /// velocity, and of moment and angular velocity. It includes forces that do no work, such as
    /// centripetal forces.
    pub turnover: f64,
}

impl Power {
    /// Power balance at rest, all zero.
    pub(super) const NONE: Self =
        Self { actuators: 0.0, loads: 0.0, energy: 0.0, dissipated: 0.0, turnover: 0.0 };

    /// Returns the residual `actuators + loads - energy - dissipated`, W; zero up to round-off.
    pub fn residual(&self) -> f64 {
        self.actuators + self.loads - self.energy - self.dissipated
    }

    /// Computes the power balance at one instant. `dissipated` contains the power that each
    /// friction interface dissipates, W.
    pub fn new(
        topology: &Topology,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        efforts: &[f64],
        dissipated: impl Iterator<Item = f64>,
        loads: &[AppliedLoad<f64>],
    ) -> Self {
        let mut turnover = 0.0;
        let mut sum = |(power, size): (f64, f64)| {
            turnover += size;
            power
        };
        let of_actuator = |(actuator, effort): (&Actuator, &f64)| {
            let power = effort * bodies.actuator_rate(topology, *actuator);
            (power, power.abs())
        };
        let of_load = |load: &AppliedLoad<f64>| {
            let (twist, wrench) = (bodies.twist[load.body.0], load.wrench(bodies));
            let point = bodies.pose[load.body.0].apply(load.point);
            let size = twist.velocity_at(point).norm() * wrench.force.norm()
                + twist.angular.norm() * wrench.moment_about(point).norm();
            (twist.power(wrench), size)
        };
        let actuators =
            topology.actuators.iter().zip(efforts).map(|pair| sum(of_actuator(pair))).sum();
        let of_springs = spring_powers(parameters, bodies)
            .map(|spring| (-(spring.energy_rate + spring.dissipated), spring.turnover));
        let loads = loads.iter().map(of_load).chain(of_springs).map(&mut sum).sum();
        let dissipated = dissipated.map(|power| sum((power, power.abs()))).sum();
        let of_bodies = (1..bodies.pose.len()).map(|b| energy_rate(parameters, bodies, b));
        let of_rotors = parameters.rotors.iter().map(|rotor| {
            let moment = RotorMotion::of(rotor, topology, parameters, bodies).moment;
            let spin = bodies.twist[rotor.body].angular;
            (moment.dot(spin), moment.norm() * spin.norm())
        });
        let energy = of_bodies.chain(of_rotors).map(&mut sum).sum();
        Self { actuators, loads, energy, dissipated, turnover }
    }
}

/// Computes the rate of change of the kinetic and gravitational energy of a body from its motion
/// alone, W, and the sum of the absolute values of the terms of this rate, W.
fn energy_rate(parameters: &Parameters<f64>, bodies: &Bodies<f64>, body: usize) -> (f64, f64) {
    let (pose, twist, acceleration) =
        (bodies.pose[body], bodies.twist[body], bodies.acceleration[body]);
    let com = pose.apply(parameters.com[body]);
    let velocity = twist.velocity_at(com);
    let acceleration_of_com = acceleration.velocity_at(com) + twist.angular.cross(velocity);
    let force = (acceleration_of_com - parameters.gravity) * parameters.mass[body];
    // d/dt (omega . J omega)/2 = omega . J omega'; the gyroscopic moment does no work.
    let spin = pose.rotation.transpose_mul(twist.angular);
    let change = pose.rotation.transpose_mul(acceleration.angular);
    let moment = parameters.inertia[body] * change;
    let size = velocity.norm() * force.norm() + spin.norm() * moment.norm();
    (velocity.dot(force) + spin.dot(moment), size)
}
