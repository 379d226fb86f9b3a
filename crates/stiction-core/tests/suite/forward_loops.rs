//! Stick and slip in closed loops, jamming, and the order of convergence.

use crate::common::simulated::*;
use crate::common::*;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, LoadAxes};
use stiction_core::forward::{
    ConstantEfforts, EventKind, Forward, ForwardError, Inputs, InterfaceMode as Doing, Method,
    Settings, View,
};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, State, Target};
use stiction_core::mechanism::{BodyId, BodySpec, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::spatial::{Pose, Vec3};

fn fine() -> Settings {
    Settings { relative: 1e-12, absolute: 1e-13, ..Settings::default() }
}

fn at(value: f64, rate: f64, acceleration: f64) -> Target<f64> {
    Target { value, rate, acceleration }
}

#[test]
fn a_crank_with_friction_everywhere_sticks_within_its_interval_and_slides_beyond() {
    let robot = slider_crank();
    for degrees in [40.0_f64, 100.0, 200.0] {
        let start = [at(degrees.to_radians(), 0.0, 0.0)];
        let mut solver = InverseDynamics::new(
            robot.mechanism.clone(),
            &[],
            &robot.coordinates,
            &start,
            Default::default(),
        )
        .unwrap();
        solver.rest(&[]).unwrap();
        let (low, high) = solver.forces().effort_bounds[0];
        assert!(high - low > 0.01, "{low} {high}");
        let model = Forward::new(robot.mechanism.clone(), &[]);
        let state = model.assemble(&[], &robot.coordinates, &start).unwrap();
        // Stick is certain only with a margin inside these limits: friction below its limits may
        // hold slightly more than friction at its limits, because it changes the normal loads.
        let (least, most) = solver.forces().effort_outer_bounds[0];
        assert!(least <= low && high <= most && most - least < 1.2 * (high - low));
        for (part, sticks) in [
            (0.31, true),
            (-0.95, true),
            (0.95, true),
            (0.9999, true),
            (-0.9999, true),
            (1.0001, false),
            (-1.0001, false),
        ] {
            let (low, high) = if sticks { (low, high) } else { (least, most) };
            let drive = 0.5 * (low + high) + part * 0.5 * (high - low);
            let mut inputs = ConstantEfforts(vec![drive]);
            let settings = Settings { longest_step: 5.0, ..Settings::default() };
            let mut simulation = model
                .start(0.0, state.clone(), settings, &mut inputs)
                .unwrap_or_else(|e| panic!("{degrees} {part}: {e}"));
            let before = simulation.instant().state.coordinates.clone();
            simulation.advance(if sticks { 1000.0 } else { 0.1 }, &mut inputs).unwrap();
            let now = simulation.instant();
            assert_eq!(now.state.coordinates == before, sticks, "{degrees} {part}");
            if sticks {
                assert!(now.state.rates.iter().all(|rate| *rate == 0.0));
                // One DOF and four friction interfaces: three friction forces are indeterminate and
                // follow from the declared rule.
                let told = simulation
                    .events()
                    .iter()
                    .any(|event| matches!(event.kind, EventKind::SharesNotUnique { redundant: 3 }));
                let stuck = simulation.interfaces().iter().filter(|c| **c == Doing::Sticks).count();
                assert!(told || stuck < 4, "{:?}", simulation.events());
                for interface in &now.interfaces {
                    assert!(interface.margin() > -1e-9 * interface.limit, "{interface:?}");
                }
            } else {
                let forward = now.bodies.joint_rates(model.topology(), 0)[0];
                assert_eq!(forward > 0.0, part > 0.0, "{degrees} {part}");
            }
        }
    }
}

/// A crank swings down with friction until the whole loop comes to rest at once.
#[test]
fn inverse_dynamics_returns_the_simulated_effort() {
    let robot = slider_crank();
    let model = Forward::new(robot.mechanism.clone(), &[]);
    let start = [at(1.0, 4.0, 0.0)];
    let state = model.assemble(&[], &robot.coordinates, &start).unwrap();
    let mut inputs = ConstantEfforts(vec![0.1]);
    let mut simulation = model.start(0.0, state, fine(), &mut inputs).unwrap();
    let mut solver = InverseDynamics::new(
        robot.mechanism.clone(),
        &[],
        &robot.coordinates,
        &start,
        stiction_core::dynamics::Settings {
            friction: FrictionMode::Converged,
            ..Default::default()
        },
    )
    .unwrap();
    let mut compared = 0;
    for k in 1..=200 {
        simulation.advance(0.02 * f64::from(k), &mut inputs).unwrap();
        let now = simulation.instant();
        if simulation.interfaces().iter().any(|c| !matches!(c, Doing::Slides(_))) {
            continue;
        }
        let slow = now.interfaces.iter().any(|c| c.velocity[0].abs() < 1e-6);
        let angle = crank_angle(now);
        let rate = now.bodies.joint_rates(model.topology(), 0)[0];
        let acceleration = now.state.accelerations[0];
        if slow {
            continue;
        }
        solver.move_to(&[at(angle, rate, acceleration)]).unwrap();
        let forces = solver.solve(&[]).unwrap();
        // A 3 kg machine under 30 N: the error consists of round-off and of step errors of 1e-12.
        assert!((forces.efforts[0] - 0.1).abs() < 1e-9, "{k}: {}", forces.efforts[0]);
        for (found, wanted) in now.reactions().iter().zip(&forces.reactions) {
            assert!((found.0 - wanted.0).norm() < 1e-8, "{k}");
        }
        compared += 1;
    }
    println!("compared {compared}, {:?}", simulation.events().len());
    assert!(compared > 10, "{compared}");
    let turnover = simulation.energies().turnover;
    assert!(simulation.energy_error().abs() < 1e-9 * turnover, "{:e}", simulation.energy_error());
}

/// Applies an oscillating torque to the crank.
struct Shake;

impl Inputs for Shake {
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        efforts[0] = 1.5 * (15.0 * view.time).sin();
    }
}

