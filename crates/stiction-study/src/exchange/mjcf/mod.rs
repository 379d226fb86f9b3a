//! MuJoCo's XML: the mechanism as a tree of nested bodies, and equalities that close the loops.

mod friction;
mod inertia;
mod names;
mod steps;
mod tree;
mod xml;

use super::Home;
use names::Names;
use steps::{Kind, Step, steps};
use stiction::joint::JointType;
use stiction::mechanism::{BodyId, GROUND_NAME, Joint};
use stiction::spatial::{Pose, Quaternion, Vec3};
use thiserror::Error;
use tree::{Closing, Part, Tree};
use xml::{Xml, numbers};

/// How stiff equalities are: of MuJoCo's soft constraints among the stiffest that its integrators
/// follow with the step of the file.
const SOLREF: &str = "0.002 1";
const SOLIMP: &str = "0.9999 0.9999 0.001 0.5 2";
/// The step of a simulation, s: half the time constant of the equalities, as MuJoCo asks for.
const TIMESTEP: f64 = 0.001;

/// A file for MuJoCo, and what it could not say.
#[derive(Clone, Debug, PartialEq)]
pub struct Mjcf {
    /// The file.
    pub text: String,
    /// What is left out or changed, a line each.
    pub notes: Vec<String>,
}

/// Why a mechanism cannot be a file for MuJoCo.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Unfit {
    /// A moving body has no mass.
    #[error("MuJoCo takes no moving body without mass, such as `{body}`")]
    Massless {
        /// The body.
        body: String,
    },
    /// A joint closes a loop, and no body beside it has a mass to hang on it.
    #[error(
        "joint `{joint}` closes a loop, for which MuJoCo needs a part of a body beside it, and \
         neither of them has mass"
    )]
    CannotClose {
        /// The joint.
        joint: String,
    },
}

impl Unfit {
    /// A way out.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Massless { .. } => {
                "give it a small mass, or leave it out and join its neighbours"
            }
            Self::CannotClose { .. } => "give one of them a small mass",
        }
    }
}

/// The file.
///
/// # Errors
/// Bodies without mass that MuJoCo would refuse.
pub fn mjcf(home: &Home<'_>) -> Result<Mjcf, Unfit> {
    let tree = Tree::new(&home.model.mechanism)?;
    check_masses(home, &tree)?;
    let mut writer = Writer::new(home, &tree);
    let notes = writer.notes();
    writer.write(&notes);
    Ok(Mjcf { text: writer.xml.finish(), notes })
}

/// Every body with joints has mass, its own or of bodies that are fixed to it.
fn check_masses(home: &Home<'_>, tree: &Tree) -> Result<(), Unfit> {
    let mechanism = &home.model.mechanism;
    let is_fixed = |part: &Part| mechanism.joints()[part.joint].joint_type == JointType::Fixed;
    // Children stand behind their parents.
    let mut heavy: Vec<bool> = mechanism.bodies().iter().map(|body| body.mass > 0.0).collect();
    for part in tree.parts.iter().rev().filter(|part| is_fixed(part)) {
        heavy[part.parent] |= heavy[part.body];
    }
    match tree.parts.iter().find(|part| !is_fixed(part) && !heavy[part.body]) {
        None => Ok(()),
        Some(part) => Err(Unfit::Massless { body: mechanism.bodies()[part.body].name.clone() }),
    }
}

/// A joint of the file with its name.
struct NamedStep {
    step: Step,
    name: String,
}

/// The names of a part and of its joints.
struct NamedPart {
    name: String,
    /// Its six coordinates in the world, for which MJCF has a joint of its own.
    free: Option<String>,
    /// The joints by which it hangs otherwise.
    steps: Vec<NamedStep>,
}

/// A marked frame of a body.
#[derive(Clone)]
struct Site {
    name: String,
    pose: Pose<f64>,
    /// It is on the further part of the body that hangs by this joint.
    part: Option<usize>,
}

/// The file as it grows.
struct Writer<'a> {
    home: &'a Home<'a>,
    tree: &'a Tree,
    xml: Xml,
    parts: Vec<NamedPart>,
    /// For each of our bodies its sites.
    sites: Vec<Vec<Site>>,
    /// For each spring the names of the sites at its ends.
    spring_sites: Vec<[String; 2]>,
    /// For each joint that closes a loop the names of the sites that coincide.
    closing_sites: Vec<[String; 2]>,
}

