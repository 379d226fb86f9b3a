//! Columns and rows of the result tables of a simulation.

use super::job::Job;
use super::motors::Motors;
use super::sample::Sample;
use crate::bodies::BodyRow;
use crate::dofs::{Dof, actuated, dofs_of};
use crate::in_space::{self, Tracked};
use crate::names::Names;
use crate::ranges::Measured;
use crate::table::{REACTION, columns, header};
use crate::{Sink, SinkError};
use std::io;
use stiction_core::forward::{InterfaceMode, InterfaceSample};

/// Names and arrangement of the columns in the tables of a simulation.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(crate) names: Names,
    pub(crate) dofs: Vec<Dof>,
    /// True for each actuator that follows a motion.
    pub(crate) reference: Vec<bool>,
    /// True if a body picks up or places a part during the simulation.
    pub(crate) has_payload_changes: bool,
    /// True for each friction interface that slides along one direction, so that speed and friction
    /// have a sign.
    pub(crate) signed: Vec<bool>,
    /// Index of each actuator's degree of freedom among all scalar degrees of freedom of joints.
    pub(crate) dof_of_actuator: Vec<usize>,
    pub(super) motors: Motors,
    bodies: Vec<String>,
    /// Bodies whose pose is compared with a reference in space.
    pub(crate) tracked: Vec<Tracked>,
    /// Quantities, other than joint coordinates, for which the model specifies a range, with their
    /// names and SI units.
    pub(super) measured: Vec<(Measured, String, &'static str)>,
    /// Stop conditions, as the user wrote them.
    pub(crate) stops: Vec<String>,
}

/// Rows of all tables for one sample, without the time column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// Time of the sample, s.
    pub time: f64,
    /// Row of `forward.csv`.
    pub forward: Vec<f64>,
    /// Row of `reactions.csv`.
    pub reactions: Vec<f64>,
    /// Row of `friction.csv`.
    pub friction: Vec<f64>,
    /// Row of `bodies.csv` except for its last columns, which [`Self::space`] contains.
    pub bodies: Vec<f64>,
    /// Last columns of `bodies.csv`: references and tracking errors in space.
    pub space: Vec<f64>,
    /// Row of `energy.csv`.
    pub energy: Vec<f64>,
}

/// Names of the columns of a friction interface in `friction.csv`.
const INTERFACE: [&str; 6] =
    ["speed [m/s]", "load [N]", "friction [N]", "limit [N]", "power [W]", "sticks"];

impl Layout {
    /// Determines the columns of the tables of a simulation.
    pub(super) fn new(job: &Job<'_>) -> Self {
        let mechanism = &job.model.mechanism;
        let dofs = dofs_of(mechanism);
        let dof_of_actuator = actuated(&dofs);
        let signed = mechanism.joints().iter().flat_map(|joint| {
            let interfaces = stiction_core::friction::interfaces_of(joint.joint_type);
            joint.friction.iter().map(|f| interfaces[f.place].1.has_one_dof())
        });
        // Effort columns have the names of degrees of freedom, like all other columns. This
        // distinguishes the degrees of freedom of one joint.
        let mut names = Names::with_shafts(mechanism);
        for ((name, _), &dof) in names.drives.iter_mut().zip(&dof_of_actuator) {
            let own: &Dof = &dofs[dof];
            name.clone_from(&own.name);
        }
        // The friction interfaces of motors come after those of the joints.
        let shafts = mechanism.shafts_with_friction();
        let signed: Vec<bool> = signed.chain(shafts.iter().map(|_| true)).collect();
        Self {
            names,
            reference: job.followers(),
            signed,
            motors: Motors::new(mechanism),
            dof_of_actuator,
            dofs,
            bodies: BodyRow::header(mechanism).collect(),
            tracked: job.followed(),
            measured: Measured::all(mechanism)
                .into_iter()
                .map(|(of, name, unit, _)| (of, name, unit))
                .collect(),
            has_payload_changes: job.has_payload_changes(),
            stops: job.stops.iter().map(|stop| stop.text().to_owned()).collect(),
        }
    }

