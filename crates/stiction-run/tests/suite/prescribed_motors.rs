//! Simulations of motors that drive several joints: prescribed and locked joints, and efforts that
//! inverse dynamics computes for motors with unequal losses.

use crate::common::{Csv, files, job, model_of, tables};
use crate::differentials::{PITCH, ROLL, WEIGHT, WRIST};
use crate::drive_trains::{PENDULUM, SWING, relative_error, with};
use stiction_core::dynamics::FrictionMode;
use stiction_core::forward::{ConstantEfforts, Forward, Inputs, Known, Settings, View};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::JointId;
use stiction_format::{LoadCase, ModelFile, gallery};
use stiction_run::Sink;
use stiction_run::forward::{Feed, Job, Recorder, Start, Tables};

const RATIO: f64 = 25.0;
const ROTOR: f64 = 4e-6;
const ETA: (f64, f64) = (0.85, 0.6);
const DRY: f64 = 0.003;

/// Creates a wrist whose two motors have losses. Both motors act on pitch and, in opposite
/// directions, on roll.
fn wrist(joints: &str) -> ModelFile {
    let train = |name: &str, sign: &str| {
        format!(
            "[actuators.{name}]\njoints = {{ pitch = 1, roll = {sign}2 }}\nratio = {RATIO}\nrotor_inertia = {ROTOR}\n\
             efficiency = {}\nbackward_efficiency = {}\nmotor_friction = {{ constant = {DRY}, viscous = 1e-5 }}\n",
            ETA.0, ETA.1
        )
    };
    with(&[WRIST, joints, &train("left", ""), &train("right", "-")])
}

/// Returns `forward.csv` of a simulation.
fn simulated(job: &Job<'_>) -> Result<Csv, String> {
    let tables = Tables::new(job, std::array::from_fn(|_| Vec::new())).unwrap();
    let mut recorder = Recorder::new(job, tables);
    job.run(|sample, _| recorder.add(sample), &|| false, None)
        .map_err(|error| error.to_string())?;
    Ok(Csv::parse(&recorder.sink.finish().unwrap()[0]))
}

/// Returns `inverse.csv` along the motion `m`.
fn inverse(model: &ModelFile) -> Csv {
    let job = job(model, "m", "none", FrictionMode::Converged);
    let mut tables = tables(&job);
    job.run(|sample| tables.add(sample), |_, _, _| true).unwrap();
    Csv::parse(&files(&job, tables).remove("inverse.csv").unwrap())
}

fn targets_at(motion: [[f64; 3]; 2]) -> Vec<Target<f64>> {
    motion.map(|[value, rate, acceleration]| Target { value, rate, acceleration }).to_vec()
}

/// Constant efforts, and prescribed coordinates with constant rates.
struct Given {
    efforts: Vec<f64>,
    starts: Vec<f64>,
    rates: Vec<f64>,
}

impl Inputs for Given {
    fn efforts(&mut self, _view: &View<'_>, efforts: &mut [f64]) {
        efforts.copy_from_slice(&self.efforts);
    }
    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        for ((target, start), rate) in targets.iter_mut().zip(&self.starts).zip(&self.rates) {
            *target = Target { value: start + rate * time, rate: *rate, acceleration: 0.0 };
        }
    }
}

const COORDINATES: [Coordinate; 2] = [
    Coordinate::Joint { joint: JointId(0), dof: 0 },
    Coordinate::Joint { joint: JointId(1), dof: 0 },
];

/// Tests that, with both joints prescribed, the motors require the torques of inverse dynamics,
/// also with dry friction in a joint and in both motors.
#[test]
fn prescribed_differential() {
    let dry = "[joints.roll.friction]\nmu = 0.2\nradius = 0.01\nbending_span = 0.05\n";
    for joints in ["", dry] {
        let model = wrist(joints);
        let expected = inverse(&model);
        let (motion, load) = (model.motion("m").unwrap(), LoadCase::default());
        let prescribed = Job {
            motion: Some(motion),
            start: Start::Moving,
            prescribed: vec![0, 1],
            until: 2.0,
            step: 0.01,
            ..Job::new(&model, ("none", &load))
        };
        let found = simulated(&prescribed).unwrap();
        let (times, of_inverse) = (found.column("time [s]"), expected.column("time [s]"));
        assert_eq!(times.len(), of_inverse.len());
        let mut checked = 0;
        for k in 0..times.len() {
            let at = |csv: &Csv, name: &str| csv.column(name)[k];
            let names = ["left", "right"];
            let speeds = names.map(|name| at(&found, &format!("{name}.motor_speed [rad/s]")));
            // Inverse dynamics assumes zero friction at interfaces whose rate is zero at the
            // sample.
            let roll = at(&found, "roll.rate [rad/s]");
            if speeds.into_iter().chain([roll]).any(|speed| speed.abs() < 1e-6) {
                continue;
            }
            checked += 1;
            let torques = names.map(|name| at(&expected, &format!("{name}.motor_torque [N m]")));
            for (name, torque) in names.iter().zip(torques) {
                let simulated = at(&found, &format!("{name}.motor_torque [N m]"));
                assert!(
                    (simulated - torque).abs() < 1e-11,
                    "{name} at {}: {simulated} {torque}",
                    times[k]
                );
            }
            let [left, right] = torques.map(|torque| RATIO * torque);
            assert!((at(&found, "pitch.drive [N m]") - left - right).abs() < 1e-10);
            assert!((at(&found, "roll.drive [N m]") - 2.0 * (left - right)).abs() < 1e-10);
        }
        assert!(checked > 150, "{checked}");
    }
}

