//! Simulations of the 3-RPS robot with dry friction in all of its joints: a motion that sticks and
//! slips, and several states in which the robot remains stuck.
//!
//! The actuators carry the weight and oscillate. In the moving simulation, springs and dampers in
//! the actuators keep the robot near its position, and the robot stops at every reversal.
//! `cargo bench -p stiction-run --bench forward` prints the number of events and evaluations, and
//! measures the time.

use criterion::{Criterion, criterion_group, criterion_main};
use stiction_core::dynamics::{FrictionMode, InverseDynamics};
use stiction_core::forward::{ConstantEfforts, Forward, Inputs, Settings, View};
use stiction_core::kinematics::{State, Target};
use stiction_format::{Source, gallery, read};

/// Angular frequency of the oscillating efforts, rad/s. The efforts of the actuators are one third
/// of a period apart.
const RATE: f64 = 3.0;
/// Stiffness, N/m, of the springs that keep the actuators near their positions.
const STIFFNESS: f64 = 3000.0;
/// Damping, N s/m, of the dampers that keep the actuators near their positions.
const DAMPING: f64 = 100.0;

struct Swing {
    mean: Vec<f64>,
    amplitude: f64,
    /// Positions of the actuators at the start, m; empty until they are known.
    home: Vec<f64>,
}

impl Inputs for Swing {
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        for (k, (effort, mean)) in efforts.iter_mut().zip(&self.mean).enumerate() {
            let phase = std::f64::consts::TAU * k as f64 / self.mean.len() as f64;
            let away = self.home.get(k).map_or(0.0, |home| view.actuator_coordinate(k) - home);
            let servo = -STIFFNESS * away - DAMPING * view.actuator_rate(k);
            *effort = mean + self.amplitude * (RATE * view.time + phase).sin() + servo;
        }
    }

    fn change(&mut self, view: &View<'_>) {
        if self.home.is_empty() {
            self.home = (0..self.mean.len()).map(|k| view.actuator_coordinate(k)).collect();
        }
    }
}

/// Creates the robot at rest in the first position of its motion, with the actuator forces that
/// carry its weight.
fn robot() -> (Forward, State<f64>, Vec<f64>) {
    let text = gallery::get("3rps").expect("it is in the gallery");
    let model = read(&Source::new("3rps", text), &|_| Err("no files".into())).expect("it is right");
    let motion = model.motion(model.default_motion.as_deref().unwrap()).unwrap();
    let still = |at: Target<f64>| Target { rate: 0.0, acceleration: 0.0, ..at };
    let targets: Vec<_> = motion.at(0.0).map(still).collect();
    let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
    let settings =
        stiction_core::dynamics::Settings { friction: FrictionMode::Off, ..Default::default() };
    let (mechanism, initial_poses) = (model.mechanism.clone(), &model.initial_poses);
    let mut solver =
        InverseDynamics::new(mechanism.clone(), initial_poses, &coordinates, &targets, settings)
            .unwrap();
    let weight = solver.solve(&[]).unwrap().efforts.clone();
    let forward = Forward::new(mechanism, &[]);
    let state = forward.assemble(initial_poses, &coordinates, &targets).unwrap();
    (forward, state, weight)
}

/// Simulates with samples every hundredth of a second, and returns the numbers of events and
/// evaluations.
fn run(forward: &Forward, state: &State<f64>, inputs: &mut dyn Inputs, until: f64) -> [usize; 2] {
    let mut simulation =
        forward.start(0.0, state.clone(), Settings::default(), inputs).expect("it starts");
    for sample in 1..=(100.0 * until) as usize {
        simulation.advance(0.01 * sample as f64, inputs).expect("it goes on");
    }
    [simulation.events().len(), simulation.evaluations()]
}

fn simulations(criterion: &mut Criterion) {
    let (forward, state, weight) = robot();
    let mut group = criterion.benchmark_group("forward/3rps");
    group.sample_size(10);
    for (name, amplitude, until) in
        [("sticks and slides for 10 s", 20.0, 10.0), ("is stuck for 1000 s", 0.1, 1000.0)]
    {
        let swing = || Swing { mean: weight.clone(), amplitude, home: Vec::new() };
        let [events, evaluations] = run(&forward, &state, &mut swing(), until);
        println!("{name}: {events} events, {evaluations} evaluations");
        group.bench_function(name, |b| b.iter(|| run(&forward, &state, &mut swing(), until)));
    }
    let name = "is stuck for 1000 s under constant forces";
    let constant = || ConstantEfforts(weight.clone());
    let [events, evaluations] = run(&forward, &state, &mut constant(), 1000.0);
    println!("{name}: {events} events, {evaluations} evaluations");
    group.bench_function(name, |b| b.iter(|| run(&forward, &state, &mut constant(), 1000.0)));
    group.finish();
}

criterion_group!(benches, simulations);
criterion_main!(benches);
