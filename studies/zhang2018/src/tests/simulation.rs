use super::*;
use crate::engine::{job, model};
use crate::lagrangian::{Printed, generalised_force};
use crate::reactions::{Form, System};
use crate::robot::{NO_LOAD, PRINTED_LOAD};
use crate::sections::headline::leg_one;
use crate::sections::simulation::{missing, near_singular, singular};
use crate::simulation::*;
use stiction_core::dynamics::FrictionMode;
use stiction_run::Error;

/// The unbalanced moment is 53.9 to 55.6 N m under the printed load, 53.5 to 56.1 with its sign
/// reversed, and up to 0.95 without load; the engine agrees.
#[test]
fn moment_is_missing() {
    let (least, most) = missing(PRINTED_LOAD);
    near(-most, 53.9, 1);
    near(-least, 55.6, 1);
    let (least, most) = missing(PRINTED_LOAD.map(|part| -part));
    near(least, 53.5, 1);
    near(most, 56.05, 2);
    let (least, most) = missing(NO_LOAD);
    near(most, 0.95, 2);
    assert!((least + most).abs() < 1e-12);

    let model = model("zhang2018").unwrap();
    let job = job(&model, "printed", "printed", FrictionMode::Off).unwrap();
    let Err(Error::CannotCarry(found)) = job.run(|_| Ok(()), |_, _, _| true) else { panic!() };
    assert_eq!((found.samples, found.of, found.unit), (101, 101, "N m"));
    near(found.range.0, 53.9, 1);
    near(found.range.1, 55.6, 1);
}

/// Without load the moment vanishes at 0, 0.5 and 1 s alone.
#[test]
fn three_instants_can_be_balanced() {
    let robot = Robot::printed();
    let at = |time: f64| missing_moment(&robot, &Robot::printed_motion(time), NO_LOAD);
    for time in [0.0, 0.5, 1.0] {
        assert!(at(time).abs() < 1e-12, "{time}");
    }
    for k in 1..500 {
        let time = f64::from(k) / 1000.0;
        assert!(at(time) > 1e-3 && at(time + 0.5) < -1e-3, "{time}");
    }
    // At t = 0 the actuator forces of the 42 equations match the published values.
    let system = System::new(&robot, &Robot::printed_motion(0.0), NO_LOAD, Form::Corrected);
    let (drives, residual) = least_squares(&system, 1.0, false);
    for (found, published) in drives.into_iter().zip([37.79, 46.81, 46.81]) {
        near(found, published, 2);
    }
    assert!(residual < 1e-11, "{residual}");
}

#[test]
fn singular_along_the_motion() {
    let (smallest, dependence) = singular();
    assert!(smallest < 1e-14 && dependence < 1e-14, "{smallest} {dependence}");
    // Inverse proportionality to the distance: 551 N at 1 deg, 4.07e5 N at 0.001 deg.
    near(near_singular(1.0).unwrap(), 551.0, 0);
    near(near_singular(0.001).unwrap() / 1e5, 4.07, 2);
    assert!(near_singular(0.0).is_none());
}

/// Published least-squares results that do not depend on linear combinations of the rows.
#[test]
fn least_squares_depends_on_units() {
    let robot = Robot::printed();
    let motion = Robot::printed_motion(0.25);
    for (load, without_pitch, planar) in [
        (NO_LOAD, [39.37, 52.40, 45.57], [[49.87, 46.11, 39.67], [49.87, 42.64, 43.11]]),
        (PRINTED_LOAD, [-301.9, 288.6, 89.1], [[8.9, 121.2, -104.9], [8.5, 318.8, -301.4]]),
    ] {
        let system = System::new(&robot, &motion, load, Form::Corrected);
        let digits = if load == NO_LOAD { 2 } else { 1 };
        let (found, residual) = least_squares(&system, 1.0, true);
        assert!(residual < 1e-10, "{residual}");
        for n in 0..3 {
            near(found[n], without_pitch[n], digits);
            for (unit, planar) in [1.0, 1e3].into_iter().zip(planar) {
                near(planar_least_squares(&robot, &motion, load, unit)[n], planar[n], digits);
            }
        }
        let answers = [(&system, 1.0), (&system, 1e3), (&system.of_single_bodies(&robot), 1.0)]
            .map(|(system, unit)| least_squares(system, unit, false));
        // Neither result solves the equations, and no two results agree.
        for (k, (drives, residual)) in answers.iter().enumerate() {
            assert!(*residual > 0.1, "{residual}");
            let others = answers[..k].iter();
            assert!(others.map(|o| (o.0[1] - drives[1]).abs()).all(|d| d > 0.1), "{answers:?}");
        }
    }
}