/// Tests the equations of both motors and the energy balance with roll prescribed at a constant
/// rate and pitch under an effort.
#[test]
fn half_prescribed_differential() {
    let model = wrist("");
    let forward = Forward::new(model.mechanism.clone(), &[1]);
    let mut driven = [0; 2];
    for (effort, rates) in
        [(0.7, [0.5, 0.4]), (-1.4, [0.3, 0.9]), (0.0, [-0.6, 0.2]), (2.5, [-0.1, -1.1])]
    {
        let start = targets_at([[0.2, rates[0], 0.0], [0.1, rates[1], 0.0]]);
        let state = forward.assemble(&[], &COORDINATES, &start).unwrap();
        let mut given =
            Given { efforts: vec![effort, 0.0], starts: vec![0.1], rates: vec![rates[1]] };
        let mut simulation = forward.start(0.0, state, Settings::default(), &mut given).unwrap();
        let [p, r] = [0, 1].map(|joint| simulation.joint_motion(JointId(joint), 0).acceleration);
        assert!(r.abs() < 1e-15, "{r}");
        let pitch = PITCH * p - WEIGHT * 0.2_f64.cos();
        let roll = simulation.instant().drives[1];
        // Only the motors act on roll.
        for sign in [1.0, -1.0] {
            let (rate, acceleration) = (rates[0] + sign * 2.0 * rates[1], p);
            let output = 0.5 * pitch;
            let is_driven = output * rate < 0.0;
            driven[usize::from(is_driven)] += 1;
            let gear = if is_driven { ETA.1 * output } else { output / ETA.0 };
            let needed = RATIO * RATIO * (ROTOR * acceleration + 1e-5 * rate)
                + RATIO * DRY * rate.signum()
                + gear;
            let exerted = 0.5 * effort + sign * 0.25 * roll;
            assert!((needed - exerted).abs() < 1e-11, "{effort} {rates:?}: {needed} {exerted}");
        }
        simulation.advance(0.4, &mut given).unwrap();
        assert!(relative_error(&simulation) < 1e-8, "{}", relative_error(&simulation));
    }
    assert!(driven.iter().all(|count| *count > 1), "{driven:?}");
    assert_eq!(ROLL, 0.002);
}

/// Tests the onset of motion with pitch locked under the weight of the hand. Roll begins to move at
/// the effort at which one motor drives and the other is back-driven, including the friction of
/// both; below this effort it remains at rest. If both joints are locked, only the weight must be
/// held.
#[test]
fn locked_differential() {
    let model = wrist("");
    let limit = 2.0 * (2.0 * RATIO * DRY + 0.5 * WEIGHT * (1.0 / ETA.0 - ETA.1));
    let forward = Forward::new(model.mechanism.clone(), &[0]);
    let start = targets_at([[0.0; 3]; 2]);
    for (part, moves) in [(0.5, false), (1.0 - 1e-4, false), (1.0 + 1e-4, true), (3.0, true)] {
        for sign in [1.0, -1.0] {
            let state = forward.assemble(&[], &COORDINATES, &start).unwrap();
            let efforts = vec![0.0, sign * part * limit];
            let mut given = Given { efforts, starts: vec![0.0], rates: vec![0.0] };
            let mut simulation =
                forward.start(0.0, state, Settings::default(), &mut given).unwrap();
            let acceleration = simulation.joint_motion(JointId(1), 0).acceleration;
            assert_eq!(acceleration * sign > 0.0, moves, "{part} {sign}: {acceleration}");
            assert_eq!(acceleration == 0.0, !moves, "{part} {sign}: {acceleration}");
            simulation.advance(0.1, &mut given).unwrap();
            assert!(simulation.joint_motion(JointId(0), 0).value.abs() < 1e-15);
            assert!(relative_error(&simulation) < 1e-10);
        }
    }
    let forward = Forward::new(model.mechanism.clone(), &[0, 1]);
    let state = forward.assemble(&[], &COORDINATES, &start).unwrap();
    let mut given = Given { efforts: vec![0.0; 2], starts: vec![0.0; 2], rates: vec![0.0; 2] };
    let simulation = forward.start(0.0, state, Settings::default(), &mut given).unwrap();
    let drives = &simulation.instant().drives;
    assert!((drives[0] + WEIGHT).abs() < 1e-13 && drives[1].abs() < 1e-13, "{drives:?}");
}

