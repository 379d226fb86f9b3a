//! Assembly from homes and starts with few digits: the generating assembly mode is found wherever the next
//! one is at least three times as far away, elsewhere a note names both.

use crate::common::{along, v};
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::joint::JointType::{self, *};
use stiction_core::kinematics::{AssemblyError, AssemblyReport, Coordinate, Target};
use stiction_core::mechanism::{BodyId, BodySpec, JointId, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::random::Random;
use stiction_core::spatial::{Mat3, Pose, Vec3};
use stiction_core::topology::TreeRule;

/// A joint between two bodies (0 is the ground), with its frame in the world.
struct Hinge {
    name: String,
    joint_type: JointType,
    ends: (usize, usize),
    frame: Pose<f64>,
    actuated: bool,
}

/// A closed configuration: poses of the bodies, ground first, and the joints between them. Its coordinates are
/// zero where joint frames coincide in a reference position, from which `turned` frames deviate.
struct Posture {
    class: &'static str,
    poses: Vec<Pose<f64>>,
    joints: Vec<Hinge>,
    /// For each joint a rotation of frame J about its own axes, so that coordinates are not zero.
    turned: Vec<Vec<f64>>,
}

fn joint(
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
        // The z axis of `frame` is the first axis, fixed in the predecessor.
        frame.rotation = frame.rotation * Mat3::about_axis(0, second.sin_cos());
    }
    posture.turned.push(turned);
    posture.joints.push(Hinge { name, joint_type, ends, frame, actuated });
}

impl Posture {
    fn new(class: &'static str, poses: Vec<Pose<f64>>) -> Self {
        let mut all = vec![Pose::identity()];
        all.extend(poses);
        Self { class, poses: all, joints: Vec::new(), turned: Vec::new() }
    }

