//! Tests of the fast singularity indices against decompositions of the balance matrices.

use super::super::newton_euler::Unknown;
use super::*;
use crate::dynamics::{InverseDynamics, Settings};
use crate::kinematics::{Coordinate, Target};
use crate::linalg::Svd;
use crate::mechanism::{BodySpec, JointId, JointSpec, MechanismBuilder};
use crate::spatial::{Mat3, Pose, Vec3};

/// Creates a four-bar linkage with R, U, S and R joints, whose crank is actuated.
fn four_bar() -> Mechanism {
    four_bars(1)
}

/// Creates separate four-bar linkages as [`four_bar`]. The first joint of each is its crank.
fn four_bars(count: usize) -> Mechanism {
    let at = |x: f64, y: f64, z: f64| {
        // Rotation axes in general directions.
        let turn = Vec3::new(0.4 + x, 0.9 - y, 0.2 + z);
        Pose { rotation: Mat3::rotation(turn, 1.0), position: Vec3::new(x, y, z) }
    };
    // At this configuration, all body frames coincide with the ground frame.
    let [a, b, c, d] =
        [at(0.0, 0.0, 0.0), at(0.02, 0.0, 0.1), at(0.33, 0.01, 0.2), at(0.3, 0.02, 0.0)];
    let mut builder = MechanismBuilder::new("four-bars");
    for k in 0..count {
        let name =
            |part: &str| if part == "ground" { part.to_owned() } else { format!("{part}{k}") };
        let joint = |joint: &str, kind, ends: [&str; 2], frames: [Pose<f64>; 2]| {
            let [from, to] = ends.map(name);
            JointSpec::new(name(joint), kind, from, to).frames(frames[0], frames[1])
        };
        for (part, com) in [("crank", b), ("rod", c), ("rocker", d)] {
            builder = builder.body(BodySpec::new(name(part)).mass(1.0).com(com.position * 0.6));
        }
        builder = builder
            .joint(joint("a", JointType::Revolute, ["ground", "crank"], [a, a]).actuated())
            .joint(joint("b", JointType::Universal, ["crank", "rod"], [b, b]))
            .joint(joint("c", JointType::Spherical, ["rod", "rocker"], [c, c]))
            .joint(joint("d", JointType::Revolute, ["ground", "rocker"], [d, d]));
    }
    builder.build().unwrap()
}

/// Checks the indices along a motion in short steps against dense decompositions. Two equal
/// linkages move in opposite directions, so that their smallest singular values cross in the middle
/// of the motion, after which another eigenvector than the extrapolated one belongs to the index.
#[test]
fn indices_are_enclosed_along_smooth_motions() {
    let cranks = [0, 4].map(|joint| Coordinate::Joint { joint: JointId(joint), dof: 0 });
    let motion = |t: f64, targets: &mut [Target<f64>]| {
        for (target, rate) in targets.iter_mut().zip([0.2, -0.2]) {
            *target = Target { value: rate * t, rate, acceleration: 0.0 };
        }
    };
    const STEP: f64 = 5e-4;
    const STEPS: usize = 80;
    let time = |step: usize| STEP * (step as f64 - STEPS as f64 / 2.0);
    let mut targets = [Target { value: 0.0, rate: 0.0, acceleration: 0.0 }; 2];
    motion(time(0), &mut targets);
    let mut solver =
        InverseDynamics::new(four_bars(2), &[], &cranks, &targets, Settings::default()).unwrap();
    let mut proximity = SingularityDistances::new(solver.mechanism()).unwrap();
    let mut enclosed = Vec::new();
    for step in 0..STEPS {
        let at = (solver.parameters(), solver.bodies());
        let dense = proximity.measure_dense(solver.mechanism(), at.0, at.1);
        proximity.place(at.0, at.1);
        let largest = proximity.largest();
        let pairs = [
            (SingularityIndex::Actuation, dense.actuation),
            (SingularityIndex::Constraint, dense.constraint),
        ];
        for (index, expected) in pairs {
            let found = proximity.smallest_in_bracket(index, largest);
            if index == SingularityIndex::Constraint {
                enclosed.push(found.is_some());
            }
            let found = found.or_else(|| proximity.smallest(index, largest)).unwrap();
            // The eigenvalue is enclosed to 1e-9.
            assert!(
                (found - expected).abs() < 1e-9 * expected,
                "{index:?} {step}: {found} {expected}"
            );
        }
        solver.follow(time(step), time(step + 1), motion).unwrap();
    }
    // The actuation index of these linkages is too small for its round-off to be neglected.
    let [before, after] = [&enclosed[..STEPS / 2], &enclosed[STEPS / 2..]];
    for half in [before, after] {
        assert!(half.iter().filter(|enclosed| **enclosed).count() > STEPS / 3, "{enclosed:?}");
    }
    assert!(after[..3].contains(&false), "{enclosed:?}");
}