/// Creates a pendulum with two motors of unequal losses, and the wrist with three motors on its two
/// joints.
fn shared() -> [ModelFile; 2] {
    let train = |name: &str, joints: &str, (forward, backward): (f64, f64), more: &str| {
        format!(
            "[actuators.{name}]\n{joints}\nratio = 20\nefficiency = {forward}\nbackward_efficiency = {backward}\n{more}\n"
        )
    };
    let rotor = "rotor_inertia = 3e-5\nmotor_friction = { constant = 0.02, viscous = 1e-4 }";
    let pivot = "joint = \"pivot\"";
    let pendulum = with(&[
        PENDULUM,
        SWING,
        &train("a", pivot, (0.9, 0.8), &format!("share = 0.4\n{rotor}")),
        &train("b", pivot, (0.5, 0.2), "share = 0.6\nmotor_friction = { constant = 0.05 }"),
    ]);
    let wrist = with(&[
        &WRIST.replace("com = [0.08, 0, 0]", "com = [0.08, 0.01, 0]"),
        &train("a", "joint = \"pitch\"", (0.9, 0.8), &format!("share = 0.2\n{rotor}")),
        &train("b", "joints = { pitch = 1, roll = 1 }", (0.6, 0.3), "share = 0.5"),
        &train("c", "joints = { pitch = 0.5, roll = -1 }", (0.7, 0.6), "share = 0.9"),
    ]);
    [pendulum, wrist]
}

/// Tests that the efforts of inverse dynamics for motors with unequal losses cause the motion.
#[test]
fn efforts_of_inverse_dynamics() {
    for (model, names) in shared().iter().zip([&["pivot"][..], &["pitch", "roll"]]) {
        let expected = inverse(model);
        let load = LoadCase::default();
        let motion = model.motion("m").unwrap();
        for k in (1..200).step_by(7) {
            let from = expected.column("time [s]")[k];
            let references: Vec<Target<f64>> =
                motion.coordinates.iter().map(|(_, signal)| signal.at(from)).collect();
            let each = COORDINATES.iter().zip(&references);
            let known: Vec<Known> = each
                .map(|(coordinate, reference)| Known {
                    coordinate: *coordinate,
                    value: Some(reference.value),
                    rate: Some(reference.rate),
                })
                .collect();
            let fed = Job {
                motion: Some(motion),
                start: Start::Known(&known),
                drives: Feed::Inverse,
                from,
                until: from + 1e-3,
                step: 1e-3,
                ..Job::new(model, ("none", &load))
            };
            let found = simulated(&fed).unwrap();
            for (name, reference) in names.iter().zip(&references) {
                let a = found.column(&format!("{name}.acceleration [rad/s^2]"))[0];
                let (expected, error) = (reference.acceleration, a - reference.acceleration);
                let size = expected.abs().max(10.0);
                assert!(error.abs() < 1e-10 * size, "{name} at {from}: {a} {expected}");
            }
        }
    }

    // A motor with zero share cannot turn its self-locking worm gear: no torques cause the motion.
    let stuck = with(&[
        PENDULUM,
        SWING,
        "[actuators.a]\njoint = \"pivot\"\nratio = 20\nefficiency = 0.9\n\
         [actuators.b]\njoint = \"pivot\"\nratio = 20\nefficiency = 0.3\nbackward_efficiency = -0.5\nshare = 0\n\
         motor_friction = { constant = 0.02 }\n",
    ]);
    let load = LoadCase::default();
    let fed = Job {
        motion: Some(stuck.motion("m").unwrap()),
        start: Start::Moving,
        drives: Feed::Inverse,
        until: 0.1,
        ..Job::new(&stuck, ("none", &load))
    };
    let error = simulated(&fed).err().unwrap();
    assert!(
        error.contains(
            "at t = 0 s the motors `a`, `b` cannot produce the motion with torques in the ratio"
        ) && error.contains("a self-locking gear jams"),
        "{error}"
    );
}

