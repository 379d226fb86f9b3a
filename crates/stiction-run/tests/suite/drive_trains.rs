//! Drive trains against closed forms.

use crate::common::{Csv, MODES, files, job, model, model_of, tables};
use std::f64::consts::TAU;
use stiction_core::dynamics::FrictionMode;
use stiction_core::forward::{ConstantEfforts, Forward, Settings, Simulation};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_core::spatial::Vec3;
use stiction_format::{ModelFile, Source, gallery, read};
use stiction_run::breakaway;
use stiction_run::exchange::{Instant, model_file};
use stiction_run::inverse::{Curves, Sample, Summary};
use stiction_run::{Job, Sink};

/// Pendulum of 2 kg at 0.3 m, with 0.05 kg m^2 about its centre of mass. It hangs down at the
/// coordinate zero.
pub(crate) const PENDULUM: &str = "
gravity = [0, 0, -9.81]
[bodies.arm]
mass = 2
com = [0, 0, -0.3]
inertia = [0.05, 0.05, 0.01]
[joints.pivot]
type = \"R\"
from = \"ground\"
to = \"arm\"
axis = \"y\"
[loads.none]
";
/// Vertical slide of 40 kg.
pub(crate) const SLIDE: &str = "
gravity = [0, 0, -9.81]
[bodies.table]
mass = 40
com = [0, 0, 0]
inertia = [1, 1, 1]
[joints.axis]
type = \"P\"
from = \"ground\"
to = \"table\"
axis = \"z\"
[loads.none]
";
pub(crate) const SWING: &str = "[motions.m]\nduration = 2\npivot = \"1.2 rad*sin(2*pi*t/1 s)\"\n";
pub(crate) const LIFT: &str =
    "[motions.m]\nduration = 2\nstep = 0.01\naxis = \"0.1 m*sin(2*pi*t/2 s)\"\n";

pub(crate) fn with(parts: &[&str]) -> ModelFile {
    model_of("machine", &parts.concat())
}

fn job_of(model: &ModelFile) -> Job<'_> {
    job(model, "m", "none", FrictionMode::Converged)
}

/// Returns the tables `inverse.csv` and `motors.csv`, and the summary of a run.
fn run(job: &Job<'_>) -> (Csv, Csv, serde_json::Value) {
    let mut tables = tables(job);
    let mut summary = Summary::new(job);
    let add = |sample: &Sample| {
        summary.add(sample)?;
        tables.add(sample)
    };
    let verdict = job.run(add, |_, _, _| true).unwrap();
    let mut files = files(job, tables);
    let mut file = |name| Csv::parse(&files.remove(name).unwrap());
    (file("inverse.csv"), file("motors.csv"), summary.json(job, &verdict))
}

/// Returns the errors that the reader reports for a model, as text.
fn errors(parts: &[&str]) -> String {
    let text = parts.concat();
    read(&Source::new("machine.toml", text), &|_| Err("no files".into())).unwrap_err().to_string()
}

/// Returns angle, rate and acceleration of the swing at a time, s.
fn swing(t: f64) -> [f64; 3] {
    let (sin, cos) = (TAU * t).sin_cos();
    [1.2 * sin, 1.2 * TAU * cos, -1.2 * TAU * TAU * sin]
}

/// Returns the torque at the input of a gear for a given torque at its output.
fn input(output: f64, n: f64, rate: f64, (forward, backward): (f64, f64)) -> f64 {
    if output * rate > 0.0 { output / (n * forward) } else { backward * output / n }
}

