//! Export of an assembled mechanism to formats of other programs.

mod damping;
mod dynamics;
mod extension;
mod json;
#[cfg(feature = "mcap")]
mod mcap;
mod mimic;
mod mjcf;
mod model_file;
mod names;
#[cfg(not(target_arch = "wasm32"))]
mod npz;
mod sdf;
mod urdf;
mod xml;

pub use json::{json, json_text};
#[cfg(feature = "mcap")]
pub use mcap::mcap_of_csv;
pub use mjcf::{Mjcf, Unfit, mjcf};
pub use model_file::{Instant, Unwritable, model_file};
#[cfg(not(target_arch = "wasm32"))]
pub use npz::npz_of_csv;
pub use sdf::{Sdf, sdf};
pub use urdf::{Urdf, urdf};

use crate::bodies::poses_in_world;
use crate::{Error, Job};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_core::spatial::Pose;
use stiction_format::ModelFile;

/// Model together with an assembled configuration, the home position.
#[derive(Clone, Debug)]
pub struct Home<'a> {
    /// Model of the exported mechanism.
    pub model: &'a ModelFile,
    /// Pose of each body in the world, with all loops closed.
    pub poses: Vec<Pose<f64>>,
    /// Pose of frame K in frame J of each joint, `X_JK`.
    pub across: Vec<Pose<f64>>,
    /// Coordinates of each joint's degrees of freedom, m or rad, with angles within half a turn.
    /// `None` for the rotations of spherical and free joints, which have no scalar coordinates.
    pub coordinates: Vec<Vec<Option<f64>>>,
    /// Mechanism with the home position as the initial guess of each joint for the assembly.
    pub mechanism: Mechanism,
    /// Prescribed coordinates at the first instant of the motion, with their values, rates and accelerations.
    pub motion: Vec<(Coordinate, Target<f64>)>,
}

impl<'a> Home<'a> {
    /// Assembles the mechanism at the first instant of the job's motion.
    ///
    /// # Errors
    /// Returns [`Error::Assembly`] if the loops cannot be closed at this instant, and
    /// [`Error::NotFinite`] if the motion has no finite value there.
    pub fn of(job: &Job<'a>) -> Result<Self, Error> {
        let solver = job.assemble(job.motion.start)?.solver;
        let origin = solver.parameters().origin;
        let bodies = solver.bodies();
        let across: Vec<Pose<f64>> =
            bodies.frame_j.iter().zip(&bodies.frame_k).map(|(j, k)| j.inverse() * *k).collect();
        let joints = job.model.mechanism.joints();
        let coordinates = joints.iter().enumerate().map(|(index, joint)| {
            if joint.joint_type == JointType::Free {
                let place = across[index].position.to_array().map(Some);
                return place.into_iter().chain([None; 3]).collect();
            }
            let mut values: Vec<Option<f64>> =
                solver.joint_coordinates(JointId(index)).into_iter().map(Some).collect();
            values.resize(joint.joint_type.dofs().len(), None);
            values
        });
        let motion = job.motion.coordinates.iter().map(|(coordinate, _)| *coordinate);
        Ok(Self {
            model: job.model,
            poses: poses_in_world(bodies, origin).collect(),
            coordinates: coordinates.collect(),
            mechanism: job.model.mechanism.starting_at(bodies.joint_poses()),
            motion: motion.zip(job.motion.at(job.motion.start)).collect(),
            across,
        })
    }
}
