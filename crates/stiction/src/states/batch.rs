//! Computations on batches of robot states: inverse dynamics, body motion, Jacobians and mass
//! matrices.

use super::States;
use super::derivatives::Derivatives;
use super::rows::{Row, Workers};
use crate::error::Error;
use stiction_core::dynamics::{Data, FrictionMode, Status};
use stiction_core::kinematics::{Bodies, Target};
use stiction_core::spatial::Quaternion;

/// Coordinates, rates and accelerations of many states. Each array has rows x coordinates, stored
/// row by row.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// Coordinates, m or rad.
    pub q: &'a [f64],
    /// Rates, m/s or rad/s; empty if all rates are zero.
    pub v: &'a [f64],
    /// Accelerations, m/s² or rad/s²; empty if all accelerations are zero.
    pub a: &'a [f64],
}

/// Outcome and computed values of each row of a batch. The values are NaN in rows that did not
/// converge.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Outcome of each row.
    pub status: Vec<Status>,
    /// Computed values, row by row.
    pub values: Vec<f64>,
}

/// Optional results of [`States::inverse_dynamics`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// Computes the reactions of all joints.
    pub reactions: bool,
    /// Computes the speed, normal load, force and power of all friction interfaces.
    pub frictions: bool,
    /// Computes the torque and the speed of the motors of all drive trains.
    pub motors: bool,
    /// Computes the derivatives of the efforts with respect to coordinates, rates and
    /// accelerations.
    pub derivatives: bool,
}

/// Results of inverse dynamics, stored row by row. The values are NaN in rows that did not
/// converge.
#[derive(Clone, Debug, Default)]
pub struct InverseRows {
    /// Outcome of each row.
    pub status: Vec<Status>,
    /// Efforts, N or N m: rows x actuators.
    pub efforts: Vec<f64>,
    /// Efforts without friction, N or N m: rows x actuators.
    pub efforts_frictionless: Vec<f64>,
    /// Force, N, and moment about the joint's origin, N m, world axes: rows x joints x 6; empty unless requested.
    pub reactions: Vec<f64>,
    /// Sliding speed, m/s, normal load, N, friction force, N, dissipated power, W: rows x interfaces x 4; empty
    /// unless requested.
    pub frictions: Vec<f64>,
    /// Torques of the motors, N m: rows x drive trains; empty unless requested. They include the inertia of the rotor
    /// and, unless friction is off or the output is at rest, the friction of the motor and the losses of the gear.
    pub motor_torques: Vec<f64>,
    /// Speeds of the motors, rad/s: rows x drive trains; empty unless requested.
    pub motor_speeds: Vec<f64>,
    /// Residual of the power balance, W, of each row.
    pub power_residual: Vec<f64>,
    /// Derivatives of the efforts; `None` unless requested.
    pub derivatives: Option<Derivatives>,
}

/// Motion of all bodies, stored row by row. The values are NaN in rows that did not converge.
#[derive(Clone, Debug, Default)]
pub struct MotionRows {
    /// Outcome of each row.
    pub status: Vec<Status>,
    /// Position of the body's origin, m, world axes: rows x bodies x 3.
    pub positions: Vec<f64>,
    /// Orientation as a unit quaternion w, x, y, z with w >= 0: rows x bodies x 4.
    pub quaternions: Vec<f64>,
    /// Velocity of the body's origin, m/s, and angular velocity, rad/s, world axes: rows x bodies x 6.
    pub twists: Vec<f64>,
    /// Acceleration of the body's origin, m/s², and angular acceleration, rad/s², world axes: rows x bodies x 6.
    pub accelerations: Vec<f64>,
}

