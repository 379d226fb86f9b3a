//! Columns of the tables of inverse dynamics, to which objectives refer by name.

use crate::Job;
use crate::inverse::rows::{Rows, TABLES};
use crate::names::Names;

/// Column of a table of inverse dynamics, or the magnitude of a vector whose components are three
/// successive columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Column {
    /// Index of the table in [`TABLES`].
    table: usize,
    /// Index of the first component in the row of the table that contains this column.
    first: usize,
    /// Number of components: one for a scalar, three for a vector.
    width: usize,
    /// Name of the column in objectives.
    pub(super) name: String,
    /// Unit of the column without brackets; `-` for a dimensionless column.
    pub(super) unit: String,
}

impl Column {
    /// Returns the value of the column in the rows of a sample.
    pub(super) fn of(&self, rows: &Rows) -> f64 {
        let row = rows.rows[self.table].get(self.first..self.first + self.width);
        match row {
            Some([value]) => *value,
            Some(vector) => vector.iter().map(|x| x * x).sum::<f64>().sqrt(),
            None => f64::NAN,
        }
    }

    /// Finds the column of the same table that states whether the values of this column are
    /// statically determinate; `None` if the table has no such column.
    pub(super) fn determined(&self, known: &[Self]) -> Option<Self> {
        let owners = self.name.match_indices('.').map(|(at, _)| &self.name[..at]);
        let flag = |owner: &str| {
            let name = format!("{owner}.determined");
            known.iter().find(|column| column.table == self.table && column.name == name)
        };
        owners.rev().find_map(flag).cloned()
    }

    /// Returns true for the torque and the current of a motor, whose root mean squares are taken over
    /// time, because they heat the motor.
    pub(super) fn has_thermal_rms(&self) -> bool {
        [".motor_torque", ".current"].into_iter().any(|what| self.name.ends_with(what))
    }

    /// Returns the short name of the table, which distinguishes columns with equal names.
    pub(super) fn table(&self) -> &'static str {
        TABLES[self.table].trim_end_matches(".csv")
    }
}

/// Lists all columns in the tables of a job. If several columns have the same name, a name without
/// a table refers to the first of them.
pub(super) fn columns(job: &Job<'_>, rows: &Rows) -> Vec<Column> {
    let mut all = Vec::new();
    // Order of precedence of columns with equal names.
    let order = ["inverse", "joints", "reactions", "friction", "bodies", "motors", "contributions"];
    let has = Rows::of_job(job);
    for table in order {
        let Some(table) = TABLES.iter().position(|file| file.trim_end_matches(".csv") == table)
        else {
            continue;
        };
        if !has[table] {
            continue;
        }
        let start = all.len();
        all.extend(rows.headers[table].iter().enumerate().map(|(first, header)| {
            let (name, unit) = split(header);
            Column { table, first, width: 1, name, unit }
        }));
        let vectors = vectors(&all[start..]);
        all.extend(vectors);
        if start == 0 {
            let efforts = efforts(job, &all);
            all.extend(efforts);
        }
    }
    all
}

/// Splits a column header such as `leg1.P.drive [N]` into name and unit.
pub(super) fn split(header: &str) -> (String, String) {
    match header.trim().strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
        Some((name, unit)) => (name.trim_end().to_owned(), unit.trim().to_owned()),
        None => (header.trim().to_owned(), "-".to_owned()),
    }
}

/// Returns the columns `J.effort` for all actuators, which are aliases of the columns `J.drive`.
fn efforts(job: &Job<'_>, inverse: &[Column]) -> Vec<Column> {
    let names = Names::new(&job.model.mechanism);
    let effort = |(name, _): &(String, &str)| {
        let drive = format!("{name}.drive");
        let column = inverse.iter().find(|column| column.name == drive)?;
        Some(Column { name: format!("{name}.effort"), ..column.clone() })
    };
    names.drives.iter().filter_map(effort).collect()
}

/// Finds the vectors among the columns of a table: `J.reaction.force` for `J.fx`, `J.fy`, `J.fz`.
fn vectors(columns: &[Column]) -> Vec<Column> {
    let kinds = [
        (["fx", "fy", "fz"], "reaction.force"),
        (["mx", "my", "mz"], "reaction.moment"),
        (["vx", "vy", "vz"], "velocity"),
        (["ax", "ay", "az"], "acceleration"),
    ];
    let mut found = Vec::new();
    for triple in columns.windows(3) {
        for (components, name) in kinds {
            let owner = |k: usize| triple[k].name.strip_suffix(components[k])?.strip_suffix('.');
            if let (Some(a), Some(b), Some(c)) = (owner(0), owner(1), owner(2))
                && a == b
                && b == c
            {
                found.push(Column { width: 3, name: format!("{a}.{name}"), ..triple[0].clone() });
            }
        }
    }
    found
}
