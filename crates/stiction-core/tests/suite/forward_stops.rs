//! Plates and balls that slide to rest, against closed forms: instant and position of the stop,
//! independent of the row interval.

use crate::common::*;
use stiction_core::forward::{
    ConstantEfforts, EventKind, Forward, InterfaceMode as Doing, Settings, Simulation,
};
use stiction_core::friction::{JointFriction, Law};
use stiction_core::joint::JointType;
use stiction_core::kinematics::State;
use stiction_core::mechanism::{BodySpec, JointSpec, MechanismBuilder};
use stiction_core::spatial::Mat3;

const G: f64 = 9.81;
const MASS: f64 = 2.0;

fn rub(mu: f64, radius: f64) -> JointFriction {
    JointFriction::round(radius, Law::coulomb_viscous(mu, 0.0))
}

/// Creates a body on a plane through its centre of mass, with the slope `slope` towards x, or in a
/// ball joint at that position.
fn body(joint: JointType, (mu, radius): (f64, f64), inertia: Mat3<f64>, slope: f64) -> Forward {
    let mechanism = MechanismBuilder::new("body")
        .gravity(v(G * slope.sin(), 0.0, -G * slope.cos()))
        .body(BodySpec::new("body").mass(MASS).inertia(inertia))
        .joint(JointSpec::new("contact", joint, "ground", "body").friction(rub(mu, radius)))
        .build()
        .unwrap();
    Forward::new(mechanism, &[])
}

/// Advances in intervals of length `stretch`, as for rows with this spacing.
fn run<'a>(model: &'a Forward, rates: [f64; 3], stretch: f64, until: f64) -> Simulation<'a> {
    let mut state = State::new(model.topology());
    state.rates.copy_from_slice(&rates);
    let mut inputs = ConstantEfforts(vec![]);
    let mut simulation = model.start(0.0, state, Settings::default(), &mut inputs).unwrap();
    let mut row = 0;
    while simulation.instant().time < until {
        row += 1;
        simulation.advance((f64::from(row) * stretch).min(until), &mut inputs).unwrap();
    }
    simulation
}

/// Returns the instant of the only stop, s.
fn stop(simulation: &Simulation<'_>) -> f64 {
    let stops: Vec<f64> = simulation
        .events()
        .iter()
        .map(|event| {
            assert!(matches!(event.kind, EventKind::Sticks { .. }), "{event:?}");
            event.time
        })
        .collect();
    assert_eq!(stops.len(), 1, "{:?}", simulation.events());
    assert!(matches!(simulation.interfaces()[0], Doing::Sticks));
    assert!(simulation.instant().state.rates.iter().all(|rate| *rate == 0.0));
    stops[0]
}

/// Tolerance of stop times, s. Velocities are accurate to 1e-10, and so are the instants at which
/// they vanish.
const SHARP: f64 = 1e-9;
const STRETCHES: [f64; 5] = [1e-3, 7e-3, 0.01, 0.1, 10.0];

fn account_closes(simulation: &Simulation<'_>) {
    let (error, turnover) = (simulation.energy_error(), simulation.energies().turnover);
    assert!(error.abs() < 1e-9 * turnover, "{error} of {turnover}");
}

#[test]
fn a_plate_stops_after_the_time_and_distance_of_its_deceleration() {
    let (mu, time) = (0.3, 1.0 / (0.3 * G));
    let model = body(JointType::Planar, (mu, 0.02), diagonal(0.1, 0.1, 0.1), 0.0);
    for rates in [[1.0, 0.0, 0.0], [0.6, -0.8, 0.0], [-0.28, 0.96, 0.0]] {
        for stretch in STRETCHES {
            let simulation = run(&model, rates, stretch, 0.7);
            let found = stop(&simulation);
            println!("{rates:?} {stretch}: off {:.1e} s", found - time);
            assert!((found - time).abs() < SHARP, "{rates:?} {stretch}: {found} {time}");
            for (q, rate) in simulation.instant().state.coordinates.iter().zip(rates) {
                assert!((q - 0.5 * time * rate).abs() < SHARP, "{q}");
            }
            account_closes(&simulation);
        }
    }
}

