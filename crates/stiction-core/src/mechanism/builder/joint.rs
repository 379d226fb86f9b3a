//! Specification of joints.

use super::{check_finite, pose_numbers};
use crate::friction::JointFriction;
use crate::joint::JointType;
use crate::mechanism::{BodyId, Compliance, Defect, Joint, JointRange};
use crate::spatial::Pose;
use std::collections::HashMap;

/// Specification of a joint; it refers to its bodies by name.
#[must_use = "a specification has no effect until it is passed to a `MechanismBuilder`"]
#[derive(Clone, Debug, PartialEq)]
pub struct JointSpec {
    pub(super) name: String,
    pub(super) joint_type: JointType,
    predecessor: String,
    successor: String,
    frame_j: Pose<f64>,
    frame_k: Pose<f64>,
    pitch: f64,
    actuated: Vec<usize>,
    start: Option<Vec<f64>>,
    pub(super) friction: Vec<JointFriction>,
    compliance: Option<Compliance>,
    ranges: Vec<JointRange>,
}

impl JointSpec {
    /// Creates a joint without friction or actuator, whose frames J and K coincide with the frames
    /// of its bodies.
    pub fn new(
        name: impl Into<String>,
        joint_type: JointType,
        predecessor: impl Into<String>,
        successor: impl Into<String>,
    ) -> Self {
        Self {
            name: name.into(),
            joint_type,
            predecessor: predecessor.into(),
            successor: successor.into(),
            frame_j: Pose::identity(),
            frame_k: Pose::identity(),
            pitch: 0.0,
            actuated: Vec::new(),
            start: None,
            friction: Vec::new(),
            compliance: None,
            ranges: Vec::new(),
        }
    }

    /// Sets the poses of the joint frames: J in the predecessor (`X_PJ`) and K in the successor
    /// (`X_SK`).
    pub fn frames(mut self, frame_j: Pose<f64>, frame_k: Pose<f64>) -> Self {
        (self.frame_j, self.frame_k) = (frame_j, frame_k);
        self
    }

    /// Sets the pitch of a helical joint: its advance in m/rad.
    pub fn pitch(mut self, pitch: f64) -> Self {
        self.pitch = pitch;
        self
    }

    /// Declares that actuators act on all degrees of freedom of the joint.
    pub fn actuated(mut self) -> Self {
        self.actuated = (0..self.joint_type.dofs().len()).collect();
        self
    }

    /// Declares that actuators act only on the degrees of freedom with these indices.
    pub fn actuated_dofs(mut self, dofs: impl Into<Vec<usize>>) -> Self {
        self.actuated = dofs.into();
        self
    }

    /// Sets the start coordinates of the joint (rad, m, or a unit quaternion for an orientation).
    /// Assembly searches for a configuration near the start coordinates.
    pub fn start(mut self, coordinates: impl Into<Vec<f64>>) -> Self {
        self.start = Some(coordinates.into());
        self
    }

    /// Sets the compliance of the joint, which determines how redundant constraints share a load.
    pub fn compliance(mut self, compliance: Compliance) -> Self {
        self.compliance = Some(compliance);
        self
    }

    /// Adds a range that the joint should not leave. A range does not change results; the reports
    /// of runs state where a motion leaves the range.
    pub fn range(mut self, range: JointRange) -> Self {
        self.ranges.push(range);
        self
    }

    /// Adds friction at one of the joint's interfaces.
    pub fn friction(mut self, interface: JointFriction) -> Self {
        self.friction.push(interface);
        self
    }

    /// Builds the joint, with bodies found by name in `ids`. Returns `None` if a body does not
    /// exist or if both bodies are the same. Appends all defects found to `defects`.
    pub(super) fn resolve(
        self,
        ids: &HashMap<String, BodyId>,
        defects: &mut Vec<Defect>,
    ) -> Option<Joint> {
        let joint = &self.name;
        let place = |what: &str| format!("{what} of joint `{joint}`");
        check_finite(defects, &place("the frame on the predecessor"), &pose_numbers(&self.frame_j));
        check_finite(defects, &place("the frame on the successor"), &pose_numbers(&self.frame_k));

        let helical = self.joint_type == JointType::Helical;
        if !self.pitch.is_finite() || helical != (self.pitch != 0.0) {
            defects.push(Defect::Pitch { joint: joint.clone() });
        }

        let mut actuated = vec![false; self.joint_type.dofs().len()];
        for &dof in &self.actuated {
            match actuated.get_mut(dof) {
                Some(driven) if self.joint_type.has_scalar_coordinates() => *driven = true,
                _ => defects.push(Defect::NotActuable { joint: joint.clone(), dof }),
            }
        }

        let expected = self.joint_type.coordinates();
        if let Some(start) = &self.start {
            if start.len() != expected {
                let found = start.len();
                defects.push(Defect::StartLength { joint: joint.clone(), found, expected });
            }
            check_finite(defects, &place("the start"), start);
        }
        self.check_friction(defects);
        self.check_compliance(defects);
        self.check_ranges(defects);

        let mut body = |name: &str| {
            let id = ids.get(name).copied();
            if id.is_none() {
                let (joint, body) = (joint.clone(), name.to_owned());
                defects.push(Defect::UnknownBody { joint, body });
            }
            id
        };
        let (predecessor, successor) = (body(&self.predecessor), body(&self.successor));
        let (predecessor, successor) = (predecessor?, successor?);
        if predecessor == successor {
            defects.push(Defect::SameBody { joint: joint.clone(), body: self.successor });
            return None;
        }
        Some(Joint {
            name: self.name,
            joint_type: self.joint_type,
            predecessor,
            successor,
            frame_j: self.frame_j,
            frame_k: self.frame_k,
            pitch: self.pitch,
            actuated,
            start: self.start,
            friction: self.friction,
            compliance: self.compliance,
            ranges: self.ranges,
        })
    }

    fn check_ranges(&self, defects: &mut Vec<Defect>) {
        for range in &self.ranges {
            let (least, greatest) = range.limits;
            // Comparisons with NaN are false, so NaN limits are rejected.
            let is_ordered = least < greatest && least.is_finite() && greatest.is_finite();
            let problem = if !range.of.is_of(self.joint_type) {
                "does not apply to a joint of this type"
            } else if !is_ordered {
                "must have finite limits, the smaller one first"
            } else {
                continue;
            };
            defects.push(Defect::Range { joint: self.name.clone(), of: range.of, problem });
        }
    }

    fn check_compliance(&self, defects: &mut Vec<Defect>) {
        let parts = self.compliance.iter().flat_map(Compliance::parts);
        for (part, value) in parts.filter(|(_, value)| *value != 0.0) {
            let problem = if !(value > 0.0 && value.is_finite()) {
                "must be a finite number of at least 0"
            } else if !Compliance::applies(self.joint_type, part) {
                "does not apply: the joint moves freely in this direction"
            } else {
                continue;
            };
            defects.push(Defect::Compliance { joint: self.name.clone(), part, problem });
        }
    }
}
