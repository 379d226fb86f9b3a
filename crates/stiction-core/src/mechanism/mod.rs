//! Mechanisms: bodies, joints, springs, drive trains, gearings and gravity. Closed loops need no
//! special description.
//!
//! [`MechanismBuilder`] builds a [`Mechanism`] and reports all defects at once. A built mechanism
//! is consistent and immutable.

mod builder;
mod changed;
mod compliance;
mod defect;
mod drive_train;
mod gearing;
mod range;
mod scalar_dof;
mod shafts;
mod spring;
mod warning;

pub use builder::{BodySpec, JointSpec, MechanismBuilder};
pub use changed::Changeable;
pub use compliance::Compliance;
pub use defect::{Defect, Defects};
pub use drive_train::{
    DriveTrain, DriveTrainSpec, GearInput, GearLoss, Mesh, Motor, MotorFriction, MotorLimits,
    MotorMap, MotorTerm, RotorAxis, SharedMotors,
};
pub use gearing::{Gearing, GearingSpec};
pub use range::{JointRange, RangeOf};
pub use scalar_dof::GearedDof;
pub(crate) use shafts::MotorShaft;
pub use spring::{
    Bushing, BushingSpec, GasSpring, JointSpring, JointSpringSpec, SixBySix, Spring, SpringSpec,
};
pub use warning::Warning;

use crate::friction::{JointFriction, interfaces_of};
use crate::joint::JointType;
use crate::spatial::{Mat3, Pose, Vec3};

/// A body's index in [`Mechanism::bodies`]; the ground is [`BodyId::GROUND`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BodyId(pub usize);

/// A joint's index in [`Mechanism::joints`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct JointId(pub usize);

impl BodyId {
    /// The ground, which does not move.
    pub const GROUND: Self = Self(0);
}

/// Name of the ground, the fixed body.
#[doc(hidden)]
pub const GROUND_NAME: &str = "ground";

/// A rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Name, unique among bodies.
    pub name: String,
    /// Mass, kg, nonnegative.
    pub mass: f64,
    /// Centre of mass in the body's frame, m.
    pub com: Vec3<f64>,
    /// Inertia about the centre of mass, in the body's axes, kg m^2; symmetric, without negative principal moments.
    pub inertia: Mat3<f64>,
}

impl Body {
    /// Principal moments of inertia about the centre of mass, kg m^2, in ascending order.
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
    /// Name, unique among joints.
    pub name: String,
    /// Joint type.
    pub joint_type: JointType,
    /// Body that carries frame J. Reactions are exerted by this body on the successor.
    pub predecessor: BodyId,
    /// Body that carries frame K.
    pub successor: BodyId,
    /// `X_PJ`: pose of frame J in the predecessor's frame.
    pub frame_j: Pose<f64>,
    /// `X_SK`: pose of frame K in the successor's frame.
    pub frame_k: Pose<f64>,
    /// Pitch of a helical joint: its advance in m/rad; zero for all other types.
    pub pitch: f64,
    /// One flag for each degree of freedom: `true` if the degree of freedom is actuated.
    pub actuated: Vec<bool>,
    /// Start coordinates, near which the joint is assembled: one value for each coordinate of the
    /// joint type. `None` if no start coordinates are declared.
    pub start: Option<Vec<f64>>,
    /// Friction of the joint, with at most one entry for each friction interface of the joint type.
    pub friction: Vec<JointFriction>,
    /// Declared compliance of the joint; `None` for a rigid joint.
    pub compliance: Option<Compliance>,
    /// Permitted ranges of the joint's coordinates and tilt. Leaving a range only causes a caution.
    pub ranges: Vec<JointRange>,
}

impl Joint {
    /// Returns the start coordinates or, if none are declared, the coordinates at which frames J
    /// and K coincide.
    #[doc(hidden)]
    pub fn start_or_zero(&self) -> Vec<f64> {
        self.start.clone().unwrap_or_else(|| {
            let mut q = vec![0.0; self.joint_type.coordinates()];
            self.joint_type.write_zero(&mut q);
            q
        })
    }

