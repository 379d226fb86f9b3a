//! The tables of a run: names, units and rows.

use super::sample::Sample;
use crate::numbers::exact;
use std::io;
use stiction::friction::contacts_of;
use stiction::mechanism::Mechanism;

/// Names of actuators and contacts in columns and messages.
#[derive(Clone, Debug)]
pub(crate) struct Names {
    /// For each actuator its name and the unit of its effort.
    pub(crate) drives: Vec<(String, &'static str)>,
    /// For each joint its name.
    pub(crate) joints: Vec<String>,
    /// For each contact its name and its joint's index.
    pub(crate) contacts: Vec<(String, usize)>,
    /// Contacts whose law has a state, of which only steady sliding is computed.
    pub(crate) steady: Vec<String>,
}

impl Names {
    pub(crate) fn new(mechanism: &Mechanism) -> Self {
        let joints = mechanism.joints();
        let drives = mechanism
            .actuators()
            .map(|(id, freedom)| {
                let joint = &joints[id.0];
                let freedom = &joint.joint_type.freedoms()[freedom];
                let alone = joint.actuated_freedoms().count() == 1;
                let name = if alone {
                    joint.name.clone()
                } else {
                    format!("{}.{}", joint.name, freedom.name)
                };
                (name, freedom.units().1)
            })
            .collect();
        let mut steady = Vec::new();
        let contacts = joints
            .iter()
            .enumerate()
            .flat_map(|(index, joint)| joint.friction.iter().map(move |c| (index, joint, c)))
            .map(|(index, joint, contact)| {
                let place = contacts_of(joint.joint_type)[contact.place].0;
                let name = if place.is_empty() {
                    joint.name.clone()
                } else {
                    format!("{}.{place}", joint.name)
                };
                let laws = [Some(&contact.law), contact.backward.as_ref()];
                if laws.into_iter().flatten().any(|law| law.bristles.is_some()) {
                    steady.push(name.clone());
                }
                (name, index)
            })
            .collect();
        Self { drives, joints: joints.iter().map(|j| j.name.clone()).collect(), contacts, steady }
    }
}

/// One table as CSV.
pub struct Table<W: io::Write> {
    writer: csv::Writer<W>,
    cell: String,
}

impl<W: io::Write> Table<W> {
    pub(crate) fn new(into: W, header: &[String]) -> io::Result<Self> {
        let mut writer = csv::Writer::from_writer(into);
        writer.write_record(header)?;
        Ok(Self { writer, cell: String::new() })
    }

    /// Goes on with a table that has its header, and maybe rows.
    pub(crate) fn onward(into: W) -> Self {
        Self { writer: csv::Writer::from_writer(into), cell: String::new() }
    }

    /// Hands on what is buffered.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }

    /// A number with all its digits, in the shortest way that reads back as the same number.
    pub(crate) fn number(&mut self, value: f64) -> io::Result<()> {
        self.cell.clear();
        exact(&mut self.cell, value);
        self.writer.write_field(&self.cell)?;
        Ok(())
    }

    fn flag(&mut self, value: bool) -> io::Result<()> {
        self.writer.write_field(if value { "1" } else { "0" })?;
        Ok(())
    }

    pub(crate) fn end_row(&mut self) -> io::Result<()> {
        self.writer.write_record(None::<&[u8]>)?;
        Ok(())
    }

    /// Writes what is buffered and gives the receiver back.
    ///
    /// # Errors
    /// What the receiver says.
    pub fn finish(self) -> io::Result<W> {
        self.writer
            .into_inner()
            .map_err(|error| io::Error::new(error.error().kind(), error.to_string()))
    }
}

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
        for (name, _) in &names.contacts {
            for column in ["speed [m/s]", "load [N]", "friction [N]", "power [W]", "determined"] {
                header.push(format!("{name}.{column}"));
            }
        }
        if !names.contacts.is_empty() {
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
            .drives
            .iter()
            .zip(&forces.drive_bounds)
            .enumerate()
            .map(|(k, (drive, bounds))| ((k, *drive), bounds))
        {
            let (k, drive) = drive;
            for value in [drive, forces.drives_frictionless[k], low, high] {
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
        for (contact, &determined) in forces.contacts.iter().zip(sample.determined_loads) {
            for value in [contact.velocity, contact.load, contact.friction, contact.power] {
                table.number(value)?;
            }
            table.flag(determined)?;
        }
        if !forces.contacts.is_empty() {
            // Where it is not known it has no bound.
            table.number(sample.coupling.unwrap_or(f64::INFINITY))?;
        }
        table.end_row()
    }
}
