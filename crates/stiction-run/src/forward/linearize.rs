//! Linear model of a mechanism about an operating point, with named states, inputs and outputs.

use super::acting_inputs::{Acting, prescribed};
use super::controller::by_actuators;
use super::job::{Feed, Job};
use super::motors::Motors;
use super::start;
use crate::dofs::dofs_of;
use crate::error::Error;
use crate::names::{Names, listed};
use nalgebra::DMatrix;
use serde_json::{Value, json};
use std::fmt::{self, Write};
use stiction_core::dynamics::FrictionMode;
use stiction_core::forward::{Forward, InterfaceMode, Linearisation, LinearisationError};
use stiction_core::kinematics::{Bodies, State, Target};
use stiction_draw::numbers::number;
use stiction_format::{Drives, Signal};

/// Named quantity with its unit and its value at the operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// Name of the quantity, such as `A` for a coordinate or `d(A)` for its rate.
    pub name: String,
    /// SI unit of the quantity.
    pub unit: &'static str,
    /// Value of the quantity at the operating point, in `unit`.
    pub value: f64,
}

/// Mode of a friction interface in a linear model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinearMode {
    /// The interface sticks: its surfaces do not move relative to each other.
    Sticks,
    /// The interface slides and keeps its direction of sliding.
    Slides,
    /// The friction law of the interface is smooth: it is regularised, or contains only viscous
    /// friction.
    Smooth,
}

impl LinearMode {
    /// Returns the name of the mode in reports.
    pub fn word(self) -> &'static str {
        match self {
            Self::Sticks => "held",
            Self::Slides => "sliding",
            Self::Smooth => "smooth",
        }
    }
}

/// Linear model `dx/dt = f + A x + B u`, `y = C x + D u` for small deviations from an operating
/// point. The states `x` are the independent coordinates and their rates, the inputs `u` are the
/// efforts of the actuators without prescribed motion, and the outputs `y` are the positions of the
/// actuators.
#[derive(Clone, Debug)]
pub struct LinearModel {
    /// Title of the model and description of the operating point.
    pub heading: String,
    /// States `x`: independent coordinates, then their rates.
    pub states: Vec<Named>,
    /// Inputs `u`: efforts of the actuators without prescribed motion.
    pub inputs: Vec<Named>,
    /// Outputs `y`: positions of the actuators, or the independent coordinates if there are no actuators.
    pub outputs: Vec<Named>,
    /// Drift `f`: the time derivative of each state at the operating point. The drift is zero at an
    /// equilibrium.
    pub drift: Vec<f64>,
    /// State matrix `A`, row by row.
    pub a: Vec<Vec<f64>>,
    /// Input matrix `B`, row by row.
    pub b: Vec<Vec<f64>>,
    /// Output matrix `C`, row by row.
    pub c: Vec<Vec<f64>>,
    /// Feed-through matrix `D`, row by row. It is zero, because positions do not depend on efforts directly.
    pub d: Vec<Vec<f64>>,
    /// Eigenvalues of the state matrix: real and imaginary parts, 1/s.
    pub eigenvalues: Vec<(f64, f64)>,
    /// Name and mode of each friction interface.
    pub interfaces: Vec<(String, LinearMode)>,
    /// Largest estimated error of a matrix entry, relative to the largest entry of the same matrix.
    pub error: f64,
    /// Notes for the user on the operating point.
    pub notes: Vec<String>,
}

/// Real parts of eigenvalues count as rounding errors below this fraction of the magnitude of the
/// eigenvalue.
const ROUNDING: f64 = 1e-12;

/// Operating point: model, state, notes for the user, and the constant efforts of inverse dynamics.
/// `drives` is `None` if the efforts of the job act instead.
pub(super) struct OperatingPoint {
    pub(super) forward: Forward,
    pub(super) state: State<f64>,
    pub(super) drives: Option<Drives>,
    pub(super) notes: Vec<String>,
}

