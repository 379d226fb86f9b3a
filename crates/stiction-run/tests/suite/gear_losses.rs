//! Losses of gears in simulations, against closed forms.

use crate::drive_trains::{LIFT, SLIDE, relative_error, with};
use stiction_core::forward::{
    ConstantEfforts, EventKind, Forward, ForwardError, Settings, Simulation,
};
use stiction_core::kinematics::{Coordinate, State, Target};
use stiction_core::mechanism::JointId;
use stiction_format::ModelFile;

const MASS: f64 = 40.0;
const GRAVITY: f64 = 9.81;

/// Hoist: the slide driven by a screw of 10 mm/rev.
struct Hoist {
    model: ModelFile,
    /// Inertia of the rotor, reflected to the slide, kg.
    rotor: f64,
    /// Efficiencies of the gear: forward and backward.
    eta: (f64, f64),
    /// Friction of guide and motor, N.
    dry: [f64; 2],
}

impl Hoist {
    fn new(rotor: f64, eta: (f64, f64), dry: [f64; 2]) -> Self {
        let n = std::f64::consts::TAU / 0.01;
        let train = format!(
            "[actuators.motor]\njoint = \"axis\"\nlead = 0.01\nrotor_inertia = {}\n\
             efficiency = {}\nbackward_efficiency = {}\nmotor_friction = {{ constant = {} }}\n",
            rotor / (n * n),
            eta.0,
            eta.1,
            dry[1] / n,
        );
        let guide = format!("axis = \"z\"\nfriction = {{ mu = 0.1, preload = {} }}", 10.0 * dry[0]);
        let slide = SLIDE.replace("axis = \"z\"", &guide);
        Self { model: with(&[&slide, LIFT, &train]), rotor, eta, dry }
    }

    /// Returns the accelerations that satisfy all laws for an effort of the motor while the hoist
    /// moves in the direction `sense`.
    fn accelerations(&self, effort: f64, sense: f64) -> Vec<f64> {
        let load = MASS * GRAVITY + sense * self.dry[0];
        let (forward, backward) = self.eta;
        let input = effort - sense * self.dry[1];
        let factors = [(1.0, 1.0 / forward), (-1.0, backward)];
        let each = factors.into_iter().filter_map(|(drives, factor)| {
            let a = (input - factor * load) / (self.rotor + factor * MASS);
            let transmitted = MASS * a + load;
            (transmitted * sense * drives > 0.0).then_some(a)
        });
        each.collect()
    }

    fn forward(&self) -> Forward {
        Forward::new(self.model.mechanism.clone(), &[])
    }
}

fn state(forward: &Forward, rate: f64) -> State<f64> {
    let joint = Coordinate::Joint { joint: JointId(0), dof: 0 };
    forward.assemble(&[], &[joint], &[Target { value: 0.0, rate, acceleration: 0.0 }]).unwrap()
}

fn started<'a>(
    forward: &'a Forward,
    effort: f64,
    rate: f64,
) -> Result<Simulation<'a>, ForwardError> {
    let mut efforts = ConstantEfforts(vec![effort]);
    forward.start(0.0, state(forward, rate), Settings::default(), &mut efforts)
}

const PAIRS: [(f64, f64); 7] =
    [(0.8, 0.7), (0.4, -0.2), (0.5, 0.0), (0.9, 1.0), (1.0, 0.6), (0.3, 0.9), (0.6, -1.5)];

/// Tests the accelerations while the motor drives, brakes, or is back-driven.
#[test]
fn accelerations_of_a_hoist() {
    let mut cases = [0; 2];
    for eta in PAIRS {
        for (rotor, dry) in [(100.0, [0.0; 2]), (70.0, [30.0, 20.0]), (900.0, [30.0, 0.0])] {
            let hoist = Hoist::new(rotor, eta, dry);
            let forward = hoist.forward();
            for effort in [-9000.0, -900.0, -300.0, 0.0, 200.0, 392.4, 500.0, 900.0, 3000.0] {
                for sense in [1.0, -1.0] {
                    let expected = hoist.accelerations(effort, sense);
                    assert_eq!(expected.len(), 1, "the rotor is heavy enough");
                    let simulation = started(&forward, effort, 0.1 * sense).unwrap();
                    let a = simulation.joint_motion(JointId(0), 0).acceleration;
                    let size = (effort.abs() + 400.0) / (rotor + hoist.eta.1 * MASS);
                    assert!(
                        (a - expected[0]).abs() < 1e-12 * size,
                        "{eta:?} {effort}: {a} {expected:?}"
                    );
                    // The reaction of the joint equals the force that the gear transmits minus the
                    // joint friction.
                    let (force, _) = simulation.instant().reactions()[0];
                    assert!(
                        (force.z - MASS * (a + GRAVITY)).abs() < 1e-11 * (effort.abs() + 400.0)
                    );
                    let drives = (MASS * (a + GRAVITY) + sense * dry[0]) * sense > 0.0;
                    cases[usize::from(drives)] += 1;
                }
            }
        }
    }
    assert!(cases.iter().all(|count| *count > 50), "{cases:?}");
}

