use super::{FRICTION_ARM, GRAVITY, INERTIA, LENGTH, MASS, pendulum};
use stiction::{EventKind, Method, Robot};

#[test]
fn a_frictionless_pendulum_keeps_its_energy() {
    let robot = pendulum();
    let run = robot
        .forward()
        .at("pivot", 1.0)
        .unwrap()
        .friction(false)
        .until(5.0)
        .step(0.1)
        .run()
        .unwrap();
    assert!(run.ended().is_ok());
    assert_eq!(run.samples().len(), 51);
    let start = &run.samples()[0];
    assert_eq!((start.position("pivot").unwrap(), start.rate("pivot").unwrap()), (1.0, 0.0));
    for sample in run.samples() {
        let (angle, rate) = (sample.position("pivot").unwrap(), sample.rate("pivot").unwrap());
        let kinetic = 0.5 * INERTIA * rate * rate;
        let potential = MASS * GRAVITY * LENGTH * (1f64.cos() - angle.cos());
        assert!((kinetic + potential).abs() < 1e-8, "{} {}", sample.time, kinetic + potential);
        assert!((sample.kinetic_energy - kinetic).abs() < 1e-12);
        let acceleration = sample.joint("pivot").unwrap().acceleration;
        assert!((INERTIA * acceleration + MASS * GRAVITY * LENGTH * angle.sin()).abs() < 1e-9);
    }
}

#[test]
fn a_pendulum_with_friction_comes_to_rest_and_its_energy_is_accounted_for() {
    let robot = pendulum();
    let run = robot.forward().at("pivot", 0.1).unwrap().until(20.0).run().unwrap();
    let last_event = run.events().last().unwrap();
    assert!(matches!(last_event.kind, EventKind::Sticks { .. }));
    assert_eq!(last_event.at, "pivot");
    let last = run.last().unwrap();
    assert_eq!(last.rate("pivot").unwrap(), 0.0);
    let friction = last.friction("pivot").unwrap();
    assert!(friction.sticks && friction.force[0].abs() <= friction.limit);
    // At rest, friction balances the moment of the weight.
    let moment = MASS * GRAVITY * LENGTH * last.position("pivot").unwrap().sin();
    assert!((friction.force[0].abs() * 8e-3 - moment.abs()).abs() < 1e-12);
    assert!(moment.abs() <= FRICTION_ARM * MASS * GRAVITY);
    let lost = run.samples()[0].mechanical_energy() - last.mechanical_energy();
    assert!((last.dissipated("pivot").unwrap() - lost).abs() < 1e-9);
    assert!(last.energy_error.abs() < 1e-9);
}

#[test]
fn rates_and_positions_at_the_start_are_independent() {
    let robot = pendulum();
    let request = robot.forward().friction(false).until(0.0);
    let first = |request: stiction::Forward| {
        let run = request.run().unwrap();
        let sample = &run.samples()[0];
        (sample.position("pivot").unwrap(), sample.rate("pivot").unwrap())
    };
    assert_eq!(first(request.clone().rate("pivot", 2.0).unwrap()), (0.0, 2.0));
    let both = request.clone().rate("pivot", 2.0).unwrap().at("pivot", 0.5).unwrap();
    assert_eq!(first(both), (0.5, 2.0));
    let text = request.from("pivot = 0.5 + 2*t").unwrap();
    assert_eq!(first(text), (0.5, 2.0));
}

#[test]
fn a_locked_joint_is_held_by_an_effort_with_its_name() {
    let robot = Robot::builtin("slider-crank").unwrap();
    let crank = robot.actuators().next().unwrap().to_owned();
    let run = robot
        .forward()
        .drives(&format!("{crank} = 0"))
        .unwrap()
        .at(&crank, 1.0)
        .unwrap()
        .hold(robot.joints().last().unwrap())
        .unwrap()
        .until(0.5)
        .run()
        .unwrap();
    let (first, last) = (&run.samples()[0], run.last().unwrap());
    assert_eq!(first.position(&crank).unwrap(), last.position(&crank).unwrap());
    assert!(last.effort(robot.joints().last().unwrap()).unwrap().abs() > 0.0);
    assert_eq!(last.effort(&crank).unwrap(), 0.0);
}

