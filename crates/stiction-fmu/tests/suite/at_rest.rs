//! A plant that stays at rest.

use stiction::Robot;

/// Each change of a parameter leads to a decision between stick and slip. These decisions occur at
/// different times, so their number is not limited, and none of them changes the integration
/// scheme.
#[test]
fn a_plant_at_rest_takes_any_number_of_changes() {
    let robot = ["left_motor", "right_motor"].iter().fold(
        Robot::builtin("five-bar").unwrap(),
        |robot, motor| {
            let friction = "{ mu = 0.5, radius = \"10 mm\", preload = \"4 kN\" }";
            robot.with(&format!("joints.{motor}.friction = {friction}")).unwrap()
        },
    );
    let mut plant = robot.forward().from("rest").unwrap().plant().unwrap();
    let start = plant.sample().unwrap().position("left_motor").unwrap();
    for step in 0..500_u32 {
        let side = if step % 2 == 0 { 1.0 } else { -1.0 };
        plant.set_effort("left_motor", 2.0 * side).unwrap();
        plant.set_parameter("left_motor.mu", 0.5 + 0.01 * side).unwrap();
        let events = plant.advance(1e-3 * f64::from(step + 1)).unwrap();
        assert!(events.is_empty(), "{step}: {events:?}");
        assert_eq!(plant.sample().unwrap().position("left_motor").unwrap(), start);
    }
}
