//! Initial states of simulations, from partial data and from the state of another simulation.

use crate::common::simulated::*;
use crate::common::*;
use stiction_core::forward::{
    Checkpoint, ConstantEfforts, Forward, ForwardError, Inputs, Known, Method, Settings, View,
};
use stiction_core::kinematics::{Coordinate, Target};

fn crank(model: &Forward, joint: &str, value: Option<f64>, rate: Option<f64>) -> Known {
    let joint = model.mechanism().joint_id(joint).unwrap();
    Known { coordinate: Coordinate::Joint { joint, dof: 0 }, value, rate }
}

/// Assembles the slider-crank (`l = 0.3`, `r = 0.1`) from a given crank angle and slider speed.
#[test]
fn values_of_one_joint_and_rates_of_another() {
    let model = Forward::new(slider_crank().mechanism, &[]);
    let (angle, speed) = (0.7_f64, -0.4);
    let known = [crank(&model, "A", Some(angle), None), crank(&model, "guide", None, Some(speed))];
    let state = model.assemble_from(&[], &known).unwrap();
    let mut inputs = ConstantEfforts(vec![0.0]);
    let simulation = model.start(0.0, state, Settings::default(), &mut inputs).unwrap();
    let now = simulation.instant();
    let relative = |joint: usize| now.bodies.frame_j[joint].inverse() * now.bodies.frame_k[joint];
    let slide = relative(3).position.norm();
    let (r, l) = (0.1, 0.3);
    let root = (l * l - (r * angle.sin()).powi(2)).sqrt();
    assert!((slide - (r * angle.cos() + root)).abs() < 1e-13, "{slide}");
    let ratio = -r * angle.sin() - r * r * angle.sin() * angle.cos() / root;
    let rate = now.bodies.joint_rates(model.topology(), 0)[0];
    assert!((rate - speed / ratio).abs() < 1e-12, "{rate}");
}

#[test]
fn contradictions_are_named() {
    let model = Forward::new(slider_crank().mechanism, &[]);
    // At a crank angle of 0.7 rad, the slider is at 0.369 m, not at 0.2 m.
    let known = [crank(&model, "A", Some(0.7), None), crank(&model, "guide", Some(0.2), None)];
    let error = model.assemble_from(&[], &known).unwrap_err();
    println!("{error}");
    let ForwardError::Contradiction { rates: false, by, .. } = error else { panic!("{error}") };
    assert!(by > 1e-3);
    let known = [crank(&model, "A", Some(0.7), Some(1.0)), crank(&model, "guide", None, Some(1.0))];
    let error = model.assemble_from(&[], &known).unwrap_err();
    println!("{error}");
    assert!(matches!(error, ForwardError::Contradiction { rates: true, .. }));
    assert!(error.to_string().contains("joint `"));
    let known = [crank(&model, "A", Some(f64::NAN), None)];
    assert!(model.assemble_from(&[], &known).is_err());
}

/// A platform with three DOFs and one given rate. The other rates minimise the kinetic energy.
#[test]
fn open_rates_have_least_kinetic_energy() {
    let robot = symmetric_3rps(None);
    let model = Forward::new(robot.mechanism.clone(), &[]);
    let known: Vec<Known> = robot
        .coordinates
        .iter()
        .zip([(Some(0.55), None), (Some(0.1), Some(0.8)), (Some(-0.05), None)])
        .map(|(&coordinate, (value, rate))| Known { coordinate, value, rate })
        .collect();
    let state = model.assemble_from(&robot.initial_poses, &known).unwrap();
    let energy = |state| {
        let mut inputs = ConstantEfforts(vec![0.0; 3]);
        let simulation = model.start(0.0, state, Settings::default(), &mut inputs).unwrap();
        simulation.instant().account.kinetic
    };
    let least = energy(state.clone());
    let all = |rates: [f64; 3]| {
        let known: Vec<Known> = known
            .iter()
            .zip(rates)
            .map(|(known, rate)| Known { rate: Some(rate), ..*known })
            .collect();
        energy(model.assemble_from(&robot.initial_poses, &known).unwrap())
    };
    let mut smallest = f64::INFINITY;
    for z in -20..=20 {
        for beta in -20..=20 {
            smallest = smallest.min(all([0.02 * f64::from(z), 0.8, 0.1 * f64::from(beta)]));
        }
    }
    println!("{least} {smallest}");
    assert!(least > 0.0 && least <= smallest * (1.0 + 1e-12), "{least} {smallest}");
    assert!(smallest < 1.02 * least, "{least} {smallest}");
}

