//! Builder of mechanisms, which reports all defects of a description at once.

mod body;
mod friction;
mod joint;
mod length;

pub use body::BodySpec;
pub use joint::JointSpec;

use super::drive_train::{check_rotors, check_shares};
use super::gearing::check_loops;
use super::{
    Body, BodyId, BushingSpec, Defect, Defects, DriveTrainSpec, GROUND_NAME, GearingSpec, Joint,
    JointSpringSpec, Mechanism, SpringSpec,
};
use crate::spatial::{Pose, Vec3};
use length::own_length;
use std::collections::{HashMap, HashSet};

/// Column names of the results that no joint may have as its name.
const TAKEN: [&str; 3] = ["time", "loads", "dampers"];

/// Checks that no joint has a reserved name, and that none has the name `joint.dof` of another
/// joint's degree of freedom. Appends the defects found to `defects`.
fn check_names(joints: &[Joint], defects: &mut Vec<Defect>) {
    for joint in joints {
        if TAKEN.contains(&joint.name.as_str()) {
            defects.push(Defect::NameTaken { name: joint.name.clone() });
        }
        let dofs = joint.joint_type.dofs();
        if dofs.len() == 1 {
            continue;
        }
        let own: Vec<String> = (0..dofs.len()).map(|k| joint.dof_name(k)).collect();
        for other in joints.iter().filter(|other| own.contains(&other.name)) {
            let (joint, other) = (other.name.clone(), joint.name.clone());
            defects.push(Defect::NameOfFreedom { joint, other });
        }
    }
}

/// Collects the bodies, joints and other parts of a mechanism in any order. The parts refer to
/// bodies and joints by name.
///
/// ```
/// use stiction_core::joint::JointType;
/// use stiction_core::mechanism::{BodySpec, JointSpec, MechanismBuilder};
/// use stiction_core::spatial::Vec3;
///
/// let pendulum = MechanismBuilder::new("pendulum")
///     .gravity(Vec3::new(0.0, -9.81, 0.0))
///     .body(BodySpec::new("bob").mass(1.0).com(Vec3::new(0.0, -1.0, 0.0)))
///     .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "bob").actuated())
///     .build()?;
/// assert_eq!(pendulum.bodies().len(), 2);
/// # Ok::<(), stiction_core::mechanism::Defects>(())
/// ```
#[must_use = "a builder has no effect until `build` is called"]
#[derive(Clone, Debug)]
pub struct MechanismBuilder {
    name: String,
    bodies: Vec<BodySpec>,
    joints: Vec<JointSpec>,
    springs: Vec<SpringSpec>,
    joint_springs: Vec<JointSpringSpec>,
    bushings: Vec<BushingSpec>,
    drive_trains: Vec<DriveTrainSpec>,
    gearings: Vec<GearingSpec>,
    gravity: Vec3<f64>,
    base: Pose<f64>,
    characteristic_length: Option<f64>,
}

