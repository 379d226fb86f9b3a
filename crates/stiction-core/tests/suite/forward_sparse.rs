//! The sparse solution of the balance compared with the dense one: for chains, rows of loops with
//! redundant constraints, and random mechanisms of all classes.

use crate::common::random::*;
use crate::common::{along, diagonal, friction, v};
use stiction_core::dynamics::InverseDynamics;
use stiction_core::forward::{ConstantEfforts, Forward, Instant, Settings, Simulation};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, State, Target};
use stiction_core::mechanism::{BodyId, BodySpec, JointId, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::spatial::{Mat3, Pose};
use stiction_core::topology::TreeRule;

/// Computes the largest difference of all results at two instants, relative to the largest value of
/// each kind.
fn difference(a: &Instant, b: &Instant) -> f64 {
    let wrenches = |instant: &Instant| -> Vec<f64> {
        let each = instant.reactions();
        each.iter().flat_map(|(f, m)| [f.x, f.y, f.z, m.x, m.y, m.z]).collect()
    };
    let loads = |instant: &Instant| -> Vec<f64> {
        instant.interfaces.iter().map(|interface| interface.load).collect()
    };
    let pairs = [
        (a.state.accelerations.clone(), b.state.accelerations.clone()),
        (wrenches(a), wrenches(b)),
        (loads(a), loads(b)),
        (a.drives.clone(), b.drives.clone()),
    ];
    let each = pairs.iter().map(|(a, b)| {
        let size = a.iter().chain(b).fold(1e-9_f64, |m, x| m.max(x.abs()));
        a.iter().zip(b).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / size
    });
    each.fold(0.0, f64::max)
}

/// Starts one simulation with the sparse and one with the dense solution, and calls `check` with
/// both. Returns `None` if neither starts.
fn both(
    mechanism: &Mechanism,
    prescribed: &[usize],
    start: impl Fn(&Forward) -> Option<State<f64>>,
    check: impl FnMut(&Simulation<'_>, &Simulation<'_>),
) -> Option<()> {
    compare(Forward::new(mechanism.clone(), prescribed), start, check)
}

/// Compares like [`both`], with the spanning tree of a given model.
fn compare(
    mut dense: Forward,
    start: impl Fn(&Forward) -> Option<State<f64>>,
    mut check: impl FnMut(&Simulation<'_>, &Simulation<'_>),
) -> Option<()> {
    dense.solve_densely();
    let mut sparse = dense.clone();
    sparse.solve_sparsely();
    let mut inputs = ConstantEfforts(vec![0.3; dense.mechanism().actuators().count()]);
    let at = start(&dense)?;
    let a = dense.start(0.0, at.clone(), Settings::default(), &mut inputs);
    let b = sparse.start(0.0, at, Settings::default(), &mut inputs);
    match (a, b) {
        (Ok(mut a), Ok(mut b)) => {
            // A short interval, so that errors of the integrator do not matter.
            a.advance(1e-6, &mut inputs).ok()?;
            b.advance(1e-6, &mut inputs).ok()?;
            check(&a, &b);
            Some(())
        }
        (Err(_), Err(_)) => None,
        (a, b) => panic!("only one starts: {:?} {:?}", a.err(), b.err()),
    }
}

#[test]
fn random_mechanisms_agree_with_the_dense_solution() {
    for rule in [TreeRule::Structure, TreeRule::Held] {
        compare_random_mechanisms(rule);
    }
}

fn compare_random_mechanisms(rule: TreeRule) {
    let (mut compared, mut sparse, mut worst) = (0, 0, 0.0_f64);
    for class in CLASSES {
        for seed in 300..312 {
            let (_, case) = case(class, seed, 0.2);
            let start =
                |model: &Forward| model.assemble(&[], &case.coordinates, &case.targets).ok();
            let model = Forward::with_tree(case.mechanism.clone(), rule, &[]);
            let _ = compare(model, start, |a, b| {
                if !a.events().is_empty() {
                    // After impacts, the instants of events, and with them all results, contain the
                    // error of the integrator.
                    return;
                }
                let apart = difference(a.instant(), b.instant());
                println!("{class:?} {seed} sparse {} {apart:.1e}", b.is_sparse());
                assert_eq!(a.instant().mobility, b.instant().mobility, "{class:?} {seed}");
                assert_eq!(a.instant().redundant, b.instant().redundant, "{class:?} {seed}");
                compared += 1;
                sparse += usize::from(b.is_sparse());
                worst = worst.max(apart);
                // Both contain the round-off of their systems, whose condition numbers are at most
                // 1e5 here.
                assert!(apart < 1e-9, "{class:?} {seed}: {apart:e}");
            });
        }
    }
    println!("{compared} compared, {sparse} sparse, {worst:.1e}");
    assert!(compared >= 40 && 2 * sparse >= compared, "{compared} {sparse}");
}

fn body(name: String, com: f64) -> BodySpec {
    let inertia = diagonal(1e-3, 2e-3, 1.5e-3);
    BodySpec::new(name).mass(1.0).com(v(com, 0.0, 0.0)).inertia(inertia)
}

/// Creates a chain of pendulums with motors and load-dependent friction.
fn chain(count: usize) -> Mechanism {
    let mut builder = MechanismBuilder::new("chain").gravity(v(0.0, 0.0, -9.81));
    for k in 0..count {
        let before = if k == 0 { "ground".into() } else { format!("b{}", k - 1) };
        let at = v(if k == 0 { 0.0 } else { 0.1 }, 0.0, 0.0);
        let axis = if k % 3 == 2 { v(0.0, 0.6, 0.8) } else { v(0.0, 1.0, 0.0) };
        builder = builder.body(body(format!("b{k}"), 0.05)).joint(
            JointSpec::new(format!("j{k}"), JointType::Revolute, before, format!("b{k}"))
                .frames(along(at, axis), along(v(0.0, 0.0, 0.0), axis))
                .actuated()
                .friction(friction(0.1, 0.0, Some(0.01))),
        );
    }
    builder.build().unwrap()
}

/// Creates a row of planar four-bar linkages in which each rocker is the crank of the next linkage.
/// In space, two of three closure equations of each loop are redundant.
fn row(count: usize) -> Mechanism {
    let mut builder = MechanismBuilder::new("row").gravity(v(0.0, 0.0, -9.81));
    let y = v(0.0, 1.0, 0.0);
    let origin = v(0.0, 0.0, 0.0);
    let joint = |name: String, from: String, to: String, at, to_at| {
        JointSpec::new(name, JointType::Revolute, from, to)
            .frames(along(at, y), along(to_at, y))
            .friction(friction(0.05, 0.0, Some(0.005)))
    };
    for k in 0..=count {
        let at = v(k as f64, 0.0, 0.0);
        builder = builder.body(body(format!("c{k}"), 0.0)).joint(joint(
            format!("g{k}"),
            "ground".into(),
            format!("c{k}"),
            at,
            origin,
        ));
        if k > 0 {
            let (before, coupler) = (format!("c{}", k - 1), format!("k{k}"));
            builder = builder
                .body(body(coupler.clone(), 0.5))
                .joint(joint(format!("p{k}"), before, coupler.clone(), v(0.0, 0.0, 0.2), origin))
                .joint(joint(
                    format!("q{k}"),
                    coupler,
                    format!("c{k}"),
                    v(1.0, 0.0, 0.0),
                    v(0.0, 0.0, 0.2),
                ));
        }
    }
    builder.build().unwrap()
}

fn target(value: f64, rate: f64) -> Target<f64> {
    Target { value, rate, acceleration: 0.0 }
}

#[test]
fn chains_agree_with_the_dense_solution() {
    for (count, prescribed) in [(1, 0), (7, 0), (40, 0), (40, 3)] {
        let mechanism = chain(count);
        let coordinates: Vec<_> =
            (0..count).map(|k| Coordinate::Joint { joint: JointId(k), dof: 0 }).collect();
        let targets: Vec<_> =
            (0..count).map(|k| target(0.1 + 0.01 * k as f64, 0.2 - 0.03 * k as f64)).collect();
        let prescribed: Vec<usize> = (0..prescribed).map(|k| 11 * k).collect();
        let start = |model: &Forward| model.assemble(&[], &coordinates, &targets).ok();
        let done = both(&mechanism, &prescribed, start, |a, b| {
            assert!(b.is_sparse() && !a.is_sparse());
            let apart = difference(a.instant(), b.instant());
            // Round-off of the dense mass matrix, whose condition number grows with the square of
            // the length.
            assert!(apart < 1e-11, "{count}: {apart:e}");
        });
        assert!(done.is_some());
    }
}

/// Poses of the couplers of [`row`] if all cranks are vertical.
fn poses_of_row(mechanism: &Mechanism, count: usize) -> Vec<(BodyId, Pose<f64>)> {
    (1..=count)
        .map(|k| {
            let body = mechanism.bodies().iter().position(|b| b.name == format!("k{k}"));
            let pose = Pose::at(v(k as f64 - 1.0, 0.0, 0.2));
            (BodyId(body.unwrap()), pose)
        })
        .collect()
}

/// The distances between far joints on the ground do not count: the length of a long row is that
/// of its loops, and its smallest singular values are above the limits of zero.
#[test]
fn long_rows_have_the_length_of_their_loops() {
    let [short, long] = [100, 400].map(|count| row(count).characteristic_length());
    // The six nearest points are farther away at both ends of the row.
    assert!((0.5..2.0).contains(&short) && (long / short - 1.0).abs() < 0.05, "{short} {long}");
}

/// States of inverse dynamics fit the model of forward dynamics also where the bodies of large
/// mechanisms do not float.
#[test]
fn states_of_inverse_dynamics_fit_long_rows() {
    for count in [2, 20] {
        let mechanism = row(count);
        let poses = poses_of_row(&mechanism, count);
        let crank = [Coordinate::Joint { joint: JointId(0), dof: 0 }];
        let settings = stiction_core::dynamics::Settings::default();
        let targets = [target(0.3, 1.7)];
        let solver =
            InverseDynamics::new(mechanism.clone(), &poses, &crank, &targets, settings).unwrap();
        let model = Forward::new(mechanism, &[]);
        let (state, bodies) = (solver.state(), solver.bodies());
        let motion = model.joint_motion(state, bodies, JointId(3 * count - 2), 0);
        assert!((motion.value - 0.3).abs() < 1e-12 && (motion.rate - 1.7).abs() < 1e-12, "{count}");
        assert!(model.closure_error(bodies, state) < 1e-12, "{count}");
    }
}

#[test]
fn rows_of_loops_agree_with_the_dense_solution() {
    for count in [1, 2, 6] {
        let mechanism = row(count);
        let poses = poses_of_row(&mechanism, count);
        let crank = [Coordinate::Joint { joint: JointId(0), dof: 0 }];
        let start = |model: &Forward| model.assemble(&poses, &crank, &[target(0.3, 1.7)]).ok();
        let done = both(&mechanism, &[], start, |a, b| assert_rows_agree(a, b, count, 0.3));
        assert!(done.is_some());
    }
}

/// Checks that the dense simulation `a` and the sparse simulation `b` of a row of `count`
/// parallelograms agree at the crank angle `angle`, rad.
fn assert_rows_agree(a: &Simulation<'_>, b: &Simulation<'_>, count: usize, angle: f64) {
    assert!(b.is_sparse() && !a.is_sparse());
    let (a, b) = (a.instant(), b.instant());
    assert_eq!((a.redundant, a.mobility), (3 * count, 1));
    assert_eq!((b.redundant, b.mobility), (3 * count, 1));
    let apart = difference(a, b);
    // Self-stresses are computed from a nearly singular system in few corrections.
    assert!(apart < 1e-10, "{count} {angle}: {apart:e}");
}

/// Creates a row of parallelograms of thin rods without inertia about their axes and without
/// friction. In a tree in which the vertical rods float, a motion of the tree has no inertia.
fn thin_row(count: usize) -> Mechanism {
    let z = v(0.0, 0.0, 1.0);
    let (origin, tip) = (v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0));
    let mut builder = MechanismBuilder::new("thin").gravity(v(0.0, -9.81, 0.0));
    let rod = |name: String| {
        let inertia = diagonal(0.0, 1.0 / 12.0, 1.0 / 12.0);
        BodySpec::new(name).mass(1.0).com(v(0.5, 0.0, 0.0)).inertia(inertia)
    };
    let joint = |name: String, from: String, to: String, at, to_at| {
        JointSpec::new(name, JointType::Revolute, from, to).frames(along(at, z), along(to_at, z))
    };
    for k in 0..=count {
        let (at, upright) = (v(k as f64, 0.0, 0.0), format!("v{k}"));
        let ground = joint(format!("g{k}"), "ground".into(), upright.clone(), at, origin);
        builder = builder.body(rod(upright.clone())).joint(ground);
        if k > 0 {
            let (before, level) = (format!("v{}", k - 1), format!("h{k}"));
            builder = builder
                .body(rod(level.clone()))
                .joint(joint(format!("a{k}"), before, level.clone(), tip, origin))
                .joint(joint(format!("b{k}"), level, upright, tip, tip));
        }
    }
    builder.build().unwrap()
}

