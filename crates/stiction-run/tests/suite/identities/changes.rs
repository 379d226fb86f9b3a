//! Invariance of forces under changes of the description, and their transformation with the
//! mechanism.

use crate::identities::harness::{Verdict, try_everywhere};
use crate::identities::solve::{
    Numbers, Solved, TOLERANCE, agree, exerts_moment, same, solve, solve_with,
};
use crate::identities::specimen::Specimen;
use crate::mechanisms::random::{Case, Random};
use stiction_core::dynamics::{AppliedLoad, LoadAxes};
use stiction_core::friction::{Curve, JointFriction, Law, Supports, interfaces_of};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{
    Body, BodyId, BodySpec, Joint, JointSpec, Mechanism, MechanismBuilder,
};
use stiction_core::spatial::{Mat3, Pose, Vec3};
use stiction_core::topology::TreeRule;
use stiction_format::{Source, read};

#[test]
fn choice_of_the_spanning_tree() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let case = specimen.case();
        let expected = solve(&case)?.numbers();
        let mut random = specimen.random_changes();
        let other = |random: &mut Random| {
            let found = solve_with(&case, TreeRule::Random(random.bits()))?.numbers();
            Ok(same(&expected, &found.drives, &found.loads))
        };
        for _ in 0..3 {
            let verdict = other(&mut random)?;
            if verdict != Verdict::Holds {
                return Ok(verdict);
            }
        }
        Ok(Verdict::Holds)
    }
    try_everywhere("choice of the spanning tree", 0.5, identity);
}

#[test]
fn order_of_bodies_and_joints() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let case = specimen.case();
        let expected = solve(&case)?;
        let mut random = specimen.random_changes();
        let mut shuffled = |n: usize, first: usize| {
            let mut order: Vec<usize> = (first..first + n).collect();
            order.sort_by_cached_key(|_| random.bits());
            order
        };
        let draft = &specimen.draft;
        let (bodies, joints) = (shuffled(draft.bodies.len(), 1), shuffled(draft.joints.len(), 0));
        let mechanism = draft.build(&bodies, &joints);
        let joint_named_as = |old: usize| {
            mechanism.joint_id(&case.mechanism.joints()[old].name).expect("it has the same joints")
        };
        let coordinates = case.coordinates.iter().map(|coordinate| match *coordinate {
            Coordinate::Joint { joint, dof } => {
                Coordinate::Joint { joint: joint_named_as(joint.0), dof }
            }
            other => other,
        });
        let loads = case.loads.iter().map(|load| {
            let name = &case.mechanism.bodies()[load.body.0].name;
            let body = mechanism.body_id(name).expect("it has the same bodies");
            AppliedLoad { body, ..*load }
        });
        let again = Case {
            coordinates: coordinates.collect(),
            targets: case.targets.clone(),
            loads: loads.collect(),
            class: case.class,
            mechanism: mechanism.clone(),
        };
        let found = solve(&again)?;
        // The forces are compared in the original order of bodies and joints.
        let sorted = |solved: &Solved, mechanism: &Mechanism| {
            let joint = |id: usize| mechanism.joints()[id].name.clone();
            let drives = mechanism.actuators().zip(&solved.forces.efforts);
            let mut drives: Vec<_> =
                drives.map(|((j, f), drive)| ((joint(j.0), f), *drive)).collect();
            let places = mechanism
                .joints()
                .iter()
                .flat_map(|j| j.friction.iter().map(|interface| (j.name.clone(), interface.place)));
            let interfaces = &solved.forces.interfaces;
            let mut loads: Vec<_> = places.zip(interfaces.iter().map(|c| c.load)).collect();
            drives.sort_by(|a, b| a.0.cmp(&b.0));
            loads.sort_by(|a, b| a.0.cmp(&b.0));
            let values =
                |list: Vec<((String, usize), f64)>| list.into_iter().map(|(_, x)| x).collect();
            (values(drives), values(loads))
        };
        let (drives, loads) = sorted(&expected, &case.mechanism);
        let expected = Numbers { drives, loads, largest: expected.numbers().largest };
        let (drives, loads) = sorted(&found, &mechanism);
        Ok(same(&expected, &drives, &loads))
    }
    try_everywhere("order of bodies and joints", 0.5, identity);
}

