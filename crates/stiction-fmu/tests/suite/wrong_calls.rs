//! Calls that are not possible return errors with messages, and do not change the instance.

use crate::importer::{ERROR, Extracted, Importer, Version};
use std::ptr::null_mut;
use stiction::Robot;
use stiction_fmu::{fmi2, fmi3};

#[test]
fn impossible_calls_are_errors_with_messages() {
    let robot = Robot::builtin("five-bar").unwrap();
    let unit = Extracted::new("wrong", &robot.export().plant().from("rest"));
    let effort = unit.reference("left_motor.effort");
    for version in [Version::Two, Version::Three { events: false }] {
        let plant = Importer::new(&unit, version);
        let refused = |status: i32, text: &str| {
            assert_eq!(status, ERROR, "{text}");
            let said = plant.said();
            assert!(said.starts_with("3 logStatusError: ") && said.contains(text), "{said}");
        };
        refused(plant.try_step(0.0, 1e-3).unwrap_err(), "in the state Instantiated");
        plant.enter(0.0);
        refused(plant.set_by(effort, f64::NAN), "`left_motor.effort` is NaN");
        refused(plant.set_by(effort, f64::INFINITY), "is inf");
        refused(plant.set_by(unit.count(), 1.0), "no variable with the value reference");
        refused(plant.get_by(unit.count()).unwrap_err(), "no variable with the value reference");
        refused(plant.set_by(unit.reference("left_motor.position"), 1.0), "is a result");
        refused(plant.get_by(unit.reference("events.count")).unwrap_err(), "is an integer");
        refused(plant.integer_by(effort).unwrap_err(), "is a real variable");
        refused(plant.set_by(unit.reference("tool.mass"), -1.0), "positive");
        refused(plant.set_by(unit.reference("left_elbow.mu"), -0.1), "zero or positive");
        assert_eq!(plant.exit(), 0, "{}", plant.said());
        let start = unit.reference("start.left_motor.position");
        refused(plant.set_by(start, 1.0), "only before the start");
        for (time, size, text) in [
            (0.0, 0.0, "the step is 0 s long"),
            (0.0, -1e-3, "the step is -0.001 s long"),
            (0.0, f64::NAN, "the step is NaN s long"),
            (f64::NAN, 1e-3, "begins at NaN s"),
            (0.5, 1e-3, "begins at 0.5 s, but the instance is at 0 s"),
        ] {
            refused(plant.try_step(time, size).unwrap_err(), text);
        }
        plant.step(0.0, 1e-3);
        refused(plant.try_step(0.0, 1e-3).unwrap_err(), "begins at 0 s");
        plant.step(1e-3, 1e-3);

        let state = plant.get_state();
        let mut bytes = plant.serialize(state);
        for cut in [0, 1, 30, bytes.len() - 1] {
            refused(plant.deserialize(&bytes[..cut]).unwrap_err(), "not a state of this model");
        }
        bytes[40] ^= 0xff;
        for place in [5, bytes.len() / 2] {
            bytes[place] ^= 0xff;
        }
        refused(plant.deserialize(&bytes).unwrap_err(), "not a state of this model");
        refused(plant.set_state(null_mut()), "the state is missing");
        plant.free_state(state);
        plant.step(2e-3, 1e-3);
    }
}

/// If one value of an array is impossible, no value of the array is set.
#[test]
fn arrays_are_set_as_a_whole() {
    let robot = Robot::builtin("five-bar").unwrap();
    let unit = Extracted::new("whole", &robot.export().plant().from("rest"));
    let plant = Importer::new(&unit, Version::Two);
    plant.enter(0.0);
    let names = ["left_motor.effort", "start.left_motor.position", "tool.mass"];
    let references = names.map(|name| unit.reference(name));
    let read = || references.map(|reference| plant.get_by(reference).unwrap());
    let before = read();
    let set = |values: [f64; 3]| unsafe {
        fmi2::fmi2SetReal(plant.handle, references.as_ptr(), 3, values.as_ptr())
    };
    assert_eq!(set([1.0, before[1] + 0.1, -1.0]), ERROR);
    assert_eq!(read(), before);
    let possible = [1.0, before[1] + 0.1, 0.7];
    assert_eq!(set(possible), 0, "{}", plant.said());
    assert_eq!(read(), possible);
}

#[test]
fn arrays_and_handles_may_be_missing() {
    let robot = Robot::builtin("five-bar").unwrap();
    let unit = Extracted::new("missing", &robot.export().plant().from("rest"));
    let plant = Importer::new(&unit, Version::Two);
    unsafe {
        assert_eq!(fmi2::fmi2GetReal(plant.handle, std::ptr::null(), 2, null_mut()), ERROR);
        assert!(plant.said().contains("the pointer is null"), "{}", plant.said());
        assert_eq!(fmi2::fmi2GetReal(plant.handle, std::ptr::null(), 0, null_mut()), 0);
        assert_eq!(fmi2::fmi2DoStep(null_mut(), 0.0, 1.0, 0), ERROR);
        assert_eq!(fmi3::fmi3Terminate(null_mut()), ERROR);
        fmi2::fmi2FreeInstance(null_mut());
        let references = [0, 1];
        let mut values = [0.0];
        let (first, place) = (references.as_ptr(), values.as_mut_ptr());
        assert_eq!(fmi3::fmi3GetFloat64(plant.handle, first, 2, place, 1), ERROR);
        assert!(plant.said().contains("2 value references, but 1 values"), "{}", plant.said());
    }
    let other = Importer::with_token(&unit, Version::Two, c"{another}");
    assert!(other.handle.is_null() && other.said().contains("export the FMU again"));
    // No message, no crash.
    unsafe {
        let made = fmi3::fmi3InstantiateCoSimulation(
            std::ptr::null(),
            std::ptr::null(),
            std::ptr::null(),
            false,
            false,
            false,
            false,
            std::ptr::null(),
            0,
            null_mut(),
            None,
            std::ptr::null(),
        );
        assert!(made.is_null());
    }
}

/// A mechanism that cannot continue: the step returns an error, and the instance does not advance.
#[test]
fn a_step_without_an_answer_is_an_error() {
    let robot = Robot::builtin("3rps").unwrap();
    let unit = Extracted::new("far", &robot.export().plant().from("rest"));
    let plant = Importer::new(&unit, Version::Three { events: false });
    let usual = plant.get("start.leg1.P.position");
    // One leg is far longer than the others.
    plant.set("start.leg1.P.position", 10.0);
    plant.enter(0.0);
    assert_eq!(plant.exit(), ERROR);
    assert!(plant.said().contains("logStatusError"), "{}", plant.said());
    plant.set("start.leg1.P.position", usual);
    assert_eq!(plant.exit(), 0, "{}", plant.said());
    plant.step(0.0, 1e-3);
    plant.set("leg1.P.effort", 1e300);
    let before = plant.get("leg1.P.position");
    assert_eq!(plant.try_step(1e-3, 1e-3), Err(ERROR));
    assert!(plant.said().contains("logStatusError"), "{}", plant.said());
    assert_eq!(plant.get("leg1.P.position"), before);
    plant.set("leg1.P.effort", 0.0);
    plant.step(1e-3, 1e-3);
}
