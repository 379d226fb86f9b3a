//! Layout of a mechanism: positions of its joints in space, and bodies grouped into legs.

use super::placed::Placed;
use stiction_core::disjoint_sets::DisjointSets;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{BodyId, Mechanism};
use stiction_core::spatial::Vec3;

/// Smallest number of joints of a hub, a body at which legs begin or end.
const HUB: usize = 3;

/// Layout of a mechanism. Points are in world axes, relative to the common origin of the poses, m.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// Position of the symbol of each joint.
    pub(super) places: Vec<Vec3<f64>>,
    /// For each joint, the points of its two bodies to which the joint's symbol is attached.
    pub(super) anchorages: Vec<Anchorage>,
    /// Indices of the joints of each body.
    pub(super) joints: Vec<Vec<usize>>,
    /// True for each body that is a hub; the ground is always a hub.
    pub(super) hubs: Vec<bool>,
    /// Index of the branch (leg) of each body; `None` for hubs.
    pub(super) branch: Vec<Option<usize>>,
    /// Name of each branch.
    pub(super) branches: Vec<String>,
}

impl Layout {
    pub(super) fn new(placed: &Placed<'_>) -> Self {
        let mechanism = placed.mechanism;
        let joints = joints_of_bodies(mechanism);
        let hubs = hubs(mechanism, &joints);
        let anchorages = anchorages(placed, &joints, &hubs);
        let places = places(placed, &anchorages);
        let (branch, branches) = branches(mechanism, &joints, &hubs);
        Self { places, anchorages, joints, hubs, branch, branches }
    }

    /// Returns the index of the branch to which a joint belongs: the branch of the successor or, if
    /// the successor is a hub, that of the predecessor. `None` for a joint between two hubs.
    pub(super) fn branch_of_joint(&self, mechanism: &Mechanism, joint: usize) -> Option<usize> {
        let (p, s) = ends(mechanism, joint);
        self.branch[s].or(self.branch[p])
    }

    /// Returns the mean position of the symbols of a body's joints; `None` for a body without
    /// joints.
    pub(super) fn middle(&self, body: usize) -> Option<Vec3<f64>> {
        mean(self.joints[body].iter().map(|&joint| self.places[joint]))
    }
}

/// Returns, for each joint, the index of its leg, which determines the colour of the joint in
/// pictures. The entry is `None` for a joint between two hubs.
pub fn legs_of_joints(mechanism: &Mechanism) -> Vec<Option<usize>> {
    let joints = joints_of_bodies(mechanism);
    let (branch, _) = branches(mechanism, &joints, &hubs(mechanism, &joints));
    let leg = |joint: usize| {
        let (p, s) = ends(mechanism, joint);
        branch[s].or(branch[p])
    };
    (0..mechanism.joints().len()).map(leg).collect()
}

/// Largest number of bodies whose paths are drawn. If more bodies qualify, no path is drawn.
const TRACED: usize = 4;

/// Returns the indices of the bodies whose paths show the motion of a mechanism: the hubs except
/// the ground, such as platforms; without such hubs, the ends of open chains; without open chains,
/// all bodies that no joint connects to the ground. Returns an empty list if these are more than
/// four bodies.
pub fn outputs(mechanism: &Mechanism) -> Vec<usize> {
    let joints = joints_of_bodies(mechanism);
    let hubs = hubs(mechanism, &joints);
    let off_ground = |body: &usize| is_off_ground(&joints, *body);
    let is_end = |body: &usize| joints[*body].len() == 1 && off_ground(body);
    traced_of(joints.len(), &[&|body| hubs[*body], &is_end, &off_ground])
}

/// Returns the bodies, without the ground, that satisfy a condition: the first of `conditions` that
/// at least one body satisfies. Returns an empty list if more than [`TRACED`] bodies satisfy this
/// condition.
pub(super) fn traced_of(bodies: usize, conditions: &[&dyn Fn(&usize) -> bool]) -> Vec<usize> {
    let mut all = conditions.iter().map(|holds| (1..bodies).filter(holds).collect::<Vec<_>>());
    let found = all.find(|found| !found.is_empty()).unwrap_or_default();
    if found.len() > TRACED { Vec::new() } else { found }
}

/// Returns true if no joint connects the body to the ground.
pub(super) fn is_off_ground(joints: &[Vec<usize>], body: usize) -> bool {
    joints[body].iter().all(|joint| !joints[BodyId::GROUND.0].contains(joint))
}

