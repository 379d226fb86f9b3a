//! The nonsmooth time stepper: closed forms, no drift, reported jumps, order of convergence.

use crate::common::simulated::*;
use crate::common::*;
use stiction_core::forward::{
    ConstantEfforts, EventKind, Forward, InterfaceMode as Doing, Method, Settings, Simulation,
};
use stiction_core::friction::{Curve, JointFriction};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{State, Target};
use stiction_core::mechanism::{BodySpec, JointSpec, Mechanism, MechanismBuilder, SpringSpec};
use stiction_core::spatial::Vec3;

fn in_steps(tolerance: f64) -> Settings {
    let method = Method::TimeStepping;
    Settings { method, time_step_tolerance: tolerance, longest_step: 10.0, ..Settings::default() }
}

fn jumps(simulation: &Simulation<'_>) -> usize {
    simulation.events().iter().filter(|e| matches!(e.kind, EventKind::Jump { .. })).count()
}

/// Creates the mass of reference R6: 1 kg on a table, friction 0.981 N, a spring of 100 N/m.
fn mass_and_spring(interface: JointFriction) -> Mechanism {
    let x = along(Vec3::zero(), Vec3::unit(0));
    MechanismBuilder::new("mass")
        .gravity(v(0.0, -9.81, 0.0))
        .body(BodySpec::new("block").mass(1.0).inertia(diagonal(0.1, 0.1, 0.1)))
        .joint(
            JointSpec::new("table", JointType::Prismatic, "ground", "block")
                .frames(x, x)
                .friction(interface),
        )
        .spring(
            SpringSpec::new("spring", "ground", "block")
                .points(v(-1.0, 0.0, 0.0), Vec3::zero())
                .stiffness(100.0, 1.0),
        )
        .build()
        .unwrap()
}

/// Runs a simulation for two seconds; the mass is released with the spring stretched by 0.1 m.
fn let_go(model: &Forward, tolerance: f64) -> Simulation<'_> {
    let mut inputs = ConstantEfforts(vec![]);
    let mut state = State::new(model.topology());
    state.coordinates[0] = 0.1;
    let mut simulation = model.start(0.0, state, in_steps(tolerance), &mut inputs).unwrap();
    simulation.advance(2.0, &mut inputs).unwrap();
    simulation
}

/// R6: the mass stops after five half-cycles at -0.0019 m and has dissipated 0.4998195 J. The error
/// decreases with the step, which is proportional to the square root of the tolerance.
#[test]
fn r6_stops_as_in_closed_form() {
    let model = Forward::new(mass_and_spring(friction(0.1, 0.0, None)), &[]);
    let mut errors = Vec::new();
    for tolerance in [1e-6, 1e-8] {
        let mut simulation = let_go(&model, tolerance);
        assert_eq!(simulation.method(), Method::TimeStepping);
        assert!(matches!(simulation.interfaces()[0], Doing::Sticks));
        let x = simulation.instant().state.coordinates[0];
        let dissipated = simulation.energies().interfaces[0];
        println!(
            "{tolerance:e}: {x} {dissipated} energy {:.1e}, {} steps",
            simulation.energy_error(),
            simulation.evaluations()
        );
        errors.push((x + 0.0019).abs());
        simulation.advance(1000.0, &mut ConstantEfforts(vec![])).unwrap();
        assert_eq!(simulation.instant().state.coordinates[0], x);
        assert_eq!(simulation.instant().state.rates[0], 0.0);
        assert_eq!(jumps(&simulation), 0);
        // The mass is constant, so the mean velocity does exactly the work that the kinetic energy
        // gains. The spring force is evaluated in the middle of a step.
        assert!((dissipated - 0.4998195).abs() < 2e3 * tolerance.sqrt() * 1e-2);
    }
    // The steps without a reversal are extrapolated, those with a reversal are shortened: the error
    // decreases almost as much as the tolerance.
    assert!(errors[0] < 5e-5 && errors[1] < 0.05 * errors[0], "{errors:?}");
}

