//! Errors of callers: each error is reported and leaves the state unchanged.

use stiction_core::dynamics::{AppliedLoad, InverseDynamics, InverseError, LoadAxes, Settings};
use stiction_core::forward::{self, ConstantEfforts, Forward, ForwardError};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{AssemblyError, Coordinate, State, Target};
use stiction_core::mechanism::{BodyId, BodySpec, JointId, JointSpec, MechanismBuilder};
use stiction_core::spatial::{Pose, Vec3};

fn at(value: f64) -> Target<f64> {
    Target { value, rate: 0.0, acceleration: 0.0 }
}

/// A crank of 0.1 m drives a rocker of 0.3 m through a rod of 0.3 m, with the bases 0.4 m apart.
fn four_bar() -> Result<InverseDynamics, Box<dyn std::error::Error>> {
    let bar = |name: &str| BodySpec::new(name).mass(1.0).com(Vec3::new(0.1, 0.0, 0.0));
    let x = |x| Pose::at(Vec3::new(x, 0.0, 0.0));
    let pin =
        |name: &str, from: &str, to: &str| JointSpec::new(name, JointType::Revolute, from, to);
    let mechanism = MechanismBuilder::new("four-bar")
        .gravity(Vec3::new(0.0, -9.81, 0.0))
        .body(bar("crank"))
        .body(bar("rod"))
        .body(bar("rocker"))
        .joint(pin("base", "ground", "crank"))
        .joint(pin("rocker", "ground", "rocker").frames(x(0.4), x(0.0)).actuated().start([2.0]))
        .joint(pin("near", "crank", "rod").frames(x(0.1), x(0.0)))
        .joint(pin("far", "rod", "rocker").frames(x(0.3), x(0.3)))
        .build()?;
    let angle = Coordinate::Joint { joint: JointId(1), dof: 0 };
    Ok(InverseDynamics::new(mechanism, &[], &[angle], &[at(2.0)], Settings::default())?)
}

/// One error contains all defects, each on its own line.
#[test]
fn all_defects_are_one_error() {
    let built = MechanismBuilder::new("x")
        .body(BodySpec::new("a").mass(-1.0))
        .joint(JointSpec::new("j", JointType::Revolute, "ground", "b"))
        .build();
    let defects = built.unwrap_err();
    assert_eq!(defects.len(), 2);
    let text = defects.to_string();
    assert_eq!(text.lines().count(), 2);
    assert!(text.contains("`a`") && text.contains("`b`"), "{text}");
}

/// After an unreachable configuration, the solver is in its previous state, with the same forces to
/// the last digit.
#[test]
fn a_failed_move_keeps_the_state() {
    let mut solver = four_bar().unwrap();
    let state = solver.state().clone();
    let drive = solver.solve(&[]).unwrap().efforts[0];
    // With the rocker turned away from the crank, the rod is too short.
    assert!(matches!(solver.move_to(&[at(0.0)]), Err(AssemblyError::Gap(_))));
    assert_eq!(solver.state().coordinates, state.coordinates);
    assert!(solver.closure_error() < 1e-12);
    let again = solver.solve(&[]).unwrap().efforts[0];
    assert!((again - drive).abs() < 1e-12 * drive.abs(), "{again} {drive}");
    assert!(solver.move_to(&[at(2.05)]).is_ok());
}

/// Values that are not finite are reported as such.
#[test]
fn values_that_are_not_finite_are_reported() {
    let mut solver = four_bar().unwrap();
    let target = Target { rate: f64::NAN, ..at(2.0) };
    assert_eq!(solver.move_to(&[target]), Err(AssemblyError::NotFinite { index: 0 }));
    let zero = Vec3::new(0.0, 0.0, 0.0);
    let force = Vec3::new(f64::INFINITY, 0.0, 0.0);
    let (body, axes) = (BodyId(2), LoadAxes::World);
    let load = AppliedLoad { body, point: zero, axes, force, moment: zero };
    let told = InverseError::NotFinite { body: "rod".to_owned() };
    assert_eq!(solver.solve(&[load]).unwrap_err(), told);
}

