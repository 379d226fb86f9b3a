//! Choice of the log columns that the identification uses: coordinates and efforts.

use super::IdentifyError as Error;
use super::prepare::MeasuredLog;
use crate::names::Names;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::kinematics::{Coordinate, Target, locks};
use stiction_core::mechanism::Mechanism;
use stiction_format::{LogRole, ModelFile};

pub(super) fn refuse(message: impl Into<String>, help: impl Into<String>) -> Error {
    Error { message: message.into(), help: help.into() }
}

/// One of the coordinates that determine the motion of the mechanism, with its columns in a log:
/// position, rate or both.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chosen {
    pub(super) coordinate: Coordinate,
    /// Index of the log column with the position of the coordinate, if the log has one.
    pub(super) position: Option<usize>,
    /// Index of the log column with the rate of the coordinate, if the log has one. The rate is
    /// used if there is no position column, and in tables of steady motions.
    pub(super) rate: Option<usize>,
    /// Value of the coordinate at the home position of the model, rad or m; used if the log has no
    /// position column.
    pub(super) home: f64,
}

impl Chosen {
    /// Returns the index of the position column, or of the rate column if there is no position
    /// column.
    pub(super) fn column(&self) -> usize {
        self.position.or(self.rate).unwrap_or(0)
    }
}

/// Chooses the coordinates that determine the motion, with their columns in the log. These are the
/// coordinates of all actuators or, if the log lacks one of them, as many of the logged coordinates
/// as there are actuators.
pub(super) fn chosen_coordinates(
    model: &ModelFile,
    log: &MeasuredLog,
) -> Result<Vec<Chosen>, Error> {
    let mechanism = &model.mechanism;
    let is_steady = log.log.is_steady;
    let mut measured: Vec<Chosen> = Vec::new();
    for (index, column) in log.log.columns.iter().enumerate() {
        let (coordinate, is_rate) = match column.role {
            LogRole::Coordinate(coordinate) => (coordinate, false),
            LogRole::Rate(coordinate) => (coordinate, true),
            _ => continue,
        };
        let place = measured.iter().position(|known| known.coordinate == coordinate);
        let place = place.unwrap_or_else(|| {
            measured.push(Chosen { coordinate, position: None, rate: None, home: 0.0 });
            measured.len() - 1
        });
        let slot = if is_rate { &mut measured[place].rate } else { &mut measured[place].position };
        *slot = Some(index);
    }
    measured.retain(|chosen| !is_steady || chosen.rate.is_some());
    let find =
        |wanted: &Coordinate| measured.iter().find(|chosen| chosen.coordinate == *wanted).copied();
    let actuated: Vec<_> =
        mechanism.actuators().map(|(joint, dof)| Coordinate::Joint { joint, dof }).collect();
    let by_actuators: Option<Vec<Chosen>> = actuated.iter().map(find).collect();
    let count = actuated.len();
    let mut chosen = match by_actuators.filter(|all| !all.is_empty()) {
        Some(all) => all,
        None if measured.len() < count || count == 0 => {
            let names: Vec<String> = mechanism
                .actuators()
                .map(|(j, dof)| mechanism.joints()[j.0].dof_name(dof))
                .collect();
            let (what, example) = match is_steady {
                true => ("rates", "the rates of the actuators, as `d(NAME)`"),
                false => ("coordinates", "the positions of the actuators"),
            };
            return Err(refuse(
                format!(
                    "{} measures {} independent {what}, but the mechanism has {count} actuators",
                    log.name,
                    measured.len()
                ),
                format!(
                    "log {example} ({}), or as many other independent {what}",
                    names.join(", ")
                ),
            ));
        }
        None => measured[..count].to_vec(),
    };
    if chosen.iter().any(|chosen| chosen.position.is_none()) {
        let homes = homes(model, log, &chosen)?;
        chosen.iter_mut().zip(homes).for_each(|(chosen, home)| chosen.home = home);
    }
    Ok(chosen)
}

/// Returns the values of the chosen coordinates at the home position of the model, rad or m; zero
/// for coordinates whose position is logged.
fn homes(model: &ModelFile, log: &MeasuredLog, chosen: &[Chosen]) -> Result<Vec<f64>, Error> {
    let mechanism = &model.mechanism;
    let fail = |error: &dyn std::fmt::Display| {
        refuse(
            format!("{}: the model has no position to integrate rates from: {error}", log.name),
            "log positions, or declare a position in the model with `home` or `start`",
        )
    };
    let open = locks(mechanism, &model.initial_poses, &[], &[]).map_err(|error| fail(&error))?;
    let (coordinates, targets): (Vec<Coordinate>, Vec<Target<f64>>) = open
        .into_iter()
        .map(|(coordinate, value)| (coordinate, Target { value, rate: 0.0, acceleration: 0.0 }))
        .unzip();
    let solver = InverseDynamics::new(
        mechanism.clone(),
        &model.initial_poses,
        &coordinates,
        &targets,
        Settings::default(),
    );
    let solver = solver.map_err(|error| fail(&error))?;
    let each = chosen.iter().map(|chosen| match (chosen.position, chosen.coordinate) {
        (Some(_), _) => Ok(0.0),
        (None, Coordinate::Joint { joint, dof }) => Ok(solver.joint_motion(joint, dof).value),
        (None, _) => Err(refuse(
            format!("{} has rates of a body without its position", log.name),
            "log positions, or rates of joints",
        )),
    });
    each.collect()
}

