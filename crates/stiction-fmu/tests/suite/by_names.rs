//! The plant of the library, used by names instead of value references.

use stiction::Robot;

#[test]
fn a_plant_is_advanced_by_names() {
    let robot = Robot::builtin("five-bar").unwrap();
    let mut plant = robot.forward().from("rest").unwrap().plant().unwrap();
    let mut begins = Vec::new();
    for step in 1..=100 {
        let until = 0.001 * f64::from(step);
        let angle = plant.sample().unwrap().position("left_motor").unwrap();
        plant.set_effort("left_motor", -5.0 * (angle - 2.0)).unwrap();
        while plant.time() < until {
            let events = plant.advance_to_event(until).unwrap();
            begins.extend(events.into_iter().map(|event| (event.time, event.at, plant.time())));
        }
    }
    assert!((plant.time() - 0.1).abs() < 1e-12);
    assert!(!begins.is_empty());
    for (time, at, end) in &begins {
        assert!(time <= end && !at.is_empty(), "{begins:?}");
    }
    let copy = plant.clone();
    let falls = |mut plant: stiction::Plant, force: f64| {
        plant.set_force("tool", [0.0, force, 0.0], [0.0; 3]).unwrap();
        plant.advance(0.12).unwrap();
        plant.sample().unwrap().velocity("tool").unwrap().linear[1]
    };
    assert!(falls(copy.clone(), 50.0) > falls(copy, 0.0) + 0.1);

    let mass = plant.parameters().find(|(name, _)| *name == "tool.mass").unwrap().1;
    assert_eq!(mass, 0.5);
    for wrong in [
        plant.set_effort("left_moter", 1.0),
        plant.set_effort("left_motor", f64::NAN),
        plant.set_force("tol", [0.0; 3], [0.0; 3]),
        plant.set_force("tool", [f64::INFINITY, 0.0, 0.0], [0.0; 3]),
        plant.set_parameter("tool.mas", 1.0),
        plant.set_parameter("tool.mass", 0.0),
        plant.advance(f64::NAN).map(|_| ()),
    ] {
        assert!(wrong.is_err());
    }
    let forward = || robot.forward();
    for unfit in [
        forward().drives("none"),
        forward().controller("pd"),
        forward().hold("left_motor"),
        forward().stop("tool.x > 1 m"),
    ] {
        let error = unfit.unwrap().plant().err().unwrap();
        assert!(error.to_string().contains("cannot be part of a plant"), "{error}");
    }
    assert!(forward().controller("none").unwrap().plant().is_ok());
}
