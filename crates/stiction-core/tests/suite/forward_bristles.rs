//! Friction laws with an internal state in the time stepper: reference R12, stick-slip of the LuGre
//! model.

use crate::common::*;
use stiction_core::forward::{Forward, Inputs, Method, Settings, View};
use stiction_core::friction::{Bristles, Curve, Exponent, JointFriction, Law};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{State, Target};
use stiction_core::mechanism::{BodySpec, JointSpec, MechanismBuilder, SpringSpec};
use stiction_core::spatial::Vec3;

/// Pulls the end of the spring at a constant speed.
struct SpringForce(f64);

impl Inputs for SpringForce {
    fn efforts(&mut self, _: &View<'_>, _: &mut [f64]) {}
    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        targets[0] = Target { value: self.0 * time, rate: self.0, acceleration: 0.0 };
    }
}

/// Creates reference R12 (Canudas de Wit 1995, table I): a mass of 1 kg pulled through a spring of
/// 2 N/m at 0.1 m/s. The normal load is 1 N, so that friction coefficients equal forces in N.
fn stick_slip() -> Forward {
    let x = along(Vec3::zero(), Vec3::unit(0));
    let law = Law {
        curve: Curve::Stribeck { mu_static: 1.5, velocity: 0.001, exponent: Exponent::Two },
        bristles: Some(Bristles { stiffness: 1e5, damping: 1e5_f64.sqrt() }),
        ..Law::coulomb_viscous(1.0, 0.4)
    };
    let interface = JointFriction::guide(law);
    let mechanism = MechanismBuilder::new("stick-slip")
        .gravity(v(0.0, -1.0, 0.0))
        .body(BodySpec::new("cart").mass(1.0).inertia(diagonal(0.1, 0.1, 0.1)))
        .body(BodySpec::new("mass").mass(1.0).inertia(diagonal(0.1, 0.1, 0.1)))
        .joint(
            JointSpec::new("pull", JointType::Prismatic, "ground", "cart").frames(x, x).actuated(),
        )
        .joint(
            JointSpec::new("table", JointType::Prismatic, "ground", "mass")
                .frames(x, x)
                .friction(interface),
        )
        .spring(
            SpringSpec::new("spring", "mass", "cart")
                .points(Vec3::zero(), v(1.0, 0.0, 0.0))
                .stiffness(2.0, 1.0),
        )
        .build()
        .unwrap();
    Forward::new(mechanism, &[0])
}

/// Integrates the same law in one variable by the Runge-Kutta method with a step within its
/// stability limit. Returns position, speed and bristle deflection of the mass.
fn by_hand(until: f64) -> [f64; 3] {
    let (s0, s1, s2, vs) = (1e5, 1e5_f64.sqrt(), 0.4, 0.001);
    let rate = |t: f64, [x, v, z]: [f64; 3]| {
        let g = 1.0 + 0.5 * (-(v / vs) * (v / vs)).exp();
        let dz = v - s0 * v.abs() * z / g;
        [v, 2.0 * (0.1 * t - x) - (s0 * z + s1 * dz + s2 * v), dz]
    };
    let h = 2e-5;
    let mut y = [0.0; 3];
    let steps = (until / h).round() as usize;
    let plus = |y: [f64; 3], k: [f64; 3], h: f64| [0, 1, 2].map(|i| y[i] + h * k[i]);
    for n in 0..steps {
        let t = h * n as f64;
        let k1 = rate(t, y);
        let k2 = rate(t + 0.5 * h, plus(y, k1, 0.5 * h));
        let k3 = rate(t + 0.5 * h, plus(y, k2, 0.5 * h));
        let k4 = rate(t + h, plus(y, k3, h));
        for i in 0..3 {
            y[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    y
}

/// The mass sticks at 5 s (the pull is 1 N, less than 1.5 N) and has slipped by 10 s. Deflections
/// follow the sliding within 1e-5 s; an explicit method must resolve this time, the time stepper
/// need not.
#[test]
fn r12_lugre_sticks_and_slips() {
    let model = stick_slip();
    let at = [5.0, 10.0].map(|until| (until, by_hand(until)));
    let run = |method: Method| {
        let settings = Settings {
            relative: 1e-8,
            absolute: 1e-10,
            method,
            time_step_tolerance: 1e-7,
            ..Settings::default()
        };
        let mut state = State::new(model.topology());
        state.rates[0] = 0.1;
        let mut pull = SpringForce(0.1);
        let mut simulation = model.start(0.0, state, settings, &mut pull).unwrap();
        let errors = at.map(|(until, [x, speed, _])| {
            simulation.advance(until, &mut pull).unwrap();
            let State { coordinates, rates, .. } = &simulation.instant().state;
            println!("{method:?} {until}: {} {x}, {} {speed}", coordinates[1], rates[1]);
            (coordinates[1] - x).abs()
        });
        println!("{method:?}: {errors:?}, {} evaluations", simulation.evaluations());
        (errors, simulation.evaluations())
    };
    let (events, many) = run(Method::EventDriven);
    // The steps of the explicit solution are about half of the shortest time constant, g /
    // (stiffness v), so its own error is 1e-6.
    assert!(events.iter().all(|e| *e < 1e-6), "{events:?}");
    let (steps, few) = run(Method::TimeStepping);
    // Convergence is of first order: the slip onset depends on the last digits of the limit.
    assert!(steps[0] < 1e-6 && steps[1] < 1e-2, "{steps:?}");
    assert!(few < many / 4, "{few} {many}");
}
