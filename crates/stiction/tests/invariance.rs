//! What driving forces must not depend on.

mod common;

use common::random::*;
use stiction::dynamics::{AppliedLoad, InverseDynamics, InverseError, LoadAxes, Settings};
use stiction::kinematics::{AssemblyError, Coordinate};
use stiction::mechanism::{BodySpec, JointSpec, Mechanism, MechanismBuilder};
use stiction::topology::TreeRule;

/// Drives and contact loads, if the mechanism is far enough from singularities for their digits to
/// mean something.
fn outcome(case: &Case, rule: TreeRule) -> Option<(Vec<f64>, Vec<f64>)> {
    let settings = Settings::default();
    let solver = InverseDynamics::with_tree(
        case.mechanism.clone(),
        rule,
        &[],
        &case.coordinates,
        &case.targets,
        settings,
    );
    let mut solver = match solver {
        Err(AssemblyError::Open { .. }) => return None,
        solver => solver.unwrap(),
    };
    let statics = solver.statics();
    let smallest = statics.singular_values()[statics.rank() - 1];
    if smallest < 1e-2 || statics.open_motions() > solver.assembly().prescription().spins().len() {
        return None;
    }
    // Six prescribed coordinates may say badly where a platform is, which magnifies round-off too.
    if solver.bodies().twist.iter().any(|twist| twist.angular.norm() > 100.0) {
        return None;
    }
    match solver.solve(&case.loads) {
        Err(InverseError::Locked { .. }) => None,
        forces => {
            let forces = forces.unwrap();
            // Close to self-locking, friction magnifies round-off as well.
            let length = case.mechanism.characteristic_length();
            let units = case.mechanism.actuators().map(|(joint, freedom)| {
                let freedoms = case.mechanism.joints()[joint.0].joint_type.freedoms();
                if freedoms[freedom].units().1 == "N m" { length } else { 1.0 }
            });
            let units: Vec<f64> = units.collect();
            let largest = |drives: &[f64]| {
                drives.iter().zip(&units).fold(0.0f64, |max, (x, unit)| max.max((x / unit).abs()))
            };
            if largest(&forces.drives) > 20.0 * largest(&forces.drives_frictionless) {
                return None;
            }
            let loads = forces.contacts.iter().map(|c| c.load).collect();
            Some((forces.drives.clone(), loads))
        }
    }
}

fn assert_same(what: &str, a: &(Vec<f64>, Vec<f64>), b: &(Vec<f64>, Vec<f64>)) {
    for (a, b) in [(&a.0, &b.0), (&a.1, &b.1)] {
        let largest = a.iter().fold(1e-9f64, |max, x| max.max(x.abs()));
        for (x, y) in a.iter().zip(b) {
            assert!((x - y).abs() <= 1e-11 * largest, "{what}: {x} {y} of {largest}");
        }
        assert_eq!(a.len(), b.len());
    }
}

/// All cases of all classes whose outcome is worth comparing.
fn for_each_case(seeds: u64, check: impl Fn(&Draft, &Case, &(Vec<f64>, Vec<f64>), &mut Random)) {
    let mut compared = 0;
    for class in CLASSES {
        for seed in 0..seeds {
            let (draft, case) = case(class, seed, 0.15);
            if let Some(expected) = outcome(&case, TreeRule::Structure) {
                check(&draft, &case, &expected, &mut Random(seed + 1000));
                compared += 1;
            }
        }
    }
    assert!(compared > 4 * seeds, "{compared}");
}

#[test]
fn choice_of_tree() {
    for_each_case(12, |_, case, expected, random| {
        for _ in 0..4 {
            let rule = TreeRule::Random(random.bits());
            let found = outcome(case, rule).expect("the same verdict");
            assert_same(&format!("{:?} {rule:?}", case.class), expected, &found);
        }
    });
}