#[test]
fn geared_pendulum() {
    for (ratio, forward, backward) in
        [(50.0, 0.8, 0.7), (-30.0, 0.6, -0.2), (1.0, 1.0, 1.0), (0.5, 0.9, 0.0)]
    {
        let train = format!(
            "[actuators.motor]\njoint = \"pivot\"\nratio = {ratio}\nrotor_inertia = 3e-5\n\
             efficiency = {forward}\nbackward_efficiency = {backward}\ntorque_constant = 0.07\n\
             motor_friction = {{ constant = 0.004, viscous = 2e-5 }}\n"
        );
        let model = with(&[PENDULUM, SWING, &train]);
        let (inverse, motors, summary) = run(&job_of(&model));
        let mut largest = 0.0_f64;
        for (k, &t) in inverse.column("time [s]").iter().enumerate() {
            let [q, rate, acceleration] = swing(t);
            let drive = (0.05 + 2.0 * 0.3 * 0.3) * acceleration + 2.0 * 9.81 * 0.3 * q.sin();
            let speed = ratio * rate;
            // At a reversal, the directions before and after it yield two torques.
            if rate.abs() < 1e-9 {
                let [low, high] = ["low", "high"]
                    .map(|end| inverse.column(&format!("motor.motor_torque_{end} [N m]"))[k]);
                let inertial = 3e-5 * ratio * acceleration;
                largest = largest.max((inertial + drive / ratio).abs());
                for sense in [1.0, -1.0] {
                    let friction = 0.004 * sense * f64::signum(ratio);
                    let ends =
                        inertial + friction + input(drive, ratio, sense, (forward, backward));
                    assert!(low - 1e-12 < ends && ends < high + 1e-12, "{low} {ends} {high}");
                }
                continue;
            }
            let expected = 3e-5 * ratio * acceleration
                + 0.004 * speed.signum()
                + 2e-5 * speed
                + input(drive, ratio, rate, (forward, backward));
            let at = |name: &str| inverse.column(name)[k];
            largest = largest.max(expected.abs());
            for (name, expected, scale) in [
                ("pivot.drive [N m]", drive, 10.0),
                ("motor.motor_torque [N m]", expected, 10.0 / ratio.abs()),
                ("motor.motor_torque_low [N m]", expected, 10.0 / ratio.abs()),
                ("motor.motor_speed [rad/s]", speed, 10.0 * ratio.abs()),
                ("motor.current [A]", expected / 0.07, 100.0 / ratio.abs()),
            ] {
                assert!((at(name) - expected).abs() < 1e-12 * scale, "{name} at {t}: {expected}");
            }
            let of = |name: &str| motors.column(name)[k];
            let losses = of("motor.motor_friction [W]") + of("motor.gear_loss [W]");
            let balance =
                of("motor.motor_power [W]") - of("motor.output [W]") - of("motor.rotor [W]");
            assert!((balance - losses).abs() < 1e-12 * 1e3, "{balance} {losses}");
            assert!(of("motor.motor_friction [W]") >= 0.0 && of("motor.gear_loss [W]") >= -1e-12);
            assert!((of("motor.motor_power [W]") - expected * speed).abs() < 1e-11 * 100.0);
            assert!(of("residual [W]").abs() < 1e-11);
        }
        let peak = summary["actuators"]["motor"]["motor_torque"]["peak"].as_f64().unwrap();
        assert!((peak.abs() - largest).abs() < 1e-12, "{peak}");
    }
}

/// Tests a screw with a lead of 10 mm on a vertical axis, driven through a belt of ratio 2.
#[test]
fn ball_screw_axis() {
    let spellings = [
        "lead = \"10 mm/rev\"",
        "lead = \"10 mm\"",
        "lead = 0.01",
        "lead = \"10 mm/(2*pi*1 rad)\"",
        "lead = \"10 mm/(360 deg)\"",
    ];
    for spelling in spellings {
        let train = format!(
            "[actuators.motor]\njoint = \"axis\"\n{spelling}\nratio = 2\n\
             rotor_inertia = \"2 kg cm^2\"\nefficiency = 0.9\n"
        );
        let model = with(&[SLIDE, LIFT, &train]);
        let (inverse, ..) = run(&job_of(&model));
        let n = 2.0 * TAU / 0.01;
        for (k, &t) in inverse.column("time [s]").iter().enumerate() {
            let (sin, cos) = (TAU * t / 2.0).sin_cos();
            let (rate, acceleration) = (0.1 * TAU / 2.0 * cos, -0.1 * (TAU / 2.0).powi(2) * sin);
            let force = 40.0 * (9.81 + acceleration);
            // At the reversal at 0.5 s, the computed rate is a rounding error.
            if rate.abs() < 1e-9 {
                continue;
            }
            let expected = 2e-4 * n * acceleration + input(force, n, rate, (0.9, 2.0 - 1.0 / 0.9));
            let found = inverse.column("motor.motor_torque [N m]")[k];
            assert!((found - expected).abs() < 1e-12, "{spelling} at {t}: {found} {expected}");
            let speed = inverse.column("motor.motor_speed [rad/s]")[k];
            assert!((speed - n * rate).abs() < 1e-12 * n, "{speed}");
        }
    }
}

