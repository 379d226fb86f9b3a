//! Tables of a run of inverse dynamics: columns and rows.

use super::motor_summary::residual;
use super::sample::Sample;
use crate::bodies::BodyRow;
use crate::dofs::{Dof, actuated, dofs_of};
use crate::job::Job;
use crate::names::Names;
use crate::table::{self, REACTION, columns, header};
use crate::{Sink, SinkError};
use std::io;

/// Names of the tables of every run, in the order of their files.
const FILES: [&str; 5] =
    ["inverse.csv", "reactions.csv", "friction.csv", "bodies.csv", "joints.csv"];
/// Name of the table of friction contributions, for runs with friction and actuators.
const CONTRIBUTIONS: &str = "shares.csv";
/// Name of the table of powers of the drive trains, for models with some.
const MOTORS: &str = "motors.csv";

/// Writes the tables of a run, one row for each sample.
///
/// `inverse.csv` has the actuators, the power balance, the closure error and the singularity indices;
/// `joints.csv` the motion of every scalar joint coordinate and the lengths of legs; `reactions.csv` the
/// complete wrench of every joint; `friction.csv` every friction interface; `bodies.csv` the motion of every
/// body; `motors.csv` the power of every motor and where it goes; `shares.csv` the contribution of every
/// friction interface to every actuator's effort.
pub struct Tables<W: io::Write> {
    tables: table::Tables<W>,
    /// Degree of freedom of each actuator among those of [`Sample::joints`].
    actuated: Vec<usize>,
    /// First and last joint of each leg.
    legs: Vec<(usize, usize)>,
    bodies: BodyRow,
    /// Torque constant of each drive train, N m/A.
    torque_constants: Vec<Option<f64>>,
    /// True if the run has this table.
    has: [bool; 7],
    rows: [Vec<f64>; 7],
}

impl<W: io::Write> Tables<W> {
    /// Names of the job's tables, in the order of the files passed to [`Self::new`].
    pub fn files(job: &Job<'_>) -> Vec<&'static str> {
        let names = FILES.into_iter().chain([MOTORS, CONTRIBUTIONS]);
        names.zip(Self::has(job)).filter(|(_, has)| *has).map(|(name, _)| name).collect()
    }

    fn has(job: &Job<'_>) -> [bool; 7] {
        let motors = !job.model.mechanism.drive_trains().is_empty();
        [true, true, true, true, true, motors, job.has_shares()]
    }

    /// Starts the tables with their headers.
    ///
    /// # Errors
    /// A header cannot be written.
    pub fn new(job: &Job<'_>, files: Vec<W>) -> io::Result<Self> {
        let mechanism = &job.model.mechanism;
        let names = Names::new(mechanism);
        let dofs = dofs_of(mechanism);
        let actuated = actuated(&dofs);
        let legs = job.model.legs.iter();
        let ends =
            legs.clone().filter_map(|leg| Some((leg.joints.first()?.0, leg.joints.last()?.0)));

        let mut inverse = Vec::new();
        for (name, unit) in &names.drives {
            let quantities = ["drive", "drive_frictionless", "drive_low", "drive_high"];
            inverse.extend(quantities.map(|quantity| format!("{name}.{quantity} [{unit}]")));
        }
        let whole = ["power.residual [W]", "closure [m]", "distance.actuation [-]"];
        inverse.extend(whole.into_iter().chain(["distance.constraint [-]"]).map(str::to_owned));
        for ((name, _), &dof) in names.drives.iter().zip(&actuated) {
            let [position, speed, _] = dofs[dof].units();
            inverse.extend([
                format!("{name}.position [{position}]"),
                format!("{name}.speed [{speed}]"),
            ]);
            inverse.push(format!("{name}.power [W]"));
        }
        let mut motors = Vec::new();
        for train in mechanism.drive_trains() {
            let name = &train.name;
            let unit = if train.lead.is_some() { "N" } else { "N m" };
            let torques = ["motor_torque", "motor_torque_low", "motor_torque_high"];
            inverse.extend(torques.map(|torque| format!("{name}.{torque} [N m]")));
            inverse.push(format!("{name}.motor_speed [rad/s]"));
            inverse.extend(train.torque_constant.map(|_| format!("{name}.current [A]")));
            motors.push(format!("{name}.effort [{unit}]"));
            let powers = ["motor_power", "output", "rotor", "motor_friction", "gear_loss"];
            motors.extend(powers.map(|power| format!("{name}.{power} [W]")));
        }
        motors.push("residual [W]".to_owned());
        let mut joints: Vec<String> = dofs.iter().flat_map(Dof::columns).collect();
        joints.extend(legs.map(|leg| format!("{}.length [m]", leg.name)));
        let reactions = columns(names.joints.iter().map(String::as_str), &REACTION);
        let interfaces = || names.interfaces.iter().map(|(name, _)| name.as_str());
        let quantities = ["speed [m/s]", "load [N]", "friction [N]", "power [W]", "determined"];
        let mut friction = columns(interfaces(), &quantities);
        friction.extend(interfaces().next().map(|_| "coupling [-]".to_owned()));
        let mut contributions = Vec::new();
        for (drive, unit) in &names.drives {
            contributions.extend(interfaces().map(|name| format!("{drive}.from.{name} [{unit}]")));
        }
        let bodies = BodyRow::header(mechanism).collect();
        let headers = [inverse, reactions, friction, bodies, joints, motors, contributions];
        let has = Self::has(job);
        let headers = headers.into_iter().zip(has).filter(|(_, has)| *has);
        let trains = mechanism.drive_trains().iter();
        Ok(Self {
            tables: table::Tables::new(headers.map(|(columns, _)| header(columns)), files)?,
            torque_constants: trains.map(|train| train.torque_constant).collect(),
            has,
            legs: ends.collect(),
            actuated,
            bodies: BodyRow::new(mechanism),
            rows: Default::default(),
        })
    }

    /// Flushes all buffers and returns the files in their order.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(self) -> io::Result<Vec<W>> {
        self.tables.finish()
    }

