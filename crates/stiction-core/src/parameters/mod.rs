//! Numerical parameters of a mechanism, in the scalar type of the kernels.

mod springs;

pub use springs::{Blocks, BushingParameters, JointSpringParameters, SpringParameters};

use crate::friction::{InterfaceShape, Law, NormalLoadMap, Thread, interfaces_of};
use crate::mechanism::{BodyId, DriveTrain, GearedDof, Gearing, Mechanism, RotorAxis};
use crate::scalar::Scalar;
use crate::spatial::{Mat3, Pose, Vec3, Wrench};
use core::ops::Range;

/// Parameters read by the kernels: geometry, inertia, friction, springs, gravity. Indices are the
/// same as in the [`Mechanism`]. Change the fields to tune a model, to differentiate with respect
/// to a parameter, or to compute with several parameter sets in SIMD lanes.
#[derive(Clone, Debug)]
pub struct Parameters<T> {
    /// Reference point O of all twists and wrenches, in the world, m. It is the mean of the
    /// ground's joint origins, which avoids a loss of digits for a robot far from the world's
    /// origin.
    pub origin: Vec3<f64>,
    /// Pose of the ground's frame relative to the reference point, in world axes.
    pub ground: Pose<T>,
    /// Gravitational acceleration, world axes, m/s^2.
    pub gravity: Vec3<T>,
    /// Mass of each body, kg.
    pub mass: Vec<T>,
    /// Centre of mass of each body in its frame, m.
    pub com: Vec<Vec3<T>>,
    /// Inertia of each body about its centre of mass, body axes, kg m^2.
    pub inertia: Vec<Mat3<T>>,
    /// Pose `X_PJ` of each joint's frame J in the predecessor's frame.
    pub frame_j: Vec<Pose<T>>,
    /// Pose `X_SK` of each joint's frame K in the successor's frame.
    pub frame_k: Vec<Pose<T>>,
    /// Pitch of each joint, m/rad; zero for joints that are not helical.
    pub pitch: Vec<T>,
    /// Friction interfaces, in the order of the joints.
    pub interfaces: Vec<InterfaceParameters<T>>,
    /// Range of indices in `interfaces` for each joint.
    pub interfaces_at: Vec<Range<usize>>,
    /// Springs between points of bodies.
    pub springs: Vec<SpringParameters<T>>,
    /// Springs on degrees of freedom of joints.
    pub joint_springs: Vec<JointSpringParameters<T>>,
    /// Bushings between frames of two bodies.
    pub bushings: Vec<BushingParameters<T>>,
    /// Rotors that spin on bodies: one entry for each rotor and each degree of freedom that turns
    /// the rotor.
    pub rotors: Vec<RotorParameters<T>>,
    /// Rigid gearings, in the order of [`Mechanism::gearings`].
    pub gearings: Vec<GearingParameters<T>>,
    /// Characteristic length, m, which makes moments comparable with forces.
    pub length: T,
    /// Weights from the compliance of each joint, relative to the most compliant joint; `None` if
    /// no joint declares a compliance.
    pub compliance: Option<Vec<Weights<T>>>,
}

/// Weights of the components of a joint's wrench, along and about the axes of its frame J.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights<T> {
    /// Weights of force components, dimensionless.
    pub force: Vec3<T>,
    /// Weights of moments about the joint's origin, 1/m^2.
    pub moment: Vec3<T>,
}

impl Weights<f64> {
    /// Computes the weights of all joints from their declared compliances. Returns `None` if no
    /// joint declares a compliance.
    pub(crate) fn declared(mechanism: &Mechanism) -> Option<Vec<Self>> {
        let length = mechanism.characteristic_length();
        let each = mechanism.joints().iter().map(|joint| {
            let compliance = joint.compliance.unwrap_or_default();
            let (force, moment) = compliance.along_axes(joint.joint_type);
            Self { force, moment }
        });
        let weights: Vec<Self> = each.collect();
        // Largest magnitudes instead of norms, because squares of compliances underflow.
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
    /// Computes the weighted inner product of two wrenches; both are reduced to the origin and axes
    /// of `frame_j`.
    // Not inlined, because inlining would enlarge every kernel of every scalar type, although few
    // mechanisms declare compliances.
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
    /// Index of the joint to which the interface belongs.
    pub joint: usize,
    /// Geometry of the sliding surface.
    pub shape: InterfaceShape,
    /// Radius of a rotating surface, m. One for a guide, whose sliding velocity equals the rate of
    /// the joint.
    pub radius: T,
    /// Friction law: friction as a function of sliding speed and normal force. The law applies to
    /// both directions of sliding unless `backward` is set.
    pub law: Law<T>,
    /// Friction law for sliding backward; `None` if it is the same as for sliding forward.
    pub backward: Option<Law<T>>,
    /// Normal force as a function of the joint's reaction.
    pub load: NormalLoadMap<T>,
}

/// Rotor that spins on a body in proportion to the rate of a joint's degree of freedom.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct RotorParameters<T> {
    /// Index of the joint whose motion turns the rotor.
    pub joint: usize,
    /// Index, in the joint, of the degree of freedom that turns the rotor.
    pub dof: usize,
    /// Index of the body that carries the rotor.
    pub body: usize,
    /// Unit vector along the rotor axis, in the frame of the body that carries the rotor.
    pub axis: Vec3<T>,
    /// Angular momentum of the rotor about `axis` per unit rate of the degree of freedom, kg m^2 or
    /// kg m: the moment of inertia times the ratio of the rotor's speed to this rate.
    pub momentum: T,
}

