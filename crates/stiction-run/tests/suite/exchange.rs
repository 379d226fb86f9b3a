//! Exported mechanisms, read back as another program would read them.

use crate::common::{default_job, model};
use serde_json::Value;
use stiction_core::dynamics::FrictionMode;
use stiction_core::joint::JointType;
use stiction_core::spatial::{Mat3, Pose, Vec3};
use stiction_format::{ModelFile, gallery};
use stiction_run::exchange::{Home, json, json_text};

/// Assembles a model at the start of its default motion.
fn home(model: &ModelFile) -> Home<'_> {
    Home::of(&default_job(model, FrictionMode::Off)).unwrap()
}

fn vector(value: &Value) -> Vec3<f64> {
    Vec3::from(std::array::from_fn(|k| value[k].as_f64().unwrap()))
}

/// Reads a matrix from its rows.
fn matrix(value: &Value) -> Mat3<f64> {
    let row = |i: usize| vector(&value[i]);
    Mat3::from_columns(row(0), row(1), row(2)).transpose()
}

fn pose(value: &Value) -> Pose<f64> {
    Pose { position: vector(&value["position"]), rotation: matrix(&value["rotation"]) }
}

/// Returns the distance between two poses, m and rad.
fn apart(a: Pose<f64>, b: Pose<f64>) -> f64 {
    let turn = (a.rotation.transpose() * b.rotation).rotation_vector();
    (a.position - b.position).norm() + turn.norm()
}

/// Tests that the numbers of the description alone close every loop: the frames of each joint match
/// its coordinates.
#[test]
fn a_description_is_an_assembled_mechanism() {
    for name in gallery::names() {
        let model = model(name);
        let home = home(&model);
        let text = json_text(&home);
        let read: Value = serde_json::from_str(&text).unwrap();
        // The layout affects only white space. Texts are compared, because parsing would round
        // numbers.
        let bare = |text: &str| text.split_whitespace().collect::<String>();
        assert!(bare(&text) == bare(&json(&home).to_string()), "{name}");
        assert_eq!((&read["format"], &read["version"]), (&"stiction-mechanism".into(), &1.into()));

        let bodies = read["bodies"].as_array().unwrap();
        let frame = |body: &Value| {
            let found = bodies.iter().find(|known| known["name"] == *body).unwrap();
            pose(&found["home"])
        };
        assert_eq!(bodies[0]["name"], "ground");
        assert_eq!(frame(&"ground".into()), pose(&read["base"]));
        let joints = read["joints"].as_array().unwrap();
        assert_eq!(joints.len(), model.mechanism.joints().len());
        for joint in joints {
            let joint_type = JointType::from_symbol(joint["type"].as_str().unwrap()).unwrap();
            let j = frame(&joint["from"]) * pose(&joint["frame_from"]);
            let k = frame(&joint["to"]) * pose(&joint["frame_to"]);
            let dofs = joint["dofs"].as_array().unwrap();
            let coordinates: Vec<Option<f64>> =
                dofs.iter().map(|dof| dof["coordinate"].as_f64()).collect();
            // Loops are closed to 1e-12 m.
            if joint_type.has_scalar_coordinates() {
                let coordinates: Vec<f64> = coordinates.into_iter().map(Option::unwrap).collect();
                let across = joint_type.pose(&coordinates, joint["pitch"].as_f64().unwrap());
                assert!(apart(j * across, k) < 4e-12, "{name}: {}", joint["name"]);
            } else {
                assert_eq!(joint_type, JointType::Spherical);
                assert!(coordinates.iter().all(Option::is_none));
                assert!((j.position - k.position).norm() < 4e-12, "{name}: {}", joint["name"]);
            }
        }
        let frictions = joints.iter().map(|joint| joint["friction"].as_array().unwrap().len());
        let interfaces = model.mechanism.joints().iter().map(|joint| joint.friction.len());
        assert_eq!(frictions.sum::<usize>(), interfaces.sum::<usize>());
    }
}

/// Tests that the numbers of the description are those of the model.
#[test]
fn a_description_has_the_numbers_of_the_model() {
    let model = model("andrews");
    let read = json(&home(&model));
    let spring = &read["springs"][0];
    let known = &model.mechanism.springs()[0];
    assert_eq!(spring["stiffness"], 4530.0);
    assert_eq!(vector(&spring["point_from"]), known.points[0]);
    let crank = &read["joints"][0];
    assert_eq!(crank["dofs"][0]["actuated"], true);
    // The initial angle of the benchmark.
    let angle = crank["dofs"][0]["coordinate"].as_f64().unwrap();
    assert!((angle + 0.061_713_890_014_276_4).abs() < 1e-15, "{angle}");
    let body = &read["bodies"][1];
    assert_eq!((&body["name"], &body["mass"]), (&"K1".into(), &0.04325.into()));
    assert_eq!(body["inertia"][2][2], 2.194e-6);
}
