//! Random mechanisms of several classes, built in an assembled configuration.

use super::*;
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::friction::{InterfaceShape, interfaces_of};
use stiction_core::kinematics::AssemblyError;

/// A mechanism with its prescribed coordinates, and their motion at one instant.
pub struct Case {
    pub mechanism: Mechanism,
    pub coordinates: Vec<Coordinate>,
    pub targets: Vec<Target<f64>>,
    pub loads: Vec<AppliedLoad<f64>>,
    pub class: Class,
}

impl Case {
    /// Returns the inverse dynamics of the mechanism and its smallest singular value. Returns
    /// `None` near singular configurations, which magnify round-off.
    pub fn regular_solver(&self, friction: FrictionMode) -> Option<(InverseDynamics, f64)> {
        let Self { mechanism, coordinates, targets, class, .. } = self;
        let settings = Settings { friction, ..Settings::default() };
        let solver =
            match InverseDynamics::new(mechanism.clone(), &[], coordinates, targets, settings) {
                Ok(solver) => solver,
                // Two legs with fixed balls permit a rotation of the platform about the line
                // between the balls.
                Err(AssemblyError::Open { .. }) if *class == Class::Constrained => return None,
                Err(error) => panic!("{class:?}: {error}"),
            };
        let statics = solver.statics();
        let smallest = *statics.singular_values()[..statics.rank()].last().unwrap();
        let open = statics.open_motions();
        let is_regular = smallest >= 1e-3 && open <= solver.constraints().spins().len();
        is_regular.then_some((solver, smallest))
    }
}

/// Computes the largest difference between two lists, relative to the largest magnitude.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().chain(b).fold(1e-9f64, |max, x| max.max(x.abs()));
    a.iter().zip(b).fold(0.0f64, |max, (x, y)| max.max((x - y).abs())) / largest
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Open chains with branches.
    Tree,
    /// One loop of random joints.
    Loop,
    /// A platform on legs with six DOFs each.
    Parallel,
    /// A platform on legs that constrain it.
    Constrained,
    /// A planar linkage in space: three redundant constraints per loop.
    Planar,
    /// A platform with more actuators than DOFs.
    RedundantlyActuated,
    /// Loops attached to loops, with open branches.
    Nested,
    /// A platform on legs whose rods have a local DOF between two balls.
    Idle,
}

pub const CLASSES: [Class; 8] = [
    Class::Tree,
    Class::Loop,
    Class::Parallel,
    Class::Constrained,
    Class::Planar,
    Class::RedundantlyActuated,
    Class::Nested,
    Class::Idle,
];

/// Pseudo-random generator SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
    /// Returns a number in (-1, 1).
    pub fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * 0.5 * (self.signed() + 1.0)
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
    pub fn vector(&mut self) -> Vec3<f64> {
        v(self.signed(), self.signed(), self.signed())
    }
    pub fn pose(&mut self, reach: f64) -> Pose<f64> {
        Pose {
            rotation: Mat3::rotation(self.vector(), self.between(-3.0, 3.0)),
            position: self.vector() * reach,
        }
    }
    pub fn pick<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }
}

/// Description of a mechanism before it is built: bodies and joints with world poses in the
/// assembled configuration.
#[derive(Clone)]
pub struct Draft {
    pub bodies: Vec<DraftBody>,
    pub joints: Vec<DraftJoint>,
}

#[derive(Clone)]
pub struct DraftBody {
    pub pose: Pose<f64>,
    pub mass: f64,
    pub com: Vec3<f64>,
    pub inertia: Mat3<f64>,
}

#[derive(Clone)]
pub struct DraftJoint {
    pub joint_type: JointType,
    /// Indices of the two bodies; zero is the ground.
    pub ends: (usize, usize),
    pub frame: Pose<f64>,
    pub actuated: Vec<usize>,
    pub friction: Vec<JointFriction>,
}

impl Draft {
    pub fn new() -> Self {
        Self { bodies: Vec::new(), joints: Vec::new() }
    }