/// Tests a worm gear with a pressure angle of 20 degrees that lifts the weight of a pendulum. The
/// efficiencies are those of a wedge. At the threshold of self-locking, the torque that keeps the
/// load from sinking changes its sign.
#[test]
fn worm_hoist() {
    let lead_angle = 6f64.to_radians();
    let flank = 20f64.to_radians();
    let tilt = (flank.tan() * lead_angle.cos()).atan();
    let threshold = lead_angle.tan() * tilt.cos();
    for mu in [0.02, threshold * (1.0 - 1e-11), threshold * (1.0 + 1e-11), 0.18] {
        let train = format!(
            "[actuators.worm]\njoint = \"pivot\"\nratio = 40\nrotor_inertia = 1e-5\n\
             mesh = {{ mu = {mu}, lead_angle = \"6 deg\", flank_angle = \"20 deg\" }}\n\
             limits = {{ peak = 0.05 }}\n"
        );
        let friction = (mu / tilt.cos()).atan();
        let forward = lead_angle.tan() / (lead_angle + friction).tan();
        let backward = (lead_angle - friction).tan() / lead_angle.tan();
        let model = with(&[PENDULUM, SWING, &train]);
        let (inverse, ..) = run(&job_of(&model));
        for (k, &t) in inverse.column("time [s]").iter().enumerate() {
            let [q, rate, acceleration] = swing(t);
            if rate.abs() < 1e-9 {
                continue;
            }
            let drive = 0.23 * acceleration + 2.0 * 9.81 * 0.3 * q.sin();
            let expected =
                1e-5 * 40.0 * acceleration + input(drive, 40.0, rate, (forward, backward));
            let found = inverse.column("worm.motor_torque [N m]")[k];
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        // The pendulum is at rest at 30 degrees.
        let still = with(&[PENDULUM, "[motions.m]\nduration = 0\npivot = \"30 deg\"\n", &train]);
        let job = job_of(&still);
        let weight = 2.0 * 9.81 * 0.3 * 0.5 / 40.0;
        let found = breakaway::evaluate(&job, None).unwrap().json(&job);
        let found = &found["actuators"]["worm"];
        let close = |value: &serde_json::Value, expected: f64| {
            assert!((value.as_f64().unwrap() - expected).abs() < 1e-12, "{value} {expected}");
        };
        close(&found["low"], weight * backward);
        close(&found["high"], weight / forward);
        assert_eq!(found["power_off"]["held"], mu > threshold);
        close(&found["power_off"]["brake_torque"], (weight * backward).max(0.0));
        let (_, _, summary) = run(&job);
        assert_eq!(summary["actuators"]["worm"]["power_off"]["held"], mu > threshold);
    }
}

/// Tests that a rotor with ratio one and a fixed housing is equivalent to an additional moment of
/// inertia of the driven link.
#[test]
fn rotors_are_inertias_of_their_links() {
    let text = gallery::get("five-bar").unwrap();
    let plain = model("five-bar");
    let actuators: Vec<_> = plain.mechanism.actuators().collect();
    let mut trains = String::new();
    let mut heavier = plain.clone();
    let mut bodies = Vec::new();
    for (k, (joint, _)) in actuators.iter().enumerate() {
        let joint = &plain.mechanism.joints()[joint.0];
        trains += &format!(
            "[actuators.m{k}]\njoint = \"{}\"\nrotor_inertia = {}\n",
            joint.name,
            2e-3 * (k + 1) as f64
        );
        bodies.push((joint.successor, 2e-3 * (k + 1) as f64));
    }
    heavier.mechanism = with_inertia(&plain.mechanism, &bodies);
    let geared = model_of("five-bar", &format!("{text}\n{trains}"));
    let (motion, load) =
        (plain.default_motion.clone().unwrap(), plain.default_load.clone().unwrap());
    for friction in MODES {
        let (found, ..) = run(&job(&geared, &motion, &load, friction));
        let mut expected = tables(&job(&heavier, &motion, &load, friction));
        let job = job(&heavier, &motion, &load, friction);
        job.run(|sample| expected.add(sample), |_, _, _| true).unwrap();
        let expected = Csv::parse(&files(&job, expected)["inverse.csv"]);
        for (k, (joint, _)) in actuators.iter().enumerate() {
            let name = &plain.mechanism.joints()[joint.0].name;
            let expected = expected.column(&format!("{name}.drive [N m]"));
            let torque = found.column(&format!("m{k}.motor_torque [N m]"));
            for (a, b) in torque.iter().zip(expected) {
                assert!((a - b).abs() < 1e-11 * b.abs().max(1.0), "{name}: {a} {b}");
            }
        }
    }
}

/// Returns a copy of the mechanism in which some bodies have larger moments of inertia in all
/// directions.
fn with_inertia(
    mechanism: &Mechanism,
    more: &[(stiction_core::mechanism::BodyId, f64)],
) -> Mechanism {
    use stiction_core::spatial::{Mat3, Vec3};
    let text = model_file(mechanism, "", Instant::default()).unwrap();
    let mut document: toml::Table = text.parse().unwrap();
    for (body, inertia) in more {
        let name = &mechanism.bodies()[body.0].name;
        let table = document["bodies"][name].as_table_mut().unwrap();
        let own = mechanism.bodies()[body.0].inertia
            + Mat3::diagonal(Vec3::new(*inertia, *inertia, *inertia));
        let entries =
            [("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2)];
        let entries = entries.map(|(key, i, j)| (key.to_owned(), toml::Value::from(own.at(i, j))));
        table.insert("inertia".into(), toml::Value::Table(entries.into_iter().collect()));
    }
    model_of("heavier", &document.to_string()).mechanism
}

/// Tests that, at rest, the friction of joint, gear and motor opposes the onset of motion in either
/// direction.
#[test]
fn torques_that_hold() {
    let joint =
        SLIDE.replace("axis = \"z\"", "axis = \"z\"\nfriction = { mu = 0.1, preload = 500 }");
    let still = "[motions.m]\nduration = 0\naxis = 0\n";
    let train = "[actuators.motor]\njoint = \"axis\"\nlead = \"-5 mm/rev\"\nefficiency = 0.8\n\
                 backward_efficiency = 0.5\nmotor_friction = { constant = 0.01 }\n";
    let model = with(&[&joint, still, train]);
    let (inverse, motors, summary) = run(&job_of(&model));
    let n = -TAU / 0.005;
    let weight = 40.0 * 9.81;
    let at = |name: &str| inverse.column(name)[0];
    let (low, high) = ((weight + 50.0) / (n * 0.8) - 0.01, 0.5 * (weight - 50.0) / n + 0.01);
    for (name, expected) in [
        ("motor.motor_torque [N m]", weight / n),
        ("motor.motor_torque_low [N m]", low),
        ("motor.motor_torque_high [N m]", high),
        ("motor.motor_speed [rad/s]", 0.0),
    ] {
        assert!((at(name) - expected).abs() < 1e-12, "{name}: {} {expected}", at(name));
    }
    assert_eq!(motors.column("motor.motor_power [W]"), [0.0]);
    let power_off = &summary["actuators"]["motor"]["power_off"];
    let brake = power_off["brake_torque"].as_f64().unwrap();
    assert!((brake + high).abs() < 1e-12, "{brake} {high}");
}

/// Tests a hinge whose axis is parallel to gravity: it carries the weight without torque. The
/// remaining rounding error requires no brake.
#[test]
fn rounding_errors_need_no_brake() {
    let model = with(&["
gravity = [1.1, 2.3, -3.7]
[bodies.arm]
mass = 3
com = [0.3, 0.2, 0.1]
inertia = [0.05, 0.05, 0.05]
[joints.pin]
type = \"R\"
from = \"ground\"
to = \"arm\"
axis = [1.1, 2.3, -3.7]
[actuators.motor]
joint = \"pin\"
ratio = 10
efficiency = 0.8
[loads.none]
[motions.m]
duration = 0
pin = 0.3
"]);
    let job = job_of(&model);
    let (inverse, _, summary) = run(&job);
    let effort = inverse.column("pin.drive [N m]")[0];
    assert!(effort != 0.0 && effort.abs() < 1e-13, "{effort}");
    let power_off = &summary["actuators"]["motor"]["power_off"];
    assert_eq!((&power_off["held"], &power_off["brake_torque"]), (&true.into(), &0.0.into()));
}

#[test]
fn limits_of_the_motor() {
    // The rms torque of an inertia of 0.05 kg m^2 on a sine of 1 rad at 1 Hz is 0.05 (2 pi)^2 /
    // sqrt 2.
    let wheel = "
gravity = [0, 0, 0]
[bodies.wheel]
mass = 1
com = [0, 0, 0]
inertia = [0.05, 0.05, 0.05]
[joints.hub]
type = \"R\"
from = \"ground\"
to = \"wheel\"
axis = \"z\"
[loads.none]
[motions.m]
duration = 2
hub = \"1 rad*sin(2*pi*t/1 s)\"
";
    let rms = 0.05 * TAU * TAU / 2f64.sqrt();
    let train = format!(
        "[actuators.leg2]\njoint = \"hub\"\nlimits = {{ rated = {}, peak = {}, speed = \"60 rpm\" }}\n",
        rms / 1.12,
        rms * 1.5
    );
    let model = with(&[wheel, &train]);
    let job = job_of(&model);
    let (_, _, summary) = run(&job);
    let motor = &summary["actuators"]["leg2"];
    let found = motor["motor_torque"]["rms"].as_f64().unwrap();
    assert!((found - rms).abs() < 1e-12, "{found} {rms}");
    let power = motor["work"].as_f64().unwrap();
    assert!(power.abs() < 1e-12 && motor["duty"].as_f64().unwrap() > 0.97, "{motor}");
    let cautions: Vec<_> =
        summary["cautions"].as_array().unwrap().iter().map(|c| c.as_str().unwrap()).collect();
    assert_eq!(cautions.len(), 1, "{cautions:?}");
    assert!(cautions[0].starts_with("leg2: 112 % of rated rms torque ("), "{cautions:?}");
    let limits = &motor["limits"];
    assert_eq!(limits["peak"]["exceeded"], false);
    // 60 rpm is 2 pi rad/s, which the motion reaches exactly.
    assert_eq!(limits["speed"]["exceeded"], false);

    let count = job.instants().unwrap().count();
    let mut curves = Curves::new(&job, count);
    job.run(|sample| curves.add(sample), |_, _, _| true).unwrap();
    let (_, figure) = curves.figures().into_iter().find(|(name, _)| *name == "motors").unwrap();
    let labels: Vec<_> = figure.panels[0].lines.iter().map(|line| line.label.as_str()).collect();
    assert_eq!(labels, ["motion", "rms", "", "rated", "", "peak", "", "speed", ""]);
}

/// Tests that two motors on one joint share its effort in the declared ratio, and are rejected
/// without shares.
#[test]
fn several_motors_on_one_joint() {
    let train = |name: &str, rest: &str| {
        format!("[actuators.{name}]\njoint = \"pivot\"\nratio = 20\nrotor_inertia = 1e-5\n{rest}\n")
    };
    let [a, b] = [train("a", "share = 0.25"), train("b", "share = 0.75")];
    let both = with(&[PENDULUM, SWING, &a, &b]);
    let one = with(&[PENDULUM, SWING, &train("one", "")]);
    let (both, ..) = run(&job_of(&both));
    let (one, ..) = run(&job_of(&one));
    for (k, torque) in one.column("one.motor_torque [N m]").iter().enumerate() {
        let acceleration = swing(one.column("time [s]")[k])[2];
        let rotor = 1e-5 * 20.0 * acceleration;
        let [a, b] = ["a", "b"].map(|name| both.column(&format!("{name}.motor_torque [N m]"))[k]);
        assert!((a - rotor - 0.25 * (torque - rotor)).abs() < 1e-13);
        assert!((b - rotor - 0.75 * (torque - rotor)).abs() < 1e-13);
    }
    let message = errors(&[PENDULUM, SWING, &train("a", ""), &train("b", "")]);
    assert!(
        message.contains("the shares of `a`, `b` in the effort of `pivot` sum to 2"),
        "{message}"
    );
}

#[test]
fn what_is_refused() {
    let cases = [
        ("joint = \"pivo\"", "drives joint `pivo`, which does not exist"),
        ("joint = \"pivot\"\nlead = \"5 mm/rev\"", "turns: give a `ratio` instead of a `lead`"),
        ("joint = \"pivot\"\nratio = 0", "`ratio` is 0, but must be other than 0"),
        ("joint = \"pivot\"\nefficiency = 1.2", "`efficiency` is 1.2"),
        ("joint = \"pivot\"\nefficiency = \"85\"", "`efficiency` is 85"),
        ("joint = \"pivot\"\nbackward_efficiency = 0.5", "has no `efficiency`"),
        (
            "joint = \"pivot\"\nefficiency = 0.5\nmesh = { mu = 0.1, lead_angle = \"5 deg\", flank_angle = 0 }",
            "is given twice",
        ),
        (
            "joint = \"pivot\"\nmesh = { mu = 1.5, lead_angle = \"40 deg\", flank_angle = 0 }",
            "its mesh jams",
        ),
        ("joint = \"pivot\"\nlimits = { speed = \"50 Hz\" }", "write the unit of the angle"),
        ("joint = \"pivot\"\nlimits = { rated = \"3 N\" }", "expected a moment"),
        ("joint = \"pivot\"\ntorque_constant = \"0.1 N m\"", "expected a torque constant"),
        ("joint = \"pivot\"\nrotor_inertia = \"-1 kg m^2\"", "`rotor_inertia` is -1"),
        ("joint = \"pivot\"\nshare = 0.5", "sum to 0.5"),
        ("joints = { pivot = 2, other = -1 }", "drives joint `other`, which does not exist"),
        ("joints = { pivot = 0 }", "`joints` is 0, but must be other than 0"),
        ("joints = {}", "it drives no joint"),
        ("joints = { pivot = \"2 m\" }", "expected a plain number"),
        ("joint = \"pivot\"\njoints = { pivot = 1 }", "are given twice"),
        ("ratio = 3", "has no `joint`"),
        (
            "joint = \"pivot\"\nrotor_inertia = 1\nrotor_axis = { body = \"arn\", axis = \"y\" }",
            "is carried by body `arn`",
        ),
        (
            "joint = \"pivot\"\nrotor_inertia = 1\nrotor_axis = { body = \"arm\", axis = \"y\" }",
            "`rotor_inertia` is 1, but must be at most the moment of inertia",
        ),
        ("joint = \"pivot\"\nrotor_axis = { body = \"arm\" }", "`axis`"),
    ];
    for (text, expected) in cases {
        let message = errors(&[PENDULUM, SWING, &format!("[actuators.m]\n{text}\n")]);
        assert!(message.contains(expected), "{text}: {message}");
    }
    let message = errors(&[SLIDE, LIFT, "[actuators.m]\njoint = \"axis\"\nratio = 3\n"]);
    assert!(message.contains("translates: give the `lead`"), "{message}");
}

/// Tests motors on all legs of a hexapod, one of which has a different type, also after the model
/// is written and read again.
#[test]
fn motors_of_legs() {
    let text = gallery::get("gough").unwrap();
    let at = text.find("[[legs]]").or_else(|| text.find("[legs]")).expect("legs");
    let joint = if text.contains("[legs.joints.P]") { "[legs.joints.P]" } else { "" };
    assert!(!joint.is_empty() && at > 0);
    let geared = text.replacen(
        joint,
        "[legs.actuators.P]\nlead = \"5 mm/rev\"\nrotor_inertia = \"1e-5 kg m^2\"\nefficiency = 0.9\n\
         torque_constant = \"0.06 N m/A\"\nlimits = { rated = 0.4, peak = 1.2, speed = \"4000 rpm\" }\n\
         motor_friction = { constant = 0.01, viscous = 1e-5 }\n\n[legs.joints.P]",
        1,
    );
    let geared = model_of("gough", &geared);
    assert_eq!(geared.mechanism.drive_trains().len(), 6);
    let plain = model("gough");
    let (motion, load) =
        (plain.default_motion.clone().unwrap(), plain.default_load.clone().unwrap());
    let (inverse, motors, summary) = run(&job(&geared, &motion, &load, FrictionMode::Converged));
    let job = job(&plain, &motion, &load, FrictionMode::Converged);
    let mut expected = tables(&job);
    job.run(|sample| expected.add(sample), |_, _, _| true).unwrap();
    let expected = Csv::parse(&files(&job, expected)["inverse.csv"]);
    // Rigid motors do not change the joint efforts.
    for (name, column) in expected.columns() {
        assert_eq!(inverse.column(name), column, "{name}");
    }
    let n = TAU / 0.005;
    for leg in 1..=6 {
        let at = |name: &str| inverse.column(&format!("leg{leg}.P.{name}"));
        for (k, drive) in at("drive [N]").iter().enumerate() {
            let rate = at("speed [m/s]")[k];
            if rate.abs() > 1e-9 {
                let torque = at("motor_torque [N m]")[k];
                let gear = input(*drive, n, rate, (0.9, 2.0 - 1.0 / 0.9));
                let friction = 0.01 * rate.signum() + 1e-5 * n * rate;
                // The rest of the torque accelerates the rotor.
                let rotor = motors.column(&format!("leg{leg}.P.rotor [W]"))[k];
                assert!((torque - gear - friction - rotor / (n * rate)).abs() < 1e-9);
            }
        }
    }
    assert_eq!(summary["actuators"].as_object().unwrap().len(), 6);
    let residual = summary["verdicts"]["power_residual_with_motors"].as_f64().unwrap();
    assert!(residual < 1e-9, "{residual}");

    let written = model_file(&geared.mechanism, "", Instant::default()).unwrap();
    let again = model_of("again", &written);
    assert_eq!(again.mechanism.drive_trains(), geared.mechanism.drive_trains());
}

/// Returns position, rate and acceleration of the first joint after a second under a constant
/// effort, and the relative energy error.
fn after(model: &ModelFile, effort: f64, start: (f64, f64)) -> (Target<f64>, f64) {
    let forward = Forward::new(model.mechanism.clone(), &[]);
    let joint = Coordinate::Joint { joint: JointId(0), dof: 0 };
    let start = Target { value: start.0, rate: start.1, acceleration: 0.0 };
    let state = forward.assemble(&[], &[joint], &[start]).unwrap();
    let mut efforts = ConstantEfforts(vec![effort]);
    let mut simulation = forward.start(0.0, state, Settings::default(), &mut efforts).unwrap();
    simulation.advance(1.0, &mut efforts).unwrap();
    (simulation.joint_motion(JointId(0), 0), relative_error(&simulation))
}

pub(crate) fn relative_error(simulation: &Simulation<'_>) -> f64 {
    simulation.energy_error().abs() / simulation.energies().turnover.max(1e-300)
}

/// Tests a slide under a constant effort, with rotor, viscous and constant friction of its motor.
#[test]
fn simulated_slide() {
    let level = SLIDE.replace("-9.81", "0");
    let train = "[actuators.motor]\njoint = \"axis\"\nlead = \"10 mm/rev\"\nrotor_inertia = 2e-5\n\
                 motor_friction = { constant = 0.05, viscous = 1e-4 }\n";
    let n = TAU / 0.01;
    let (mass, damping, dry) = (40.0 + n * n * 2e-5, n * n * 1e-4, n * 0.05);
    let model = with(&[&level, LIFT, train]);
    let effort = 3.0 * dry;
    let (motion, error) = after(&model, effort, (0.0, 0.0));
    // Equation of motion: m v' = F - dry - damping v.
    let (final_rate, time) = ((effort - dry) / damping, mass / damping);
    let rate = final_rate * (1.0 - (-1.0 / time).exp());
    assert!((motion.rate - rate).abs() < 1e-9 * rate, "{} {rate}", motion.rate);
    assert!((motion.value - (final_rate - rate * time)).abs() < 1e-9, "{}", motion.value);
    assert!(error < 1e-9, "{error}");
    // The motor friction resists efforts up to its limit, and no greater efforts.
    assert_eq!(after(&model, dry * (1.0 - 1e-9), (0.0, 0.0)).0.rate, 0.0);
    assert!(after(&model, dry * (1.0 + 1e-6), (0.0, 0.0)).0.rate > 0.0);
    // The slide decelerates, stops and stays at rest; without viscous friction it stops after the
    // distance v^2 m / (2 dry).
    let dry_only = train.replace(", viscous = 1e-4", "");
    let model = with(&[&level, LIFT, &dry_only]);
    let (motion, error) = after(&model, 0.0, (0.0, 0.5));
    let way = 0.125 * mass / dry;
    assert!(motion.rate == 0.0 && (motion.value - way).abs() < 1e-9, "{} {way}", motion.value);
    assert!(error < 1e-9, "{error}");
}

/// Tests that the static friction of a joint and that of its motor add up.
#[test]
fn joint_and_motor_hold_together() {
    let level = SLIDE
        .replace("-9.81", "0")
        .replace("axis = \"z\"", "axis = \"z\"\nfriction = { mu = 0.1, preload = 500 }");
    let train = "[actuators.motor]\njoint = \"axis\"\nlead = \"-10 mm/rev\"\nrotor_inertia = 1e-5\n\
                 motor_friction = { constant = 0.05 }\n";
    let model = with(&[&level, LIFT, train]);
    let n = TAU / 0.01;
    let (dry, mass) = (50.0 + n * 0.05, 40.0 + n * n * 1e-5);
    for sense in [1.0, -1.0] {
        let (motion, _) = after(&model, sense * dry * (1.0 - 1e-9), (0.0, 0.0));
        assert_eq!(motion.rate, 0.0);
        let (motion, error) = after(&model, sense * (dry + 10.0), (0.0, 0.0));
        assert!((motion.value - sense * 5.0 / mass).abs() < 1e-9, "{}", motion.value);
        assert!(error < 1e-9);
        let (motion, _) = after(&model, 0.0, (0.0, sense * 0.3));
        assert!((motion.value - sense * 0.045 * mass / dry).abs() < 1e-9 && motion.rate == 0.0);
    }
}

/// Tests simulations of closed chains for every choice of the cut joints. Motors with prescribed
/// motion require the torques of inverse dynamics. Without efforts, the energy of the mechanism is
/// conserved.
#[test]
fn simulated_hexapod() {
    use stiction_core::topology::TreeRule;
    for (name, together) in
        [("gough", false), ("five-bar", false), ("gough", true), ("five-bar", true)]
    {
        let plain = model(name);
        let mut trains = String::new();
        for (k, (joint, dof)) in plain.mechanism.actuators().enumerate() {
            let joint = &plain.mechanism.joints()[joint.0];
            let kind =
                if joint.joint_type.dofs()[dof].translates() { "lead = 0.02" } else { "ratio = 5" };
            // Every second rotor spins on a body and has a third of the inertia of this body.
            let carrier = &plain.mechanism.bodies()[joint.successor.0];
            let axis = Vec3::new(0.48, 0.6, 0.64);
            let (inertia, spin) = match k % 2 {
                0 => {
                    let spin = "rotor_axis = { body = \"NAME\", axis = [0.48, 0.6, 0.64] }\n";
                    let inertia = axis.dot(carrier.inertia * axis) / 3.0;
                    (inertia, spin.replace("NAME", &carrier.name))
                }
                _ => (1e-4, String::new()),
            };
            // Each motor moves its joint and, if `together` is true, also the next joint.
            let next =
                plain.mechanism.actuators().nth(k + 1).or(plain.mechanism.actuators().next());
            let next = &plain.mechanism.joints()[next.unwrap().0.0].name;
            let (driven, friction) = match together {
                true => (format!("joints = {{ \"{}\" = 1.5, \"{next}\" = -0.4 }}", joint.name), ""),
                false => (
                    format!("joint = \"{}\"", joint.name),
                    "motor_friction = { constant = 0.02, viscous = 1e-4 }\n\
                     efficiency = 0.8\nbackward_efficiency = 0.6\n",
                ),
            };
            trains += &format!(
                "[actuators.m{k}]\n{driven}\n{kind}\nrotor_inertia = {inertia}\n{spin}{friction}"
            );
        }
        let text = format!("{}\n{trains}", gallery::get(name).unwrap());
        let geared = model_of(name, &text);
        let (motion, load) = (geared.default_motion.clone().unwrap(), geared.loads[0].0.clone());
        let job = Job { load: &NO_LOAD, ..job(&geared, &motion, &load, FrictionMode::Converged) };
        let (inverse, ..) = run(&job);
        let time = geared.motion(&motion).unwrap().duration * 0.31;
        let row = inverse.column("time [s]").iter().position(|t| *t >= time).unwrap();
        let time = inverse.column("time [s]")[row];
        let mut follower = job.assemble(job.motion.start).unwrap();
        follower.go_to(time).unwrap();
        let solver = &follower.solver;
        let actuators: Vec<_> = geared.mechanism.actuators().collect();
        let targets: Vec<Target<f64>> =
            actuators.iter().map(|(joint, dof)| solver.joint_motion(*joint, *dof)).collect();
        for rule in
            [TreeRule::Structure, TreeRule::Random(1), TreeRule::Random(2), TreeRule::Random(3)]
        {
            let all: Vec<usize> = (0..actuators.len()).collect();
            let mechanism = geared.mechanism.starting_at(solver.bodies().joint_poses());
            let forward = Forward::with_tree(mechanism.clone(), rule, &all);
            let coordinates: Vec<_> = actuators
                .iter()
                .map(|(joint, dof)| Coordinate::Joint { joint: *joint, dof: *dof })
                .collect();
            let state = forward.assemble(&[], &coordinates, &targets).unwrap();
            let mut led = Led(targets.clone());
            let simulation =
                forward.start(0.0, state.clone(), Settings::default(), &mut led).unwrap();
            let maps = geared.mechanism.motor_maps();
            for (k, train) in geared.mechanism.drive_trains().iter().enumerate() {
                let expected = inverse.column(&format!("m{k}.motor_torque [N m]"))[row];
                let found = maps[k].effort(&simulation.instant().drives) / train.transmission();
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{name} {rule:?} m{k}: {found} {expected}"
                );
            }
            // The torques of inverse dynamics with friction cause the motion.
            let efforts = simulation.instant().drives.clone();
            let unled = Forward::with_tree(mechanism.clone(), rule, &[]);
            let mut efforts = ConstantEfforts(efforts);
            let driven =
                unled.start(0.0, state.clone(), Settings::default(), &mut efforts).unwrap();
            for ((joint, dof), expected) in actuators.iter().zip(&targets) {
                let found = driven.joint_motion(*joint, *dof).acceleration;
                assert!((found - expected.acceleration).abs() < 1e-8, "{name} {rule:?}: {found}");
            }
            // Without efforts, the energy balance closes.
            let free = Forward::with_tree(mechanism, rule, &[]);
            let mut none = ConstantEfforts(Vec::new());
            let mut simulation = free.start(0.0, state, Settings::default(), &mut none).unwrap();
            simulation.advance(0.05, &mut none).unwrap();
            assert!(relative_error(&simulation) < 1e-8, "{name} {}", relative_error(&simulation));
        }
    }
}

static NO_LOAD: stiction_format::LoadCase = stiction_format::LoadCase {
    title: String::new(),
    wrenches: Vec::new(),
    laws: Vec::new(),
    payloads: Vec::new(),
};

/// Inputs with a prescribed motion of each actuator.
struct Led(Vec<Target<f64>>);

impl stiction_core::forward::Inputs for Led {
    fn efforts(&mut self, _: &stiction_core::forward::View<'_>, _: &mut [f64]) {}

    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        for (target, at) in targets.iter_mut().zip(&self.0) {
            let rate = at.rate + at.acceleration * time;
            let value = at.value + (at.rate + 0.5 * at.acceleration * time) * time;
            *target = Target { value, rate, acceleration: at.acceleration };
        }
    }
}
