//! Recognises repeating legs: chains of joints and bodies between the same two bodies, equal except for their names
//! and their places.

mod names;
pub(super) mod placement;
mod same;

pub(super) use same::is_same;

use super::description::{Description, GROUND};
use super::names::TAKEN;
use super::text::legs::properties;
use names::Pattern;
use std::collections::{HashMap, HashSet};
use stiction_core::joint::JointType;

/// Maximum number of joints in the chain of a leg; it limits the time of the search.
const LONGEST: usize = 30;

/// Group of equal legs.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) from: usize,
    pub(super) to: usize,
    /// Legs in the order of their first joints in the file.
    pub(super) legs: Vec<Leg>,
    /// Names of the joints of a leg, in order from `from` to `to`.
    pub(super) joints: Vec<Part>,
    /// Names of the bodies between the joints, in the same order.
    pub(super) bodies: Vec<Part>,
}

/// A leg: the indices of its joints, in order from `from` to `to`, and of the bodies between them.
#[derive(Clone, Debug)]
pub(super) struct Leg {
    pub(super) name: String,
    pub(super) joints: Vec<usize>,
    pub(super) bodies: Vec<usize>,
}

/// Names of a joint or body that every leg of a group has.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Name of the part within the leg, such as `rod`.
    pub(super) key: String,
    /// Pattern of the part's names in the model, with `{}` in place of the leg's name.
    pub(super) pattern: String,
}

impl Part {
    /// Tests if the part has the default name in the model: the leg's name, a dot, and the name of
    /// the part within the leg.
    pub(super) fn has_default_names(&self) -> bool {
        self.pattern.strip_prefix("{}.") == Some(self.key.as_str())
    }
}

/// A chain of joints between two bodies, with the bodies between the joints.
#[derive(Clone)]
struct Walk {
    from: usize,
    to: usize,
    joints: Vec<usize>,
    bodies: Vec<usize>,
}

/// Finds groups of equal legs. No joint or body belongs to two groups.
pub(super) fn find(robot: &Description) -> Vec<Group> {
    let kinds = |walk: &Walk| -> Vec<JointType> {
        walk.joints.iter().map(|&joint| robot.joints[joint].kind).collect()
    };
    let mut by_kinds: HashMap<_, Vec<Walk>> = HashMap::new();
    for walk in walks(robot) {
        let kinds = kinds(&walk);
        if !kinds.contains(&JointType::Free) {
            by_kinds.entry((walk.from, walk.to, kinds)).or_default().push(walk);
        }
    }
    // A chain may belong to several classes of equal chains, because several words of its names may
    // be the leg's name.
    let mut alike: HashMap<_, Vec<(Walk, Pattern)>> = HashMap::new();
    for walk in by_kinds.into_values().filter(|walks| walks.len() > 1).flatten() {
        let joints = walk.joints.iter().map(|&joint| robot.joints[joint].name.as_str());
        let bodies = walk.bodies.iter().map(|&body| robot.bodies[body].name.as_str());
        let names: Vec<&str> = joints.chain(bodies).collect();
        let properties = properties(robot, &walk.joints, &walk.bodies);
        for pattern in names::patterns(&names) {
            let ends = (walk.from, walk.to);
            let key = (ends, kinds(&walk), pattern.names.clone(), properties.clone());
            alike.entry(key).or_default().push((walk.clone(), pattern));
        }
    }
    let mut classes: Vec<Vec<(Walk, Pattern)>> =
        alike.into_values().filter(|class| class.len() > 1).collect();
    // Prefer groups with many parts, then groups with longer names of legs; the first joint makes
    // the order unique.
    classes.sort_by_key(|class| {
        let parts = (class.len() - 1) * class[0].0.joints.len();
        let letters: usize = class.iter().map(|(_, pattern)| pattern.leg.len()).sum();
        let first = class.iter().filter_map(|(walk, _)| walk.joints.iter().min()).min().copied();
        (usize::MAX - parts, usize::MAX - letters, first, class[0].1.names.clone())
    });
    let (mut joints, mut bodies) = (HashSet::new(), HashSet::new());
    let mut taken: HashSet<String> = HashSet::new();
    let mut groups = Vec::new();
    for class in classes {
        let mut legs: Vec<Leg> = class
            .iter()
            .map(|(walk, pattern)| Leg {
                name: pattern.leg.clone(),
                joints: walk.joints.clone(),
                bodies: walk.bodies.clone(),
            })
            .collect();
        let is_free = |leg: &Leg| {
            leg.joints.iter().all(|joint| !joints.contains(joint))
                && leg.bodies.iter().all(|body| !bodies.contains(body))
                && !taken.contains(&leg.name)
        };
        legs.retain(is_free);
        let mut own: HashSet<usize> = HashSet::new();
        let mut named: HashSet<String> = HashSet::new();
        legs.retain(|leg| {
            leg.bodies.iter().all(|body| !own.contains(body)) && named.insert(leg.name.clone()) && {
                own.extend(&leg.bodies);
                true
            }
        });
        if legs.len() < 2 {
            continue;
        }
        legs.sort_by_key(|leg| leg.joints.first().copied());
        let (walk, pattern) = &class[0];
        let Some((own_joints, own_bodies)) = parts(robot, walk, pattern) else { continue };
        for leg in &legs {
            joints.extend(leg.joints.iter().copied());
            bodies.extend(leg.bodies.iter().copied());
            taken.insert(leg.name.clone());
        }
        let (from, to) = (walk.from, walk.to);
        groups.push(Group { from, to, legs, joints: own_joints, bodies: own_bodies });
    }
    // The legs of a group can end at a body of another leg only if the group of that leg is written
    // earlier. The order of the file usually ensures this.
    groups.sort_by_key(|group| group.legs[0].joints.first().copied());
    groups
}

