//! Part of the joint friction that MJCF and SDF can express: viscous damping that does not depend on
//! the load.

use stiction_core::friction::{Curve, InterfaceShape, JointFriction, Law, Thread, interfaces_of};
use stiction_core::mechanism::Joint;

/// Returns the damping coefficient of each degree of freedom of a joint, N s/m or N m s.
pub(super) fn damping(joint: &Joint) -> Vec<f64> {
    let mut damping = vec![0.0; joint.joint_type.dofs().len()];
    for interface in &joint.friction {
        let Some(viscous) = viscous(interface) else { continue };
        let (_, shape) = interfaces_of(joint.joint_type)[interface.place];
        let radius = interface.radius.unwrap_or(1.0);
        // The dissipated power is the viscous coefficient times the squared sliding speed, so each
        // lever arm appears as its square.
        let squares = match shape {
            InterfaceShape::Plate => [1.0, 1.0, radius * radius],
            InterfaceShape::Thread => {
                let way = Thread { radius, pitch: joint.pitch }.way();
                [way * way; 3]
            }
            InterfaceShape::Guide { .. } | InterfaceShape::Shaft { .. } => [1.0; 3],
            InterfaceShape::Sleeve => [radius * radius, 1.0, 1.0],
            InterfaceShape::Pin { .. } | InterfaceShape::Ball => [radius * radius; 3],
        };
        for (dof, square) in shape.dofs().zip(squares) {
            damping[dof] += viscous * square;
        }
    }
    damping
}

/// Returns the viscous coefficient of an interface, N s/m; `None` if forward and backward sliding
/// have different coefficients.
fn viscous(interface: &JointFriction) -> Option<f64> {
    let same = interface.backward.as_ref().is_none_or(|law| law.viscous == interface.law.viscous);
    same.then_some(interface.law.viscous)
}

/// Returns true if MJCF damping describes the friction of an interface completely. `can_be_damped`
/// is true if the file has an MJCF joint for the joint of the interface.
pub(super) fn is_damping_alone(interface: &JointFriction, can_be_damped: bool) -> bool {
    let laws = [Some(&interface.law), interface.backward.as_ref()];
    viscous(interface).is_some_and(|viscous| can_be_damped || viscous == 0.0)
        && laws.into_iter().flatten().all(has_no_coefficient)
}

fn has_no_coefficient(law: &Law) -> bool {
    match &law.curve {
        Curve::Constant => law.mu == 0.0,
        Curve::Static { mu_static } => law.mu == 0.0 && *mu_static == 0.0,
        Curve::Stribeck { mu_static, .. } => law.mu == 0.0 && *mu_static == 0.0,
        Curve::Table(rows) => rows.iter().all(|row| row[1] == 0.0),
    }
}
