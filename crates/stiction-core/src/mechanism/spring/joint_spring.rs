//! Torsion and linear springs with dampers on degrees of freedom of joints.

use super::check_not_negative;
use crate::mechanism::scalar_dof::{Coefficients, find_scalar};
use crate::mechanism::{Defect, Joint, JointId};

/// A spring with a parallel damper on one degree of freedom of a joint. Its effort, exerted by the
/// predecessor on the successor, is `preload - stiffness * (q - rest) - damping * rate of q`, where
/// `q` is the coordinate of the degree of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSpring {
    /// Name, unique among springs and bushings.
    pub name: String,
    /// Joint on which the spring acts.
    pub joint: JointId,
    /// Index of the degree of freedom in the joint.
    pub dof: usize,
    /// Stiffness, N m/rad or N/m, nonnegative.
    pub stiffness: f64,
    /// Coordinate at which the effort is the preload, rad or m.
    pub rest: f64,
    /// Effort at the coordinate `rest`, N m or N; positive towards larger coordinates.
    pub preload: f64,
    /// Damping, N m s/rad or N s/m, nonnegative.
    pub damping: f64,
    /// Middle of the interval of one full turn into which the angle of a joint that closes a loop
    /// is wrapped, rad. It is the middle of the permitted range of the degree of freedom, or zero
    /// without such a range.
    pub(crate) middle: f64,
}

/// Specification of a spring on a degree of freedom of a joint.
#[must_use = "a specification has no effect until it is passed to a `MechanismBuilder`"]
#[derive(Clone, Debug, PartialEq)]
pub struct JointSpringSpec {
    joint: String,
    spring: JointSpring,
}

impl JointSpringSpec {
    /// Creates a spring without stiffness and damping; `joint` is the name of a joint with one degree of
    /// freedom, or of a degree of freedom such as `leg1.U.first`.
    pub fn new(name: impl Into<String>, joint: impl Into<String>) -> Self {
        let spring = JointSpring {
            name: name.into(),
            joint: JointId(0),
            dof: 0,
            stiffness: 0.0,
            rest: 0.0,
            preload: 0.0,
            damping: 0.0,
            middle: 0.0,
        };
        Self { joint: joint.into(), spring }
    }

    /// Sets stiffness, N m/rad or N/m, and rest coordinate, rad or m.
    pub fn stiffness(mut self, stiffness: f64, rest: f64) -> Self {
        (self.spring.stiffness, self.spring.rest) = (stiffness, rest);
        self
    }

    /// Sets the effort at the rest coordinate, N m or N; positive towards larger coordinates.
    pub fn preload(mut self, preload: f64) -> Self {
        self.spring.preload = preload;
        self
    }

    /// Sets damping, N m s/rad or N s/m.
    pub fn damping(mut self, damping: f64) -> Self {
        self.spring.damping = damping;
        self
    }

    pub(in crate::mechanism) fn name(&self) -> &str {
        &self.spring.name
    }

    /// Builds the spring, or returns `None` if the mechanism does not have the named joint or
    /// degree of freedom. Appends all defects to `defects`.
    pub(in crate::mechanism) fn resolve(
        mut self,
        joints: &[Joint],
        defects: &mut Vec<Defect>,
    ) -> Option<JointSpring> {
        let JointSpring { stiffness, rest, preload, damping, .. } = self.spring;
        let name = || self.spring.name.clone();
        check_not_negative(
            &self.spring.name,
            &[("stiffness", stiffness), ("damping", damping)],
            defects,
        );
        for (what, value) in [("rest", rest), ("preload", preload)] {
            if !value.is_finite() {
                let place = format!("`{what}` of spring `{}`", name());
                defects.push(Defect::NotFinite { place });
            }
        }
        let (joint, dof) = match find_scalar(joints, &self.joint, false) {
            Ok(place) => place,
            Err(Coefficients::Unfit(problem)) => {
                defects.push(Defect::Spring { spring: name(), problem });
                return None;
            }
            Err(Coefficients::Unknown(_) | Coefficients::OutOfRange(_)) => {
                let joint = self.joint.clone();
                defects.push(Defect::UnknownJointOfSpring { spring: name(), joint });
                return None;
            }
        };
        let range = joints[joint]
            .ranges
            .iter()
            .find(|range| range.of == crate::mechanism::RangeOf::Dof(dof));
        self.spring.middle = range.map_or(0.0, |range| 0.5 * (range.limits.0 + range.limits.1));
        (self.spring.joint, self.spring.dof) = (JointId(joint), dof);
        Some(self.spring)
    }
}
