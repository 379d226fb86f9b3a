//! Files of other authors, compared with results of other programs. The files are not part of the
//! project: if they are absent, the tests report this and pass.

use super::tree::{Tree, mobility, model};
use nalgebra::DMatrix;
use serde_json::Value;
use std::path::PathBuf;
use stiction_core::spatial::{Pose, Vec3};
use stiction_format::{ImportOptions, Imported, ModelFile, Source, import};

fn folder(name: &str) -> Option<PathBuf> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models").join(name);
    // In a worktree, the folder is one level higher.
    let deeper =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../../shared/models").join(name);
    let found = [root, deeper].into_iter().find(|folder| folder.exists());
    if found.is_none() {
        println!("skipped: there is no folder ../shared/models/{name}");
    }
    found
}

struct Case {
    imported: Imported,
    model: ModelFile,
    truth: Value,
}

fn case(name: &str, file: &str, truth: &str) -> Option<Case> {
    let folder = folder(name)?;
    let text = std::fs::read_to_string(folder.join(file)).unwrap();
    let load = |name: &str| std::fs::read(folder.join(name)).map_err(|error| error.to_string());
    let imported = import(&Source::new(file, text), ImportOptions::default(), &load)
        .unwrap_or_else(|errors| panic!("{errors}"));
    let truth = std::fs::read_to_string(folder.join(truth)).unwrap();
    let model = model(&imported);
    Some(Case { imported, model, truth: serde_json::from_str(&truth).unwrap() })
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn vector(value: &Value) -> Vec3<f64> {
    let numbers = numbers(value);
    Vec3::new(numbers[0], numbers[1], numbers[2])
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().unwrap().iter().map(numbers).collect();
    DMatrix::from_fn(rows.len(), rows.len(), |i, j| rows[i][j])
}

/// Fails unless all entries agree to `tolerance` of the largest.
fn same(found: &DMatrix<f64>, expected: &DMatrix<f64>, tolerance: f64) {
    let error = (found - expected).amax() / expected.amax();
    assert!(error < tolerance, "relative error {error:e}\n{found}\n{expected}");
}

fn total_mass(model: &ModelFile) -> f64 {
    model.mechanism.bodies().iter().map(|body| body.mass).sum()
}

fn pose_of<'a>(model: &ModelFile, tree: &'a Tree, name: &str) -> &'a Pose<f64> {
    let bodies = model.mechanism.bodies();
    &tree.poses[bodies.iter().position(|body| body.name == name).unwrap()]
}

fn joint<'a>(model: &'a ModelFile, name: &str) -> &'a stiction_core::mechanism::Joint {
    model.mechanism.joints().iter().find(|joint| joint.name == name).unwrap()
}

/// A URDF with its YAML file, compared with Pinocchio.
#[test]
fn five_bar_agrees_with_pinocchio() {
    let found = case("gepetto_5bar_linkage", "robot.urdf", "truth_pinocchio.json");
    let Some(Case { imported, model, truth }) = found else { return };
    let mass = truth["total_mass"].as_f64().unwrap();
    assert!((total_mass(&model) - mass).abs() < 1e-9 * mass);
    let names: Vec<&str> = truth["joint_names"]
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap())
        .collect();
    let q = numbers(&truth["q_assembled"]);
    let tree = Tree::new(&model.mechanism, &names, &q);
    same(&tree.mass_matrix(&model.mechanism), &matrix(&truth["mass_matrix"]), 1e-9);
    // Frames of joints are those of their children.
    for name in &names {
        let child = joint(&model, name).successor.0;
        let (found, expected) = (tree.poses[child], &truth["joint_poses"][name]);
        assert!((found.position + -vector(&expected["position"])).norm() < 1e-9, "{name}");
        let rotation = matrix(&expected["rotation"]);
        let error =
            (0..9).map(|k| (found.rotation.at(k / 3, k % 3) - rotation[(k / 3, k % 3)]).abs());
        assert!(error.fold(0.0, f64::max) < 1e-9, "{name}");
    }
    // The closing frames coincide there.
    let closure = joint(&model, "closedloop1");
    let frame = |body: usize, frame: Pose<f64>| tree.poses[body] * frame;
    let between = frame(closure.predecessor.0, closure.frame_j).inverse()
        * frame(closure.successor.0, closure.frame_k);
    assert!(between.position.norm() < 1e-9 && between.rotation.rotation_vector().norm() < 1e-9);
    assert_eq!(mobility(&model), truth["mobility"].as_u64().unwrap() as usize);
    assert_eq!(model.mechanism.actuators().count(), 2);
    // With the motors locked, one local (passive) degree of freedom remains, which needs no
    // coordinate.
    assert_eq!(model.motion("hold").unwrap().coordinates.len(), 2);
    let notes: Vec<String> = imported.notes.iter().map(|note| note.line()).collect();
    assert!(notes.iter().any(|note| note.contains("a unit error")), "{notes:#?}");
}