/// Interfaces stick, slip and reverse, but the energy does not jump at any of these events. Between
/// two rows, the error of the energy balance grows no more with an event in between than without
/// one.
#[test]
fn energy_does_not_jump_at_events() {
    let robot = slider_crank();
    let model = Forward::new(robot.mechanism.clone(), &[]);
    let state = model.assemble(&[], &robot.coordinates, &[at(0.3, 4.0, 0.0)]).unwrap();
    let mut simulation = model.start(0.0, state, Settings::default(), &mut Shake).unwrap();
    let mut with_events = 0;
    for k in 1..=1000 {
        let (before, told) = (simulation.energy_error(), simulation.events().len());
        simulation.advance(1e-3 * f64::from(k), &mut Shake).unwrap();
        with_events += usize::from(simulation.events().len() > told);
        let lost = (simulation.energy_error() - before).abs();
        // Steps are accurate to 1e-10 of coordinates and rates; the energy exchanged is some
        // joules.
        assert!(lost < 1e-9, "{k}: {lost:e}, {:?}", &simulation.events()[told..]);
    }
    println!("{with_events} {:?}", simulation.energies());
    assert!(with_events > 5 && simulation.energies().turnover > 0.1);
    let steps =
        |event: &&stiction_core::forward::Event| matches!(event.kind, EventKind::Method { .. });
    assert_eq!(simulation.events().iter().filter(steps).count(), 0);
}

fn crank_angle(now: &stiction_core::forward::Instant) -> f64 {
    let relative = now.bodies.frame_j[0].inverse() * now.bodies.frame_k[0];
    relative.rotation.at(1, 0).atan2(relative.rotation.at(0, 0))
}