#[test]
fn both_schemes_agree_on_a_swing() {
    let robot = pendulum();
    let request = robot.forward().at("pivot", 0.5).unwrap().until(1.0).step(0.5);
    let end = |method| {
        let run = request.clone().method(method).run().unwrap();
        run.last().unwrap().position("pivot").unwrap()
    };
    assert!((end(Method::EventDriven) - end(Method::TimeStepping)).abs() < 1e-4);
}

/// With prescribed actuators, a delta robot has only the passive rotations of its rods, so friction
/// does not change the velocities of its other joints. Time stepping and inverse dynamics compute
/// the same efforts.
#[test]
fn prescribed_actuators_need_the_efforts_of_inverse_dynamics() {
    let robot = Robot::builtin("delta").unwrap();
    let names = ["leg1.R", "leg2.R", "leg3.R"];
    let mut request = robot.forward().method(Method::TimeStepping).until(0.06).step(0.02);
    for name in names {
        request = request.prescribe(name).unwrap();
    }
    let run = request.run().unwrap();
    assert!(run.ended().is_ok());
    let inverse: Vec<_> =
        robot.inverse().step(0.02).samples().unwrap().take(4).map(Result::unwrap).collect();
    // Friction changes these efforts by 4 %. Those of time stepping are averages over steps of some
    // milliseconds. At the first instant the robot is at rest, and its efforts are not unique.
    for (found, expected) in run.samples().iter().zip(&inverse).skip(1) {
        for name in names {
            let (found, expected) = (found.effort(name).unwrap(), expected.effort(name).unwrap());
            assert!((found - expected).abs() < 1e-2 * expected.abs(), "{found} {expected}");
        }
    }
}

/// If a prescribed motion pauses, the joints come to rest and friction holds them, instead of
/// acting as if the joints continued to slide in the last direction.
#[test]
fn joints_stick_while_a_prescribed_motion_pauses() {
    // A cart on a slope of 0.1 rad, moved through its mass centre.
    let cart = r#"
        gravity = ["-9.81 m/s^2*sin(0.1)", 0, "-9.81 m/s^2*cos(0.1)"]
        bodies.cart = { mass = "2 kg", com = [0, 0, 0], inertia = [0.01, 0.01, 0.01] }
        [joints.g]
        type = "P"
        from = "ground"
        to = "cart"
        axis = "x"
        actuated = true
        friction = { mu = 0.2 }
        [motions.go]
        law = "quintic"
        waypoints = [{ g = 0 }, { at = "1 s", g = "100 mm" }, { at = "2 s", g = "100 mm" }, { at = "3 s", g = 0 }]
    "#;
    let robot = Robot::parse(cart).unwrap();
    let run = robot.forward().prescribe("g").unwrap().step(0.25).run().unwrap();
    let (weight, load) = (2.0 * 9.81 * 0.1_f64.sin(), 2.0 * 9.81 * 0.1_f64.cos());
    let effort = |index: usize| run.samples()[index].effort("g").unwrap();
    for index in [5, 6, 7] {
        let friction = run.samples()[index].friction("g").unwrap();
        assert!(friction.sticks, "{index}");
        // The motor alone can hold the cart, and the rule of least static friction selects this
        // solution.
        assert!((effort(index) - weight).abs() < 1e-12, "{}", effort(index));
    }
    // Half-way through both moves the acceleration is zero.
    assert!((effort(2) - weight - 0.2 * load).abs() < 1e-9, "{}", effort(2));
    assert!((effort(10) - weight + 0.2 * load).abs() < 1e-9, "{}", effort(10));
    let times = |wanted: fn(&EventKind) -> bool| -> Vec<f64> {
        run.events().iter().filter(|event| wanted(&event.kind)).map(|event| event.time).collect()
    };
    let sticks = times(|kind| matches!(kind, EventKind::Sticks { .. }));
    let slides = times(|kind| matches!(kind, EventKind::Slides { .. }));
    assert!(sticks.len() == 2 && (sticks[0] - 1.0).abs() < 1e-9, "{sticks:?}");
    assert!(slides.last().is_some_and(|time| (time - 2.0).abs() < 1e-3), "{slides:?}");

    // Joints that follow through a loop come to rest with the prescribed joint.
    let source = stiction::gallery::get("slider-crank").unwrap();
    let motion = r#"
        [motions.pause]
        law = "quintic"
        waypoints = [{ A = 1 }, { at = "1 s", A = 2 }, { at = "2 s", A = 2 }, { at = "3 s", A = 1 }]
    "#;
    let robot = Robot::parse(&format!("{source}{motion}")).unwrap();
    let request = robot.forward().motion("pause").unwrap().prescribe("A").unwrap();
    let run = request.step(0.25).run().unwrap();
    for index in [5, 6, 7] {
        for joint in ["A", "B", "C", "guide"] {
            let friction = run.samples()[index].friction(joint).unwrap();
            assert!(friction.sticks, "{joint} at sample {index}");
        }
    }
    assert!(!run.samples()[10].friction("B").unwrap().sticks);
}

