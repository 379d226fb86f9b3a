//! Joints that stick and slip, against closed forms.

use crate::common::simulated::*;
use crate::common::*;
use stiction_core::dynamics::{FrictionMode, InverseDynamics};
use stiction_core::forward::{
    ConstantEfforts, EventKind, Forward, Inputs, InterfaceMode as Doing, Settings, View,
};
use stiction_core::friction::{Bristles, Curve, JointFriction, Law};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, State, Target};
use stiction_core::mechanism::{BodySpec, JointSpec, Mechanism, MechanismBuilder, SpringSpec};
use stiction_core::spatial::Vec3;

fn fine() -> Settings {
    Settings { relative: 1e-12, absolute: 1e-13, ..Settings::default() }
}

fn nothing() -> ConstantEfforts {
    ConstantEfforts(vec![])
}

fn coulomb(mu: f64, curve: Curve, radius: Option<f64>) -> JointFriction {
    JointFriction { radius, ..JointFriction::guide(Law { curve, ..Law::coulomb_viscous(mu, 0.0) }) }
}

fn start_of(model: &Forward, values: &[(f64, f64)]) -> State<f64> {
    let joints = model.mechanism().joints().len();
    let coordinates: Vec<_> = (0..joints.min(values.len()))
        .map(|k| {
            let joint = model.mechanism().joint_id(&model.mechanism().joints()[k].name).unwrap();
            Coordinate::Joint { joint, dof: 0 }
        })
        .collect();
    let targets: Vec<_> =
        values.iter().map(|&(value, rate)| Target { value, rate, acceleration: 0.0 }).collect();
    model.assemble(&[], &coordinates, &targets).unwrap()
}

/// Creates the mass of reference R6 on a table along x, with a spring to the ground.
fn mass_and_spring(interface: JointFriction, spring: f64) -> Mechanism {
    let x = along(Vec3::zero(), Vec3::unit(0));
    MechanismBuilder::new("mass")
        .gravity(v(0.0, -9.81, 0.0))
        .body(BodySpec::new("block").mass(1.0).inertia(diagonal(0.1, 0.1, 0.1)))
        .joint(
            JointSpec::new("table", JointType::Prismatic, "ground", "block")
                .frames(x, x)
                .actuated()
                .friction(interface),
        )
        .spring(
            SpringSpec::new("spring", "ground", "block")
                .points(v(-1.0, 0.0, 0.0), Vec3::zero())
                .stiffness(spring, 1.0),
        )
        .build()
        .unwrap()
}

#[test]
fn r6_half_cycles_reverse_and_stop_as_in_closed_form() {
    // Friction 0.981 N under a weight of 9.81 N.
    let model = Forward::new(mass_and_spring(coulomb(0.1, Curve::Constant, None), 100.0), &[]);
    let mut inputs = nothing();
    let mut simulation =
        model.start(0.0, start_of(&model, &[(0.1, 0.0)]), fine(), &mut inputs).unwrap();
    let half = std::f64::consts::PI / 10.0;
    for n in 1..=4 {
        simulation.advance(half * f64::from(n), &mut inputs).unwrap();
        let x = simulation.instant().state.coordinates[0];
        let expected = (0.1 - 0.01962 * f64::from(n)) * if n % 2 == 0 { 1.0 } else { -1.0 };
        // Steps are accurate to 1e-12. At a turning point, an error in time has no first-order
        // effect.
        assert!((x - expected).abs() < 1e-11, "{n}: {x} {expected}");
    }
    simulation.advance(3.0, &mut inputs).unwrap();
    let last = simulation.events().last().unwrap();
    assert!(matches!(last.kind, EventKind::Sticks { .. }), "{last:?}");
    println!("R6 stop {} off {:.1e}", last.time, last.time - 5.0 * half);
    assert!((last.time - 5.0 * half).abs() < 1e-10);
    let x = simulation.instant().state.coordinates[0];
    assert!((x + 0.0019).abs() < 1e-11, "{x}");
    let dissipated = simulation.energies().interfaces[0];
    assert!((dissipated - 0.4998195).abs() < 1e-11, "{dissipated}");
    assert!(simulation.energy_error().abs() < 1e-11);
    // The mass stays there, to the last bit.
    simulation.advance(1000.0, &mut inputs).unwrap();
    assert_eq!(simulation.instant().state.coordinates[0], x);
    assert_eq!(simulation.instant().state.rates[0], 0.0);
}

