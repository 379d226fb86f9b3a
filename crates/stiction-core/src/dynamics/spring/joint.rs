//! Springs on degrees of freedom of joints.
//!
//! Equation (B11) of the book's theory.

use crate::kinematics::Bodies;
use crate::parameters::JointSpringParameters;
use crate::scalar::Scalar;
use crate::spatial::Wrench;

/// Rate of the spring's degree of freedom, rad/s or m/s.
pub(super) fn rate<T: Scalar>(spring: &JointSpringParameters<T>, bodies: &Bodies<T>) -> T {
    let [from, to] = spring.ends;
    (bodies.twist[to] - bodies.twist[from]).power(bodies.effort(&spring.dof, spring.joint))
}

/// Computes the wrench on the successor at the given coordinate.
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