    fn fill(&mut self, sample: &Sample) {
        let forces = &sample.forces;
        self.rows.iter_mut().for_each(Vec::clear);
        let [inverse, reactions, friction, bodies, joints, motors, contributions] = &mut self.rows;
        for (k, &(low, high)) in forces.effort_bounds.iter().enumerate() {
            inverse.extend([forces.efforts[k], forces.efforts_frictionless[k], low, high]);
        }
        let distances = sample.distances;
        inverse.extend([forces.power.residual(), sample.closure]);
        inverse.extend([distances.actuation, distances.constraint]);
        for (&dof, drive) in self.actuated.iter().zip(&forces.efforts) {
            let motion = &sample.joints[dof];
            // The sum turns the negative zero of a drive at rest into zero.
            inverse.extend([motion.value, motion.rate, drive * motion.rate + 0.0]);
        }
        for (motor, constant) in sample.motors.iter().zip(&self.torque_constants) {
            let (low, high) = motor.torque_bounds;
            inverse.extend([motor.torque, low, high, motor.speed + 0.0]);
            inverse.extend(constant.map(|constant| motor.torque / constant));
            motors.extend([motor.effort, motor.power, motor.output, motor.rotor_power]);
            motors.extend([motor.friction_power, motor.gear_loss].map(|power| power + 0.0));
        }
        motors.push(residual(&sample.motors, forces));
        for motion in &sample.joints {
            joints.extend([motion.value, motion.rate, motion.acceleration]);
        }
        let (first, last) = (&sample.bodies.frame_j, &sample.bodies.frame_k);
        let length =
            |&(from, to): &(usize, usize)| (last[to].position - first[from].position).norm();
        joints.extend(self.legs.iter().map(length));
        for ((force, moment), determined) in
            forces.reactions.iter().zip(&sample.determined_reactions)
        {
            reactions.extend(force.to_array().into_iter().chain(moment.to_array()));
            reactions.push(flag(determined.iter().all(|component| *component)));
        }
        for (interface, &determined) in forces.interfaces.iter().zip(&sample.determined_loads) {
            friction.extend([interface.velocity, interface.load, interface.friction]);
            friction.extend([interface.power, flag(determined)]);
        }
        if !forces.interfaces.is_empty() {
            // Infinity stands for an unknown coupling.
            friction.push(sample.coupling.unwrap_or(f64::INFINITY));
        }
        bodies.extend_from_slice(self.bodies.of(&sample.bodies, sample.origin, &sample.loads));
        for drive in 0..forces.efforts.len() {
            contributions.extend(sample.shares.of_actuator(drive));
        }
    }
}

impl<W: io::Write> Sink<Sample> for Tables<W> {
    fn add(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.fill(sample);
        let rows = self.rows.iter().zip(self.has).filter(|(_, has)| *has);
        Ok(self.tables.add(sample.time, rows.map(|(row, _)| row.as_slice()))?)
    }
}

fn flag(value: bool) -> f64 {
    f64::from(u8::from(value))
}