impl Job<'_> {
    /// Determines the operating point: the state at the start of the simulation, and the efforts in
    /// this state. The efforts come from inverse dynamics if the job requests this, or if `usual`
    /// is true and the actuators determine the motion. Otherwise the efforts of the job act.
    pub(super) fn operating_point(&self, usual: bool) -> Result<OperatingPoint, Error> {
        let forward = Forward::new(self.model.mechanism.clone(), &prescribed(self));
        let (state, mut notes) = start::state(self, &forward)?;
        let mut drives = None;
        let asked = matches!(self.drives, Feed::Inverse);
        if asked || usual {
            match self.efforts_of(&forward, &state) {
                Ok(efforts) => {
                    let efforts = efforts.into_iter().map(Signal::constant).enumerate().collect();
                    drives = Some(Drives { efforts, ..Drives::default() });
                    notes.push("efforts of inverse dynamics at the operating point".to_owned());
                }
                Err(error) if asked => return Err(error),
                Err(_) => notes.push(
                    "no efforts: the actuators do not determine the motion, or there are none"
                        .to_owned(),
                ),
            }
        }
        Ok(OperatingPoint { forward, state, drives, notes })
    }

    /// Computes by inverse dynamics the efforts of all actuators, N or N m, that cause the
    /// accelerations of `state`.
    fn efforts_of(&self, forward: &Forward, state: &State<f64>) -> Result<Vec<f64>, Error> {
        let mut bodies = Bodies::new(forward.topology());
        bodies.place(forward.topology(), forward.parameters(), &state.coordinates);
        bodies.move_with(forward.topology(), &state.rates);
        bodies.accelerate(forward.topology(), &state.accelerations);
        let mut model = by_actuators(self.model, forward, (state, &bodies))?;
        if self.friction {
            model.settings_mut().friction = FrictionMode::Converged;
        }
        let targets: Vec<Target<f64>> = forward
            .mechanism()
            .actuators()
            .map(|(joint, dof)| forward.joint_motion(state, &bodies, joint, dof))
            .collect();
        model.move_to(&targets).map_err(Error::Controller)?;
        let loads = self.loads_without_state()?;
        let forces = model.solve(&loads).map_err(Error::ControllerForces)?;
        let mut efforts = forces.efforts.clone();
        let motors = Motors::new(forward.mechanism());
        motors.add(self.from, &mut efforts, (&targets, &bodies), self.friction)?;
        Ok(efforts)
    }

    /// Linearises the mechanism about the initial state of the simulation. The friction interfaces
    /// keep the modes that they have in this state. If `usual` is true, the efforts of inverse
    /// dynamics replace those of the job, provided that the actuators determine the motion.
    ///
    /// # Errors
    /// [`Error::NoLinearModel`] if the configuration is singular, if the mechanism cannot move in
    /// this configuration, or if friction permits no linear model.
    pub fn linearize(&self, usual: bool) -> Result<LinearModel, Error> {
        if !self.load.payloads.is_empty() {
            let (model, load) = self.with_payloads()?;
            let job = Job { model: &model, load: &load, ..self.clone() };
            return job.linearize(usual);
        }
        let point = self.operating_point(usual)?;
        let job = match &point.drives {
            Some(drives) => Job { drives: Feed::Given(drives), ..self.clone() },
            None => self.clone(),
        };
        let going = || false;
        let mut acting = Acting::new(&job, &point.forward, &point.state, &going)?;
        let started = point.forward.start(self.from, point.state, self.settings, &mut acting);
        let mut simulation = started.map_err(Error::Forward)?;
        let names = Names::with_shafts(&self.model.mechanism);
        acting.refuse_kinks(&simulation)?;
        let linear = simulation.linearise(&mut acting).map_err(|error| refusal(error, &names))?;
        Ok(LinearModel::new(&job, &linear, point.notes))
    }
}

/// Advice to the user if friction interfaces at rest permit no linear model.
const BESIDE_REST: &str = "; choose an instant of the motion at which they slide (--at), give rates at the start \
                           (--from \"...; d(NAME) = ...\"), or leave friction out (--friction off)";

/// Converts an error of the linearisation to an error that names the friction interface.
pub(super) fn refusal(error: LinearisationError, names: &Names) -> Error {
    let name = |interface: usize| {
        names.interfaces.get(interface).map_or_else(String::new, |(name, _)| name.clone())
    };
    match error {
        LinearisationError::Forward(error) => Error::Forward(error),
        LinearisationError::AtLimit { interface } => Error::NoLinearModel(format!(
            "friction interface `{}` is at rest at its static friction limit, so opposite \
             disturbances cause different motions{BESIDE_REST}",
            name(interface)
        )),
        LinearisationError::Bristles { interface } => Error::NoLinearModel(format!(
            "the friction law of interface `{}` has bristles (dahl, lugre), whose deflections are \
             further states that a linear model does not include; give it another law",
            name(interface)
        )),
        LinearisationError::BeginsToSlide { interfaces } => {
            let all: Vec<_> = interfaces.into_iter().map(|k| format!("`{}`", name(k))).collect();
            Error::NoLinearModel(format!(
                "friction interfaces begin to slide from rest at this state, so opposite \
                 disturbances cause different motions: {}{BESIDE_REST}",
                listed(&all, 6)
            ))
        }
        other => Error::NoLinearModel(other.to_string()),
    }
}