/// A plate slides on a slope below the friction angle, with an initial velocity across the slope,
/// so that its path bends. With the accelerations `a` due to the slope and `p` due to friction, the
/// sum `p |v| + a v_x` decreases at the constant rate `p^2 - a^2`.
#[test]
fn a_plate_thrown_across_a_slope_bends_its_way_and_stops_in_time() {
    for (mu, slope) in [(0.3, 0.1), (0.3, 0.25), (0.5, 0.02)] {
        let (p, a) = (mu * G * f64::cos(slope), G * f64::sin(slope));
        let model = body(JointType::Planar, (mu, 0.02), diagonal(0.1, 0.1, 0.1), slope);
        for angle in [0.3_f64, 1.2, 2.0, 3.0] {
            let rates = [angle.cos(), angle.sin(), 0.0];
            let time = (p + a * rates[0]) / (p * p - a * a);
            for stretch in STRETCHES {
                let simulation = run(&model, rates, stretch, 1.3 * time);
                let found = stop(&simulation);
                println!("{mu} {slope} {angle} {stretch}: off {:.1e} s", found - time);
                assert!((found - time).abs() < SHARP, "{stretch}: {found} {time}");
                account_closes(&simulation);
            }
        }
    }
}

/// For a disc that slides and spins, both motions stop at the same time. With `k = m r^2 / I`, the
/// rim speed of the spin decreases as the `k`-th power of the sliding speed. The stopping time is
/// therefore `1 / (mu g)` times the integral of `sqrt(1 + (u/v)^2 x^(2 (k - 1)))` over `x` from 0
/// to 1.
#[test]
fn a_disc_that_slides_and_spins_stops_both_at_once() {
    let (mu, radius) = (0.2, 0.05);
    let simpson = |f: &dyn Fn(f64) -> f64| {
        let n = 2000;
        let at = |k: usize| f(k as f64 / n as f64);
        let weight = |k: usize| if k == 0 || k == n { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
        (0..=n).map(|k| weight(k) * at(k)).sum::<f64>() / (3.0 * n as f64)
    };
    for (k, sliding, spinning) in
        [(1.0, 1.0, 0.5), (2.0, 0.8, 0.9), (3.0, 0.1, 1.0), (0.5, 0.9, 0.8)]
    {
        // Larger initial speeds prolong the stop; for `k` below one, the sliding decreases faster.
        let (first, other, power): (f64, f64, f64) =
            if k >= 1.0 { (sliding, spinning, k) } else { (spinning, sliding, 1.0 / k) };
        let ratio = other / first;
        let shape = simpson(&|x| (1.0 + (ratio * x.powf(power - 1.0)).powi(2)).sqrt());
        let slows = if k >= 1.0 { mu * G } else { k * mu * G };
        let time = first / slows * shape;
        let inertia = MASS * radius * radius / k;
        let model = body(JointType::Planar, (mu, radius), diagonal(inertia, inertia, inertia), 0.0);
        for stretch in STRETCHES {
            let rates = [0.6 * sliding, 0.8 * sliding, spinning / radius];
            let simulation = run(&model, rates, stretch, 1.3 * time);
            let found = stop(&simulation);
            println!("{k} {stretch}: off {:.1e} s", found - time);
            assert!((found - time).abs() < SHARP, "{k} {stretch}: {found} {time}");
            account_closes(&simulation);
        }
    }
}

/// The stopping time of a ball about any axis is `I omega / (mu m g r)`.
#[test]
fn a_ball_turns_to_rest_in_time() {
    let (mu, radius, inertia) = (0.2, 0.03, 4e-3);
    let model = body(JointType::Spherical, (mu, radius), diagonal(inertia, inertia, inertia), 0.0);
    for rates in [[0.0, 0.0, 3.0], [1.0, -2.0, 2.0], [0.48, 1.44, -2.598_999_807_618_3]] {
        let speed = v(rates[0], rates[1], rates[2]).norm();
        let time = inertia * speed / (mu * MASS * G * radius);
        for stretch in STRETCHES {
            let simulation = run(&model, rates, stretch, 2.0 * time);
            let found = stop(&simulation);
            println!("{rates:?} {stretch}: off {:.1e} s", found - time);
            assert!((found - time).abs() < SHARP, "{rates:?} {stretch}: {found} {time}");
            let turned = simulation.instant().bodies.pose[1].rotation.rotation_vector().norm();
            assert!((turned - 0.5 * speed * time).abs() < SHARP, "{turned}");
            account_closes(&simulation);
        }
    }
}
