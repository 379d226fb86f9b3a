//! Independent kinematics and dynamics of an imported robot: open chains of joints, their poses and
//! their mass matrix.

use nalgebra::{DMatrix, Matrix3};
use std::collections::HashMap;
use stiction_core::joint::JointType;
use stiction_core::mechanism::Mechanism;
use stiction_core::spatial::{Mat3, Pose, Vec3};
use stiction_format::{ImportOptions, Imported, ModelFile, Source, import, read};

/// Converts a text without further files.
pub(super) fn convert(name: &str, text: &str) -> Imported {
    with_files(name, text, &[], false)
}

/// Converts a text with further files.
pub(super) fn with_files(
    name: &str,
    text: &str,
    files: &[(&str, &str)],
    literal: bool,
) -> Imported {
    let load = |wanted: &str| {
        let found = files.iter().find(|(known, _)| *known == wanted);
        found.map(|(_, text)| text.as_bytes().to_vec()).ok_or("there is no such file".to_owned())
    };
    import(&Source::new(name, text), ImportOptions { literal }, &load)
        .unwrap_or_else(|errors| panic!("{errors}"))
}

/// Errors of a text that cannot be converted.
pub(super) fn refused(name: &str, text: &str) -> String {
    let load = |_: &str| Err("there is no such file".to_owned());
    let errors = import(&Source::new(name, text), ImportOptions { literal: false }, &load);
    errors.map(|imported| imported.text).unwrap_err().render(false)
}

/// Reads the model of a conversion.
pub(super) fn model(imported: &Imported) -> ModelFile {
    read(&Source::new("imported.toml", &imported.text), &|_| Err("no files".into()))
        .unwrap_or_else(|errors| panic!("{errors}\n{}", imported.text))
}

/// Open chains of fixed joints and of the joints with the given names, at given coordinates.
pub(super) struct Tree {
    pub(super) poses: Vec<Pose<f64>>,
    /// Twist of each body per unit rate of each coordinate: angular velocity, and velocity of the
    /// body point at the origin of the world.
    rates: Vec<Vec<(Vec3<f64>, Vec3<f64>)>>,
}

impl Tree {
    pub(super) fn new(mechanism: &Mechanism, names: &[&str], q: &[f64]) -> Self {
        let count = mechanism.bodies().len();
        let none = vec![(Vec3::zero(), Vec3::zero()); names.len()];
        let mut poses = vec![None; count];
        poses[0] = Some(Pose::identity());
        let mut rates = vec![none; count];
        let index: HashMap<&str, usize> = names.iter().enumerate().map(|(k, n)| (*n, k)).collect();
        loop {
            let mut changed = false;
            for joint in mechanism.joints() {
                let (from, to) = (joint.predecessor.0, joint.successor.0);
                let (Some(base), None) = (poses[from], poses[to]) else { continue };
                let own = index.get(joint.name.as_str());
                let is_held = matches!(joint.joint_type, JointType::Fixed | JointType::Spherical);
                if own.is_none() && !is_held {
                    continue;
                }
                let value: Vec<f64> = own.map(|k| q[*k]).into_iter().collect();
                let frame = base * joint.frame_j;
                let across = match own {
                    Some(_) => joint.joint_type.pose(&value, 0.0),
                    None => Pose::identity(),
                };
                poses[to] = Some(frame * across * joint.frame_k.inverse());
                rates[to] = rates[from].clone();
                if let Some(k) = own {
                    let axis = frame.rotation.columns[2];
                    rates[to][*k] = match joint.joint_type {
                        JointType::Prismatic => (Vec3::zero(), axis),
                        _ => (axis, frame.position.cross(axis)),
                    };
                }
                changed = true;
            }
            if !changed {
                break;
            }
        }
        let poses = poses.into_iter().map(|pose| pose.expect("a body is not reached")).collect();
        Self { poses, rates }
    }

    pub(super) fn mass_matrix(&self, mechanism: &Mechanism) -> DMatrix<f64> {
        let count = self.rates[0].len();
        let mut total = DMatrix::zeros(count, count);
        for (body, content) in mechanism.bodies().iter().enumerate() {
            let pose = self.poses[body];
            let com = pose.apply(content.com);
            let turned: Mat3<f64> = pose.rotation * content.inertia * pose.rotation.transpose();
            let inertia = Matrix3::from(turned);
            let part = |k: usize| {
                let (w, v) = self.rates[body][k];
                (nalgebra::Vector3::from(w), nalgebra::Vector3::from(v + w.cross(com)))
            };
            for i in 0..count {
                for j in 0..count {
                    let ((wi, vi), (wj, vj)) = (part(i), part(j));
                    total[(i, j)] += content.mass * vi.dot(&vj) + wi.dot(&(inertia * wj));
                }
            }
        }
        total
    }
}

/// Number of instantaneous degrees of freedom in the assembled configuration.
pub(super) fn mobility(model: &ModelFile) -> usize {
    let locks = stiction_core::kinematics::locks(&model.mechanism, &model.initial_poses, &[], &[]);
    locks.unwrap().len()
}