impl States {
    /// Number of rows of a batch.
    ///
    /// # Errors
    /// The robot has no coordinates, the length of `q` is not a whole number of rows, or another
    /// array is neither empty nor as long as `q`.
    fn rows_of(&self, batch: Batch<'_>) -> Result<usize, Error> {
        let count = self.home.len();
        let shape = |array: &str, length: usize| {
            Error::input(format!(
                "`{array}` has {length} numbers, but must have {count} in each row, one for each of {}",
                self.coordinates.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ")
            ))
        };
        if count == 0 {
            return Err(Error::input("the robot has no actuators, so a state has no coordinates")
                .with_help("give the names of coordinates, for example those of joints")
                .with_option("coordinates"));
        }
        if !batch.q.len().is_multiple_of(count) {
            return Err(shape("q", batch.q.len()));
        }
        for (name, array) in [("v", batch.v), ("a", batch.a)] {
            if !array.is_empty() && array.len() != batch.q.len() {
                return Err(shape(name, array.len()).with_help("give it the shape of `q`"));
            }
        }
        Ok(batch.q.len() / count)
    }

    /// Computes inverse dynamics of all rows.
    ///
    /// ```
    /// use stiction::{Batch, Outputs, Robot, Workers};
    ///
    /// let states = Robot::builtin("five-bar")?.states().compile()?;
    /// let batch = Batch { q: states.home(), v: &[0.1, 0.1], a: &[] };
    /// let wanted = Outputs { derivatives: true, ..Outputs::default() };
    /// let rows = states.inverse_dynamics(batch, wanted, &Workers::default())?;
    /// assert!(rows.status[0].is_converged());
    /// println!("{:?} N m, by rates {:?}", rows.efforts, rows.derivatives.unwrap().by_rate);
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// The lengths of the arrays do not agree, the robot has no derivatives, or the computation was stopped. A row
    /// without a solution is no error: see [`InverseRows::status`].
    pub fn inverse_dynamics(
        &self,
        batch: Batch<'_>,
        outputs: Outputs,
        workers: &Workers<'_>,
    ) -> Result<InverseRows, Error> {
        self.rows_of(batch)?;
        let Outputs { reactions, frictions, motors, derivatives } = outputs;
        let recorded = derivatives.then(|| self.recorded_derivatives()).transpose()?;
        let mechanism = self.model.mechanism();
        let (actuators, joints) = (mechanism.actuators().count(), mechanism.joints().len());
        let interfaces = self.model.parameters().interfaces.len();
        let trains = if motors { mechanism.drive_trains().len() } else { 0 };
        let slopes = if derivatives { actuators * self.home.len() } else { 0 };
        let widths = [
            actuators,
            actuators,
            if reactions { 6 * joints } else { 0 },
            if frictions { 4 * interfaces } else { 0 },
            trains,
            trains,
            1,
            slopes,
            slopes,
            slopes,
        ];
        let rest = vec![0.0; self.home.len()];
        let compute = |data: &mut Data<f64>, row: &mut Row<'_, '_>| {
            let (q, v, a) = self.row_of(batch, row.index, &rest);
            let status = self.model.inverse_dynamics(data, q, v, a, &self.loads);
            if !status.is_converged() {
                return status;
            }
            row.of(0).copy_from_slice(data.efforts());
            row.of(1).copy_from_slice(data.efforts_frictionless());
            if reactions {
                for (joint, out) in row.of(2).chunks_exact_mut(6).enumerate() {
                    let (force, moment) = data.reaction(joint);
                    out[..3].copy_from_slice(&force.to_array());
                    out[3..].copy_from_slice(&moment.to_array());
                }
            }
            if frictions {
                for (state, out) in data.friction().iter().zip(row.of(3).chunks_exact_mut(4)) {
                    let numbers = [state.velocity, state.load, state.friction, state.power];
                    out.copy_from_slice(&numbers);
                }
            }
            if motors {
                self.write_motors(data, row.several(4));
            }
            row.of(6)[0] = data.power().residual();
            if let Some(recorded) = recorded {
                let values = q.iter().zip(v).zip(a);
                let targets: Vec<Target<f64>> = values
                    .map(|((&value, &rate), &acceleration)| Target { value, rate, acceleration })
                    .collect();
                recorded.write(data, &targets, &self.loads, row.several(7));
            }
            status
        };
        let (status, arrays) = self.each_row(batch.q, &widths, workers, compute)?;
        let mut arrays = arrays.into_iter();
        let mut next = || arrays.next().unwrap_or_default();
        let results = InverseRows {
            status,
            efforts: next(),
            efforts_frictionless: next(),
            reactions: next(),
            frictions: next(),
            motor_torques: next(),
            motor_speeds: next(),
            power_residual: next(),
            derivatives: None,
        };
        let derivatives =
            derivatives.then(|| Derivatives::new([next(), next(), next()], results.status.len()));
        Ok(InverseRows { derivatives, ..results })
    }