#[test]
fn rows_of_thin_rods_are_solved_sparsely() {
    for count in [10, 25] {
        let mechanism = thin_row(count);
        for angle in [1.6_f64, 0.9, 0.05] {
            let (c, s) = (angle.cos(), angle.sin());
            let poses: Vec<_> = (0..=count)
                .map(|k| (format!("v{k}"), k as f64, 0.0, true))
                .chain((1..=count).map(|k| (format!("h{k}"), k as f64 - 1.0 + c, s, false)))
                .map(|(name, x, y, turned)| {
                    let body = mechanism.bodies().iter().position(|b| b.name == name).unwrap();
                    let turn = if turned { angle } else { 0.0 };
                    let rotation = Mat3::rotation(v(0.0, 0.0, 1.0), turn);
                    (BodyId(body), Pose { rotation, position: v(x, y, 0.0) })
                })
                .collect();
            let crank = [Coordinate::Joint { joint: JointId(0), dof: 0 }];
            let start =
                |model: &Forward| model.assemble(&poses, &crank, &[target(angle, -1.0)]).ok();
            let done = both(&mechanism, &[], start, |a, b| assert_rows_agree(a, b, count, angle));
            assert!(done.is_some());
        }
    }
}

/// Creates a platform on legs of universal, prismatic and spherical joints; all prismatic joints
/// are actuated, and their coordinates are zero at home.
fn platform(legs: usize) -> Mechanism {
    let mut builder = MechanismBuilder::new("platform")
        .gravity(v(0.0, 0.0, -9.81))
        .body(BodySpec::new("platform").mass(10.0).inertia(diagonal(0.2, 0.2, 0.4)));
    let origin = Pose::identity();
    for k in 0..legs {
        // Regular places would be singular for the first six legs.
        let angle = |part: f64| {
            let off = 0.4 * (1.7 * k as f64 + 9.0 * part).sin();
            core::f64::consts::TAU * (k as f64 + part + off) / legs as f64
        };
        let side = if k % 2 == 0 { 0.35 } else { -0.35 };
        let (foot, tip) = (angle(side), angle(-side));
        let foot = v(0.45 * foot.cos(), 0.45 * foot.sin(), 0.0);
        let tip = v(0.2 * tip.cos(), 0.2 * tip.sin(), 0.05 * (k % 3) as f64);
        let leg = tip + v(0.0, 0.0, 0.55) - foot;
        // The axes of the universal joint, z and x, are perpendicular to the leg.
        let (along_leg, z) = (v(0.0, 1.0, 0.0), v(0.0, 0.0, 1.0));
        let rotation = Mat3::between(along_leg, leg * (1.0 / leg.norm()));
        let slide =
            Pose { rotation: Mat3::between(z, along_leg), position: along_leg * leg.norm() };
        let rod = |name: &str, mass, com| {
            let inertia = diagonal(0.02, 0.03, 0.001);
            BodySpec::new(format!("{name}{k}")).mass(mass).com(com).inertia(inertia)
        };
        let names = [format!("lower{k}"), format!("upper{k}")];
        let joint = |name: &str, joint_type, from: &str, to: &str| {
            JointSpec::new(format!("{name}{k}"), joint_type, from, to)
        };
        builder = builder
            .body(rod("lower", 3.0, along_leg * 0.15))
            .body(rod("upper", 1.0, z * -0.15))
            .joint(
                joint("u", JointType::Universal, "ground", &names[0])
                    .frames(Pose { rotation, position: foot }, origin),
            )
            .joint(
                joint("p", JointType::Prismatic, &names[0], &names[1])
                    .frames(slide, origin)
                    .actuated(),
            )
            .joint(
                joint("s", JointType::Spherical, &names[1], "platform")
                    .frames(origin, Pose::at(tip)),
            );
    }
    builder.build().unwrap()
}