/// Returns the mechanism with replaced bodies and joints.
fn rebuilt(
    mechanism: &Mechanism,
    builder: MechanismBuilder,
    body: impl Fn(&Body) -> Body,
    joint: impl Fn(&Joint) -> Joint,
) -> Mechanism {
    let bodies = mechanism.bodies().iter().skip(1).map(body);
    let builder = bodies.fold(builder, |builder, body| {
        builder.body(BodySpec::new(body.name).mass(body.mass).com(body.com).inertia(body.inertia))
    });
    let name = |id: BodyId| mechanism.bodies()[id.0].name.clone();
    let joints = mechanism.joints().iter().map(joint);
    let builder = joints.fold(builder, |builder, joint| {
        let (from, to) = (name(joint.predecessor), name(joint.successor));
        let driven: Vec<usize> = joint.actuated_dofs().collect();
        let spec = JointSpec::new(joint.name, joint.joint_type, from, to)
            .frames(joint.frame_j, joint.frame_k)
            .pitch(joint.pitch)
            .actuated_dofs(driven);
        builder.joint(joint.friction.into_iter().fold(spec, JointSpec::friction))
    });
    builder.build().unwrap_or_else(|defects| panic!("{defects:?}"))
}

#[test]
fn a_moved_and_turned_base() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let case = specimen.case();
        let expected = solve(&case)?.numbers();
        let base = specimen.random_changes().pose(3.0);
        let gravity = base.rotation * case.mechanism.gravity();
        let builder = MechanismBuilder::new("moved").gravity(gravity).base(base);
        let mechanism = rebuilt(&case.mechanism, builder, Body::clone, Joint::clone);
        let loads = case.loads.iter().map(|load| match load.axes {
            LoadAxes::Body => *load,
            LoadAxes::World => AppliedLoad {
                force: base.rotation * load.force,
                moment: base.rotation * load.moment,
                ..*load
            },
        });
        let moved = Case { mechanism, loads: loads.collect(), ..case };
        let found = solve(&moved)?.numbers();
        Ok(same(&expected, &found.drives, &found.loads))
    }
    try_everywhere("a moved and turned base", 0.5, identity);
}

/// Tests very small and very large mechanisms. With lengths and masses multiplied by `s` and
/// unchanged time, forces are multiplied by `s^2`, if gravity and loads are scaled accordingly.
#[test]
fn scale() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let case = specimen.case();
        let expected = solve(&case)?.numbers();
        let at = |scale: f64| {
            let scaled = scaled(&case, scale);
            let mut found = solve(&scaled)?.numbers();
            for (actuator, drive) in found.drives.iter_mut().enumerate() {
                *drive /= scale.powi(if exerts_moment(&case, actuator) { 3 } else { 2 });
            }
            found.loads.iter_mut().for_each(|load| *load /= scale.powi(2));
            Ok(same(&expected, &found.drives, &found.loads))
        };
        Ok(at(1e-3)?.and(|| at(1e3).unwrap_or_else(|apart| apart)))
    }
    try_everywhere("scale", 0.5, identity);
}

fn scaled(case: &Case, scale: f64) -> Case {
    let place = |pose: Pose<f64>| Pose { position: pose.position * scale, ..pose };
    let body = |body: &Body| Body {
        mass: body.mass * scale,
        com: body.com * scale,
        inertia: body.inertia * scale.powi(3),
        ..body.clone()
    };
    let joint = |joint: &Joint| Joint {
        frame_j: place(joint.frame_j),
        frame_k: place(joint.frame_k),
        pitch: joint.pitch * scale,
        friction: joint
            .friction
            .iter()
            .map(|interface| scaled_interface(interface, scale))
            .collect(),
        ..joint.clone()
    };
    let builder = MechanismBuilder::new("scaled").gravity(case.mechanism.gravity() * scale);
    let types: Vec<JointType> = case.mechanism.joints().iter().map(|j| j.joint_type).collect();
    let target = |(target, coordinate): (&Target<f64>, &Coordinate)| {
        let factor = if coordinate.is_angle(&types) { 1.0 } else { scale };
        Target {
            value: target.value * factor,
            rate: target.rate * factor,
            acceleration: target.acceleration * factor,
        }
    };
    let load = |load: &AppliedLoad<f64>| AppliedLoad {
        point: load.point * scale,
        force: load.force * scale.powi(2),
        moment: load.moment * scale.powi(3),
        ..*load
    };
    Case {
        mechanism: rebuilt(&case.mechanism, builder, body, joint),
        coordinates: case.coordinates.clone(),
        targets: case.targets.iter().zip(&case.coordinates).map(target).collect(),
        loads: case.loads.iter().map(load).collect(),
        class: case.class,
    }
}