#[test]
fn order_of_bodies_and_joints() {
    for_each_case(12, |draft, case, expected, random| {
        let mut shuffled = |n: usize, first: usize| {
            let mut order: Vec<usize> = (first..first + n).collect();
            order.sort_by_cached_key(|_| random.bits());
            order
        };
        let (bodies, joints) = (shuffled(draft.bodies.len(), 1), shuffled(draft.joints.len(), 0));
        let mechanism = draft.build(&bodies, &joints);
        let rename = |id: usize, names: &Mechanism| names.joints()[id].name.clone();
        let again = Case {
            coordinates: case
                .coordinates
                .iter()
                .map(|c| match *c {
                    Coordinate::Joint { joint, freedom } => Coordinate::Joint {
                        joint: mechanism.joint_id(&rename(joint.0, &case.mechanism)).unwrap(),
                        freedom,
                    },
                    other => other,
                })
                .collect(),
            targets: case.targets.clone(),
            loads: case
                .loads
                .iter()
                .map(|load| {
                    let name = &case.mechanism.bodies()[load.body.0].name;
                    AppliedLoad { body: mechanism.body_id(name).unwrap(), ..*load }
                })
                .collect(),
            class: case.class,
            mechanism,
        };
        let (drives, loads) = outcome(&again, TreeRule::Structure).expect("the same verdict");
        // Back to the first order.
        let place_of_drive = |name: &str, freedom| {
            let actuators = again.mechanism.actuators();
            let joint = again.mechanism.joint_id(name).unwrap();
            actuators.into_iter().position(|a| a == (joint, freedom)).unwrap()
        };
        let drives = case
            .mechanism
            .actuators()
            .map(|(joint, freedom)| {
                drives[place_of_drive(&rename(joint.0, &case.mechanism), freedom)]
            })
            .collect();
        let places: Vec<String> = again
            .mechanism
            .joints()
            .iter()
            .flat_map(|j| j.friction.iter().map(|c| format!("{} {}", j.name, c.place)))
            .collect();
        let loads = case
            .mechanism
            .joints()
            .iter()
            .flat_map(|j| j.friction.iter().map(|c| format!("{} {}", j.name, c.place)))
            .map(|place| loads[places.iter().position(|p| *p == place).unwrap()])
            .collect();
        assert_same(&format!("{:?}", case.class), expected, &(drives, loads));
    });
}

/// The mechanism on a base that is moved and turned, in a world that is turned with it.
fn moved(mechanism: &Mechanism, base: stiction::spatial::Pose<f64>) -> Mechanism {
    let gravity = base.rotation * mechanism.gravity();
    rebuilt(mechanism, 1.0, MechanismBuilder::new("moved").gravity(gravity).base(base))
}

/// The mechanism with all lengths and masses multiplied by `scale` (inertias by its cube).
fn rebuilt(mechanism: &Mechanism, scale: f64, mut builder: MechanismBuilder) -> Mechanism {
    for body in &mechanism.bodies()[1..] {
        builder = builder.body(
            BodySpec::new(&body.name)
                .mass(body.mass * scale)
                .com(body.com * scale)
                .inertia(body.inertia * (scale * scale * scale)),
        );
    }
    let name = |id: stiction::mechanism::BodyId| mechanism.bodies()[id.0].name.clone();
    for joint in mechanism.joints() {
        let scaled = |pose: stiction::spatial::Pose<f64>| stiction::spatial::Pose {
            position: pose.position * scale,
            ..pose
        };
        let mut spec = JointSpec::new(
            &joint.name,
            joint.joint_type,
            name(joint.predecessor),
            name(joint.successor),
        )
        .frames(scaled(joint.frame_j), scaled(joint.frame_k))
        .pitch(joint.pitch * scale)
        .actuated_freedoms(joint.actuated_freedoms().collect::<Vec<_>>());
        for contact in &joint.friction {
            let mut contact = contact.clone();
            contact.radius = contact.radius.map(|r| r * scale);
            contact.law.viscous *= scale;
            contact.load.preload *= scale * scale;
            spec = spec.friction(contact);
        }
        builder = builder.joint(spec);
    }
    builder.build().unwrap()
}

#[test]
fn a_moved_and_turned_base() {
    for_each_case(12, |_, case, expected, random| {
        let base = random.pose(3.0);
        let turned = Case {
            mechanism: moved(&case.mechanism, base),
            coordinates: case.coordinates.clone(),
            targets: case.targets.clone(),
            loads: case
                .loads
                .iter()
                .map(|load| match load.axes {
                    LoadAxes::Body => *load,
                    LoadAxes::World => AppliedLoad {
                        force: base.rotation * load.force,
                        moment: base.rotation * load.moment,
                        ..*load
                    },
                })
                .collect(),
            class: case.class,
        };
        let found = outcome(&turned, TreeRule::Structure).expect("the same verdict");
        assert_same(&format!("{:?}", case.class), expected, &found);
    });
}

