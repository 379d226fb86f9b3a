//! Columns and rows of the tables of inverse dynamics.

use super::motor_summary::residual;
use super::sample::Sample;
use crate::bodies::BodyRow;
use crate::dofs::{Dof, actuated, dofs_of};
use crate::job::Job;
use crate::names::Names;
use crate::table::{REACTION, columns};

/// File names of the tables, in the order of [`Rows::rows`].
pub(crate) const TABLES: [&str; 7] = [
    "inverse.csv",
    "reactions.csv",
    "friction.csv",
    "bodies.csv",
    "joints.csv",
    "motors.csv",
    "contributions.csv",
];
/// Number of tables that every run writes; these tables come first in [`TABLES`]. The other tables
/// require drive trains, or friction and actuators.
const ALWAYS: usize = 5;

/// Rows of all tables of a run for one sample.
pub(crate) struct Rows {
    /// Index of each actuator's degree of freedom in [`Sample::joints`].
    actuated: Vec<usize>,
    /// Indices of the first and the last joint of each leg.
    legs: Vec<(usize, usize)>,
    bodies: BodyRow,
    /// Torque constant of each drive train, N m/A; `None` if the model does not declare it.
    torque_constants: Vec<Option<f64>>,
    /// Headers of the columns of each table, without the time column.
    pub(crate) headers: [Vec<String>; 7],
    /// Values in the row of each table, without the time column.
    pub(crate) rows: [Vec<f64>; 7],
}

impl Rows {
    /// Returns true for each table in [`TABLES`] that a run of this job writes.
    pub(crate) fn of_job(job: &Job<'_>) -> [bool; 7] {
        let motors = !job.model.mechanism.drive_trains().is_empty();
        let mut has = [true; 7];
        (has[ALWAYS], has[ALWAYS + 1]) = (motors, job.has_shares());
        has
    }

    /// Creates the columns of the tables of a job, with empty rows.
    pub(crate) fn new(job: &Job<'_>) -> Self {
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
            let unit = if train.translates() { "N" } else { "N m" };
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
        let mut reactions = columns(names.joints.iter().map(String::as_str), &REACTION);
        for (name, unit) in &names.gearings {
            reactions.extend([format!("{name}.effort [{unit}]"), format!("{name}.determined")]);
        }
        let interfaces = || names.interfaces.iter().map(|(name, _)| name.as_str());
        let quantities = ["speed [m/s]", "load [N]", "friction [N]", "power [W]", "determined"];
        let mut friction = columns(interfaces(), &quantities);
        friction.extend(interfaces().next().map(|_| "coupling [-]".to_owned()));
        let mut contributions = Vec::new();
        for (drive, unit) in &names.drives {
            contributions.extend(interfaces().map(|name| format!("{drive}.from.{name} [{unit}]")));
        }
        let bodies = BodyRow::header(mechanism).collect();
        let trains = mechanism.drive_trains().iter();
        Self {
            headers: [inverse, reactions, friction, bodies, joints, motors, contributions],
            torque_constants: trains.map(|train| train.torque_constant).collect(),
            legs: ends.collect(),
            actuated,
            bodies: BodyRow::new(mechanism),
            rows: Default::default(),
        }
    }

    /// Fills the rows with the values of a sample.
    pub(crate) fn fill(&mut self, sample: &Sample) {
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
            // The added zero turns the negative zero of an actuator at rest into a positive zero.
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
        for (effort, &determined) in forces.gearings.iter().zip(&sample.determined_gearings) {
            reactions.extend([*effort, flag(determined)]);
        }
        for (interface, &determined) in forces.interfaces.iter().zip(&sample.determined_loads) {
            friction.extend([interface.velocity, interface.load, interface.friction]);
            friction.extend([interface.power, flag(determined)]);
        }
        if !forces.interfaces.is_empty() {
            // An unknown coupling is written as infinity.
            friction.push(sample.coupling.unwrap_or(f64::INFINITY));
        }
        bodies.extend_from_slice(self.bodies.of(&sample.bodies, sample.origin, &sample.loads));
        for drive in 0..forces.efforts.len() {
            contributions.extend(sample.shares.of_actuator(drive));
        }
    }
}

fn flag(value: bool) -> f64 {
    f64::from(u8::from(value))
}
