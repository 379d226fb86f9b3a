//! Friction contributions to each actuator force: sums, the dense system, and virtual work.

use crate::common::random::*;
use crate::common::*;
use stiction_core::dynamics::{FrictionMode, InverseDynamics, Settings};
use stiction_core::kinematics::Target;

const FRICTION: [FrictionMode; 2] = [FrictionMode::OnePass, FrictionMode::Converged];

/// Lists all friction contributions, actuator by actuator.
fn shares(solver: &mut InverseDynamics) -> Vec<Vec<f64>> {
    let drives = solver.forces().efforts.len();
    let shares = solver.shares();
    (0..drives).map(|drive| shares.of_actuator(drive).collect()).collect()
}

/// Computes the largest difference between the sum of the contributions and the change of an
/// actuator force due to friction, relative to the sum of all magnitudes.
fn misses(solver: &InverseDynamics, shares: &[Vec<f64>]) -> f64 {
    let forces = solver.forces();
    let pairs = forces.efforts.iter().zip(&forces.efforts_frictionless).zip(shares);
    let miss = pairs.map(|((with, without), shares)| {
        let sum: f64 = shares.iter().sum();
        let size = shares.iter().map(|share| share.abs()).sum::<f64>() + with.abs();
        (with - without - sum).abs() / size.max(f64::MIN_POSITIVE)
    });
    miss.fold(0.0, f64::max)
}

/// Calls `each` with the solvers of regular random mechanisms, after solving for all forces.
fn solved(mut each: impl FnMut(&Case, &mut InverseDynamics, f64)) {
    for class in CLASSES {
        for seed in 0..10 {
            for friction in FRICTION {
                let (_, case) = case(class, seed, 0.1);
                let settings = Settings { friction, ..Settings::default() };
                let solver = InverseDynamics::new(
                    case.mechanism.clone(),
                    &[],
                    &case.coordinates,
                    &case.targets,
                    settings,
                );
                let Ok(mut solver) = solver else { continue };
                let statics = solver.statics();
                let smallest = *statics.singular_values()[..statics.rank()].last().unwrap();
                // Near singular configurations, round-off grows with the inverse of the smallest
                // singular value, and with its square if redundant actuators share the load by a
                // quadratic rule.
                if smallest > 2e-3 && solver.solve(&case.loads).is_ok() {
                    each(&case, &mut solver, smallest);
                }
            }
        }
    }
}

#[test]
fn contributions_add_up_and_agree_with_the_dense_system() {
    let (mut summed, mut compared) = (0, 0);
    solved(|case, solver, smallest| {
        let kernel = shares(solver);
        let miss = misses(solver, &kernel);
        assert!(miss < 1e-13 / smallest, "{:?}: {miss:e}", case.class);
        assert_eq!(shares(solver), kernel, "asked twice");
        summed += 1;
        if solver.solve_dense(&case.loads).is_err() {
            return;
        }
        let dense = shares(solver);
        let miss = misses(solver, &dense);
        assert!(miss < 1e-13 / smallest, "{:?} dense: {miss:e}", case.class);
        let drives = solver.forces().efforts.clone();
        // See `solved`.
        let is_redundant = drives.len() > case.coordinates.len();
        // Friction near locking amplifies round-off in the same way as the frictionless efforts.
        let (mut greatest, mut frictionless) = (0f64, 0f64);
        for (shares, drive) in dense.iter().zip(&drives) {
            greatest = shares.iter().fold(greatest, |most, share| most.max(share.abs()));
            frictionless = frictionless.max((drive - shares.iter().sum::<f64>()).abs());
        }
        let amplified = (greatest / frictionless).max(1.0);
        let limit = 1e-12 * amplified / smallest.powi(if is_redundant { 2 } else { 1 });
        for ((kernel, dense), drive) in kernel.iter().zip(&dense).zip(drives) {
            let size = dense.iter().map(|share| share.abs()).sum::<f64>() + drive.abs();
            for (a, b) in kernel.iter().zip(dense) {
                assert!((a - b).abs() <= limit * size, "{:?} {a} {b}", case.class);
            }
        }
        compared += 1;
    });
    assert!(summed > 100 && compared > 100, "{summed} {compared}");
}

