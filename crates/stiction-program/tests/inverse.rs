//! Programs against the general solver that they were recorded from.

use stiction::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, Settings};
use stiction::kinematics::Target;
use stiction_model::{Model, Source, gallery, read};
use stiction_program::InverseProgram;

struct Robot {
    solver: InverseDynamics,
    course: Vec<Vec<Target<f64>>>,
    loads: Vec<AppliedLoad<f64>>,
}

fn model(name: &str) -> Model {
    let text = gallery::get(name).unwrap();
    read(&Source::new(name, text), &|_| Err("no files".into())).unwrap()
}

fn robot(name: &str, load: Option<&str>) -> Robot {
    let model = model(name);
    let motion = model.motion(model.default_motion.as_deref().unwrap()).unwrap();
    let load = model.load(load.or(model.default_load.as_deref()).unwrap()).unwrap();
    let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
    let course: Vec<Vec<_>> =
        (0..10).map(|k| motion.at(0.1 * (f64::from(k) + 0.37) * motion.duration).collect()).collect();
    let solver = InverseDynamics::new(
        model.mechanism.clone(),
        &model.homes,
        &coordinates,
        &course[0],
        Settings::default(),
    )
    .unwrap();
    let loads = load.at(0.1).collect();
    Robot { solver, course, loads }
}

/// The largest differences between a program and the solver along the course: without friction, with,
/// relative to the largest force; moments over the characteristic length.
fn compare(robot: &mut Robot, program: &InverseProgram) -> f64 {
    let (drives, joints, contacts) = program.sizes();
    let length = robot.solver.mechanism().characteristic_length();
    let mut memory = program.memory(1);
    let mut worst = 0.0_f64;
    let mut settled = [false];
    for targets in robot.course.clone() {
        robot.solver.move_to(&targets).unwrap();
        robot.solver.settings_mut().friction = FrictionMode::Converged;
        let forces = robot.solver.solve(&robot.loads).unwrap().clone();
        let state = robot.solver.assembly().state();
        program.set(&mut memory, 0, state, &targets, &robot.loads);
        program.run_frictionless(&mut memory, &mut settled);
        assert!(settled[0]);
        let ideal: Vec<f64> = (0..drives).map(|k| program.ideal_drive(&memory, 0, k)).collect();
        program.run(&mut memory, &mut settled);
        assert!(settled[0]);
        let scale = forces.reactions.iter().map(|(f, _)| f.norm()).fold(1e-300, f64::max);
        let mut differs = |found: f64, expected: f64, unit: f64| {
            worst = worst.max((found - expected).abs() / (scale * unit));
        };
        for drive in 0..drives {
            let found = program.drive(&memory, 0, drive);
            differs(found, forces.drives[drive], length.max(1.0));
            differs(ideal[drive], forces.drives_frictionless[drive], length.max(1.0));
        }
        for joint in 0..joints {
            let found = program.reaction(&memory, 0, joint);
            let (force, moment) = forces.reactions[joint];
            for i in 0..3 {
                differs(found[i], force.to_array()[i], 1.0);
                differs(found[3 + i], moment.to_array()[i], length);
            }
        }
        for contact in 0..contacts {
            let [load, velocity, friction] = program.contact(&memory, 0, contact);
            let expected = &forces.contacts[contact];
            differs(load, expected.load, 1.0);
            differs(friction, expected.limit, 1.0);
            assert!((velocity - expected.velocity).abs() < 1e-12);
        }
    }
    worst
}

#[test]
fn programs_are_their_solvers() {
    for (name, load) in [
        ("3rps", None),
        ("zhang2018-regular", Some("L1")),
        ("gough", None),
        ("delta", None),
        ("4ups-upu", None),
    ] {
        let mut robot = robot(name, load);
        for machine in [false, true] {
            let course = robot.course.clone();
            let Some(program) = InverseProgram::record_with(&robot.solver, &course, &robot.loads, machine) else { println!("{name}: none"); continue };
            let worst = compare(&mut robot, &program);
            println!("{name} machine {machine} {} ops {:?}: {worst:e}", program.is_machine_code(), program.operations());
            assert!(worst < 1e-11, "{name}: {worst}");
        }
    }
}