impl MechanismBuilder {
    /// Creates a builder without bodies, joints and gravity.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            bodies: Vec::new(),
            joints: Vec::new(),
            springs: Vec::new(),
            joint_springs: Vec::new(),
            bushings: Vec::new(),
            drive_trains: Vec::new(),
            gearings: Vec::new(),
            gravity: Vec3::zero(),
            base: Pose::identity(),
            characteristic_length: None,
        }
    }

    /// Sets the acceleration of gravity in world axes, m/s^2.
    pub fn gravity(mut self, gravity: Vec3<f64>) -> Self {
        self.gravity = gravity;
        self
    }

    /// Sets `X_WG`, the pose of the ground's frame in the world.
    pub fn base(mut self, base: Pose<f64>) -> Self {
        self.base = base;
        self
    }

    /// Sets the characteristic length, m. See [`Mechanism::characteristic_length`].
    pub fn characteristic_length(mut self, length: f64) -> Self {
        self.characteristic_length = Some(length);
        self
    }

    /// Adds a body.
    pub fn body(mut self, body: BodySpec) -> Self {
        self.bodies.push(body);
        self
    }

    /// Adds a joint.
    pub fn joint(mut self, joint: JointSpec) -> Self {
        self.joints.push(joint);
        self
    }

    /// Adds a spring between points of two bodies.
    pub fn spring(mut self, spring: SpringSpec) -> Self {
        self.springs.push(spring);
        self
    }

    /// Adds a spring on a degree of freedom of a joint.
    pub fn joint_spring(mut self, spring: JointSpringSpec) -> Self {
        self.joint_springs.push(spring);
        self
    }

    /// Adds a bushing (a linear spring and damper in six directions) between frames of two bodies.
    pub fn bushing(mut self, bushing: BushingSpec) -> Self {
        self.bushings.push(bushing);
        self
    }

    /// Adds a rigid gearing between degrees of freedom of joints.
    pub fn gearing(mut self, gearing: GearingSpec) -> Self {
        self.gearings.push(gearing);
        self
    }

    /// Adds a drive train and declares the degrees of freedom that it drives as actuated.
    pub fn drive_train(mut self, drive_train: DriveTrainSpec) -> Self {
        self.drive_trains.push(drive_train);
        self
    }

    /// Builds the mechanism.
    ///
    /// # Errors
    /// Returns all [`Defect`]s of the description together.
    pub fn build(self) -> Result<Mechanism, Defects> {
        let mut defects = Vec::new();
        check_finite(&mut defects, "gravity", &self.gravity.to_array());
        check_finite(&mut defects, "the pose of the base", &pose_numbers(&self.base));

        let ground = BodySpec::new(GROUND_NAME).body;
        let mut ids = HashMap::from([(GROUND_NAME.to_owned(), BodyId::GROUND)]);
        let mut bodies = vec![ground];
        if self.bodies.is_empty() {
            defects.push(Defect::NoBodies);
        }
        for spec in self.bodies {
            spec.check(&mut defects);
            if spec.body.name == GROUND_NAME {
                defects.push(Defect::GroundTaken);
            } else if ids.insert(spec.body.name.clone(), BodyId(bodies.len())).is_some() {
                let name = spec.body.name.clone();
                defects.push(Defect::DuplicateName { what: "bodies", name });
            }
            bodies.push(spec.body);
        }

        let mut names = HashSet::new();
        let mut joints = Vec::new();
        for spec in self.joints {
            if !names.insert(spec.name.clone()) {
                let name = spec.name.clone();
                defects.push(Defect::DuplicateName { what: "joints", name });
            }
            joints.extend(spec.resolve(&ids, &mut defects));
        }

        check_names(&joints, &mut defects);

        let mut names = HashSet::new();
        let mut distinct = |name: &str, defects: &mut Vec<Defect>| {
            if !names.insert(name.to_owned()) {
                let name = name.to_owned();
                defects.push(Defect::DuplicateName { what: "springs", name });
            }
        };
        let mut springs = Vec::new();
        for spec in self.springs {
            distinct(spec.name(), &mut defects);
            springs.extend(spec.resolve(&ids, &mut defects));
        }
        let mut joint_springs = Vec::new();
        for spec in self.joint_springs {
            distinct(spec.name(), &mut defects);
            joint_springs.extend(spec.resolve(&joints, &mut defects));
        }
        let mut bushings = Vec::new();
        for spec in self.bushings {
            distinct(spec.name(), &mut defects);
            bushings.extend(spec.resolve(&ids, &mut defects));
        }

        let mut names = HashSet::new();
        let mut drive_trains = Vec::new();
        for spec in self.drive_trains {
            if !names.insert(spec.name().to_owned()) {
                let name = spec.name().to_owned();
                defects.push(Defect::DuplicateName { what: "actuators", name });
            }
            drive_trains.extend(spec.resolve(&ids, &mut joints, &mut defects));
        }
        let mut names = HashSet::new();
        let mut gearings = Vec::new();
        for spec in self.gearings {
            if !names.insert(spec.name().to_owned()) {
                let name = spec.name().to_owned();
                defects.push(Defect::DuplicateName { what: "gearings", name });
            }
            gearings.extend(spec.resolve(&joints, &mut defects));
        }
        if defects.is_empty() {
            check_loops(&gearings, (bodies.len(), &joints), &mut defects);
            check_shares(&drive_trains, &joints, &mut defects);
            check_rotors(&drive_trains, &bodies, &mut defects);
        }

        // The connectivity check requires that all joints have valid bodies.
        if defects.is_empty() {
            defects.extend(disconnected(&bodies, &joints));
        }
        let own = own_length(&bodies, &joints);
        if let Some(length) = self.characteristic_length {
            if !(length > 0.0 && length.is_finite()) {
                defects.push(Defect::CharacteristicLength(length));
            } else if own.is_finite() {
                // If points that should coincide differ by rounding, the default length does not
                // describe the size of the mechanism. The upper limit is therefore at least 1e6 m.
                let (least, most) = (1e-6 * own, 1e6 * own.max(1.0));
                if !(least..=most).contains(&length) {
                    defects.push(Defect::CharacteristicLengthFar { length, own, least, most });
                }
            }
        }
        if let Some(defects) = Defects::new(defects) {
            return Err(defects);
        }
        let characteristic_length = self.characteristic_length.unwrap_or(own);
        Ok(Mechanism {
            name: self.name,
            bodies,
            joints,
            springs,
            joint_springs,
            bushings,
            drive_trains,
            gearings,
            gravity: self.gravity,
            base: self.base,
            characteristic_length,
        })
    }
}

fn pose_numbers(pose: &Pose<f64>) -> Vec<f64> {
    let [x, y, z] = pose.rotation.columns;
    [x, y, z, pose.position].iter().flat_map(|v| v.to_array()).collect()
}

fn check_finite(defects: &mut Vec<Defect>, place: &str, numbers: &[f64]) {
    if numbers.iter().any(|x| !x.is_finite()) {
        defects.push(Defect::NotFinite { place: place.to_owned() });
    }
}

/// Returns a defect for each body that no chain of joints connects with the ground.
fn disconnected(bodies: &[Body], joints: &[Joint]) -> Vec<Defect> {
    let mut reached = vec![false; bodies.len()];
    reached[BodyId::GROUND.0] = true;
    loop {
        let mut grew = false;
        for joint in joints {
            let (a, b) = (joint.predecessor.0, joint.successor.0);
            if reached[a] != reached[b] {
                (reached[a], reached[b]) = (true, true);
                grew = true;
            }
        }
        if !grew {
            break;
        }
    }
    bodies
        .iter()
        .zip(reached)
        .filter(|(_, reached)| !reached)
        .map(|(body, _)| Defect::Disconnected { body: body.name.clone() })
        .collect()
}
