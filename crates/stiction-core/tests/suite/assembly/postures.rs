//! Closed configurations of robots, built from their geometry.

use crate::common::{along, v};
use stiction_core::joint::JointType::{self, *};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodySpec, JointId, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::random::Random;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// A joint between two bodies (index 0 is the ground), with its frame in the world.
pub(super) struct Hinge {
    pub(super) name: String,
    pub(super) joint_type: JointType,
    pub(super) ends: (usize, usize),
    pub(super) frame: Pose<f64>,
    pub(super) actuated: bool,
}

/// A closed configuration: poses of the bodies, ground first, and the joints between them. Its
/// coordinates are not zero, because each joint frame J is rotated by `turned`.
pub(super) struct Posture {
    pub(super) class: &'static str,
    pub(super) poses: Vec<Pose<f64>>,
    pub(super) joints: Vec<Hinge>,
    /// For each joint, a rotation of frame J about its own axes, which makes the coordinates
    /// nonzero.
    pub(super) turned: Vec<Vec<f64>>,
}

pub(super) fn joint(
    posture: &mut Posture,
    joint_type: JointType,
    ends: (usize, usize),
    mut frame: Pose<f64>,
    actuated: bool,
    random: &mut Random,
) {
    let name = format!("j{}", posture.joints.len());
    let angle = |random: &mut Random| 3.0 * random.number();
    let turned = match joint_type {
        Prismatic => vec![0.6 + 0.3 * random.number()],
        Revolute => vec![angle(random)],
        Universal => vec![angle(random), 1.2 * random.number()],
        _ => vec![],
    };
    if let (Universal, [_, second]) = (joint_type, turned.as_slice()) {
        // The z axis of `frame` is the first axis, which is fixed in the predecessor.
        frame.rotation = frame.rotation * Mat3::about_axis(0, second.sin_cos());
    }
    posture.turned.push(turned);
    posture.joints.push(Hinge { name, joint_type, ends, frame, actuated });
}

impl Posture {
    pub(super) fn new(class: &'static str, poses: Vec<Pose<f64>>) -> Self {
        let mut all = vec![Pose::identity()];
        all.extend(poses);
        Self { class, poses: all, joints: Vec::new(), turned: Vec::new() }
    }

    /// Builds the mechanism. `start` returns the start coordinates of a joint from its index and
    /// its coordinates in the posture. Each joint frame J is such that the posture has the
    /// coordinates `turned`.
    pub(super) fn mechanism(&self, start: impl Fn(usize, &[f64]) -> Option<Vec<f64>>) -> Mechanism {
        let mut builder = MechanismBuilder::new(self.class);
        for body in 1..self.poses.len() {
            builder = builder.body(BodySpec::new(format!("b{body}")).mass(1.0));
        }
        let name = |body: usize| match body {
            0 => "ground".to_owned(),
            body => format!("b{body}"),
        };
        for (index, joint) in self.joints.iter().enumerate() {
            let (a, b) = joint.ends;
            let across = match self.turned[index].as_slice() {
                [] => Pose::identity(),
                q => joint.joint_type.pose(q, 0.0),
            };
            let world_j = joint.frame * across.inverse();
            let mut spec = JointSpec::new(&joint.name, joint.joint_type, name(a), name(b))
                .frames(self.poses[a].inverse() * world_j, self.poses[b].inverse() * joint.frame);
            if joint.actuated {
                spec = spec.actuated();
            }
            if let Some(start) = start(index, &self.turned[index]) {
                spec = spec.start(start);
            }
            builder = builder.joint(spec);
        }
        builder.build().unwrap()
    }

    /// Index of the body that hints with the home pose of a platform refer to.
    pub(super) fn platform(&self) -> usize {
        match self.class {
            "four-bar" | "five-bar" => 2,
            _ => 1,
        }
    }

    /// Returns the actuated coordinates with their values in the posture.
    pub(super) fn prescribed(&self) -> (Vec<Coordinate>, Vec<Target<f64>>) {
        let actuated = self.joints.iter().enumerate().filter(|(_, joint)| joint.actuated);
        actuated
            .map(|(index, _)| {
                let value = self.turned[index][0];
                let joint = Coordinate::Joint { joint: JointId(index), dof: 0 };
                (joint, Target { value, rate: 0.0, acceleration: 0.0 })
            })
            .unzip()
    }
}

pub(super) fn planar(x: f64, y: f64, angle: f64) -> Pose<f64> {
    Pose { position: v(x, y, 0.0), rotation: Mat3::about_axis(2, angle.sin_cos()) }
}

