//! Onset of motion: breakaway efforts at the ends of the intervals at rest, and as the limit of
//! slow motion.

use crate::breakaway::holder::Holder;
use crate::common::*;
use stiction_core::dynamics::{Bounds, Breakaway, FrictionMode, InverseDynamics, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_run::breakaway::evaluate;

/// Tests breakaway efforts against the ends of the intervals. Statics yields the static friction
/// that raises an actuator force most, and kinematics yields the impending motion. Friction takes
/// power from the motion, so both results agree except for the effect of normal loads: to first
/// order in the coefficients, the ends of the interval are the breakaway efforts. In some
/// mechanisms, the interfaces have only one direction of sliding, and none slides slowly (pins of
/// planar mechanisms). The normal loads then keep their directions, and the results agree.
#[test]
fn breakaway_is_at_the_ends_of_the_interval() {
    let mut compared = 0;
    for name in regular() {
        let model = model(name);
        let Ok(found) = evaluate(&default_job(&model, FrictionMode::Converged), Some(0.0)) else {
            continue;
        };
        for (k, breakaway) in found.rest.breakaway.iter().enumerate() {
            let (Some(breakaway), (low, high)) = (breakaway, found.forces.effort_bounds[k]) else {
                continue;
            };
            let rounding = 1e-9 * (low.abs() + high.abs());
            let (back, forth) = (breakaway.backward.1, breakaway.forward.1);
            assert!(low - rounding <= back && forth <= high + rounding, "{name} {breakaway:?}");
            let planar = ["five-bar", "four-bar", "slider-crank", "3rrr"].contains(&name);
            let gap = (back - low).max(high - forth);
            assert!(!planar || gap <= rounding, "{name} {breakaway:?} {low} {high}");
            compared += usize::from(high - low > 1e-6);
        }
    }
    assert!(compared > 10, "{compared}");
}

/// Tests a guide and a plate that load each other strongly. At the onset of motion, all friction
/// forces are within their limits, so the inner bounds extend at least to the breakaway efforts.
#[test]
fn motion_begins_within_the_interval() {
    const STRONG: &str = r#"
gravity = [5.92, 9.7, -5.62]
[base]
rotation = { xzy = ["81 deg", "43 deg", "94 deg"] }

[bodies.b0]
com = [-0.062, -0.11, 0.12]
[bodies.b1]
mass = 2.99
com = [-0.021, -0.111, -0.077]
inertia = [0.15, 0.173, 0.14]
[bodies.b2]
[bodies.b3]

[joints.j0]
type = "H"
from = "b0"
to = "ground"
at = [0.366, 0.2943, -0.0668]
to_at = [0.022, 0.11, -0.311]
axis = [0.7, -0.024, -0.51]
turn = { yzx = [-2.23, -0.124, -1.7] }
pitch = 0.017
actuated = true
[joints.guide]
type = "P"
from = "b0"
to = "b1"
at = [0.26, 0.3, 0.043]
axis = [-0.23, 0.8525, -0.64]
turn = { xzx = [0.65, 2.465, -3.0] }
start = 0.075
friction = { mu = 0.14, torsion_arm = 0.1301 }
[joints.j4]
type = "E"
from = "b1"
to = "b2"
at = [0.4, -0.133, -0.361]
to_at = [0.73, -0.0584, -0.169]
axis = [0, 0, -1]
x_axis = [-2.1, 0.14, 0]
actuated = ["angle"]
friction = { mu = 0.1, radius = 0.004, bending_span = 0.22 }
[joints.j3]
type = "P"
from = "b3"
to = "b2"
axis = [-0.385, -0.082, -0.369]
actuated = true
[joints.j2]
type = "S"
from = "b2"
to = "ground"
at = [-0.16, -0.2, -0.018]
to_at = [0.4, -0.3335, -0.0656]

[springs.s0]
from = "b1"
to = "b0"
at = [0.02, 0.36, -0.015]
to_at = [0.2256, -0.201, -0.45]
stiffness = 58
free_length = 0.431

[motions.go]
duration = 0
j0 = -0.18
j4.x = 0.04
j3 = 0.23

[loads.press]
b1 = { force = [12.9, -56, -72.3], moment = [-2.12, 2.66, 0.006], at = [0.26, 0.25, 0.07] }
b3 = { force = [3.1, -78, 39.6], moment = [4.68, 1.1, -7.89], at = [0.3, 0.29, 0.15] }
[default]
motion = "go"
load = "press"
"#;
    let model = model_of("strong", STRONG);
    let found = evaluate(&default_job(&model, FrictionMode::Converged), None).unwrap();
    assert_eq!(found.forces.bounds, Bounds::Attained);
    let mut some = 0;
    for (breakaway, (low, high)) in found.rest.breakaway.iter().zip(&found.forces.effort_bounds) {
        let Some(Breakaway { forward, backward }) = breakaway else { continue };
        for effort in [forward.0, forward.1, backward.0, backward.1] {
            assert!((*low..=*high).contains(&effort), "{low} {effort} {high}");
            some += 1;
        }
    }
    assert_eq!(some, 12);
}

/// Tests that the breakaway effort of a leg is the effort of a slow motion of this leg while the
/// other legs are at rest.
#[test]
fn breakaway_is_the_limit_of_slow_motion() {
    let model = model("3rps");
    let holder = Holder::new(&model, 0.3);
    let legs: Vec<_> = model.mechanism.actuators().collect();
    let coordinates: Vec<Coordinate> =
        legs.iter().map(|&(joint, dof)| Coordinate::Joint { joint, dof }).collect();
    for (k, breakaway) in holder.rest.breakaway.iter().enumerate() {
        let breakaway = breakaway.unwrap();
        for (rate, expected) in [(1e-8, breakaway.forward), (-1e-8, breakaway.backward)] {
            let targets: Vec<Target<f64>> = legs
                .iter()
                .enumerate()
                .map(|(leg, &(joint, dof))| Target {
                    value: holder.solver.joint_coordinates(joint)[dof],
                    rate: if leg == k { rate } else { 0.0 },
                    acceleration: 0.0,
                })
                .collect();
            let (mechanism, initial_poses) = (model.mechanism.clone(), &model.initial_poses);
            let settings = Settings { rest_speed: 1e-14, ..Settings::default() };
            let mut solver =
                InverseDynamics::new(mechanism, initial_poses, &coordinates, &targets, settings)
                    .unwrap();
            let forces = solver.solve(&holder.loads).unwrap();
            let same = holder.solver.forces().efforts_frictionless.iter();
            for (a, b) in same.zip(&forces.efforts_frictionless) {
                assert!((a - b).abs() < 1e-9 * a.abs(), "another position: {a} {b}");
            }
            // Guides of legs at rest may have any static friction: the effort is between two
            // limits.
            let (least, greatest) = (expected.0.min(expected.1), expected.0.max(expected.1));
            let (low, high) = forces.effort_bounds[k];
            // Tolerance for viscous friction at 1e-8 m/s, and for the slow interfaces in the legs
            // at rest.
            let near = 1e-6;
            assert!(
                (low - least).abs() < near && (high - greatest).abs() < near,
                "{k} {rate}: {low} {high} {expected:?}"
            );
        }
    }
}
