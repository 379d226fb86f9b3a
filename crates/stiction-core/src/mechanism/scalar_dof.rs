//! Search by name for degrees of freedom with a scalar coordinate, to which drive trains, gearings
//! and springs refer.

use super::{Joint, JointId};
use crate::joint::Motion;

/// Term of a weighted sum of joint coordinates. The sum is either the output coordinate of a
/// motor's gear, or the sum that a gearing keeps constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GearedDof {
    /// Joint to which the degree of freedom belongs.
    pub joint: JointId,
    /// Index of the degree of freedom in the joint.
    pub dof: usize,
    /// Nonzero coefficient of the degree of freedom in the sum; one if a motor drives only this
    /// degree of freedom.
    pub coefficient: f64,
    /// True if the degree of freedom is a translation.
    pub translates: bool,
}

/// Error in a list of joint names and coefficients that should define a weighted sum of
/// coordinates.
pub(super) enum Coefficients {
    /// No joint has this name.
    Unknown(String),
    /// A coefficient is zero or not finite.
    OutOfRange(f64),
    /// A name does not identify a single degree of freedom, or the list contains a degree of
    /// freedom twice. The text describes the problem.
    Unfit(String),
}

/// Finds the degrees of freedom with the given names, and combines each with its coefficient.
///
/// # Errors
/// Returns the problems of all names and coefficients.
pub(super) fn resolve(
    joints: &[Joint],
    named: &[(String, f64)],
) -> Result<Vec<GearedDof>, Vec<Coefficients>> {
    let (mut found, mut problems) = (Vec::<GearedDof>::new(), Vec::new());
    for (name, coefficient) in named {
        if !coefficient.is_finite() || *coefficient == 0.0 {
            problems.push(Coefficients::OutOfRange(*coefficient));
        }
        let (joint, dof) = match find_scalar(joints, name, true) {
            Ok((joint, dof)) => (JointId(joint), dof),
            Err(problem) => {
                problems.push(problem);
                continue;
            }
        };
        let content = &joints[joint.0];
        if found.iter().any(|known| (known.joint, known.dof) == (joint, dof)) {
            let problem = format!("it names `{}` twice", content.dof_name(dof));
            problems.push(Coefficients::Unfit(problem));
        }
        let translates = content.joint_type.dofs()[dof].motion == Motion::Translation;
        found.push(GearedDof { joint, dof, coefficient: *coefficient, translates });
    }
    if problems.is_empty() { Ok(found) } else { Err(problems) }
}

/// Finds the degree of freedom with this name and returns the index of its joint and its index in
/// the joint. The name is `joint.dof`, or the name of a joint with one degree of freedom. If
/// `of_actuator` is true, the name of a joint with one actuator is accepted as well.
///
/// # Errors
/// Returns [`Coefficients::Unknown`] if the name is that of no joint or degree of freedom, and
/// [`Coefficients::Unfit`] if it is the name of a joint but does not identify a single degree of
/// freedom.
pub(super) fn find_scalar(
    joints: &[Joint],
    name: &str,
    of_actuator: bool,
) -> Result<(usize, usize), Coefficients> {
    if let Some(found) = find(joints, name, of_actuator) {
        return Ok(found);
    }
    Err(match joints.iter().find(|known| known.name == name) {
        Some(known)
            if known.joint_type.has_scalar_coordinates() && !known.joint_type.dofs().is_empty() =>
        {
            let dofs: Vec<_> = (0..known.joint_type.dofs().len())
                .map(|dof| format!("`{}`", known.dof_name(dof)))
                .collect();
            Coefficients::Unfit(format!(
                "joint `{name}` has several degrees of freedom: name one of {}",
                dofs.join(", ")
            ))
        }
        Some(_) => Coefficients::Unfit(format!(
            "joint `{name}` has no degree of freedom with a single coordinate"
        )),
        None => Coefficients::Unknown(name.to_owned()),
    })
}

fn find(joints: &[Joint], name: &str, of_actuator: bool) -> Option<(usize, usize)> {
    let scalar = |(_, joint): &(usize, &Joint)| joint.joint_type.has_scalar_coordinates();
    joints.iter().enumerate().filter(scalar).find_map(|(id, joint)| {
        let mut driven = joint.actuated_dofs();
        let of_joint = match (joint.joint_type.dofs(), driven.next(), driven.next()) {
            ([_], ..) => Some(0),
            (_, only, None) if of_actuator => only,
            _ => None,
        };
        let named = || (0..joint.actuated.len()).find(|dof| joint.dof_name(*dof) == name);
        let dof = of_joint.filter(|_| joint.name == name).or_else(named)?;
        Some((id, dof))
    })
}
