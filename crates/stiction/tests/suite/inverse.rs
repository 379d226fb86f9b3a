use super::{FRICTION_ARM, GRAVITY, INERTIA, LENGTH, MASS, pendulum};
use std::f64::consts::TAU;
use std::num::NonZeroUsize;
use stiction::core::joint::JointType;
use stiction::core::spatial::{Mat3, Vec3};
use stiction::{BodySpec, FrictionMode, JointSpec, Robot};

/// Angle, rate and acceleration of the motion `swing`.
fn swing(t: f64) -> [f64; 3] {
    let a = 30f64.to_radians();
    [a * (TAU * t).sin(), a * TAU * (TAU * t).cos(), -a * TAU * TAU * (TAU * t).sin()]
}

#[test]
fn a_pendulum_agrees_with_newton_and_coulomb() {
    let robot = pendulum();
    for sample in robot.inverse().motion("swing").unwrap().step(0.017).samples().unwrap() {
        let sample = sample.unwrap();
        let [angle, rate, acceleration] = swing(sample.time);
        let (sin, cos) = angle.sin_cos();
        let ideal = INERTIA * acceleration + MASS * GRAVITY * LENGTH * sin;
        // Acceleration of the centre of mass, tangential and centripetal.
        let (tangential, radial) = (LENGTH * acceleration, LENGTH * rate * rate);
        let x = MASS * (tangential * cos - radial * sin);
        let y = MASS * (tangential * sin + radial * cos + GRAVITY);
        let load = x.hypot(y);
        let expected = ideal + FRICTION_ARM * load * rate.signum();
        assert!((sample.effort_frictionless("pivot").unwrap() - ideal).abs() < 1e-12);
        assert!((sample.effort("pivot").unwrap() - expected).abs() < 1e-12, "{}", sample.time);
        assert_eq!(sample.efforts(), [sample.effort("pivot").unwrap()]);
        let reaction = sample.reaction("pivot").unwrap();
        assert!(reaction.determined);
        assert!((reaction.force[0] - x).abs() < 1e-11 && (reaction.force[1] - y).abs() < 1e-11);
        let friction = sample.friction("pivot").unwrap();
        assert!((friction.load - load).abs() < 1e-11);
        assert!((friction.force.abs() - 0.1 * load).abs() < 1e-12);
        assert!((friction.power - FRICTION_ARM * load * rate.abs()).abs() < 1e-11);
        let pose = sample.pose("bob").unwrap();
        assert!(
            (pose.rotation[1][0] - sin).abs() < 1e-14 && (pose.rotation[0][1] + sin).abs() < 1e-14
        );
        assert!(sample.power_residual.abs() < 1e-11 && sample.closure_error < 1e-14);
    }
}

#[test]
fn a_robot_built_by_code_is_the_one_in_the_file() {
    let built = Robot::builder("pendulum")
        .gravity([0.0, -GRAVITY, 0.0])
        .body(
            BodySpec::new("bob")
                .mass(MASS)
                .com(Vec3::new(0.0, -LENGTH, 0.0))
                .inertia(Mat3::diagonal(Vec3::new(1e-3, 1e-3, 1e-3))),
        )
        .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "bob").actuated())
        .motion("swing", "pivot = 30 deg*sin(2*pi*t); duration = 2 s")
        .load("wind", "bob.fx = 3 N")
        .build()
        .unwrap();
    let efforts = |robot: &Robot| -> Vec<f64> {
        let request = robot.inverse().friction(FrictionMode::Off).step(0.1);
        request.collect().unwrap().iter().map(|sample| sample.efforts()[0]).collect()
    };
    assert_eq!(efforts(&built), efforts(&pendulum()));
    assert_eq!(built.loads().collect::<Vec<_>>(), ["wind"]);
    // The wind acts at the bob's origin, which is in the pivot: the effort does not change, but the
    // reaction does.
    let mut still = built.inverse().motion("pivot = 0; duration = 0").unwrap();
    let force = |sample: &stiction::Sample| sample.reaction("pivot").unwrap().force[0];
    assert!(force(&still.collect().unwrap()[0]).abs() < 1e-15);
    still = still.load("wind").unwrap();
    assert!((force(&still.collect().unwrap()[0]) + 3.0).abs() < 1e-14);
}

#[test]
fn the_control_loop_gives_the_efforts_of_the_motion() {
    let robot = Robot::builtin("four-bar").unwrap();
    let stiction::ControlLoop { model, mut data, position } = robot.control_loop().unwrap();
    assert_eq!(position.len(), 1);
    let motion = format!("A = {:?} + 0.3*t + 0.2*t^2; duration = 1", position[0]);
    let request = robot.inverse().motion(&motion).unwrap().load("none").unwrap().step(0.05);
    for sample in request.collect().unwrap() {
        let t = sample.time;
        let (q, v, a) = (position[0] + 0.3 * t + 0.2 * t * t, 0.3 + 0.4 * t, 0.4);
        assert!(model.inverse_dynamics(&mut data, &[q], &[v], &[a], &[]).is_converged());
        let (own, other) = (data.efforts()[0], sample.effort("A").unwrap());
        assert!((own - other).abs() < 1e-11 * other.abs().max(1.0), "{t}: {own} {other}");
    }
}

#[test]
fn threads_and_streams_give_the_same_bits() {
    let robot = Robot::builtin("3rps").unwrap();
    let request = robot.inverse().step(0.02);
    let collected = request.collect().unwrap();
    let mut streamed = request.clone().threads(NonZeroUsize::new(3).unwrap()).samples().unwrap();
    let mut count = 0;
    for (sample, other) in streamed.by_ref().zip(&collected) {
        assert_eq!(sample.unwrap().efforts(), other.efforts());
        count += 1;
    }
    assert_eq!(count, collected.len());
    assert!(streamed.next().is_none());
    assert_eq!(streamed.outcome().unwrap().samples, collected.len());
}
