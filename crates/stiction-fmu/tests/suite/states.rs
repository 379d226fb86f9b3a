//! Many instances, and states that are saved and restored.

use crate::importer::{Extracted, Importer, Version};
use stiction::Robot;

const PERIOD: f64 = 1e-3;

fn five_bar(name: &str) -> Extracted {
    let robot = Robot::builtin("five-bar").unwrap();
    Extracted::new(name, &robot.export().plant().from("rest").force_on("tool"))
}

fn start(unit: &Extracted, version: Version) -> Importer<'_> {
    let plant = Importer::new(unit, version);
    plant.enter(0.0);
    assert_eq!(plant.exit(), 0, "{}", plant.said());
    plant
}

/// Takes one step with a controller that lets joints stick; the controller depends on `kind`.
fn step(plant: &Importer<'_>, step: u32, kind: u32) {
    let time = PERIOD * f64::from(step);
    let goal = 2.0 + 0.002 * f64::from(kind);
    let position = plant.get("left_motor.position");
    let speed = plant.get("left_motor.speed");
    plant.set("left_motor.effort", 40.0 * (goal - position) - 2.0 * speed);
    plant.set("tool.fx", if step % 20 < 10 { 3.0 } else { -3.0 });
    plant.step(time, PERIOD);
}

/// All numbers of an instance, bit by bit.
fn bits(plant: &Importer<'_>) -> Vec<u64> {
    let real = |reference| plant.get_by(reference).map(f64::to_bits);
    let integer = |reference| plant.integer_by(reference).map(|i| u64::from(i.cast_unsigned()));
    let each = (0..plant.unit.count()).map(|r| real(r).or_else(|_| integer(r)));
    each.collect::<Result<_, _>>().unwrap()
}

/// A hundred instances, advanced in turn, are bitwise equal to instances that are advanced alone.
#[test]
fn instances_do_not_disturb_each_other() {
    let unit = five_bar("hundred");
    let version = Version::Three { events: false };
    let plants: Vec<Importer<'_>> = (0..100).map(|_| start(&unit, version)).collect();
    for k in 0..25 {
        for (kind, plant) in plants.iter().enumerate() {
            step(plant, k, kind as u32 % 5);
        }
    }
    let mut alone = Vec::new();
    for kind in 0..5 {
        let plant = start(&unit, version);
        (0..25).for_each(|k| step(&plant, k, kind));
        alone.push(bits(&plant));
    }
    for (kind, plant) in plants.iter().enumerate() {
        assert_eq!(bits(plant), alone[kind % 5], "instance {kind}");
    }
    assert_ne!(alone[0], alone[4]);
}

/// Restored states continue bitwise as the original does: saved or serialised, with changed
/// parameters, in another instance, and across stick and slip.
#[test]
fn states_continue_bit_for_bit() {
    let unit = five_bar("states");
    for version in [Version::Two, Version::Three { events: false }] {
        let plant = start(&unit, version);
        let change = |plant: &Importer<'_>| {
            plant.set("left_elbow.mu", 0.2);
            plant.set("tool.mass", 0.8);
        };
        (0..60).for_each(|k| step(&plant, k, 0));
        change(&plant);
        (60..80).for_each(|k| step(&plant, k, 0));
        // The saved state includes inputs that have not acted yet.
        plant.set("right_motor.effort", 0.5);
        let state = plant.get_state();
        let bytes = plant.serialize(state);
        (80..200).for_each(|k| step(&plant, k, 0));
        let end = bits(&plant);
        assert!(plant.integer("events.count") >= 3, "{}", plant.integer("events.count"));

        assert_eq!(plant.set_state(state), 0);
        (80..200).for_each(|k| step(&plant, k, 0));
        assert_eq!(bits(&plant), end);

        let other = Importer::new(&unit, version);
        let read = other.deserialize(&bytes).unwrap();
        assert_eq!(other.set_state(read), 0);
        assert_eq!(other.serialize(read), bytes);
        (80..200).for_each(|k| step(&other, k, 0));
        assert_eq!(bits(&other), end);
        other.free_state(read);
        plant.free_state(state);
    }
}

/// Parameters that are set before the start act as in a model with these values.
#[test]
fn parameters_are_those_of_the_model() {
    let robot = Robot::builtin("five-bar").unwrap();
    let heavy = robot.with("bodies.tool.mass = 0.9 kg").unwrap();
    let heavy = heavy.with("joints.left_elbow.friction.mu = 0.15").unwrap();
    let motion = |robot: &Robot, name: &str, changed: bool| {
        let unit = Extracted::new(name, &robot.export().plant().from("rest"));
        let plant = Importer::new(&unit, Version::Three { events: false });
        if changed {
            plant.set("tool.mass", 0.9);
            plant.set("left_elbow.mu", 0.15);
        }
        plant.set("start.left_motor.position", 2.2);
        plant.enter(0.0);
        assert_eq!(plant.exit(), 0, "{}", plant.said());
        (0..50).for_each(|k| {
            plant.step(PERIOD * f64::from(k), PERIOD);
        });
        (plant.get("tool.x"), plant.get("tool.vy"), plant.get("left_elbow.friction"))
    };
    let (changed, written) = (motion(&robot, "tuned", true), motion(&heavy, "written", false));
    assert_eq!(changed, written);
    assert_ne!(changed, motion(&robot, "usual", false));
}

/// Parameters that change while the plant runs act from that time on: without dry friction nothing
/// sticks, a new mass preserves velocities, and the energy balance continues.
#[test]
fn parameters_change_while_it_runs() {
    let unit = five_bar("running");
    let plant = start(&unit, Version::Three { events: false });
    let interfaces = ["left_motor", "right_motor", "left_elbow", "right_elbow", "tip"];
    let all = |ending: &str, value: f64| {
        interfaces.iter().for_each(|name| plant.set(&format!("{name}.{ending}"), value));
    };
    let sticking = || interfaces.map(|name| plant.integer(&format!("{name}.sticks")));
    let friction = || interfaces.map(|name| plant.get(&format!("{name}.friction")));
    // 10 N m in each motor hold all links.
    plant.set("left_motor.mu", 50.0);
    plant.set("right_motor.mu", 50.0);
    (0..5).for_each(|k| {
        plant.step(PERIOD * f64::from(k), PERIOD);
    });
    assert_eq!(sticking(), [1; 5]);
    all("mu", 0.0);
    all("viscous", 0.0);
    (5..40).for_each(|k| step(&plant, k, 0));
    assert_eq!((sticking(), friction()), ([0; 5], [0.0; 5]));
    let speed = plant.get("tool.vx");
    assert!(speed.abs() > 0.01, "{speed}");
    plant.set("tool.mass", 5.0);
    // In a step of a nanosecond velocities do not change.
    let time = PERIOD * 40.0;
    plant.step(time, 1e-9);
    assert!((plant.get("tool.vx") - speed).abs() < 1e-6 * speed.abs());
    all("mu", 0.1);
    plant.step(time + 1e-9, PERIOD - 1e-9);
    (41..80).for_each(|k| step(&plant, k, 0));
    assert!(friction().iter().all(|friction| friction.abs() > 0.01), "{:?}", friction());
    let (error, energy) = (plant.get("energy.error"), plant.get("energy.kinetic"));
    assert!(error.abs() < 1e-6 * (1.0 + energy), "{error} of {energy}");
    assert!(plant.get("energy.dissipated") > 0.0);
}
