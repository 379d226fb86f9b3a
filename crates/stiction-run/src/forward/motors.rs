//! Motors of the drive trains in a simulation.
//!
//! The effort of an actuator with a drive train is the torque of its motor times the transmission: rotor and
//! friction of the motor are part of the mechanism that it moves.

use crate::power_off::actuators_of;
use stiction_core::kinematics::Target;
use stiction_core::mechanism::{DriveTrain, Mechanism};

/// Drive trains, each with its actuator.
#[derive(Clone, Debug)]
pub(super) struct Motors {
    trains: Vec<(DriveTrain, usize)>,
}

impl Motors {
    pub(super) fn new(mechanism: &Mechanism) -> Self {
        let trains = mechanism.drive_trains().iter().cloned();
        Self { trains: trains.zip(actuators_of(mechanism)).collect() }
    }

    /// Columns of the motors.
    pub(super) fn columns(&self) -> impl Iterator<Item = String> + '_ {
        self.trains.iter().flat_map(|(train, _)| {
            let name = &train.name;
            let current = train.torque_constant.map(|_| format!("{name}.current [A]"));
            [format!("{name}.motor_torque [N m]"), format!("{name}.motor_speed [rad/s]")]
                .into_iter()
                .chain(current)
        })
    }

    /// Writes the row of the motors; `rate` is that of an actuator, m/s or rad/s.
    pub(super) fn write(&self, efforts: &[f64], rate: impl Fn(usize) -> f64, row: &mut Vec<f64>) {
        for (train, actuator) in &self.trains {
            let n = train.transmission();
            let torque = train.share * efforts[*actuator] / n;
            row.extend([torque, n * rate(*actuator)]);
            row.extend(train.torque_constant.map(|constant| torque / constant));
        }
    }

    /// Adds to the efforts that joints need for a motion what their motors need in addition: to accelerate
    /// their rotors and, if `friction`, to overcome their friction.
    pub(super) fn add(&self, efforts: &mut [f64], motion: &[Target<f64>], friction: bool) {
        for (train, actuator) in &self.trains {
            let Target { rate, acceleration, .. } = motion[*actuator];
            let motor = match friction {
                true => train.motor(0.0, (0.0, 0.0), Some(rate), acceleration),
                false => train.without_friction().motor(0.0, (0.0, 0.0), Some(rate), acceleration),
            };
            efforts[*actuator] += train.transmission() * motor.torque;
        }
    }

    /// Adds the reflected inertia of the rotors to the effective masses of the actuators, kg or kg m^2.
    pub(super) fn add_inertia(&self, masses: &mut [f64]) {
        for (train, actuator) in &self.trains {
            masses[*actuator] += train.reflected_inertia();
        }
    }
}