/// Tests that the hoist remains at rest for efforts between the onsets of upward and downward
/// motion, and for no others. With negative backward efficiency, the hoist holds the load without a
/// motor effort.
#[test]
fn rest_of_a_hoist() {
    for eta in PAIRS {
        for dry in [[0.0; 2], [30.0, 20.0], [0.0, 50.0]] {
            let hoist = Hoist::new(100.0, eta, dry);
            let forward = hoist.forward();
            let weight = MASS * GRAVITY;
            // Onset of motion upward, then downward. The guide friction may load a self-locking
            // gear: for efforts between both values of `low`, the hoist can hold as well as move.
            let high = (weight + dry[0]) / eta.0 + dry[1];
            let low = [-1.0, 1.0].map(|sense| (weight + sense * dry[0]) * eta.1 - dry[1]);
            let low = [low[0].max(low[1]), low[0].min(low[1])];
            // Static frictions that share an effort may exceed their limits by 1e-5, see `stick`.
            let near = if dry[0] > 0.0 { 1e-4 } else { 1e-9 };
            for ([holds, moves], sense) in [([high; 2], 1.0), (low, -1.0)] {
                for (effort, part, begins) in [(holds, -near, false), (moves, near, true)] {
                    let effort = effort + part * sense * (effort.abs() + weight);
                    let simulation = started(&forward, effort, 0.0).unwrap();
                    let a = simulation.joint_motion(JointId(0), 0).acceleration;
                    assert_eq!(a * sense > 0.0, begins, "{eta:?} {dry:?} {effort} {a}");
                    assert_eq!(a == 0.0, !begins, "{eta:?} {dry:?} {effort} {a}");
                }
            }
        }
    }
}

/// Tests the energy balance of motions up and down: the hoist is driven up, then released.
#[test]
fn runs_of_a_hoist() {
    for eta in [(0.8, 0.7), (0.4, -0.2)] {
        let hoist = Hoist::new(100.0, eta, [30.0, 20.0]);
        let forward = hoist.forward();
        let mut efforts = ConstantEfforts(vec![2000.0]);
        let settings = Settings::default();
        let mut simulation =
            forward.start(0.0, state(&forward, 0.0), settings, &mut efforts).unwrap();
        simulation.advance(0.5, &mut efforts).unwrap();
        let up = hoist.accelerations(2000.0, 1.0)[0];
        let motion = simulation.joint_motion(JointId(0), 0);
        assert!((motion.value - 0.125 * up).abs() < 1e-9, "{} {up}", motion.value);
        let from = simulation.instant().state.clone();
        assert!(relative_error(&simulation) < 1e-12, "{}", relative_error(&simulation));

        let mut none = ConstantEfforts(vec![0.0]);
        let mut simulation = forward.start(0.5, from, settings, &mut none).unwrap();
        simulation.advance(3.0, &mut none).unwrap();
        let brakes = hoist.accelerations(0.0, 1.0)[0];
        assert!(brakes < 0.0);
        let rate = 0.5 * up;
        let (stop, top) = (0.5 - rate / brakes, 0.125 * up - 0.5 * rate * rate / brakes);
        let motion = simulation.joint_motion(JointId(0), 0);
        let down = match eta.1 > 0.0 {
            true => 0.5 * hoist.accelerations(0.0, -1.0)[0] * (3.0 - stop).powi(2),
            false => 0.0,
        };
        assert!((motion.value - top - down).abs() < 1e-8, "{} {top} {down}", motion.value);
        assert_eq!(motion.rate == 0.0, eta.1 < 0.0);
        assert!(relative_error(&simulation) < 1e-9, "{}", relative_error(&simulation));
    }
}

