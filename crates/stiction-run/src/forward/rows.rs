//! The numbers of a sample, table by table.

use super::sample::Sample;
use crate::inverse::bodies::BodyRow;
use crate::names::Names;
use stiction_core::forward::{InterfaceMode, InterfaceSample};
use stiction_core::mechanism::{JointId, Mechanism};

/// A scalar freedom of a joint.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Dof {
    /// The joint's name, with that of the freedom where the joint has several.
    pub(crate) name: String,
    pub(crate) joint: JointId,
    pub(crate) index: usize,
    pub(crate) translates: bool,
    /// The actuator that drives it.
    pub(crate) actuator: Option<usize>,
}

/// All scalar freedoms of a mechanism's joints.
pub(crate) fn dofs_of(mechanism: &Mechanism) -> Vec<Dof> {
    let actuators: Vec<_> = mechanism.actuators().collect();
    let mut all = Vec::new();
    for (id, joint) in mechanism.joints().iter().enumerate() {
        if !joint.joint_type.has_scalar_coordinates() {
            continue;
        }
        let dofs = joint.joint_type.dofs();
        for (index, dof) in dofs.iter().enumerate() {
            let joint_id = JointId(id);
            all.push(Dof {
                name: joint.dof_name(index),
                joint: joint_id,
                index,
                translates: dof.translates(),
                actuator: actuators.iter().position(|a| *a == (joint_id, index)),
            });
        }
    }
    all
}

impl Dof {
    /// Units of the coordinate, its rate and its acceleration.
    pub(crate) fn units(&self) -> [&'static str; 3] {
        if self.translates { ["m", "m/s", "m/s^2"] } else { ["rad", "rad/s", "rad/s^2"] }
    }
}

/// What is in which column.
#[derive(Clone, Debug)]
pub struct Layout {
    pub(crate) names: Names,
    pub(crate) dofs: Vec<Dof>,
    /// For each actuator whether it follows a motion.
    pub(crate) wanted: Vec<bool>,
    /// For each contact whether its sliding has one direction, and so a sign.
    pub(crate) signed: Vec<bool>,
    /// For each actuator its freedom.
    pub(crate) dof_of_actuator: Vec<usize>,
    bodies: Vec<String>,
}

/// The numbers of a sample, each table's row without the time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// s.
    pub time: f64,
    /// `forward.csv`.
    pub forward: Vec<f64>,
    /// `reactions.csv`.
    pub reactions: Vec<f64>,
    /// `friction.csv`.
    pub friction: Vec<f64>,
    /// `bodies.csv`.
    pub bodies: Vec<f64>,
    /// `energy.csv`.
    pub energy: Vec<f64>,
}

/// Columns of a reaction.
const REACTION: [&str; 7] =
    ["fx [N]", "fy [N]", "fz [N]", "mx [N m]", "my [N m]", "mz [N m]", "determined"];
/// Columns of a contact.
const INTERFACE: [&str; 6] =
    ["speed [m/s]", "load [N]", "friction [N]", "limit [N]", "power [W]", "sticks"];

impl Layout {
    /// The columns of a mechanism; `wanted` says of each actuator whether it follows a motion.
    pub fn new(mechanism: &Mechanism, wanted: Vec<bool>) -> Self {
        let dofs = dofs_of(mechanism);
        let place = |actuator: usize| dofs.iter().position(|f| f.actuator == Some(actuator));
        let dof_of_actuator: Vec<usize> =
            (0..mechanism.actuators().count()).filter_map(place).collect();
        let signed = mechanism.joints().iter().flat_map(|joint| {
            let interfaces = stiction_core::friction::interfaces_of(joint.joint_type);
            joint.friction.iter().map(|f| interfaces[f.place].1.has_one_dof())
        });
        // One of several freedoms is told which, as in all other columns here.
        let mut names = Names::new(mechanism);
        for ((name, _), &dof) in names.drives.iter_mut().zip(&dof_of_actuator) {
            let own: &Dof = &dofs[dof];
            name.clone_from(&own.name);
        }
        Self {
            names,
            wanted,
            signed: signed.collect(),
            dof_of_actuator,
            dofs,
            bodies: BodyRow::header(mechanism).collect(),
        }
    }

    /// Header of `forward.csv`.
    pub(crate) fn forward(&self) -> Vec<String> {
        let mut header = time();
        for dof in &self.dofs {
            let units = dof.units();
            for (what, unit) in ["position", "rate", "acceleration"].iter().zip(units) {
                header.push(format!("{}.{what} [{unit}]", dof.name));
            }
            if let Some(actuator) = dof.actuator {
                let (name, unit) = &self.names.drives[actuator];
                header.push(format!("{name}.drive [{unit}]"));
                if self.wanted[actuator] {
                    header.push(format!("{}.wanted [{}]", dof.name, units[0]));
                }
            }
        }
        header.push("closure [m]".to_owned());
        header
    }

