//! External loads on bodies, and the wrenches that the motion of bodies requires.

use crate::kinematics::Bodies;
use crate::mechanism::{Body, BodyId};
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::spatial::{Vec3, Wrench};

/// Axes in which an external load is expressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadAxes {
    /// World axes: the direction of the load is constant.
    World,
    /// The body's axes: the direction of the load rotates with the body.
    Body,
}

/// External load: a force and a moment on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AppliedLoad<T> {
    /// Body on which the load acts.
    pub body: BodyId,
    /// Point of application of the force, in the body's frame, m.
    pub point: Vec3<T>,
    /// Axes in which `force` and `moment` are expressed.
    pub axes: LoadAxes,
    /// Force, N.
    pub force: Vec3<T>,
    /// Moment about `point`, N m.
    pub moment: Vec3<T>,
}

impl AppliedLoad<f64> {
    /// Converts point, force and moment to constants of another scalar type.
    pub fn lift<T: Scalar>(self) -> AppliedLoad<T> {
        AppliedLoad {
            body: self.body,
            point: self.point.lift(),
            axes: self.axes,
            force: self.force.lift(),
            moment: self.moment.lift(),
        }
    }
}

impl AppliedLoad<f64> {
    /// Computes the load that a part fixed to a body exerts on the body by its weight and inertia
    /// (d'Alembert's principle). Centre of mass and inertia of the part are in the frame of the
    /// body; `gravity`, m/s^2, is in world axes.
    pub fn of_payload(body: BodyId, part: &Body, gravity: Vec3<f64>, bodies: &Bodies<f64>) -> Self {
        let (pose, twist) = (bodies.pose[body.0], bodies.twist[body.0]);
        let acceleration = bodies.acceleration[body.0];
        let com = pose.apply(part.com);
        let omega = twist.angular;
        let of_com = acceleration.velocity_at(com) + omega.cross(twist.velocity_at(com));
        let spin = pose.rotation.transpose_mul(omega);
        let change = pose.rotation.transpose_mul(acceleration.angular);
        let moment = pose.rotation * (part.inertia * change + spin.cross(part.inertia * spin));
        Self {
            body,
            point: part.com,
            axes: LoadAxes::World,
            force: (gravity - of_com) * part.mass,
            moment: moment * -1.0,
        }
    }

    /// Computes the load that a part fixed to a body exerts on the body by its weight alone. The
    /// part's centre of mass is in the frame of the body; `gravity`, m/s^2, is in world axes.
    pub fn of_weight(body: BodyId, part: &Body, gravity: Vec3<f64>) -> Self {
        let force = gravity * part.mass;
        Self { body, point: part.com, axes: LoadAxes::World, force, moment: Vec3::zero() }
    }
}

/// Returns true if two lists of loads act on the same bodies, at the same points and in the same
/// axes; their forces and moments may differ.
pub(crate) fn act_alike(a: &[AppliedLoad<f64>], b: &[AppliedLoad<f64>]) -> bool {
    let place = |load: &AppliedLoad<f64>| (load.body, load.point, load.axes);
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| place(a) == place(b))
}

impl<T: Scalar> AppliedLoad<T> {
    /// Computes the wrench of the load about the reference point, in world axes.
    pub fn wrench(&self, bodies: &Bodies<T>) -> Wrench<T> {
        let pose = bodies.pose[self.body.0];
        let turn = |v| match self.axes {
            LoadAxes::World => v,
            LoadAxes::Body => pose.rotation * v,
        };
        let force = turn(self.force);
        Wrench { force, moment: turn(self.moment) + pose.apply(self.point).cross(force) }
    }
}

/// Computes the total wrench (about the reference point) that the joints of a body must exert for
/// the motion of the body: the rate of change of its momentum minus its weight. External loads are
/// not included.
pub(crate) fn demand_of_motion<T: Scalar>(
    parameters: &Parameters<T>,
    bodies: &Bodies<T>,
    body: usize,
) -> Wrench<T> {
    let (pose, twist, acceleration) =
        (bodies.pose[body], bodies.twist[body], bodies.acceleration[body]);
    let com = pose.apply(parameters.com[body]);
    let omega = twist.angular;
    let acceleration_of_com = acceleration.velocity_at(com) + omega.cross(twist.velocity_at(com));
    let force = (acceleration_of_com - parameters.gravity) * parameters.mass[body];
    // Euler's equation in body axes, in which the inertia tensor is constant.
    let inertia = parameters.inertia[body];
    let spin = pose.rotation.transpose_mul(omega);
    let change = pose.rotation.transpose_mul(acceleration.angular);
    let moment = pose.rotation * (inertia * change + spin.cross(inertia * spin));
    Wrench { force, moment: moment + com.cross(force) }
}
