//! Ranges of joints: violations along a motion, compared with closed forms.

use stiction::Robot;

/// The pendulum swings by 30 deg sin(2 pi t/2 s). Its range ends at 15 deg, so the pendulum leaves
/// the range at t = 1/6 s and returns at 5/6 s.
fn limited() -> Robot {
    super::pendulum().with("pivot.range = [\"-40 deg\", \"15 deg\"]").unwrap()
}

const MOTION: &str = "pivot = 30 deg*sin(2*pi*t/(2 s)); duration = 2 s";

#[test]
fn check_reports_violations() {
    let report = limited().check_along().motion(MOTION).unwrap().run().unwrap();
    let ranges = &report.to_json()["ranges"];
    let excursion = &ranges[0]["excursions"][0];
    // The cubic through samples 10 ms apart is wrong by h^4/384 times the fourth derivative.
    assert!((excursion["from"].as_f64().unwrap() - 1.0 / 6.0).abs() < 1e-8, "{excursion}");
    assert!((excursion["until"].as_f64().unwrap() - 5.0 / 6.0).abs() < 1e-8, "{excursion}");
    assert!((excursion["beyond"].as_f64().unwrap() - 15f64.to_radians()).abs() < 1e-12);
    let cautions = report.to_json()["cautions"].to_string();
    let expected =
        "pivot exceeds its range of -40.00 deg to 15.00 deg by 15.00 deg at t = 0.5000 s";
    assert!(cautions.contains(expected), "{cautions}");
}

#[test]
fn a_wide_range_is_kept() {
    let robot = super::pendulum().with("pivot.range = [\"-31 deg\", \"31 deg\"]").unwrap();
    let report = robot.check_along().motion(MOTION).unwrap().run().unwrap();
    assert_eq!(report.to_json()["cautions"].as_array().map(Vec::len), Some(0));
    assert_eq!(report.to_json()["ranges"][0]["count"], 0);
}

/// Tilts of a hexapod's ball joints agree with the angle between the z axes of the screw and of the
/// platform, which is level in the home position.
#[test]
fn the_tilt_of_a_ball_joint_is_that_of_the_leg() {
    let robot = Robot::builtin("gough").unwrap();
    let robot = robot.with("legs.S.range = { tilt = [\"0 deg\", \"1 deg\"] }").unwrap();
    let home = "platform.x = 0; platform.y = 0; platform.z = 900 mm; platform.rx = 0; platform.ry = 0; \
                platform.rz = 0; duration = 0 s";
    let report = robot.check_along().motion(home).unwrap().run().unwrap();
    let ranges = &report.to_json()["ranges"];
    // Foot and ball of leg 1, from the parameters of the model.
    let (base, platform, spread) = (0.7, 0.4, 12f64.to_radians());
    let ball = std::f64::consts::FRAC_PI_3 - spread;
    let (dx, dy): (f64, f64) =
        (platform * ball.cos() - base * spread.cos(), platform * ball.sin() - base * spread.sin());
    let expected = dx.hypot(dy).atan2(0.9);
    let found = ranges[0]["greatest"].as_f64().unwrap();
    assert_eq!(ranges[0]["name"], "leg1.S.tilt");
    assert!((found - expected).abs() < 1e-12, "{found} {expected}");
}
