use super::pendulum;
use stiction::core::joint::JointType;
use stiction::{BodySpec, ErrorKind, JointSpec, Robot};

/// Message and suggestion of the error in a result.
fn told<T>(result: Result<T, stiction::Error>) -> String {
    let error = result.err().expect("an error");
    assert_eq!(error.kind(), ErrorKind::Input);
    error.to_string()
}

#[test]
fn unknown_names_are_answered_by_the_nearest() {
    let robot = pendulum();
    let sample = &robot.inverse().collect().unwrap()[0];
    assert_eq!(
        told(sample.effort("pivit")),
        "there is no actuator `pivit`\nhelp: did you mean `pivot`?"
    );
    assert_eq!(
        told(sample.reaction("shoulder")),
        "there is no joint `shoulder`\nhelp: known names: `pivot`"
    );
    assert!(told(robot.inverse().motion("swin")).contains("`swing`"));
    assert!(told(robot.forward().at("pivut", 1.0)).contains("`pivot`"));
    assert!(told(robot.forward().hold("pivut")).contains("`pivot`"));
    assert!(told(Robot::builtin("guogh")).contains("did you mean `gough`?"));
}

#[test]
fn defects_of_a_file_come_all_at_once_with_their_places() {
    let text = include_str!("../../examples/pendulum.toml");
    let wrong = text.replace("mass =", "masss =").replace("actuated", "actuatedd");
    let error = Robot::parse(&wrong).unwrap_err();
    assert_eq!(error.diagnostics().unwrap().len(), 2);
    let told = error.to_string();
    assert!(told.contains("model:5:1") && told.contains("did you mean `actuated`?"), "{told}");
    assert_eq!(error.to_json()["diagnostics"][0]["line"], 5);
}

#[test]
fn unreadable_files_are_reported() {
    assert_eq!(
        told(Robot::load("no/such.toml")),
        "cannot read the model no/such.toml: there is no such file\n\
         help: give a model file, or the name of a built-in model"
    );
    assert!(told(Robot::load("src")).contains("it is a folder"));
}

#[test]
fn contradictions_name_both_options() {
    let robot = pendulum();
    let both = robot.forward().hold("pivot").unwrap().prescribe("pivot");
    assert!(told(both).contains("either lock it or prescribe its motion (option `hold`)"));
    let driven = robot.forward().drives("pivot = 1 N m").unwrap().hold("pivot").unwrap().run();
    assert!(told(driven).contains("an effort is given for `pivot`, which is locked"));
    assert!(told(robot.forward().at("pivot", 1.0).unwrap().until(f64::NAN).run()).contains("NaN"));
    assert!(told(robot.forward().tolerance(1.0)).contains("between 1e-14 and 1e-2"));
}

#[test]
fn a_robot_without_a_motion_asks_for_one() {
    let robot = Robot::builder("bare")
        .body(BodySpec::new("bar").mass(1.0))
        .joint(JointSpec::new("hinge", JointType::Revolute, "ground", "bar").actuated())
        .build()
        .unwrap();
    assert!(told(robot.inverse().samples()).contains("no default motion"));
    let first = robot.inverse().motion("hinge = 0; duration = 0").unwrap().collect().unwrap();
    assert_eq!(first.len(), 1);
}
