//! Export to URDF, which describes a tree of links, and to a YAML file that lists the loop closures
//! and motors, in the convention of *example-parallel-robots*.
//!
//! The frame of a link is the frame of its body. If the frame of a joint on its child body differs
//! from the frame of the child link, the file inserts a link without mass between them, named after
//! the joint.

use super::dynamics;
use super::extension::{self, Entry, angles, is_identity, tensor};
use super::mimic::{self, Mimic};
use super::names::Names;
use super::xml::{Xml, numbers};
use super::{Home, Unfit};
use stiction_core::disjoint_sets::DisjointSets;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{BodyId, Joint, Mechanism};
use stiction_core::spatial::{Mat3, Pose, Vec3};
use stiction_format::NAMESPACE;

/// URDF model and its YAML file as text, with notes on properties that neither of them can express.
#[derive(Clone, Debug, PartialEq)]
pub struct Urdf {
    /// Text of the URDF.
    pub text: String,
    /// Text of the accompanying YAML file; `None` if the mechanism has neither loops nor motors, nor joints of special
    /// types.
    pub yaml: Option<String>,
    /// Notes on properties that the files omit or change, one per entry.
    pub notes: Vec<String>,
}

/// Content of the YAML file that accompanies a URDF file.
#[derive(Default)]
struct Convention {
    closures: Vec<([String; 2], &'static str)>,
    motors: Vec<String>,
    types: Vec<(String, &'static str)>,
}

/// Limit, in SI units, that the file contains for a quantity without a limit.
const WIDE: f64 = 1e9;

/// Last line of a YAML file that this program writes, and therefore may replace.
const WRITTEN: &str = "# Written by stiction.";

struct Writer<'a> {
    home: &'a Home<'a>,
    xml: Xml,
    links: Names,
    bodies: Vec<String>,
    convention: Convention,
    /// Indices of the joints whose direction is reversed in the file.
    reversed: Vec<usize>,
    mimics: Vec<Mimic>,
}

/// Converts an assembled mechanism to URDF and YAML.
///
/// # Errors
/// Returns [`Unfit::NoSuchJoint`] if neither URDF nor the YAML convention has a joint of a required
/// type.
pub fn urdf(home: &Home<'_>) -> Result<Urdf, Unfit> {
    let mechanism = &home.model.mechanism;
    let lacks = |joint: &&Joint| match joint.joint_type {
        JointType::Helical | JointType::Cylindrical | JointType::Planar => true,
        JointType::Universal => joint.actuated_dofs().next().is_some(),
        _ => false,
    };
    if let Some(joint) = mechanism.joints().iter().find(lacks) {
        let drive = if joint.joint_type == JointType::Universal { " with an actuator" } else { "" };
        let kind = format!("{}{drive}", joint.joint_type.symbol());
        return Err(Unfit::NoSuchJoint { joint: joint.name.clone(), kind, format: "URDF" });
    }
    let mut notes = extension::notes(mechanism);
    let down = Vec3::new(0.0, 0.0, -9.81);
    if mechanism.gravity() != down {
        notes.push("gravity is in an element that only stiction reads".to_owned());
    }
    let mut links = Names::default();
    let bodies = mechanism.bodies().iter().map(|body| links.take(&body.name)).collect();
    let mut writer = Writer {
        home,
        xml: Xml::default(),
        links,
        bodies,
        convention: Convention::default(),
        reversed: Vec::new(),
        mimics: mimic::all(mechanism),
    };
    writer.write(&notes);
    Ok(Urdf { yaml: writer.convention.text(), text: writer.xml.finish(), notes })
}

/// Chooses the joints of the spanning tree, from the ground outwards. Returns the index of each
/// joint with a flag, which is true if the joint leads from its predecessor to its successor, and
/// false if the joint is reversed.
fn tree(mechanism: &Mechanism) -> Vec<(usize, bool)> {
    let joints = mechanism.joints();
    // Loops are preferably closed at spherical and fixed joints, and not at joints with motors.
    let rank = |joint: &Joint| match joint.joint_type {
        JointType::Free => 4,
        JointType::Spherical => 3,
        JointType::Fixed => 2,
        _ => usize::from(joint.actuated_dofs().next().is_none()),
    };
    let mut order: Vec<usize> = (0..joints.len()).collect();
    order.sort_by_key(|&index| rank(&joints[index]));
    let mut trees = DisjointSets::new(mechanism.bodies().len());
    let mut in_tree = order;
    in_tree.retain(|&k| trees.unite(joints[k].predecessor.0, joints[k].successor.0));
    in_tree.sort_unstable();
    let mut reached = vec![false; mechanism.bodies().len()];
    reached[BodyId::GROUND.0] = true;
    let mut found = Vec::new();
    loop {
        let count = found.len();
        for &index in &in_tree {
            let (from, to) = (joints[index].predecessor.0, joints[index].successor.0);
            if reached[from] != reached[to] {
                found.push((index, reached[from]));
                (reached[from], reached[to]) = (true, true);
            }
        }
        if found.len() == count {
            return found;
        }
    }
}

/// Returns the rotation to a frame whose z axis is the previous -z axis, for reversed joints.
fn flipped() -> Pose<f64> {
    Pose {
        rotation: Mat3::from_columns(Vec3::unit(0), -Vec3::unit(1), -Vec3::unit(2)),
        position: Vec3::zero(),
    }
}

/// Returns the rotation to a frame whose x and y axes are the previous z and x axes, as the YAML
/// convention requires for `CARDAN` joints.
fn cardan() -> Pose<f64> {
    Pose {
        rotation: Mat3::from_columns(Vec3::unit(2), Vec3::unit(0), Vec3::unit(1)),
        position: Vec3::zero(),
    }
}

/// Returns the rotation to a frame whose z and x axes are the previous -x and -z axes. The rotation
/// exchanges the axes of a universal joint.
fn exchanged() -> Pose<f64> {
    Pose {
        rotation: Mat3::from_columns(-Vec3::unit(2), -Vec3::unit(1), -Vec3::unit(0)),
        position: Vec3::zero(),
    }
}

impl Writer<'_> {
    fn write(&mut self, notes: &[String]) {
        let mechanism = &self.home.model.mechanism;
        let name = ("name", self.home.model.name.clone());
        self.xml.open("robot", &[name, ("xmlns:stiction", NAMESPACE.into())]);
        let made = format!("Written by stiction {}. SI units.", env!("CARGO_PKG_VERSION"));
        self.xml.comment(&[&self.home.model.title, &made]);
        for note in notes {
            self.xml.comment(&[&format!("Note: {note}.")]);
        }
        let base = mechanism.base();
        if !is_identity(base) {
            let world = self.links.take("world");
            self.link(&world);
            let ground = self.bodies[0].clone();
            self.joint("ground_hold", "fixed", (&world, &ground), base);
        }
        for (index, body) in mechanism.bodies().iter().enumerate() {
            self.xml.open("link", &[("name", self.bodies[index].clone())]);
            if body.mass > 0.0 || body.inertia != Mat3::zero() {
                self.xml.open("inertial", &[]);
                let com = numbers(&body.com.to_array());
                self.xml.empty("origin", &[("xyz", com), ("rpy", "0 0 0".into())]);
                self.xml.empty("mass", &[("value", numbers(&[body.mass]))]);
                let entries = tensor(body).map(|(key, value)| (key, numbers(&[value])));
                self.xml.empty("inertia", &entries);
                self.xml.close();
            }
            self.xml.close();
        }
        let tree = tree(mechanism);
        for &(index, forward) in &tree {
            self.tree_joint(index, forward);
        }
        for index in 0..mechanism.joints().len() {
            if !tree.iter().any(|(known, _)| *known == index) {
                self.closure(index);
            }
        }
        self.extensions();
    }

