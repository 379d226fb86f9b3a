//! Energy and power of springs, computed from lengths, coordinates and deflections. They are
//! independent of the spring wrenches, which they serve to check.

use super::bushing::BushingForce;
use super::{SpringForce, joint};
use crate::kinematics::Bodies;
use crate::parameters::{BushingParameters, JointSpringParameters, Parameters, SpringParameters};
use crate::scalar::Scalar;
use crate::spatial::{Twist, Vec3, Wrench};

/// Energy and power of one spring or bushing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpringPower<T> {
    /// Stored energy, J; zero at the rest position of the spring, also with a preload.
    pub(crate) energy: T,
    /// Rate of change of the stored energy, W.
    pub(crate) energy_rate: T,
    /// Power dissipated by the damper, W.
    pub(crate) dissipated: T,
    /// Scale of round-off in the power, W: the sum of the absolute values of the products of the
    /// velocities of both bodies and the wrench.
    pub(crate) turnover: T,
}

/// Computes energy and power of all springs and bushings.
pub(crate) fn spring_powers<'a, T: Scalar>(
    parameters: &'a Parameters<T>,
    bodies: &'a Bodies<T>,
) -> impl Iterator<Item = SpringPower<T>> + 'a {
    let of_points = parameters.springs.iter().map(|spring| of_spring(spring, bodies));
    let joints = parameters.joint_springs.iter().zip(&bodies.spring_coordinates);
    let of_joints = joints.map(|(spring, &coordinate)| of_joint(spring, bodies, coordinate));
    let of_bushings = parameters.bushings.iter().map(|bushing| of_bushing(bushing, bodies));
    of_points.chain(of_joints).chain(of_bushings)
}

fn of_spring<T: Scalar>(spring: &SpringParameters<T>, bodies: &Bodies<T>) -> SpringPower<T> {
    let now = SpringForce::of(spring, bodies);
    let longer = now.length - spring.free_length;
    SpringPower {
        energy: T::from_f64(0.5) * spring.stiffness * longer * longer - spring.preload * longer,
        energy_rate: (spring.stiffness * longer - spring.preload) * now.rate,
        dissipated: spring.damping * now.rate * now.rate,
        turnover: now.turnover(spring, bodies),
    }
}

fn of_joint<T: Scalar>(
    spring: &JointSpringParameters<T>,
    bodies: &Bodies<T>,
    coordinate: T,
) -> SpringPower<T> {
    let rate = joint::rate(spring, bodies);
    let off = coordinate - spring.rest;
    let wrench = joint::wrench(spring, bodies, coordinate);
    let at = bodies.frame_k[spring.joint].position;
    SpringPower {
        energy: T::from_f64(0.5) * spring.stiffness * off * off - spring.preload * off,
        energy_rate: (spring.stiffness * off - spring.preload) * rate,
        dissipated: spring.damping * rate * rate,
        turnover: both(spring.ends, bodies, wrench, at),
    }
}

fn of_bushing<T: Scalar>(bushing: &BushingParameters<T>, bodies: &Bodies<T>) -> SpringPower<T> {
    let now = BushingForce::of(bushing, bodies);
    let (force, moment) = bushing.stiffness.times(now.deflection);
    let (displacement, rotation) = now.deflection;
    let (linear, rotation_rate) = now.deflection_rate;
    let (damping_force, damping_moment) = bushing.damping.times((linear, now.angular));
    let at = (bodies.pose[bushing.ends[1]] * bushing.frames[1]).position;
    SpringPower {
        energy: T::from_f64(0.5) * (force.dot(displacement) + moment.dot(rotation)),
        energy_rate: force.dot(linear) + moment.dot(rotation_rate),
        dissipated: damping_force.dot(linear) + damping_moment.dot(now.angular),
        turnover: both(bushing.ends, bodies, now.wrench, at),
    }
}

/// Returns the sum, over both bodies, of the magnitude of velocity times force plus the magnitude
/// of angular velocity times moment, W. Velocities and moment refer to `point`.
fn both<T: Scalar>(ends: [usize; 2], bodies: &Bodies<T>, wrench: Wrench<T>, point: Vec3<T>) -> T {
    let size = |body: usize| {
        let twist: Twist<T> = bodies.twist[body];
        twist.velocity_at(point).norm() * wrench.force.norm()
            + twist.angular.norm() * wrench.moment_about(point).norm()
    };
    size(ends[0]) + size(ends[1])
}