impl LinearModel {
    fn new(job: &Job<'_>, linear: &Linearisation, mut notes: Vec<String>) -> Self {
        let mechanism = &job.model.mechanism;
        let dofs = dofs_of(mechanism);
        let names = Names::with_shafts(mechanism);
        let find = |at| dofs.iter().find(|dof| (dof.joint, dof.index) == at);
        let (mut states, mut rates) = (Vec::new(), Vec::new());
        let mut drift = Vec::new();
        for (at, motion) in linear.coordinates.iter().zip(&linear.motion) {
            let Some(dof) = find(*at) else { continue };
            let [place, speed, _] = dof.units();
            let named = |name, unit, value| Named { name, unit, value };
            states.push(named(dof.name.clone(), place, motion.value));
            rates.push(named(format!("d({})", dof.name), speed, motion.rate));
            drift.push(motion.rate);
        }
        drift.extend(linear.motion.iter().map(|motion| motion.acceleration));
        let m = states.len();
        let coordinates = states.clone();
        states.extend(rates);
        let actuators: Vec<_> = mechanism.actuators().collect();
        let name_of =
            |k: usize| find(actuators[k]).map_or_else(String::new, |dof| dof.name.clone());
        let effort_unit = |k: usize| match find(actuators[k]).is_some_and(|dof| dof.translates) {
            true => "N",
            false => "N m",
        };
        let inputs: Vec<Named> = linear
            .inputs
            .iter()
            .map(|&k| Named { name: name_of(k), unit: effort_unit(k), value: linear.efforts[k] })
            .collect();
        let zeros = |rows: usize, columns: usize| vec![vec![0.0; columns]; rows];
        let mut a = zeros(2 * m, 2 * m);
        let mut b = zeros(2 * m, inputs.len());
        for i in 0..m {
            a[i][m + i] = 1.0;
            a[m + i][..m].copy_from_slice(&linear.by_position[i]);
            a[m + i][m..].copy_from_slice(&linear.by_rate[i]);
            b[m + i].copy_from_slice(&linear.by_effort[i]);
        }
        let (outputs, rows) = if actuators.is_empty() {
            let unit = |i: usize| (0..m).map(|k| f64::from(u8::from(k == i))).collect();
            (coordinates, (0..m).map(unit).collect::<Vec<Vec<f64>>>())
        } else {
            let unit = |k: usize| find(actuators[k]).map_or("", |dof| dof.units()[0]);
            let outputs = (0..actuators.len())
                .map(|k| Named { name: name_of(k), unit: unit(k), value: linear.positions[k] })
                .collect();
            (outputs, linear.outputs.clone())
        };
        let c: Vec<Vec<f64>> = rows
            .into_iter()
            .map(|row| row.into_iter().chain(std::iter::repeat_n(0.0, m)).collect())
            .collect();
        let d = zeros(c.len(), inputs.len());
        let matrix = DMatrix::from_fn(2 * m, 2 * m, |i, k| a[i][k]);
        let mut eigenvalues: Vec<(f64, f64)> =
            matrix.complex_eigenvalues().iter().map(|z| (z.re, z.im)).collect();
        let size = |z: &(f64, f64)| z.0.hypot(z.1);
        eigenvalues.sort_by(|x, y| size(x).total_cmp(&size(y)).then(y.1.total_cmp(&x.1)));
        let held = |mode: &InterfaceMode| match mode {
            InterfaceMode::Sticks => LinearMode::Sticks,
            InterfaceMode::Slides(_) | InterfaceMode::AtLimit(_) => LinearMode::Slides,
            InterfaceMode::Smooth => LinearMode::Smooth,
        };
        let interfaces = names.interfaces.iter().map(|(name, _)| name.clone());
        let interfaces = interfaces.zip(linear.modes.iter().map(held)).collect();
        if linear.local > 0 {
            notes.push(format!(
                "{} local degrees of freedom, spins of rods about their own axes, are left out",
                linear.local
            ));
        }
        let heading = crate::names::heading_of(job.model);
        let error = linear.error;
        Self {
            heading,
            states,
            inputs,
            outputs,
            drift,
            a,
            b,
            c,
            d,
            eigenvalues,
            interfaces,
            error,
            notes,
        }
    }

    /// Returns all results as JSON.
    pub fn json(&self) -> Value {
        let named = |all: &[Named]| -> Vec<Value> {
            let each = all.iter();
            each.map(|n| json!({ "name": n.name, "unit": n.unit, "value": n.value })).collect()
        };
        let eigenvalues: Vec<Value> = self
            .eigenvalues
            .iter()
            .map(|z| {
                let mode = Mode::of(*z);
                json!({ "real": z.0, "imaginary": z.1, "frequency": mode.frequency, "damping": mode.damping })
            })
            .collect();
        let interfaces: serde_json::Map<String, Value> =
            self.interfaces.iter().map(|(name, held)| (name.clone(), json!(held.word()))).collect();
        json!({
            "states": named(&self.states),
            "inputs": named(&self.inputs),
            "outputs": named(&self.outputs),
            "A": self.a, "B": self.b, "C": self.c, "D": self.d,
            "drift": self.drift,
            "eigenvalues": eigenvalues,
            "interfaces": interfaces,
            "relative_error": self.error,
            "notes": self.notes,
        })
    }

