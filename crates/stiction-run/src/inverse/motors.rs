//! Computation of the state of all motors at one instant: torque, speed and powers.

use stiction_core::dynamics::FrictionMode;
use stiction_core::kinematics::{Bodies, Target};
use stiction_core::mechanism::{DriveTrain, Mechanism, Motor, MotorMap};

/// Evaluation of the motors of all drive trains from the efforts of the actuators, instant by instant.
#[derive(Clone, Debug)]
pub struct Motors {
    trains: Vec<Train>,
}

#[derive(Clone, Debug)]
struct Train {
    train: DriveTrain,
    map: MotorMap,
    /// Rate below which the output of the drive train counts as being at rest, m/s or rad/s.
    rest_rate: f64,
}

impl Motors {
    /// Creates the evaluation. `rest_rate` is the rate of an actuator, m/s or rad/s, below which its joint counts as
    /// resting. Without friction, motors and gears have no losses.
    pub fn new(
        mechanism: &Mechanism,
        friction: FrictionMode,
        rest_rate: impl Fn(usize) -> f64,
    ) -> Self {
        let trains = mechanism.drive_trains().iter().zip(mechanism.motor_maps());
        let train = |(train, map): (&DriveTrain, MotorMap)| Train {
            train: match friction {
                FrictionMode::Off => train.without_friction(),
                _ => train.clone(),
            },
            rest_rate: map.most(&rest_rate),
            map,
        };
        Self { trains: trains.map(train).collect() }
    }

    /// Evaluates the motors, in the order of the drive trains, from the efforts, N or N m, and the motions of the
    /// actuators, and from the motion of the bodies. `bounds` are the intervals of the efforts; without them each
    /// interval contains only its effort.
    pub fn evaluate<'a>(
        &'a self,
        efforts: &'a [f64],
        bounds: Option<&'a [(f64, f64)]>,
        motion: impl Fn(usize) -> Target<f64> + 'a,
        bodies: &'a Bodies<f64>,
    ) -> impl Iterator<Item = Motor> + 'a {
        self.trains.iter().map(move |each| {
            let rate = each.map.output(|actuator| motion(actuator).rate);
            let rate = Some(rate).filter(|rate| rate.abs() > each.rest_rate);
            let acceleration = each.map.output(|actuator| motion(actuator).acceleration);
            let effort = each.map.effort(efforts);
            let bounds = bounds.map_or((effort, effort), |bounds| each.map.effort_bounds(bounds));
            let carrier = each.train.acceleration_of_carrier(&bodies.pose, &bodies.acceleration);
            each.train.motor(effort, bounds, rate, acceleration, carrier)
        })
    }
}
