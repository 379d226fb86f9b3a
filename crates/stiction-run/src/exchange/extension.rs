//! Extension elements of exported files. They contain properties of a mechanism that the target
//! format cannot express, and only this program reads them.

use super::dynamics;
use super::model_file::{actuator, friction, gearing_table, joint, spring};
use crate::job::friction_word;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{BodyId, Mechanism};
use stiction_core::spatial::{Pose, Quaternion, Vec3};
use stiction_format::ModelFile;

/// Content of an extension element: the kind of a property, the name of the joint, spring or other
/// element that has this property, and the property as text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) kind: &'static str,
    pub(super) name: String,
    pub(super) text: String,
}

/// Lists the friction of all joints in the syntax of a model file. Joints with friction that a
/// model file cannot express are omitted.
pub(super) fn frictions(mechanism: &Mechanism) -> Vec<Entry> {
    let table = |joint: &stiction_core::mechanism::Joint| {
        let table = friction::table(joint).ok().flatten()?;
        let text = table.to_string();
        Some(Entry { kind: "friction", name: joint.name.clone(), text: text.trim().to_owned() })
    };
    mechanism.joints().iter().filter_map(table).collect()
}

/// Returns the friction mode that the model selects by default, if any.
pub(super) fn default_friction(model: &ModelFile) -> Option<Entry> {
    let text = friction_word(model.default_friction?).to_owned();
    Some(Entry { kind: "default", name: "friction".to_owned(), text })
}

/// Lists all springs in the syntax of a model file.
pub(super) fn springs(mechanism: &Mechanism) -> Vec<Entry> {
    let entry = |(name, table): (String, toml::Table)| Entry {
        kind: "spring",
        name,
        text: table.to_string().trim().to_owned(),
    };
    spring::tables(mechanism).into_iter().map(entry).collect()
}

/// Lists the springs that an MJCF file contains as extension elements: all springs on joints, and
/// each spring between points that has a preload or a range of lengths.
pub(super) fn own_springs(mechanism: &Mechanism) -> Vec<Entry> {
    let plain = |name: &str| {
        let mut springs = mechanism.springs().iter();
        springs
            .any(|spring| spring.name == name && spring.preload == 0.0 && spring.lengths.is_none())
    };
    springs(mechanism).into_iter().filter(|entry| !plain(&entry.name)).collect()
}

/// Lists bushings, motors, gearings, and ranges of joints in the syntax of a model file.
pub(super) fn others(mechanism: &Mechanism) -> Vec<Entry> {
    let entry = |kind: &'static str| {
        move |(name, table): (String, toml::Table)| Entry {
            kind,
            name,
            text: table.to_string().trim().to_owned(),
        }
    };
    let bushings = spring::bushing_tables(mechanism).into_iter().map(entry("bushing"));
    let trains = mechanism.drive_trains().iter().map(|train| actuator::table(mechanism, train));
    let gearings = mechanism.gearings().iter().map(|gearing| gearing_table(mechanism, gearing));
    let ranges = mechanism.joints().iter().filter_map(|own| {
        let table = match joint::range(own)? {
            toml::Value::Table(table) => table,
            pair => [("range".to_owned(), pair)].into_iter().collect(),
        };
        Some((own.name.clone(), table))
    });
    bushings
        .chain(trains.map(entry("actuator")))
        .chain(gearings.map(entry("gearing")))
        .chain(ranges.map(entry("range")))
        .collect()
}

/// Returns the name of the XML element for a kind of property in URDF and SDF.
pub(super) fn tag(kind: &str) -> &'static str {
    match kind {
        "friction" => "stiction:friction",
        "spring" => "stiction:spring",
        "bushing" => "stiction:bushing",
        "actuator" => "stiction:actuator",
        "gearing" => "stiction:gearing",
        "range" => "stiction:range",
        "default" => "stiction:default",
        "from" => "stiction:from",
        "start" => "stiction:start",
        _ => "stiction:coordinates",
    }
}

/// Lists, for each of `joints`, the name of its predecessor. The direction of these joints is
/// reversed in the file.
pub(super) fn reversed(mechanism: &Mechanism, joints: impl Iterator<Item = usize>) -> Vec<Entry> {
    let entry = |index: usize| {
        let joint = &mechanism.joints()[index];
        let text = mechanism.bodies()[joint.predecessor.0].name.clone();
        Entry { kind: "from", name: joint.name.clone(), text }
    };
    joints.map(entry).collect()
}