/// Returns the part of a body's name before the first dot, which is the name of the leg; `None` if
/// the name has no dot.
pub(super) fn leg_of(name: &str) -> Option<&str> {
    name.split_once('.').map(|(leg, _)| leg)
}

pub(super) fn ends(mechanism: &Mechanism, joint: usize) -> (usize, usize) {
    let joint = &mechanism.joints()[joint];
    (joint.predecessor.0, joint.successor.0)
}

fn joints_of_bodies(mechanism: &Mechanism) -> Vec<Vec<usize>> {
    let mut joints = vec![Vec::new(); mechanism.bodies().len()];
    for (index, joint) in mechanism.joints().iter().enumerate() {
        // A free joint imposes no constraint.
        if joint.joint_type != JointType::Free {
            joints[joint.predecessor.0].push(index);
            joints[joint.successor.0].push(index);
        }
    }
    joints
}

/// Finds the hubs: the ground, and all bodies with at least three joints, except bodies of a named
/// leg, such as the upper arms of a Delta robot.
fn hubs(mechanism: &Mechanism, joints: &[Vec<usize>]) -> Vec<bool> {
    let is_hub = |(body, own): (usize, &Vec<usize>)| {
        body == BodyId::GROUND.0
            || own.len() >= HUB && leg_of(&mechanism.bodies()[body].name).is_none()
    };
    joints.iter().enumerate().map(is_hub).collect()
}

/// Groups the bodies into branches. Bodies that are connected without a hub between them, and
/// bodies whose names contain the same leg, form one branch. In a mechanism without legs, such as a
/// plain loop, each body is a separate branch.
fn branches(
    mechanism: &Mechanism,
    joints: &[Vec<usize>],
    hubs: &[bool],
) -> (Vec<Option<usize>>, Vec<String>) {
    let bodies = mechanism.bodies();
    let mut sets = DisjointSets::new(bodies.len());
    for joint in 0..mechanism.joints().len() {
        let (p, s) = ends(mechanism, joint);
        if !hubs[p] && !hubs[s] && joints[p].contains(&joint) {
            sets.unite(p, s);
        }
    }
    for a in 1..bodies.len() {
        let same = |b: &usize| leg_of(&bodies[*b].name) == leg_of(&bodies[a].name);
        if leg_of(&bodies[a].name).is_some()
            && let Some(b) = (1..a).find(same)
        {
            sets.unite(a, b);
        }
    }
    let mut group: Vec<usize> = (0..bodies.len()).map(|body| sets.least(body)).collect();
    // A chain that is connected to one hub only is a serial arm, not a leg.
    let held = |member: usize| {
        let is_member = |body: usize| !hubs[body] && group[body] == member;
        let at_hub = (0..mechanism.joints().len()).filter(|&joint| {
            let (p, s) = ends(mechanism, joint);
            joints[p].contains(&joint) && (is_member(p) && hubs[s] || is_member(s) && hubs[p])
        });
        at_hub.count()
    };
    let serial: Vec<bool> = (0..bodies.len())
        .map(|body| leg_of(&bodies[body].name).is_none() && held(group[body]) < 2)
        .collect();
    for body in (0..bodies.len()).filter(|&body| serial[body]) {
        group[body] = body;
    }
    let mut roots: Vec<usize> = (0..bodies.len()).filter(|&b| !hubs[b]).map(|b| group[b]).collect();
    roots.sort_unstable();
    roots.dedup();
    if roots.len() < 2 {
        roots = (0..bodies.len()).filter(|&b| !hubs[b]).collect();
        group = (0..bodies.len()).collect();
    }
    let branch = |b: usize| roots.binary_search(&group[b]).ok().filter(|_| !hubs[b]);
    let branch: Vec<Option<usize>> = (0..bodies.len()).map(branch).collect();
    let names = (0..roots.len()).map(|k| {
        let members: Vec<&str> = (0..bodies.len())
            .filter(|&b| branch[b] == Some(k))
            .map(|b| bodies[b].name.as_str())
            .collect();
        let leg = members.first().and_then(|name| leg_of(name));
        match leg {
            Some(leg) if members.iter().all(|name| leg_of(name) == Some(leg)) => leg.to_owned(),
            _ => members.join(", "),
        }
    });
    let names = names.collect();
    (branch, names)
}