    fn link(&mut self, name: &str) {
        self.xml.empty("link", &[("name", name.to_owned())]);
    }

    fn joint(&mut self, name: &str, word: &str, (from, to): (&str, &str), place: Pose<f64>) {
        let mechanism = &self.home.model.mechanism;
        let moves = matches!(word, "prismatic" | "continuous");
        let own = mechanism.joints().iter().position(|joint| moves && joint.name == name);
        let is_simple = |joint: &usize| {
            let kind = mechanism.joints()[*joint].joint_type;
            matches!(kind, JointType::Revolute | JointType::Prismatic)
        };
        let own = own.filter(is_simple);
        let (range, effort, rate) =
            own.map_or((None, None, None), |own| mimic::limits(mechanism, own));
        let word = if word == "continuous" && range.is_some() { "revolute" } else { word };
        self.xml.open("joint", &[("name", name.to_owned()), ("type", word.to_owned())]);
        self.xml.empty("parent", &[("link", from.to_owned())]);
        self.xml.empty("child", &[("link", to.to_owned())]);
        let origin =
            [("xyz", numbers(&place.position.to_array())), ("rpy", numbers(&angles(place)))];
        self.xml.empty("origin", &origin);
        if !matches!(word, "fixed" | "floating") {
            self.xml.empty("axis", &[("xyz", "0 0 1".into())]);
        }
        if matches!(word, "prismatic" | "revolute") {
            // The format requires limits. Very wide limits replace missing ones.
            let (lower, upper) = range.unwrap_or((-WIDE, WIDE));
            let [effort, rate] = [effort, rate].map(|limit| limit.unwrap_or(WIDE));
            let limits =
                [("lower", lower), ("upper", upper), ("effort", effort), ("velocity", rate)];
            self.xml.empty("limit", &limits.map(|(key, value)| (key, numbers(&[value]))));
        } else if word == "continuous" && (effort.is_some() || rate.is_some()) {
            let limits = [("effort", effort), ("velocity", rate)];
            let limits = limits.map(|(key, value)| (key, numbers(&[value.unwrap_or(WIDE)])));
            self.xml.empty("limit", &limits);
        }
        let dynamics = own.map(|own| dynamics::attributes(mechanism, own)).unwrap_or_default();
        if !dynamics.is_empty() {
            let all: Vec<_> =
                dynamics.into_iter().map(|(key, value)| (key, numbers(&[value]))).collect();
            self.xml.empty("dynamics", &all);
        }
        let mimic = self.mimics.iter().find(|mimic| Some(mimic.follower) == own);
        if let Some(&Mimic { leader, multiplier, offset, .. }) = mimic {
            let leader = mechanism.joints()[leader].name.clone();
            let numbers = [("multiplier", multiplier), ("offset", offset)]
                .map(|(key, value)| (key, numbers(&[value])));
            let [multiplier, offset] = numbers;
            self.xml.empty("mimic", &[("joint", leader), multiplier, offset]);
        }
        self.xml.close();
    }

