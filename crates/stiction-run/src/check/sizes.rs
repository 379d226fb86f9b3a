//! Masses of bodies, and the ranges of joint coordinates, leg lengths and body positions along a
//! motion.

use serde_json::{Value, json};
use std::f64::consts::TAU;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::mechanism::{BodyId, JointId, Mechanism};
use stiction_core::spatial::Vec3;
use stiction_draw::numbers::{fixed, number};

/// Largest difference between two coordinates that counts as a rounding error, mm or deg.
const ROUNDING: f64 = 1e-9;

/// Range of a quantity along a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Name of the quantity.
    pub name: String,
    /// SI unit of the quantity: rad or m.
    pub unit: &'static str,
    /// Least value along the motion, in `unit`.
    pub least: f64,
    /// Greatest value along the motion, in `unit`.
    pub greatest: f64,
}

/// Mass properties of a moving body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMass {
    /// Name of the moving body.
    pub name: String,
    /// Mass of the body, kg.
    pub mass: f64,
    /// Centre of mass of the body at the first pose, in world coordinates, m.
    pub centre: Vec3<f64>,
    /// Principal moments of inertia of the body, kg m^2, smallest first.
    pub moments: [f64; 3],
}

/// Masses of a mechanism, and the ranges of its joints, legs and bodies along a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Sizes {
    /// Mass properties of all moving bodies.
    pub bodies: Vec<BodyMass>,
    /// Total mass of all moving bodies, kg.
    pub mass: f64,
    /// Common centre of mass of all bodies at the first pose, in world coordinates, m.
    pub centre: Vec3<f64>,
    /// Range of each scalar degree of freedom of the joints. Angles are continuous and may exceed a
    /// full turn.
    pub joints: Vec<Range>,
    /// Range of the distance, m, between the origins of the first and the last joint of each leg.
    pub legs: Vec<Range>,
    /// Reach of each body at which legs end, or of all bodies if the mechanism has no legs. An
    /// entry contains the name of the body and two opposite corners, m, of a box parallel to the
    /// world axes. The box is the smallest one that contains the centre of mass of the body along
    /// the whole motion.
    pub reach: Vec<(String, Vec3<f64>, Vec3<f64>)>,
}

/// Collects masses, ranges and reach of a mechanism, sample by sample.
pub(super) struct Measuring {
    sizes: Sizes,
    joints: Vec<(usize, usize, f64)>,
    legs: Vec<(usize, usize)>,
    bodies: Vec<usize>,
}

impl Measuring {
    pub(super) fn new(solver: &InverseDynamics) -> Self {
        let mechanism = solver.mechanism();
        let (mut joints, mut ranges) = (Vec::new(), Vec::new());
        for (joint, content) in mechanism.joints().iter().enumerate() {
            let dofs = content.joint_type.dofs();
            let coordinates = solver.joint_coordinates(JointId(joint));
            for (dof, value) in coordinates.into_iter().enumerate() {
                let name = content.dof_name(dof);
                let unit = dofs[dof].units().0;
                joints.push((joint, dof, value));
                ranges.push(Range { name, unit, least: value, greatest: value });
            }
        }
        let legs = legs(mechanism);
        let empty = |name: String| Range {
            name,
            unit: "m",
            least: f64::INFINITY,
            greatest: f64::NEG_INFINITY,
        };
        let leg_ranges = legs.iter().map(|&(first, last)| {
            let name = |joint: usize| mechanism.joints()[joint].name.as_str();
            empty(leg_name(name(first), name(last)))
        });
        let hubs: Vec<usize> =
            (1..mechanism.bodies().len()).filter(|&body| joints_at(mechanism, body) > 2).collect();
        let bodies = if hubs.is_empty() { (1..mechanism.bodies().len()).collect() } else { hubs };
        let far = f64::INFINITY;
        let reach = bodies.iter().map(|&body: &usize| {
            let name = mechanism.bodies()[body].name.clone();
            (name, Vec3::new(far, far, far), Vec3::new(-far, -far, -far))
        });
        let (bodies_masses, mass, centre) = masses(solver);
        let sizes = Sizes {
            bodies: bodies_masses,
            mass,
            centre,
            joints: ranges,
            legs: leg_ranges.collect(),
            reach: reach.collect(),
        };
        Self { sizes, joints, legs, bodies }
    }

    /// Extends the ranges by the current configuration of `solver`.
    pub(super) fn observe(&mut self, solver: &InverseDynamics) {
        for ((joint, dof, last), range) in self.joints.iter_mut().zip(&mut self.sizes.joints) {
            let value = solver.joint_coordinates(JointId(*joint))[*dof];
            let turns = if range.unit == "rad" { ((*last - value) / TAU).round() } else { 0.0 };
            *last = value + turns * TAU;
            range.add(*last);
        }
        let bodies = solver.bodies();
        for (&(first, last), range) in self.legs.iter().zip(&mut self.sizes.legs) {
            let (foot, tip) = (bodies.frame_j[first].position, bodies.frame_k[last].position);
            range.add((tip - foot).norm());
        }
        for (&body, (_, least, greatest)) in self.bodies.iter().zip(&mut self.sizes.reach) {
            let com = bodies.pose[body].apply(solver.parameters().com[body]);
            let at = (com + solver.parameters().origin).to_array();
            let each = |box_: Vec3<f64>, f: fn(f64, f64) -> f64| {
                let [x, y, z] = box_.to_array();
                Vec3::new(f(x, at[0]), f(y, at[1]), f(z, at[2]))
            };
            (*least, *greatest) = (each(*least, f64::min), each(*greatest, f64::max));
        }
    }

