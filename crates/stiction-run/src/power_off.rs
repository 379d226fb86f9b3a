//! Holding of a pose while the motors have no power: by friction of joints, motors and gears, or by brakes.

use serde_json::{Value, json};
use std::fmt::{self, Write};
use stiction_core::dynamics::Forces;
use stiction_core::mechanism::{DriveTrain, Motor, MotorMap, SharedMotors};
use stiction_core::spatial::Vec3;
use stiction_draw::numbers::number;

/// An effort up to this fraction of the largest joint force or moment counts as a rounding error.
const ROUNDING: f64 = 1e-13;

/// Result for the shaft of one motor at rest with power off: what holds the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PowerOff {
    /// Friction holds the shaft.
    Held,
    /// Neither a load nor friction acts on the shaft.
    Unloaded,
    /// A brake on the shaft of the motor is needed, with at least this torque, N m.
    Brake(f64),
    /// Static friction can hold the shaft, but perhaps not while it also holds the shafts of all
    /// other motors.
    Undecided,
}

/// Determines for each drive train what holds its motor with power off. `forces` are the forces of
/// the mechanism at rest.
pub(crate) fn of(
    (trains, maps, shared): (&[DriveTrain], &[MotorMap], &[SharedMotors]),
    forces: &Forces,
) -> Vec<PowerOff> {
    let largest = |size: fn(&(Vec3<f64>, Vec3<f64>)) -> f64| {
        forces.reactions.iter().map(size).fold(0.0, f64::max)
    };
    let rounding = [largest(|(force, _)| force.norm()), largest(|(_, moment)| moment.norm())];
    let error = |train: &DriveTrain| ROUNDING * rounding[usize::from(!train.translates())];
    let each = trains.iter().zip(maps).map(|(train, map)| {
        let effort = map.effort(&forces.efforts);
        let at = |bounds| train.motor(effort, bounds, None, 0.0, 0.0);
        let bounds = map.effort_bounds(&forces.effort_bounds);
        let error = error(train);
        let holds = |(low, high)| at((low - error, high + error)).holds_without_power();
        if !holds(bounds) {
            let (low, high) = at(bounds).torque_bounds;
            PowerOff::Brake(low.abs().min(high.abs()))
        } else if is_nothing(at(bounds), error / train.transmission().abs()) {
            PowerOff::Unloaded
        } else if holds((effort, effort)) || forces.efforts.len() == 1 {
            // Either friction of motor and gear holds the shaft without the help of joint friction,
            // which is possible for all motors at the same time, or there is only one actuator.
            PowerOff::Held
        } else {
            PowerOff::Undecided
        }
    });
    let mut found: Vec<PowerOff> = each.collect();
    // If several motors share one degree of freedom, the gear with the greatest holding effort may
    // hold the degree of freedom for all of them.
    for shared in shared {
        let [actuator] = shared.actuators[..] else { continue };
        let (effort, bounds) = (forces.efforts[actuator], forces.effort_bounds[actuator]);
        let error = shared.trains.iter().map(|&k| error(&trains[k])).fold(0.0, f64::max);
        let range = |(low, high)| shared.holding(trains, (low - error, high + error));
        let Some((low, high)) = range(bounds) else { continue };
        let brake = if low > 0.0 { low } else { (-high).max(0.0) };
        let certain = range((effort, effort)).is_some_and(|(low, high)| low <= 0.0 && high >= 0.0);
        for &k in &shared.trains {
            if found[k] == PowerOff::Unloaded {
                continue;
            }
            found[k] = if brake > 0.0 {
                PowerOff::Brake(brake * trains[k].share / trains[k].transmission().abs())
            } else if certain || forces.efforts.len() == 1 {
                PowerOff::Held
            } else {
                PowerOff::Undecided
            };
        }
    }
    found
}

/// Returns true if no torque acts on the motor at rest, apart from rounding errors.
fn is_nothing(motor: Motor, error: f64) -> bool {
    let (low, high) = motor.torque_bounds;
    low.abs().max(high.abs()) <= error
}

impl PowerOff {
    pub(crate) fn json(&self) -> Value {
        match self {
            Self::Held | Self::Unloaded => json!({ "held": true, "brake_torque": 0.0 }),
            Self::Brake(torque) => json!({ "held": false, "brake_torque": torque }),
            Self::Undecided => json!({ "held": null, "brake_torque": null }),
        }
    }
}

pub(crate) fn write(
    out: &mut impl Write,
    trains: &[DriveTrain],
    found: &[PowerOff],
) -> fmt::Result {
    for (train, found) in trains.iter().zip(found) {
        match found {
            PowerOff::Held => writeln!(out, "  {} is held by friction", train.name)?,
            PowerOff::Unloaded => writeln!(out, "  {} carries no load in this pose", train.name)?,
            PowerOff::Brake(torque) => writeln!(
                out,
                "  {} needs a brake of at least {} N m on the motor's shaft",
                train.name,
                number(*torque)
            )?,
            PowerOff::Undecided => writeln!(
                out,
                "  {} is held if the static friction of the joints need not hold other motors as \
                 well",
                train.name
            )?,
        }
    }
    Ok(())
}
