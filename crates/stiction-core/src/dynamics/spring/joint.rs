//! Springs that act on degrees of freedom of joints.
//!
//! Equation (B11) of the book's theory.

use crate::kinematics::Bodies;
use crate::parameters::JointSpringParameters;
use crate::scalar::Scalar;
use crate::spatial::Wrench;

/// Returns the rate of the degree of freedom on which the spring acts, rad/s or m/s.
pub(super) fn rate<T: Scalar>(spring: &JointSpringParameters<T>, bodies: &Bodies<T>) -> T {
    let [from, to] = spring.ends;
    (bodies.twist[to] - bodies.twist[from]).power(bodies.effort(&spring.dof, spring.joint))
}

/// Computes the wrench of a joint spring on the successor of its joint, about the reference point
/// in world axes. `coordinate` is the coordinate of the degree of freedom on which the spring acts,
/// rad or m.
pub(super) fn wrench<T: Scalar>(
    spring: &JointSpringParameters<T>,
    bodies: &Bodies<T>,
    coordinate: T,
) -> Wrench<T> {
    let effort = spring.preload
        - spring.stiffness * (coordinate - spring.rest)
        - spring.damping * rate(spring, bodies);
    bodies.effort(&spring.dof, spring.joint) * effort
}