/// Micro- and giant mechanisms: with lengths and masses times `s` and time as it is, forces grow as
/// `s^2` under gravity and loads that grow alike.
#[test]
fn scale() {
    for_each_case(6, |_, case, expected, _| {
        for scale in [1e-3, 1e3] {
            let gravity = case.mechanism.gravity() * scale;
            let translates = |c: &Coordinate| !c.is_angle(&types(&case.mechanism));
            let scaled = Case {
                mechanism: rebuilt(
                    &case.mechanism,
                    scale,
                    MechanismBuilder::new("s").gravity(gravity),
                ),
                coordinates: case.coordinates.clone(),
                targets: case
                    .targets
                    .iter()
                    .zip(&case.coordinates)
                    .map(|(target, coordinate)| {
                        let factor = if translates(coordinate) { scale } else { 1.0 };
                        stiction::kinematics::Target {
                            value: target.value * factor,
                            rate: target.rate * factor,
                            acceleration: target.acceleration * factor,
                        }
                    })
                    .collect(),
                loads: case
                    .loads
                    .iter()
                    .map(|load| AppliedLoad {
                        point: load.point * scale,
                        force: load.force * scale.powi(2),
                        moment: load.moment * scale.powi(3),
                        ..*load
                    })
                    .collect(),
                class: case.class,
            };
            let (mut drives, loads) =
                outcome(&scaled, TreeRule::Structure).expect("the same verdict");
            for (drive, (joint, freedom)) in drives.iter_mut().zip(case.mechanism.actuators()) {
                let freedoms = case.mechanism.joints()[joint.0].joint_type.freedoms();
                let turns = freedoms[freedom].units().1 == "N m";
                *drive /= scale.powi(if turns { 3 } else { 2 });
            }
            let loads = loads.into_iter().map(|load| load / scale.powi(2)).collect();
            assert_same(&format!("{:?} {scale}", case.class), expected, &(drives, loads));
        }
    });
}

fn types(mechanism: &Mechanism) -> Vec<stiction::joint::JointType> {
    mechanism.joints().iter().map(|j| j.joint_type).collect()
}

/// Time run backwards turns friction round and nothing else: the kernel at reversed rates gives what
/// it gives at the same rates with all coefficients negative.
#[test]
fn time_reversal_turns_friction_round() {
    let mut compared = 0;
    for class in CLASSES {
        for seed in 0..6 {
            let (_, case) = case(class, seed, 0.05);
            let (mechanism, settings) = (case.mechanism.clone(), Settings::default());
            let (coordinates, targets) = (&case.coordinates, &case.targets);
            let Ok(solver) = InverseDynamics::new(mechanism, &[], coordinates, targets, settings)
            else {
                continue;
            };
            let Some(kernel) = solver.kernel() else { continue };
            let run = |sign: f64, coefficients: f64| {
                let mut parameters = solver.parameters().clone();
                for contact in &mut parameters.contacts {
                    contact.law.coulomb *= coefficients;
                    contact.law.viscous *= coefficients;
                }
                let targets: Vec<_> = targets
                    .iter()
                    .map(|t| stiction::kinematics::Target { rate: sign * t.rate, ..*t })
                    .collect();
                let mut workspace = kernel.workspace(&parameters, solver.assembly().state());
                kernel.run(&parameters, &mut workspace, &targets, &case.loads, &settings);
                let inverse = &workspace.inverse;
                (inverse.drives().to_vec(), inverse.drives_frictionless().to_vec())
            };
            let (forward, backward, negative) = (run(1.0, 1.0), run(-1.0, 1.0), run(1.0, -1.0));
            let largest = forward.0.iter().fold(1e-9f64, |max, x| max.max(x.abs()));
            if largest > 1e4 {
                continue; // Too close to a singular position for digits to mean something.
            }
            let differ = |a: &[f64], b: &[f64]| {
                a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
            };
            assert!(differ(&forward.1, &backward.1) < 1e-11, "{class:?} {seed} without friction");
            assert!(differ(&backward.0, &negative.0) < 1e-9, "{class:?} {seed} with friction");
            assert!(differ(&forward.0, &backward.0) > 1e-6, "{class:?} {seed}: friction acts");
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared}");
}
