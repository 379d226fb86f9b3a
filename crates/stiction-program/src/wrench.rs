//! Conversion of wrenches between frames, and to and from arrays of six components.

use stiction_core::dynamics::Inverse;
use stiction_core::kinematics::Bodies;
use stiction_core::scalar::Scalar;
use stiction_core::spatial::{Pose, Vec3, Wrench};

/// Returns the components of a wrench: force, then moment.
pub(crate) fn components<T: Copy>(wrench: Wrench<T>) -> [T; 6] {
    let Wrench { force: f, moment: m } = wrench;
    [f.x, f.y, f.z, m.x, m.y, m.z]
}

/// Creates a wrench from six components: force, then moment.
pub(crate) fn from_components<T: Copy>(numbers: &[T]) -> Wrench<T> {
    let part =
        |first: usize| Vec3 { x: numbers[first], y: numbers[first + 1], z: numbers[first + 2] };
    Wrench { force: part(0), moment: part(3) }
}

/// Expresses a wrench in the axes of the frame whose pose is `frame`, with the moment about the
/// origin of this frame.
pub(crate) fn local<T: Scalar>(frame: &Pose<T>, wrench: Wrench<T>) -> Wrench<T> {
    Wrench {
        force: frame.rotation.transpose_mul(wrench.force),
        moment: frame.rotation.transpose_mul(wrench.moment_about(frame.position)),
    }
}

/// Total wrench that the predecessor of a joint exerts on the successor: force, N, then moment
/// about the joint's origin, N m, world axes.
pub(crate) fn reaction<T: Scalar>(
    inverse: &Inverse<T>,
    bodies: &Bodies<T>,
    joint: usize,
) -> [T; 6] {
    let (force, moment) = inverse.reaction(bodies, joint);
    components(Wrench { force, moment })
}