/// Prescribes the constant speed of a belt.
struct Belt(f64);

impl Inputs for Belt {
    fn efforts(&mut self, _: &View<'_>, _: &mut [f64]) {}
    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        targets[0] = Target { value: self.0 * time, rate: self.0, acceleration: 0.0 };
    }
}

#[test]
fn r6_stick_slip_on_a_belt() {
    let x = along(Vec3::zero(), Vec3::unit(0));
    let breakaway = Curve::Static { mu_static: 1.5 / 9.81 };
    let mechanism = MechanismBuilder::new("belt")
        .gravity(v(0.0, -9.81, 0.0))
        .body(BodySpec::new("belt").mass(1.0).inertia(diagonal(0.1, 0.1, 0.1)))
        .body(BodySpec::new("block").mass(1.0).inertia(diagonal(0.1, 0.1, 0.1)))
        .joint(
            JointSpec::new("rollers", JointType::Prismatic, "ground", "belt")
                .frames(x, x)
                .actuated(),
        )
        .joint(
            JointSpec::new("rubs", JointType::Prismatic, "belt", "block")
                .frames(x, x)
                .friction(coulomb(1.0 / 9.81, breakaway, None)),
        )
        .spring(
            SpringSpec::new("spring", "ground", "block")
                .points(v(-1.0, 0.0, 0.0), Vec3::zero())
                .stiffness(100.0, 1.0),
        )
        .build()
        .unwrap();
    let model = Forward::new(mechanism, &[0]);
    let mut belt = Belt(0.1);
    let state = start_of(&model, &[(0.0, 0.1), (0.0, 0.0)]);
    let mut simulation = model.start(0.0, state, fine(), &mut belt).unwrap();
    simulation.advance(3.0, &mut belt).unwrap();
    let mut slips = Vec::new();
    let mut sticks = Vec::new();
    for event in simulation.events() {
        match event.kind {
            EventKind::Slides { .. } => slips.push(event.time),
            EventKind::Sticks { .. } => sticks.push(event.time),
            _ => {}
        }
    }
    println!("{slips:?} {sticks:?}");
    // The belt carries the mass until the spring pulls with 1.5 N, 15 mm from its free length.
    assert!((slips[0] - 0.15).abs() < 1e-9, "{slips:?}");
    for (slip, stick) in slips.iter().zip(&sticks) {
        assert!((stick - slip - 0.5355890089178).abs() < 1e-9, "{}", stick - slip);
    }
    for (stick, slip) in sticks.iter().zip(&slips[1..]) {
        assert!((slip - stick - 0.1).abs() < 1e-9, "{}", slip - stick);
    }
    assert!(slips.len() >= 4);
    let error = simulation.energy_error();
    assert!(error.abs() < 1e-9 * simulation.energies().turnover.max(1.0), "{error}");
}

/// Creates the pendulum of reference R5.
fn journal(mu: f64) -> Forward {
    let mechanism = MechanismBuilder::new("journal")
        .gravity(v(0.0, -9.81, 0.0))
        .body(BodySpec::new("bob").mass(1.0).com(v(0.0, -1.0, 0.0)))
        .joint(JointSpec::new("pin", JointType::Revolute, "ground", "bob").friction(coulomb(
            mu,
            Curve::Constant,
            Some(0.05),
        )))
        .build()
        .unwrap();
    Forward::new(mechanism, &[])
}

