//! The tables of a run: columns and rows.

use super::sample::Sample;
use crate::names::Names;
use crate::table::Table;
use std::io;
use stiction_core::mechanism::Mechanism;

/// The three tables of a run.
pub struct Tables<W: io::Write> {
    /// `inverse.csv`: drives, power balance, closure, distances.
    pub inverse: Table<W>,
    /// `reactions.csv`: the complete wrench of every joint.
    pub reactions: Table<W>,
    /// `friction.csv`: speed, load, friction and power of every contact.
    pub friction: Table<W>,
}

impl<W: io::Write> Tables<W> {
    /// Begins the tables of a mechanism.
    ///
    /// # Errors
    /// What the receivers say.
    pub fn new(mechanism: &Mechanism, [inverse, reactions, friction]: [W; 3]) -> io::Result<Self> {
        let names = Names::new(mechanism);
        let begin = || vec!["time [s]".to_owned()];

        let mut header = begin();
        for (name, unit) in &names.drives {
            for what in ["drive", "drive_frictionless", "drive_low", "drive_high"] {
                header.push(format!("{name}.{what} [{unit}]"));
            }
        }
        for column in [
            "power.residual [W]",
            "closure [m]",
            "distance.actuation [-]",
            "distance.constraint [-]",
        ] {
            header.push(column.to_owned());
        }
        let inverse = Table::new(inverse, &header)?;

        let mut header = begin();
        for name in &names.joints {
            for component in ["fx [N]", "fy [N]", "fz [N]", "mx [N m]", "my [N m]", "mz [N m]"] {
                header.push(format!("{name}.{component}"));
            }
            header.push(format!("{name}.determined"));
        }
        let reactions = Table::new(reactions, &header)?;

        let mut header = begin();
        for (name, _) in &names.interfaces {
            for column in ["speed [m/s]", "load [N]", "friction [N]", "power [W]", "determined"] {
                header.push(format!("{name}.{column}"));
            }
        }
        if !names.interfaces.is_empty() {
            header.push("coupling [-]".to_owned());
        }
        let friction = Table::new(friction, &header)?;
        Ok(Self { inverse, reactions, friction })
    }

    /// Adds a row to each table.
    ///
    /// # Errors
    /// What the receivers say.
    pub fn add(&mut self, sample: &Sample<'_>) -> io::Result<()> {
        let forces = sample.forces;
        let table = &mut self.inverse;
        table.number(sample.time)?;
        for (drive, &(low, high)) in forces
            .efforts
            .iter()
            .zip(&forces.effort_bounds)
            .enumerate()
            .map(|(k, (drive, bounds))| ((k, *drive), bounds))
        {
            let (k, drive) = drive;
            for value in [drive, forces.efforts_frictionless[k], low, high] {
                table.number(value)?;
            }
        }
        for value in [
            forces.power.residual(),
            sample.closure,
            sample.distances.actuation,
            sample.distances.constraint,
        ] {
            table.number(value)?;
        }
        table.end_row()?;

        let table = &mut self.reactions;
        table.number(sample.time)?;
        for ((force, moment), determined) in
            forces.reactions.iter().zip(sample.determined_reactions)
        {
            for component in force.to_array().into_iter().chain(moment.to_array()) {
                table.number(component)?;
            }
            table.flag(determined.iter().all(|d| *d))?;
        }
        table.end_row()?;

        let table = &mut self.friction;
        table.number(sample.time)?;
        for (interface, &determined) in forces.interfaces.iter().zip(sample.determined_loads) {
            for value in [interface.velocity, interface.load, interface.friction, interface.power] {
                table.number(value)?;
            }
            table.flag(determined)?;
        }
        if !forces.interfaces.is_empty() {
            // Where it is not known it has no bound.
            table.number(sample.coupling.unwrap_or(f64::INFINITY))?;
        }
        table.end_row()
    }
}