    /// Returns the URDF type of a joint, and the rotation from the axes of the model to those that URDF requires.
    fn word(&mut self, joint: &Joint, forward: bool) -> (&'static str, Pose<f64>) {
        let none = Pose::identity();
        let name = joint.name.clone();
        match joint.joint_type {
            JointType::Prismatic => ("prismatic", if forward { none } else { flipped() }),
            JointType::Spherical => {
                self.convention.types.push((name, "SPHERICAL"));
                ("continuous", none)
            }
            JointType::Universal => {
                self.convention.types.push((name, "CARDAN"));
                let first = if forward { none } else { exchanged() };
                ("continuous", first * cardan())
            }
            JointType::Fixed => ("fixed", none),
            JointType::Free => ("floating", none),
            _ => ("continuous", if forward { none } else { flipped() }),
        }
    }

    fn tree_joint(&mut self, index: usize, forward: bool) {
        let joint = &self.home.model.mechanism.joints()[index];
        let (word, axes) = self.word(joint, forward);
        let ends = if forward {
            (joint.predecessor, joint.successor, joint.frame_j, joint.frame_k)
        } else {
            self.reversed.push(index);
            (joint.successor, joint.predecessor, joint.frame_k, joint.frame_j)
        };
        let (near, far) = (ends.2 * axes, ends.3 * axes);
        let (from, to) = (self.bodies[ends.0.0].clone(), self.bodies[ends.1.0].clone());
        self.motors(joint);
        if is_identity(far) {
            self.joint(&joint.name, word, (&from, &to), near);
            return;
        }
        let between = self.links.take(&format!("{}.frame", joint.name));
        self.link(&between);
        self.joint(&joint.name, word, (&from, &between), near);
        self.joint(&format!("{between}_fixed"), "fixed", (&between, &to), far.inverse());
    }