/// With prescribed legs, the equations of these legs alone are singular.
#[test]
fn platforms_on_many_legs_agree_with_the_dense_solution() {
    for (legs, prescribed) in [(8, 0), (8, 2), (13, 0), (13, 5)] {
        let mechanism = platform(legs);
        let coordinates: Vec<_> =
            (0..6).map(|k| Coordinate::Joint { joint: JointId(3 * k + 1), dof: 0 }).collect();
        let targets: Vec<_> = (0..6)
            .map(|k| target(0.0, if k < prescribed { 0.0 } else { 0.02 * k as f64 }))
            .collect();
        let prescribed: Vec<usize> = (0..prescribed).collect();
        let home = [(BodyId(1), Pose::at(v(0.0, 0.0, 0.55)))];
        let start = |model: &Forward| model.assemble(&home, &coordinates, &targets).ok();
        let done = both(&mechanism, &prescribed, start, |a, b| {
            assert!(b.is_sparse() && !a.is_sparse());
            let (a, b) = (a.instant(), b.instant());
            assert_eq!((a.redundant, a.mobility), (0, 6 - prescribed.len()));
            assert_eq!((b.redundant, b.mobility), (0, 6 - prescribed.len()));
            let apart = difference(a, b);
            assert!(apart < 1e-10, "{legs}: {apart:e}");
        });
        assert!(done.is_some(), "{legs}");
    }
}