/// Lists the chains that contain at least one body and end at a body that is the successor of
/// several joints. Each body inside a chain is the successor of exactly one joint.
fn walks(robot: &Description) -> Vec<Walk> {
    let mut into: Vec<Vec<usize>> = vec![Vec::new(); robot.bodies.len()];
    for (index, joint) in robot.joints.iter().enumerate() {
        into[joint.to].push(index);
    }
    let mut walks = Vec::new();
    for (to, last) in into.iter().enumerate().filter(|(_, joints)| joints.len() > 1) {
        for &last in last {
            let (mut joints, mut bodies) = (vec![last], Vec::new());
            let mut body = robot.joints[last].from;
            while body != GROUND
                && body != to
                && joints.len() < LONGEST
                && let [joint] = into[body][..]
                && !bodies.contains(&body)
            {
                bodies.push(body);
                joints.push(joint);
                body = robot.joints[joint].from;
                let reversed = |list: &[usize]| list.iter().rev().copied().collect();
                if body != to && !bodies.contains(&body) {
                    let (joints, bodies) = (reversed(&joints), reversed(&bodies));
                    walks.push(Walk { from: body, to, joints, bodies });
                }
            }
        }
    }
    walks
}

/// Names of the joints and bodies of a chain; `None` if two parts would have the same name within
/// the leg.
fn parts(robot: &Description, walk: &Walk, pattern: &Pattern) -> Option<(Vec<Part>, Vec<Part>)> {
    let (joint_names, body_names) = pattern.names.split_at(walk.joints.len());
    let symbols: Vec<&str> =
        walk.joints.iter().map(|&joint| robot.joints[joint].kind.symbol()).collect();
    let joint = |(index, pattern): (usize, &String)| {
        let same = |symbol: &&&str| **symbol == symbols[index];
        let number = symbols[..=index].iter().filter(same).count();
        let is_alone = symbols.iter().filter(same).count() == 1;
        let number = if is_alone { String::new() } else { number.to_string() };
        Part { key: format!("{}{number}", symbols[index]), pattern: pattern.clone() }
    };
    let joints: Vec<Part> = joint_names.iter().enumerate().map(joint).collect();
    let body = |(index, pattern): (usize, &String)| {
        let key = names::bare(pattern);
        let is_joint = JointType::from_symbol(&key).is_some();
        let first = key.split('.').next().unwrap_or_default();
        let key = if first.is_empty() || is_joint || TAKEN.contains(&first) {
            format!("link{}", index + 1)
        } else {
            key
        };
        Part { key, pattern: pattern.clone() }
    };
    let bodies: Vec<Part> = body_names.iter().enumerate().map(body).collect();
    let mut keys: HashSet<&str> = joints.iter().map(|part| part.key.as_str()).collect();
    bodies.iter().all(|part| keys.insert(&part.key)).then_some((joints, bodies))
}