    /// Returns the headers of all tables, in the order of [`Tables::FILES`](super::Tables::FILES).
    pub(crate) fn headers(&self) -> [Vec<String>; 6] {
        let mut forward = Vec::new();
        for dof in &self.dofs {
            forward.extend(dof.columns());
            if let Some(actuator) = dof.actuator {
                let (name, unit) = &self.names.drives[actuator];
                forward.push(format!("{name}.drive [{unit}]"));
                if self.reference[actuator] {
                    forward.push(format!("{}.reference [{}]", dof.name, dof.units()[0]));
                }
            }
        }
        forward.extend(self.motors.columns());
        forward.extend(self.measured.iter().map(|(_, name, unit)| format!("{name} [{unit}]")));
        forward.push("closure [m]".to_owned());
        let mut reactions = columns(self.names.joints.iter().map(String::as_str), &REACTION);
        for (name, unit) in &self.names.gearings {
            reactions.extend([format!("{name}.effort [{unit}]"), format!("{name}.determined")]);
        }
        let interfaces = || self.names.interfaces.iter().map(|(name, _)| name.as_str());
        let friction = self.names.friction_columns(&INTERFACE);
        let mut energy = ["kinetic [J]", "potential [J]"].map(str::to_owned).to_vec();
        energy.extend(columns(
            self.names.drives.iter().map(|(name, _)| name.as_str()),
            &["work [J]"],
        ));
        energy.extend(["loads.work [J]", "dampers.dissipated [J]"].map(str::to_owned));
        if self.has_payload_changes {
            energy.extend(["payloads.energy [J]", "impacts.lost [J]"].map(str::to_owned));
        }
        energy.extend(columns(interfaces(), &["dissipated [J]"]));
        energy.extend(["error [J]", "turnover [J]"].map(str::to_owned));
        // Other commands read the motion table as input.
        let mut motion = Vec::new();
        for &dof in &self.dof_of_actuator {
            let dof = &self.dofs[dof];
            let (name, [unit, rate, acceleration]) = (&dof.name, dof.units());
            motion.push(format!("{name} [{unit}]"));
            motion.push(format!("d({name}) [{rate}]"));
            motion.push(format!("dd({name}) [{acceleration}]"));
        }
        let mut bodies = self.bodies.clone();
        bodies.extend(self.tracked.iter().flat_map(in_space::columns));
        [forward, reactions, friction, bodies, energy, motion].map(header)
    }

    /// Returns the index of the first column of a degree of freedom in a row of `forward.csv`.
    fn place(&self, dof: usize) -> usize {
        let width = |f: &Dof| 3 + f.actuator.map_or(0, |a| 1 + usize::from(self.reference[a]));
        self.dofs[..dof].iter().map(width).sum()
    }

    /// Returns the part of a row of `forward.csv` that begins with the columns of the motors.
    pub(super) fn motors_in<'r>(&self, row: &'r [f64]) -> &'r [f64] {
        let begin = self.place(self.dofs.len()).min(row.len());
        &row[begin..]
    }

    /// Returns the columns with position, rate and acceleration of a degree of freedom in a row of
    /// `forward.csv`.
    pub(crate) fn motion_in<'r>(&self, row: &'r [f64], dof: usize) -> &'r [f64] {
        let at = self.place(dof);
        &row[at..at + 3]
    }

    /// Returns the value of a quantity of [`Self::measured`] in a row of `forward.csv`, rad or m;
    /// NaN if the table does not contain the quantity.
    pub(crate) fn measured_in(&self, row: &[f64], of: Measured) -> f64 {
        let place = self.measured.iter().position(|(known, ..)| *known == of);
        let first = row.len() - 1 - self.measured.len();
        place.and_then(|place| row.get(first + place)).copied().unwrap_or(f64::NAN)
    }

    /// Returns the effort and the reference position of an actuator in a row of `forward.csv`. The
    /// reference position is `None` if the actuator follows no motion.
    pub(crate) fn drive_in(&self, row: &[f64], actuator: usize) -> (f64, Option<f64>) {
        let at = self.place(self.dof_of_actuator[actuator]) + 3;
        (row[at], self.reference[actuator].then(|| row[at + 1]))
    }
}

/// Returns the sliding speed, m/s, and the friction, N, of an interface. They have a sign if the
/// interface slides along one direction; otherwise they are magnitudes.
fn along(moment: &InterfaceSample, signed: bool) -> (f64, f64) {
    let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    match signed {
        true => (moment.velocity[0], moment.friction[0]),
        false => (size(moment.velocity), size(moment.friction)),
    }
}

/// Converter of samples of a simulation to table rows. It passes the rows to [`Self::sink`] in
/// chronological order.
#[derive(Clone, Debug)]
pub struct Recorder<S> {
    layout: Layout,
    bodies: BodyRow,
    rows: Rows,
    /// Receiver of the rows: tables, a summary or curves.
    pub sink: S,
}

