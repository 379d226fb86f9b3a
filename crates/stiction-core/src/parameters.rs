//! Parameters of a mechanism, in the scalar of the kernels.

use crate::friction::{InterfaceShape, Law, NormalLoadMap, Thread, interfaces_of};
use crate::mechanism::{BodyId, Mechanism, Spring};
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3, Wrench};
use core::ops::Range;

/// Parameters that the kernels read: geometry, inertia, friction, springs, gravity. Indices are
/// those of the [`Mechanism`]. Change the fields to tune a model, to differentiate with respect to
/// a parameter, or to run several parameter sets in lanes.
#[derive(Clone, Debug)]
pub struct Parameters<T> {
    /// Reference point O of all twists and wrenches, in the world, m. It is the mean of the
    /// ground's joint origins, so that a robot far from the world's origin loses no digits.
    pub origin: Vec3<f64>,
    /// Frame of the ground relative to the reference point, in world axes.
    pub ground: Pose<T>,
    /// Acceleration of gravity, world axes, m/s^2.
    pub gravity: Vec3<T>,
    /// Mass of each body, kg.
    pub mass: Vec<T>,
    /// Centre of mass of each body in its frame, m.
    pub com: Vec<Vec3<T>>,
    /// Inertia of each body about its centre of mass, body axes, kg m^2.
    pub inertia: Vec<Mat3<T>>,
    /// Frame J of each joint in the predecessor, `X_PJ`.
    pub frame_j: Vec<Pose<T>>,
    /// Frame K of each joint in the successor, `X_SK`.
    pub frame_k: Vec<Pose<T>>,
    /// Pitch of each joint, m/rad.
    pub pitch: Vec<T>,
    /// Friction interfaces, in the order of the joints.
    pub interfaces: Vec<InterfaceParameters<T>>,
    /// Range of each joint's friction interfaces in `interfaces`.
    pub interfaces_at: Vec<Range<usize>>,
    /// Springs.
    pub springs: Vec<SpringParameters<T>>,
    /// Characteristic length, m: makes moments comparable with forces.
    pub length: T,
    /// Compliance of each joint, relative to the most compliant one; none if no joint declares a
    /// compliance.
    pub compliance: Option<Vec<Weights<T>>>,
}

/// Weights of the components of a joint's wrench along and about the axes of its frame J.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights<T> {
    /// Weights of forces, dimensionless.
    pub force: Vec3<T>,
    /// Weights of moments about the joint's origin, 1/m^2.
    pub moment: Vec3<T>,
}

impl Weights<f64> {
    /// Weights of all joints, if any joint declares a compliance.
    pub(crate) fn declared(mechanism: &Mechanism) -> Option<Vec<Self>> {
        let length = mechanism.characteristic_length();
        let each = mechanism.joints().iter().map(|joint| {
            let compliance = joint.compliance.unwrap_or_default();
            let (force, moment) = compliance.along_axes(joint.joint_type);
            Self { force, moment }
        });
        let weights: Vec<Self> = each.collect();
        // Not norms: squares of compliances underflow.
        let most = |v: Vec3<f64>| v.to_array().into_iter().map(f64::abs).fold(0.0, f64::max);
        let size = |w: &Self| most(w.force).max(most(w.moment) / (length * length));
        let largest = weights.iter().map(size).fold(0.0, f64::max);
        let scaled = |w: &Self| {
            let over = 1.0 / largest;
            Self { force: w.force * over, moment: w.moment * over }
        };
        (largest > 0.0).then(|| weights.iter().map(scaled).collect())
    }
}

impl<T: Scalar> Weights<T> {
    /// Weighted inner product of two wrenches at the origin of `frame_j`, in its axes.
    // Not inlined: few mechanisms declare compliances, and every kernel of every scalar would grow.
    #[inline(never)]
    pub(crate) fn product(&self, frame_j: &Pose<T>, a: Wrench<T>, b: Wrench<T>) -> T {
        let own = |v: Vec3<T>| frame_j.rotation.transpose_mul(v);
        let weigh = |w: Vec3<T>, a: Vec3<T>, b: Vec3<T>| {
            w.x * a.x * b.x + w.y * a.y * b.y + w.z * a.z * b.z
        };
        let point = frame_j.position;
        weigh(self.force, own(a.force), own(b.force))
            + weigh(self.moment, own(a.moment_about(point)), own(b.moment_about(point)))
    }
}

/// Friction interface of a joint.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct InterfaceParameters<T> {
    /// Index of the joint.
    pub joint: usize,
    /// Surface in the joint.
    pub shape: InterfaceShape,
    /// Radius of a rotating surface, m; one for a guide, where the sliding velocity is the rate of
    /// the joint.
    pub radius: T,
    /// Friction law: from sliding speed and normal force to friction.
    pub law: Law<T>,
    /// Friction law for sliding backward, if different.
    pub backward: Option<Law<T>>,
    /// Normal force as a function of the joint's reaction.
    pub load: NormalLoadMap<T>,
}