    pub fn body(&mut self, random: &mut Random, pose: Pose<f64>) -> usize {
        // A few point masses, which yield a physically possible inertia.
        let mut inertia = Mat3::zero();
        for _ in 0..4 {
            let (p, m) = (random.vector() * 0.15, random.between(0.1, 0.5));
            let [x, y, z] = p.to_array();
            let tensor = Mat3::from_columns(
                v(y * y + z * z, -x * y, -x * z),
                v(-x * y, x * x + z * z, -y * z),
                v(-x * z, -y * z, x * x + y * y),
            );
            inertia = inertia + tensor * m;
        }
        let (mass, com) = (random.between(0.2, 3.0), random.vector() * 0.1);
        self.bodies.push(DraftBody { pose, mass, com, inertia });
        self.bodies.len()
    }

    pub fn joint(
        &mut self,
        joint_type: JointType,
        ends: (usize, usize),
        frame: Pose<f64>,
    ) -> usize {
        let (actuated, friction) = (Vec::new(), Vec::new());
        self.joints.push(DraftJoint { joint_type, ends, frame, actuated, friction });
        self.joints.len() - 1
    }

    /// Adds random friction to every joint that has friction interfaces.
    pub fn rub(&mut self, random: &mut Random, mu: f64) {
        for joint in &mut self.joints {
            for (place, shape) in surfaces_of(joint.joint_type, false) {
                joint.friction.push(JointFriction {
                    place,
                    radius: shape.turns().then(|| random.between(0.005, 0.03)),
                    law: Law::coulomb_viscous(
                        mu * random.between(0.3, 1.0),
                        random.between(0.0, 5.0),
                    ),
                    backward: None,
                    load: NormalLoadMap {
                        preload: random.between(0.0, 3.0),
                        flank_cosine: (shape == InterfaceShape::Thread).then_some(0.9),
                        ..NormalLoadMap::force_only()
                    },
                });
            }
        }
    }

    pub fn pose(&self, body: usize) -> Pose<f64> {
        if body == 0 { Pose::identity() } else { self.bodies[body - 1].pose }
    }

    pub fn body_name(body: usize) -> String {
        if body == 0 { "ground".to_owned() } else { format!("b{body}") }
    }

    /// Builds the mechanism with bodies and joints in the given order.
    pub fn build(&self, bodies: &[usize], joints: &[usize]) -> Mechanism {
        let mut builder = MechanismBuilder::new("random").gravity(v(0.3, -0.2, -9.81));
        for &body in bodies {
            let DraftBody { mass, com, inertia, .. } = self.bodies[body - 1];
            let spec = BodySpec::new(Self::body_name(body)).mass(mass).com(com).inertia(inertia);
            builder = builder.body(spec);
        }
        for &index in joints {
            let joint = &self.joints[index];
            let (p, s) = joint.ends;
            let mut spec = JointSpec::new(
                format!("j{index}"),
                joint.joint_type,
                Self::body_name(p),
                Self::body_name(s),
            )
            .frames(self.pose(p).inverse() * joint.frame, self.pose(s).inverse() * joint.frame)
            .actuated_dofs(joint.actuated.clone());
            if joint.joint_type == JointType::Helical {
                spec = spec.pitch(0.01);
            }
            for interface in &joint.friction {
                spec = spec.friction(interface.clone());
            }
            builder = builder.joint(spec);
        }
        builder.build().unwrap_or_else(|defects| panic!("{defects:?}"))
    }

    pub fn build_in_order(&self) -> Mechanism {
        let bodies: Vec<_> = (1..=self.bodies.len()).collect();
        let joints: Vec<_> = (0..self.joints.len()).collect();
        self.build(&bodies, &joints)
    }