/// Leg 1 longer by 1 um: no pose, or two poses 0.22 deg and 1.0 mm away; by 10 um: 0.71 deg and 3.2
/// mm.
#[test]
fn positions_fold() {
    let robot = Robot::printed();
    let home = Robot::printed_motion(0.0).pose;
    for (change, degrees, millimetres) in [(-1e-6, 0.22, 1.0), (-1e-5, 0.71, 3.2)] {
        for side in [1.0, -1.0] {
            let found = fold(&robot, 0.0, change, 0.01 * side).unwrap();
            near(side * (found[2] - home[2]).to_degrees(), degrees, 2);
            near(side * (found[0] - home[0]) * 1e3, millimetres, 1);
            assert!(fold(&robot, 0.0, -change, 0.01 * side).is_none());
        }
    }
}

/// Without load the normal force of leg 1 is at most 0.22 N and its friction 0.03 N.
#[test]
fn friction_of_leg_one_is_small() {
    let (load, friction) = leg_one();
    near(load, 0.22, 2);
    near(friction, 0.03, 2);
}

/// With friction, a self-stress between 50 and 200 N closes the balance about y at t = 0.2 s; none
/// up to 1 kN does at t = 0.02 s. Zero coefficients give zero friction.
#[test]
fn friction_and_self_stress_on_the_printed_motion() {
    let robot = Robot::printed();
    let missing = |time: f64, f: f64| {
        with_friction(&robot, &Robot::printed_motion(time), NO_LOAD, f).unwrap().1
    };
    let closes =
        |time: f64, sign: f64| missing(time, 50.0 * sign) * missing(time, 200.0 * sign) < 0.0;
    assert!(closes(0.2, 1.0) || closes(0.2, -1.0));
    let at_first = missing(0.02, 0.0);
    near(at_first.abs(), 0.47, 2);
    for k in 1..=20 {
        for f in [50.0 * f64::from(k), -50.0 * f64::from(k)] {
            assert!(missing(0.02, f) * at_first > 0.0, "{f}");
        }
    }
    let free = Robot { mu: 0.0, viscous: 0.0, ..robot.clone() };
    let motion = Robot::printed_motion(0.2);
    let (force, missed) = with_friction(&free, &motion, NO_LOAD, 70.0).unwrap();
    let ideal = generalised_force(&robot, Printed::NONE, &motion);
    assert!((0..3).all(|i| (force[i] - ideal[i]).abs() < 1e-12));
    assert!((missed.abs() - missing_moment(&robot, &motion, NO_LOAD).abs()).abs() < 1e-10);
}

/// Published least-squares results for single bodies, the rod about P and the base about R.
#[test]
fn least_squares_of_single_bodies() {
    let robot = Robot::printed();
    let motion = Robot::printed_motion(0.25);
    for (load, unit, published, digits) in [
        (NO_LOAD, 1.0, [39.37, 50.50, 47.49], 2),
        (NO_LOAD, 1e3, [39.36, 49.11, 48.88], 2),
        (PRINTED_LOAD, 1.0, [-301.5, 397.1, -19.9], 1),
        (PRINTED_LOAD, 1e3, [-301.2, 476.4, -99.3], 1),
    ] {
        let system = System::new(&robot, &motion, load, Form::Corrected).of_single_bodies(&robot);
        let (drives, _) = least_squares(&system, unit, false);
        for (found, published) in drives.into_iter().zip(published) {
            near(found, published, digits);
        }
    }
}
