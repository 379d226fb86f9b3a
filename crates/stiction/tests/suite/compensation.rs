//! Friction compensation: tracking errors of control laws compared with closed forms, and the
//! improvement by compensation.

use stiction::{Compensator, Robot, Transition};

const OMEGA: f64 = std::f64::consts::TAU * 5.0;
const MU: f64 = 0.2;
const GRAVITY: f64 = 9.81;

/// Final tracking error of each law.
fn errors(known_to: f64) -> Vec<f64> {
    let robot = Robot::parse(include_str!("../../examples/carriage.toml")).unwrap();
    let compensation = robot.compensation().motion("guide = 0.1 m/s*t; duration = 1 s");
    let compared = compensation.known_to(known_to, 3).run().unwrap();
    assert_eq!(compared.laws.len(), 5);
    let last = |law: &stiction::LawResult| {
        assert!(law.ended.is_none());
        law.errors.last().unwrap().1[0]
    };
    compared.laws.iter().map(last).collect()
}

/// At constant speed, the proportional part `m omega^2 e` balances the friction `mu m g`.
#[test]
fn a_carriage_lags_by_its_friction() {
    let lag = MU * GRAVITY / (OMEGA * OMEGA);
    let [pd, pd_constant, torque, constant, friction] = errors(0.0)[..] else { panic!("5 laws") };
    // After a second, the transient of the critically damped loop is exp(-31) times thirty.
    assert!((pd / lag - 1.0).abs() < 1e-9 && (torque / lag - 1.0).abs() < 1e-9, "{pd} {torque}");
    // Constant friction is exact here, and so is that of the model.
    for error in [pd_constant, constant, friction] {
        assert!(error.abs() < 1e-9 * lag, "{error}");
    }
    let wrong = errors(0.1);
    let relative = (wrong[4] / lag).abs();
    assert!(relative > 1e-4 && relative <= 0.1 * (1.0 + 1e-9), "{relative}");
    assert!((wrong[2] / lag - 1.0).abs() < 1e-9);
}

/// At constant speed, a tanh of the rate over the largest rate leaves the fraction 1 - tanh(1) of
/// the friction.
#[test]
fn a_wide_tanh_leaves_friction_at_full_speed() {
    let lag = MU * GRAVITY / (OMEGA * OMEGA);
    let robot = Robot::parse(include_str!("../../examples/carriage.toml")).unwrap();
    let laws = [Compensator::ComputedTorque, Compensator::ComputedTorqueFriction];
    let transitions = [Transition::Sign, Transition::Fade, Transition::Tanh(1.0)];
    let compared = robot
        .compensation()
        .motion("guide = 0.1 m/s*t; duration = 1 s")
        .known_to(0.0, 1)
        .laws(&laws)
        .transitions(&transitions)
        .run()
        .unwrap();
    let last = |law: &stiction::LawResult| law.errors.last().unwrap().1[0];
    let [torque, sign, fade, tanh] = &compared.laws[..] else { panic!("{compared}") };
    assert!((last(torque) / lag - 1.0).abs() < 1e-9);
    assert!(last(sign).abs() < 1e-9 * lag && last(fade).abs() < 1e-9 * lag);
    assert!((last(tanh) / lag - (1.0 - 1.0_f64.tanh())).abs() < 1e-9, "{}", last(tanh) / lag);
    assert!(compared.to_string().contains("tanh 100%"));
    let head = compared.errors_csv().lines().next().unwrap().to_owned();
    assert!(head.contains("computed-torque+friction tanh 100%: guide"), "{head}");
}

/// With coefficients known to 10 %, the tracking error of the default robot is at least five times smaller
/// than that of computed torque without friction, and smaller than with constant friction.
#[test]
fn friction_of_the_model_reduces_the_error() {
    let robot = Robot::builtin("zhang2018-regular").unwrap();
    let laws = [
        Compensator::ComputedTorque,
        Compensator::ComputedTorqueCoulomb,
        Compensator::ComputedTorqueFriction,
    ];
    let compared = robot.compensation().laws(&laws).run().unwrap();
    let better = |than| compared.ratio(than, Compensator::ComputedTorqueFriction).unwrap();
    assert!(better(laws[0]) > 5.0 && better(laws[1]) > 2.0, "{compared}");
    let rows = compared.errors_csv();
    assert_eq!(rows.lines().count(), compared.laws[0].errors.len() + 1);
    assert!(rows.lines().all(|line| line.split(',').count() == 10));
}

/// Equal options produce bitwise equal numbers; another seed produces others.
#[test]
fn comparisons_are_reproducible() {
    let robot = Robot::builtin("slider-crank").unwrap();
    let rows = |seed| {
        let base = robot.compensation().laws(&[Compensator::ComputedTorqueFriction]);
        base.known_to(0.1, seed).sensors(1e-4, 1e-5).run().unwrap().errors_csv()
    };
    assert_eq!(rows(1), rows(1));
    assert_ne!(rows(1), rows(2));
}

/// Impossible options are rejected, and the message names the option.
#[test]
fn impossible_options_are_refused() {
    let robot = Robot::builtin("slider-crank").unwrap();
    let base = || robot.compensation();
    for (request, option) in [
        (base().period(0.0), "period"),
        (base().bandwidth(f64::NAN), "bandwidth"),
        (base().bandwidth(200.0), "bandwidth"),
        (base().known_to(1.0, 1), "known-to"),
        (base().sensors(-1.0, 0.0), "resolution"),
        (base().sensors(0.0, f64::INFINITY), "noise"),
        (base().delay(10.0), "delay"),
        (base().laws(&[]), "controller"),
        (base().transitions(&[]), "transition"),
        (base().transitions(&[Transition::Tanh(f64::NAN)]), "transition"),
    ] {
        assert_eq!(request.run().unwrap_err().option(), Some(option));
    }
    assert!(base().motion("nonsense").run().is_err());
}

/// The progress covers all simulations: its amount grows from law to law up to nearly all samples.
#[test]
fn progress_counts_the_samples_of_all_laws() {
    let robot = Robot::parse(include_str!("../../examples/carriage.toml")).unwrap();
    let compensation = robot.compensation().motion("guide = 0.1 m/s*t; duration = 0.2 s");
    let calls = std::cell::RefCell::new(Vec::new());
    let receive = |step: &str, done: usize, of: usize| {
        if step == "simulating the controllers" {
            calls.borrow_mut().push((done, of));
        }
    };
    compensation
        .laws(&[Compensator::Pd, Compensator::ComputedTorqueFriction])
        .run_with(&receive)
        .unwrap();
    let calls = calls.into_inner();
    assert!(calls.len() > 100);
    assert!(calls.iter().all(|(done, of)| *of == 400 && done <= of), "{:?}", calls.last());
    assert!(calls.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    assert!(calls.last().unwrap().0 > 395, "{:?}", calls.last());
}
