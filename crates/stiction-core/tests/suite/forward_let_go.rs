//! The instant of slip onset, and the friction coefficient of the sliding that follows.

use crate::common::*;
use stiction_core::forward::{EventKind, Forward, Inputs, Settings, Simulation, View};
use stiction_core::friction::{Curve, Exponent, Law};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{State, Target};
use stiction_core::mechanism::{BodySpec, JointSpec, MechanismBuilder};
use stiction_core::spatial::{Pose, Vec3};

const G: f64 = 9.81;
const ARM: f64 = 0.5;
const INERTIA: f64 = 0.02;
const RADIUS: f64 = 0.02;
const BEGINS: f64 = 1.0;

/// Prescribes the motion of a cart from rest at `BEGINS`, along a polynomial of fifth degree. The
/// acceleration, and with it the moment at the pivot of the hanging bob, begins as a ramp.
struct Led {
    way: f64,
    takes: f64,
}

impl Inputs for Led {
    fn efforts(&mut self, _view: &View<'_>, _efforts: &mut [f64]) {}

    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        let u = ((time - BEGINS) / self.takes).clamp(0.0, 1.0);
        targets[0] = Target {
            value: self.way * u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u),
            rate: self.way / self.takes * 30.0 * (u * (1.0 - u)).powi(2),
            acceleration: self.acceleration(time),
        };
    }

    fn seen_until(&self, time: f64) -> f64 {
        let knots = [BEGINS, BEGINS + self.takes];
        knots.into_iter().find(|knot| *knot > time).unwrap_or(f64::INFINITY)
    }
}

impl Led {
    fn acceleration(&self, time: f64) -> f64 {
        let u = ((time - BEGINS) / self.takes).clamp(0.0, 1.0);
        self.way / self.takes.powi(2) * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)
    }

    /// Computes the instant at which the moment at the pivot of the hanging bob of 1 kg exceeds the
    /// static limit: m a L = mu r m sqrt(g^2 + a^2).
    fn lets_go(&self, at_rest: f64) -> f64 {
        let (mut low, mut high) = (BEGINS, BEGINS + 0.2 * self.takes);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            let a = self.acceleration(middle);
            if a * ARM > at_rest * RADIUS * a.hypot(G) { high = middle } else { low = middle }
        }
        high
    }

    /// Computes angle and rate of the bob, which swings backward, at a time before it turns back.
    /// Uses the fourth-order Runge-Kutta method from the slip onset.
    fn swing(&self, law: &Law, until: f64) -> [f64; 2] {
        let steps = 20_000;
        let begins = self.lets_go(law.at_rest());
        let h = (until - begins) / f64::from(steps);
        let slope = |t: f64, [angle, rate]: [f64; 2]| {
            let (a, (sine, cosine)) = (self.acceleration(t), angle.sin_cos());
            let mut turn = 0.0;
            // The normal load depends on the acceleration through the small radius. Each iteration
            // gains two digits.
            for _ in 0..12 {
                let x = a + ARM * (turn * cosine - rate * rate * sine);
                let y = G + ARM * (turn * sine + rate * rate * cosine);
                let rub = RADIUS * law.sliding(-rate * RADIUS).force(x.hypot(y));
                turn = (rub - ARM * (a * cosine + G * sine)) / (INERTIA + ARM * ARM);
            }
            [rate, turn]
        };
        let beside = |y: [f64; 2], k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
        let mut y = [0.0, 0.0];
        for n in 0..steps {
            let t = begins + h * f64::from(n);
            let k1 = slope(t, y);
            let k2 = slope(t + 0.5 * h, beside(y, k1, 0.5 * h));
            let k3 = slope(t + 0.5 * h, beside(y, k2, 0.5 * h));
            let k4 = slope(t + h, beside(y, k3, h));
            y = [0, 1].map(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
        y
    }
}

fn cart(law: Law) -> Forward {
    let x = along(Vec3::zero(), Vec3::unit(0));
    let at = Pose::identity();
    let mut pivot = friction(0.0, 0.0, Some(RADIUS));
    pivot.law = law;
    let mechanism = MechanismBuilder::new("cart")
        .gravity(v(0.0, -G, 0.0))
        .body(BodySpec::new("cart").mass(3.0).inertia(diagonal(0.1, 0.1, 0.1)))
        .body(
            BodySpec::new("bob")
                .mass(1.0)
                .com(v(0.0, -ARM, 0.0))
                .inertia(diagonal(INERTIA, INERTIA, INERTIA)),
        )
        .joint(
            JointSpec::new("guide", JointType::Prismatic, "ground", "cart").frames(x, x).actuated(),
        )
        .joint(
            JointSpec::new("pivot", JointType::Revolute, "cart", "bob")
                .frames(at, at)
                .friction(pivot),
        )
        .build()
        .unwrap();
    Forward::new(mechanism, &[0])
}

/// Simulates up to the time `until` with rows at intervals `every`.
fn simulate<'a>(model: &'a Forward, led: &mut Led, every: f64, until: f64) -> Simulation<'a> {
    let state = State::new(model.topology());
    let mut simulation =
        model.start(0.0, state, Settings { relative: 1e-12, ..Settings::default() }, led).unwrap();
    let mut row = 1.0;
    while every * row < until {
        simulation.advance(every * row, led).unwrap();
        row += 1.0;
    }
    simulation.advance(until, led).unwrap();
    simulation
}