/// Without given data, a simulation starts at rest from the start coordinates of the model, with
/// closed loops.
#[test]
fn without_data_a_simulation_starts_at_rest() {
    let robot = symmetric_3rps(None);
    let model = Forward::new(robot.mechanism.clone(), &[]);
    let state = model.assemble_from(&robot.initial_poses, &[]).unwrap();
    assert!(state.rates.iter().all(|rate| *rate == 0.0));
    let same = model.assemble(&robot.initial_poses, &robot.coordinates, &level()).unwrap();
    // The start values of this robot close the loops to rounding.
    let apart = state.coordinates.iter().zip(&same.coordinates).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-12);
}

struct Swing;

impl Inputs for Swing {
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        for (k, effort) in efforts.iter_mut().enumerate() {
            *effort = 47.4 + 12.0 * (9.0 * view.time * (1.0 + 0.2 * k as f64)).sin();
        }
    }
}

/// A simulation is interrupted and resumed while interfaces stick and slip; every number must be
/// bitwise identical.
#[test]
fn a_resumed_simulation_is_the_same_bit_by_bit() {
    let (_, model, state) = rubbing_3rps(0.1);
    for method in [Method::Automatic, Method::TimeStepping] {
        let settings = Settings {
            relative: 1e-7,
            absolute: 1e-9,
            method,
            time_step_tolerance: 1e-5,
            ..Settings::default()
        };
        let mut whole = model.start(0.0, state.clone(), settings, &mut Swing).unwrap();
        whole.advance(0.06, &mut Swing).unwrap();
        let saved = whole.checkpoint();
        // Written as text and read again, as with a file.
        let text: Vec<String> = saved.numbers.iter().map(|x| format!("{x:e}")).collect();
        let numbers = text.iter().map(|x| x.parse().unwrap()).collect();
        let read = Checkpoint { numbers, events: saved.events.clone() };
        assert_eq!(read, saved);
        let mut resumed = model.resume(&read, settings).unwrap();
        assert_eq!(resumed.checkpoint(), saved);
        for until in [0.11, 0.4] {
            whole.advance(until, &mut Swing).unwrap();
            resumed.advance(until, &mut Swing).unwrap();
            assert_eq!(whole.checkpoint(), resumed.checkpoint(), "{until}");
        }
        assert!(whole.events().len() > saved.events.len());
        for wrong in [vec![], saved.numbers[1..].to_vec(), [&saved.numbers[..], &[0.0]].concat()] {
            let wrong = Checkpoint { numbers: wrong, events: vec![] };
            assert!(matches!(model.resume(&wrong, settings), Err(ForwardError::Checkpoint)));
        }
    }
}

/// Locks a joint at its initial position.
struct Lock(f64);