    /// Adds a chain of joints from one body to another through new bodies at random positions near
    /// the line between them; returns the joints.
    pub fn chain(
        &mut self,
        random: &mut Random,
        types: &[JointType],
        from: usize,
        to: usize,
        ends: (Vec3<f64>, Vec3<f64>),
    ) -> Vec<usize> {
        let mut joints = Vec::new();
        let mut previous = from;
        for (i, &joint_type) in types.iter().enumerate() {
            let part = if types.len() > 1 { i as f64 / (types.len() - 1) as f64 } else { 0.5 };
            let position = ends.0 * (1.0 - part) + ends.1 * part + random.vector() * 0.08;
            let frame = Pose { position, ..random.pose(0.0) };
            let next = if i + 1 == types.len() {
                to
            } else {
                let place = random.vector() * 0.05 + position;
                let pose = Pose { position: place, ..random.pose(0.0) };
                self.body(random, pose)
            };
            joints.push(self.joint(joint_type, (previous, next), frame));
            previous = next;
        }
        joints
    }

    /// Adds a leg of two collinear rods between two balls; the leg can spin about its own line.
    fn spinning_leg(
        &mut self,
        random: &mut Random,
        platform: usize,
        foot: Vec3<f64>,
        tip: Vec3<f64>,
    ) -> Vec<usize> {
        let axis = tip - foot;
        let rods = [0.3, 0.7].map(|part| {
            let pose = Pose { position: foot + axis * part, ..random.pose(0.0) };
            let rod = self.body(random, pose);
            let on_line = foot + axis * (part + 0.1 * random.signed());
            self.bodies[rod - 1].com = pose.inverse().apply(on_line);
            rod
        });
        vec![
            self.joint(Spherical, (0, rods[0]), Pose::at(foot)),
            self.joint(Prismatic, (rods[0], rods[1]), along((foot + tip) * 0.5, axis)),
            self.joint(Spherical, (rods[1], platform), Pose::at(tip)),
        ]
    }

    /// Exchanges predecessor and successor of some joints.
    fn reverse_some(&mut self, random: &mut Random) {
        for joint in &mut self.joints {
            // The axes of a universal joint depend on the order of its bodies; all other joints are
            // symmetric.
            if random.below(3) == 0 {
                joint.ends = (joint.ends.1, joint.ends.0);
            }
        }
    }
}

use JointType::*;

/// Chains with six DOFs.
const SIX: [&[JointType]; 7] = [
    &[Universal, Prismatic, Spherical],
    &[Revolute, Universal, Spherical],
    &[Cylindrical, Revolute, Spherical],
    &[Revolute, Helical, Prismatic, Spherical],
    &[Planar, Universal, Prismatic],
    &[Revolute, Revolute, Revolute, Prismatic, Universal],
    &[Prismatic, Fixed, Universal, Spherical],
];
/// Chains with five DOFs.
const FIVE: [&[JointType]; 4] = [
    &[Revolute, Prismatic, Spherical],
    &[Revolute, Revolute, Spherical],
    &[Prismatic, Universal, Universal],
    &[Cylindrical, Spherical],
];

fn dofs(joint_type: JointType) -> usize {
    joint_type.dofs().len()
}