/// The same mass with a static coefficient of 0.3. At its fourth turning point, 0.1 - 8 * 0.00981
/// m, the spring pulls with 2.15 N, which is more than the sliding friction but less than the
/// static limit of 2.94 N. The mass therefore stays there.
#[test]
fn static_friction_holds_at_a_reversal() {
    let mut interface = friction(0.1, 0.0, None);
    interface.law.curve = Curve::Static { mu_static: 0.3 };
    let model = Forward::new(mass_and_spring(interface), &[]);
    let mut errors = Vec::new();
    for tolerance in [1e-6, 1e-8] {
        let simulation = let_go(&model, tolerance);
        assert_eq!(simulation.interfaces()[0], Doing::Sticks);
        let turns = simulation.events().iter();
        let turns = turns.filter(|e| matches!(e.kind, EventKind::Slides { .. })).count();
        assert_eq!(turns, 3, "{:?}", simulation.events());
        errors.push((simulation.instant().state.coordinates[0] - (0.1 - 8.0 * 0.00981)).abs());
    }
    // As in the test of R6.
    assert!(errors[0] < 5e-4 && errors[1] < 0.3 * errors[0], "{errors:?}");
}

/// A block slides up a ramp and back. The friction slows it down three times as fast as gravity
/// accelerates it afterwards, so an instant of the reversal estimated with the friction after it
/// would be far too late. The only event is the reversal, and neither instant nor velocity is off.
#[test]
fn a_reversal_is_one_event() {
    let x = along(Vec3::zero(), Vec3::unit(0));
    let mechanism = MechanismBuilder::new("ramp")
        .gravity(v(-9.81, -9.81, 0.0))
        .body(BodySpec::new("block").mass(1.0).inertia(diagonal(0.1, 0.1, 0.1)))
        .joint(
            JointSpec::new("table", JointType::Prismatic, "ground", "block")
                .frames(x, x)
                .friction(friction(0.5, 0.0, None)),
        )
        .build()
        .unwrap();
    let model = Forward::new(mechanism, &[]);
    let (up, down) = (1.5 * 9.81, 0.5 * 9.81);
    for speed in [0.7, 1.0, 1.3] {
        let mut inputs = ConstantEfforts(vec![]);
        let mut state = State::new(model.topology());
        state.rates[0] = speed;
        let mut simulation = model.start(0.0, state, in_steps(1e-7), &mut inputs).unwrap();
        simulation.advance(0.2, &mut inputs).unwrap();
        let [method, event] = simulation.events() else { panic!("{:?}", simulation.events()) };
        assert!(matches!(method.kind, EventKind::Method { .. }), "{method:?}");
        assert!(matches!(event.kind, EventKind::Slides { .. }), "{event:?}");
        let turn = event.time;
        let rate = simulation.instant().state.rates[0] + down * (0.2 - speed / up);
        println!(
            "{speed}: turns at {turn}, {:.1e} late; rate off by {rate:.1e}",
            turn - speed / up
        );
        assert!(rate.abs() < 1e-5, "{rate}");
        assert!((turn - speed / up).abs() < 1e-9, "{turn}");
    }
}

/// The crank of reference R8, with efforts inside and outside its holding interval, by time
/// stepping.
#[test]
fn a_held_crank_does_not_move_at_all() {
    let robot = slider_crank();
    let model = Forward::new(robot.mechanism.clone(), &[]);
    let at = Target { value: 1.0, rate: 0.0, acceleration: 0.0 };
    let state = model.assemble(&[], &robot.coordinates, &[at]).unwrap();
    // Efforts inside and outside the holding interval, which inverse dynamics determines.
    for (drive, sticks) in [(1.0, true), (0.0, false)] {
        let mut solver = stiction_core::dynamics::InverseDynamics::new(
            robot.mechanism.clone(),
            &[],
            &robot.coordinates,
            &[at],
            Default::default(),
        )
        .unwrap();
        solver.rest(&[]).unwrap();
        let (low, high) = solver.forces().effort_bounds[0];
        let effort = if drive == 1.0 { low + 0.975 * (high - low) } else { high + 0.5 };
        let mut inputs = ConstantEfforts(vec![effort]);
        let mut simulation = model.start(0.0, state.clone(), in_steps(1e-7), &mut inputs).unwrap();
        let before = simulation.instant().state.coordinates.clone();
        simulation.advance(if sticks { 1000.0 } else { 0.05 }, &mut inputs).unwrap();
        assert_eq!(simulation.instant().state.coordinates == before, sticks);
        for moment in &simulation.instant().interfaces {
            let has = moment.friction.iter().map(|f| f * f).sum::<f64>().sqrt();
            assert!(has <= moment.limit * (1.0 + 1e-8), "{moment:?}");
        }
    }
}

