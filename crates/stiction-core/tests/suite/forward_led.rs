//! Friction in joints whose motion is prescribed.

use crate::common::*;
use stiction_core::forward::{EventKind, Forward, Inputs, Known, Settings, View};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, State, Target};
use stiction_core::mechanism::{BodySpec, JointSpec, MechanismBuilder};
use stiction_core::spatial::Vec3;

const G: f64 = 9.81;
const MASS: f64 = 2.0;
const MU: f64 = 0.3;

/// Prescribes the motion of a slide by a function of time.
struct Leads<F>(F);

impl<F: Fn(f64) -> Target<f64>> Inputs for Leads<F> {
    fn efforts(&mut self, _view: &View<'_>, _efforts: &mut [f64]) {}
    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        targets[0] = (self.0)(time);
    }
}

fn block() -> Forward {
    let x = along(Vec3::zero(), Vec3::unit(0));
    let mechanism = MechanismBuilder::new("block")
        .gravity(v(0.0, 0.0, -G))
        .body(BodySpec::new("block").mass(MASS).inertia(diagonal(0.1, 0.1, 0.1)))
        .joint(
            JointSpec::new("guide", JointType::Prismatic, "ground", "block")
                .frames(x, x)
                .actuated()
                .friction(friction(MU, 0.0, None)),
        )
        .build()
        .unwrap();
    Forward::new(mechanism, &[0])
}

/// A prescribed slide that starts from rest, at once or later, smoothly or abruptly, forward or
/// backward. As soon as it moves, the actuator force includes inertia and friction.
#[test]
fn a_prescribed_slide_has_friction_from_its_start() {
    let model = block();
    let even = |t: f64| Target { value: 0.1 * t * t, rate: 0.2 * t, acceleration: 0.2 };
    let smooth = |t: f64| {
        let (s, v, a) = (t.powi(4), 4.0 * t.powi(3), 12.0 * t * t);
        Target { value: -0.2 * s, rate: -0.2 * v, acceleration: -0.2 * a }
    };
    let waits = |t: f64| {
        if t < 0.37 {
            Target { value: 0.0, rate: 0.0, acceleration: 0.0 }
        } else {
            smooth(t - 0.37)
        }
    };
    type Way<'a> = &'a dyn Fn(f64) -> Target<f64>;
    let ways: [(Way<'_>, f64, f64); 3] =
        [(&even, 1.0, 0.0), (&smooth, -1.0, 0.0), (&waits, -1.0, 0.37)];
    for (way, sense, begins) in ways {
        let mut leads = Leads(way);
        let state = State::new(model.topology());
        let mut simulation = model.start(0.0, state, Settings::default(), &mut leads).unwrap();
        for k in 1..=10 {
            let time = 0.1 * f64::from(k);
            simulation.advance(time, &mut leads).unwrap();
            let now = simulation.instant();
            let rub = if time > begins { sense * MU * MASS * G } else { 0.0 };
            let expected = MASS * way(time).acceleration + rub;
            assert!(
                (now.drives[0] - expected).abs() < 1e-9,
                "{time}: {} {expected}",
                now.drives[0]
            );
        }
        let moved = way(1.0).value.abs();
        let dissipated = simulation.energies().interfaces[0];
        // Motion is detected when the rate exceeds 1e-10 of the largest rate.
        assert!((dissipated - MU * MASS * G * moved).abs() < 1e-9, "{dissipated}");
        let turnover = simulation.energies().turnover;
        assert!(simulation.energy_error().abs() < 1e-9 * turnover);
        let slides =
            |e: &&stiction_core::forward::Event| matches!(e.kind, EventKind::Slides { .. });
        if begins > 0.0 {
            let time = simulation.events().iter().find(slides).unwrap().time;
            // The displacement grows with the cube of time and is detected from about 1e-10 on.
            assert!((time - begins).abs() < 1e-3, "{time}");
        }
    }
}

/// A slider-crank with consistently prescribed crank and slider: one effort is redundant. The
/// efforts with the least sum of squares, where torques are divided by the characteristic length,
/// are proportional to the rates.
#[test]
fn efforts_of_redundant_actuators_have_the_least_sum_of_squares() {
    let mechanism = slider_crank().mechanism;
    let guide = mechanism.joint_id("guide").unwrap();
    let model = Forward::new(mechanism.with_actuator(guide, 0), &[0, 1]);
    let slide = |t: f64| {
        let (sine, cosine) = (0.5 + 10.0 * t).sin_cos();
        let root = (0.09 - 0.01 * sine * sine).sqrt();
        // Derivatives with respect to the crank's angle, then with respect to time.
        let first = -0.1 * sine - 0.01 * sine * cosine / root;
        let second = -0.1 * cosine
            - 0.01
                * ((cosine * cosine - sine * sine) / root
                    + 0.01 * (sine * cosine).powi(2) / root.powi(3));
        Target { value: 0.1 * cosine + root, rate: 10.0 * first, acceleration: 100.0 * second }
    };
    struct Both<F>(F);
    impl<F: Fn(f64) -> Target<f64>> Inputs for Both<F> {
        fn efforts(&mut self, _view: &View<'_>, _efforts: &mut [f64]) {}
        fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
            targets[0] = Target { value: 0.5 + 10.0 * time, rate: 10.0, acceleration: 0.0 };
            targets[1] = (self.0)(time);
        }
    }
    let known = [Known {
        coordinate: Coordinate::Joint { joint: model.mechanism().joint_id("A").unwrap(), dof: 0 },
        value: Some(0.5),
        rate: Some(10.0),
    }];
    let mut leads = Both(slide);
    let state = model.assemble_from(&[], &known).unwrap();
    let mut simulation = model.start(0.0, state, Settings::default(), &mut leads).unwrap();
    for time in [0.02, 0.1, 0.2] {
        simulation.advance(time, &mut leads).unwrap();
        let now = simulation.instant();
        assert_eq!(now.open_drives, 1);
        let (turns, slides) = (10.0, slide(time).rate);
        let [torque, force] = now.drives[..] else { panic!() };
        let length = model.parameters().length;
        let off = torque / length * slides / length - force * turns;
        assert!(off.abs() < 1e-9 * (force * turns).abs(), "{off} {torque} {force}");
    }
    let turnover = simulation.energies().turnover;
    assert!(simulation.energy_error().abs() < 1e-9 * turnover);
}