#[test]
fn r5_journal_loses_height_as_its_closed_form_says() {
    let model = journal(0.3);
    let mut inputs = nothing();
    let state = start_of(&model, &[(80_f64.to_radians(), 0.0)]);
    let mut simulation = model.start(0.0, state, fine(), &mut inputs).unwrap();
    let mut peaks = Vec::new();
    let mut seen = 0;
    while peaks.len() < 6 {
        let next = simulation.instant().time + 0.05;
        simulation.advance(next, &mut inputs).unwrap();
        for event in &simulation.events()[seen..] {
            if matches!(event.kind, EventKind::Slides { .. }) && event.time > 0.0 {
                peaks.push(event.time);
            }
        }
        seen = simulation.events().len();
        assert!(next < 20.0);
    }
    let expected = [
        75.84391908501,
        71.96678352715,
        68.32973260301,
        64.90139389660,
        61.65601309379,
        58.57214417160,
    ];
    let mut again = model
        .start(0.0, start_of(&model, &[(80_f64.to_radians(), 0.0)]), fine(), &mut inputs)
        .unwrap();
    for (time, expected) in peaks.iter().zip(expected) {
        again.advance(*time, &mut inputs).unwrap();
        let angle = again.instant().state.coordinates[0].to_degrees().abs();
        println!("R5 {angle} off {:.1e}", angle - expected);
        assert!((angle - expected).abs() < 1e-9, "{angle} {expected}");
    }
}

#[test]
fn r5_rests_just_below_its_angle_and_not_above() {
    // The pendulum can rest where |sin angle| <= mu r / L.
    let model = journal(0.3);
    let limit = (0.3_f64 * 0.05).asin();
    for (part, rests) in [(1.0 - 1e-9, true), (1.0 + 1e-8, false)] {
        let mut inputs = nothing();
        let state = start_of(&model, &[(limit * part, 0.0)]);
        let mut simulation = model.start(0.0, state, Settings::default(), &mut inputs).unwrap();
        simulation.advance(0.1, &mut inputs).unwrap();
        assert_eq!(simulation.interfaces()[0] == Doing::Sticks, rests, "{part}");
        assert_eq!(simulation.instant().state.coordinates[0] == limit * part, rests);
    }
}

/// Creates a block on an inclined plane, with a guide or a plate as its joint.
fn incline(angle: f64, mu: f64, joint_type: JointType) -> Forward {
    let down = v(angle.cos(), -angle.sin(), 0.0);
    let normal = v(angle.sin(), angle.cos(), 0.0);
    let frame = match joint_type {
        JointType::Prismatic => along(Vec3::zero(), down),
        _ => along(Vec3::zero(), normal),
    };
    let radius = (joint_type == JointType::Planar).then_some(0.02);
    let mechanism = MechanismBuilder::new("incline")
        .gravity(v(0.0, -9.81, 0.0))
        .body(BodySpec::new("block").mass(2.0).inertia(diagonal(0.1, 0.1, 0.1)))
        .joint(
            JointSpec::new("plane", joint_type, "ground", "block")
                .frames(frame, frame)
                .friction(coulomb(mu, Curve::Constant, radius)),
        )
        .build()
        .unwrap();
    Forward::new(mechanism, &[])
}

#[test]
fn a_block_sticks_just_below_the_friction_angle_and_slides_just_above() {
    for joint_type in [JointType::Prismatic, JointType::Planar] {
        let mu = 0.3_f64;
        // A plate may slide in any direction. The slower it slides, the stiffer its friction is
        // perpendicular to its velocity.
        let above = if joint_type == JointType::Planar { 2e-2 } else { 1e-8 };
        for (part, sticks) in [(1.0 - 1e-8, true), (1.0 + above, false)] {
            let angle = mu.atan() * part;
            let model = incline(angle, mu, joint_type);
            let mut inputs = nothing();
            let state = State::new(model.topology());
            let settings = Settings::default();
            let mut simulation = model.start(0.0, state.clone(), settings, &mut inputs).unwrap();
            simulation.advance(1.0, &mut inputs).unwrap();
            let now = simulation.instant();
            assert_eq!(now.state.coordinates == state.coordinates, sticks, "{joint_type:?} {part}");
            let way = 0.5 * 9.81 * (angle.sin() - mu * angle.cos());
            let moved = now.bodies.pose[1].position.norm();
            let expected = if sticks { 0.0 } else { way };
            // The tolerance of the steps is 1e-10 of the distance.
            assert!(
                (moved - expected).abs() < 1e-9 * way.abs().max(1e-2),
                "{joint_type:?} {part}: {moved} {expected}"
            );
        }
    }
}