    /// Indices of the actuated degrees of freedom.
    pub fn actuated_dofs(&self) -> impl Iterator<Item = usize> + '_ {
        self.actuated.iter().enumerate().filter(|(_, driven)| **driven).map(|(k, _)| k)
    }

    /// Returns the name of a degree of freedom, given by index: the joint's name if the joint has
    /// one degree of freedom, otherwise `joint.dof`.
    pub fn dof_name(&self, dof: usize) -> String {
        match self.joint_type.dofs() {
            [_] => self.name.clone(),
            several => format!("{}.{}", self.name, several[dof].name),
        }
    }

    /// Returns the name of an actuated degree of freedom: the joint's name if the joint has one
    /// actuator, otherwise `joint.dof`.
    pub fn actuator_name(&self, dof: usize) -> String {
        match self.actuated_dofs().count() {
            1 => self.name.clone(),
            _ => self.dof_name(dof),
        }
    }

    /// Returns the names of the friction interfaces: the joint's name or, if the joint type has
    /// several interfaces, `joint.interface`.
    pub fn interface_names(&self) -> impl Iterator<Item = String> + '_ {
        let places = interfaces_of(self.joint_type);
        self.friction.iter().map(|friction| match places[friction.place].0 {
            "" => self.name.clone(),
            place => format!("{}.{place}", self.name),
        })
    }
}

/// An immutable mechanism that [`MechanismBuilder`] has checked for consistency.
#[derive(Clone, Debug, PartialEq)]
pub struct Mechanism {
    name: String,
    bodies: Vec<Body>,
    joints: Vec<Joint>,
    springs: Vec<Spring>,
    joint_springs: Vec<JointSpring>,
    bushings: Vec<Bushing>,
    drive_trains: Vec<DriveTrain>,
    gearings: Vec<Gearing>,
    gravity: Vec3<f64>,
    base: Pose<f64>,
    characteristic_length: f64,
}

/// Degree of freedom whose motor or gear has friction, see [`Mechanism::shafts_with_friction`].
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct FrictionShaft<'a> {
    /// Name of the first drive train with friction on the degree of freedom.
    pub name: &'a str,
    /// Joint of the degree of freedom; the first of the joints that a motor with its own shaft
    /// drives.
    pub joint: JointId,
    /// True if friction is a moment, N m, and the sliding velocity an angular velocity, rad/s.
    pub rotates: bool,
}

impl Mechanism {
    /// Name of the mechanism.
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

    /// All springs between points of bodies.
    pub fn springs(&self) -> &[Spring] {
        &self.springs
    }

    /// All springs on degrees of freedom of joints.
    pub fn joint_springs(&self) -> &[JointSpring] {
        &self.joint_springs
    }

    /// All bushings between frames of bodies.
    pub fn bushings(&self) -> &[Bushing] {
        &self.bushings
    }

    /// All drive trains. An actuated degree of freedom without a drive train is driven directly by
    /// its effort.
    pub fn drive_trains(&self) -> &[DriveTrain] {
        &self.drive_trains
    }

    /// All rigid gearings.
    pub fn gearings(&self) -> &[Gearing] {
        &self.gearings
    }

    /// Returns, for each drive train, the map from the motions and efforts of all actuators to
    /// those at the output of its gear.
    pub fn motor_maps(&self) -> Vec<MotorMap> {
        let actuators: Vec<_> = self.actuators().collect();
        drive_train::motor_maps(&self.drive_trains, &actuators)
    }

