//! `bodies.csv`, read as another program would read it: positions, velocities and accelerations are
//! consistent, and together with the reactions they satisfy the equations of motion of every body.

use crate::common::{Csv, default_job, files, job, model, model_of, regular, tables};
use stiction_core::dynamics::FrictionMode;
use stiction_core::mechanism::{BodyId, Mechanism};
use stiction_core::spatial::{Mat3, Pose, Quaternion, Vec3};
use stiction_format::gallery;
use stiction_run::{Job, Sink};

/// Returns `bodies.csv` and `reactions.csv` of a run.
fn bodies_and_reactions(job: &Job<'_>) -> (Csv, Csv) {
    let mut tables = tables(job);
    job.run(|sample| tables.add(sample), |_, _, _| true).unwrap();
    let files = files(job, tables);
    (Csv::parse(&files["bodies.csv"]), Csv::parse(&files["reactions.csv"]))
}

fn vector(csv: &Csv, of: &str, columns: [&str; 3], row: usize) -> Vec3<f64> {
    Vec3::from(columns.map(|column| csv.column(&format!("{of}.{column}"))[row]))
}

const POSITION: [&str; 3] = ["x [m]", "y [m]", "z [m]"];
const ANGULAR: [&str; 3] = ["wx [rad/s]", "wy [rad/s]", "wz [rad/s]"];
const LINEAR: [&str; 3] = ["vx [m/s]", "vy [m/s]", "vz [m/s]"];
const ANGULAR_CHANGE: [&str; 3] = ["alphax [rad/s^2]", "alphay [rad/s^2]", "alphaz [rad/s^2]"];
const ACCELERATION: [&str; 3] = ["ax [m/s^2]", "ay [m/s^2]", "az [m/s^2]"];
const FORCE: [&str; 3] = ["fx [N]", "fy [N]", "fz [N]"];
const MOMENT: [&str; 3] = ["mx [N m]", "my [N m]", "mz [N m]"];

fn quaternion(csv: &Csv, of: &str, row: usize) -> [f64; 4] {
    ["qw [-]", "qx [-]", "qy [-]", "qz [-]"]
        .map(|column| csv.column(&format!("{of}.{column}"))[row])
}

fn pose(csv: &Csv, of: &str, row: usize) -> Pose<f64> {
    let rotation = Quaternion::from_coordinates(&quaternion(csv, of, row)).rotation();
    Pose { rotation, position: vector(csv, of, POSITION, row) }
}

/// Returns the largest errors of twists relative to differences of poses, and of accelerations
/// relative to differences of twists, over all bodies, at every multiple of 0.05 s inside the
/// motion.
fn errors_of_differences(name: &str, step: f64) -> [f64; 4] {
    let model = model(name);
    let job = Job { step: Some(step), ..default_job(&model, FrictionMode::Off) };
    let (csv, _) = bodies_and_reactions(&job);
    let times = csv.column("time [s]");
    let every = (0.05 / step).round() as usize;
    let mut errors = [0.0_f64; 4];
    for row in (every..times.len() - every).step_by(every) {
        for body in &model.mechanism.bodies()[1..] {
            let of = body.name.as_str();
            let over = 0.5 / step;
            let (behind, ahead) = (pose(&csv, of, row - 1), pose(&csv, of, row + 1));
            let turn = (ahead.rotation * behind.rotation.transpose()).rotation_vector();
            let difference = |columns| {
                (vector(&csv, of, columns, row + 1) - vector(&csv, of, columns, row - 1)) * over
            };
            let pairs = [
                (vector(&csv, of, ANGULAR, row), turn * over),
                (vector(&csv, of, LINEAR, row), difference(POSITION)),
                (vector(&csv, of, ANGULAR_CHANGE, row), difference(ANGULAR)),
                (vector(&csv, of, ACCELERATION, row), difference(LINEAR)),
            ];
            for (error, (given, found)) in errors.iter_mut().zip(pairs) {
                *error = error.max((given - found).norm());
            }
        }
    }
    errors
}