#[test]
fn no_drift_at_95_percent_of_the_friction_limit() {
    let model = Forward::new(mass_and_spring(coulomb(0.2, Curve::Constant, None), 0.0), &[]);
    for part in [0.31, 0.95] {
        let mut inputs = ConstantEfforts(vec![0.2 * 9.81 * part]);
        let state = start_of(&model, &[(0.123, 0.0)]);
        let before = state.coordinates.clone();
        let mut simulation = model.start(0.0, state, Settings::default(), &mut inputs).unwrap();
        simulation.advance(1000.0, &mut inputs).unwrap();
        assert_eq!(simulation.instant().state.coordinates, before);
        let interface = simulation.instant().interfaces[0];
        // Friction balances the driving load; its sign is that of the sliding that it resists.
        assert!((interface.friction[0] - 0.2 * 9.81 * part).abs() < 1e-12);
    }
}

/// Applies oscillating forces.
struct Swing {
    mean: [f64; 3],
    amplitude: f64,
    rate: f64,
}

impl Inputs for Swing {
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        for (k, effort) in efforts.iter_mut().enumerate() {
            let phase = self.rate * view.time * (1.0 + 0.2 * k as f64);
            *effort = self.mean[k] + self.amplitude * phase.sin();
        }
    }
}

/// The symmetric 3-RPS with Coulomb friction in guides and pins, limited by the reactions, and
/// viscous friction in the balls: six interfaces stick and slip under oscillating forces, with
/// three DOFs.
#[test]
fn a_parallel_robot_sticks_and_slides() {
    let (robot, model, state) = rubbing_3rps(0.0);
    let mut solver = InverseDynamics::new(
        robot.mechanism.clone(),
        &robot.initial_poses,
        &robot.coordinates,
        &level(),
        stiction_core::dynamics::Settings { friction: FrictionMode::Off, ..Default::default() },
    )
    .unwrap();
    let weight = solver.solve(&[]).unwrap().efforts.clone();
    let mean = [weight[0], weight[1], weight[2]];
    let mut swing = Swing { mean, amplitude: 12.0, rate: 9.0 };
    let settings = Settings { relative: 1e-8, absolute: 1e-10, ..Settings::default() };
    let mut simulation = model.start(0.0, state, settings, &mut swing).unwrap();
    // In equilibrium, nothing begins to move.
    assert!(simulation.interfaces().iter().all(|c| !matches!(c, Doing::Slides(_))));
    let until = 1.0;
    simulation.advance(until, &mut swing).unwrap();
    let slides =
        simulation.events().iter().filter(|e| matches!(e.kind, EventKind::Slides { .. })).count();
    // Most interfaces reverse without stopping, because other joints keep moving.
    assert!(slides > 12, "{slides}");
    let turnover = simulation.energies().turnover;
    assert!(simulation.energy_error().abs() < 1e-7 * turnover);
}

/// Dahl's law as a function of displacement, `N mu (1 - exp(-stiffness x / mu))`: the force on a
/// prescribed slide at constant speed, and the energy stored in the bristles.
#[test]
fn dahl_rises_exponentially_with_displacement() {
    let (mu, stiffness, speed, way) = (0.2, 1e4, 0.01, 5e-5);
    let law = Law {
        bristles: Some(Bristles { stiffness, damping: 0.0 }),
        ..Law::coulomb_viscous(mu, 0.0)
    };
    let interface = JointFriction { law, ..coulomb(mu, Curve::Constant, None) };
    let model = Forward::new(mass_and_spring(interface, 0.0), &[0]);
    let mut drive = Belt(speed);
    let state = start_of(&model, &[(0.0, speed)]);
    let mut simulation = model.start(0.0, state, fine(), &mut drive).unwrap();
    assert!(matches!(simulation.interfaces()[0], Doing::Smooth));
    simulation.advance(way / speed, &mut drive).unwrap();
    let now = simulation.instant();
    let expected = 9.81 * mu * (1.0 - (-stiffness * way / mu).exp());
    // Steps are accurate to 1e-12 of the deflection.
    assert!((now.drives[0] - expected).abs() < 1e-9, "{} {expected}", now.drives[0]);
    assert!(simulation.energy_error().abs() < 1e-12);
}