/// Tests a light rotor with a self-locking gear that moves down: no acceleration satisfies the
/// laws, and the hoist stops at once. Under a lowering torque, two accelerations satisfy the laws,
/// and both are reported.
#[test]
fn self_locking_gears_jam() {
    let hoist = Hoist::new(2.0, (0.3, -0.5), [0.0; 2]);
    let forward = hoist.forward();
    assert!(hoist.accelerations(0.0, -1.0).is_empty());
    let mut none = ConstantEfforts(vec![0.0]);
    let mut simulation =
        forward.start(0.0, state(&forward, -0.1), Settings::default(), &mut none).unwrap();
    simulation.advance(0.1, &mut none).unwrap();
    let motion = simulation.joint_motion(JointId(0), 0);
    assert!(motion.rate == 0.0 && motion.value.abs() < 1e-3, "{motion:?}");

    let expected = hoist.accelerations(-1000.0, -1.0);
    assert_eq!(expected.len(), 2);
    let simulation = started(&forward, -1000.0, -0.1).unwrap();
    let motion = simulation.joint_motion(JointId(0), 0);
    assert!((motion.acceleration - expected[0]).abs() < 1e-11, "{motion:?} {expected:?}");
    let EventKind::NotUnique { others, .. } = &simulation.events()[0].kind else {
        panic!("{:?}", simulation.events())
    };
    assert!((others[0].accelerations[0] - expected[1]).abs() < 1e-11, "{others:?} {expected:?}");
}

/// Tests that, for steady lifting, `inverse` and `forward` report the same torque, the same limits,
/// and the same exceeded limits.
#[test]
fn motors_in_summaries() {
    use crate::common::job;
    use stiction_core::dynamics::FrictionMode;
    use stiction_run::Sink;
    use stiction_run::forward::{Job, Recorder, Start, Summary, write_summary};
    let motion = "[motions.m]\nduration = 1\naxis = \"0.1 m/s*t\"\n";
    let n = std::f64::consts::TAU / 0.01;
    let torque = MASS * GRAVITY / (0.8 * n) + 0.02;
    let train = format!(
        "[actuators.motor]\njoint = \"axis\"\nlead = 0.01\nefficiency = 0.8\n\
         motor_friction = {{ constant = 0.02 }}\n\
         limits = {{ rated = {}, peak = {}, speed = 60 }}\n",
        torque / 1.12,
        torque * 1.01
    );
    let model = with(&[SLIDE, motion, &train]);
    let along = job(&model, "m", "none", FrictionMode::Converged);
    let mut summary = stiction_run::inverse::Summary::new(&along);
    let verdict = along.run(|sample| summary.add(sample), |_, _, _| true).unwrap();
    let mut inverse = String::new();
    stiction_run::inverse::write_summary(&mut inverse, &along, &summary, &verdict).unwrap();
    let of_inverse = summary.json(&along, &verdict);

    let load = stiction_format::LoadCase::default();
    let simulated = Job {
        motion: Some(along.motion),
        start: Start::Moving,
        prescribed: vec![0],
        until: 1.0,
        step: 0.01,
        ..Job::new(&model, ("none", &load))
    };
    let mut recorder = Recorder::new(&simulated, Summary::new(&simulated));
    let outcome = simulated.run(|sample, _| recorder.add(sample), &|| false, None).unwrap();
    let of_forward = recorder.sink.json(&simulated, &outcome);
    let mut forward = String::new();
    write_summary(&mut forward, &simulated, &recorder.sink, &outcome).unwrap();
    for (text, json) in [(inverse, of_inverse), (forward, of_forward)] {
        let motor = &json["actuators"]["motor"];
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        for size in ["peak", "rms"] {
            assert!((number(&motor["motor_torque"][size]) - torque).abs() < 1e-12 * torque);
        }
        assert!((number(&motor["work"]) - torque * n * 0.1).abs() < 1e-9);
        assert_eq!(number(&motor["duty"]), 1.0);
        let exceeded = ["rated", "peak", "speed"].map(|limit| &motor["limits"][limit]["exceeded"]);
        assert_eq!(exceeded, [true, false, true]);
        assert!(text.contains("motor: 112 % of rated rms torque"), "{text}");
        assert!(text.contains("motor: 105 % of speed limit"), "{text}");
        assert!(!text.contains("of peak torque"), "{text}");
    }
}
