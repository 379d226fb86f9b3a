//! Mechanisms whose joints have small integer coordinates, so that axes are often parallel,
//! concurrent or coplanar. All properties that linear algebra decides are computed exactly.
#![allow(dead_code, unreachable_pub, reason = "each test uses a part")]

pub mod classes;
pub mod modular;
pub mod solver;
pub mod tracer;
pub mod verdicts;

use stiction_core::joint::JointType::{self, *};
use stiction_core::mechanism::{BodySpec, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::spatial::{Mat3, Pose, Vec3};

pub type Ints = [i64; 3];
/// Six components: for a twist, the angular velocity, then the linear velocity at the origin; for a
/// wrench, the force, then the moment about the origin.
pub type Six = [i64; 6];

pub fn cross(a: Ints, b: Ints) -> Ints {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn plus(a: Ints, b: Ints) -> Ints {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn by(a: Ints, factor: i64) -> Ints {
    a.map(|x| x * factor)
}

fn six(a: Ints, b: Ints) -> Six {
    [a[0], a[1], a[2], b[0], b[1], b[2]]
}

/// Returns the six coordinates of the line through a point, which represent a rotation or a force.
fn line(direction: Ints, point: Ints) -> Six {
    six(direction, cross(point, direction))
}

const ZERO: Ints = [0; 3];
pub const UNITS: [Ints; 3] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

/// A joint in the assembled configuration.
#[derive(Clone, Debug)]
pub struct Joint {
    pub joint_type: JointType,
    /// Indices of predecessor and successor; zero is the ground.
    pub ends: (usize, usize),
    pub at: Ints,
    pub axis: Ints,
    /// The joint's x axis, perpendicular to `axis`.
    pub second: Ints,
    pub pitch: i64,
    pub actuated: Vec<usize>,
}

/// A mechanism in the assembled configuration, with integer coordinates.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// Centres of mass of the moving bodies.
    pub coms: Vec<Ints>,
    pub joints: Vec<Joint>,
}

impl Joint {
    /// Returns the twists of all DOFs, which are not of unit length.
    pub fn twists(&self) -> Vec<Six> {
        let (p, a, x) = (self.at, self.axis, self.second);
        let slide = |axis| six(ZERO, axis);
        match self.joint_type {
            Revolute => vec![line(a, p)],
            Prismatic => vec![slide(a)],
            Helical => vec![six(a, plus(cross(p, a), by(a, self.pitch)))],
            Cylindrical => vec![line(a, p), slide(a)],
            Universal => vec![line(a, p), line(x, p)],
            Spherical => UNITS.map(|axis| line(axis, p)).to_vec(),
            Planar => vec![slide(x), slide(cross(a, x)), line(a, p)],
            Fixed => vec![],
            Free => [UNITS.map(slide), UNITS.map(|axis| line(axis, p))].concat(),
        }
    }

    /// Returns a basis of the joint's constraint wrenches.
    pub fn wrenches(&self) -> Vec<Six> {
        let (p, a, x) = (self.at, self.axis, self.second);
        let y = cross(a, x);
        let moment = |axis| six(ZERO, axis);
        let forces = UNITS.map(|axis| line(axis, p)).to_vec();
        let across = vec![line(x, p), line(y, p), moment(x), moment(y)];
        match self.joint_type {
            Revolute => [forces, vec![moment(x), moment(y)]].concat(),
            Prismatic => [vec![line(x, p), line(y, p)], UNITS.map(moment).to_vec()].concat(),
            Helical => [across, vec![six(a, plus(cross(p, a), by(a, -self.pitch)))]].concat(),
            Cylindrical => across,
            Universal => [forces, vec![moment(cross(a, x))]].concat(),
            Spherical => forces,
            Planar => vec![line(a, p), moment(x), moment(y)],
            Fixed => [forces, UNITS.map(moment).to_vec()].concat(),
            Free => vec![],
        }
    }

    /// Returns the wrench of an actuator on a DOF: a couple, or a force through the joint.
    pub fn effort(&self, dof: usize) -> Six {
        let (p, a, x) = (self.at, self.axis, self.second);
        match (self.joint_type, dof) {
            (Revolute | Helical | Cylindrical | Universal, 0) | (Planar, 2) => six(ZERO, a),
            (Universal, 1) => six(ZERO, x),
            (Prismatic, 0) | (Cylindrical, 1) => line(a, p),
            (Planar, 0) => line(x, p),
            (Planar, 1) => line(cross(a, x), p),
            other => panic!("no actuator there: {other:?}"),
        }
    }
}

impl Drawing {
    /// Adds a body.
    pub fn body(&mut self, com: Ints) -> usize {
        self.coms.push(com);
        self.coms.len()
    }

    pub fn constraints(&self) -> usize {
        self.joints.iter().map(|j| j.wrenches().len()).sum()
    }

    pub fn gruebler(&self) -> i64 {
        6 * self.coms.len() as i64 - self.constraints() as i64
    }

    /// Returns the action of a wrench on successor and predecessor, with six coordinates per body.
    pub fn on_bodies(&self, joint: &Joint, wrench: Six) -> Vec<i64> {
        let mut row = vec![0; 6 * self.coms.len()];
        for (body, sign) in [(joint.ends.1, 1), (joint.ends.0, -1)] {
            if body > 0 {
                for k in 0..6 {
                    row[6 * (body - 1) + k] += sign * wrench[k];
                }
            }
        }
        row
    }

    /// Returns the actions of the constraints on the bodies, one row per constraint wrench.
    pub fn constraint_rows(&self) -> Vec<Vec<i64>> {
        self.joints
            .iter()
            .flat_map(|joint| joint.wrenches().into_iter().map(|w| self.on_bodies(joint, w)))
            .collect()
    }

    /// Returns the number of DOFs, and the conditions on the joint rates, six rows per independent
    /// loop.
    pub fn loop_rows(&self) -> (usize, Vec<Vec<i64>>) {
        let first: Vec<usize> = self
            .joints
            .iter()
            .scan(0, |sum, joint| {
                *sum += joint.twists().len();
                Some(*sum - joint.twists().len())
            })
            .collect();
        let dofs = self.joints.iter().map(|j| j.twists().len()).sum();
        // Paths from the ground to each body, as lists of joints with signs.
        let mut ways: Vec<Option<Vec<(usize, i64)>>> = vec![None; self.coms.len() + 1];
        ways[0] = Some(vec![]);
        let mut closing: Vec<usize> = (0..self.joints.len()).collect();
        loop {
            let before = closing.len();
            closing.retain(|&index| {
                let (p, s) = self.joints[index].ends;
                let (from, to, sign) = match (&ways[p], &ways[s]) {
                    (Some(_), None) => (p, s, 1),
                    (None, Some(_)) => (s, p, -1),
                    _ => return true,
                };
                let mut way = ways[from].clone().unwrap();
                way.push((index, sign));
                ways[to] = Some(way);
                false
            });
            if closing.len() == before {
                break;
            }
        }
        let mut rows = Vec::new();
        for index in closing {
            let (p, s) = self.joints[index].ends;
            let mut conditions = vec![vec![0; dofs]; 6];
            let to_successor = ways[p].iter().flatten().copied().chain([(index, 1)]);
            let back = ways[s].iter().flatten().map(|&(joint, sign)| (joint, -sign));
            for (joint, sign) in to_successor.chain(back) {
                for (dof, twist) in self.joints[joint].twists().into_iter().enumerate() {
                    for k in 0..6 {
                        conditions[k][first[joint] + dof] += sign * twist[k];
                    }
                }
            }
            rows.extend(conditions);
        }
        (dofs, rows)
    }

    /// Builds the same mechanism with body frames at the given world poses, and lengths multiplied
    /// by `scale`.
    pub fn build(&self, frames: &[Pose<f64>], scale: f64) -> Mechanism {
        let vector = |x: Ints| Vec3::new(x[0] as f64, x[1] as f64, x[2] as f64);
        let name = |body: usize| match body {
            0 => "ground".to_owned(),
            body => format!("b{body}"),
        };
        let frame = |body: usize| if body == 0 { Pose::identity() } else { frames[body - 1] };
        let mut builder = MechanismBuilder::new("drawing");
        for (index, &com) in self.coms.iter().enumerate() {
            let com = frame(index + 1).inverse().apply(vector(com) * scale);
            let inertia = Mat3::identity() * (scale * scale);
            builder =
                builder.body(BodySpec::new(name(index + 1)).mass(1.0).com(com).inertia(inertia));
        }
        for (index, joint) in self.joints.iter().enumerate() {
            let z = vector(joint.axis).direction().unwrap();
            let x = vector(joint.second).direction().unwrap();
            let rotation = Mat3::from_columns(x, z.cross(x), z);
            let pose = Pose { rotation, position: vector(joint.at) * scale };
            let (p, s) = joint.ends;
            let mut spec = JointSpec::new(format!("j{index}"), joint.joint_type, name(p), name(s))
                .frames(frame(p).inverse() * pose, frame(s).inverse() * pose)
                .actuated_dofs(joint.actuated.clone());
            if joint.joint_type == Helical {
                spec = spec.pitch(joint.pitch as f64 * scale);
            }
            builder = builder.joint(spec);
        }
        builder.build().unwrap_or_else(|defects| panic!("{defects:?} {self:?}"))
    }
}
