//! Mechanisms and motions of the tests.

use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{BodySpec, DriveTrainSpec, JointSpec, Mechanism, MechanismBuilder};
use stiction_core::random::Random;
use stiction_core::{JointType, Mat3, Pose, Vec3};
use stiction_format::{ModelFile, Source, gallery, read};
use stiction_identify::{Choice, Columns, Regressor};

pub(crate) fn gallery_model(name: &str) -> ModelFile {
    let text = gallery::get(name).unwrap();
    read(&Source::new(format!("{name}.toml"), text), &|_| Err("no files".into())).unwrap()
}

/// A serial chain of revolute joints by standard DH parameters (d, a, alpha), all joints actuated, with
/// general bodies.
pub(crate) fn serial(rows: &[(f64, f64, f64)], gravity: Vec3<f64>) -> Mechanism {
    serial_builder(rows, gravity).build().unwrap()
}

/// Serial chain as in [`serial`], with a motor at each joint.
pub(crate) fn serial_with_motors(rows: &[(f64, f64, f64)], gravity: Vec3<f64>) -> Mechanism {
    let mut builder = serial_builder(rows, gravity);
    for k in 1..=rows.len() {
        let motor = DriveTrainSpec::new(format!("M{k}"), format!("J{k}"));
        builder = builder.drive_train(motor.ratio(50.0).rotor_inertia(2e-4));
    }
    builder.build().unwrap()
}

fn serial_builder(rows: &[(f64, f64, f64)], gravity: Vec3<f64>) -> MechanismBuilder {
    let mut builder = MechanismBuilder::new("serial").gravity(gravity);
    let mut random = Random::new(7);
    let mut frame = Pose::identity();
    for (k, &(d, a, alpha)) in rows.iter().enumerate() {
        let name = format!("link{}", k + 1);
        let from = if k == 0 { "ground".to_owned() } else { format!("link{k}") };
        // A general mass distribution of points, which makes the inertia physical.
        let spread = Mat3::diagonal(Vec3::new(0.05, 0.06, 0.07)) + {
            let v = random.vector();
            Mat3::from_columns(v * v.x, v * v.y, v * v.z) * -0.01
        };
        builder = builder
            .body(
                BodySpec::new(&name)
                    .mass(2.0 + random.number())
                    .com(random.vector() * 0.2)
                    .inertia(spread),
            )
            .joint(
                JointSpec::new(format!("J{}", k + 1), JointType::Revolute, &from, &name)
                    .frames(frame, Pose::identity())
                    .actuated(),
            );
        let turn = Mat3::rotation(Vec3::unit(0), alpha);
        frame = Pose { position: Vec3::new(a, 0.0, d), rotation: turn };
    }
    builder
}

pub(crate) fn actuator_coordinates(mechanism: &Mechanism) -> Vec<Coordinate> {
    mechanism.actuators().map(|(joint, dof)| Coordinate::Joint { joint, dof }).collect()
}

pub(crate) fn solver(
    mechanism: &Mechanism,
    coordinates: &[Coordinate],
    at: &[f64],
) -> InverseDynamics {
    let targets: Vec<_> =
        at.iter().map(|&value| Target { value, rate: 0.0, acceleration: 0.0 }).collect();
    InverseDynamics::new(mechanism.clone(), &[], coordinates, &targets, Settings::default())
        .unwrap()
}

/// Solver of a gallery model at the first instant of its default motion.
pub(crate) fn gallery_solver(model: &ModelFile) -> (InverseDynamics, Vec<f64>) {
    let name = model.default_motion.clone().unwrap_or_else(|| model.motions[0].0.clone());
    let motion = model.motion(&name).unwrap();
    let coordinates: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
    let targets: Vec<_> = motion.at(motion.start).collect();
    let solver = InverseDynamics::new(
        model.mechanism.clone(),
        &model.initial_poses,
        &coordinates,
        &targets,
        Settings::default(),
    );
    (solver.unwrap(), targets.iter().map(|target| target.value).collect())
}

/// Name, home coordinates and regressor with all parameters of every gallery model whose motion is
/// determined by its actuators, except models with freely spinning bodies. The accelerations of
/// such bodies depend on their inertia, so that efforts are not linear in it and difference
/// quotients of loads do not exist.
pub(crate) fn gallery_regressors() -> impl Iterator<Item = (&'static str, Vec<f64>, Regressor)> {
    gallery::names().filter_map(|name| {
        let model = gallery_model(name);
        if model.motions.is_empty() || model.mechanism.actuators().count() == 0 {
            return None;
        }
        let (solver, home) = gallery_solver(&model);
        if !solver.constraints().spins().is_empty() {
            return None;
        }
        Some((name, home, Regressor::new(solver, &Choice::ALL).ok()?))
    })
}

/// A random motion near `home`.
pub(crate) fn random_motion(random: &mut Random, home: &[f64], size: f64) -> [Vec<f64>; 3] {
    let mut some = |factor: f64| home.iter().map(|_| factor * random.number()).collect::<Vec<_>>();
    let q = some(size).iter().zip(home).map(|(d, h)| h + d).collect();
    [q, some(1.0), some(5.0)]
}

/// Columns at random motions.
pub(crate) fn random_columns(
    solver: InverseDynamics,
    choice: Choice,
    home: &[f64],
    (size, count): (f64, usize),
) -> (Regressor, Vec<Columns>) {
    let mut regressor = Regressor::new(solver, &choice).unwrap();
    let mut random = Random::new(3);
    let mut all = Vec::new();
    for _ in 0..count {
        let [q, v, a] = random_motion(&mut random, home, size);
        if let Ok(columns) = regressor.at(&q, &v, &a) {
            all.push(columns);
        }
    }
    (regressor, all)
}

pub(crate) fn stacked(all: &[Columns]) -> nalgebra::DMatrix<f64> {
    let rows: Vec<_> = all.iter().flat_map(|c| c.matrix.row_iter()).collect();
    nalgebra::DMatrix::from_rows(&rows)
}