    /// Returns the four matrices as CSV, each with its file name. The header contains the names of
    /// the columns, and the first column contains the names of the rows.
    pub fn tables(&self) -> [(&'static str, String); 4] {
        let labels = |all: &[Named], rate: bool| -> Vec<String> {
            let unit = |n: &Named| match (rate, n.unit.strip_suffix("/s")) {
                (false, _) => n.unit.to_owned(),
                (true, None) => format!("{}/s", n.unit),
                (true, Some(length)) => format!("{length}/s^2"),
            };
            let name = |n: &Named| if rate { format!("d/dt {}", n.name) } else { n.name.clone() };
            all.iter().map(|n| format!("{} [{}]", name(n), unit(n))).collect()
        };
        let states = labels(&self.states, false);
        let rates = labels(&self.states, true);
        let inputs = labels(&self.inputs, false);
        let outputs = labels(&self.outputs, false);
        let table = |rows: &[String], columns: &[String], matrix: &[Vec<f64>]| {
            let mut text = format!("row,{}\n", columns.join(","));
            for (row, values) in rows.iter().zip(matrix) {
                let values: Vec<String> = values.iter().map(|x| format!("{x:?}")).collect();
                let _ = writeln!(text, "{row},{}", values.join(","));
            }
            text
        };
        [
            ("A.csv", table(&rates, &states, &self.a)),
            ("B.csv", table(&rates, &inputs, &self.b)),
            ("C.csv", table(&outputs, &states, &self.c)),
            ("D.csv", table(&outputs, &inputs, &self.d)),
        ]
    }
}

/// Frequency and damping of an eigenvalue.
#[derive(Clone, Copy, Debug)]
struct Mode {
    /// Undamped frequency, Hz; `None` for a real eigenvalue.
    frequency: Option<f64>,
    /// Damping ratio; `None` for a real eigenvalue.
    damping: Option<f64>,
}

impl Mode {
    fn of((real, imaginary): (f64, f64)) -> Self {
        let size = real.hypot(imaginary);
        let oscillates = imaginary != 0.0;
        Self {
            frequency: oscillates.then_some(size / std::f64::consts::TAU),
            damping: oscillates.then_some(-real / size),
        }
    }
}

impl fmt::Display for LinearModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.heading)?;
        writeln!(
            f,
            "linear model: dx/dt = f + A x + B u, y = C x + D u, about the operating point"
        )?;
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        for (what, all) in
            [("states x", &self.states), ("inputs u", &self.inputs), ("outputs y", &self.outputs)]
        {
            writeln!(f, "\n{what}")?;
            for n in all {
                writeln!(f, "  {:24} {:>13} {}", n.name, number(n.value), n.unit)?;
            }
        }
        let moving = self.drift[self.drift.len() / 2..].iter().any(|x| x.abs() > 1e-9);
        if moving {
            writeln!(
                f,
                "\nnot an equilibrium: the accelerations are not zero (`drift` in --json)"
            )?;
        }
        if !self.interfaces.is_empty() {
            writeln!(f)?;
        }
        for state in [LinearMode::Sticks, LinearMode::Slides, LinearMode::Smooth] {
            let names: Vec<&str> =
                self.interfaces.iter().filter(|i| i.1 == state).map(|i| i.0.as_str()).collect();
            if !names.is_empty() {
                writeln!(f, "friction interfaces {}: {}", state.word(), names.join(", "))?;
            }
        }
        writeln!(f, "\neigenvalues of A, 1/s")?;
        for &(real, imaginary) in self.eigenvalues.iter().filter(|z| z.1 >= 0.0) {
            let small = |x: f64, size: f64| if x.abs() < ROUNDING * size { 0.0 } else { x };
            let real = small(real, real.hypot(imaginary));
            let mode = Mode::of((real, imaginary));
            match (mode.frequency, mode.damping) {
                (Some(frequency), Some(damping)) => writeln!(
                    f,
                    "  {} +- {} i: {} Hz, damping ratio {}",
                    number(real),
                    number(imaginary),
                    number(frequency),
                    number(damping)
                )?,
                _ => writeln!(f, "  {}", number(real))?,
            }
        }
        let unstable = self.eigenvalues.iter().any(|z| z.0 > 1e-9 * z.0.hypot(z.1).max(1.0));
        writeln!(f, "{}", if unstable { "unstable" } else { "no growing motion" })?;
        writeln!(f, "estimated relative error of the derivatives: {:.0e}", self.error)
    }
}
