//! Writes identified parameter values into a mechanism.

use crate::parameter::{Kind, Parameter};
use crate::physical;
use stiction_core::friction::{Curve, JointFriction, Law};
use stiction_core::joint::Motion;
use stiction_core::mechanism::{Changeable, GearLoss, Mechanism};

/// Friction coefficient that replaces zero if a joint has only load-independent friction, because a
/// model file expresses such friction by a coefficient and a preload. It is so small that the
/// normal load of the joint changes the friction by less than one part in 10^6.
const CARRIER: f64 = 1e-9;

/// Sets the friction coefficient of a law to `mu`. Static coefficients and coefficients in tables
/// change in the same ratio.
pub(crate) fn scale_law(law: &mut Law, mu: f64) {
    let ratio = if law.mu > 0.0 { mu / law.mu } else { 1.0 };
    match &mut law.curve {
        Curve::Constant => {}
        Curve::Static { mu_static } | Curve::Stribeck { mu_static, .. } => {
            *mu_static = (*mu_static * ratio).max(mu);
        }
        Curve::Table(rows) => rows.iter_mut().for_each(|row| row[1] *= ratio),
    }
    law.mu = mu;
}

/// Sets the friction coefficient of a joint's law to `mu`. The coefficient of the separate law for
/// backward sliding, if there is one, changes in the same ratio.
pub(crate) fn scale_laws(law: &mut Law, backward: Option<&mut Law>, mu: f64) {
    if let Some(other) = backward {
        let ratio = if law.mu > 0.0 { mu / law.mu } else { 1.0 };
        scale_law(other, other.mu * ratio);
    }
    scale_law(law, mu);
}

/// Returns the preload, N, with which a law yields a constant friction `force`, N. If the
/// coefficient of the law is zero, sets it to [`CARRIER`].
pub(crate) fn carried_preload(law: &mut Law, backward: Option<&mut Law>, force: f64) -> f64 {
    if law.mu <= 0.0 && force > 0.0 {
        scale_law(law, CARRIER);
        if let Some(other) = backward {
            scale_law(other, CARRIER);
        }
    }
    if law.mu > 0.0 { force / law.mu } else { 0.0 }
}

/// Sets the viscous coefficient for both directions of sliding.
pub(crate) fn set_viscous(law: &mut Law, backward: Option<&mut Law>, viscous: f64) {
    law.viscous = viscous;
    if let Some(other) = backward {
        other.viscous = viscous;
    }
}

/// Sets the static coefficient of a law with Stribeck's curve to `1 + excess` times the sliding
/// coefficient.
pub(crate) fn set_static_excess(law: &mut Law, excess: f64) {
    let mu = law.mu;
    if let Curve::Stribeck { mu_static, .. } = &mut law.curve {
        *mu_static = mu * (1.0 + excess);
    }
}

/// Returns the mechanism with identified `values`, one for each of `parameters`. Offsets and effort terms describe the
/// logs and are left out. Friction of an actuator becomes motor friction if efforts were measured `at_motors`,
/// otherwise joint friction. The gears of the drive trains in `lossless` have no loss, because it is a part of the
/// identified friction.
pub fn applied(
    mechanism: &Mechanism,
    parameters: &[Parameter],
    values: &[f64],
    (at_motors, lossless): (bool, &[usize]),
) -> Mechanism {
    let actuators: Vec<_> = mechanism.actuators().collect();
    mechanism.with_changes(|Changeable { bodies, joints, drive_trains }| {
        for &train in lossless {
            drive_trains[train].gear = GearLoss::NONE;
        }
        for (body, inertial) in physical::bodies(parameters, values) {
            if inertial[0] > 0.0 {
                let (mass, com, inertia) = physical::central(&inertial);
                let body = &mut bodies[body];
                (body.mass, body.com, body.inertia) = (mass, com, inertia);
            }
        }
        let interfaces: Vec<(usize, usize)> = joints
            .iter()
            .enumerate()
            .flat_map(|(joint, content)| (0..content.friction.len()).map(move |k| (joint, k)))
            .collect();
        let mut coulomb = vec![0.0; interfaces.len()];
        for (parameter, &value) in parameters.iter().zip(values) {
            match parameter.kind {
                Kind::Rotor(train) => drive_trains[train].rotor_inertia = value,
                Kind::TorqueConstant(train) if value > 0.0 => {
                    drive_trains[train].torque_constant = Some(value);
                }
                Kind::Mu(i) => {
                    let (joint, k) = interfaces[i];
                    let friction = &mut joints[joint].friction[k];
                    scale_laws(&mut friction.law, friction.backward.as_mut(), value);
                }
                Kind::Viscous(i) => {
                    let (joint, k) = interfaces[i];
                    let arm = arm(&joints[joint].friction[k], joints[joint].pitch);
                    let friction = &mut joints[joint].friction[k];
                    let viscous = value / (arm * arm);
                    set_viscous(&mut friction.law, friction.backward.as_mut(), viscous);
                }
                Kind::Coulomb(i) => coulomb[i] = value,
                Kind::DriveCoulomb(index) | Kind::DriveViscous(index) => {
                    let (joint, dof) = actuators[index];
                    let train = drive_trains.iter_mut().find(|train| {
                        at_motors
                            && train.dofs.len() == 1
                            && (train.dofs[0].joint, train.dofs[0].dof) == (joint, dof)
                    });
                    let is_coulomb = matches!(parameter.kind, Kind::DriveCoulomb(_));
                    if let Some(train) = train {
                        let n = train.transmission();
                        match is_coulomb {
                            true => train.motor_friction.constant = value / n.abs(),
                            false => train.motor_friction.viscous = value / (n * n),
                        }
                    } else if value > 0.0 {
                        declare(&mut joints[joint.0], dof, is_coulomb, value);
                    }
                }
                _ => {}
            }
        }
        for (&(joint, k), value) in interfaces.iter().zip(coulomb) {
            let pitch = joints[joint].pitch;
            let friction = &mut joints[joint].friction[k];
            let has_coulomb = parameters.iter().any(|p| matches!(p.kind, Kind::Coulomb(_)));
            if !has_coulomb {
                continue;
            }
            let force = value / arm(friction, pitch);
            friction.load.preload =
                carried_preload(&mut friction.law, friction.backward.as_mut(), force);
        }
        for (parameter, &value) in parameters.iter().zip(values) {
            if let Kind::StaticExcess(i) = parameter.kind {
                let (joint, k) = interfaces[i];
                set_static_excess(&mut joints[joint].friction[k].law, value);
            }
        }
    })
}

/// Declares friction in an actuated joint that has none in the model.
fn declare(joint: &mut stiction_core::mechanism::Joint, dof: usize, is_coulomb: bool, value: f64) {
    let turns = joint.joint_type.dofs()[dof].motion == Motion::Rotation;
    if joint.friction.is_empty() {
        let law = Law::coulomb_viscous(0.0, 0.0);
        joint.friction.push(if turns {
            JointFriction::round(1.0, law)
        } else {
            JointFriction::guide(law)
        });
    }
    let friction = &mut joint.friction[0];
    if is_coulomb {
        friction.law.mu = CARRIER;
        friction.load.preload = value / CARRIER;
    } else {
        friction.law.viscous = value;
    }
}

fn arm(friction: &JointFriction, pitch: f64) -> f64 {
    // The lever arm of a screw thread is the path along the helix per radian.
    let radius = friction.radius.unwrap_or(1.0);
    if pitch != 0.0 { radius.hypot(pitch) } else { radius }
}