    /// Header of `reactions.csv`.
    pub(crate) fn reactions(&self) -> Vec<String> {
        let joints = self.names.joints.iter();
        time()
            .into_iter()
            .chain(joints.flat_map(|name| REACTION.map(|c| format!("{name}.{c}"))))
            .collect()
    }

    /// Header of `friction.csv`.
    pub(crate) fn friction(&self) -> Vec<String> {
        let interfaces = self.names.interfaces.iter();
        let columns = interfaces.flat_map(|(name, _)| INTERFACE.map(|c| format!("{name}.{c}")));
        time().into_iter().chain(columns).collect()
    }

    /// Header of `bodies.csv`.
    pub(crate) fn bodies(&self) -> Vec<String> {
        time().into_iter().chain(self.bodies.iter().cloned()).collect()
    }

    /// Header of `energy.csv`.
    pub(crate) fn energy(&self) -> Vec<String> {
        let mut header = time();
        header.extend(["kinetic [J]", "potential [J]"].map(str::to_owned));
        header.extend(self.names.drives.iter().map(|(name, _)| format!("{name}.work [J]")));
        header.extend(["loads.work [J]", "dampers.dissipated [J]"].map(str::to_owned));
        let interfaces = self.names.interfaces.iter();
        header.extend(interfaces.map(|(name, _)| format!("{name}.dissipated [J]")));
        header.extend(["error [J]", "turnover [J]"].map(str::to_owned));
        header
    }

    /// Header of `motion.csv`, which other verbs read.
    pub(crate) fn motion(&self) -> Vec<String> {
        let mut header = time();
        for &dof in &self.dof_of_actuator {
            let dof = &self.dofs[dof];
            let (name, [unit, rate, acceleration]) = (&dof.name, dof.units());
            header.push(format!("{name} [{unit}]"));
            header.push(format!("d({name}) [{rate}]"));
            header.push(format!("dd({name}) [{acceleration}]"));
        }
        header
    }

    /// Where in a row of `forward.csv` a freedom's numbers begin.
    fn place(&self, dof: usize) -> usize {
        let width = |f: &Dof| 3 + f.actuator.map_or(0, |a| 1 + usize::from(self.wanted[a]));
        self.dofs[..dof].iter().map(width).sum()
    }

    /// Position, rate and acceleration of a freedom.
    pub(crate) fn motion_in<'r>(&self, row: &'r [f64], dof: usize) -> &'r [f64] {
        let at = self.place(dof);
        &row[at..at + 3]
    }

    /// The effort of an actuator, and where it is wanted.
    pub(crate) fn drive_in(&self, row: &[f64], actuator: usize) -> (f64, Option<f64>) {
        let at = self.place(self.dof_of_actuator[actuator]) + 3;
        (row[at], self.wanted[actuator].then(|| row[at + 1]))
    }
}

fn time() -> Vec<String> {
    vec!["time [s]".to_owned()]
}

/// Speed and friction of a contact: with a sign where there is one direction.
fn along(moment: &InterfaceSample, signed: bool) -> (f64, f64) {
    let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    match signed {
        true => (moment.velocity[0], moment.friction[0]),
        false => (size(moment.velocity), size(moment.friction)),
    }
}

/// Makes rows of samples, which must come in order.
#[derive(Clone, Debug)]
pub struct Scribe {
    bodies: BodyRow,
}

impl Scribe {
    /// Before the first sample.
    pub fn new(mechanism: &Mechanism) -> Self {
        Self { bodies: BodyRow::new(mechanism) }
    }

    /// Goes on after these rows.
    pub fn follow(&mut self, rows: &Rows) {
        self.bodies.follow(&rows.bodies);
    }

    /// The rows of a sample.
    pub fn write(&mut self, layout: &Layout, sample: &Sample<'_>, rows: &mut Rows) {
        let now = sample.instant;
        rows.time = now.time;

        let row = &mut rows.forward;
        row.clear();
        for (dof, motion) in layout.dofs.iter().zip(sample.joints) {
            row.extend([motion.value, motion.rate, motion.acceleration]);
            if let Some(actuator) = dof.actuator {
                row.push(now.drives[actuator]);
                row.extend(layout.wanted[actuator].then(|| sample.wanted[actuator].value));
            }
        }
        row.push(sample.closure);

        let row = &mut rows.reactions;
        row.clear();
        let determined = f64::from(u8::from(now.redundant == 0));
        for (force, moment) in now.reactions() {
            row.extend(force.to_array().into_iter().chain(moment.to_array()));
            row.push(determined);
        }

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

        let row = &mut rows.energy;
        row.clear();
        let energies = sample.energies;
        row.extend([now.account.kinetic, now.account.potential]);
        row.extend_from_slice(&energies.drives);
        row.extend([energies.loads, energies.dampers]);
        row.extend_from_slice(&energies.interfaces);
        row.extend([sample.energy_error, energies.turnover]);
    }
}