    /// Writes torques and speeds of all motors in a state whose forces have been computed.
    fn write_motors(&self, data: &Data<f64>, [torques, speeds]: [&mut [f64]; 2]) {
        let bodies = &data.kinematics.bodies;
        let (topology, parameters) = (self.model.topology(), self.model.parameters());
        let motion = |actuator: usize| {
            bodies.joint_motion(topology, parameters, self.actuators[actuator], 0.0)
        };
        let motors = self.motors.evaluate(data.efforts(), None, motion, bodies);
        for ((motor, torque), speed) in motors.zip(torques).zip(speeds) {
            (*torque, *speed) = (motor.torque, motor.speed);
        }
    }

    /// Coordinates, rates and accelerations of the row `index`; `rest`, a row of zeros, replaces an
    /// empty array.
    fn row_of<'b>(
        &self,
        batch: Batch<'b>,
        index: usize,
        rest: &'b [f64],
    ) -> (&'b [f64], &'b [f64], &'b [f64]) {
        let of = |array: &'b [f64]| match array.is_empty() {
            true => rest,
            false => &array[index * rest.len()..][..rest.len()],
        };
        (of(batch.q), of(batch.v), of(batch.a))
    }

    /// Computes the motion of all bodies in all rows; the first body is the ground.
    ///
    /// # Errors
    /// See [`Self::inverse_dynamics`].
    pub fn kinematics(&self, batch: Batch<'_>, workers: &Workers<'_>) -> Result<MotionRows, Error> {
        self.rows_of(batch)?;
        let bodies = self.model.mechanism().bodies().len();
        let origin = self.model.parameters().origin;
        let rest = vec![0.0; self.home.len()];
        let compute = |data: &mut Data<f64>, row: &mut Row<'_, '_>| {
            let (q, v, a) = self.row_of(batch, row.index, &rest);
            let status = self.model.move_to(data, q, v, a);
            if !status.is_converged() {
                return status;
            }
            let all: &Bodies<f64> = &data.kinematics.bodies;
            for body in 0..bodies {
                let (pose, twist) = (all.pose[body], all.twist[body]);
                let at = pose.position;
                row.of(0)[3 * body..][..3].copy_from_slice(&(at + origin).to_array());
                Quaternion::from_rotation(pose.rotation).write(&mut row.of(1)[4 * body..][..4]);
                let velocity = twist.velocity_at(at);
                let change = all.acceleration[body];
                let acceleration = change.velocity_at(at) + twist.angular.cross(velocity);
                for (array, linear, angular) in
                    [(2, velocity, twist.angular), (3, acceleration, change.angular)]
                {
                    let out = &mut row.of(array)[6 * body..][..6];
                    out[..3].copy_from_slice(&linear.to_array());
                    out[3..].copy_from_slice(&angular.to_array());
                }
            }
            status
        };
        let widths = [3, 4, 6, 6].map(|width| width * bodies);
        let (status, arrays) = self.each_row(batch.q, &widths, workers, compute)?;
        let mut arrays = arrays.into_iter();
        let mut next = || arrays.next().unwrap_or_default();
        Ok(MotionRows {
            status,
            positions: next(),
            quaternions: next(),
            twists: next(),
            accelerations: next(),
        })
    }

    /// Computes the Jacobians of all bodies, of shape rows x bodies x 6 x coordinates. The six
    /// components are the velocity of the body's origin and its angular velocity, along world axes,
    /// for a unit rate of each coordinate.
    ///
    /// # Errors
    /// See [`Self::inverse_dynamics`].
    pub fn jacobian(&self, q: &[f64], workers: &Workers<'_>) -> Result<Rows, Error> {
        let batch = Batch { q, v: &[], a: &[] };
        self.rows_of(batch)?;
        let (bodies, count) = (self.model.mechanism().bodies().len(), self.home.len());
        let rest = vec![0.0; count];
        let compute = |data: &mut Data<f64>, row: &mut Row<'_, '_>| {
            let (q, ..) = self.row_of(batch, row.index, &rest);
            let mut unit = rest.clone();
            for column in 0..count {
                unit[column] = 1.0;
                let status = self.model.move_to(data, q, &unit, &rest);
                unit[column] = 0.0;
                if !status.is_converged() {
                    return status;
                }
                let all: &Bodies<f64> = &data.kinematics.bodies;
                for body in 0..bodies {
                    let twist = all.twist[body];
                    let linear = twist.velocity_at(all.pose[body].position).to_array();
                    let numbers = linear.into_iter().chain(twist.angular.to_array());
                    for (component, number) in numbers.enumerate() {
                        row.of(0)[(6 * body + component) * count + column] = number;
                    }
                }
            }
            Status::Converged
        };
        self.one_array(q, 6 * bodies * count, workers, compute)
    }

    /// Computes mass matrices with respect to the actuators: rows x actuators x actuators. The
    /// matrices include payloads that the load fixes to bodies, but no reflected inertia of rotors.
    ///
    /// # Errors
    /// The errors of [`Self::inverse_dynamics`]; the coordinates are not those of the actuators.
    pub fn mass_matrix(&self, q: &[f64], workers: &Workers<'_>) -> Result<Rows, Error> {
        self.refuse_other_coordinates("a mass matrix")?;
        let batch = Batch { q, v: &[], a: &[] };
        self.rows_of(batch)?;
        let count = self.home.len();
        let rest = vec![0.0; count];
        let compute = |data: &mut Data<f64>, row: &mut Row<'_, '_>| {
            let (q, ..) = self.row_of(batch, row.index, &rest);
            data.settings.friction = FrictionMode::Off;
            let mut unit = rest.clone();
            let mut at_rest = vec![0.0; count];
            for column in 0..=count {
                // The first solution, at zero accelerations, yields the efforts that support the
                // weight.
                if let Some(before) = column.checked_sub(1) {
                    unit[before] = 1.0;
                }
                let status = self.model.inverse_dynamics(data, q, &rest, &unit, &[]);
                unit.fill(0.0);
                if !status.is_converged() {
                    return status;
                }
                match column.checked_sub(1) {
                    None => at_rest.copy_from_slice(data.efforts()),
                    Some(before) => {
                        for (actuator, (effort, weight)) in
                            data.efforts().iter().zip(&at_rest).enumerate()
                        {
                            row.of(0)[actuator * count + before] = effort - weight;
                        }
                    }
                }
            }
            Status::Converged
        };
        self.one_array(q, count * count, workers, compute)
    }

    fn one_array(
        &self,
        q: &[f64],
        width: usize,
        workers: &Workers<'_>,
        compute: impl Fn(&mut Data<f64>, &mut Row<'_, '_>) -> Status + Sync,
    ) -> Result<Rows, Error> {
        let (status, mut arrays) = self.each_row(q, &[width], workers, compute)?;
        Ok(Rows { status, values: arrays.pop().unwrap_or_default() })
    }
}