    /// Returns the coordinate of a degree of freedom at the last sample, m or rad. Angles are
    /// continuous and may exceed a full turn. Returns `None` if the joint has no such degree of
    /// freedom.
    pub(super) fn coordinate(&self, joint: JointId, dof: usize) -> Option<f64> {
        let own =
            self.joints.iter().find(|(known, index, _)| (*known, *index) == (joint.0, dof))?;
        Some(own.2)
    }

    pub(super) fn finish(self) -> Sizes {
        self.sizes
    }
}

/// Formats a number with three decimals, or with four significant digits if its magnitude lies
/// between [`ROUNDING`] and 0.1.
fn decimals(x: f64) -> String {
    if x.abs() > ROUNDING && x.abs() < 0.1 { number(x) } else { fixed(x, 3) }
}

impl Range {
    fn add(&mut self, value: f64) {
        (self.least, self.greatest) = (self.least.min(value), self.greatest.max(value));
    }

    /// Returns the least value, the greatest value and their difference as texts, and the unit of
    /// these texts.
    pub(super) fn in_words(&self) -> ([String; 3], &'static str) {
        let (scale, unit) = match self.unit {
            "rad" => (1f64.to_degrees(), "deg"),
            _ => (1e3, "mm"),
        };
        let values = [self.least, self.greatest, self.greatest - self.least];
        (values.map(|x| decimals(x * scale)), unit)
    }

    pub(super) fn json(&self) -> Value {
        json!({
            "name": self.name,
            "unit": self.unit,
            "least": self.least,
            "greatest": self.greatest,
        })
    }
}

impl Sizes {
    pub(super) fn json(&self) -> Value {
        let bodies = self.bodies.iter().map(|body| {
            json!({
                "body": body.name,
                "mass": body.mass,
                "centre": body.centre.to_array(),
                "principal_moments": body.moments,
            })
        });
        json!({
            "total": self.mass,
            "centre": self.centre.to_array(),
            "bodies": bodies.collect::<Vec<_>>(),
        })
    }

    pub(super) fn reach_json(&self) -> Value {
        let each = self.reach.iter().map(|(body, least, greatest)| {
            json!({ "body": body, "least": least.to_array(), "greatest": greatest.to_array() })
        });
        Value::Array(each.collect())
    }
}

/// Returns the mass properties of all moving bodies, their total mass, kg, and their common centre
/// of mass in world coordinates, m.
fn masses(solver: &InverseDynamics) -> (Vec<BodyMass>, f64, Vec3<f64>) {
    let origin = solver.parameters().origin;
    let bodies = solver.mechanism().bodies().iter().zip(&solver.bodies().pose).skip(1);
    let (mut all, mut mass, mut moment) = (Vec::new(), 0.0, Vec3::zero());
    for (body, pose) in bodies {
        let centre = pose.apply(body.com);
        mass += body.mass;
        moment += centre * body.mass;
        let (name, moments) = (body.name.clone(), body.principal_moments());
        all.push(BodyMass { name, mass: body.mass, centre: centre + origin, moments });
    }
    let from_origin = if mass > 0.0 { moment * (1.0 / mass) } else { Vec3::zero() };
    (all, mass, from_origin + origin)
}

fn joints_at(mechanism: &Mechanism, body: usize) -> usize {
    let at = |id: BodyId| id == BodyId(body);
    mechanism.joints().iter().filter(|j| at(j.predecessor) || at(j.successor)).count()
}

/// Finds the legs and returns the first and last joint of each leg. A leg is a chain of bodies with
/// two joints each that connects the ground to a body with three or more joints.
fn legs(mechanism: &Mechanism) -> Vec<(usize, usize)> {
    let joints = mechanism.joints();
    let mut legs = Vec::new();
    for (first, joint) in joints.iter().enumerate() {
        let mut body = match BodyId::GROUND {
            ground if joint.predecessor == ground => joint.successor,
            ground if joint.successor == ground => joint.predecessor,
            _ => continue,
        };
        let mut at = first;
        while body != BodyId::GROUND && joints_at(mechanism, body.0) == 2 {
            let next = joints
                .iter()
                .enumerate()
                .find(|(k, j)| *k != at && (j.predecessor == body || j.successor == body));
            let Some((k, j)) = next else { break };
            body = if j.predecessor == body { j.successor } else { j.predecessor };
            at = k;
        }
        if at != first && body != BodyId::GROUND && joints_at(mechanism, body.0) > 2 {
            legs.push((first, at));
        }
    }
    legs
}

/// Returns the name of a leg: the common part of the names of its first and last joint, such as
/// `leg1` for `leg1.R` and `leg1.S`. If the names have no common part, returns both names.
fn leg_name(first: &str, last: &str) -> String {
    match (first.rsplit_once('.'), last.rsplit_once('.')) {
        (Some((a, _)), Some((b, _))) if a == b => a.to_owned(),
        _ => format!("{first} to {last}"),
    }
}