/// A motion needs finite start and end times.
#[test]
fn times_that_are_not_finite_are_reported() {
    let mut solver = four_bar().unwrap();
    for (from, to) in [(0.0, f64::NAN), (f64::NAN, 1.0), (0.0, f64::INFINITY), (-1e308, 1e308)] {
        let told = solver.follow(from, to, |_, targets| targets[0] = at(2.0)).unwrap_err();
        assert!(matches!(told, AssemblyError::NoTime { .. }), "{told}");
    }
    // Intermediate targets are checked as well.
    let told = solver.follow(0.0, 1.0, |t, targets| targets[0] = at(2.0 + t / 0.0)).unwrap_err();
    assert_eq!(told, AssemblyError::NotFinite { index: 0 });
    // Halving of steps ends where time cannot be resolved further: the motion jumps at one instant.
    let mut solver = four_bar().unwrap();
    let jump =
        |t: f64, targets: &mut [Target<f64>]| targets[0] = at(if t > 1e17 { 2.5 } else { 2.0 });
    assert!(solver.follow(1e17, 1e17 + 64.0, jump).is_err());
    let mut solver = four_bar().unwrap();
    let jump =
        |t: f64, targets: &mut [Target<f64>]| targets[0] = at(if t > 0.0 { 2.5 } else { 2.0 });
    assert!(solver.follow(0.0, 1e-322, jump).is_err());
}

#[test]
#[should_panic(expected = "expected 1 targets, one for each prescribed coordinate, but found 2")]
fn excess_targets_are_reported() {
    let _ = four_bar().unwrap().move_to(&[at(2.0), at(2.0)]);
}

#[test]
#[should_panic(expected = "a load refers to BodyId(9), but the mechanism has 4 bodies")]
fn an_unknown_body_is_reported() {
    let zero = Vec3::new(0.0, 0.0, 0.0);
    let (body, axes) = (BodyId(9), LoadAxes::Body);
    let load = AppliedLoad { body, point: zero, axes, force: zero, moment: zero };
    let _ = four_bar().unwrap().solve(&[load]);
}

/// Creates a free pendulum.
fn pendulum() -> Forward {
    let spec = JointSpec::new("pin", JointType::Revolute, "ground", "bar");
    let body = BodySpec::new("bar").mass(1.0).com(Vec3::new(0.5, 0.0, 0.0));
    Forward::new(MechanismBuilder::new("pendulum").body(body).joint(spec).build().unwrap(), &[])
}

#[test]
fn a_start_that_is_not_finite_is_reported() {
    let model = pendulum();
    let start =
        |state| model.start(0.0, state, forward::Settings::default(), &mut ConstantEfforts(vec![]));
    let still = State::new(model.topology());
    assert!(start(still.clone()).is_ok());
    for place in 0..2 {
        let mut state = still.clone();
        [&mut state.coordinates, &mut state.rates][place][0] = f64::NAN;
        assert!(matches!(start(state), Err(ForwardError::NotFinite { .. })));
    }
}

#[test]
#[should_panic(
    expected = "[0, 0, 0] coordinates, rates and accelerations for a tree that has [1, 1, 1]"
)]
fn a_state_of_another_mechanism_is_reported() {
    let nothing = State { coordinates: vec![], rates: vec![], accelerations: vec![] };
    let settings = forward::Settings::default();
    let _ = pendulum().start(0.0, nothing, settings, &mut ConstantEfforts(vec![]));
}

/// Errors can be sent between threads and boxed.
#[test]
fn errors_are_errors() {
    fn is_error<E: std::error::Error + Send + Sync + Clone + 'static>() {}
    is_error::<stiction_core::mechanism::Defects>();
    is_error::<stiction_core::mechanism::Defect>();
    is_error::<AssemblyError>();
    is_error::<InverseError>();
    is_error::<stiction_core::forward::ForwardError>();
}
