//! Motors that move several joints together, against closed forms.

use crate::common::{Csv, files, job, model_of, tables};
use crate::drive_trains::{relative_error, with};
use serde_json::Value;
use std::f64::consts::TAU;
use stiction_core::dynamics::FrictionMode;
use stiction_core::forward::{ConstantEfforts, Forward, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::JointId;
use stiction_format::{ModelFile, Source, read};
use stiction_run::Sink;
use stiction_run::exchange::{Instant, model_file};
use stiction_run::inverse::{Sample, Summary};

/// Wrist that pitches about y, then rolls about x. The hand of 1.5 kg has its centre of mass on the
/// roll axis at 80 mm, and is rotationally symmetric about this axis.
pub(crate) const WRIST: &str = "
gravity = [0, 0, -9.81]
[bodies.cradle]
[bodies.hand]
mass = 1.5
com = [0.08, 0, 0]
inertia = [0.002, 0.004, 0.004]
[joints.pitch]
type = \"R\"
from = \"ground\"
to = \"cradle\"
axis = \"y\"
[joints.roll]
type = \"R\"
from = \"cradle\"
to = \"hand\"
axis = \"x\"
[loads.none]
[motions.m]
duration = 2
pitch = \"0.9 rad*sin(2*pi*t/1 s)\"
roll = \"1.4 rad*cos(2*pi*t/2 s)\"
";
/// Moment of inertia of the wrist about the pitch axis, kg m^2.
pub(crate) const PITCH: f64 = 0.004 + 1.5 * 0.08 * 0.08;
/// Moment of inertia of the hand about the roll axis, kg m^2.
pub(crate) const ROLL: f64 = 0.002;
/// Moment of the weight about the pitch axis with the hand horizontal, N m.
pub(crate) const WEIGHT: f64 = 1.5 * 9.81 * 0.08;

fn run(model: &ModelFile) -> (Csv, Csv, Value) {
    let job = job(model, "m", "none", FrictionMode::Converged);
    let mut tables = tables(&job);
    let mut summary = Summary::new(&job);
    let add = |sample: &Sample| {
        summary.add(sample)?;
        tables.add(sample)
    };
    let verdict = job.run(add, |_, _, _| true).unwrap();
    let mut files = files(&job, tables);
    let mut file = |name| Csv::parse(&files.remove(name).unwrap());
    (file("inverse.csv"), file("motors.csv"), summary.json(&job, &verdict))
}

fn errors(parts: &[&str]) -> String {
    let text = parts.concat();
    read(&Source::new("machine.toml", text), &|_| Err("no files".into())).unwrap_err().to_string()
}

/// Returns angle, rate and acceleration of pitch and roll at a time, s.
fn motion(t: f64) -> [[f64; 3]; 2] {
    let (sin, cos) = (TAU * t).sin_cos();
    let (sin2, cos2) = (0.5 * TAU * t).sin_cos();
    let half = 0.5 * TAU;
    [
        [0.9 * sin, 0.9 * TAU * cos, -0.9 * TAU * TAU * sin],
        [1.4 * cos2, -1.4 * half * sin2, -1.4 * half * half * cos2],
    ]
}

/// Returns the efforts of pitch and roll. The hand is rotationally symmetric about the roll axis,
/// so pitch and roll are decoupled.
fn efforts([pitch, roll]: [[f64; 3]; 2]) -> [f64; 2] {
    // The weight acts at the centre of mass of the hand, which positive pitch lowers.
    [PITCH * pitch[2] - WEIGHT * pitch[0].cos(), ROLL * roll[2]]
}

#[test]
fn wrist_differential() {
    let (n, inertia, constant, viscous) = (25.0, 4e-6, 0.003, 1e-5);
    let (forward, backward) = (0.85, 0.8);
    let train = |name: &str, sign: &str| {
        format!(
            "[actuators.{name}]\njoints = {{ pitch = 1, roll = {sign}2 }}\nratio = {n}\nrotor_inertia = {inertia}\n\
             efficiency = {forward}\nbackward_efficiency = {backward}\ntorque_constant = 0.03\n\
             motor_friction = {{ constant = {constant}, viscous = {viscous} }}\n"
        )
    };
    let model = with(&[WRIST, &train("left", ""), &train("right", "-")]);
    let (inverse, motors, summary) = run(&model);
    assert_eq!(summary["actuators"]["left"]["actuated"], "pitch, roll");
    let mut checked = 0;
    for (k, &t) in inverse.column("time [s]").iter().enumerate() {
        let [pitch, roll] = motion(t);
        let [tau_p, tau_r] = efforts([pitch, roll]);
        let at = |name: &str| inverse.column(name)[k];
        assert!((at("pitch.drive [N m]") - tau_p).abs() < 1e-12, "{t}");
        assert!((at("roll.drive [N m]") - tau_r).abs() < 1e-12, "{t}");
        for (name, sign) in [("left", 2.0), ("right", -2.0)] {
            // Both motors drive both joints: pitch receives the sum of their efforts, roll twice
            // the difference.
            let effort = 0.5 * (tau_p + tau_r / sign);
            let rate = pitch[1] + sign * roll[1];
            let acceleration = pitch[2] + sign * roll[2];
            let of = |column: &str| motors.column(&format!("{name}.{column}"))[k];
            assert!((of("effort [N m]") - effort).abs() < 1e-12, "{t}");
            if rate.abs() < 1e-6 {
                continue;
            }
            checked += 1;
            let gear = if effort * rate > 0.0 { effort / forward } else { effort * backward } / n;
            let torque =
                inertia * n * acceleration + constant * rate.signum() + viscous * n * rate + gear;
            let found = at(&format!("{name}.motor_torque [N m]"));
            assert!((found - torque).abs() < 1e-12, "{name} at {t}: {found} {torque}");
            let found = at(&format!("{name}.current [A]"));
            assert!((found - torque / 0.03).abs() < 1e-10);
            let found = at(&format!("{name}.motor_speed [rad/s]"));
            assert!((found - n * rate).abs() < 1e-10);
            assert!(of("gear_loss [W]") >= -1e-12 && of("motor_friction [W]") >= 0.0);
        }
        // The output powers of both motors add up to the power of both joints.
        let output: f64 = ["left", "right"]
            .iter()
            .map(|name| motors.column(&format!("{name}.output [W]"))[k])
            .sum();
        assert!((output - tau_p * pitch[1] - tau_r * roll[1]).abs() < 1e-11);
        assert!(motors.column("residual [W]")[k].abs() < 1e-12);
    }
    assert!(checked > 200, "{checked}");
    // The mechanism does not change when it is written as a model file and read again.
    let again = model_of("again", &model_file(&model.mechanism, "", Instant::default()).unwrap());
    assert_eq!(again.mechanism.drive_trains(), model.mechanism.drive_trains());
}

/// Tests that a differential is equivalent to separate motor shafts with gearings. Its motor
/// friction and gear losses can therefore be simulated: the torques of inverse dynamics cause the
/// motion.
#[test]
fn differential_by_shafts() {
    let numbers = "ratio = 25\nrotor_inertia = 4e-6\nefficiency = 0.85\nbackward_efficiency = 0.8\n\
                   motor_friction = { constant = 0.003, viscous = 1e-5 }\n";
    let (mut direct, mut shafts) = (WRIST.to_owned(), WRIST.to_owned());
    for (name, roll) in [("left", "2"), ("right", "-2")] {
        direct +=
            &format!("[actuators.{name}]\njoints = {{ pitch = 1, roll = {roll} }}\n{numbers}");
        shafts += &format!(
            "[bodies.{name}]\n[joints.{name}]\ntype = \"R\"\nfrom = \"ground\"\nto = \"{name}\"\naxis = \"x\"\n\
             [actuators.{name}]\njoint = \"{name}\"\n{numbers}\
             [gearings.{name}]\njoints = {{ {name} = -1, pitch = 1, roll = {roll} }}\n"
        );
    }
    let (direct, shafts) = (model_of("direct", &direct), model_of("shafts", &shafts));
    let (expected, ..) = run(&direct);
    let (found, motors, _) = run(&shafts);
    for name in ["left", "right"] {
        for column in ["motor_torque [N m]", "motor_speed [rad/s]"] {
            let column = format!("{name}.{column}");
            let pairs = expected.column(&column).iter().zip(found.column(&column));
            for (k, (a, b)) in pairs.enumerate() {
                assert!((a - b).abs() < 1e-10, "{column} {k}: {a} {b}");
            }
        }
    }
    assert!(motors.column("residual [W]").iter().all(|residual| residual.abs() < 1e-11));

    let sample = 37;
    let motion = motion(found.column("time [s]")[sample]);
    let targets = motion.map(|[value, rate, acceleration]| Target { value, rate, acceleration });
    let torque = |name: &str| found.column(&format!("{name}.motor_torque [N m]"))[sample];
    let mut efforts = ConstantEfforts(vec![25.0 * torque("left"), 25.0 * torque("right")]);
    let model = Forward::new(shafts.mechanism.clone(), &[]);
    let coordinates = [0, 1].map(|joint| Coordinate::Joint { joint: JointId(joint), dof: 0 });
    let state = model.assemble(&[], &coordinates, &targets).unwrap();
    let mut simulation = model.start(0.0, state, Settings::default(), &mut efforts).unwrap();
    for (joint, target) in targets.iter().enumerate() {
        let acceleration = simulation.joint_motion(JointId(joint), 0).acceleration;
        assert!((acceleration - target.acceleration).abs() < 1e-9, "{joint}: {acceleration}");
    }
    simulation.advance(0.3, &mut efforts).unwrap();
    assert!(relative_error(&simulation) < 1e-8, "{}", relative_error(&simulation));

    // Without shafts and gearings in the model, the joint torques are the sum of the motor torques
    // and twice their difference.
    let (left, right) = (25.0 * torque("left"), 25.0 * torque("right"));
    let mut efforts = ConstantEfforts(vec![left + right, 2.0 * (left - right)]);
    let model = Forward::new(direct.mechanism.clone(), &[]);
    let state = model.assemble(&[], &coordinates, &targets).unwrap();
    let mut several = model.start(0.0, state, Settings::default(), &mut efforts).unwrap();
    several.advance(0.3, &mut efforts).unwrap();
    assert!(relative_error(&several) < 1e-8, "{}", relative_error(&several));
    for joint in 0..2 {
        let [a, b] = [&simulation, &several].map(|run| run.joint_motion(JointId(joint), 0));
        assert!(
            (a.value - b.value).abs() < 1e-12 && (a.rate - b.rate).abs() < 1e-11,
            "{a:?} {b:?}"
        );
        let [a, b] = [&simulation, &several].map(|run| run.instant().reactions()[joint]);
        assert!((a.0 - b.0).norm() < 1e-10 && (a.1 - b.1).norm() < 1e-10, "{a:?} {b:?}");
    }
    assert_eq!(several.instant().reactions().len(), 2);
    assert!(several.instant().gearings.is_empty());
    let [a, b] = [&simulation, &several].map(|run| run.instant().interfaces.clone());
    assert_eq!(a.len(), 2);
    for (a, b) in a.iter().zip(&b) {
        assert!((a.load - b.load).abs() < 1e-10 && (a.friction[0] - b.friction[0]).abs() < 1e-10);
    }
}

/// Tests two motors with dry friction that drive two joints together by belts, against closed
/// forms. Each joint accelerates according to the motor forces minus losses, and remains at rest
/// while the friction of both motors holds it.
#[test]
fn simulated_belt_with_losses() {
    let (bridge, carriage, lead, inertia) = (3.0, 0.8, 0.04, 2e-5);
    let (eta, back, constant) = (0.8, 0.6, 0.02);
    let n = TAU / lead;
    let train = |name: &str, sign: &str| {
        format!(
            "[actuators.{name}]\njoints = {{ x = 1, y = {sign}1 }}\nlead = {lead}\nrotor_inertia = {inertia}\n\
             efficiency = {eta}\nbackward_efficiency = {back}\nmotor_friction = {{ constant = {constant} }}\n"
        )
    };
    let text = format!(
        "gravity = [0, 0, -9.81]\n\
         [bodies.bridge]\nmass = {bridge}\ncom = [0, 0, 0]\ninertia = [0.1, 0.1, 0.1]\n\
         [bodies.carriage]\nmass = {carriage}\ncom = [0, 0, 0]\ninertia = [0.01, 0.01, 0.01]\n\
         [joints.x]\ntype = \"P\"\nfrom = \"ground\"\nto = \"bridge\"\naxis = \"x\"\n\
         [joints.y]\ntype = \"P\"\nfrom = \"bridge\"\nto = \"carriage\"\naxis = \"y\"\n\
         [loads.none]\n{}{}",
        train("a", ""),
        train("b", "-")
    );
    let model = model_of("belt", &text);
    let forward = Forward::new(model.mechanism.clone(), &[]);
    let coordinates = [0, 1].map(|joint| Coordinate::Joint { joint: JointId(joint), dof: 0 });
    let masses = [bridge + carriage, carriage];
    // Motor forces at the belts, N, and rates of x and y, m/s.
    let cases: [([f64; 2], [f64; 2]); 5] = [
        ([40.0, 30.0], [0.3, 0.1]),
        ([40.0, -30.0], [0.1, 0.4]),
        ([-25.0, -9.0], [0.5, 0.2]),
        ([0.0, 0.0], [0.3, -0.5]),
        ([15.0, 60.0], [-0.2, 0.6]),
    ];
    let mut driven = [0; 2];
    for (forces, rates) in cases {
        let start = rates.map(|rate| Target { value: 0.0, rate, acceleration: 0.0 });
        let efforts = [forces[0] + forces[1], forces[0] - forces[1]];
        let state = forward.assemble(&[], &coordinates, &start).unwrap();
        let mut inputs = ConstantEfforts(efforts.to_vec());
        let simulation = forward.start(0.0, state, Settings::default(), &mut inputs).unwrap();
        let [x, y] = [0, 1].map(|joint| simulation.joint_motion(JointId(joint), 0).acceleration);
        // Belt forces on bridge and carriage, from their accelerations.
        let belts = [0.5 * (masses[0] * x + masses[1] * y), 0.5 * (masses[0] * x - masses[1] * y)];
        for (k, sign) in [1.0, -1.0].into_iter().enumerate() {
            let (rate, acceleration) = (rates[0] + sign * rates[1], x + sign * y);
            let is_driven = belts[k] * rate < 0.0;
            driven[usize::from(is_driven)] += 1;
            let input = if is_driven { back * belts[k] } else { belts[k] / eta };
            let needed = input + n * n * inertia * acceleration + n * constant * rate.signum();
            assert!((needed - forces[k]).abs() < 1e-10, "{forces:?} {rates:?}: {needed}");
        }
    }
    assert!(driven.iter().all(|count| *count > 1), "{driven:?}");

    // At rest without a load, each motor holds up to its own constant friction.
    let limit = n * constant;
    let still = [Target { value: 0.0, rate: 0.0, acceleration: 0.0 }; 2];
    for (forces, stays) in [
        ([0.99, 0.99], true),
        ([0.99, -0.99], true),
        ([-0.99, 0.5], true),
        ([1.01, 0.0], false),
        ([0.2, -1.01], false),
    ] {
        let [a, b] = forces.map(|part| part * limit);
        let mut inputs = ConstantEfforts(vec![a + b, a - b]);
        let state = forward.assemble(&[], &coordinates, &still).unwrap();
        let mut simulation = forward.start(0.0, state, Settings::default(), &mut inputs).unwrap();
        simulation.advance(0.2, &mut inputs).unwrap();
        let rates = [0, 1].map(|joint| simulation.joint_motion(JointId(joint), 0).rate);
        assert_eq!(rates == [0.0; 2], stays, "{forces:?}: {rates:?}");
        assert!(relative_error(&simulation) < 1e-10);
    }
}

/// Tests a belt over two fixed motors that moves bridge and carriage, with pulleys of 40 mm per
/// revolution.
#[test]
fn belt_of_two_slides() {
    let (bridge, carriage, lead, inertia) = (3.0, 0.8, 0.04, 2e-5);
    let text = format!(
        "gravity = [0, 0, -9.81]\n\
         [bodies.bridge]\nmass = {bridge}\ncom = [0, 0, 0]\ninertia = [0.1, 0.1, 0.1]\n\
         [bodies.carriage]\nmass = {carriage}\ncom = [0, 0, 0]\ninertia = [0.01, 0.01, 0.01]\n\
         [joints.x]\ntype = \"P\"\nfrom = \"ground\"\nto = \"bridge\"\naxis = \"x\"\n\
         [joints.y]\ntype = \"P\"\nfrom = \"bridge\"\nto = \"carriage\"\naxis = \"y\"\n\
         [loads.none]\n[motions.m]\nduration = 2\nx = \"0.2 m*sin(2*pi*t/1 s)\"\ny = \"0.1 m*cos(2*pi*t/2 s)\"\n\
         [actuators.a]\njoints = {{ x = 1, y = 1 }}\nlead = {lead}\nrotor_inertia = {inertia}\n\
         [actuators.b]\njoints = {{ x = 1, y = -1 }}\nlead = {lead}\nrotor_inertia = {inertia}\n"
    );
    let model = model_of("belt", &text);
    let (inverse, motors, _) = run(&model);
    let n = TAU / lead;
    for (k, &t) in inverse.column("time [s]").iter().enumerate() {
        let x = -0.2 * TAU * TAU * (TAU * t).sin();
        let y = -0.1 * 0.25 * TAU * TAU * (0.5 * TAU * t).cos();
        let forces = [(bridge + carriage) * x, carriage * y];
        for (name, sign) in [("a", 1.0), ("b", -1.0)] {
            let torque = inertia * n * (x + sign * y) + 0.5 * (forces[0] + sign * forces[1]) / n;
            let found = inverse.column(&format!("{name}.motor_torque [N m]"))[k];
            assert!((found - torque).abs() < 1e-12, "{name} at {t}: {found} {torque}");
            let found = motors.column(&format!("{name}.effort [N]"))[k];
            assert!((found - 0.5 * (forces[0] + sign * forces[1])).abs() < 1e-11);
        }
        assert!(motors.column("residual [W]")[k].abs() < 1e-11);
    }

    // Simulation: M = diag(m) + G^T J G, with the efforts G^T tau of constant torques.
    let torques = [0.3, -0.1];
    let efforts = vec![n * (torques[0] + torques[1]), n * (torques[0] - torques[1])];
    let reflected = 2.0 * n * n * inertia;
    let expected =
        [efforts[0] / (bridge + carriage + reflected), efforts[1] / (carriage + reflected)];
    let forward = Forward::new(model.mechanism.clone(), &[]);
    let coordinates = [0, 1].map(|joint| Coordinate::Joint { joint: JointId(joint), dof: 0 });
    let start = [Target { value: 0.0, rate: 0.0, acceleration: 0.0 }; 2];
    let state = forward.assemble(&[], &coordinates, &start).unwrap();
    let mut inputs = ConstantEfforts(efforts);
    let mut simulation = forward.start(0.0, state, Settings::default(), &mut inputs).unwrap();
    simulation.advance(1.0, &mut inputs).unwrap();
    for (joint, expected) in expected.into_iter().enumerate() {
        let motion = simulation.joint_motion(JointId(joint), 0);
        assert!((motion.acceleration - expected).abs() < 1e-12 * expected.abs().max(1.0));
        assert!((motion.value - 0.5 * expected).abs() < 1e-9 * expected.abs().max(1.0));
    }
    assert!(relative_error(&simulation) < 1e-12);
}

/// Tests a screw nut and a ball-spline nut that move a shaft: the motor of the spline nut turns and
/// lifts the shaft.
#[test]
fn turning_and_sliding_together() {
    let text = "gravity = [0, 0, -9.81]\n\
         [bodies.quill]\nmass = 2\ncom = [0, 0, 0]\ninertia = [0.01, 0.01, 0.003]\n\
         [joints.shaft]\ntype = \"C\"\nfrom = \"ground\"\nto = \"quill\"\naxis = \"z\"\n\
         [loads.none]\n[motions.m]\nduration = 1\n\"shaft.angle\" = \"2 rad*sin(2*pi*t/1 s)\"\n\
         \"shaft.slide\" = \"0.05 m*cos(2*pi*t/1 s)\"\n\
         [actuators.spline]\njoint = \"shaft.angle\"\nratio = 3\nrotor_inertia = 1e-4\n\
         [actuators.nut]\njoints = { \"shaft.angle\" = -1, \"shaft.slide\" = 1 }\nlead = \"20 mm/rev\"\nratio = 2\n\
         rotor_inertia = 2e-4\n";
    let (inverse, motors, _) = run(&model_of("spline", text));
    let screw = TAU / 0.02;
    for (k, &t) in inverse.column("time [s]").iter().enumerate() {
        let (sin, cos) = (TAU * t).sin_cos();
        let (turn, slide) = (-2.0 * TAU * TAU * sin, -0.05 * TAU * TAU * cos);
        let (torque, force) = (0.003 * turn, 2.0 * (slide + 9.81));
        let nut = 2e-4 * 2.0 * (screw * slide - turn) + force / screw / 2.0;
        // The reaction of the screw nut turns the shaft backwards; the spline nut carries this
        // torque.
        let spline = 1e-4 * 3.0 * turn + (torque + force / screw) / 3.0;
        let at = |name: &str| inverse.column(&format!("{name}.motor_torque [N m]"))[k];
        assert!((at("nut") - nut).abs() < 1e-12, "{t}: {} {nut}", at("nut"));
        assert!((at("spline") - spline).abs() < 1e-12, "{t}: {} {spline}", at("spline"));
        assert!(motors.column("residual [W]")[k].abs() < 1e-11);
    }
}

/// Tests three motors on two joints. The efforts of the motors add up to those of the joints, and
/// the sum of effort^2/share is minimal.
#[test]
fn more_motors_than_joints() {
    let parts = [[1.0, 0.0], [1.0, 1.0], [0.5, -1.0]];
    let shares = [0.2, 0.5, 0.9];
    let mut text = WRIST.to_owned();
    for (k, ([p, r], share)) in parts.iter().zip(shares).enumerate() {
        let roll = if *r == 0.0 { String::new() } else { format!(", roll = {r}") };
        text += &format!(
            "[actuators.m{k}]\njoints = {{ pitch = {p}{roll} }}\nratio = {}\nshare = {share}\n",
            k + 3
        );
    }
    let (inverse, motors, _) = run(&model_of("wrist", &text));
    for (k, &t) in inverse.column("time [s]").iter().enumerate() {
        let tau = efforts(motion(t));
        let efforts: Vec<f64> =
            (0..3).map(|m| motors.column(&format!("m{m}.effort [N m]"))[k]).collect();
        for (joint, tau) in tau.iter().enumerate() {
            let sum: f64 = efforts.iter().zip(&parts).map(|(e, part)| e * part[joint]).sum();
            assert!((sum - tau).abs() < 1e-12);
        }
        // In the optimal distribution, the weighted efforts are orthogonal to the null vector,
        // along which efforts change no joint effort.
        let null = [-1.5, 1.0, 1.0];
        let slope: f64 =
            efforts.iter().zip(&shares).zip(null).map(|((e, share), x)| e / share * x).sum();
        assert!(slope.abs() < 1e-12, "{slope}");
        for (m, effort) in efforts.iter().enumerate() {
            let torque = inverse.column(&format!("m{m}.motor_torque [N m]"))[k];
            // Without friction, motors at rest have the same torque.
            assert!((torque - effort / (m + 3) as f64).abs() < 1e-12);
        }
    }
}

#[test]
fn what_differentials_refuse() {
    let train = |name: &str, joints: &str| {
        format!("[actuators.{name}]\njoints = {{ {joints} }}\nratio = 10\nrotor_inertia = 1e-5\n")
    };
    let both = train("a", "pitch = 1, roll = 1");
    let message = errors(&[WRIST, &both]);
    assert!(
        message.contains("`a` cannot drive 2 joints (`pitch`, `roll`) independently"),
        "{message}"
    );
    let message = errors(&[WRIST, &both, &train("b", "pitch = 2, roll = 2")]);
    assert!(message.contains("cannot move `pitch`, `roll` independently"), "{message}");
    // A motor with zero share drives no joint.
    let idle = train("b", "pitch = 2, roll = -1") + "share = 0\n";
    let message = errors(&[WRIST, &both, &idle]);
    assert!(message.contains("independently: choose linearly independent"), "{message}");
    let message = errors(&[WRIST, &train("a", "pitch = 1, slide = 1")]);
    assert!(message.contains("drives joint `slide`, which does not exist"), "{message}");
}