impl Inputs for Lock {
    fn efforts(&mut self, _view: &View<'_>, _efforts: &mut [f64]) {}
    fn targets(&mut self, _time: f64, targets: &mut [Target<f64>]) {
        targets[0] = Target { value: self.0, rate: 0.0, acceleration: 0.0 };
    }
}

/// The rod's pin is locked, so nothing can move. The simulation drops the given rate and reports
/// this; a rate of the order of rounding counts as rest.
#[test]
fn a_forbidden_rate_is_reported_and_dropped() {
    let mechanism = slider_crank().mechanism;
    let pin = mechanism.joint_id("B").unwrap();
    let mechanism = mechanism.with_actuator(pin, 0);
    let is_pin = |actuator: &(stiction_core::mechanism::JointId, usize)| actuator.0 == pin;
    let lock = mechanism.actuators().position(|actuator| is_pin(&actuator)).unwrap();
    let model = Forward::new(mechanism, &[lock]);
    let known = [crank(&model, "A", Some(0.5), Some(3.0))];
    let state = model.assemble_from(&[], &known).unwrap();
    let free = Forward::new(model.mechanism().clone(), &[]);
    let mut nothing = ConstantEfforts(vec![0.0; 2]);
    let asked = free.start(0.0, state.clone(), Settings::default(), &mut nothing).unwrap();
    assert!(asked.dropped() < 1e-12, "{}", asked.dropped());
    let now = asked.instant();
    let angle = model.joint_coordinate(&now.state, &now.bodies, pin, 0);
    let simulation = model.start(0.0, state, Settings::default(), &mut Lock(angle)).unwrap();
    assert!((simulation.dropped() - 1.0).abs() < 1e-12, "{}", simulation.dropped());
    assert_eq!(simulation.interfaces().len(), 4);
    for interface in simulation.interfaces() {
        // One interface may be at its friction limit, while the lock carries the remaining load.
        assert!(
            !matches!(interface, stiction_core::forward::InterfaceMode::Slides(_)),
            "{interface:?}"
        );
    }
    assert_eq!(simulation.instant().mobility, 0);
}

/// A screw in a loop: a nut on a guide, its spindle on a bearing. The actuator turns the spindle in
/// the nut. Regardless of which joint is cut, the coordinate of the actuator follows from the
/// advance of the screw, beyond full turns.
#[test]
fn a_screw_that_closes_a_loop_counts_its_turns() {
    use stiction_core::joint::JointType;
    use stiction_core::mechanism::{BodySpec, JointSpec, MechanismBuilder};
    use stiction_core::topology::TreeRule;
    let angle = 4.0 * std::f64::consts::PI + 0.3;
    let body = |name: &str| BodySpec::new(name).mass(1.0).inertia(diagonal(0.01, 0.01, 0.01));
    let mechanism = MechanismBuilder::new("screw")
        .gravity(v(0.0, 0.0, -9.81))
        .body(body("nut"))
        .body(body("spindle"))
        .joint(JointSpec::new("guide", JointType::Prismatic, "ground", "nut").start([2e-3 * angle]))
        .joint(JointSpec::new("bearing", JointType::Revolute, "ground", "spindle").start([-angle]))
        .joint(
            JointSpec::new("thread", JointType::Helical, "spindle", "nut")
                .pitch(2e-3)
                .start([angle])
                .actuated(),
        )
        .build()
        .unwrap();
    struct Look(f64);
    impl Inputs for Look {
        fn efforts(&mut self, view: &View<'_>, _efforts: &mut [f64]) {
            self.0 = view.actuator_coordinate(0);
        }
    }
    let thread = mechanism.joint_id("thread").unwrap();
    let mut cut = 0;
    for seed in 0..12 {
        let model = Forward::with_tree(mechanism.clone(), TreeRule::Random(seed), &[]);
        let state = model.assemble_from(&[], &[]).unwrap();
        let mut look = Look(f64::NAN);
        let simulation = model.start(0.0, state, Settings::default(), &mut look).unwrap();
        let now = simulation.instant();
        // If the thread is cut, the tree has two DOFs: a slide and a rotation of about minus
        // `angle`.
        let turns = now.state.coordinates.iter().filter(|q| (**q + angle).abs() < 1e-9).count();
        cut += usize::from(turns == 1 && now.state.coordinates.len() == 2);
        assert!((look.0 - angle).abs() < 1e-9, "{seed}: {} {angle}", look.0);
        let own = model.joint_coordinate(&now.state, &now.bodies, thread, 0);
        assert!((look.0 - own).abs() < 1e-12);
    }
    assert!(cut > 0);
}
