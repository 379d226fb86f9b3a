//! Identification from torques that are measured at motors, and the uncertainty of friction.

use super::columns;
use crate::program::{Folder, column, json};
use std::fmt::Write as _;

/// Writes the log `log.csv` of the motor torques of `model`, computed along [`MOTION`].
/// `joints` and `motors` are the names of the two joints and of their motors.
fn log(folder: &Folder, model: &str, joints: [&str; 2], motors: [&str; 2]) {
    folder
        .stiction(&["inverse", model, "--motion", MOTION, "--report", "off", "-o", "out"])
        .succeeds();
    let positions = joints.map(|joint| format!("{joint}.position [rad]"));
    let table = folder.read("out/inverse.csv");
    let torques = motors.map(|motor| format!("{motor}.motor_torque [N m]"));
    let [q1, q2] = positions.each_ref().map(|name| column(&table, name));
    let [t1, t2] = torques.each_ref().map(|name| column(&table, name));
    let times = columns(&table, ["time"]);
    let mut text =
        format!("time [s],{} [rad],{} [rad],{},{}\n", joints[0], joints[1], torques[0], torques[1]);
    for (k, [time]) in times.iter().enumerate() {
        writeln!(text, "{time},{},{},{},{}", q1[k], q2[k], t1[k], t2[k]).unwrap();
    }
    folder.write("log.csv", &text);
}

/// An arm of two links with the given motors.
fn arm(motors: &str) -> String {
    let link = |name: &str, from: &str, mass: f64, at: &str| {
        format!(
            "[bodies.{name}]\nmass = {mass}\ncom = [0.15, 0, 0.01]\ninertia = [0.01, 0.04, 0.04]\n\
             [joints.{name}_pin]\ntype = \"R\"\nfrom = \"{from}\"\nto = \"{name}\"\nat = {at}\n\
             axis = \"y\"\nfriction = {{ mu = 0.1, radius = 0.02, viscous = \"0.2 N m s/rad\" }}\n"
        )
    };
    let links =
        [link("upper", "ground", 4.0, "[0, 0, 0]"), link("lower", "upper", 2.0, "[0.3, 0, 0]")];
    format!("gravity = [0, 0, -9.81]\n{}{motors}\n", links.concat())
}

const MOTION: &str = "upper_pin = 0.6*sin(1.1*t) + 0.4*sin(4.3*t + 1) + 0.15*sin(7*t); \
                      lower_pin = 0.8*sin(1.7*t) + 0.2*sin(2.9*t + 1); duration = 10; step = 10 ms";
const JOINTS: [&str; 2] = ["upper_pin", "lower_pin"];
const MOTORS: [&str; 2] = ["shoulder", "elbow"];

/// The torque of a spinning rotor contains the acceleration of the body that carries it, and its
/// moment on this body loads the other motor: the model that made the log predicts it.
#[test]
fn spinning_rotors_are_parts_of_the_model() {
    let folder = Folder::new("identify-rotors");
    let motors = "
        [actuators.shoulder]
        joint = \"upper_pin\"
        ratio = 50
        rotor_inertia = 5e-5
        rotor_axis = { body = \"ground\", axis = \"y\" }
        [actuators.elbow]
        joint = \"lower_pin\"
        ratio = 2
        rotor_inertia = 0.01
        rotor_axis = { body = \"upper\", axis = [0, 0.8, 0.6] }";
    folder.write("arm.toml", &arm(motors));
    log(&folder, "arm.toml", JOINTS, MOTORS);
    let run = ["identify", "arm.toml", "log.csv", "--filter", "10 Hz", "--json"];
    let result = json(folder.stiction(&run).succeeds());
    let errors = result["predictions"][0]["error_percent_of_model"].as_object().unwrap();
    assert_eq!(errors.len(), 2);
    for (actuator, error) in errors {
        // Errors are those of filtering: 11 % without the terms of the rotors.
        assert!(error.as_f64().unwrap() < 0.5, "{actuator}: {error}");
    }
}

/// Efforts at motors contain the losses of the gears, which become a part of the identified
/// friction. The written model has no losses in addition: it needs the measured torques.
#[test]
fn the_identified_model_counts_gear_losses_once() {
    let folder = Folder::new("identify-gear-loss");
    let motors = "
        [actuators.shoulder]
        joint = \"upper_pin\"
        ratio = 50
        efficiency = 0.8
        backward_efficiency = 0.75
        [actuators.elbow]
        joint = \"lower_pin\"
        ratio = 30
        efficiency = 0.85";
    folder.write("arm.toml", &arm(motors));
    log(&folder, "arm.toml", JOINTS, MOTORS);
    let run = ["identify", "arm.toml", "log.csv", "--filter", "10 Hz", "--force", "-o", "found"];
    let said = folder.stiction(&run);
    assert!(said.out.contains("the gears of the identified model have no losses"), "{}", said.out);
    let rms = |model: &str| {
        let run = ["inverse", model, "--motion", MOTION, "--json"];
        let summary = json(folder.stiction(&run).succeeds());
        MOTORS.map(|motor| summary["actuators"][motor]["motor_torque"]["rms"].as_f64().unwrap())
    };
    let (expected, found) = (rms("arm.toml"), rms("found/identified.toml"));
    for (expected, found) in expected.into_iter().zip(found) {
        assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
    }
}

/// On a horizontal slide, only the product of mass and coefficient of friction is known precisely:
/// the coefficient has the relative uncertainty of the mass.
#[test]
fn a_coefficient_of_friction_is_as_uncertain_as_the_mass() {
    let folder = Folder::new("identify-slide");
    let text = "
        gravity = [0, 0, -9.81]
        [bodies.carriage]
        mass = 10
        com = [0, 0, 0]
        inertia = [0.1, 0.1, 0.1]
        [joints.guide]
        type = \"P\"
        from = \"ground\"
        to = \"carriage\"
        axis = \"x\"
        actuated = true
        friction = { mu = 0.2, viscous = 20 }";
    folder.write("slide.toml", text);
    let parameters = "carriage.mass,guide.mu,guide.viscous";
    let limits = ["--limit", "guide=150 mm", "--limit", "guide.acceleration=0.5 m/s^2"];
    let more = ["--parameters", parameters, "--noise", "8 N", "--iterations", "5", "--json"];
    let run = [&["excite", "slide.toml"], &limits[..], &more].concat();
    let result = json(folder.stiction(&run).succeeds());
    let expected = result["parameters"].as_array().unwrap();
    let part = |name: &str| {
        let own = expected.iter().find(|own| own["name"] == name).unwrap();
        own["sigma"].as_f64().unwrap() / own["value"].as_f64().unwrap()
    };
    let (mass, mu) = (part("carriage.mass"), part("guide.mu"));
    assert!(mass > 0.05 && (mu / mass - 1.0).abs() < 0.1, "{mass} {mu}");
}