/// Tests the efforts for which the motor friction holds the hanging pendulum. For the wrist, these
/// efforts depend on each other and are reported as unknown.
#[test]
fn holding_efforts_of_shared_motors() {
    let load = LoadCase::default();
    let [pendulum, wrist] = shared().map(|model| {
        let mut smooth = model.clone();
        smooth.mechanism = model.mechanism.without_friction();
        let smooth = Job { friction: false, ..Job::new(&smooth, ("none", &load)) };
        let found = smooth.equilibrium(false).unwrap();
        Job::new(&model, ("none", &load)).holding(&found).unwrap()
    });
    // With 0.4 U > 0.4 N m at the first motor, which drives, and 0.6 U < 1 N m at the second, which is driven:
    // 0.9 (0.4 U - 0.4) + (0.6 U - 1)/0.2 = 0.
    let limit = (0.36 + 5.0) / (0.36 + 3.0);
    let (low, high) = pendulum.ranges[0].range;
    assert!((low + limit).abs() < 1e-9 && (high - limit).abs() < 1e-9, "{low} {high} {limit}");
    assert!(wrist.ranges.is_empty());
    let unknown = wrist.unknown.unwrap();
    assert!(
        unknown.contains(
            "the motors `a`, `b`, `c` share the efforts of several joints and have gear losses"
        ),
        "{unknown}"
    );
}

/// Tests one motor with a lossy gear on pitch and one lossless motor on pitch and roll. The gear
/// transmits only the effort of the first motor, not all efforts on pitch.
#[test]
fn geared_motor_beside_a_free_one() {
    let model = with(&[
        WRIST,
        "[actuators.a]\njoint = \"pitch\"\nratio = 10\nefficiency = 0.7\nbackward_efficiency = 0.4\n\
         [actuators.c]\njoints = { pitch = 1, roll = 1 }\nratio = 10\n",
    ]);
    let forward = Forward::new(model.mechanism.clone(), &[]);
    for (efforts, rate) in [([1.5, -2.0], 0.3), ([-1.0, 2.0], 0.3), ([0.5, 3.0], -0.2)] {
        let start = targets_at([[0.4, rate, 0.0], [0.0, 0.1, 0.0]]);
        let state = forward.assemble(&[], &COORDINATES, &start).unwrap();
        let mut inputs = ConstantEfforts(efforts.to_vec());
        let simulation = forward.start(0.0, state, Settings::default(), &mut inputs).unwrap();
        let [pitch, roll] = [0, 1].map(|joint| simulation.joint_motion(JointId(joint), 0));
        let input = efforts[0] - efforts[1];
        let output = if input * rate > 0.0 { 0.7 * input } else { input / 0.4 };
        let expected = (output + efforts[1] + WEIGHT * 0.4_f64.cos()) / PITCH;
        assert!((pitch.acceleration - expected).abs() < 1e-10 * expected.abs(), "{pitch:?}");
        assert!((roll.acceleration - efforts[1] / ROLL).abs() < 1e-10 * efforts[1].abs() / ROLL);
    }
}

