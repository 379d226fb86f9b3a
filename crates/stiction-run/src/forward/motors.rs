//! Motors of the drive trains in a simulation.
//!
//! The effort of an actuator with a drive train is the torque of its motor times the transmission
//! ratio. The rotor, the friction of the motor and the loss of the gear belong to the mechanism on
//! which this effort acts.

use crate::error::Error;
use nalgebra::DMatrix;
use stiction_core::kinematics::{Bodies, Target};
use stiction_core::mechanism::{DriveTrain, GearInput, Mechanism, MotorMap, SharedMotors};

/// Drive trains, each with the actuators that it moves.
#[derive(Clone, Debug)]
pub(super) struct Motors {
    trains: Vec<(DriveTrain, MotorMap)>,
    /// Groups of motors that together drive fewer joints, each motor with a fixed share of the
    /// effort, and whose gears do not transmit efforts in the ratio of these shares.
    shared: Vec<SharedMotors>,
}

/// Motion at the output of a motor's gear, and of the body that carries the motor.
struct OutputMotion {
    /// Rate, rad/s or m/s; `None` at rest, where friction may act in either direction.
    rate: Option<f64>,
    acceleration: f64,
    /// Angular acceleration, about the axis of the rotor, of the body that carries the rotor,
    /// rad/s^2.
    carrier: f64,
}

impl Motors {
    pub(super) fn new(mechanism: &Mechanism) -> Self {
        let trains = mechanism.drive_trains().iter().cloned();
        let trains = trains.zip(mechanism.motor_maps()).collect();
        Self { trains, shared: mechanism.shared_motors() }
    }