    /// The mechanism, with starts by `start` (of joint, coordinates), and with each joint frame J such that the
    /// posture has the coordinates `turned`.
    fn mechanism(&self, start: impl Fn(usize, &[f64]) -> Option<Vec<f64>>) -> Mechanism {
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

    /// The actuated coordinates with their values in the posture.
    fn prescribed(&self) -> (Vec<Coordinate>, Vec<Target<f64>>) {
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

fn planar(x: f64, y: f64, angle: f64) -> Pose<f64> {
    Pose { position: v(x, y, 0.0), rotation: Mat3::about_axis(2, angle.sin_cos()) }
}

/// A planar chain of bars between two points, elbow on a random side: poses of two bars of random lengths.
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

fn four_bar(random: &mut Random) -> Posture {
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

fn five_bar(random: &mut Random) -> Posture {
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

fn platform_3rrr(random: &mut Random) -> Posture {
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

/// A platform above the ground on three legs R P S, tangential hinges at the feet.
fn platform_3rps(random: &mut Random) -> Posture {
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

/// A general hexapod with legs U P S.
fn gough(random: &mut Random) -> Posture {
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
        // First axis across the leg, in any direction.
        let turn = Mat3::about_axis(1, (1.0, 0.0)) * Mat3::about_axis(2, random.number().sin_cos());
        let across = Pose { rotation: frame.rotation * turn, position: foot };
        joint(&mut posture, Universal, (0, first), across, false, random);
        joint(&mut posture, Prismatic, (first, first + 1), along(tip, axis), true, random);
        joint(&mut posture, Spherical, (first + 1, 1), Pose::at(tip), false, random);
        posture.turned[3 * leg as usize + 1] = vec![(tip - foot).norm()];
    }
    posture
}

/// A delta robot with legs R U U: the rods as single bars.
fn delta(random: &mut Random) -> Posture {
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
        // The first axis of both universal joints is the tangent, the second is at right angles to the rod.
        let second = tangent.cross(rod).direction().unwrap();
        let frame = |at: Vec3<f64>| Pose {
            rotation: Mat3::from_columns(second, tangent.cross(second), tangent),
            position: at,
        };
        let first = posture.poses.len();
        posture.poses.extend([arm, along(elbow, rod)]);
        joint(&mut posture, Revolute, (0, first), along(foot, tangent), true, random);
        joint(&mut posture, Universal, (first, first + 1), frame(elbow), false, random);
        // From the platform, so that its first axis is fixed there.
        joint(&mut posture, Universal, (1, first + 1), frame(tip), false, random);
    }
    posture
}

/// A number with an error of one per cent of `size` at most, and three digits.
fn rough(x: f64, size: f64, random: &mut Random) -> f64 {
    format!("{:.2e}", x + 0.01 * size * random.number()).parse().unwrap()
}

/// Root mean square displacement of bodies, as in [`AssemblyReport::distance`].
fn apart(a: &[Pose<f64>], b: &[Pose<f64>], length: f64) -> f64 {
    let each = a.iter().zip(b).skip(1).map(|(a, b)| {
        let apart = a.inverse() * *b;
        (apart.position.norm() / length).powi(2) + apart.rotation.rotation_vector().norm_squared()
    });
    (each.sum::<f64>() / (a.len() - 1) as f64).sqrt()
}

#[derive(Clone, Copy, Debug)]
enum Hint {
    /// Homes of all bodies.
    Homes,
    /// Starts of all joints with scalar coordinates.
    Starts,
}

/// Assembles a posture from a hint; its distance from the posture, and the report.
fn found(
    posture: &Posture,
    hint: Hint,
    random: &mut Random,
) -> Result<(f64, AssemblyReport), AssemblyError> {
    let mut starts: Vec<Option<Vec<f64>>> = Vec::new();
    for (joint, turned) in posture.joints.iter().zip(&posture.turned) {
        let wants = match hint {
            Hint::Homes => false,
            Hint::Starts => !turned.is_empty(),
        };
        let size = if joint.joint_type == Prismatic { turned[0] } else { 1.0 };
        starts.push(wants.then(|| turned.iter().map(|q| rough(*q, size, random)).collect()));
    }
    let mechanism = posture.mechanism(|joint, _| starts[joint].clone());
    let mut homes = Vec::new();
    for (body, pose) in posture.poses.iter().enumerate().skip(1) {
        if matches!(hint, Hint::Homes) {
            let position = pose.position.to_array().map(|x| rough(x, 1.0, random));
            let turn = v(random.number(), random.number(), random.number()) * 0.01;
            let rotation = Mat3::rotation(turn, turn.norm()) * pose.rotation;
            homes.push((BodyId(body), Pose { position: Vec3::from(position), rotation }));
        }
    }
    let (coordinates, targets) = posture.prescribed();
    // The spanning tree must not matter.
    let seed = (random.number() * 1e9).abs() as u64;
    let rule = if seed.is_multiple_of(2) { TreeRule::Structure } else { TreeRule::Random(seed) };
    let length = mechanism.characteristic_length();
    let settings = Settings::default();
    let solver =
        InverseDynamics::with_tree(mechanism, rule, &homes, &coordinates, &targets, settings)?;
    let ground = solver.bodies().pose[0];
    let poses: Vec<Pose<f64>> =
        solver.bodies().pose.iter().map(|pose| ground.inverse() * *pose).collect();
    let error = apart(&posture.poses, &poses, length);
    Ok((error, solver.assembly_report().clone()))
}

#[test]
fn the_generating_mode_is_found() {
    let classes: [fn(&mut Random) -> Posture; 6] =
        [four_bar, five_bar, platform_3rrr, platform_3rps, gough, delta];
    let (mut all, mut singular, mut near) = (0, 0, 0);
    let mut lost = Vec::new();
    for seed in (0..360_u64).filter(|seed| (seed / 6) % 3 < 2) {
        let mut random = Random::new(seed);
        random.number();
        let posture = classes[seed as usize % 6](&mut random);
        let hint = [Hint::Homes, Hint::Starts][(seed as usize / 6) % 3];
        all += 1;
        let (error, report) = match found(&posture, hint, &mut random) {
            Ok(found) => found,
            Err(AssemblyError::Open { .. } | AssemblyError::Undetermined { .. }) => {
                singular += 1;
                continue;
            }
            Err(error) => {
                println!("{} {seed} {hint:?}: {error}", posture.class);
                lost.push((posture.class, seed));
                continue;
            }
        };
        // Modes that differ by less than the errors of the hints are one.
        if error < 0.01 {
            continue;
        }
        // Another mode: it must be nearer than three times the generating one, and noted.
        let distance = report.distance.unwrap();
        println!("{} {seed} {hint:?}: {error:.3e} from the posture, {report:?}", posture.class);
        let is_near = report.other_modes.iter().any(|other| *other < 3.0 * distance);
        match is_near && !report.notes().is_empty() {
            true => near += 1,
            false => lost.push((posture.class, seed)),
        }
    }
    println!("{all} postures, {singular} singular, {near} with a mode as near, lost {lost:?}");
    assert!(lost.is_empty(), "{lost:?}");
    assert!(near * 20 <= all && singular * 20 <= all, "{near} and {singular} of {all}");
}