/// Log column that contains the effort of an actuator.
#[derive(Clone, Copy, Debug)]
pub(super) struct EffortColumn {
    /// Index of the column in the log.
    pub(super) column: usize,
    /// Factor that converts the values of the column to the effort at the joint, N or N m.
    pub(super) factor: f64,
    /// SI unit of the values of the column.
    pub(super) unit: &'static str,
    /// Index of the drive train if the column contains the current of its motor and the model lacks
    /// the torque constant. `factor` then assumes 1 N m/A.
    pub(super) unknown: Option<usize>,
}

/// Chooses the effort column of each actuator, in the order of the actuators. The second result is
/// true if the efforts are measured at the motors.
pub(super) fn chosen_efforts(
    mechanism: &Mechanism,
    log: &MeasuredLog,
) -> Result<(Vec<EffortColumn>, bool), Error> {
    let drives = Names::new(mechanism).drives;
    let count = drives.len();
    // A table that inverse dynamics has written contains the efforts of the joints and of their
    // motors. The efforts of the joints are then used.
    let (mut found, mut by_motors) = (vec![None; count], vec![None; count]);
    let mut twice = None;
    for (index, column) in log.log.columns.iter().enumerate() {
        let (train_index, per_torque) = match column.role {
            LogRole::Effort(actuator) => {
                let unit = drives[actuator].1;
                let own = EffortColumn { column: index, factor: 1.0, unit, unknown: None };
                found[actuator] = Some(own);
                continue;
            }
            LogRole::MotorTorque(train) => (train, Some(1.0)),
            LogRole::Current(train) => (train, mechanism.drive_trains()[train].torque_constant),
            _ => continue,
        };
        let train = &mechanism.drive_trains()[train_index];
        let [driven] = &train.dofs[..] else {
            return Err(refuse(
                format!("{}: the motor {} moves several joints together", log.name, train.name),
                "log the efforts of the joints as `JOINT.effort`",
            ));
        };
        let actuator = mechanism.actuators().position(|own| own == (driven.joint, driven.dof));
        if let Some(actuator) = actuator {
            let factor = per_torque.unwrap_or(1.0) * train.transmission();
            let unknown = per_torque.is_none().then_some(train_index);
            let unit = if matches!(column.role, LogRole::Current(_)) { "A" } else { "N m" };
            let own = EffortColumn { column: index, factor, unit, unknown };
            if let Some(EffortColumn { column: other, .. }) = by_motors[actuator] {
                twice = Some([other, index].map(|k: usize| &log.log.columns[k].name));
            }
            by_motors[actuator] = Some(own);
        }
    }
    let at_motors = by_motors.iter().any(Option::is_some);
    let is_by_motors = at_motors && found.iter().any(Option::is_none);
    if is_by_motors && found.iter().any(Option::is_some) {
        return Err(refuse(
            format!("{} has efforts of motors and of joints", log.name),
            "give all efforts as `JOINT.effort`, or all as `MOTOR.motor_torque` or `MOTOR.current`",
        ));
    }
    if let (true, Some([a, b])) = (is_by_motors, twice) {
        return Err(refuse(
            format!("{}: `{a}` and `{b}` are both the effort of one motor", log.name),
            format!("leave one of them out: `\"{b}\" = \"\"` below [columns] of the options"),
        ));
    }
    let found = if is_by_motors { by_motors } else { found };
    let missing = drives.iter().zip(&found).filter(|(_, found)| found.is_none());
    let missing: Vec<&(String, &str)> = missing.map(|(drive, _)| drive).collect();
    if let Some((first, unit)) = missing.first() {
        let names: Vec<&str> = missing.iter().map(|(name, _)| name.as_str()).collect();
        return Err(refuse(
            format!("{} has no effort of {}", log.name, names.join(", ")),
            format!(
                "add columns such as `{first}.effort [{unit}]`, or name them below [columns] of the options"
            ),
        ));
    }
    Ok((found.into_iter().flatten().collect(), is_by_motors))
}

/// Assembles the mechanism with the chosen coordinates at the values `at`, rad or m, at rest.
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