    fn motors(&mut self, joint: &Joint) {
        if joint.actuated_dofs().next().is_some() {
            self.convention.motors.push(joint.name.clone());
        }
    }

    /// Writes a joint that closes a loop as two frames that must coincide.
    fn closure(&mut self, index: usize) {
        let joint = &self.home.model.mechanism.joints()[index];
        let name = &joint.name;
        let bodies = [joint.predecessor, joint.successor].map(|body| self.bodies[body.0].clone());
        let [from, to] = bodies;
        let kind = match joint.joint_type {
            JointType::Free => return,
            JointType::Spherical => "3d",
            JointType::Fixed => "6d",
            _ => {
                // The joint carries a link that coincides with the joint frame on the successor.
                let (word, axes) = self.word(joint, true);
                self.motors(joint);
                let between = self.links.take(&format!("{name}.frame"));
                self.link(&between);
                self.joint(name, word, (&from, &between), joint.frame_j * axes);
                let second = self.frame(&format!("{name}.to"), &to, joint.frame_k * axes);
                self.convention.closures.push(([between, second], "6d"));
                return;
            }
        };
        let first = self.frame(&format!("{name}.from"), &from, joint.frame_j);
        let second = self.frame(&format!("{name}.to"), &to, joint.frame_k);
        self.convention.closures.push(([first, second], kind));
    }

    /// Adds a link without mass that marks a frame of a loop closure, and returns the name of the
    /// link. The link is fixed to the link `on`. Each closure has its own link, even if its frame
    /// equals that of `on`.
    fn frame(&mut self, name: &str, on: &str, place: Pose<f64>) -> String {
        let link = self.links.take(name);
        self.link(&link);
        self.joint(&format!("{link}_fixed"), "fixed", (on, &link), place);
        link
    }

    fn extensions(&mut self) {
        let mechanism = &self.home.model.mechanism;
        self.xml.text("stiction:gravity", &[], &numbers(&mechanism.gravity().to_array()));
        let mut entries = extension::frictions(mechanism);
        entries.extend(extension::default_friction(self.home.model));
        entries.extend(extension::springs(mechanism));
        entries.extend(extension::others(mechanism));
        entries.extend(extension::reversed(mechanism, self.reversed.iter().copied()));
        entries.extend(extension::coordinates(self.home));
        for Entry { kind, name, text } in entries {
            // Coordinates in URDF equal those of the model, so the home coordinates are written as
            // start coordinates of the joints.
            let kind = if kind == "coordinates" { "start" } else { kind };
            self.xml.text(extension::tag(kind), &[("name", name)], &text);
        }
    }
}

impl Convention {
    fn text(&self) -> Option<String> {
        if self.closures.is_empty() && self.motors.is_empty() && self.types.is_empty() {
            return None;
        }
        let quoted = |text: &str| format!("'{}'", text.replace('\'', "''"));
        let list = |items: Vec<String>| format!("[{}]", items.join(", "));
        let pair = |([a, b], _): &([String; 2], _)| list(vec![quoted(a), quoted(b)]);
        let lines = [
            ("closed_loop", list(self.closures.iter().map(pair).collect())),
            ("type", list(self.closures.iter().map(|(_, kind)| quoted(kind)).collect())),
            ("name_mot", list(self.motors.iter().map(|name| quoted(name)).collect())),
            ("joint_name", list(self.types.iter().map(|(name, _)| quoted(name)).collect())),
            ("joint_type", list(self.types.iter().map(|(_, kind)| quoted(kind)).collect())),
        ];
        let lines = lines.map(|(key, value)| format!("{key}: {value}\n")).concat();
        Some(format!("{lines}{WRITTEN}\n"))
    }
}
