//! Columns of a log that the identification uses.

use super::IdentifyError as Error;
use super::prepare::MeasuredLog;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::Mechanism;
use stiction_format::{LogRole, ModelFile};

pub(super) fn refuse(message: impl Into<String>, help: impl Into<String>) -> Error {
    Error { message: message.into(), help: help.into() }
}

/// Coordinates that move the mechanism, and their columns in the log.
pub(super) fn chosen_coordinates(
    model: &ModelFile,
    log: &MeasuredLog,
) -> Result<Vec<(Coordinate, usize)>, Error> {
    let mechanism = &model.mechanism;
    let measured: Vec<(Coordinate, usize)> = log
        .log
        .columns
        .iter()
        .enumerate()
        .filter_map(|(index, column)| match column.role {
            LogRole::Coordinate(coordinate) => Some((coordinate, index)),
            _ => None,
        })
        .collect();
    let find = |wanted: &Coordinate| measured.iter().find(|(c, _)| c == wanted).copied();
    let actuated: Vec<_> =
        mechanism.actuators().map(|(joint, dof)| Coordinate::Joint { joint, dof }).collect();
    let by_actuators: Option<Vec<_>> = actuated.iter().map(find).collect();
    if let Some(all) = by_actuators.filter(|all| !all.is_empty()) {
        return Ok(all);
    }
    let count = actuated.len();
    if measured.len() < count || count == 0 {
        let names: Vec<String> =
            mechanism.actuators().map(|(j, dof)| mechanism.joints()[j.0].dof_name(dof)).collect();
        return Err(refuse(
            format!(
                "{} measures {} coordinates, but the mechanism has {count} actuators",
                log.name,
                measured.len()
            ),
            format!("log the positions of the actuators ({}), or as many others", names.join(", ")),
        ));
    }
    Ok(measured[..count].to_vec())
}

/// Columns of efforts in the order of the actuators, each with its factor to the effort at the joint, and
/// whether they are measured at motors.
pub(super) fn chosen_efforts(
    mechanism: &Mechanism,
    log: &MeasuredLog,
) -> Result<(Vec<(usize, f64)>, bool), Error> {
    let mut found = vec![None; mechanism.actuators().count()];
    let (mut at_motors, mut at_joints) = (false, false);
    for (index, column) in log.log.columns.iter().enumerate() {
        let (train, per_torque) = match column.role {
            LogRole::Effort(actuator) => {
                at_joints = true;
                found[actuator] = Some((index, 1.0));
                continue;
            }
            LogRole::MotorTorque(train) => (&mechanism.drive_trains()[train], 1.0),
            LogRole::Current(train) => {
                let train = &mechanism.drive_trains()[train];
                let Some(constant) = train.torque_constant else {
                    return Err(refuse(
                        format!(
                            "{}: the current of {} needs its torque constant",
                            log.name, train.name
                        ),
                        format!("add `torque_constant` to [actuators.{}] of the model", train.name),
                    ));
                };
                (train, constant)
            }
            _ => continue,
        };
        let [driven] = &train.dofs[..] else {
            return Err(refuse(
                format!("{}: the motor {} moves several joints together", log.name, train.name),
                "log the efforts of the joints as `JOINT.effort`",
            ));
        };
        let actuator = mechanism.actuators().position(|own| own == (driven.joint, driven.dof));
        if let Some(actuator) = actuator {
            at_motors = true;
            found[actuator] = Some((index, per_torque * train.transmission()));
        }
    }
    if at_motors && at_joints {
        return Err(refuse(
            format!("{} has efforts of motors and of joints", log.name),
            "give all efforts as `JOINT.effort`, or all as `MOTOR.motor_torque` or `MOTOR.current`",
        ));
    }
    let names = mechanism.actuators().map(|(j, dof)| mechanism.joints()[j.0].actuator_name(dof));
    let missing: Vec<String> =
        names.zip(&found).filter(|(_, found)| found.is_none()).map(|(name, _)| name).collect();
    if !missing.is_empty() {
        return Err(refuse(
            format!("{} has no effort of {}", log.name, missing.join(", ")),
            format!(
                "add columns such as `{}.effort [N]`, or name them below [columns] of the options",
                missing[0]
            ),
        ));
    }
    Ok((found.into_iter().flatten().collect(), at_motors))
}

/// Assembles the mechanism at positions.
pub(super) fn assembled(
    model: &ModelFile,
    log: &MeasuredLog,
    coordinates: &[Coordinate],
    at: &[f64],
) -> Result<InverseDynamics, Error> {
    let targets: Vec<Target<f64>> =
        at.iter().map(|&value| Target { value, rate: 0.0, acceleration: 0.0 }).collect();
    let mechanism = model.mechanism.clone();
    let solver = InverseDynamics::new(
        mechanism,
        &model.initial_poses,
        coordinates,
        &targets,
        Settings::default(),
    );
    solver.map_err(|error| {
        refuse(
            format!(
                "{}: the mechanism cannot be assembled at the first position: {error}",
                log.name
            ),
            "check units, signs and offsets of the positions, and `home` or `start` in the model",
        )
    })
}
