//! Rigid gearings: constraints between joint coordinates.
//!
//! Equation (G12) of the book's theory.

use super::scalar_dof::{self, Coefficients};
use super::{Defect, GearedDof, Joint, JointId};
use crate::disjoint_sets::DisjointSets;

/// Rigid gearing of several degrees of freedom: a weighted sum of their coordinates has a constant
/// value.
///
/// The effort `lambda` of the gearing is the Lagrange multiplier of this constraint. The gearing
/// exerts the effort `coefficient * lambda` on each degree of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct Gearing {
    /// Name, unique among gearings.
    pub name: String,
    /// Degrees of freedom with their coefficients; at least two, each listed once.
    pub dofs: Vec<GearedDof>,
    /// Constant value of the weighted sum, in m if a degree of freedom translates, otherwise in
    /// rad.
    pub offset: f64,
}

impl Gearing {
    /// Returns `true` if a degree of freedom translates. The weighted sum is then a length, and the
    /// effort a force.
    pub fn is_length(&self) -> bool {
        self.dofs.iter().any(|geared| geared.translates)
    }
}

/// Specification of a rigid gearing; it refers to joints by name.
#[must_use = "a specification has no effect until it is passed to a `MechanismBuilder`"]
#[derive(Clone, Debug, PartialEq)]
pub struct GearingSpec {
    name: String,
    joints: Vec<(String, f64)>,
    offset: f64,
}

impl GearingSpec {
    /// Creates a gearing that keeps the weighted sum of joint coordinates at zero. `joints` are
    /// pairs of name and coefficient. A joint with one degree of freedom is given by its name, a
    /// degree of freedom of another joint by `joint.dof`. If a degree of freedom translates, the
    /// sum is a length, and the coefficients of rotations are in m/rad.
    pub fn new<N: Into<String>>(
        name: impl Into<String>,
        joints: impl IntoIterator<Item = (N, f64)>,
    ) -> Self {
        let joints = joints.into_iter().map(|(joint, coefficient)| (joint.into(), coefficient));
        Self { name: name.into(), joints: joints.collect(), offset: 0.0 }
    }

    /// Sets the constant value of the weighted sum, rad or m.
    pub fn offset(mut self, offset: f64) -> Self {
        self.offset = offset;
        self
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Builds the gearing, and appends all defects to `defects`. Returns `None` if the gearing has
    /// unsuitable names or coefficients, or fewer than two degrees of freedom.
    pub(super) fn resolve(self, joints: &[Joint], defects: &mut Vec<Defect>) -> Option<Gearing> {
        let gearing = || self.name.clone();
        if !self.offset.is_finite() {
            let place = format!("the offset of gearing `{}`", self.name);
            defects.push(Defect::NotFinite { place });
        }
        let dofs = match scalar_dof::resolve(joints, &self.joints) {
            Ok(dofs) => dofs,
            Err(problems) => {
                defects.extend(problems.into_iter().map(|problem| match problem {
                    Coefficients::Unknown(joint) => {
                        Defect::UnknownJointOfGearing { gearing: gearing(), joint }
                    }
                    Coefficients::OutOfRange(value) => Defect::Gearing {
                        gearing: gearing(),
                        problem: format!("a coefficient is {value}, but must be other than 0"),
                    },
                    Coefficients::Unfit(problem) => Defect::Gearing { gearing: gearing(), problem },
                }));
                return None;
            }
        };
        if dofs.len() < 2 {
            let problem = "it connects fewer than two degrees of freedom".to_owned();
            defects.push(Defect::Gearing { gearing: gearing(), problem });
            return None;
        }
        Some(Gearing { dofs, name: self.name, offset: self.offset })
    }
}

/// Checks that no loop consists of geared joints only, because the spanning tree must contain all
/// geared joints. `bodies` is the number of bodies.
pub(super) fn check_loops(
    gearings: &[Gearing],
    (bodies, joints): (usize, &[Joint]),
    defects: &mut Vec<Defect>,
) {
    if let Some((gearing, joint)) = closing_joint(gearings, (bodies, joints)) {
        let problem = format!(
            "every joint of a loop through `{}` is in a gearing, but at least one must not be: split \
             one body of this loop into two, and connect them with a fixed joint",
            joints[joint.0].name
        );
        defects.push(Defect::Gearing { gearing: gearings[gearing].name.clone(), problem });
    }
}

/// Searches the geared joints, in the order of the gearings, for a joint that closes a loop of
/// geared joints only. Returns the first such joint and the index of its gearing. `bodies` is the
/// number of bodies.
pub(super) fn closing_joint(
    gearings: &[Gearing],
    (bodies, joints): (usize, &[Joint]),
) -> Option<(usize, JointId)> {
    let mut trees = DisjointSets::new(bodies);
    let mut known = vec![false; joints.len()];
    for (index, gearing) in gearings.iter().enumerate() {
        for geared in &gearing.dofs {
            if std::mem::replace(&mut known[geared.joint.0], true) {
                continue;
            }
            let joint = &joints[geared.joint.0];
            if !trees.unite(joint.predecessor.0, joint.successor.0) {
                return Some((index, geared.joint));
            }
        }
    }
    None
}