impl<S: Sink<Rows>> Recorder<S> {
    /// Creates a recorder that has not yet received a sample.
    pub fn new(job: &Job<'_>, sink: S) -> Self {
        let bodies = BodyRow::new(&job.model.mechanism);
        Self { layout: Layout::new(job), bodies, rows: Rows::default(), sink }
    }

    /// Returns the table rows of the last sample that the recorder received.
    pub fn last(&self) -> &Rows {
        &self.rows
    }

    /// Reads `count` rows from the tables of an interrupted simulation, in the order of
    /// [`Tables::FILES`](super::Tables::FILES), and passes them to the sink before any further
    /// samples.
    ///
    /// # Errors
    /// Returns an error if the tables do not contain `count` rows of this simulation, or the error
    /// of the sink.
    pub fn read(&mut self, files: [&mut dyn io::Read; 6], count: usize) -> Result<(), SinkError> {
        let mut readers = Vec::new();
        for (file, header) in files.into_iter().zip(self.layout.headers()) {
            let mut reader = csv::Reader::from_reader(file);
            if reader.headers()?.iter().ne(header.iter().map(String::as_str)) {
                return Err("the columns of the tables are not those of this simulation".into());
            }
            readers.push(reader.into_records());
        }
        for _ in 0..count {
            let Rows { time, forward, reactions, friction, bodies, space, energy } = &mut self.rows;
            // The rows of `motion.csv` are discarded, because they repeat values of other tables.
            let mut motion = Vec::new();
            let rows = [forward, reactions, friction, bodies, energy, &mut motion];
            for (reader, row) in readers.iter_mut().zip(rows) {
                let record = reader.next().ok_or("rows are missing")??;
                *row = record.iter().map(str::parse).collect::<Result<Vec<f64>, _>>()?;
                if row.is_empty() {
                    return Err("a row is empty".into());
                }
                *time = row.remove(0);
            }
            *space = bodies.split_off(bodies.len() - in_space::WIDTH * self.layout.tracked.len());
            self.bodies.follow(&self.rows.bodies);
            self.sink.add(&self.rows)?;
        }
        Ok(())
    }
}

impl<S: Sink<Rows>> Sink<Sample<'_>> for Recorder<S> {
    fn add(&mut self, sample: &Sample<'_>) -> Result<(), SinkError> {
        let Self { layout, rows, .. } = self;
        let now = sample.instant;
        rows.time = now.time;

        let row = &mut rows.forward;
        row.clear();
        for (dof, motion) in layout.dofs.iter().zip(sample.joints) {
            row.extend([motion.value, motion.rate, motion.acceleration]);
            if let Some(actuator) = dof.actuator {
                row.push(now.drives[actuator]);
                row.extend(layout.reference[actuator].then(|| sample.reference[actuator].value));
            }
        }
        layout.motors.write(
            &now.drives,
            |actuator| sample.joints[layout.dof_of_actuator[actuator]].rate,
            row,
        );
        row.extend(layout.measured.iter().map(|(of, ..)| of.value(&now.bodies)));
        row.push(sample.closure);

        let row = &mut rows.reactions;
        row.clear();
        let determined = f64::from(u8::from(now.redundant == 0));
        for (force, moment) in now.reactions() {
            row.extend(force.to_array().into_iter().chain(moment.to_array()));
            row.push(determined);
        }
        row.extend(now.gearings.iter().flat_map(|effort| [*effort, determined]));

        let row = &mut rows.friction;
        row.clear();
        let interfaces = now.interfaces.iter().zip(&now.account.interfaces);
        for ((moment, power), signed) in interfaces.zip(&layout.signed) {
            let (speed, friction) = along(moment, *signed);
            let sticks =
                matches!(moment.interface, InterfaceMode::Sticks | InterfaceMode::AtLimit(_));
            row.extend([speed, moment.load, friction, moment.limit, *power]);
            row.push(f64::from(u8::from(sticks)));
        }

        rows.bodies.clear();
        let origin = sample.forward.parameters().origin;
        rows.bodies.extend_from_slice(self.bodies.of(&now.bodies, origin, sample.loads));

        rows.space.clear();
        for point in sample.in_space() {
            rows.space.extend(point.followed());
        }

        let row = &mut rows.energy;
        row.clear();
        let energies = sample.energies;
        row.extend([now.account.kinetic, now.account.potential]);
        row.extend_from_slice(&energies.drives);
        row.extend([energies.loads, energies.dampers]);
        if layout.has_payload_changes {
            row.extend([energies.payloads, energies.impacts]);
        }
        row.extend_from_slice(&energies.interfaces);
        row.extend([sample.energy_error, energies.turnover]);
        self.sink.add(rows)
    }
}