/// An MJCF with nested classes, closures and missing meshes, compared with MuJoCo.
#[test]
fn gripper_agrees_with_mujoco() {
    let found = case("menagerie_robotiq_2f85", "2f85.xml", "truth_mujoco.json");
    let Some(Case { imported, model, truth }) = found else { return };
    let mass = truth["total_mass"].as_f64().unwrap();
    assert!((total_mass(&model) - mass).abs() < 1e-9 * mass);
    let joints = truth["joints"].as_array().unwrap();
    let names: Vec<&str> = joints.iter().map(|joint| joint["name"].as_str().unwrap()).collect();
    let q = numbers(&truth["qpos_assembled"]);
    let tree = Tree::new(&model.mechanism, &names, &q);
    let mut expected = matrix(&truth["mass_matrix_with_armature"]);
    for (k, joint) in joints.iter().enumerate() {
        expected[(k, k)] -= joint["armature"].as_f64().unwrap();
    }
    // The tolerance is relative to the matrix with armature, because the matrix is a small
    // difference.
    let with = matrix(&truth["mass_matrix_with_armature"]).amax();
    let error = (tree.mass_matrix(&model.mechanism) - &expected).amax() / with;
    assert!(error < 1e-9, "{error:e}");
    for (name, body) in truth["bodies"].as_object().unwrap() {
        let (pose, index) = (pose_of(&model, &tree, name), model.mechanism.bodies().iter());
        let content = index.clone().find(|body| body.name == *name).unwrap();
        assert!((content.mass - body["mass"].as_f64().unwrap()).abs() < 1e-12, "{name}");
        assert!((pose.position + -vector(&body["position"])).norm() < 1e-9, "{name}");
        if content.mass > 0.0 {
            assert!((pose.apply(content.com) + -vector(&body["com"])).norm() < 1e-9, "{name}");
        }
        let q = numbers(&body["quaternion_wxyz"]);
        let expected = stiction_core::spatial::Quaternion::from_coordinates(&q).rotation();
        let error = (pose.rotation.transpose() * expected).rotation_vector().norm();
        assert!(error < 1e-9, "{name}");
    }
    for joint in joints {
        let own = self::joint(&model, joint["name"].as_str().unwrap());
        let frame = tree.poses[own.predecessor.0] * own.frame_j;
        assert!((frame.rotation.columns[2] + -vector(&joint["axis"])).norm() < 1e-9);
        assert!((frame.position + -vector(&joint["anchor"])).norm() < 1e-9);
    }
    // Springs of the passive joints: the effort at rest agrees with MuJoCo.
    let efforts = numbers(&truth["passive_force_at_rest"]);
    let springs = model.mechanism.joint_springs();
    assert_eq!(springs.len(), efforts.iter().filter(|effort| **effort != 0.0).count());
    for spring in springs {
        let name = &model.mechanism.joints()[spring.joint.0].name;
        let index = names.iter().position(|known| known == name).unwrap();
        assert!((spring.stiffness * spring.rest - efforts[index]).abs() < 1e-12, "{name}");
    }
    // The robot has two hinges, a gearing, and a motor of both driving joints, which the gearing
    // couples.
    assert_eq!(mobility(&model), truth["mobility"].as_u64().unwrap() as usize);
    let [gearing] = model.mechanism.gearings() else { panic!("one gearing") };
    assert_eq!((gearing.dofs.len(), gearing.offset), (2, 0.0));
    let [train] = model.mechanism.drive_trains() else { panic!("one motor") };
    assert_eq!((train.transmission(), train.limits.peak), (1.0, Some(5.0)));
    let notes: Vec<String> = imported.notes.iter().map(|note| note.line()).collect();
    for name in truth["bodies_whose_mass_came_from_meshes"].as_array().unwrap() {
        let name = name.as_str().unwrap();
        assert!(
            notes.iter().any(|note| note.contains(&format!("`{name}`"))),
            "{name} in {notes:#?}"
        );
    }
}

/// An SDF with a loop, compared with a solution by hand.
#[test]
fn four_bar_agrees_with_the_loop_by_hand() {
    let found = case("own_four_bar_sdf", "model.sdf", "truth.json");
    let Some(Case { model, truth, .. }) = found else { return };
    let tree = Tree::new(&model.mechanism, &["drive", "knee", "pivot"], &[0.0; 3]);
    assert!((total_mass(&model) - truth["total_mass"].as_f64().unwrap()).abs() < 1e-15);
    for (name, point) in truth["joint_points_world"].as_object().unwrap() {
        let own = joint(&model, name);
        let ends = [(own.predecessor.0, own.frame_j), (own.successor.0, own.frame_k)];
        for (body, frame) in ends {
            let frame = tree.poses[body] * frame;
            assert!((frame.position + -vector(point)).norm() < 1e-12, "{name}");
            let axis = vector(&truth["axis_in_world"]);
            assert!((frame.rotation.columns[2] + -axis).norm() < 1e-12, "{name}");
        }
    }
    for (name, com) in truth["coms_world"].as_object().unwrap() {
        let content = model.mechanism.bodies().iter().find(|body| body.name == *name).unwrap();
        let found = pose_of(&model, &tree, name).apply(content.com);
        assert!((found + -vector(com)).norm() < 1e-12, "{name}");
    }
    assert_eq!(mobility(&model), 1);
    assert_eq!(model.mechanism.gravity(), vector(&truth["gravity"]));
    let train = &model.mechanism.drive_trains()[0];
    assert_eq!(train.motor_friction.constant, 0.05);
}
