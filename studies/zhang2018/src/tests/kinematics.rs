use super::*;
use crate::engine::{job, model, positions};
use crate::kinematics::*;
use crate::robot::leg_vector;
use crate::sections::kinematics::{agreement, data, determinant_misfit};
use stiction_core::dynamics::FrictionMode;

/// (4) to (6) as printed, evaluated by hand.
#[test]
fn leg_vectors_as_printed() {
    let robot = Robot::printed();
    let (x, z, theta): (f64, f64, f64) = (0.013, 0.51, 1.4);
    let (k, l, sin, cos) = (0.15, 0.45, theta.sin(), theta.cos());
    let expected = [[x, z], [x + k * sin - l, z - k * cos], [x - k * sin + l, z + k * cos]];
    for (n, expected) in expected.into_iter().enumerate() {
        let found = leg_vector(&robot, n, [x, z, theta]);
        for i in 0..2 {
            assert!((found[i] - expected[i]).abs() < 1e-15, "{n}: {found:?} {expected:?}");
        }
    }
}

/// Published table of the regular variant's motion: lengths and rates to six digits.
#[test]
fn table_of_the_twin() {
    let rows = [
        (
            0.0,
            [0.617335, 0.509550, 0.650599],
            [0.027045, -0.042809, 0.010346],
            [0.144001, 0.330436, 0.208175],
        ),
        (
            0.3,
            [0.581699, 0.465623, 0.630515],
            [-0.191265, -0.154770, -0.104509],
            [0.061785, -0.423535, 0.061155],
        ),
        (
            0.6,
            [0.558364, 0.467025, 0.618979],
            [0.088687, 0.148219, 0.054148],
            [-0.192952, -0.064322, -0.247831],
        ),
        (
            0.9,
            [0.608858, 0.508677, 0.646482],
            [0.137404, 0.058001, 0.069648],
            [0.065636, 0.449168, 0.094876],
        ),
    ];
    let robot = Robot::regular();
    for (time, lengths, rates, turns) in rows {
        for n in 0..3 {
            let leg = leg_motion(&robot, n, &Robot::regular_motion(time));
            near(leg.length[0], lengths[n], 6);
            near(leg.length[1], rates[n], 6);
            near(leg.turn[1], turns[n], 6);
        }
    }
}

/// Second derivatives equal the finite differences of the first.
#[test]
fn accelerations_are_derivatives_of_rates() {
    let h = 1e-5;
    for (robot, motion) in [
        (Robot::printed(), Robot::printed_motion as fn(f64) -> _),
        (Robot::regular(), Robot::regular_motion),
    ] {
        for n in 0..3 {
            let at = |t: f64| leg_motion(&robot, n, &motion(t));
            let (before, now, after) = (at(0.2 - h), at(0.2), at(0.2 + h));
            // The error of central differences is h^2 times a third derivative of about (2 pi)^3.
            for (a, b, c) in [
                (before.length, now.length, after.length),
                (before.turn, now.turn, after.turn),
                (before.rod[0], now.rod[0], after.rod[0]),
                (before.rod[1], now.rod[1], after.rod[1]),
                (before.base[1], now.base[1], after.base[1]),
            ] {
                assert!(((c[1] - a[1]) / (2.0 * h) - b[2]).abs() < 1e-6);
                assert!(((c[0] - a[0]) / (2.0 * h) - b[1]).abs() < 1e-6);
            }
        }
    }
}

#[test]
fn positions_and_rates_are_those_of_the_engine() {
    for (name, motion, load, robot, signal) in [
        ("zhang2018", "printed", "none", Robot::printed(), Robot::printed_motion as fn(f64) -> _),
        ("zhang2018-regular", "regular", "L0", Robot::regular(), Robot::regular_motion),
    ] {
        let model = model(name).unwrap();
        let job = job(&model, motion, load, FrictionMode::Off).unwrap();
        let found = positions(&job).unwrap();
        assert_eq!(found.len(), 101);
        let (lengths, rates) = agreement(&robot, signal, &found);
        // Rounding of lengths below 1 m and rates below 1.
        assert!(lengths < 4e-15 && rates < 1e-14, "{name}: {lengths} {rates}");
    }
}