impl<'a> Writer<'a> {
    fn new(home: &'a Home<'a>, tree: &'a Tree) -> Self {
        let mechanism = &home.model.mechanism;
        let (mut bodies, mut joints) = (Names::default(), Names::default());
        bodies.reserve("world");
        let own: Vec<String> = mechanism.bodies().iter().map(|b| bodies.take(&b.name)).collect();
        let parts = tree.parts.iter().map(|part| {
            let joint = &mechanism.joints()[part.joint];
            let name = match part.is_further {
                false => own[part.body].clone(),
                true => bodies.take(&format!("{}@{}", own[part.body], joint.name)),
            };
            if part.is_free {
                let free = Some(joints.take(&joint.name));
                return NamedPart { name, free, steps: Vec::new() };
            }
            let steps = steps(home, part.joint, part.reversed).into_iter().map(|step| {
                let name = joints.take(&format!("{}{}", joint.name, step.suffix));
                NamedStep { step, name }
            });
            NamedPart { name, free: None, steps: steps.collect() }
        });
        let parts = parts.collect();
        let mut writer = Self {
            home,
            tree,
            xml: Xml::default(),
            parts,
            sites: vec![Vec::new(); mechanism.bodies().len()],
            spring_sites: Vec::new(),
            closing_sites: Vec::new(),
        };
        writer.place_sites();
        writer
    }

    /// Where springs end, and what closes loops.
    fn place_sites(&mut self) {
        let mechanism = &self.home.model.mechanism;
        let mut names = Names::default();
        for spring in mechanism.springs() {
            let own = ["from", "to"].map(|end| names.take(&format!("{}.{end}", spring.name)));
            for (end, name) in own.iter().enumerate() {
                let (name, pose) = (name.clone(), Pose::at(spring.points[end]));
                self.sites[spring.ends[end].0].push(Site { name, pose, part: None });
            }
            self.spring_sites.push(own);
        }
        for &(index, closing) in &self.tree.closings {
            let joint = self.joint(index);
            let own = ["from", "to"].map(|end| names.take(&format!("{}.{end}", joint.name)));
            let [from, to] = own.clone();
            let (j, k) = (joint.predecessor.0, joint.successor.0);
            let place = |name: String, pose| Site { name, pose, part: None };
            match closing {
                Closing::Nothing => {}
                Closing::Connect | Closing::Weld => {
                    self.sites[j].push(place(from, joint.frame_j));
                    self.sites[k].push(place(to, joint.frame_k));
                }
                Closing::Part => {
                    // Both at the same place of the two parts of one body.
                    let is_it = |part: &&Part| part.joint == index;
                    let Some(part) = self.tree.parts.iter().find(is_it) else { continue };
                    let (body, pose) = match part.reversed {
                        true => (j, joint.frame_j),
                        false => (k, joint.frame_k),
                    };
                    self.sites[body].push(place(from, pose));
                    self.sites[body].push(Site { name: to, pose, part: Some(index) });
                }
            }
            self.closing_sites.push(own);
        }
    }