/// Tests that two motors with unequal gears on every joint of a loop have the same results as in
/// the loop with one body divided by a fixed joint.
#[test]
fn loop_of_shared_joints() {
    let body = |name: &str| {
        format!("[bodies.{name}]\nmass = 2\ncom = [0.1, 0.02, 0]\ninertia = [0.01, 0.02, 0.03]\n")
    };
    let joint = |name: &str, from: &str, to: &str, more: &str| {
        format!(
            "[joints.{name}]\ntype = \"R\"\nfrom = \"{from}\"\nto = \"{to}\"\naxis = \"z\"\n{more}\n"
        )
    };
    let trains: String = ["a", "b", "c", "d"]
        .iter()
        .enumerate()
        .flat_map(|(k, joint)| {
            [(0.9, 0.8), (0.6, 0.3)].map(|(forward, backward)| {
                format!(
                    "[actuators.{joint}{k}{}]\njoint = \"{joint}\"\nratio = {}\nshare = 0.5\nefficiency = {forward}\n\
                     backward_efficiency = {backward}\nmotor_friction = {{ constant = 0.01 }}\n",
                    (forward * 10.0) as usize,
                    5 + k
                )
            })
        })
        .collect();
    let run = |divided: bool| {
        let last = if divided { "stub" } else { "rocker" };
        let text = [
            "gravity = [0, -9.81, 0]\n".to_owned(),
            body("crank"),
            body("coupler"),
            body("rocker"),
            joint("a", "ground", "crank", "start = 1.2"),
            joint("b", "crank", "coupler", "at = [0.3, 0, 0]\nstart = -0.7"),
            joint("c", "coupler", "rocker", "at = [0.5, 0, 0]\nto_at = [0.4, 0, 0]"),
            joint("d", "ground", last, "at = [0.6, 0, 0]"),
            if divided {
                "[bodies.stub]\n[joints.weld]\ntype = \"fixed\"\nfrom = \"stub\"\nto = \"rocker\"\n"
                    .to_owned()
            } else {
                String::new()
            },
            "[loads.none]\n".to_owned(),
            trains.clone(),
        ]
        .concat();
        let model = model_of("loop", &text);
        let forward = Forward::new(model.mechanism.clone(), &[]);
        let start = Target { value: 1.2, rate: 0.8, acceleration: 0.0 };
        let state = forward.assemble(&[], &COORDINATES[..1], &[start]).unwrap();
        let mut efforts = ConstantEfforts(vec![3.0, -1.0, 2.0, 0.5]);
        let mut simulation = forward.start(0.0, state, Settings::default(), &mut efforts).unwrap();
        simulation.advance(0.2, &mut efforts).unwrap();
        assert!(relative_error(&simulation) < 1e-9, "{}", relative_error(&simulation));
        let motion = simulation.joint_motion(JointId(0), 0);
        (motion, simulation.instant().reactions()[..4].to_vec())
    };
    let ((a, of_a), (b, of_b)) = (run(false), run(true));
    assert!((a.value - b.value).abs() < 1e-10 && (a.rate - b.rate).abs() < 1e-9, "{a:?} {b:?}");
    assert!((a.acceleration - b.acceleration).abs() < 1e-8 * a.acceleration.abs(), "{a:?} {b:?}");
    for (a, b) in of_a.iter().zip(&of_b) {
        // Reactions are statically determinate only in the plane of the loop.
        assert!((a.0.x - b.0.x).abs() < 1e-7 && (a.0.y - b.0.y).abs() < 1e-7, "{a:?} {b:?}");
    }
}

/// Tests two motors with unequal gears on each leg of a hexapod. The hexapod assembles as without
/// motors, and the efforts of inverse dynamics cause the motion.
#[test]
fn hexapod_with_two_motors_on_each_leg() {
    let mut text = gallery::get("gough").unwrap().to_owned();
    for leg in 1..=6 {
        for (name, forward, backward) in [("a", 0.9, 0.8), ("b", 0.6, 0.3)] {
            text += &format!(
                "\n[actuators.{name}{leg}]\njoint = \"leg{leg}.P\"\nlead = 0.02\nshare = 0.5\nefficiency = {forward}\n\
                 backward_efficiency = {backward}\nrotor_inertia = 4e-5\nmotor_friction = {{ constant = 0.01 }}\n"
            );
        }
    }
    let model = model_of("gough", &text);
    let load = LoadCase::default();
    let along = stiction_run::Job {
        load: &load,
        ..job(&model, "sway", "payload", FrictionMode::Converged)
    };
    let mut tables = tables(&along);
    along.run(|sample| tables.add(sample), |_, _, _| true).unwrap();
    let expected = Csv::parse(&files(&along, tables).remove("joints.csv").unwrap());
    let fed = Job {
        motion: Some(model.motion("sway").unwrap()),
        start: Start::Moving,
        drives: Feed::Inverse,
        until: 1e-3,
        step: 1e-3,
        ..Job::new(&model, ("none", &load))
    };
    let found = simulated(&fed).unwrap();
    for leg in 1..=6 {
        let column = format!("leg{leg}.P.acceleration [m/s^2]");
        let (a, b) = (found.column(&column)[0], expected.column(&column)[0]);
        assert!((a - b).abs() < 1e-9, "{leg}: {a} {b}");
    }
    let forward = Forward::new(model.mechanism.clone(), &[]);
    let plain = Forward::new(model.mechanism.without_friction(), &[]);
    let motion = model.motion("sway").unwrap();
    let coordinates: Vec<Coordinate> =
        motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect();
    let targets: Vec<Target<f64>> =
        motion.coordinates.iter().map(|(_, signal)| signal.at(0.0)).collect();
    let [with_shafts, without] = [&forward, &plain].map(|forward| {
        let poses = &model.initial_poses;
        let (_, report) = forward.assemble_with_report(poses, &coordinates, &targets).unwrap();
        report.notes()
    });
    assert_eq!(with_shafts, without);
}