fn scaled_interface(interface: &JointFriction, scale: f64) -> JointFriction {
    let law = |law: &Law| {
        let mut law = law.clone();
        law.viscous *= scale;
        match &mut law.curve {
            Curve::Constant | Curve::Static { .. } => {}
            Curve::Stribeck { velocity, .. } => *velocity *= scale,
            Curve::Table(rows) => rows.iter_mut().for_each(|[speed, _]| *speed *= scale),
        }
        law
    };
    let mut scaled = interface.clone();
    scaled.law = law(&interface.law);
    scaled.backward = interface.backward.as_ref().map(law);
    let lengths = [&mut scaled.radius, &mut scaled.load.bending_span, &mut scaled.load.torsion_arm];
    lengths.into_iter().flatten().for_each(|length| *length *= scale);
    scaled.load.preload *= scale.powi(2);
    scaled
}

/// Exchanges the two sliding directions of the interfaces at DOFs whose sign is -1.
fn turned_laws(joint: &Joint, signs: &[f64]) -> Vec<JointFriction> {
    let turned = |interface: &JointFriction| {
        let (_, shape) = interfaces_of(joint.joint_type)[interface.place];
        let mut turned = interface.clone();
        let slides_back = signs.get(shape.dofs().start).is_some_and(|sign| *sign < 0.0);
        if let (Some(backward), true) = (&mut turned.backward, slides_back) {
            std::mem::swap(&mut turned.law, backward);
        }
        turned
    };
    joint.friction.iter().map(turned).collect()
}

/// Returns the signs of prescribed coordinates and actuators from the signs of the joints' DOFs.
fn signed(case: &Case, signs: &[Vec<f64>]) -> (Vec<Target<f64>>, Vec<f64>) {
    let targets = case.targets.iter().zip(&case.coordinates).map(|(target, coordinate)| {
        let Coordinate::Joint { joint, dof } = *coordinate else { unreachable!("joints only") };
        let sign = signs[joint.0][dof];
        Target {
            value: sign * target.value,
            rate: sign * target.rate,
            acceleration: sign * target.acceleration,
        }
    });
    let drives = case.mechanism.actuators().map(|(joint, dof)| signs[joint.0][dof]);
    (targets.collect(), drives.collect())
}

fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

/// Tests that exchanging the two bodies of a joint changes only the signs of its coordinates.
#[test]
fn joints_the_other_way_round() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let case = specimen.case();
        let expected = solve(&case)?.numbers();
        let mut random = specimen.random_changes();
        // The axes of a universal joint and the sides of a plate are not symmetric in the two
        // bodies.
        let turns: Vec<bool> = case
            .mechanism
            .joints()
            .iter()
            .map(|joint| {
                let is_one_way =
                    matches!(joint.joint_type, JointType::Universal | JointType::Planar);
                !is_one_way && random.below(2) == 0
            })
            .collect();
        let signs: Vec<Vec<f64>> =
            turns.iter().map(|&turn| vec![if turn { -1.0 } else { 1.0 }; 6]).collect();
        let gravity = case.mechanism.gravity();
        let builder = MechanismBuilder::new("reversed").gravity(gravity);
        let joint = |joint: &Joint| {
            let id = case.mechanism.joint_id(&joint.name).expect("it is one of them").0;
            if !turns[id] {
                return joint.clone();
            }
            let mut friction = turned_laws(joint, &signs[id]);
            for interface in &mut friction {
                let load = &mut interface.load;
                let on_one = interfaces_of(joint.joint_type)[interface.place].1.dofs().len() == 1
                    && !matches!(joint.joint_type, JointType::Revolute);
                load.supports = match load.supports {
                    Supports::Predecessor if on_one => Supports::Successor,
                    Supports::Successor => Supports::Predecessor,
                    supports => supports,
                };
            }
            Joint {
                predecessor: joint.successor,
                successor: joint.predecessor,
                frame_j: joint.frame_k,
                frame_k: joint.frame_j,
                friction,
                ..joint.clone()
            }
        };
        let mechanism = rebuilt(&case.mechanism, builder, Body::clone, joint);
        let (targets, drives) = signed(&case, &signs);
        let reversed = Case { mechanism, targets, ..case };
        let found = solve(&reversed)?.numbers();
        Ok(same(&expected, &times(&found.drives, &drives), &found.loads))
    }
    try_everywhere("joints the other way round", 0.5, identity);
}