/// A simulation that resumes after any of its samples, also after the last one, has the outcome of
/// one that was not interrupted. Interrupted again before its next sample, it keeps its checkpoint.
#[test]
fn a_simulation_resumes_after_any_sample() {
    let robot = pendulum();
    // The pendulum sticks at its second reversal, at 2.7 s.
    let plan = |until: f64| {
        let request = robot.forward().at("pivot", 0.02).unwrap().step(0.03).until(until);
        request.plan().unwrap()
    };
    let run = robot.forward().at("pivot", 0.02).unwrap().until(10.0).run().unwrap();
    let reversals: Vec<f64> = run.events().iter().map(|event| event.time).collect();
    assert!(!reversals.is_empty());
    // Ends close after an event and between events.
    for until in [reversals[0] + 1e-9, reversals[0] + 0.11, reversals[0] * 0.7] {
        let plan = plan(until);
        let mut checkpoints = Vec::new();
        let whole = plan
            .record(
                |_, checkpoint| {
                    checkpoints.push(checkpoint());
                    Ok(())
                },
                &|| false,
                None,
            )
            .unwrap();
        assert_eq!(checkpoints.len(), whole.samples);
        for checkpoint in &checkpoints {
            let resumed = plan.record(|_, _| Ok(()), &|| false, Some(checkpoint)).unwrap();
            assert_eq!(resumed.samples, whole.samples);
            assert_eq!(resumed.events, whole.events);
            assert_eq!(resumed.evaluations, whole.evaluations);
            assert_eq!(resumed.coarsest, whole.coarsest);
            assert_eq!(resumed.last, whole.last);
            let polls = std::cell::Cell::new(0);
            let is_stopped = || polls.replace(polls.get() + 1) > 0;
            let cut = plan.record(|_, _| Ok(()), &is_stopped, Some(checkpoint)).unwrap();
            assert!(cut.checkpoint.as_ref() == Some(checkpoint));
        }
    }
}

/// The same for a robot whose controller has so many samples that a program is recorded.
#[test]
fn a_simulation_by_a_recorded_program_resumes_after_any_sample() {
    let robot = Robot::builtin("3rps").unwrap();
    let request = robot.forward().controller("type = pd; period = 0.1 ms").unwrap();
    let plan = request.step(0.03).until(0.21).plan().unwrap();
    let mut checkpoints = Vec::new();
    let record = |ends: &mut Vec<_>, from: Option<&_>| {
        plan.record(
            |_, checkpoint| {
                ends.push(checkpoint());
                Ok(())
            },
            &|| false,
            from,
        )
        .unwrap()
    };
    let whole = record(&mut checkpoints, None);
    let last = checkpoints.last().unwrap();
    for checkpoint in &checkpoints {
        let mut ends = Vec::new();
        let resumed = record(&mut ends, Some(checkpoint));
        assert_eq!(resumed.events, whole.events);
        assert_eq!(resumed.evaluations, whole.evaluations);
        assert!(ends.last().is_none_or(|end| end == last));
    }
}
