//! Geometry and mechanics of a rigid body: vectors, rotations, poses, twists, wrenches.
//!
//! All types are small, can be copied, and are generic over [`Scalar`](crate::scalar::Scalar). In a
//! computation, every twist and wrench is expressed in **world axes** and refers to **one common
//! point**, the reference point. Twists and wrenches of different bodies can therefore be added
//! directly.
//!
//! | name | meaning |
//! | --- | --- |
//! | `pose_ab` | [`Pose`] `X_AB` of frame B in frame A |
//! | `Twist` | angular velocity, and velocity of the body-fixed point at the reference point |
//! | `Wrench` | force, and moment about the reference point |

mod matrix;
mod pose;
mod screw;
mod vector;
mod words;

pub use matrix::Mat3;
pub use pose::Pose;
pub use screw::Twist;
pub use vector::Vec3;
pub(crate) use words::describe_direction;
pub(crate) use words::describe_motion;

// Used by other crates of the project; not part of the stable interface.
#[doc(hidden)]
pub use pose::Quaternion;
#[doc(hidden)]
pub use screw::Wrench;