/// Creates a planar chain of two bars with random lengths between two points, with the elbow on a
/// random side. Returns the poses of the bars.
fn elbow(from: Vec3<f64>, to: Vec3<f64>, random: &mut Random) -> [Pose<f64>; 2] {
    let apart = to - from;
    let half = 0.5 * apart.norm();
    let height = (0.3 + 0.5 * (1.0 + random.number())) * half.max(0.2);
    let side = if random.number() > 0.0 { 1.0 } else { -1.0 };
    let along = apart * (1.0 / apart.norm());
    let across = v(-along.y, along.x, 0.0) * (side * height);
    let corner = from + along * (half * (1.0 + 0.4 * random.number())) + across;
    let bar = |from: Vec3<f64>, to: Vec3<f64>| {
        let d = to - from;
        planar(from.x, from.y, d.y.atan2(d.x))
    };
    [bar(from, corner), bar(corner, to)]
}

fn pin(at: Vec3<f64>) -> Pose<f64> {
    Pose::at(at)
}

pub(super) fn four_bar(random: &mut Random) -> Posture {
    let crank = planar(0.0, 0.0, 3.0 * random.number());
    let tip = crank.apply(v(0.3 + 0.1 * random.number(), 0.0, 0.0));
    let base = v(1.0 + 0.2 * random.number(), 0.1 * random.number(), 0.0);
    let [coupler, rocker] = elbow(tip, base, random);
    let corner = rocker.position;
    let mut posture = Posture::new("four-bar", vec![crank, coupler, rocker]);
    joint(&mut posture, Revolute, (0, 1), pin(v(0.0, 0.0, 0.0)), true, random);
    joint(&mut posture, Revolute, (1, 2), pin(tip), false, random);
    joint(&mut posture, Revolute, (2, 3), pin(corner), false, random);
    joint(&mut posture, Revolute, (0, 3), pin(base), false, random);
    posture
}

pub(super) fn five_bar(random: &mut Random) -> Posture {
    let crank = |x: f64, random: &mut Random| planar(x, 0.0, 3.0 * random.number());
    let (left, right) = (crank(0.0, random), crank(0.6, random));
    let tips = [left, right].map(|crank| crank.apply(v(0.4, 0.0, 0.0)));
    let [near, far] = elbow(tips[0], tips[1], random);
    let corner = far.position;
    let mut posture = Posture::new("five-bar", vec![left, near, far, right]);
    joint(&mut posture, Revolute, (0, 1), pin(v(0.0, 0.0, 0.0)), true, random);
    joint(&mut posture, Revolute, (1, 2), pin(tips[0]), false, random);
    joint(&mut posture, Revolute, (2, 3), pin(corner), false, random);
    joint(&mut posture, Revolute, (3, 4), pin(tips[1]), false, random);
    joint(&mut posture, Revolute, (0, 4), pin(v(0.6, 0.0, 0.0)), true, random);
    posture
}

pub(super) fn platform_3rrr(random: &mut Random) -> Posture {
    let platform = planar(0.15 * random.number(), 0.15 * random.number(), 0.8 * random.number());
    let mut posture = Posture::new("3-RRR", vec![platform]);
    for leg in 0..3 {
        let turn = planar(0.0, 0.0, 2.1 * f64::from(leg) + 0.2 * random.number());
        let foot = turn.apply(v(0.7, 0.0, 0.0));
        let tip = (platform * turn).apply(v(0.2, 0.0, 0.0));
        let [crank, coupler] = elbow(foot, tip, random);
        let first = posture.poses.len();
        posture.poses.extend([crank, coupler]);
        joint(&mut posture, Revolute, (0, first), pin(foot), true, random);
        joint(&mut posture, Revolute, (first, first + 1), pin(coupler.position), false, random);
        joint(&mut posture, Revolute, (first + 1, 1), pin(tip), false, random);
    }
    posture
}