/// Tests that the mirror image of a mechanism in the plane x = 0 has the mirror image of the
/// forces.
#[test]
fn mirror_images() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let case = specimen.case();
        let expected = solve(&case)?.numbers();
        let mirror = Mat3::from_columns(-Vec3::unit(0), Vec3::unit(1), Vec3::unit(2));
        let pose = |pose: Pose<f64>| Pose {
            rotation: mirror * pose.rotation * mirror,
            position: mirror * pose.position,
        };
        let body = |body: &Body| Body {
            com: mirror * body.com,
            inertia: mirror * body.inertia * mirror,
            ..body.clone()
        };
        // The frames of the mirror image are right-handed: their x axes are the reversed mirror
        // images.
        let signs: Vec<Vec<f64>> = case
            .mechanism
            .joints()
            .iter()
            .map(|joint| match joint.joint_type {
                JointType::Revolute | JointType::Helical => vec![-1.0],
                JointType::Prismatic => vec![1.0],
                JointType::Cylindrical | JointType::Universal => vec![-1.0, 1.0],
                JointType::Planar => vec![-1.0, 1.0, -1.0],
                JointType::Spherical | JointType::Fixed | JointType::Free => vec![1.0; 6],
            })
            .collect();
        let joint = |joint: &Joint| {
            let id = case.mechanism.joint_id(&joint.name).expect("it is one of them").0;
            Joint {
                frame_j: pose(joint.frame_j),
                frame_k: pose(joint.frame_k),
                pitch: -joint.pitch,
                friction: turned_laws(joint, &signs[id]),
                ..joint.clone()
            }
        };
        let builder = MechanismBuilder::new("mirrored").gravity(mirror * case.mechanism.gravity());
        let loads = case.loads.iter().map(|load| AppliedLoad {
            point: mirror * load.point,
            force: mirror * load.force,
            // Moments are axial vectors.
            moment: -(mirror * load.moment),
            ..*load
        });
        let (targets, drives) = signed(&case, &signs);
        let mirrored = Case {
            mechanism: rebuilt(&case.mechanism, builder, body, joint),
            loads: loads.collect(),
            targets,
            ..case
        };
        let found = solve(&mirrored)?.numbers();
        Ok(same(&expected, &times(&found.drives, &drives), &found.loads))
    }
    try_everywhere("mirror images", 0.5, identity);
}

/// Tests that a model file describes the same mechanism as the one from which it was written.
#[test]
fn written_models_are_read_back() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let case = specimen.case();
        let expected = solve(&case)?.numbers();
        let file = specimen.file();
        let model = match read(&Source::new("specimen.toml", file), &|_| Err("no files".into())) {
            Ok(model) => model,
            Err(diagnostics) => return Ok(Verdict::Broken(diagnostics.to_string())),
        };
        let motion = model.motion("here").expect("it is written");
        let loads = model.load("here").map(|load| load.at(0.0).collect::<Vec<_>>());
        let again = Case {
            coordinates: motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect(),
            targets: motion.at(0.0).collect(),
            loads: loads.unwrap_or_default(),
            class: case.class,
            mechanism: model.mechanism.clone(),
        };
        let targets = |case: &Case| -> Vec<f64> {
            case.targets.iter().flat_map(|t| [t.value, t.rate, t.acceleration]).collect()
        };
        // A joint that contains interfaces with friction is written with all its interfaces, so the
        // indices of normal loads change.
        let largest = expected.largest;
        Ok(agree("target", &targets(&case), &targets(&again), 1.0, 1e-15).and(|| {
            match solve(&again) {
                Ok(found) => {
                    agree("drive", &expected.drives, &found.forces.efforts, largest, TOLERANCE)
                }
                Err(verdict) => verdict,
            }
        }))
    }
    try_everywhere("written down and read", 0.5, identity);
}
