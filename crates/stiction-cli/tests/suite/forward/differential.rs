//! A wrist whose two motors move both joints, with friction in motors and gears.

use crate::program::{Folder, column, json};

const WRIST: &str = r#"
gravity = [0, 0, "-9.81 m/s^2"]
[bodies.fork]
mass = "0.5 kg"
com = [0, 0, 0]
inertia = ["1e-3 kg m^2", "2e-3 kg m^2", "2e-3 kg m^2"]
[bodies.hand]
mass = "0.6 kg"
com = [0, 0, "50 mm"]
inertia = ["2e-3 kg m^2", "2e-3 kg m^2", "1e-3 kg m^2"]
[joints.pitch]
type = "R"
from = "ground"
to = "fork"
axis = "y"
friction = { mu = 0.1, radius = "5 mm" }
[joints.roll]
type = "R"
from = "fork"
to = "hand"
axis = "z"
[actuators.left]
joints = { pitch = 1, roll = 2 }
ratio = 25
rotor_inertia = "0.04 kg cm^2"
efficiency = 0.85
backward_efficiency = 0.8
motor_friction = { constant = "3 mN m" }
[actuators.right]
joints = { pitch = 1, roll = -2 }
ratio = 25
rotor_inertia = "0.04 kg cm^2"
efficiency = 0.85
backward_efficiency = 0.8
motor_friction = { constant = "3 mN m" }
[motions.m]
duration = "1 s"
pitch = "0.9 rad*sin(2*pi*t/1 s)"
roll = "1.4 rad*cos(2*pi*t/2 s)"
"#;

/// Checks simulations with controllers with and without a model of the robot, with torques from
/// inverse dynamics, and a linear model. Each lists the friction interfaces of both motors, but
/// none of the shafts that the simulation adds.
#[test]
fn motors_of_several_joints_with_friction_are_simulated() {
    let folder = Folder::new("forward-differential");
    folder.write("wrist.toml", WRIST);
    for controller in ["pd", "computed-torque+friction", "none"] {
        let drives = if controller == "none" { "inverse" } else { "none" };
        let arguments =
            ["forward", "wrist.toml", "--controller", controller, "--drives", drives, "-o", "out"];
        let said = folder.stiction(&arguments);
        let out = said.succeeds();
        assert!(out.contains("left.motor") && out.contains("right.motor"), "{out}");
        assert!(!out.contains("note:") && !said.err.contains("shaft"), "{out}{}", said.err);
        let results = Folder(folder.0.join("out"));
        for file in ["forward.csv", "reactions.csv", "friction.csv", "bodies.csv", "energy.csv"] {
            let table = results.read(file);
            let width = |line: &str| line.split(',').count();
            let header = width(table.lines().next().unwrap());
            assert!(table.lines().all(|line| width(line) == header), "{controller}: {file}");
        }
        let energy = results.read("energy.csv");
        let turnover = *column(&energy, "turnover [J]").last().unwrap();
        assert!(column(&energy, "error [J]").iter().all(|error| error.abs() < 1e-8 * turnover));
        assert!(*column(&energy, "left.motor.dissipated [J]").last().unwrap() > 0.1);
    }
    // The torques of inverse dynamics initially cause the accelerations of the motion; later they
    // differ, because they are constant between samples.
    let table = folder.read("out/forward.csv");
    let expected = -1.4 * std::f64::consts::PI.powi(2);
    let first = |name: &str| column(&table, name)[0];
    assert!(first("pitch.acceleration [rad/s^2]").abs() < 1e-9);
    assert!((first("roll.acceleration [rad/s^2]") - expected).abs() < 1e-9);
    let model = folder.stiction(&["linearize", "wrist.toml", "--at", "0.3", "--json"]);
    let model = json(model.succeeds());
    assert_eq!(model["states"].as_array().unwrap().len(), 4, "{model}");
    // With the pitch locked, both motors rotate in opposite directions and share the friction of
    // the roll.
    let said = folder.stiction(&["forward", "wrist.toml", "--hold", "pitch", "-o", "locked"]);
    assert!(said.succeeds().contains("locked: pitch"), "{}", said.out);
    let energy = folder.read("locked/energy.csv");
    let [left, right] = ["left", "right"]
        .map(|name| *column(&energy, &format!("{name}.motor.dissipated [J]")).last().unwrap());
    assert!(left > 0.1 && (left - right).abs() < 1e-9 * left, "{left} {right}");
}