/// Tests twists and accelerations against central differences. The error of a central difference is
/// its squared step times a third derivative: half of the step leaves a quarter of the error. The
/// error of a wrong derivative would not decrease.
#[test]
fn twists_and_accelerations_are_derivatives() {
    for name in ["3rps", "gough"] {
        let (coarse, fine) =
            (errors_of_differences(name, 0.005), errors_of_differences(name, 0.0025));
        for (coarse, fine) in coarse.into_iter().zip(fine) {
            // Fourth-order terms change the ratio by about (2 pi 2/s 0.005 s)^2 = 0.4 %.
            let ratio = coarse / fine;
            assert!((ratio - 4.0).abs() < 0.1, "{name}: {coarse} {fine}");
            assert!(fine > 1e-9, "{name}: rounding would say nothing: {fine}");
        }
    }
}

/// Tests that quaternions have no jumps. Beyond half a turn, a continuous quaternion has the
/// opposite sign of the quaternion computed from the rotation matrix.
#[test]
fn quaternions_are_unit_and_continuous() {
    for name in ["four-bar", "gough"] {
        let model = model(name);
        let (csv, _) = bodies_and_reactions(&default_job(&model, FrictionMode::Off));
        let mut passed = false;
        for body in &model.mechanism.bodies()[1..] {
            let mut last = quaternion(&csv, &body.name, 0);
            assert!(last[0] >= 0.0);
            for row in 0..csv.column("time [s]").len() {
                let next = quaternion(&csv, &body.name, row);
                let square = |q: [f64; 4]| q.iter().map(|x| x * x).sum::<f64>();
                assert!((square(next) - 1.0).abs() < 1e-15);
                let change = std::array::from_fn(|k| next[k] - last[k]);
                // The crank turns by a hundredth of a turn per sample; no body turns by more than
                // 0.5 rad.
                assert!(square(change).sqrt() < 0.25, "{name}: {} at row {row}", body.name);
                passed |= next[0] < -0.5;
                last = next;
            }
        }
        assert_eq!(passed, name == "four-bar", "its crank turns all the way");
    }
}

/// Tests a load that rotates with its body and acts at a lever arm.
#[test]
fn loads_refer_to_the_origin_in_world_axes() {
    let text = gallery::get("3rps").unwrap().to_owned()
        + "\n[loads.turning]\n\
           platform = { force = [\"10 N + 5 N/s*t\", 20, -30], moment = [1, -2, 3], \
           at = [0.1, 0.2, -0.3], axes = \"body\" }\n\
           \"leg1.rod\" = { force = [7, 0, 0], at = [0, 0, 0.5] }\n";
    let model = model_of("3rps", &text);
    let (csv, _) = bodies_and_reactions(&job(&model, "reference", "turning", FrictionMode::Off));
    let times = csv.column("time [s]");
    for (row, &time) in times.iter().enumerate() {
        let rotation = pose(&csv, "platform", row).rotation;
        let force = Vec3::new(10.0 + 5.0 * time, 20.0, -30.0);
        let moment = Vec3::new(1.0, -2.0, 3.0) + Vec3::new(0.1, 0.2, -0.3).cross(force);
        let arm = pose(&csv, "leg1.rod", row).rotation.columns[2] * 0.5;
        let push = Vec3::new(7.0, 0.0, 0.0);
        let loads = [
            ("platform", rotation * force, rotation * moment),
            ("leg1.rod", push, arm.cross(push)),
            ("leg2.rod", Vec3::zero(), Vec3::zero()),
        ];
        for (of, force, moment) in loads {
            // Rounding relative to about 40 N and N m.
            assert!((vector(&csv, of, FORCE, row) - force).norm() < 1e-13);
            assert!((vector(&csv, of, MOMENT, row) - moment).norm() < 1e-13);
        }
    }
    assert!(times.len() > 50);
}

