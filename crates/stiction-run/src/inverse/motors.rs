//! Motors of the drive trains at each sample.

use crate::dofs::{actuated, dofs_of};
use crate::job::Job;
use crate::power_off::actuators_of;
use stiction_core::dynamics::{Forces, FrictionMode};
use stiction_core::kinematics::Target;
use stiction_core::mechanism::{DriveTrain, Motor};

/// Evaluation of all drive trains, sample by sample.
pub(super) struct Motors {
    trains: Vec<Train>,
}

struct Train {
    train: DriveTrain,
    actuator: usize,
    /// Index among the scalar degrees of freedom of all joints.
    dof: usize,
    /// Rate below which the joint is at rest, m/s or rad/s.
    rest_rate: f64,
}

impl Motors {
    /// Evaluation with the rates of all actuators below which their joints are at rest, m/s or rad/s.
    pub(super) fn new(job: &Job<'_>, rest_rates: Vec<f64>) -> Self {
        let mechanism = &job.model.mechanism;
        let dofs = actuated(&dofs_of(mechanism));
        let trains = mechanism.drive_trains().iter().zip(actuators_of(mechanism));
        let train = |(train, actuator): (&DriveTrain, usize)| Train {
            train: match job.friction {
                FrictionMode::Off => train.without_friction(),
                _ => train.clone(),
            },
            actuator,
            dof: dofs[actuator],
            rest_rate: rest_rates.get(actuator).copied().unwrap_or_default(),
        };
        Self { trains: trains.map(train).collect() }
    }

    /// Motors for these forces and this motion of the joints.
    pub(super) fn evaluate(
        &self,
        forces: &Forces,
        joints: &[Target<f64>],
        motors: &mut Vec<Motor>,
    ) {
        motors.clear();
        motors.extend(self.trains.iter().map(|each| {
            let motion = &joints[each.dof];
            let rate = Some(motion.rate).filter(|rate| rate.abs() > each.rest_rate);
            let (effort, bounds) =
                (forces.efforts[each.actuator], forces.effort_bounds[each.actuator]);
            each.train.motor(effort, bounds, rate, motion.acceleration)
        }));
    }
}
