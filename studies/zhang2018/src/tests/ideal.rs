use super::*;
use crate::engine::{Run, job, model};
use crate::kinematics::inverse_jacobian;
use crate::lagrangian::*;
use crate::robot::{Motion, NO_LOAD, PRINTED_LOAD};
use crate::sections::ideal::{READINGS, agreement, errors};
use stiction_core::dynamics::FrictionMode;

/// Lagrange's equations and the engine agree for the regular variant with all rates non-zero, with
/// and without loads.
#[test]
fn lagrange_is_the_engine() {
    let model = model("zhang2018-regular").unwrap();
    let run = |load: &str| {
        Run::of(&job(&model, "regular", load, FrictionMode::Off).unwrap(), |_, _, _| true).unwrap()
    };
    let (difference, largest) = agreement(&run("L0").samples);
    // Rounding of forces of 100 N at a condition number below 10.
    assert!(difference < 1e-12 && largest > 100.0, "{difference} {largest}");
    let robot = Robot::regular();
    let l1 = [20.0, -10.0, -30.0, 2.0, 3.0, -1.5];
    for (name, load) in [("L1", l1), ("LP", PRINTED_LOAD)] {
        for sample in run(name).samples.iter().step_by(7) {
            let motion = Robot::regular_motion(sample.time);
            let own = driving_forces(&robot, Printed::NONE, &motion, load).unwrap();
            for n in 0..3 {
                assert!(
                    (own[n] - sample.ideal[n]).abs() < 3e-12,
                    "{name} {own:?} {:?}",
                    sample.ideal
                );
            }
        }
    }
}

/// Published sizes of the three errors.
#[test]
fn errors_of_the_printed_inertias() {
    let [platform, rods, bases, _] = READINGS.map(|(_, reading)| {
        let on_29 = errors(&Robot::printed(), Robot::printed_motion, reading, 1000).0;
        (on_29, errors(&Robot::regular(), Robot::regular_motion, reading, 1000).1.unwrap())
    });
    assert_eq!(platform.0, [0.0; 3]);
    near(platform.1[0], 69.0, 0);
    near(rods.0[0], 0.58, 2);
    near(rods.0[2], 0.032, 3);
    near(bases.0[0], 0.53, 2);
    near(bases.0[2], 0.047, 3);
    let size = |i: usize| {
        let at = |k: i32| {
            generalised_force(
                &Robot::printed(),
                Printed::NONE,
                &Robot::printed_motion(f64::from(k) / 1000.0),
            )[i]
        };
        (0..1000).map(at).fold(0.0_f64, |a, b| a.max(b.abs()))
    };
    near(size(0), 2.48, 2);
    near(size(2), 0.013, 3);
    // For leg 1 of the printed robot the printed axis is correct and makes no difference.
    let (rest, rate) = ([0.0, 0.5, 1.4], [0.1, 0.0, 0.0]);
    let mut alone = Robot::printed();
    alone.b = [alone.b[0]; 3];
    let energies = [false, true].map(|printed| base_energy(&alone, printed, rest, rate));
    assert!((energies[0] - energies[1]).abs() < 1e-12 * energies[0]);
}

/// (18) to (20): at rest the generalised force is the gradient of the potential and equals that of
/// the engine's static actuator forces.
#[test]
fn weights_do_the_work_of_the_potential() {
    let h = 1e-6;
    for robot in robots() {
        let pose = [0.031, 0.52, 1.15];
        let still = Motion { pose, rate: [0.0; 3], acceleration: [0.0; 3] };
        let force = generalised_force(&robot, Printed::ALL, &still);
        for i in 0..3 {
            let at = |step: f64| {
                let mut pose = pose;
                pose[i] += step;
                potential(&robot, pose)
            };
            let slope = (at(h) - at(-h)) / (2.0 * h);
            assert!((slope - force[i]).abs() < 1e-6, "{slope} {}", force[i]);
        }
        let drives = driving_forces(&robot, Printed::NONE, &still, NO_LOAD).unwrap();
        let rows = inverse_jacobian(&robot, pose);
        for i in 0..3 {
            let back: f64 = (0..3).map(|n| rows[n][i] * drives[n]).sum();
            assert!((back - force[i]).abs() < 1e-11);
        }
    }
}

/// The power of the generalised force equals the rate of change of the Lagrangian's total energy.
#[test]
fn power_is_the_change_of_energy() {
    let robot = Robot::regular();
    let energy = |time: f64| {
        let Motion { pose, rate, .. } = Robot::regular_motion(time);
        lagrangian(&robot, Printed::NONE, pose, rate) + 2.0 * potential(&robot, pose)
    };
    let h = 1e-4;
    for k in 0..10 {
        let time = 0.05 + 0.1 * f64::from(k);
        let motion = Robot::regular_motion(time);
        let force = generalised_force(&robot, Printed::NONE, &motion);
        let power: f64 = (0..3).map(|i| force[i] * motion.rate[i]).sum();
        // Fourth-order central difference.
        let slope = (8.0 * (energy(time + h) - energy(time - h))
            - (energy(time + 2.0 * h) - energy(time - 2.0 * h)))
            / (12.0 * h);
        assert!((power - slope).abs() < 1e-8, "{power} {slope}");
    }
}
