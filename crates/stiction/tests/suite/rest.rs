use super::{FRICTION_ARM, GRAVITY, LENGTH, MASS, pendulum};
use stiction::Robot;

#[test]
fn the_interval_at_rest_is_weight_more_or_less_friction() {
    let robot = pendulum();
    let rest = robot.breakaway().motion("pivot = 0.3; duration = 0").unwrap().run().unwrap();
    let (low, high) = rest.effort_bounds("pivot").unwrap();
    // The normal load hardly depends on the effort; it equals the weight.
    let (moment, friction) =
        (MASS * GRAVITY * LENGTH * 0.3f64.sin(), FRICTION_ARM * MASS * GRAVITY);
    assert!(
        (low - (moment - friction)).abs() < 1e-12 && (high - (moment + friction)).abs() < 1e-12
    );
    assert!(rest.to_string().contains("pivot") && rest.to_json().is_object());
}

#[test]
fn mobility_of_a_planar_four_bar_is_counted_in_three_ways() {
    let report = Robot::builtin("four-bar").unwrap().check().unwrap();
    let mobility = report.mobility();
    assert_eq!((mobility.gruebler, mobility.instantaneous, mobility.finite), (-2, 1, Some(1)));
    assert_eq!(report.redundant_constraints(), 3);
    assert!(!report.undetermined_reactions().is_empty());
    assert!(report.actuation_singularity().index > 0.0 && !report.actuation_singularity().is_met);
    assert!(report.leg_singularity().is_none());
    assert!(report.to_string().starts_with("four-bar"));
}

/// Results along the motion equal those at single instants.
#[test]
fn static_friction_along_a_motion() {
    let robot = Robot::builtin("five-bar").unwrap();
    let along = robot.breakaway().step(0.2).collect().unwrap();
    assert!(along.len() > 2);
    for rest in &along {
        let alone = robot.breakaway().at(rest.time()).run().unwrap();
        for actuator in robot.actuators() {
            let [a, b] = [rest, &alone].map(|rest| rest.effort_bounds(actuator).unwrap());
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(1.0);
            // Positions that are reached in different steps differ by rounding.
            assert!(near(a.0, b.0) && near(a.1, b.1), "{actuator}: {a:?} {b:?}");
        }
    }
}
