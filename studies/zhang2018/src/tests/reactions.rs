use super::*;
use crate::engine::{Run, job, model};
use crate::friction::joint_friction;
use crate::kinematics::joint_rates;
use crate::reactions::*;
use crate::robot::NO_LOAD;
use crate::sections::reactions::{agreement, null_vector, printed_errors, ranks, transverse};
use crate::simulation::{missing_moment, out_of_range};
use stiction_core::dynamics::FrictionMode;

const REFERENCE: &str = include_str!("../../../../reference/3rps_parallel_axis_regular_L0.csv");

/// All 42 unknowns at eleven instants, published with ten digits, in three cases.
#[test]
fn reference_of_all_unknowns() {
    let mut lines = REFERENCE.lines().filter(|line| !line.starts_with('#'));
    assert!(
        lines.next().unwrap().starts_with("load,t,case,FRt1,FRy1,FRu1,MRt1,MRu1,FPt1,FPy1,MPt1")
    );
    let robot = Robot::regular();
    let mut compared = 0;
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let motion = Robot::regular_motion(cells[1].parse().unwrap());
        let system = System::new(&robot, &motion, NO_LOAD, Form::Corrected);
        let lu = system.matrix.clone().lu();
        let mut unknowns = lu.solve(&system.right).unwrap();
        let passes = match cells[2] {
            "frictionless" => 0,
            "onepass" => 1,
            "converged" => 60,
            other => panic!("{other}"),
        };
        for _ in 0..passes {
            let loads = System::loads(&unknowns);
            let friction = joint_friction(&robot, &joint_rates(&robot, &motion), &loads, true);
            let mut right = system.right.clone();
            system.add_friction(&friction, &mut right);
            unknowns = lu.solve(&right).unwrap();
        }
        for (i, cell) in cells[3..].iter().enumerate() {
            let expected: f64 = cell.parse().unwrap();
            // Half a unit in the tenth digit.
            let tolerance = 5.1e-10 * expected.abs().max(1e-3) + 1e-11;
            assert!((unknowns[i] - expected).abs() < tolerance, "{line}: {i} {}", unknowns[i]);
            compared += 1;
        }
    }
    assert_eq!(compared, 33 * SIZE);
}

/// The rank is 41 at every pose of the printed robot and 42 for the regular variant.
#[test]
fn rank_forty_one() {
    let [printed, regular] = robots();
    let along = |motion: fn(f64) -> _| (0..40).map(move |k| motion(f64::from(k) / 40.0));
    for form in [Form::Printed, Form::Corrected] {
        let found = ranks(&printed, form, &mut along(Robot::printed_motion));
        assert_eq!(found.rank, (41, 41));
        assert!(found.last.1 < 1e-14 && found.before_last.0 > 0.05, "{found:?}");
        let found = ranks(&regular, form, &mut along(Robot::regular_motion));
        assert_eq!(found.rank, (42, 42));
        assert!(found.last.0 > 5e-3, "{found:?}");
    }
    // Nine unknowns appear in no equation.
    let found = ranks(&printed, Form::Literal, &mut along(Robot::printed_motion));
    assert_eq!(found.rank, (33, 33));
}

/// The null vector is the self-stress (-2, 1, 1) and its internal reactions.
#[test]
fn null_vector_is_the_self_stress() {
    for k in 0..10 {
        let (vector, rest) = null_vector(0.1 * f64::from(k)).unwrap();
        let forces = [0, 1, 2].map(|n| vector[OF_LEG * n + unknown::FS + 1]);
        for (force, expected) in forces.into_iter().zip([-2.0, 1.0, 1.0]) {
            assert!((force - expected).abs() < 1e-12, "{forces:?}");
        }
        assert!(rest < 1e-12, "{rest}");
    }
}

/// The error of equation (23) as printed is up to 1.1 N on (29), and 8.4 N of 24 N on the motion of
/// the regular variant.
#[test]
fn printed_equation_of_moments() {
    let (error, _) = transverse(&Robot::printed(), Robot::printed_motion, 1000);
    near(error.into_iter().fold(0.0, f64::max), 1.1, 1);
    let (error, of) = transverse(&Robot::regular(), Robot::regular_motion, 1000);
    near(error.into_iter().fold(0.0, f64::max), 8.4, 1);
    near(of.into_iter().fold(0.0, f64::max), 24.0, 0);
}

/// The printed system with minimal repairs has errors of newtons in every unknown.
#[test]
fn printed_system_is_wrong_by_much() {
    for (name, error, of) in printed_errors(&Robot::regular()) {
        assert!(error > 3.0 && error < of, "{name}: {error} of {of}");
    }
}

/// At 90 deg the unbalanced load is the moment about y combined with the moments of the forces
/// about the intersection of the legs; all other loads, a moment about z included, are in the
/// range. Off 90 deg the roll moment contributes.
#[test]
fn range_of_the_equations() {
    let robot = Robot::printed();
    for k in 0..10 {
        let motion = Robot::printed_motion(0.1 * f64::from(k) + 0.03);
        let (null, missed) = out_of_range(&robot, &motion, NO_LOAD).unwrap();
        let [x, z, _] = motion.pose;
        // k / (k - l) = -1/2.
        let expected = [-z / 2.0, 0.0, x / 2.0, 0.0, 1.0, 0.0];
        for (found, expected) in null.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-11, "{null:?}");
        }
        let moment = missing_moment(&robot, &motion, NO_LOAD);
        assert!((missed.abs() - moment.abs()).abs() < 1e-10, "{missed} {moment}");
    }
    let mut motion = Robot::printed_motion(0.13);
    motion.pose[2] = 80.0_f64.to_radians();
    let (null, _) = out_of_range(&robot, &motion, NO_LOAD).unwrap();
    // Result of an independent program, up to the sign: (0.247, 0, 0.014, -0.088, -1, 0.016).
    for (found, published) in null.into_iter().zip([-0.247, 0.0, -0.014, 0.088, 1.0, -0.016]) {
        near(found, published, 3);
    }
}

#[test]
fn engine_has_the_same_unknowns() {
    let model = model("zhang2018-regular").unwrap();
    let job = job(&model, "regular", "L0", FrictionMode::Off).unwrap();
    let run = Run::of(&job, |_, _, _| true).unwrap();
    let (difference, largest) = agreement(&run.samples);
    // Rounding of 150 N at condition numbers up to 180.
    assert!(difference < 5e-12 && largest > 100.0, "{difference} {largest}");
}

/// The equations for single bodies have the same solution.
#[test]
fn single_bodies_have_the_same_solution() {
    let robot = Robot::regular();
    let system = System::new(&robot, &Robot::regular_motion(0.37), NO_LOAD, Form::Corrected);
    let single = system.of_single_bodies(&robot);
    let solve = |s: &System| s.matrix.clone().lu().solve(&s.right).unwrap();
    assert!((solve(&system) - solve(&single)).amax() < 1e-11);
    assert!((&system.matrix - &single.matrix).amax() > 0.1);
}
