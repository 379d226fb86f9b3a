//! Assembly mode of the mechanism at the first instant of its motion.

use crate::dofs::dofs_of;
use serde_json::{Value, json};
use stiction_core::dynamics::InverseDynamics;
use stiction_core::kinematics::AssemblyReport;
use stiction_draw::numbers::number;

/// Distance, in characteristic lengths, below which the given configuration closes the loops.
const EXACT: f64 = 1e-6;

/// Assembly mode at the first instant, and its distance from the given configuration.
#[derive(Clone, Debug)]
pub struct AssemblyMode {
    /// Names and values, m or rad, of the scalar coordinates of all joints.
    pub coordinates: Vec<(String, f64)>,
    /// Comparison with the given configuration.
    pub report: AssemblyReport,
    /// False for an open chain, which has only one assembly mode.
    pub has_loops: bool,
}

impl AssemblyMode {
    pub(super) fn of(solver: &InverseDynamics) -> Self {
        let value = |joint, index| solver.joint_motion(joint, index).value;
        let dofs = dofs_of(solver.mechanism()).into_iter();
        Self {
            coordinates: dofs.map(|dof| (dof.name, value(dof.joint, dof.index))).collect(),
            report: solver.assembly_report().clone(),
            has_loops: solver.topology().cut_joints() > 0,
        }
    }

    /// States what selected the mode and how to select another one; `None` for open chains.
    pub(super) fn sentence(&self) -> Option<String> {
        let selected = match self.report.distance {
            _ if self.report.open_mode.is_some() => {
                "one of several that agree with `home`, `start` and the prescribed coordinates"
                    .to_owned()
            }
            Some(distance) if distance < EXACT => {
                "that given by `home`, `start` and the prescribed coordinates".to_owned()
            }
            Some(distance) => format!(
                "the nearest to `home`, `start` and the prescribed coordinates, at an rms distance \
                 of {} characteristic lengths",
                number(distance)
            ),
            None => "the nearest to zero coordinates".to_owned(),
        };
        self.has_loops
            .then(|| format!("assembly mode: {selected}; other `home` or `start` select another"))
    }

    pub(super) fn json(&self) -> Value {
        let coordinates = self.coordinates.iter().map(|(name, value)| (name.clone(), json!(value)));
        json!({
            "coordinates": Value::Object(coordinates.collect()),
            "distance": self.report.distance,
            "is_ambiguous": self.report.open_mode.is_some(),
            "other_modes": self.report.other_modes,
        })
    }
}
