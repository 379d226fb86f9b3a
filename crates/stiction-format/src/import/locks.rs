//! Locks joints whose coordinate is prescribed: a coupling (linear constraint) that contains a
//! single coordinate turns the joint into a fixed joint.

use super::context::Context;
use super::description::Description;
use crate::diagnostic::quoted;
use stiction_core::joint::JointType;

/// Largest relative difference between two values prescribed for one coordinate that is attributed
/// to rounding.
const SAME: f64 = 1e-9;

/// Replaces a joint by a fixed joint if a coupling that contains only the joint's coordinate
/// prescribes this coordinate. Motors of the joint are removed.
pub(super) fn fix(context: &Context<'_>, robot: &mut Description) {
    while let Some((gearing, joint, factor)) = next(robot) {
        let gearing = robot.gearings.remove(gearing);
        let value = gearing.constant / factor;
        let message = format!(
            "a coupling keeps joint {} at a constant value: the joint is imported as a fixed joint",
            quoted(&robot.joints[joint].name)
        );
        context.note(message, gearing.place);
        let own = &mut robot.joints[joint];
        let across = own.kind.pose(&[value], own.pitch);
        own.frame_j = own.frame_j * across;
        own.kind = JointType::Fixed;
        own.dofs.clear();
        let has_motor = robot.motors.iter().any(|motor| motor.joint == joint);
        if has_motor {
            context.note(
                "motors of joints that a coupling keeps at a constant value are left out",
                own.place.clone(),
            );
        }
        robot.motors.retain(|motor| motor.joint != joint);
        for motor in &mut robot.joint_motors {
            motor.terms.retain(|term| term.0 != joint);
        }
        robot.joint_motors.retain(|motor| !motor.terms.is_empty());
        for other in &mut robot.gearings {
            let terms = &mut other.terms;
            let held: f64 = terms.iter().filter(|term| term.0 == joint).map(|term| term.2).sum();
            let size = other.constant.abs() + held.abs() * value.abs();
            terms.retain(|term| term.0 != joint);
            other.constant -= held * value;
            if terms.is_empty() && other.constant.abs() > SAME * size {
                let message = format!(
                    "two couplings keep joint {} at different values",
                    quoted(&robot.joints[joint].name)
                );
                if let Some(place) = &other.place {
                    context.error("equality", message, place, "remove one of them");
                }
            }
        }
        robot.gearings.retain(|gearing| !gearing.terms.is_empty());
    }
}

/// Finds the first coupling that contains a single coordinate. Returns the index of the coupling,
/// the index of the joint, and the factor of the coordinate.
fn next(robot: &Description) -> Option<(usize, usize, f64)> {
    robot.gearings.iter().enumerate().find_map(|(index, gearing)| {
        let terms = || gearing.terms.iter().filter(|term| term.2 != 0.0);
        let &(first, dof, _) = terms().next()?;
        let is_alone = terms().all(|term| (term.0, term.1) == (first, dof));
        let has_one = robot.joints[first].dofs.len() == 1;
        let factor: f64 = terms().map(|term| term.2).sum();
        (is_alone && has_one && factor != 0.0 && factor.is_finite())
            .then_some((index, first, factor))
    })
}
