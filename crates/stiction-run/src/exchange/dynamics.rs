//! Friction and damping of a joint as `<dynamics>` of URDF and SDF: viscous damping, and friction that depends neither on
//! the load nor on the speed.

use super::damping::{damping, is_damping_alone};
use stiction_core::friction::{Curve, JointFriction};
use stiction_core::joint::JointType;
use stiction_core::mechanism::{Joint, Mechanism};

/// Greatest friction coefficient of an interface whose normal load is its preload: friction due to the reaction of the
/// joint is negligible. The import of constant friction writes this coefficient.
const NEGLIGIBLE: f64 = 1e-6;

/// Attributes of `<dynamics>`: damping, N s/m or N m s/rad, and friction, N or N m. Values of zero are omitted, and all
/// values of joints that are neither revolute nor prismatic.
pub(super) fn attributes(mechanism: &Mechanism, joint: usize) -> Vec<(&'static str, f64)> {
    let content = &mechanism.joints()[joint];
    if !is_simple(content) {
        return Vec::new();
    }
    let own = content.friction.iter().filter_map(|interface| constant(content, interface));
    let (mut damping, mut friction) = (damping(content)[0], own.sum::<f64>());
    let trains = mechanism.drive_trains().iter();
    let is_own = |only: Option<(stiction_core::mechanism::JointId, usize)>| {
        only.is_some_and(|(id, _)| id.0 == joint)
    };
    for train in trains.filter(|train| is_own(train.only_dof())) {
        let (n, motor) = (train.transmission().abs(), train.motor_friction);
        friction += n * motor.constant;
        damping += n * n * motor.viscous;
    }
    let springs = mechanism.joint_springs().iter().filter(|spring| spring.joint.0 == joint);
    damping += springs.map(|spring| spring.damping).sum::<f64>();
    let all = [("damping", damping), ("friction", friction)];
    all.into_iter().filter(|(_, value)| *value > 0.0).collect()
}

/// Tests if `<dynamics>` describes the friction of a joint completely.
pub(super) fn is_complete(joint: &Joint) -> bool {
    let is_expressed = |interface: &JointFriction| {
        is_damping_alone(interface, true) || constant(joint, interface).is_some()
    };
    joint.friction.is_empty() || (is_simple(joint) && joint.friction.iter().all(is_expressed))
}

fn is_simple(joint: &Joint) -> bool {
    matches!(joint.joint_type, JointType::Revolute | JointType::Prismatic)
}

/// Friction of an interface whose normal load is its preload, N or N m. `None` if the friction depends on the reaction of
/// the joint, on the speed or on the direction.
fn constant(joint: &Joint, interface: &JointFriction) -> Option<f64> {
    let law = &interface.law;
    let is_constant = is_simple(joint)
        && law.curve == Curve::Constant
        && law.bristles.is_none()
        && law.regularisation.is_none()
        && interface.backward.is_none()
        && (0.0..=NEGLIGIBLE).contains(&law.mu)
        && law.mu * interface.load.preload > 0.0;
    is_constant.then(|| law.mu * interface.load.preload * interface.radius.unwrap_or(1.0))
}