impl<T: Scalar> RotorParameters<T> {
    /// Returns the parameters of a drive train's rotor, one entry for each degree of freedom that
    /// contributes to the rotor's angular momentum. Returns no entries if the rotor does not spin
    /// on a body.
    pub fn of(train: &DriveTrain) -> impl Iterator<Item = Self> + '_ {
        let momentum = train.transmission() * train.rotor_inertia;
        let spinning = train.rotor_axis.filter(|_| momentum != 0.0);
        spinning.into_iter().flat_map(move |RotorAxis { body, axis }| {
            train.output_parts().map(move |(joint, dof, part)| Self {
                joint: joint.0,
                dof,
                body: body.0,
                axis: axis.lift(),
                momentum: T::from_f64(momentum * part),
            })
        })
    }
}

/// Rigid gearing of degrees of freedom. The gearing's equation is divided by `size`, so that its
/// coefficients are of order one.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct GearingParameters<T> {
    /// Coefficient of each degree of freedom, divided by `size`.
    pub coefficients: Vec<T>,
    /// Required value of the weighted sum of coordinates, rad or m, divided by `size`.
    pub offset: T,
    /// Divisor of the equation: the greatest magnitude of a coefficient. If the weighted sum is a
    /// length, this comparison uses coefficients of rotations divided by the characteristic length.
    /// The effort of the gearing is the multiplier of the divided equation, divided by `size`.
    pub size: f64,
}

impl<T: Scalar> GearingParameters<T> {
    fn new(gearing: &Gearing, length: f64) -> Self {
        let is_length = gearing.is_length();
        let size = |geared: &GearedDof| {
            let scale = if is_length && !geared.translates { length.recip() } else { 1.0 };
            geared.coefficient.abs() * scale
        };
        let size = gearing.dofs.iter().map(size).fold(f64::MIN_POSITIVE, f64::max);
        let each = gearing.dofs.iter().map(|geared| T::from_f64(geared.coefficient / size));
        let offset = T::from_f64(gearing.offset / size);
        Self { coefficients: each.collect(), offset, size }
    }
}

impl<T: Scalar> InterfaceParameters<T> {
    /// Returns the sliding distance at the surface per unit displacement in each degree of freedom
    /// of the interface, m/rad or dimensionless; `pitch` is the pitch of the joint, m/rad.
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
    /// Returns the friction law for sliding backward if `sense` is negative, otherwise that for
    /// sliding forward.
    pub(crate) fn law_towards(&self, sense: f64) -> &Law {
        match &self.backward {
            Some(backward) if sense < 0.0 => backward,
            _ => &self.law,
        }
    }

    /// Returns the friction laws for sliding forward and backward.
    pub(crate) fn laws(&self) -> [&Law; 2] {
        [&self.law, self.backward.as_ref().unwrap_or(&self.law)]
    }
}

impl Parameters<f64> {
    /// Returns `true` if spring forces depend on rates.
    pub(crate) fn has_dampers(&self) -> bool {
        let damps = |blocks: &Blocks<f64>| {
            let all = [blocks.force, blocks.coupling, blocks.moment];
            all.iter().any(|block| block.columns.iter().any(|c| c.norm_squared() != 0.0))
        };
        self.springs.iter().any(|spring| spring.damping != 0.0)
            || self.joint_springs.iter().any(|spring| spring.damping != 0.0)
            || self.bushings.iter().any(|bushing| damps(&bushing.damping))
    }
}

impl<T: Scalar> Parameters<T> {
    /// Converts the parameters of `mechanism` to constants of the scalar type.
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
            joint_springs: JointSpringParameters::all(mechanism),
            bushings: mechanism.bushings().iter().map(BushingParameters::new).collect(),
            rotors: mechanism.drive_trains().iter().flat_map(RotorParameters::of).collect(),
            gearings: mechanism
                .gearings()
                .iter()
                .map(|gearing| GearingParameters::new(gearing, mechanism.characteristic_length()))
                .collect(),
            length: T::from_f64(mechanism.characteristic_length()),
            compliance: Weights::declared(mechanism).map(|all| all.iter().map(lift).collect()),
        }
    }
}

fn lift<T: Scalar>(weights: &Weights<f64>) -> Weights<T> {
    Weights { force: weights.force.lift(), moment: weights.moment.lift() }
}

/// Computes the mean of the ground's joint origins, in the world, m.
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