    /// Lists the actuated degrees of freedom whose motors or gears have friction, in the order of
    /// the drive trains. A motor that has its own shaft in simulations has a separate entry. For
    /// each entry, simulations append one friction interface to the interfaces of the joints.
    #[doc(hidden)]
    pub fn shafts_with_friction(&self) -> Vec<FrictionShaft<'_>> {
        let mut found: Vec<(&str, (JointId, usize), bool)> = Vec::new();
        let trains = self.drive_trains.iter().zip(self.trains_on_shafts());
        for (train, on_shaft) in trains.filter(|(train, _)| train.has_friction()) {
            let Some(driven) = train.dofs.first() else { continue };
            let driven = (driven.joint, driven.dof);
            if on_shaft || !found.iter().any(|(_, known, _)| *known == driven) {
                found.push((&train.name, driven, on_shaft));
            }
        }
        let shaft = |(name, (joint, dof), on_shaft): (_, (JointId, usize), bool)| {
            let dofs = self.joints[joint.0].joint_type.dofs();
            let translates = dofs.get(dof).is_some_and(|own| own.translates());
            FrictionShaft { name, joint, rotates: on_shaft || !translates }
        };
        found.into_iter().map(shaft).collect()
    }

    /// Gravitational acceleration in world axes, m/s^2.
    pub fn gravity(&self) -> Vec3<f64> {
        self.gravity
    }

    /// `X_WG`: pose of the ground's frame in the world.
    pub fn base(&self) -> Pose<f64> {
        self.base
    }

    /// Characteristic length, m, which relates moments to forces and angles to lengths (singularity
    /// indices, default weights, ranks). If no length is declared, it is the root mean square of
    /// the distances between points of the same body, over all bodies including the ground, from
    /// each point to at most six nearest others. These points are joint origins and the centre of
    /// mass. If all distances vanish, the characteristic length is one metre. This default depends
    /// on the geometry alone.
    pub fn characteristic_length(&self) -> f64 {
        self.characteristic_length
    }

    /// Returns the index of the body with this name.
    pub fn body_id(&self, name: &str) -> Option<BodyId> {
        self.bodies.iter().position(|b| b.name == name).map(BodyId)
    }

    /// Returns the index of the joint with this name.
    pub fn joint_id(&self, name: &str) -> Option<JointId> {
        self.joints.iter().position(|j| j.name == name).map(JointId)
    }

    /// Returns a copy of the mechanism without friction in joints and drive trains.
    pub fn without_friction(&self) -> Self {
        let mut other = self.clone();
        other.joints.iter_mut().for_each(|joint| joint.friction.clear());
        other.drive_trains = self.drive_trains.iter().map(DriveTrain::without_friction).collect();
        other
    }

    /// Returns a copy of the mechanism with an additional actuator on the given degree of freedom,
    /// for example to lock this degree of freedom. The copy is unchanged if the degree of freedom
    /// does not exist or has no scalar coordinate.
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

    /// Returns a copy of the mechanism with `part` rigidly attached to a body. Centre of mass and
    /// inertia of `part` are in the frame of that body. The characteristic length does not change.
    pub fn with_payload(&self, body: BodyId, part: &Body) -> Self {
        let mut other = self.clone();
        if let Some(body) = other.bodies.get_mut(body.0)
            && part.mass > 0.0
        {
            let mass = body.mass + part.mass;
            let com = (body.com * body.mass + part.com * part.mass) * (1.0 / mass);
            // Parallel axis theorem: inertia of body and part about the common centre of mass.
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

    /// Returns a copy of the mechanism with start coordinates computed from the given joint poses
    /// (frame K in frame J), so that assembly reproduces the configuration of these poses. The
    /// poses are in the order of the joints, see [`crate::kinematics::Bodies::joint_poses`].
    pub fn starting_at(&self, joint_poses: impl IntoIterator<Item = Pose<f64>>) -> Self {
        let mut other = self.clone();
        for (joint, relative) in other.joints.iter_mut().zip(joint_poses) {
            let mut start = joint.start_or_zero();
            joint.joint_type.write_coordinates(relative, joint.pitch, &mut start);
            joint.start = Some(start);
        }
        other
    }

    /// All actuated degrees of freedom, in the order of the joints. All lists of actuator efforts
    /// are in this order.
    pub fn actuators(&self) -> impl Iterator<Item = (JointId, usize)> + '_ {
        self.joints
            .iter()
            .enumerate()
            .flat_map(|(j, joint)| joint.actuated_dofs().map(move |k| (JointId(j), k)))
    }
}