#[test]
fn lower_bounds_are_below_the_indices() {
    let crank = Coordinate::Joint { joint: JointId(0), dof: 0 };
    let still = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
    let solver =
        InverseDynamics::new(four_bar(), &[], &[crank], &[still], Settings::default()).unwrap();
    let at = (solver.parameters(), solver.bodies());
    let mut proximity = SingularityDistances::new(solver.mechanism()).unwrap();
    let Distances { actuation, constraint } = proximity.measure(solver.mechanism(), at.0, at.1);
    let both = [SingularityIndex::Actuation, SingularityIndex::Constraint];
    for (index, value) in both.into_iter().zip([actuation, constraint]) {
        // The margin for round-off is 1e-11, relative to the square of the largest entry.
        assert!(proximity.exceeds(index, value * (1.0 - 1e-6), at), "{index:?} {value}");
        assert!(!proximity.exceeds(index, value * (1.0 + 1e-6), at), "{index:?} {value}");
        assert!(!proximity.exceeds(index, f64::NAN, at));
        assert!(!proximity.exceeds(index, 0.0, at));
    }
}

/// Checks that triangular factors yield small singular values accurately. A very large
/// characteristic length makes the scaled balance matrices nearly singular.
#[test]
fn small_values_are_found_by_triangular_factors() {
    let mut small = 0;
    let crank = Coordinate::Joint { joint: JointId(0), dof: 0 };
    let still = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
    let solver =
        InverseDynamics::new(four_bar(), &[], &[crank], &[still], Settings::default()).unwrap();
    let mechanism = solver.mechanism();
    for length in [1e2, 1e3, 1e4, 3e4, 1e5, 3e5, 1e6, 1e7, 1e8] {
        let mut parameters = solver.parameters().clone();
        parameters.length = length;
        let system = NewtonEuler::new(mechanism, &parameters, solver.bodies());
        let types: Vec<_> = mechanism.joints().iter().map(|joint| joint.joint_type).collect();
        let scaled = system.scaled_matrix(&types).to_dense();
        let is_constraint = |k: &usize| matches!(system.unknowns[*k], Unknown::Constraint { .. });
        let constraints: Vec<usize> = (0..scaled.ncols()).filter(is_constraint).collect();
        let only_constraints = scaled.select_columns(&constraints);

        let mut proximity = SingularityDistances::new(mechanism).unwrap();
        proximity.place(&parameters, solver.bodies());
        let largest = proximity.largest();
        let pairs = [
            (proximity.smallest_by_factor(SingularityIndex::Actuation), Svd::new(&scaled)),
            (
                proximity.smallest_by_factor(SingularityIndex::Constraint),
                Svd::new(&only_constraints),
            ),
        ];
        for (found, svd) in pairs {
            let expected = *svd.singular_values.as_slice().last().unwrap();
            if !(TINY * largest..=SMALL * largest).contains(&expected) {
                continue;
            }
            // The iteration stops at a residual of 1e-9, with a quadratic error; with any method,
            // the relative accuracy of the smallest value is the round-off of the entries divided
            // by that value.
            let known = 2e-12 + 8.0 * f64::EPSILON * svd.largest() / expected;
            let found = found.unwrap();
            let error = (found - expected).abs() / expected;
            assert!(error < known, "{length}: {found} {expected}, {error}");
            small += 1;
        }
    }
    assert!(small >= 6, "{small}");
}

/// The constraint matrix of many similar pendulums has many eigenvalues close to the smallest one.
/// Iterations without a shift do not separate them; with a shift from a bisection, the smallest one
/// is found without a dense decomposition.
#[test]
fn the_smallest_of_many_close_values_is_found() {
    const COUNT: usize = 400;
    let mut builder = MechanismBuilder::new("pendulums");
    for k in 0..COUNT {
        // The arms lie closest together near the ends of their range.
        let arm = 1.1 + 0.9 * (std::f64::consts::PI * k as f64 / (COUNT - 1) as f64).cos();
        let name = format!("b{k}");
        let body = BodySpec::new(&name).mass(1.0).com(Vec3::new(arm, 0.0, 0.0));
        let joint = JointSpec::new(format!("j{k}"), JointType::Revolute, "ground", &name);
        builder = builder.body(body).joint(joint.actuated());
    }
    let coordinates: Vec<_> =
        (0..COUNT).map(|k| Coordinate::Joint { joint: JointId(k), dof: 0 }).collect();
    let still = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
    let targets = vec![still; COUNT];
    let mechanism = builder.build().unwrap();
    let solver =
        InverseDynamics::new(mechanism, &[], &coordinates, &targets, Settings::default()).unwrap();
    let (parameters, bodies) = (solver.parameters(), solver.bodies());
    let mut proximity = SingularityDistances::new(solver.mechanism()).unwrap();
    proximity.place(parameters, bodies);
    let index = SingularityIndex::Constraint;
    assert!(proximity.smallest_at(index, Shift::NONE).is_none());
    let found = proximity.smallest_by_iteration(index).unwrap();
    assert!(proximity.exceeds(index, found * (1.0 - 1e-8), (parameters, bodies)), "{found}");
    assert!(!proximity.exceeds(index, found * (1.0 + 1e-8), (parameters, bodies)), "{found}");
}
