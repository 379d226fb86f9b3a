//! What a mechanism is: bodies, joints and springs between them, gravity. Cycles are native.
//!
//! A [`Mechanism`] is made by a [`MechanismBuilder`], which reports all defects at once; once built
//! it is consistent and does not change.

mod builder;
mod compliance;
mod defect;
mod spring;
mod warning;

pub use builder::{BodySpec, JointSpec, MechanismBuilder};
pub use compliance::Compliance;
pub use defect::{Defect, Defects};
pub use spring::{Spring, SpringSpec};
pub use warning::Warning;

use crate::friction::JointFriction;
use crate::joint::JointType;
use crate::spatial::{Mat3, Pose, Vec3};

/// A body's index in [`Mechanism::bodies`]; the ground is [`BodyId::GROUND`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BodyId(pub usize);

/// A joint's index in [`Mechanism::joints`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct JointId(pub usize);

impl BodyId {
    /// The body that does not move.
    pub const GROUND: Self = Self(0);
}

/// The name of the body that does not move.
#[doc(hidden)]
pub const GROUND_NAME: &str = "ground";

/// A rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its name, unique among bodies.
    pub name: String,
    /// Mass, kg, not negative.
    pub mass: f64,
    /// Centre of mass in the body's frame, m.
    pub com: Vec3<f64>,
    /// Inertia about the centre of mass, in the body's axes, kg m^2; symmetric, not negative.
    pub inertia: Mat3<f64>,
}

impl Body {
    /// The principal moments of inertia about the centre of mass, kg m^2, smallest first.
    pub fn principal_moments(&self) -> [f64; 3] {
        let tensor = nalgebra::Matrix3::from(self.inertia);
        let mut moments: [f64; 3] = tensor.symmetric_eigenvalues().into();
        moments.sort_by(f64::total_cmp);
        moments
    }
}

/// A joint between two bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Its name, unique among joints.
    pub name: String,
    /// Its type.
    pub joint_type: JointType,
    /// The body that carries frame J. Reactions are those of this body on the successor.
    pub predecessor: BodyId,
    /// The body that carries frame K.
    pub successor: BodyId,
    /// `X_PJ`: the joint frame in the predecessor.
    pub frame_j: Pose<f64>,
    /// `X_SK`: the joint frame in the successor.
    pub frame_k: Pose<f64>,
    /// Advance of a helical joint, m/rad; zero for the other types.
    pub pitch: f64,
    /// For each freedom, whether an actuator drives it.
    pub actuated: Vec<bool>,
    /// Coordinates from which assembly starts: as many as the type has.
    pub start: Vec<f64>,
    /// Its frictions, at most one for each contact of the type.
    pub friction: Vec<JointFriction>,
    /// How much it gives; by default it is rigid.
    pub compliance: Option<Compliance>,
}

impl Joint {
    /// The freedoms that an actuator drives, by index.
    pub fn actuated_dofs(&self) -> impl Iterator<Item = usize> + '_ {
        self.actuated.iter().enumerate().filter(|(_, driven)| **driven).map(|(k, _)| k)
    }

    /// The name of a freedom, by its index: that of the joint, if it has no other, else `joint.dof`.
    pub fn dof_name(&self, dof: usize) -> String {
        match self.joint_type.dofs() {
            [_] => self.name.clone(),
            several => format!("{}.{}", self.name, several[dof].name),
        }
    }

    /// The name of a freedom that an actuator drives: that of the joint, if no other of its freedoms is driven, else
    /// `joint.dof`.
    pub fn actuator_name(&self, dof: usize) -> String {
        match self.actuated_dofs().count() {
            1 => self.name.clone(),
            _ => self.dof_name(dof),
        }
    }
}

/// A consistent mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct Mechanism {
    name: String,
    bodies: Vec<Body>,
    joints: Vec<Joint>,
    springs: Vec<Spring>,
    gravity: Vec3<f64>,
    base: Pose<f64>,
    characteristic_length: f64,
}

impl Mechanism {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// All bodies; the first is the ground.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// All joints.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// All springs.
    pub fn springs(&self) -> &[Spring] {
        &self.springs
    }

    /// Acceleration of gravity in world axes, m/s^2.
    pub fn gravity(&self) -> Vec3<f64> {
        self.gravity
    }

    /// `X_WG`: the ground's frame in the world.
    pub fn base(&self) -> Pose<f64> {
        self.base
    }

    /// The length, m, by which moments and forces, angles and lengths are compared wherever that is
    /// needed (distances to singularities, default weights, ranks): declared, or the root mean
    /// square of the distances between points of one body, taken over all bodies with the ground,
    /// the points being joint origins and the centre of mass. It depends on the geometry alone.
    pub fn characteristic_length(&self) -> f64 {
        self.characteristic_length
    }

    /// The body with this name.
    pub fn body_id(&self, name: &str) -> Option<BodyId> {
        self.bodies.iter().position(|b| b.name == name).map(BodyId)
    }

    /// The joint with this name.
    pub fn joint_id(&self, name: &str) -> Option<JointId> {
        self.joints.iter().position(|j| j.name == name).map(JointId)
    }

    /// The same mechanism without any friction in its joints.
    pub fn without_friction(&self) -> Self {
        let mut other = self.clone();
        other.joints.iter_mut().for_each(|joint| joint.friction.clear());
        other
    }

    /// The same mechanism with an actuator on this freedom of this joint as well, such as a lock; unchanged
    /// if there is no such freedom, or none that an actuator could drive.
    pub fn with_actuator(&self, joint: JointId, dof: usize) -> Self {
        let mut other = self.clone();
        if let Some(joint) = other.joints.get_mut(joint.0)
            && joint.joint_type.has_scalar_coordinates()
            && let Some(actuated) = joint.actuated.get_mut(dof)
        {
            *actuated = true;
        }
        other
    }

    /// The same mechanism with a part fixed to a body, whose centre of mass and inertia are given in the frame of that
    /// body. The characteristic length stays.
    pub fn with_payload(&self, body: BodyId, part: &Body) -> Self {
        let mut other = self.clone();
        if let Some(body) = other.bodies.get_mut(body.0)
            && part.mass > 0.0
        {
            let mass = body.mass + part.mass;
            let com = (body.com * body.mass + part.com * part.mass) * (1.0 / mass);
            // The parallel axis theorem, for both about the common centre of mass.
            let about = |part: &Body| {
                let d = part.com - com;
                let outer = Mat3::from_columns(d * d.x, d * d.y, d * d.z);
                let square = d.dot(d);
                let diagonal = Mat3::diagonal(Vec3::new(square, square, square));
                part.inertia + (diagonal + outer * -1.0) * part.mass
            };
            body.inertia = about(body) + about(part);
            (body.mass, body.com) = (mass, com);
        }
        other
    }

    /// The same mechanism with each joint's start coordinates where it stands, frame K seen from frame J, in the
    /// order of the joints ([`crate::kinematics::Bodies::joint_poses`]): assembly from there finds this position again.
    pub fn starting_at(&self, joint_poses: impl IntoIterator<Item = Pose<f64>>) -> Self {
        let mut other = self.clone();
        for (joint, relative) in other.joints.iter_mut().zip(joint_poses) {
            joint.joint_type.write_coordinates(relative, joint.pitch, &mut joint.start);
        }
        other
    }

    /// All actuated freedoms in the order of the joints: the order of all lists of drives.
    pub fn actuators(&self) -> impl Iterator<Item = (JointId, usize)> + '_ {
        self.joints
            .iter()
            .enumerate()
            .flat_map(|(j, joint)| joint.actuated_dofs().map(move |k| (JointId(j), k)))
    }
}