/// Errors decrease with the eighth power of the step, for the pendulum of reference R1 after one
/// second.
#[test]
fn steps_are_of_order_eight() {
    let mechanism = MechanismBuilder::new("pendulum")
        .gravity(v(0.0, -9.81, 0.0))
        .body(BodySpec::new("bob").mass(1.0).com(v(-1.0, 0.0, 0.0)))
        .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "bob"))
        .build()
        .unwrap();
    let model = Forward::new(mechanism, &[]);
    let mut inputs = ConstantEfforts(vec![]);
    let errors = [1.0 / 6.0, 1.0 / 12.0, 1.0 / 24.0].map(|step| {
        // With an unlimited error tolerance, all steps except the first few have the maximum size.
        let settings = Settings { relative: 1e9, longest_step: step, ..Settings::default() };
        let state = State::new(model.topology());
        let mut simulation = model.start(0.0, state, settings, &mut inputs).unwrap();
        simulation.advance(1.0, &mut inputs).unwrap();
        let pose = simulation.instant().bodies.pose[1];
        (pose.apply(v(-1.0, 0.0, 0.0)) - v(0.9862917511319, -0.1650108531255, 0.0)).norm()
    });
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    println!("{errors:?} {orders:?}");
    assert!(orders.iter().all(|order| *order > 7.5), "{orders:?} {errors:?}");
}

/// The centre of mass is at the distance `e` from a guide that slides forward under a force `F`
/// along it. The pads carry the moment `m e |a|` with a normal load of `2 m e |a| / span`, so
/// `m a = F - k m |a|` with `k = 2 mu e / span`.
#[test]
fn short_guides_jam_with_a_message() {
    let (mu, span) = (0.12, 0.02);
    for (e, force) in [(0.05, 5.0), (0.05, -5.0), (0.2, 5.0), (0.2, -5.0)] {
        let k = 2.0 * mu * e / span;
        let model = Forward::new(collar(e), &[]);
        let mut state = State::new(model.topology());
        state.rates[0] = 0.3;
        let mut inputs = ConstantEfforts(vec![force]);
        let started = model.start(0.0, state.clone(), Settings::default(), &mut inputs);
        if force < 0.0 && k > 1.0 {
            // Neither sign of the acceleration is consistent with the friction laws: the slide jams
            // in an inelastic impact, which dissipates its kinetic energy.
            let mut jammed = started.unwrap();
            jammed.advance(1e-5, &mut inputs).unwrap();
            // Afterwards, the force pushes the slide back.
            let rate = jammed.instant().state.rates[0];
            assert!((rate - force / (1.0 + k) * 1e-5).abs() < 1e-6, "{rate}");
            let jumps = jammed.events().iter().filter_map(|event| match &event.kind {
                EventKind::Jump { rates, .. } => Some(rates[0]),
                _ => None,
            });
            let jumps: Vec<_> = jumps.collect();
            assert_eq!(jumps.len(), 1, "{jumps:?}");
            assert!(jumps[0].before == 0.3 && jumps[0].after.abs() < 1e-6, "{jumps:?}");
            let lost = jammed.energies().interfaces.iter().sum::<f64>();
            assert!((lost - 0.045).abs() < 1e-6, "{lost}");
            // The event-driven method alone finds no consistent acceleration.
            let settings = Settings { method: Method::EventDriven, ..Settings::default() };
            let error = model.start(0.0, state, settings, &mut inputs).unwrap_err();
            let ForwardError::NoAcceleration { time, joint, percent } = &error else {
                panic!("{error}")
            };
            assert_eq!((*time, joint.as_str()), (0.0, "guide"));
            assert!((percent - 100.0 / k).abs() < 0.01, "{percent}");
            continue;
        }
        let simulation = started.unwrap();
        let acceleration = simulation.instant().state.accelerations[0];
        let expected = if force > 0.0 { force / (1.0 + k) } else { force / (1.0 - k) };
        assert!((acceleration - expected).abs() < 1e-12, "{acceleration} {expected}");
        // If k > 1, a backward acceleration F / (1 - k) also satisfies all friction laws.
        let others: Vec<f64> = simulation
            .events()
            .iter()
            .filter_map(|event| match &event.kind {
                EventKind::NotUnique { others, .. } => Some(others),
                _ => None,
            })
            .flatten()
            .map(|other| other.accelerations[0])
            .collect();
        if k > 1.0 {
            assert_eq!(others.len(), 1, "{others:?}");
            assert!((others[0] - force / (1.0 - k)).abs() < 1e-9, "{others:?}");
        } else {
            assert!(others.is_empty(), "{others:?}");
        }
    }
}

/// Applies a load parallel to the guide, on its axis or with an offset.
struct Push {
    force: f64,
    point: Vec3<f64>,
}