/// Creates a platform above the ground on three RPS legs with tangential hinges at the feet.
pub(super) fn platform_3rps(random: &mut Random) -> Posture {
    let ball = |leg: i32, platform: &Pose<f64>| {
        let turn = planar(0.0, 0.0, 2.0 * core::f64::consts::FRAC_PI_3 * f64::from(leg));
        (turn, platform.apply(turn.apply(v(0.2, 0.0, 0.0))))
    };
    // The legs keep the balls in their planes: three equations for x, y and the yaw.
    let tilt = Mat3::rotation(v(random.number(), random.number(), 0.0), 0.5 * random.number());
    let mut platform = Pose { position: v(0.0, 0.0, 0.6 + 0.15 * random.number()), rotation: tilt };
    for _ in 0..200 {
        for leg in 0..3 {
            let (turn, at) = ball(leg, &platform);
            let normal = turn.rotation.columns[1];
            let off = normal.dot(at);
            let arm = at - platform.position;
            platform.position -= normal * (0.7 * off);
            let spin = v(0.0, 0.0, 1.0).cross(arm).dot(normal);
            let angle = -0.3 * off * spin / (spin * spin + 0.01);
            platform.rotation = Mat3::about_axis(2, angle.sin_cos()) * platform.rotation;
        }
    }
    let mut posture = Posture::new("3-RPS", vec![platform]);
    for leg in 0..3 {
        let (turn, tip) = ball(leg, &platform);
        let foot = turn.apply(v(0.5, 0.0, 0.0));
        let axis = (tip - foot).direction().unwrap();
        let leg_frame = along(foot, axis);
        let first = posture.poses.len();
        posture.poses.extend([leg_frame, along(tip, axis)]);
        let hinge = along(foot, turn.rotation.columns[1]);
        joint(&mut posture, Revolute, (0, first), hinge, false, random);
        joint(&mut posture, Prismatic, (first, first + 1), along(tip, axis), true, random);
        joint(&mut posture, Spherical, (first + 1, 1), Pose::at(tip), false, random);
        posture.turned[3 * leg as usize + 1] = vec![(tip - foot).norm()];
    }
    posture
}

/// Creates a general hexapod with UPS legs.
pub(super) fn gough(random: &mut Random) -> Posture {
    let axis = v(random.number(), random.number(), random.number());
    let platform = Pose {
        position: v(0.3 * random.number(), 0.3 * random.number(), 0.8 + 0.2 * random.number()),
        rotation: Mat3::rotation(axis, random.number()),
    };
    let mut posture = Posture::new("hexapod", vec![platform]);
    for leg in 0..6 {
        let angle = 1.05 * f64::from(leg) + 0.3 * random.number();
        let height = 0.1 * random.number();
        let foot = planar(0.0, 0.0, angle).apply(v(0.7, 0.0, height));
        let tip = planar(0.0, 0.0, angle + 0.5).apply(v(0.4, 0.0, 0.1 * random.number()));
        let tip = platform.apply(tip);
        let axis = (tip - foot).direction().unwrap();
        let frame = along(foot, axis);
        let first = posture.poses.len();
        posture.poses.extend([frame, along(tip, axis)]);
        // The first axis is perpendicular to the leg, in any direction.
        let turn = Mat3::about_axis(1, (1.0, 0.0)) * Mat3::about_axis(2, random.number().sin_cos());
        let across = Pose { rotation: frame.rotation * turn, position: foot };
        joint(&mut posture, Universal, (0, first), across, false, random);
        joint(&mut posture, Prismatic, (first, first + 1), along(tip, axis), true, random);
        joint(&mut posture, Spherical, (first + 1, 1), Pose::at(tip), false, random);
        posture.turned[3 * leg as usize + 1] = vec![(tip - foot).norm()];
    }
    posture
}

/// Creates a delta robot with RUU legs, whose rods are single bars.
pub(super) fn delta(random: &mut Random) -> Posture {
    let position = v(0.2 * random.number(), 0.2 * random.number(), -0.9 + 0.1 * random.number());
    let platform = Pose::at(position);
    let mut posture = Posture::new("delta", vec![platform]);
    for leg in 0..3 {
        let turn = planar(0.0, 0.0, 2.0 * core::f64::consts::FRAC_PI_3 * f64::from(leg));
        let foot = turn.apply(v(0.3, 0.0, 0.0));
        let angle = 0.6 + 0.8 * random.number();
        let (s, c) = angle.sin_cos();
        let arm = Pose { position: foot, rotation: turn.rotation * Mat3::about_axis(1, (s, c)) };
        let elbow = arm.apply(v(0.4, 0.0, 0.0));
        let tip = platform.apply(turn.apply(v(0.1, 0.0, 0.0)));
        let tangent = turn.rotation.columns[1];
        let rod = (tip - elbow).direction().unwrap();
        // The first axis of both universal joints is the tangent; the second is perpendicular to
        // the rod.
        let second = tangent.cross(rod).direction().unwrap();
        let frame = |at: Vec3<f64>| Pose {
            rotation: Mat3::from_columns(second, tangent.cross(second), tangent),
            position: at,
        };
        let first = posture.poses.len();
        posture.poses.extend([arm, along(elbow, rod)]);
        joint(&mut posture, Revolute, (0, first), along(foot, tangent), true, random);
        joint(&mut posture, Universal, (first, first + 1), frame(elbow), false, random);
        // The platform is the predecessor, so that the first axis is fixed in it.
        joint(&mut posture, Universal, (1, first + 1), frame(tip), false, random);
    }
    posture
}