    fn joint(&self, index: usize) -> &'a Joint {
        &self.home.model.mechanism.joints()[index]
    }

    /// What the file leaves out or changes.
    fn notes(&self) -> Vec<String> {
        let mechanism = &self.home.model.mechanism;
        let mut notes = Vec::new();
        let (mut all, mut left_out) = (0, 0);
        for (index, joint) in mechanism.joints().iter().enumerate() {
            let has_steps = self.tree.parts.iter().any(|part| part.joint == index);
            all += joint.friction.len();
            let carried = |contact: &&_| friction::is_damping_alone(contact, has_steps);
            left_out += joint.friction.len() - joint.friction.iter().filter(carried).count();
        }
        if left_out > 0 {
            notes.push(format!(
                "friction is left out at {left_out} of {all} contacts: MJCF has none that grows with \
                 the load or is different backward, and none where a ball closes a loop; viscous \
                 friction elsewhere is there as damping"
            ));
        }
        let length = mechanism.characteristic_length();
        let raised: Vec<&str> = (1..mechanism.bodies().len())
            .filter(|&body| {
                let content = &mechanism.bodies()[body];
                content.mass > 0.0 && inertia::accepted(content, length, self.tree.count[body]).1
            })
            .map(|body| mechanism.bodies()[body].name.as_str())
            .collect();
        if !raised.is_empty() {
            notes.push(format!(
                "the least moments of inertia of {} are raised, since MuJoCo takes none that no body \
                 can have; this changes nothing as long as they turn about their other axes only",
                raised.join(", ")
            ));
        }
        if mechanism.joints().iter().any(|joint| joint.compliance.is_some()) {
            notes.push("compliances of joints are left out".to_owned());
        }
        notes
    }

    fn write(&mut self, notes: &[String]) {
        let mechanism = &self.home.model.mechanism;
        self.xml.open("mujoco", &[("model", self.home.model.name.clone())]);
        let title = &*self.home.model.title;
        let made = format!("Written by stiction {}. SI units.", env!("CARGO_PKG_VERSION"));
        let lines: Vec<&str> = [title, &made].into_iter().filter(|l| !l.is_empty()).collect();
        self.xml.comment(&lines);
        self.xml.comment(&[
            "Bodies have their frames, joints their coordinates (qpos) as in the model. A ball's qpos is",
            "the rotation of its body since the home position, in the body's axes. The file's own",
            "position (qpos0) is the home: the mechanism put together at the start of a motion.",
        ]);
        for note in notes {
            self.xml.comment(&[&format!("Note: {note}.")]);
        }
        self.xml.empty(
            "compiler",
            &[
                ("angle", "radian".into()),
                ("autolimits", "false".into()),
                ("inertiafromgeom", "false".into()),
            ],
        );
        let gravity = numbers(&mechanism.gravity().to_array());
        self.xml.empty("option", &[("gravity", gravity), ("timestep", numbers(&[TIMESTEP]))]);
        self.write_bodies();
        self.write_equalities();
        self.write_springs();
        self.write_drives();
        self.write_keyframe();
    }

    fn write_bodies(&mut self) {
        self.xml.open("worldbody", &[]);
        let base = self.xml.depth();
        // A body of its own: programs that read only the first body of the world find everything in it.
        let mut attributes = vec![("name", GROUND_NAME.to_owned())];
        attributes.extend(placed(self.home.model.mechanism.base()));
        self.xml.open("body", &attributes);
        self.xml.empty("inertial", &massless());
        self.write_sites(BodyId::GROUND.0, None);
        for index in 0..self.tree.parts.len() {
            while self.xml.depth() > base + self.tree.parts[index].depth {
                self.xml.close();
            }
            self.write_part(index);
        }
        while self.xml.depth() >= base {
            self.xml.close();
        }
    }

    fn write_part(&mut self, index: usize) {
        let (home, part) = (self.home, &self.tree.parts[index]);
        let mechanism = &home.model.mechanism;
        let body = &mechanism.bodies()[part.body];
        let in_parent = match part.is_free {
            true => home.poses[part.body],
            false => home.poses[part.parent].inverse() * home.poses[part.body],
        };
        let mut attributes = vec![("name", self.parts[index].name.clone())];
        attributes.extend(placed(in_parent));
        self.xml.open("body", &attributes);
        if body.mass > 0.0 {
            let (length, count) = (mechanism.characteristic_length(), self.tree.count[part.body]);
            let share = 1.0 / count as f64;
            let (inertia, _) = inertia::accepted(body, length, count);
            let entry = |(i, j)| inertia.at(i, j) * share;
            let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(entry);
            self.xml.empty(
                "inertial",
                &[
                    ("pos", numbers(&body.com.to_array())),
                    ("mass", numbers(&[body.mass * share])),
                    ("fullinertia", numbers(&entries)),
                ],
            );
        } else {
            self.xml.empty("inertial", &massless());
        }
        self.write_steps(index);
        self.write_sites(part.body, part.is_further.then_some(part.joint));
    }

    fn write_steps(&mut self, index: usize) {
        let part = &self.tree.parts[index];
        let joint = self.joint(part.joint);
        let NamedPart { free, steps, .. } = &self.parts[index];
        if let Some(name) = free {
            self.xml.empty("freejoint", &[("name", name.clone())]);
        }
        let damping = friction::damping(joint);
        for NamedStep { step, name } in steps {
            let kind = match step.kind {
                Kind::Hinge => "hinge",
                Kind::Slide => "slide",
                Kind::Ball => "ball",
            };
            let mut attributes = vec![("name", name.clone()), ("type", kind.into())];
            attributes.push(("pos", numbers(&step.position.to_array())));
            if step.kind != Kind::Ball {
                attributes.push(("axis", numbers(&step.axis.to_array())));
                attributes.push(("ref", numbers(&[step.home])));
            }
            let damping = step.freedom.map_or(0.0, |freedom| damping[freedom]);
            if damping > 0.0 {
                attributes.push(("damping", numbers(&[damping])));
            }
            self.xml.empty("joint", &attributes);
        }
    }

    /// The sites of a body, or of a further part of it.
    fn write_sites(&mut self, body: usize, part: Option<usize>) {
        for site in self.sites[body].iter().filter(|site| site.part == part) {
            let mut attributes = vec![("name", site.name.clone())];
            attributes.extend(placed(site.pose));
            self.xml.empty("site", &attributes);
        }
    }

    fn write_equalities(&mut self) {
        let mut joint_names = Names::default();
        let threads: Vec<usize> = (0..self.tree.parts.len())
            .filter(|&k| self.joint(self.tree.parts[k].joint).joint_type == JointType::Helical)
            .collect();
        let closings = &self.tree.closings;
        if closings.iter().all(|(_, closing)| *closing == Closing::Nothing) && threads.is_empty() {
            return;
        }
        self.xml.open("equality", &[]);
        self.xml.comment(&[
            "MuJoCo's equalities are soft: solref and solimp say how far. A body at the end of a loop is in",
            "two parts, one of which hangs by the closing joint and is named after it: welded together,",
            "they have the mass and the inertia of the body.",
        ]);
        for (&(joint, closing), sites) in closings.iter().zip(&self.closing_sites) {
            let tag = match closing {
                Closing::Nothing => continue,
                Closing::Connect => "connect",
                Closing::Weld | Closing::Part => "weld",
            };
            let [from, to] = sites.clone();
            let name = joint_names.take(&self.joint(joint).name);
            let mut attributes = vec![("name", name), ("site1", from), ("site2", to)];
            attributes.extend(stiffness());
            self.xml.empty(tag, &attributes);
        }
        for part in threads {
            let joint = self.joint(self.tree.parts[part].joint);
            let names = self.parts[part].steps.iter();
            let (advance, angle): (Vec<_>, Vec<_>) =
                names.partition(|named| named.step.freedom.is_none());
            let (Some(advance), Some(angle)) = (advance.first(), angle.first()) else { continue };
            let mut attributes = vec![
                ("name", joint_names.take(&advance.name)),
                ("joint1", advance.name.clone()),
                ("joint2", angle.name.clone()),
                ("polycoef", numbers(&[0.0, joint.pitch, 0.0, 0.0, 0.0])),
            ];
            attributes.extend(stiffness());
            self.xml.empty("joint", &attributes);
        }
        self.xml.close();
    }

    fn write_springs(&mut self) {
        let springs = self.home.model.mechanism.springs();
        if springs.is_empty() {
            return;
        }
        self.xml.open("tendon", &[]);
        for (spring, sites) in springs.iter().zip(&self.spring_sites) {
            self.xml.open(
                "spatial",
                &[
                    ("name", spring.name.clone()),
                    ("stiffness", numbers(&[spring.stiffness])),
                    ("springlength", numbers(&[spring.free_length])),
                    ("damping", numbers(&[spring.damping])),
                ],
            );
            for site in sites {
                self.xml.empty("site", &[("site", site.clone())]);
            }
            self.xml.close();
        }
        self.xml.close();
    }

    fn write_drives(&mut self) {
        let mechanism = &self.home.model.mechanism;
        let mut drives = Vec::new();
        let names = crate::inverse::columns::Names::new(mechanism).drives;
        let mut taken = Names::default();
        for ((joint, freedom), (name, _)) in mechanism.actuators().zip(names) {
            let steps = self.tree.parts.iter().zip(&self.parts);
            let own =
                steps.filter(|(part, _)| part.joint == joint.0).flat_map(|(_, own)| &own.steps);
            let named = own.into_iter().find(|named| named.step.freedom == Some(freedom));
            drives.extend(named.map(|named| (taken.take(&name), named.name.clone())));
        }
        if drives.is_empty() {
            return;
        }
        self.xml.open("actuator", &[]);
        for (name, joint) in drives {
            self.xml.empty("motor", &[("name", name), ("joint", joint), ("gear", "1".into())]);
        }
        self.xml.close();
    }

    fn write_keyframe(&mut self) {
        let mut qpos = Vec::new();
        for (part, NamedPart { free, steps, .. }) in self.tree.parts.iter().zip(&self.parts) {
            if free.is_some() {
                let pose = self.home.poses[part.body];
                qpos.extend(pose.position.to_array());
                qpos.extend(quaternion(pose));
            }
            for NamedStep { step, .. } in steps {
                match step.kind {
                    Kind::Ball => qpos.extend([1.0, 0.0, 0.0, 0.0]),
                    _ => qpos.push(step.home),
                }
            }
        }
        self.xml.open("keyframe", &[]);
        self.xml.empty("key", &[("name", "home".into()), ("qpos", numbers(&qpos))]);
        self.xml.close();
    }
}

/// Inertia of what has none; not every program takes it for granted.
fn massless() -> [(&'static str, String); 3] {
    let zeros = numbers(&[0.0; 3]);
    [("pos", zeros.clone()), ("mass", numbers(&[0.0])), ("diaginertia", zeros)]
}

fn stiffness() -> [(&'static str, String); 2] {
    [("solref", SOLREF.into()), ("solimp", SOLIMP.into())]
}

fn placed(pose: Pose<f64>) -> [(&'static str, String); 2] {
    let Pose { position, .. } = pose;
    [("pos", numbers(&Vec3::to_array(position))), ("quat", numbers(&quaternion(pose)))]
}

fn quaternion(pose: Pose<f64>) -> [f64; 4] {
    let mut quaternion = [0.0; 4];
    Quaternion::from_rotation(pose.rotation).write(&mut quaternion);
    quaternion
}
