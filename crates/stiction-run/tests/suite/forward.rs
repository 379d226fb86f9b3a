//! Controllers in simulations, against recurrences solved by hand.

use crate::common::slide;
use stiction_format::{Control, LoadCase, ModelFile, Motion, Source};
use stiction_run::forward::{Ending, Job, Recorder, Rows, Start};
use stiction_run::{Sink, SinkError};

const MASS: f64 = 2.0;

/// Position, rate and effort of every sample of a simulation.
struct All(Vec<[f64; 3]>);

impl Sink<Rows> for All {
    fn add(&mut self, rows: &Rows) -> Result<(), SinkError> {
        self.0.push([rows.forward[0], rows.forward[1], rows.forward[3]]);
        Ok(())
    }
}

struct Given {
    model: ModelFile,
    motion: Motion,
    control: Control,
}

impl Given {
    fn new(friction: &str, motion: &str, control: &str) -> Self {
        let none = |_: &str| Err("no files".to_owned());
        let model = slide(friction, "");
        let motion = model.parse_motion(&Source::new("--motion", motion), &none).unwrap();
        let control = model.parse_control(&Source::new("--controller", control), &none).unwrap();
        Self { model, motion, control }
    }

    /// Returns position, rate and effort at every sample of a simulation.
    fn run(&self, start: Start<'_>, step: f64) -> Vec<[f64; 3]> {
        let load = LoadCase::default();
        let job = Job {
            motion: Some(&self.motion),
            control: Some(&self.control),
            start,
            until: self.motion.duration,
            step,
            ..Job::new(&self.model, ("none", &load))
        };
        let mut recorder = Recorder::new(&job, All(Vec::new()));
        let outcome = job.run(|sample, _| recorder.add(sample), &|| false, None);
        assert!(matches!(outcome.unwrap().ending, Ending::Reached));
        recorder.sink.0
    }
}

/// Returns position and rate of a mass after a period with constant effort.
fn held(position: f64, rate: f64, effort: f64, period: f64) -> (f64, f64) {
    let acceleration = effort / MASS;
    (position + rate * period + 0.5 * acceleration * period * period, rate + acceleration * period)
}

fn wanted(t: f64) -> (f64, f64) {
    (0.05 * (3.0 * t).sin(), 0.15 * (3.0 * t).cos())
}

const SWAY: &str = "slide = 50 mm*sin(3*t); duration = 0.8 s";

#[test]
fn a_pd_controller_agrees_with_its_recurrence() {
    let period = 4e-3;
    let control = "type = pd; period = 4 ms; kp = 3 kN/m; kd = 120 N s/m";
    let given = Given::new("", SWAY, control);
    let found = given.run(Start::AtRest, period);
    assert_eq!(found.len(), 201);
    let (mut position, mut rate) = (0.0, 0.0);
    for (k, row) in found.iter().enumerate() {
        let (r, dr) = wanted(k as f64 * period);
        let effort = 3000.0 * (r - position) + 120.0 * (dr - rate);
        // The steps of the integrator are exact for parabolas.
        for (found, expected) in row.iter().zip([position, rate, effort]) {
            assert!((found - expected).abs() < 1e-10 * expected.abs().max(1.0), "{k}: {row:?}");
        }
        (position, rate) = held(position, rate, effort, period);
    }
}

/// Tests a controller whose measured position is quantised, whose rates are differences of this
/// position, and whose effort is limited.
#[test]
fn quantisation_differences_and_saturation_are_in_the_recurrence() {
    let period = 5e-3;
    let control =
        "type = pd; period = 5 ms; kp = 3 kN/m; kd = 60 N s/m; resolution = 0.23 mm; limit = 9 N";
    let given = Given::new("", SWAY, control);
    let found = given.run(Start::AtRest, period);
    let (mut position, mut rate) = (0.0_f64, 0.0_f64);
    let mut before: Option<f64> = None;
    let mut saturated = 0;
    for (k, row) in found.iter().enumerate() {
        let (r, dr) = wanted(k as f64 * period);
        let measured = (position / 2.3e-4).round() * 2.3e-4;
        let difference = before.map_or(0.0, |before| (measured - before) / period);
        before = Some(measured);
        let asked = 3000.0 * (r - measured) + 60.0 * (dr - difference);
        let effort = asked.clamp(-9.0, 9.0);
        saturated += usize::from(asked != effort);
        for (found, expected) in row.iter().zip([position, rate, effort]) {
            assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{k}: {row:?}");
        }
        (position, rate) = held(position, rate, effort, period);
    }
    assert!((5..found.len()).contains(&saturated), "{saturated}");
}

/// Tests the default gains, which follow from bandwidth and damping: kp = m w^2, kd = 2 m z w.
#[test]
fn usual_gains_are_those_of_the_mass() {
    let by_bandwidth = Given::new("", SWAY, "type = pd; bandwidth = 4 Hz; damping = 0.8");
    let omega = std::f64::consts::TAU * 4.0;
    let gains = format!(
        "type = pd; kp = {:?} N/m; kd = {:?} N s/m",
        MASS * omega * omega,
        1.6 * MASS * omega
    );
    let by_gains = Given::new("", SWAY, &gains);
    let (a, b) = (by_bandwidth.run(Start::AtRest, 0.01), by_gains.run(Start::AtRest, 0.01));
    for (a, b) in a.iter().zip(&b) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
    }
}

/// Tests the tracking error due to friction F at constant speed: F/(m w^2) with computed torque,
/// and zero with friction feed-forward.
#[test]
fn friction_causes_a_tracking_error_of_computed_torque() {
    let friction = "friction = { mu = 0.3 }";
    let ramp = "slide = 0.2 m/s*t; duration = 2 s";
    let omega = std::f64::consts::TAU * 5.0;
    let lag = 0.3 * 10.0 / (omega * omega);
    for (feed, expected) in [("off", lag), ("reference", 0.0), ("measured", 0.0)] {
        let control =
            format!("type = computed-torque; friction = {feed}; bandwidth = 5 Hz; period = 1 ms");
        let found = Given::new(friction, ramp, &control).run(Start::Moving, 0.1);
        let end = found.last().unwrap();
        // After 2 s, ten periods of the closed loop, the transient has decayed to exp(-60).
        assert!((0.4 - end[0] - expected).abs() < 1e-12, "{feed}: {end:?}");
        assert!((end[2] - 6.0).abs() < 1e-9, "{feed}: {end:?}");
    }
}
