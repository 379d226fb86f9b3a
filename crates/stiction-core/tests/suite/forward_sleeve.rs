//! A shaft in a sleeve, with one friction force along the resultant of turning and sliding.

use crate::common::*;
use stiction_core::forward::{Forward, Inputs, Method, Settings, View};
use stiction_core::friction::{JointFriction, Law};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{State, Target};
use stiction_core::mechanism::{BodySpec, JointSpec, MechanismBuilder};
use stiction_core::spatial::Vec3;

const MASS: f64 = 2.0;
const RADIUS: f64 = 0.01;
const MU: f64 = 0.1;
/// Weight perpendicular to the shaft, N.
const LOAD: f64 = 200.0;

/// Creates a shaft whose surface has the same effective mass in both directions: the moment of
/// inertia is the mass times the square of the sleeve's radius.
fn shaft(prescribed: &[usize]) -> Forward {
    let x = along(Vec3::zero(), Vec3::unit(0));
    let mechanism = MechanismBuilder::new("shaft")
        .gravity(v(0.0, -LOAD / MASS, 0.0))
        .body(BodySpec::new("shaft").mass(MASS).inertia(diagonal(
            MASS * RADIUS * RADIUS,
            1e-2,
            1e-2,
        )))
        .joint(
            JointSpec::new("sleeve", JointType::Cylindrical, "ground", "shaft")
                .frames(x, x)
                .actuated()
                .friction(JointFriction::sleeve(RADIUS, Law::coulomb_viscous(MU, 0.0))),
        )
        .build()
        .unwrap();
    Forward::new(mechanism, prescribed)
}

/// Applies constant efforts, and prescribes a slide that begins to accelerate at 0.05 s.
struct Given([f64; 2]);

const BEGINS: f64 = 0.05;
const PRESCRIBED: f64 = 0.2;

impl Inputs for Given {
    fn efforts(&mut self, _view: &View<'_>, efforts: &mut [f64]) {
        efforts.copy_from_slice(&self.0);
    }
    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        let since = (time - BEGINS).max(0.0);
        let acceleration = if time < BEGINS { 0.0 } else { PRESCRIBED };
        for target in targets {
            let (value, rate) = (0.5 * PRESCRIBED * since * since, PRESCRIBED * since);
            *target = Target { value, rate, acceleration };
        }
    }
}

/// Computes the state at time `until` for initial rates and constant efforts of `[angle, slide]`.
fn moved(
    model: &Forward,
    method: Method,
    rates: [f64; 2],
    efforts: [f64; 2],
    until: f64,
) -> [f64; 4] {
    let mut inputs = Given(efforts);
    let mut state = State::new(model.topology());
    state.rates.copy_from_slice(&rates);
    let settings = Settings { method, ..Settings::default() };
    let mut simulation = model.start(0.0, state, settings, &mut inputs).unwrap();
    for k in 1..=20 {
        simulation.advance(until * f64::from(k) / 20.0, &mut inputs).unwrap();
    }
    let now = &simulation.instant().state;
    [now.coordinates[0], now.coordinates[1], now.rates[0], now.rates[1]]
}

const METHODS: [Method; 2] = [Method::EventDriven, Method::TimeStepping];

/// The surface velocity keeps its direction and decreases by `mu N / m` per second until it stops.
#[test]
fn a_shaft_coasts_along_the_resultant() {
    let model = shaft(&[]);
    let slows = MU * LOAD / MASS;
    for method in METHODS {
        for [turn, slide] in [[40.0, 0.3], [-25.0, 0.02], [0.0, 0.4], [30.0, 0.0]] {
            let speed = f64::hypot(RADIUS * turn, slide);
            for part in [0.6, 1.5] {
                let time = part * speed / slows;
                let found = moved(&model, method, [turn, slide], [0.0; 2], time);
                let left = (1.0 - part).max(0.0);
                let way = 0.5 * speed / slows * (1.0 - left * left);
                let expected = [turn * way, slide * way, turn * left, slide * left];
                for (found, (expected, scale)) in
                    found.iter().zip(expected.iter().zip([1.0, RADIUS, 40.0, 0.4]))
                {
                    // A time step has a relative error of 1e-7; the stop lies within one step.

                    let tolerance = if method == Method::TimeStepping { 1e-6 } else { 1e-9 };
                    assert!(
                        (found - expected).abs() < tolerance * scale,
                        "{method:?}: {found} {expected}"
                    );
                }
            }
        }
    }
}

/// Static friction bounds the resultant: 0.6 and 0.7 of the limit together do not exceed it, 0.7
/// and 0.8 do. The shaft then starts to slide along their resultant.
#[test]
fn a_shaft_holds_up_to_the_resultant() {
    let model = shaft(&[]);
    let limit = MU * LOAD;
    for method in METHODS {
        for [turn, slide] in [[0.6, 0.7], [0.7, 0.8], [0.0, 1.01], [-0.8, 0.8], [0.99, 0.0]] {
            let resultant = f64::hypot(turn, slide);
            let excess = (resultant - 1.0).max(0.0) * limit / MASS;
            let efforts = [turn * limit * RADIUS, slide * limit];
            let found = moved(&model, method, [0.0; 2], efforts, 0.1);
            let expected = [turn, slide].map(|part| 0.1 * excess * part / resultant);
            let rates = [found[2] * RADIUS, found[3]];
            for (found, expected) in rates.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9, "{method:?}: {found} {expected}");
            }
            if excess == 0.0 {
                assert_eq!(found, [0.0; 4], "{method:?}");
            }
        }
    }
}

/// A rotation is held by static friction against a torque. When a prescribed slide begins to move,
/// it also causes slip of the rotation. The free rotation then accelerates such that `r alpha / a`
/// is the tangent of the direction of the surface velocity, with `I alpha = T - r mu N sin`.
#[test]
fn a_prescribed_slide_lets_the_rotation_go() {
    let model = shaft(&[1]);
    let torque = 0.5 * MU * LOAD * RADIUS;
    // The direction is computed by bisection.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let sine = 0.5 * (low + high);
        let alpha = (torque - RADIUS * MU * LOAD * sine) / (MASS * RADIUS * RADIUS);
        let steep = RADIUS * alpha / PRESCRIBED > sine / f64::sqrt(1.0 - sine * sine);
        if steep { low = sine } else { high = sine }
    }
    let alpha = (torque - RADIUS * MU * LOAD * low) / (MASS * RADIUS * RADIUS);
    // The direction changes abruptly when the slide begins. Event-driven integration alone is too
    // stiff there; the automatic method uses time steps.
    for method in [Method::Automatic, Method::TimeStepping] {
        let found = moved(&model, method, [0.0; 2], [torque, 0.0], 0.15);
        let since = 0.15 - BEGINS;
        assert!((found[3] - PRESCRIBED * since).abs() < 1e-12, "{method:?}: {found:?}");
        let turned = found[2] / (alpha * since) - 1.0;
        assert!(turned.abs() < 1e-5, "{method:?}: {turned}");
    }
}