/// (7): zero at zero input, with legs 505 and 587.39 mm long, and equal to the leg extension
/// elsewhere.
#[test]
fn inputs_are_those_of_the_joints() {
    let robot = Robot::printed();
    let home = [0.0, 0.505, core::f64::consts::FRAC_PI_2];
    assert!(inputs(&robot, home).into_iter().all(|q| q.abs() < 1e-15));
    for (length, published) in robot.home.into_iter().zip([505.0, 587.39, 587.39]) {
        near(1e3 * length, published, 2);
    }
    let pose = [0.02, 0.52, 1.5];
    for n in 0..3 {
        let [dx, dz] = leg_vector(&robot, n, pose);
        let input: f64 = inputs(&robot, pose)[n];
        assert!((input + robot.home[n] - dx.hypot(dz)).abs() < 1e-15);
    }
}

#[test]
fn centres_lie_on_the_legs() {
    for robot in robots() {
        let pose = [0.03, 0.47, 1.2];
        for n in 0..3 {
            let [dx, dz] = leg_vector(&robot, n, pose);
            let ball = [robot.b[n][0] + dx, robot.b[n][2] + dz];
            let rod: [f64; 2] = rod_centre(&robot, n, pose);
            let base: [f64; 2] = base_centre(&robot, n, pose);
            let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            assert!((distance(rod, ball) - 0.12848).abs() < 1e-15);
            assert!((distance(base, [robot.b[n][0], robot.b[n][2]]) - 0.17465).abs() < 1e-15);
            let whole = dx.hypot(dz);
            assert!((distance(rod, base) - (whole - 0.12848 - 0.17465)).abs() < 1e-15);
        }
    }
}

/// (13) to (15) with arccos, for balls above the base.
#[test]
fn angles_of_the_legs() {
    let robot = Robot::printed();
    let home = [0.0, 0.505, core::f64::consts::FRAC_PI_2];
    let angles = [0, 1, 2].map(|n| leg_angle(&robot, n, home).to_degrees());
    near(angles[0], 90.0, 9);
    near(angles[1], 120.71, 2);
    near(angles[1] + angles[2], 180.0, 9);
    for n in 0..3 {
        let pose = [0.02, 0.5, 1.3];
        let [dx, dz] = leg_vector(&robot, n, pose);
        let arccos = (dx / dx.hypot(dz)).acos();
        assert!((arccos - leg_angle(&robot, n, pose)).abs() < 1e-14);
    }
}

#[test]
fn determinant_in_closed_form() {
    let robot = Robot::printed();
    assert!(determinant_misfit(&robot, 2000) < 1e-14);
    // Zero at 90 deg alone.
    let at = |degrees: f64| determinant(&robot, [0.01, 0.5, degrees.to_radians()]).abs();
    assert!(at(90.0) < 1e-17 && at(89.0) > 3e-4, "{} {}", at(90.0), at(89.0));
}

/// Published contradictions of the printed data.
#[test]
fn data_contradict_each_other() {
    let [sides, leg, angle, both, raised] = data().map(|datum| datum.implied);
    near(1e3 * sides[0], 300.0, 2);
    near(1e3 * sides[2], 587.39, 2);
    near(sides[3], 120.71, 2);
    near(1e3 * leg[0], 200.0, 1);
    near(leg[3], 111.61, 1);
    near(1e3 * both[0], 184.2, 1);
    near(1e3 * both[1], 511.0, 1);
    near(1e3 * raised[1], 555.0, 0);
    near(1e3 * raised[2], 589.9, 1);
    near(angle[3], 109.82, 9);
}
