//! Computation of the state of all motors at each sample: torque, speed and powers.

use crate::dofs::{actuated, dofs_of};
use crate::job::Job;
use stiction_core::dynamics::{Forces, FrictionMode};
use stiction_core::kinematics::{Bodies, Target};
use stiction_core::mechanism::{DriveTrain, Motor, MotorMap};

/// Evaluation of all drive trains, sample by sample.
pub(super) struct Motors {
    trains: Vec<Train>,
    /// For each actuator, the index of the actuated degree of freedom in the list of the scalar
    /// degrees of freedom of all joints.
    dofs: Vec<usize>,
}

struct Train {
    train: DriveTrain,
    map: MotorMap,
    /// Rate below which the output of the drive train counts as being at rest, m/s or rad/s.
    rest_rate: f64,
}

impl Motors {
    /// Creates the evaluation of the drive trains of a job. `rest_rates` contains, for each
    /// actuator, the rate below which its joint counts as being at rest, m/s or rad/s.
    pub(super) fn new(job: &Job<'_>, rest_rates: Vec<f64>) -> Self {
        let mechanism = &job.model.mechanism;
        let dofs = actuated(&dofs_of(mechanism));
        let trains = mechanism.drive_trains().iter().zip(mechanism.motor_maps());
        let train = |(train, map): (&DriveTrain, MotorMap)| Train {
            train: match job.friction {
                FrictionMode::Off => train.without_friction(),
                _ => train.clone(),
            },
            rest_rate: map.most(|actuator| rest_rates.get(actuator).copied().unwrap_or_default()),
            map,
        };
        Self { trains: trains.map(train).collect(), dofs }
    }

    /// Evaluates the motors for given forces and for the motion of joints and bodies; `motors`
    /// receives one result for each drive train.
    pub(super) fn evaluate(
        &self,
        forces: &Forces,
        (joints, bodies): (&[Target<f64>], &Bodies<f64>),
        motors: &mut Vec<Motor>,
    ) {
        motors.clear();
        motors.extend(self.trains.iter().map(|each| {
            let motion = |actuator: usize| &joints[self.dofs[actuator]];
            let rate = each.map.output(|actuator| motion(actuator).rate);
            let rate = Some(rate).filter(|rate| rate.abs() > each.rest_rate);
            let acceleration = each.map.output(|actuator| motion(actuator).acceleration);
            let effort = each.map.effort(&forces.efforts);
            let bounds = each.map.effort_bounds(&forces.effort_bounds);
            let carrier = each.train.acceleration_of_carrier(&bodies.pose, &bodies.acceleration);
            each.train.motor(effort, bounds, rate, acceleration, carrier)
        }));
    }
}