    /// Returns the names of the table columns of all motors: torque, speed and, if the torque
    /// constant is known, current.
    pub(super) fn columns(&self) -> impl Iterator<Item = String> + '_ {
        self.trains.iter().flat_map(|(train, _)| {
            let name = &train.name;
            let current = train.torque_constant.map(|_| format!("{name}.current [A]"));
            [format!("{name}.motor_torque [N m]"), format!("{name}.motor_speed [rad/s]")]
                .into_iter()
                .chain(current)
        })
    }

    /// Returns the drive trains of the mechanism.
    pub(super) fn trains(&self) -> impl Iterator<Item = &DriveTrain> {
        self.trains.iter().map(|(train, _)| train)
    }

    /// Reads torque, N m, and speed, rad/s, of each motor from its columns in `row`.
    pub(super) fn read<'r>(
        &self,
        row: &'r [f64],
    ) -> impl Iterator<Item = (f64, f64)> + use<'_, 'r> {
        let mut at = 0;
        self.trains().map(move |train| {
            let first = at;
            at += 2 + usize::from(train.torque_constant.is_some());
            (row[first], row[first + 1])
        })
    }

    /// Appends the column values of all motors to `row`, in the order of [`Self::columns`].
    /// `efforts` contains the efforts of all actuators, N or N m; `rate` returns the rate of an
    /// actuator, m/s or rad/s.
    pub(super) fn write(&self, efforts: &[f64], rate: impl Fn(usize) -> f64, row: &mut Vec<f64>) {
        for (train, map) in &self.trains {
            let n = train.transmission();
            let torque = map.effort(efforts) / n;
            row.extend([torque, n * map.output(&rate)]);
            row.extend(train.torque_constant.map(|constant| torque / constant));
        }
    }

    /// Converts `efforts` from the efforts that a motion requires at the joints to those that the
    /// motors must exert. The motors also accelerate their rotors and, if `friction` is true,
    /// overcome the friction of motors and gears.
    ///
    /// # Errors
    /// [`Error::SharedMotors`] at `time`, s, if motors with torques in the ratio of their shares
    /// cannot exert these efforts.
    pub(super) fn add(
        &self,
        time: f64,
        efforts: &mut [f64],
        (motion, bodies): (&[Target<f64>], &Bodies<f64>),
        friction: bool,
    ) -> Result<(), Error> {
        let joints = efforts.to_vec();
        for (train, map) in &self.trains {
            let OutputMotion { rate, acceleration, carrier } =
                output_motion((train, map), motion, bodies);
            let effort = map.effort(&joints);
            let bounds = (effort, effort);
            let motor = match friction {
                true => train.motor(effort, bounds, rate, acceleration, carrier),
                false => {
                    let ideal = train.without_friction();
                    ideal.motor(effort, bounds, rate, acceleration, carrier)
                }
            };
            let more = train.transmission() * motor.torque - effort;
            map.terms.iter().for_each(|term| efforts[term.actuator] += term.part * more);
        }
        // Without friction, the distribution of an effort among several motors has no effect on
        // their sum, so no correction is necessary.
        for shared in self.shared.iter().filter(|_| friction) {
            let input = |&k: &usize| -> GearInput {
                let (train, map) = &self.trains[k];
                let OutputMotion { rate, acceleration, carrier } =
                    output_motion((train, map), motion, bodies);
                train.gear_input(rate, acceleration, carrier)
            };
            let inputs: Vec<GearInput> = shared.trains.iter().map(input).collect();
            let outputs: Vec<f64> = shared.actuators.iter().map(|&k| joints[k]).collect();
            let found = shared
                .efforts(&inputs, &outputs)
                .ok_or_else(|| Error::SharedMotors { time, motors: self.names(shared) })?;
            shared.actuators.iter().zip(found).for_each(|(&k, effort)| efforts[k] = effort);
        }
        Ok(())
    }

    /// Widens the ranges of efforts that hold joints at rest by the friction of the motors and the
    /// losses of the gears.
    ///
    /// # Errors
    /// [`Error::SharedHolding`] if motors with losses share the efforts of several joints, or if
    /// one of their gears may jam.
    pub(super) fn widen(&self, low: &mut [f64], high: &mut [f64]) -> Result<(), Error> {
        let joints: Vec<(f64, f64)> = low.iter().copied().zip(high.iter().copied()).collect();
        for (train, map) in &self.trains {
            let bounds = map.effort_bounds(&joints);
            let motor = train.motor(0.5 * (bounds.0 + bounds.1), bounds, None, 0.0, 0.0);
            let n = train.transmission();
            let (a, b) = (n * motor.torque_bounds.0, n * motor.torque_bounds.1);
            let (lower, upper) = (a.min(b) - bounds.0, a.max(b) - bounds.1);
            for term in &map.terms {
                let (a, b) = (term.part * lower, term.part * upper);
                low[term.actuator] += a.min(b);
                high[term.actuator] += a.max(b);
            }
        }
        let trains: Vec<DriveTrain> = self.trains().cloned().collect();
        for shared in &self.shared {
            let range = match shared.actuators[..] {
                [actuator] if !shared.may_jam(&trains) => {
                    shared.holding(&trains, joints[actuator]).map(|range| (actuator, range))
                }
                _ => None,
            };
            let Some((actuator, range)) = range else {
                return Err(Error::SharedHolding { motors: self.names(shared) });
            };
            (low[actuator], high[actuator]) = range;
        }
        Ok(())
    }

    fn names(&self, shared: &SharedMotors) -> String {
        let names = shared.trains.iter().map(|&k| format!("`{}`", self.trains[k].0.name));
        names.collect::<Vec<_>>().join(", ")
    }

    /// Adds the reflected inertia of the rotors to the mass matrix of the actuators, kg or kg m^2.
    pub(super) fn add_inertia(&self, masses: &mut DMatrix<f64>) {
        for (train, map) in &self.trains {
            for (a, b) in map.terms.iter().flat_map(|a| map.terms.iter().map(move |b| (a, b))) {
                masses[(a.actuator, b.actuator)] += a.part * b.part * train.reflected_inertia();
            }
        }
    }
}

fn output_motion(
    (train, map): (&DriveTrain, &MotorMap),
    motion: &[Target<f64>],
    bodies: &Bodies<f64>,
) -> OutputMotion {
    let rate = map.output(|actuator| motion[actuator].rate);
    OutputMotion {
        rate: (rate != 0.0).then_some(rate),
        acceleration: map.output(|actuator| motion[actuator].acceleration),
        carrier: train.acceleration_of_carrier(&bodies.pose, &bodies.acceleration),
    }
}