/// A rod in two pads, pushed back such that no acceleration satisfies the friction laws (as in
/// `forward_loops`). The time stepper stops the rod at once and reports the jump.
#[test]
fn jumps_of_velocities_are_reported() {
    let model = Forward::new(collar(0.2), &[]);
    let mut state = State::new(model.topology());
    state.rates[0] = 0.3;
    let mut inputs = ConstantEfforts(vec![-5.0]);
    let mut simulation = model.start(0.0, state, in_steps(1e-7), &mut inputs).unwrap();
    simulation.advance(0.01, &mut inputs).unwrap();
    println!("{:?} {:?}", simulation.events(), simulation.instant().state);
    assert!(jumps(&simulation) > 0);
    // The pads dissipate all kinetic energy of the rod at once; then it slides back, at -5 / (1 +
    // 2.4) m/s^2.
    let rate = simulation.instant().state.rates[0];
    let back = -5.0 / 3.4 * 0.01;
    assert!((rate - back).abs() < 1e-5 * back.abs(), "{rate} {back}");
    let lost = simulation.energies().interfaces[0];
    let on_the_way = 5.0 * (2.4 / 3.4) * 0.5 * (5.0 / 3.4) * 0.01 * 0.01;
    assert!((lost - 0.5 * 0.3 * 0.3 - on_the_way).abs() < 1e-6, "{lost}");
}

/// Both methods yield the same motion of the symmetric 3-RPS robot with friction in guides and pins.
/// The comparison starts in motion: at rest the distribution of static friction is not unique, and
/// the methods may choose different interfaces that slip first.
#[test]
fn both_methods_give_the_same_motion() {
    let (robot, model, rest) = rubbing_3rps(0.1);
    let mut inputs = ConstantEfforts(vec![70.0, 45.0, 50.0]);
    let exactly = Settings { method: Method::EventDriven, ..Settings::default() };
    let mut started = model.start(0.0, rest, exactly, &mut inputs).unwrap();
    started.advance(0.02, &mut inputs).unwrap();
    let state = &started.instant().state;
    let run = |settings: Settings| {
        let mut inputs = ConstantEfforts(vec![70.0, 45.0, 50.0]);
        let mut simulation = model.start(0.0, state.clone(), settings, &mut inputs).unwrap();
        simulation.advance(0.05, &mut inputs).unwrap();
        println!(
            "{} evaluations, {} events, energy {:.1e} of {:.1e}",
            simulation.evaluations(),
            simulation.events().len(),
            simulation.energy_error(),
            simulation.energies().turnover
        );
        simulation.instant().bodies.pose[robot.mechanism.body_id("platform").unwrap().0].position
    };
    let exact = run(exactly);
    let errors = [1e-5, 1e-7].map(|tolerance| (run(in_steps(tolerance)) - exact).norm());
    println!("{errors:?}");
    // The step is proportional to the square root of the tolerance. Extrapolation leaves an error
    // that is proportional to the square of the step: it decreases by a factor of a hundred, except
    // for steps shortened in both runs by events and the start. The method without extrapolation
    // has errors of 1.8e-5 and 3.3e-6.
    assert!(errors[0] < 5e-6 && errors[1] < 0.1 * errors[0], "{errors:?}");
}