/// Returns the forces of the springs on their bodies in a row, with their points of application.
fn pulls(mechanism: &Mechanism, csv: &Csv, row: usize) -> Vec<(BodyId, Vec3<f64>, Vec3<f64>)> {
    let mut all = Vec::new();
    for spring in mechanism.springs() {
        let ends = [0, 1].map(|end| {
            let of = mechanism.bodies()[spring.ends[end].0].name.as_str();
            let frame = pose_of(mechanism, csv, spring.ends[end], row);
            let at = frame.apply(spring.points[end]);
            let velocity = match spring.ends[end] {
                BodyId::GROUND => Vec3::zero(),
                _ => {
                    let turning = vector(csv, of, ANGULAR, row);
                    vector(csv, of, LINEAR, row) + turning.cross(at - frame.position)
                }
            };
            (at, velocity)
        });
        let across = ends[1].0 - ends[0].0;
        let along = across * (1.0 / across.norm());
        let rate = along.dot(ends[1].1 - ends[0].1);
        let stretch = across.norm() - spring.free_length;
        let pull = along * (spring.stiffness * stretch + spring.damping * rate);
        all.push((spring.ends[0], ends[0].0, pull));
        all.push((spring.ends[1], ends[1].0, -pull));
    }
    all
}

fn pose_of(mechanism: &Mechanism, csv: &Csv, body: BodyId, row: usize) -> Pose<f64> {
    match body {
        BodyId::GROUND => mechanism.base(),
        BodyId(index) => pose(csv, &mechanism.bodies()[index].name, row),
    }
}

/// Tests the Newton-Euler equations of every body with numbers from the tables alone: reactions,
/// loads, weight and springs equal mass times acceleration.
#[test]
fn the_tables_balance_every_body() {
    for name in regular() {
        let model = model(name);
        let mechanism = &model.mechanism;
        let job = Job { step: Some(0.05), ..default_job(&model, FrictionMode::Converged) };
        let (csv, reactions) = bodies_and_reactions(&job);
        for row in 0..csv.column("time [s]").len() {
            let springs = pulls(mechanism, &csv, row);
            let mut largest = 0.0_f64;
            let mut worst = 0.0_f64;
            for (index, body) in mechanism.bodies().iter().enumerate().skip(1) {
                let of = body.name.as_str();
                let at = vector(&csv, of, POSITION, row);
                let (mut force, mut moment) =
                    (vector(&csv, of, FORCE, row), vector(&csv, of, MOMENT, row));
                let mut add = |point: Vec3<f64>, push: Vec3<f64>, couple: Vec3<f64>| {
                    force += push;
                    moment += couple + (point - at).cross(push);
                    largest = largest.max(push.norm());
                };
                for joint in mechanism.joints() {
                    let sign = match index {
                        _ if joint.successor.0 == index => 1.0,
                        _ if joint.predecessor.0 == index => -1.0,
                        _ => continue,
                    };
                    let j = pose_of(mechanism, &csv, joint.predecessor, row) * joint.frame_j;
                    let push = vector(&reactions, &joint.name, FORCE, row) * sign;
                    add(j.position, push, vector(&reactions, &joint.name, MOMENT, row) * sign);
                }
                for &(_, point, pull) in springs.iter().filter(|(on, _, _)| on.0 == index) {
                    add(point, pull, Vec3::zero());
                }
                let rotation = pose(&csv, of, row).rotation;
                let (w, alpha) =
                    (vector(&csv, of, ANGULAR, row), vector(&csv, of, ANGULAR_CHANGE, row));
                let arm = rotation * body.com;
                add(at + arm, mechanism.gravity() * body.mass, Vec3::zero());
                let of_com =
                    vector(&csv, of, ACCELERATION, row) + alpha.cross(arm) + w.cross(w.cross(arm));
                let inertia: Mat3<f64> = rotation * body.inertia * rotation.transpose();
                let change = inertia * alpha + w.cross(inertia * w);
                add(at + arm, of_com * -body.mass, -change);
                let length = mechanism.characteristic_length();
                worst = worst.max(force.norm()).max(moment.norm() / length);
            }
            // Rounding of the largest force, and of the corresponding solution.
            assert!(worst <= 1e-9 * largest, "{name}, row {row}: {worst} of {largest}");
        }
    }
}