/// Point that the symbol of a joint follows during a motion. It lies between a point of the
/// predecessor and a point of the successor, each given in the frame of its body, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchorage {
    pub(super) on_predecessor: Vec3<f64>,
    pub(super) on_successor: Vec3<f64>,
    /// Weight of the successor's point: with zero, the symbol is at the predecessor's point, with
    /// one at the successor's point.
    pub(super) weight: f64,
}

/// Computes the anchorage of each joint's symbol, usually the origin of the joint. The frames of a
/// sliding joint may lie anywhere along its axis, so the symbol of a sliding joint is drawn near
/// its bodies.
fn anchorages(placed: &Placed<'_>, joints: &[Vec<usize>], hubs: &[bool]) -> Vec<Anchorage> {
    let mechanism = placed.mechanism;
    let on_body = |joint: usize, body: usize| {
        let frame = if mechanism.joints()[joint].predecessor.0 == body {
            placed.frame_j[joint]
        } else {
            placed.frame_k[joint]
        };
        frame.position
    };
    // Mean position of the body's other joints. If there are none: the centre of mass or, for the
    // ground and bodies without mass, the origin of this joint's frame on the body.
    let anchor = |joint: usize, body: usize| {
        let others = joints[body].iter().filter(|&&other| other != joint);
        mean(others.map(|&other| on_body(other, body))).unwrap_or_else(|| {
            let content = &mechanism.bodies()[body];
            if body != BodyId::GROUND.0 && content.mass > 0.0 {
                placed.pose[body].apply(content.com)
            } else {
                on_body(joint, body)
            }
        })
    };
    let anchorage = |joint: usize| {
        let content = &mechanism.joints()[joint];
        let (p, s) = ends(mechanism, joint);
        let frame = &placed.frame_j[joint];
        let (origin, axis) = (frame.position, frame.rotation.columns[2]);
        let along = |point: Vec3<f64>| (point - origin).dot(axis);
        let between = |from: Vec3<f64>, to: Vec3<f64>, weight: f64| Anchorage {
            on_predecessor: placed.pose[p].inverse().apply(from),
            on_successor: placed.pose[s].inverse().apply(to),
            weight,
        };
        match content.joint_type {
            JointType::Prismatic | JointType::Cylindrical | JointType::Helical => {
                let [from, to] = [p, s].map(|body| along(anchor(joint, body)));
                let (from, to, weight) = match (hubs[p], hubs[s]) {
                    (true, false) => (to, to, 1.0),
                    (false, true) => (from, from, 0.0),
                    _ if is_amid(from, to) => (0.0, 0.0, 0.0),
                    _ => (from, to, 0.5),
                };
                between(origin + axis * from, origin + axis * to, weight)
            }
            JointType::Planar => {
                let slider = if hubs[s] && !hubs[p] { p } else { s };
                let point = origin + (anchor(joint, slider) - origin).across(axis);
                between(point, point, if slider == s { 1.0 } else { 0.0 })
            }
            JointType::Free => {
                let point = placed.frame_k[joint].position;
                between(point, point, 1.0)
            }
            _ => between(origin, origin, 0.0),
        }
    };
    (0..mechanism.joints().len()).map(anchorage).collect()
}

/// Computes the position of the symbol of each joint.
fn places(placed: &Placed<'_>, anchorages: &[Anchorage]) -> Vec<Vec3<f64>> {
    let place = |(joint, anchorage): (usize, &Anchorage)| {
        let (p, s) = ends(placed.mechanism, joint);
        let from = placed.pose[p].apply(anchorage.on_predecessor);
        let to = placed.pose[s].apply(anchorage.on_successor);
        from + (to - from) * anchorage.weight
    };
    anchorages.iter().enumerate().map(place).collect()
}

/// Returns true if the origin of a sliding joint lies between its two bodies, with a margin of 20 %
/// of their distance. `from` and `to` are the positions of the bodies along the axis of the joint,
/// m, relative to the origin.
fn is_amid(from: f64, to: f64) -> bool {
    let margin = 0.2 * (to - from).abs();
    from.min(to) + margin < 0.0 && 0.0 < from.max(to) - margin
}

pub(super) fn mean(points: impl Iterator<Item = Vec3<f64>>) -> Option<Vec3<f64>> {
    let (sum, count) = points.fold((Vec3::zero(), 0), |(sum, count), p| (sum + p, count + 1));
    (count > 0).then(|| sum * (1.0 / f64::from(count)))
}
