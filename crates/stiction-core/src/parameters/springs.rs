//! Parameters of springs and bushings.

use crate::joint::Dof;
use crate::mechanism::{Bushing, Mechanism, Spring};
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3};

/// Spring with a damper between points of two bodies.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct SpringParameters<T> {
    /// Indices of the spring's two bodies.
    pub ends: [usize; 2],
    /// Positions of the spring's ends, each in its body's frame, m.
    pub points: [Vec3<T>; 2],
    /// Stiffness, N/m.
    pub stiffness: T,
    /// Length at which only the preload acts, m.
    pub free_length: T,
    /// Force that pushes the ends apart at the free length, N.
    pub preload: T,
    /// Damping, N s/m.
    pub damping: T,
}

impl<T: Scalar> SpringParameters<T> {
    pub(super) fn new(spring: &Spring) -> Self {
        Self {
            ends: spring.ends.map(|body| body.0),
            points: spring.points.map(Vec3::lift),
            stiffness: T::from_f64(spring.stiffness),
            free_length: T::from_f64(spring.free_length),
            preload: T::from_f64(spring.preload),
            damping: T::from_f64(spring.damping),
        }
    }
}

/// Spring with a damper on a degree of freedom of a joint.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct JointSpringParameters<T> {
    /// Index of the joint on which the spring acts.
    pub joint: usize,
    /// Index, in the joint, of the degree of freedom on which the spring acts.
    pub index: usize,
    /// Degree of freedom on which the spring acts.
    pub dof: Dof,
    /// Indices of the joint's predecessor and successor.
    pub ends: [usize; 2],
    /// Stiffness, N m/rad or N/m.
    pub stiffness: T,
    /// Coordinate at which only the preload acts, rad or m.
    pub rest: T,
    /// Effort at the coordinate `rest`, N m or N.
    pub preload: T,
    /// Damping, N m s/rad or N s/m.
    pub damping: T,
    /// Middle of the interval of one full turn into which the angle of a joint that closes a loop
    /// is wrapped, rad.
    pub middle: T,
}

impl<T: Scalar> JointSpringParameters<T> {
    pub(super) fn all(mechanism: &Mechanism) -> Vec<Self> {
        let of_spring = |spring: &crate::mechanism::JointSpring| {
            let joint = &mechanism.joints()[spring.joint.0];
            Self {
                joint: spring.joint.0,
                index: spring.dof,
                dof: joint.joint_type.dofs()[spring.dof],
                ends: [joint.predecessor.0, joint.successor.0],
                stiffness: T::from_f64(spring.stiffness),
                rest: T::from_f64(spring.rest),
                preload: T::from_f64(spring.preload),
                damping: T::from_f64(spring.damping),
                middle: T::from_f64(spring.middle),
            }
        };
        mechanism.joint_springs().iter().map(of_spring).collect()
    }
}

/// Elastic connection between frames of two bodies.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct BushingParameters<T> {
    /// Indices of the bushing's two bodies.
    pub ends: [usize; 2],
    /// Pose of each of the two connected frames in the frame of its body.
    pub frames: [Pose<T>; 2],
    /// Stiffness matrix, see [`Blocks`].
    pub stiffness: Blocks<T>,
    /// Damping matrix, see [`Blocks`].
    pub damping: Blocks<T>,
}

/// Symmetric 6x6 stiffness or damping matrix in blocks of 3x3. It maps a displacement and a
/// rotation (or their rates) to a force and a moment.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Blocks<T> {
    /// Block that maps displacements to forces.
    pub force: Mat3<T>,
    /// Block that maps rotations to forces; its transpose maps displacements to moments.
    pub coupling: Mat3<T>,
    /// Block that maps rotations to moments.
    pub moment: Mat3<T>,
}

impl<T: Scalar> Blocks<T> {
    fn new(matrix: &crate::mechanism::SixBySix) -> Self {
        // Use the symmetric part of the matrix, because the check of the mechanism tolerates
        // asymmetry from rounded entries.
        let entry = |i: usize, j: usize| T::from_f64(0.5 * (matrix[i][j] + matrix[j][i]));
        let block = |row: usize, column: usize| {
            let of = |j: usize| {
                Vec3::new(
                    entry(row, column + j),
                    entry(row + 1, column + j),
                    entry(row + 2, column + j),
                )
            };
            Mat3::from_columns(of(0), of(1), of(2))
        };
        Self { force: block(0, 0), coupling: block(0, 3), moment: block(3, 3) }
    }

    /// Multiplies the matrix by a displacement and a rotation; returns force and moment.
    pub fn times(&self, (linear, angular): (Vec3<T>, Vec3<T>)) -> (Vec3<T>, Vec3<T>) {
        (
            self.force * linear + self.coupling * angular,
            self.coupling.transpose_mul(linear) + self.moment * angular,
        )
    }
}

impl<T: Scalar> BushingParameters<T> {
    pub(super) fn new(bushing: &Bushing) -> Self {
        Self {
            ends: bushing.ends.map(|body| body.0),
            frames: bushing.frames.map(Pose::lift),
            stiffness: Blocks::new(&bushing.stiffness),
            damping: Blocks::new(&bushing.damping),
        }
    }
}