fn law(at_rest: f64, sliding: f64, viscous: f64) -> Law {
    let mut law = Law::coulomb_viscous(sliding, viscous);
    if at_rest != sliding {
        law.curve = Curve::Static { mu_static: at_rest };
    }
    law
}

/// The result must not depend on the row interval or on the rate of loading.
#[test]
fn sliding_begins_where_friction_is_at_its_limit() {
    for (way, takes) in [(0.2, 0.02), (0.2, 1.0), (-0.05, 0.3)] {
        for law in
            [law(0.2, 0.2, 0.0), law(0.2, 0.2, 5.0), law(0.3, 0.1, 0.0), law(0.02, 0.01, 0.0)]
        {
            let model = cart(law.clone());
            let mut led = Led { way, takes };
            let expected = Led { way: way.abs(), takes }.lets_go(law.at_rest());
            for every in [0.0003, 0.001, 0.003, 0.04, 0.5] {
                let simulation = simulate(&model, &mut led, every, BEGINS + 0.5 * takes);
                let slides =
                    simulation.events().iter().find(|e| matches!(e.kind, EventKind::Slides { .. }));
                let time = slides.unwrap().time;
                // Slip onset is detected at a relative excess of 1e-9 over the limit. The curved
                // ramp takes slightly longer to reach this excess.
                assert!(
                    (time - expected).abs() < 2e-9 * (expected - BEGINS) + 1e-14,
                    "{way} {takes} {every}: {time} {expected}"
                );
            }
        }
    }
}

/// From the first instant of sliding, friction follows the sliding law, whether its coefficient is
/// lower than at rest or grows with speed.
#[test]
fn slip_continues_with_sliding_friction() {
    let mut stribeck = law(0.2, 0.2, 0.0);
    stribeck.curve = Curve::Stribeck { mu_static: 0.5, velocity: 1e-3, exponent: Exponent::Two };
    let weak = law(0.02, 0.01, 0.0);
    let viscous = law(0.2, 0.2, 20.0);
    let fast = [law(0.5, 0.2, 0.0), viscous.clone(), stribeck.clone()];
    let gentle = [law(0.5, 0.2, 0.0), viscous, stribeck, weak];
    for (takes, passes, laws) in [(0.02, 0.005, &fast[..]), (1.0, 0.1, &gentle)] {
        for law in laws {
            let model = cart(law.clone());
            let mut led = Led { way: 0.2, takes };
            let until = BEGINS + passes;
            let [angle, rate] = led.swing(law, until);
            for every in [0.001, 0.003, 0.5] {
                let simulation = simulate(&model, &mut led, every, until);
                let state = &simulation.instant().state;
                let (off, slow) = (state.coordinates[1] - angle, state.rates[1] - rate);
                // Errors of a thousand steps with this tolerance, or the delay of the slip onset by
                // 1e-9 of the limit.
                let most = 1e-9 * rate.abs();
                assert!(
                    slow.abs() < most && off.abs() < most * passes,
                    "{every} {off:e} {slow:e} {law:?}"
                );
            }
        }
    }
}