/// Creates a random draft of a class, with actuators, and the DOFs that must be prescribed in
/// addition to the actuators. There are none of the latter; with redundant actuation, some
/// actuators are not prescribed.
pub fn draft(class: Class, random: &mut Random) -> (Draft, Vec<(usize, usize)>) {
    let mut draft = Draft::new();
    let mut driven: Vec<(usize, usize)> = Vec::new();
    let scalar = |draft: &Draft, joints: &[usize]| -> Vec<(usize, usize)> {
        joints
            .iter()
            .filter(|&&j| draft.joints[j].joint_type.has_scalar_coordinates())
            .flat_map(|&j| (0..dofs(draft.joints[j].joint_type)).map(move |f| (j, f)))
            .collect()
    };
    match class {
        Class::Tree => {
            for _ in 0..3 + random.below(5) {
                let parent = random.below(draft.bodies.len() + 1);
                let joint_type = random.pick(&[
                    Revolute,
                    Prismatic,
                    Helical,
                    Cylindrical,
                    Universal,
                    Planar,
                    Fixed,
                ]);
                let frame = random.pose(0.4);
                let pose = random.pose(0.4);
                let body = draft.body(random, pose);
                let joint = draft.joint(joint_type, (parent, body), frame);
                driven.extend(scalar(&draft, &[joint]));
            }
        }
        Class::Loop => {
            let mut types: Vec<JointType> = vec![Spherical];
            let target = 6 + 1 + random.below(2);
            while types.iter().map(|&t| dofs(t)).sum::<usize>() < target {
                types.push(random.pick(&[
                    Revolute,
                    Prismatic,
                    Universal,
                    Cylindrical,
                    Helical,
                    Revolute,
                ]));
            }
            let mobility = types.iter().map(|&t| dofs(t)).sum::<usize>() - 6;
            let at = random.below(types.len());
            types.swap(0, at);
            let ends = (v(-0.4, 0.0, 0.0), v(0.4, 0.1, 0.0));
            let joints = draft.chain(random, &types, 0, 0, ends);
            let mut candidates = scalar(&draft, &joints);
            for _ in 0..mobility {
                let i = random.below(candidates.len());
                driven.push(candidates.swap_remove(i));
            }
        }
        Class::Parallel | Class::Constrained | Class::RedundantlyActuated | Class::Idle => {
            let pose = Pose { position: v(0.0, 0.0, 0.6), ..random.pose(0.0) };
            let platform = draft.body(random, pose);
            let (legs, chains): (usize, &[&[JointType]]) = match class {
                Class::Parallel | Class::Idle => (6, &SIX),
                Class::RedundantlyActuated => (8, &SIX),
                _ => (2 + random.below(3), &FIVE),
            };
            let mut candidates = Vec::new();
            for leg in 0..legs {
                let angle = leg as f64 * 2.4;
                let foot = v(0.5 * angle.cos(), 0.5 * angle.sin(), 0.0);
                let tip = v(0.3 * (angle + 0.4).cos(), 0.3 * (angle + 0.4).sin(), 0.6);
                let joints = if class == Class::Idle {
                    // Similar polygons would be singular in every pose.
                    let (foot, tip) = (foot + random.vector() * 0.1, tip + random.vector() * 0.1);
                    draft.spinning_leg(random, platform, foot, tip)
                } else {
                    let types = random.pick(chains);
                    draft.chain(random, types, 0, platform, (foot, tip))
                };
                candidates.push(scalar(&draft, &joints));
            }
            // One actuator per leg, at most as many as the platform has DOFs.
            let wanted = if class == Class::Constrained { 6 - legs } else { legs };
            for actuator in 0..wanted {
                let of_leg = &mut candidates[actuator % legs];
                if !of_leg.is_empty() {
                    let i = random.below(of_leg.len());
                    driven.push(of_leg.swap_remove(i));
                }
            }
        }
        Class::Planar => {
            // A platform on three RRR or RPR legs in the xy plane.
            let pose = Pose {
                position: v(0.05, 0.02, 0.0),
                rotation: Mat3::about_axis(2, 0.3f64.sin_cos()),
            };
            let platform = draft.body(random, pose);
            for leg in 0..3 {
                let angle = leg as f64 * 2.1;
                let foot = v(0.6 * angle.cos(), 0.6 * angle.sin(), 0.0);
                let tip = v(0.15 * (angle + 0.2).cos(), 0.15 * (angle + 0.2).sin(), 0.0);
                let middle = (foot + tip) * 0.5
                    + v(0.1 * random.signed(), 0.1 * random.signed(), 0.0)
                    + v(0.1 * angle.sin(), -0.1 * angle.cos(), 0.0);
                let in_plane = |random: &mut Random, p: Vec3<f64>| Pose {
                    position: p,
                    rotation: Mat3::about_axis(2, random.between(-3.0, 3.0).sin_cos()),
                };
                let (a_pose, b_pose) = (in_plane(random, middle * 0.8), in_plane(random, middle));
                let a = draft.body(random, a_pose);
                let b = draft.body(random, b_pose);
                let first = draft.joint(Revolute, (0, a), Pose::at(foot));
                let slides = random.below(3) == 0;
                let elbow = if slides {
                    let axis = tip - foot + v(0.05, 0.02, 0.0) * random.signed();
                    along(middle, axis)
                } else {
                    Pose::at(middle)
                };
                let second = draft.joint(if slides { Prismatic } else { Revolute }, (a, b), elbow);
                draft.joint(Revolute, (b, platform), Pose::at(tip));
                driven.push((if slides { second } else { first }, 0));
            }
            // Only in-plane mass properties matter for the motion, but loads act in any direction.
        }
        Class::Nested => {
            // A loop, a second loop between two of its bodies, an open branch.
            let types = [Revolute, Universal, Spherical, Prismatic, Revolute];
            let first = draft.chain(random, &types, 0, 0, (v(-0.4, 0.0, 0.0), v(0.4, 0.0, 0.2)));
            let types = [Revolute, Spherical, Universal, Revolute];
            let second = draft.chain(random, &types, 1, 3, (v(-0.2, 0.3, 0.0), v(0.2, 0.3, 0.1)));
            let (place, frame) = (random.pose(0.3), random.pose(0.3));
            let tip = draft.body(random, place);
            let branch = draft.joint(Cylindrical, (2, tip), frame);
            driven.push((first[0], 0));
            driven.push((first[3], 0));
            driven.push((second[0], 0));
            driven.extend([(branch, 0), (branch, 1)]);
        }
    }
    for &(joint, dof) in &driven {
        draft.joints[joint].actuated.push(dof);
    }
    draft.reverse_some(random);
    let prescribed = match class {
        // Six of the eight actuators determine the pose of the platform.
        Class::RedundantlyActuated => driven[..6].to_vec(),
        _ => driven,
    };
    (draft, prescribed)
}