impl Inputs for Push {
    fn efforts(&mut self, _: &View<'_>, _: &mut [f64]) {}
    fn loads(&mut self, _: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        loads.push(AppliedLoad {
            body: BodyId(1),
            point: self.point,
            axes: LoadAxes::World,
            force: v(self.force, 0.0, 0.0),
            moment: Vec3::zero(),
        });
    }
}

#[test]
fn r7_a_collar_pushed_at_an_offset_slides_or_locks() {
    // For a force with offset `e` from the rod and the centre of mass on the rod, the friction is
    // mu 2 e F / s.
    let model = Forward::new(collar(0.0), &[]);
    let (mu, span) = (0.12, 0.02);
    for e in [0.04, 0.08, 0.0834, 0.2] {
        let mut inputs = Push { force: 5.0, point: v(0.0, e, 0.0) };
        let state = State::new(model.topology());
        let simulation = model.start(0.0, state, Settings::default(), &mut inputs).unwrap();
        let acceleration = simulation.instant().state.accelerations[0];
        let part = 2.0 * mu * e / span;
        let expected = if part < 1.0 { 5.0 * (1.0 - part) } else { 0.0 };
        assert!((acceleration - expected).abs() < 1e-12, "{e}: {acceleration} {expected}");
    }
}

/// Creates a block on an inclined plane along x, moved by a connecting rod from the rocker of a
/// four-bar linkage. All links are balanced, so that the frictionless pins transmit no force at
/// rest: crank and rocker each carry half of the coupler as a counterweight, and the rod's centre
/// of mass is at its pin in the block. The plane is modelled as level; `angle` is the direction of
/// gravity.
fn block_on_an_incline(angle: f64, mu: f64) -> Mechanism {
    let (crank, coupler, rocker, rod) = (0.15_f64, 0.4_f64, 0.3_f64, 0.8_f64);
    let (pivot, height) = (v(0.4, 0.0, 0.0), -0.2);
    // Positions of the joints: the crank at 60 deg, the coupler and the rocker on the upper side.
    let b = v(crank * 60_f64.to_radians().cos(), crank * 60_f64.to_radians().sin(), 0.0);
    let way = pivot - b;
    let base = way.norm();
    let along_way = (coupler * coupler - rocker * rocker + base * base) / (2.0 * base);
    let up = (coupler * coupler - along_way * along_way).sqrt();
    let c = b + v(
        (way.x * along_way - way.y * up) / base,
        (way.y * along_way + way.x * up) / base,
        0.0,
    );
    let block = v(c.x + (rod * rod - (c.y - height).powi(2)).sqrt(), height, 0.0);
    let direction = |from: Vec3<f64>, to: Vec3<f64>| (to.y - from.y).atan2(to.x - from.x);
    let (first, second) = (60_f64.to_radians(), direction(b, c));
    let (third, last) = (direction(pivot, c), direction(c, block));
    let slim = |mass: f64, length: f64| {
        let j = mass * length * length / 12.0;
        diagonal(0.01 * j, j, j)
    };
    let pin = |name: &str, from: &str, to: &str, at: Vec3<f64>, start: f64| {
        JointSpec::new(name, JointType::Revolute, from, to)
            .frames(Pose::at(at), Pose::identity())
            .start([start])
    };
    let guide = |x: f64| along(v(x, height, 0.0), Vec3::unit(0));
    let half = 0.5 * 0.8;
    MechanismBuilder::new("incline")
        .gravity(v(9.81 * angle.sin(), -9.81 * angle.cos(), 0.0))
        .body(
            BodySpec::new("crank")
                .mass(1.0)
                .com(v(-half * crank / 1.0, 0.0, 0.0))
                .inertia(slim(1.0, crank)),
        )
        .body(
            BodySpec::new("coupler")
                .mass(2.0 * half)
                .com(v(0.5 * coupler, 0.0, 0.0))
                .inertia(slim(0.8, coupler)),
        )
        .body(
            BodySpec::new("rocker")
                .mass(1.6)
                .com(v(-half * rocker / 1.6, 0.0, 0.0))
                .inertia(slim(1.6, rocker)),
        )
        .body(BodySpec::new("rod").mass(0.5).com(v(rod, 0.0, 0.0)).inertia(slim(0.5, rod)))
        .body(BodySpec::new("block").mass(2.0).inertia(diagonal(0.01, 0.01, 0.01)))
        .joint(pin("A", "ground", "crank", Vec3::zero(), first).actuated())
        .joint(pin("B", "crank", "coupler", v(crank, 0.0, 0.0), second - first))
        .joint(pin("D", "ground", "rocker", pivot, third))
        .joint(
            JointSpec::new("C", JointType::Revolute, "coupler", "rocker")
                .frames(Pose::at(v(coupler, 0.0, 0.0)), Pose::at(v(rocker, 0.0, 0.0)))
                .start([third - second]),
        )
        .joint(pin("E", "rocker", "rod", v(rocker, 0.0, 0.0), last - third))
        .joint(
            JointSpec::new("F", JointType::Revolute, "rod", "block")
                .frames(Pose::at(v(rod, 0.0, 0.0)), Pose::identity())
                .start([-last]),
        )
        .joint(
            JointSpec::new("plane", JointType::Prismatic, "ground", "block")
                .frames(guide(0.0), along(Vec3::zero(), Vec3::unit(0)))
                .start([block.x])
                .friction(friction(mu, 0.0, None)),
        )
        .build()
        .unwrap()
}

#[test]
fn a_block_moved_by_a_four_bar_sticks_just_below_the_friction_angle_and_slides_just_above() {
    let mu = 0.3_f64;
    for (part, sticks) in [(1.0 - 1e-8, true), (1.0 + 1e-8, false)] {
        for sign in [1.0, -1.0] {
            let mechanism = block_on_an_incline(sign * part * mu.atan(), mu);
            let crank = mechanism.joint_id("A").unwrap();
            let coordinates = [Coordinate::Joint { joint: crank, dof: 0 }];
            let block = mechanism.body_id("block").unwrap();
            let model = Forward::new(mechanism, &[]);
            let start = [at(60_f64.to_radians(), 0.0, 0.0)];
            let state = model.assemble(&[], &coordinates, &start).unwrap();
            let mut inputs = ConstantEfforts(vec![0.0]);
            let settings = Settings { longest_step: 5.0, ..Settings::default() };
            let mut simulation = model.start(0.0, state, settings, &mut inputs).unwrap();
            let before = simulation.instant().state.coordinates.clone();
            let place = simulation.instant().bodies.pose[block.0].position.x;
            simulation.advance(if sticks { 1000.0 } else { 1.0 }, &mut inputs).unwrap();
            let now = simulation.instant();
            let moved = now.bodies.pose[block.0].position.x - place;
            assert_eq!(now.state.coordinates == before, sticks, "{part} {sign}: {moved:e}");
            // Sliding distance without the inertia of the linkage. The inertia slows the motion but
            // hardly changes the distance.
            let freely = 0.5 * 9.81 * ((part * mu.atan()).sin() - mu * (part * mu.atan()).cos());
            if sticks {
                assert!(now.state.rates.iter().all(|rate| *rate == 0.0));
            } else {
                assert!(
                    moved * sign > 0.3 * freely && moved * sign < freely,
                    "{moved:e} {freely:e}"
                );
            }
        }
    }
}

/// At a dead centre, the slider is at rest while the crank continues to move. The slider is not a
/// DOF of the mechanism there and cannot stick: it reverses, as at every later dead centre.
#[test]
fn a_crank_that_starts_at_a_dead_centre_only_reverses_its_slider() {
    let robot = slider_crank();
    let model = Forward::new(robot.mechanism.clone(), &[]);
    let state = model.assemble(&[], &robot.coordinates, &[at(0.0, 10.0, 0.0)]).unwrap();
    let mut inputs = ConstantEfforts(vec![0.0]);
    let mut simulation = model.start(0.0, state, fine(), &mut inputs).unwrap();
    simulation.advance(0.05, &mut inputs).unwrap();
    assert!(simulation.events().is_empty(), "{:?}", simulation.events());
    assert!(simulation.interfaces().iter().all(|c| matches!(c, Doing::Slides(_))));
    let turnover = simulation.energies().turnover;
    assert!(simulation.energy_error().abs() < 1e-11 * turnover, "{:e}", simulation.energy_error());
}