/// Checks that a contribution is the friction times the sliding velocity in the motion with a unit
/// rate of one actuator and all others at rest. The rates are taken from the mechanism in this
/// motion.
#[test]
fn contributions_are_those_of_virtual_work() {
    let mut compared = 0;
    solved(|case, solver, smallest| {
        let spins = solver.constraints().spins().len();
        let count = case.coordinates.len();
        // Only if each actuator can move alone. Friction accelerates local DOFs.
        if spins > 0 || solver.actuator_rates().count() != count {
            return;
        }
        let found = shares(solver);
        let topology = solver.topology().clone();
        let interfaces = solver.parameters().interfaces.clone();
        let mut moved = solver.clone();
        let mut rates = nalgebra::DMatrix::zeros(count, count);
        let mut joints = Vec::new();
        for k in 0..count {
            let unit = |(i, target): (usize, &Target<f64>)| {
                let rate = if i == k { 1.0 } else { 0.0 };
                Target { rate, ..*target }
            };
            let targets: Vec<_> = case.targets.iter().enumerate().map(unit).collect();
            moved.move_to(&targets).unwrap();
            for (drive, rate) in moved.actuator_rates().enumerate() {
                rates[(drive, k)] = rate;
            }
            let of_joint = |joint| moved.bodies().joint_rates(&topology, joint);
            joints.push((0..case.mechanism.joints().len()).map(of_joint).collect::<Vec<_>>());
        }
        let Some(inverse) = rates.clone().try_inverse() else { return };
        if inverse.norm() * rates.norm() > 1e3 {
            return;
        }
        for drive in 0..count {
            let size: f64 = found[drive].iter().map(|share| share.abs()).sum();
            for (index, interface) in interfaces.iter().enumerate() {
                // Surface velocities of the motion, and of a unit rate of each actuator.
                let arms = interface.arms(solver.parameters().pitch[interface.joint]);
                let surface = |rates: &[f64]| {
                    let own = rates[interface.shape.dofs()].iter().zip(arms);
                    own.map(|(rate, arm)| rate * arm).collect::<Vec<f64>>()
                };
                let sliding = surface(&solver.bodies().joint_rates(&topology, interface.joint));
                let speed = sliding.iter().map(|u| u * u).sum::<f64>().sqrt();
                let force = solver.forces().interfaces[index].limit;
                let mut work = 0.0;
                for k in 0..count {
                    let unit = surface(&joints[k][interface.joint]);
                    let along: f64 = sliding.iter().zip(unit).map(|(a, b)| a * b).sum();
                    work += force * along / speed * inverse[(k, drive)];
                }
                assert!(
                    (work - found[drive][index]).abs() <= 1e-9 / smallest * size,
                    "{:?} {drive} {index}: {work} {}",
                    case.class,
                    found[drive][index]
                );
                compared += 1;
            }
        }
    });
    assert!(compared > 500, "{compared}");
}

/// Checks that the actuator powers due to the contributions equal the dissipated power.
#[test]
fn contributions_dissipate_the_friction_power() {
    let mut compared = 0;
    solved(|case, solver, smallest| {
        if !solver.constraints().spins().is_empty() {
            return;
        }
        let found = shares(solver);
        let forces = solver.forces();
        for (index, interface) in forces.interfaces.iter().enumerate() {
            let rates = solver.actuator_rates();
            let taken: f64 =
                found.iter().zip(rates).map(|(shares, rate)| shares[index] * rate).sum();
            let size = forces.power.turnover;
            assert!((taken - interface.power).abs() <= 1e-12 / smallest * size, "{:?}", case.class);
            compared += 1;
        }
    });
    assert!(compared > 500, "{compared}");
}

/// Checks that reversed rates reverse friction and nothing else, and that reversing them again
/// restores the original values.
#[test]
fn time_run_backward_reverses_friction_and_nothing_else() {
    let mut compared = 0;
    solved(|case, solver, smallest| {
        let mut back = solver.reversed();
        for (ahead, back) in solver.actuator_rates().zip(back.actuator_rates()) {
            assert!((ahead + back).abs() <= 1e-12 * ahead.abs(), "{ahead} {back}");
        }
        if back.solve(&case.loads).is_err() {
            return;
        }
        let drives = |solver: &InverseDynamics| {
            let forces = solver.forces();
            (forces.efforts.clone(), forces.efforts_frictionless.clone())
        };
        let ((with, without), (_, without_back)) = (drives(solver), drives(&back));
        let near = |a: &[f64], b: &[f64]| {
            let largest = a.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
            a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-11 / smallest * largest)
        };
        assert!(near(&without, &without_back), "{:?}", case.class);
        assert!(back.forces().interfaces.iter().all(|interface| interface.power >= 0.0));
        let mut again = back.reversed();
        again.solve(&case.loads).unwrap();
        assert!(near(&with, &drives(&again).0), "{:?}", case.class);
        compared += 1;
    });
    assert!(compared > 100, "{compared}");
}

/// The slider-crank of reference R8 at 60 degrees, compared with a calculation by hand. For a unit
/// rate of the crank, the rod turns at `-a cos(q) / (l cos(b))` relative to the ground.
#[test]
fn slider_crank_by_hand() {
    let robot = slider_crank();
    let (angle, crank, rod) = (60f64.to_radians(), 0.1, 0.3);
    let turning = |t: f64| Target { value: 10.0 * t, rate: 10.0, acceleration: 0.0 };
    let (mechanism, coordinates) = (robot.mechanism, &robot.coordinates);
    let start = [turning(0.0)];
    let mut solver =
        InverseDynamics::new(mechanism, &[], coordinates, &start, Settings::default()).unwrap();
    solver.follow(0.0, 0.1 * angle, |t, targets| targets[0] = turning(t)).unwrap();
    solver.solve(&[]).unwrap();
    let found = shares(&mut solver)[0].clone();
    // The rod's angle below the horizontal, and its rate for a unit rate of the crank.
    let tilt = (crank * angle.sin() / rod).asin();
    let rod_rate = -crank * angle.cos() / (rod * tilt.cos());
    let slider_rate = -crank * angle.sin() + rod * tilt.sin() * rod_rate;
    // Sliding velocities: pins of 10 mm at A, B (rod against crank), C (slider against rod).
    let sliding = [0.01, 0.01 * (rod_rate - 1.0), 0.01 * -rod_rate, slider_rate];
    for ((interface, share), sliding) in solver.forces().interfaces.iter().zip(&found).zip(sliding)
    {
        assert!((interface.velocity - 10.0 * sliding).abs() < 1e-12);
        let expected = interface.friction * sliding;
        assert!((share - expected).abs() < 1e-12, "{share} {expected}");
        // Every joint resists a crank that turns forward.
        assert!(*share > 0.0);
    }
}