/// Creates a random mechanism with its motion.
pub fn case(class: Class, seed: u64, mu: f64) -> (Draft, Case) {
    let mut random = Random(seed);
    let (mut draft, prescribed) = draft(class, &mut random);
    if mu > 0.0 {
        draft.rub(&mut random, mu);
    }
    let mechanism = draft.build_in_order();
    let case = in_motion(&mut random, &draft, mechanism, &prescribed, class);
    (draft, case)
}

fn in_motion(
    random: &mut Random,
    draft: &Draft,
    mechanism: Mechanism,
    prescribed: &[(usize, usize)],
    class: Class,
) -> Case {
    let coordinates = prescribed
        .iter()
        .map(|&(joint, dof)| Coordinate::Joint {
            joint: mechanism.joint_id(&format!("j{joint}")).unwrap(),
            dof,
        })
        .collect::<Vec<_>>();
    let targets = coordinates
        .iter()
        .map(|_| Target {
            value: 0.0,
            rate: random.between(0.2, 1.0) * random.signed().signum(),
            acceleration: random.signed() * 3.0,
        })
        .collect();
    let loads = (1..=draft.bodies.len())
        .filter(|_| random.below(2) == 0)
        .collect::<Vec<_>>()
        .into_iter()
        .map(|body| AppliedLoad {
            body: mechanism.body_id(&Draft::body_name(body)).unwrap(),
            point: random.vector() * 0.1,
            axes: if random.below(2) == 0 { LoadAxes::World } else { LoadAxes::Body },
            force: random.vector() * 20.0,
            moment: random.vector() * 3.0,
        })
        .collect();
    Case { mechanism, coordinates, targets, loads, class }
}

/// Lists the friction interfaces of a joint; a cylindrical joint has either a sleeve or a pin and a
/// guide.
pub fn surfaces_of(joint_type: JointType, sleeve: bool) -> Vec<(usize, InterfaceShape)> {
    let all = interfaces_of(joint_type).iter().enumerate();
    let all = all.map(|(place, (_, shape))| (place, *shape));
    let is_present = |shape: InterfaceShape| {
        joint_type != Cylindrical || (shape == InterfaceShape::Sleeve) == sleeve
    };
    all.filter(|(_, shape)| is_present(*shape)).collect()
}