/// Spring with a damper between points of two bodies.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct SpringParameters<T> {
    /// Indices of its two bodies.
    pub ends: [usize; 2],
    /// Its ends, each in its body's frame, m.
    pub points: [Vec3<T>; 2],
    /// Stiffness, N/m.
    pub stiffness: T,
    /// Length without tension, m.
    pub free_length: T,
    /// Damping, N s/m.
    pub damping: T,
}

impl<T: Scalar> SpringParameters<T> {
    fn new(spring: &Spring) -> Self {
        Self {
            ends: spring.ends.map(|body| body.0),
            points: spring.points.map(Vec3::lift),
            stiffness: T::from_f64(spring.stiffness),
            free_length: T::from_f64(spring.free_length),
            damping: T::from_f64(spring.damping),
        }
    }
}

impl<T: Scalar> InterfaceParameters<T> {
    /// Sliding distance at the surface per unit of each of its DOFs, m or one; `pitch` is that of
    /// the joint.
    pub fn arms(&self, pitch: T) -> [T; 3] {
        match self.shape {
            InterfaceShape::Plate => [T::one(), T::one(), self.radius],
            InterfaceShape::Sleeve => [self.radius, T::one(), T::one()],
            InterfaceShape::Thread => [Thread { radius: self.radius, pitch }.way(); 3],
            _ => [self.radius; 3],
        }
    }
}

impl InterfaceParameters<f64> {
    /// Law for the direction of sliding with this sign.
    pub(crate) fn law_towards(&self, sense: f64) -> &Law {
        match &self.backward {
            Some(backward) if sense < 0.0 => backward,
            _ => &self.law,
        }
    }

    /// Laws for sliding forward and backward.
    pub(crate) fn laws(&self) -> [&Law; 2] {
        [&self.law, self.backward.as_ref().unwrap_or(&self.law)]
    }
}

impl<T: Scalar> Parameters<T> {
    /// Parameters of `mechanism`, as constants of the scalar.
    pub fn new(mechanism: &Mechanism) -> Self {
        let bodies = mechanism.bodies();
        let joints = mechanism.joints();
        let base = mechanism.base();
        let origin = amid_ground_joints(mechanism);
        let mut interfaces = Vec::new();
        let mut interfaces_at = Vec::new();
        for (index, joint) in joints.iter().enumerate() {
            let first = interfaces.len();
            interfaces.extend(joint.friction.iter().map(|interface| InterfaceParameters {
                joint: index,
                shape: interfaces_of(joint.joint_type)[interface.place].1,
                radius: T::from_f64(interface.radius.unwrap_or(1.0)),
                law: interface.law.lift(),
                backward: interface.backward.as_ref().map(Law::lift),
                load: interface.load.lift(),
            }));
            interfaces_at.push(first..interfaces.len());
        }
        Self {
            origin,
            ground: Pose { position: base.position - origin, ..base }.lift(),
            gravity: mechanism.gravity().lift(),
            mass: bodies.iter().map(|b| T::from_f64(b.mass)).collect(),
            com: bodies.iter().map(|b| b.com.lift()).collect(),
            inertia: bodies.iter().map(|b| b.inertia.lift()).collect(),
            frame_j: joints.iter().map(|j| j.frame_j.lift()).collect(),
            frame_k: joints.iter().map(|j| j.frame_k.lift()).collect(),
            pitch: joints.iter().map(|j| T::from_f64(j.pitch)).collect(),
            interfaces,
            interfaces_at,
            springs: mechanism.springs().iter().map(SpringParameters::new).collect(),
            length: T::from_f64(mechanism.characteristic_length()),
            compliance: Weights::declared(mechanism).map(|all| all.iter().map(lift).collect()),
        }
    }
}

fn lift<T: Scalar>(weights: &Weights<f64>) -> Weights<T> {
    Weights { force: weights.force.lift(), moment: weights.moment.lift() }
}

/// Mean of the ground's joint origins, in the world, m.
fn amid_ground_joints(mechanism: &Mechanism) -> Vec3<f64> {
    let joints = mechanism.joints().iter();
    let points: Vec<_> = joints
        .filter_map(|joint| match BodyId::GROUND {
            ground if joint.predecessor == ground => Some(joint.frame_j.position),
            ground if joint.successor == ground => Some(joint.frame_k.position),
            _ => None,
        })
        .collect();
    let count = points.len().max(1) as f64;
    let sum = points.into_iter().fold(Vec3::zero(), |sum, p| sum + p);
    mechanism.base().apply(sum * (1.0 / count))
}