/// Lists the orientations of frames J and K of all ball joints with a range, as two quaternions, each in the body of its
/// frame: the tilt is the angle between their z axes. The frames of `reversed` joints are exchanged, as their bodies are
/// in the file.
pub(super) fn ball_axes(mechanism: &Mechanism, reversed: &[usize]) -> Vec<Entry> {
    let joints = mechanism.joints().iter().enumerate();
    let balls =
        joints.filter(|(_, own)| own.joint_type == JointType::Spherical && !own.ranges.is_empty());
    let entry = |(index, own): (usize, &stiction_core::mechanism::Joint)| {
        let ends = [(own.predecessor, own.frame_j), (own.successor, own.frame_k)];
        let ends = match reversed.contains(&index) {
            false => ends,
            true => [ends[1], ends[0]],
        };
        let quaternions = ends.map(|(body, frame)| {
            // The ground of the file is the world, in which the base may be turned.
            let rotation = match body {
                BodyId::GROUND => mechanism.base().rotation * frame.rotation,
                _ => frame.rotation,
            };
            let mut quaternion = [0.0; 4];
            Quaternion::from_rotation(rotation).write(&mut quaternion);
            quaternion
        });
        let text = super::xml::numbers(quaternions.as_flattened());
        Entry { kind: "axes", name: own.name.clone(), text }
    };
    balls.map(entry).collect()
}

/// Lists the coordinates of all joints at the home position, as the model defines them: a
/// quaternion for spherical joints, a position and a quaternion for free joints.
pub(super) fn coordinates(home: &super::Home<'_>) -> Vec<Entry> {
    let joints = home.mechanism.joints().iter();
    let entry = |joint: &stiction_core::mechanism::Joint| {
        let values = joint.start.as_deref().filter(|values| !values.is_empty())?;
        Some(Entry {
            kind: "coordinates",
            name: joint.name.clone(),
            text: super::xml::numbers(values),
        })
    };
    joints.filter_map(entry).collect()
}

/// Composes notes on properties that the format cannot express: properties that only extension
/// elements contain, and properties that are omitted.
pub(super) fn notes(mechanism: &Mechanism) -> Vec<String> {
    let mut notes = Vec::new();
    let joints = mechanism.joints();
    if !joints.iter().all(dynamics::is_complete) {
        notes.push("friction is in elements that only stiction reads".to_owned());
    }
    if !mechanism.springs().is_empty() || !mechanism.joint_springs().is_empty() {
        notes.push("springs are in elements that only stiction reads".to_owned());
    }
    if joints.iter().any(|joint| joint.compliance.is_some()) {
        notes.push("compliances of joints are omitted".to_owned());
    }
    if !mechanism.bushings().is_empty() {
        notes.push("bushings are in elements that only stiction reads".to_owned());
    }
    if !mechanism.drive_trains().is_empty() {
        let kept =
            "except for the driven joints, the limits of effort and speed, and friction of motors";
        notes.push(format!("motors and gears are in elements that only stiction reads, {kept}"));
    }
    let taken = super::mimic::all(mechanism);
    let lost: Vec<&str> = (mechanism.gearings().iter().enumerate())
        .filter(|(index, _)| taken.iter().all(|mimic| mimic.gearing != *index))
        .map(|(_, gearing)| gearing.name.as_str())
        .collect();
    if !lost.is_empty() {
        notes.push(format!("gearings in elements that only stiction reads: {}", lost.join(", ")));
    }
    notes
}

/// Returns the orientation of a pose as roll, pitch and yaw, rad.
pub(super) fn angles(pose: Pose<f64>) -> [f64; 3] {
    let r = pose.rotation;
    let pitch = (-r.at(2, 0)).atan2(r.at(0, 0).hypot(r.at(1, 0)));
    let yaw = r.at(1, 0).atan2(r.at(0, 0));
    // The roll is computed from the rotation that remains after the yaw. The result is exact even
    // at a pitch of a quarter turn, where the yaw is arbitrary.
    let (s, c) = yaw.sin_cos();
    let roll = (s * r.at(0, 2) - c * r.at(1, 2)).atan2(c * r.at(1, 1) - s * r.at(0, 1));
    [roll, pitch, yaw]
}

/// Returns a pose in the order of SDF: position, m, followed by roll, pitch and yaw, rad.
pub(super) fn six(pose: Pose<f64>) -> [f64; 6] {
    let ([x, y, z], [roll, pitch, yaw]) = (pose.position.to_array(), angles(pose));
    [x, y, z, roll, pitch, yaw]
}

/// Returns the names and values of the six independent entries of a body's inertia tensor, kg m^2.
pub(super) fn tensor(body: &stiction_core::mechanism::Body) -> [(&'static str, f64); 6] {
    let entry = |i: usize, j: usize| body.inertia.at(i, j);
    [
        ("ixx", entry(0, 0)),
        ("iyy", entry(1, 1)),
        ("izz", entry(2, 2)),
        ("ixy", entry(0, 1)),
        ("ixz", entry(0, 2)),
        ("iyz", entry(1, 2)),
    ]
}

/// Returns true if a pose is the identity.
pub(super) fn is_identity(pose: Pose<f64>) -> bool {
    pose == Pose::at(Vec3::zero())
}
