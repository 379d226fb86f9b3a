//! Linearisation of the equations of motion in independent coordinates.
//!
//! Derivatives of the accelerations are computed by central differences of order six. Each sample
//! satisfies the loop constraints, and the friction interfaces keep their present modes. The
//! differences are repeated with a quarter of the step each time. The result is the estimate that
//! differs least from the estimate with the next smaller step; this difference is the error
//! estimate.

mod differences;
mod error;

pub use error::LinearisationError;

use super::scratch::Scratch;
use super::{Method, Simulation};
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::solve::Unsolved;
use crate::kinematics::{Bodies, State, Target};
use crate::mechanism::JointId;
use crate::spatial::Vec3;
use differences::{Beside, Change};
use nalgebra::{DMatrix, DVector};

/// A joint coordinate counts as dependent if the part of its rate that is linearly independent of
/// the coordinates already selected is below this fraction of the largest rate of any coordinate.
const DEPENDENT: f64 = 1e-6;
/// Actuated coordinates are selected before other coordinates as long as the independent part of
/// their rate exceeds this fraction of the largest rate of any coordinate.
const PREFERRED: f64 = 1e-2;
/// Smallest singularity index of the constraints for which a linearisation is computed.
const SINGULAR: f64 = 1e-6;
/// Initial difference step, which is also the largest one. Coordinates: rad or characteristic
/// lengths. Rates: rad or characteristic lengths per characteristic time. Efforts: fraction of the
/// weight of the mechanism, times the characteristic length for torques.
const FIRST_STEP: f64 = 2e-2;

/// Linear equations of motion about an operating point: `dq/dt = v`, `dv/dt = a0 + K q + D v + B
/// u`, outputs `y = C q`. Here `q`, `v` and `u` are the deviations of the independent coordinates,
/// of their rates and of the actuator efforts from the operating point.
#[derive(Clone, Debug)]
pub struct Linearisation {
    /// Independent joint coordinates, as pairs of joint and index of the degree of freedom.
    pub coordinates: Vec<(JointId, usize)>,
    /// Value (rad or m), rate and acceleration of each independent coordinate at the operating
    /// point.
    pub motion: Vec<Target<f64>>,
    /// Matrix `K`: derivatives of the accelerations with respect to the independent coordinates,
    /// one row per acceleration.
    pub by_position: Vec<Vec<f64>>,
    /// Matrix `D`: derivatives of the accelerations with respect to the rates, one row per
    /// acceleration.
    pub by_rate: Vec<Vec<f64>>,
    /// Matrix `B`: derivatives of the accelerations with respect to the efforts of the actuators
    /// listed in [`Self::inputs`], one row per acceleration.
    pub by_effort: Vec<Vec<f64>>,
    /// Indices of the actuators whose efforts are the inputs `u`: all actuators without prescribed
    /// motion.
    pub inputs: Vec<usize>,
    /// Matrix `C`: derivatives of the coordinates of all actuators with respect to the independent
    /// coordinates, one row per actuator.
    pub outputs: Vec<Vec<f64>>,
    /// Coordinates of all actuators at the operating point, rad or m.
    pub positions: Vec<f64>,
    /// Efforts of all actuators at the operating point, N or N m.
    pub efforts: Vec<f64>,
    /// Mode of each friction interface. The linearisation assumes that the modes do not change.
    pub modes: Vec<InterfaceMode>,
    /// Number of local degrees of freedom that the linearisation omits, such as the spin of a rod
    /// about its own axis.
    pub local: usize,
    /// Largest estimated error of any derivative, relative to the largest entry of its matrix.
    pub error: f64,
    /// For each independent coordinate, the rates of all degrees of freedom of the spanning tree at
    /// a unit rate of this coordinate.
    directions: Vec<Vec<f64>>,
}

impl Simulation<'_> {
    /// Linearises the equations of motion about the present state, with the present modes of the
    /// friction interfaces.
    ///
    /// # Errors
    /// See [`LinearisationError`].
    pub fn linearise(
        &mut self,
        inputs: &mut dyn Inputs,
    ) -> Result<Linearisation, LinearisationError> {
        self.linearised(inputs, true)
    }

    /// Linearises like [`Self::linearise`], but computes only the derivatives with respect to
    /// coordinates; the rows of the matrices of derivatives with respect to rates and efforts are
    /// empty.
    ///
    /// # Errors
    /// See [`LinearisationError`].
    pub fn linearise_statics(
        &mut self,
        inputs: &mut dyn Inputs,
    ) -> Result<Linearisation, LinearisationError> {
        self.linearised(inputs, false)
    }

    fn linearised(
        &mut self,
        inputs: &mut dyn Inputs,
        moves: bool,
    ) -> Result<Linearisation, LinearisationError> {
        if self.method() == Method::TimeStepping {
            return Err(LinearisationError::NoAcceleration);
        }
        let model = self.model;
        for (interface, mode) in self.modes.iter().enumerate() {
            if matches!(mode, InterfaceMode::AtLimit(_)) {
                return Err(LinearisationError::AtLimit { interface });
            }
            if model.parameters.interfaces[interface].law.bristles.is_some() {
                return Err(LinearisationError::Bristles { interface });
            }
        }
        let mut y = Vec::new();
        self.pack_into(&mut y);
        let time = self.now.time;
        self.workspace.loads.clear();
        let now = self.evaluate(time, &y, inputs, false)?;
        if model.topology.closures() > 0 && now.distance < SINGULAR {
            return Err(LinearisationError::Singular { distance: now.distance });
        }
        let n = model.topology.dofs();
        let Scratch { situation, solved, .. } = &mut *self.workspace;
        let dense = solved.balance.make_dense(model, situation).map_err(Unsolved::Massless);
        dense.map_err(|u| model.unsolved(time, u))?;
        let basis = solved.balance.null_space().to_vec();
        let (coordinates, directions, local) = self.independent(&basis)?;
        if coordinates.is_empty() {
            let sticks = self.modes.iter().filter(|mode| **mode == InterfaceMode::Sticks).count();
            let held = match sticks {
                0 => "the constraints leave no degree of freedom".to_owned(),
                _ => format!("friction holds it (interfaces that stick: {sticks})"),
            };
            return Err(LinearisationError::Held { held });
        }
        debug_assert!(directions.iter().all(|d| d.len() == n));
        let motion = coordinates
            .iter()
            .map(|&(joint, dof)| model.joint_motion(&now.state, &now.bodies, joint, dof))
            .collect();
        let inputs_of: Vec<usize> =
            (0..model.topology.actuators.len()).filter(|a| !model.prescribed.contains(a)).collect();
        let mut lin = Linearisation {
            motion,
            by_position: Vec::new(),
            by_rate: Vec::new(),
            by_effort: Vec::new(),
            outputs: Vec::new(),
            positions: model
                .topology
                .actuators
                .iter()
                .map(|a| model.joint_coordinate(&now.state, &now.bodies, JointId(a.joint), a.dof))
                .collect(),
            efforts: now.drives.clone(),
            modes: self.modes.clone(),
            local,
            error: 0.0,
            inputs: inputs_of,
            coordinates,
            directions,
        };
        let force = self.force_scale();
        let (count, actuators) = (lin.coordinates.len(), model.topology.actuators.len());
        let mut columns = |changes: Vec<(Change, f64)>, lin: &mut Linearisation| {
            let mut all = Vec::new();
            let (mut largest, mut worst) = (0.0_f64, 0.0_f64);
            for (change, scale) in changes {
                let (column, error) = self.difference(lin, change, scale, inputs)?;
                let size = column.0.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                (largest, worst) = (largest.max(size), worst.max(error));
                all.push(column);
            }
            if largest > 0.0 {
                lin.error = lin.error.max(worst / largest);
            }
            Ok::<_, LinearisationError>(all)
        };
        let scale = |k: usize| match translates(model, lin.coordinates[k]) {
            true => model.parameters.length,
            false => 1.0,
        };
        let scales: Vec<f64> = (0..count).map(scale).collect();
        let rate = self_rate(model);
        let positions = (0..count).map(|k| (Change::Position(k), FIRST_STEP * scales[k])).collect();
        let rates = (0..count).map(|k| (Change::Rate(k), FIRST_STEP * scales[k] * rate)).collect();
        let efforts: Vec<_> = lin
            .inputs
            .iter()
            .map(|&a| {
                let actuator = model.topology.actuators[a];
                let at = (JointId(actuator.joint), actuator.dof);
                let arm = if translates(model, at) { 1.0 } else { model.parameters.length };
                (Change::Effort(a), FIRST_STEP * force * arm)
            })
            .collect();
        let by_position = columns(positions, &mut lin)?;
        let (by_rate, by_effort) = match moves {
            true => (columns(rates, &mut lin)?, columns(efforts, &mut lin)?),
            false => (Vec::new(), Vec::new()),
        };
        let rows = |columns: &[Beside], count: usize, of: fn(&Beside) -> &Vec<f64>| {
            (0..count)
                .map(|row| columns.iter().map(|column| of(column)[row]).collect())
                .collect::<Vec<Vec<f64>>>()
        };
        lin.by_position = rows(&by_position, count, |b| &b.0);
        lin.outputs = rows(&by_position, actuators, |b| &b.1);
        for (row, actuator) in lin.outputs.iter_mut().zip(&model.topology.actuators) {
            let own = (JointId(actuator.joint), actuator.dof);
            if let Some(k) = lin.coordinates.iter().position(|at| *at == own) {
                row.fill(0.0);
                row[k] = 1.0;
            }
        }
        lin.by_rate = rows(&by_rate, count, |b| &b.0);
        lin.by_effort = rows(&by_effort, count, |b| &b.0);
        Ok(lin)
    }

    /// Returns a state at rest whose independent coordinates differ from the operating point by
    /// `change`, rad or m.
    ///
    /// # Errors
    /// [`ForwardError::Open`] if the loops cannot be closed at the displaced configuration.
    pub fn displaced(
        &mut self,
        lin: &Linearisation,
        change: &[f64],
        inputs: &mut dyn Inputs,
    ) -> Result<State<f64>, ForwardError> {
        let rates = vec![0.0; change.len()];
        self.state_beside(lin, change, Some(&rates), inputs)
    }

    /// Returns the characteristic force that scales the difference steps of efforts, N: the weight
    /// of the mechanism, but at least one newton.
    fn force_scale(&self) -> f64 {
        let bodies = self.model.simulated().bodies();
        let mass: f64 = bodies.iter().map(|body| body.mass).sum();
        (mass * self.model.parameters.gravity.norm()).max(1.0)
    }

    /// Selects independent joint coordinates for the motions in `basis` (null space of the
    /// constraints), actuated coordinates first. Returns the coordinates, the rates of the spanning
    /// tree for a unit rate of each coordinate, and the number of local degrees of freedom.
    #[allow(clippy::type_complexity)]
    fn independent(
        &self,
        basis: &[f64],
    ) -> Result<(Vec<(JointId, usize)>, Vec<Vec<f64>>, usize), LinearisationError> {
        let (model, topology) = (self.model, &self.model.topology);
        let n = topology.dofs().max(1);
        let free = basis.len() / n;
        let is_actuated =
            |at: (usize, usize)| topology.actuators.iter().any(|a| (a.joint, a.dof) == at);
        let mut candidates: Vec<(usize, usize)> = Vec::new();
        let joints = model.mechanism.joints().len();
        for (joint, joint_type) in topology.joint_types[..joints].iter().enumerate() {
            if joint_type.has_scalar_coordinates() {
                candidates.extend((0..joint_type.dofs().len()).map(|dof| (joint, dof)));
            }
        }
        let mut bodies = Bodies::new(topology);
        bodies.place(topology, &model.parameters, &self.now.state.coordinates);
        let mut rows = DMatrix::<f64>::zeros(candidates.len(), free);
        for (k, vector) in basis.chunks_exact(n).enumerate() {
            bodies.move_with(topology, vector);
            for (row, &(joint, dof)) in candidates.iter().enumerate() {
                let own = (JointId(joint), dof);
                let unit = if translates(model, own) { model.parameters.length } else { 1.0 };
                rows[(row, k)] = bodies.joint_rates(topology, joint)[dof] / unit;
            }
        }
        let largest = rows.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        // Selects rows by orthogonalisation with pivoting.
        let mut rest = rows.clone();
        let mut chosen: Vec<usize> = Vec::new();
        while chosen.len() < free {
            let size = |row: usize| rest.row(row).norm();
            let best = |actuated: bool| {
                (0..candidates.len())
                    .filter(|row| !actuated || is_actuated(candidates[*row]))
                    .max_by(|a, b| size(*a).total_cmp(&size(*b)))
            };
            let pick = best(true)
                .filter(|row| size(*row) > PREFERRED * largest)
                .or_else(|| best(false))
                .filter(|row| size(*row) > DEPENDENT * largest);
            let Some(row) = pick else { break };
            let unit = rest.row(row).normalize();
            for other in 0..candidates.len() {
                let along = rest.row(other).dot(&unit);
                let reduced = rest.row(other) - &unit * along;
                rest.set_row(other, &reduced);
            }
            chosen.push(row);
        }
        chosen.sort_unstable();
        self.check_local(basis, &rows, &chosen)?;
        let picked = DMatrix::from_fn(chosen.len(), free, |i, k| rows[(chosen[i], k)]);
        let gram = (&picked * picked.transpose()).lu();
        let mut directions = Vec::with_capacity(chosen.len());
        let coordinates: Vec<(JointId, usize)> =
            chosen.iter().map(|&row| (JointId(candidates[row].0), candidates[row].1)).collect();
        for (i, &own) in coordinates.iter().enumerate() {
            let unit = if translates(model, own) { model.parameters.length } else { 1.0 };
            let mut target = DVector::zeros(chosen.len());
            target[i] = 1.0 / unit;
            let amounts = gram.solve(&target).ok_or(LinearisationError::NoCoordinate)?;
            let amounts = picked.transpose() * amounts;
            let mut direction = vec![0.0; n];
            for (vector, amount) in basis.chunks_exact(n).zip(amounts.iter()) {
                direction.iter_mut().zip(vector).for_each(|(d, z)| *d += amount * z);
            }
            directions.push(direction);
        }
        Ok((coordinates, directions, free - chosen.len()))
    }

    /// Checks that every motion in `basis` that changes none of the selected coordinates is a local
    /// spin, which moves neither joints nor centres of mass.
    fn check_local(
        &self,
        basis: &[f64],
        rows: &DMatrix<f64>,
        chosen: &[usize],
    ) -> Result<(), LinearisationError> {
        let (model, topology) = (self.model, &self.model.topology);
        let n = topology.dofs().max(1);
        let free = basis.len() / n;
        let mut bodies = Bodies::new(topology);
        bodies.place(topology, &model.parameters, &self.now.state.coordinates);
        let picked = DMatrix::from_fn(chosen.len(), free, |i, k| rows[(chosen[i], k)]);
        let gram = (&picked * picked.transpose()).lu();
        let mut axes: Vec<Option<Vec3<f64>>> = vec![None; bodies.twist.len()];
        for k in 0..free {
            // Component of a basis vector that changes none of the selected coordinates.
            let mut amounts = DVector::zeros(free);
            amounts[k] = 1.0;
            if !chosen.is_empty() {
                let seen =
                    gram.solve(&(&picked * &amounts)).ok_or(LinearisationError::NoCoordinate)?;
                amounts -= picked.transpose() * seen;
            }
            let mut rates = vec![0.0; n];
            for (vector, amount) in basis.chunks_exact(n).zip(amounts.iter()) {
                rates.iter_mut().zip(vector).for_each(|(r, z)| *r += amount * z);
            }
            bodies.move_with(topology, &rates);
            let size = |v: Vec3<f64>| v.norm() / model.parameters.length;
            // A local spin keeps the centre of mass in place and has a single axis. A body that is
            // free to rotate in a ball joint has several axes, and its rotation is not local.
            for (body, twist) in bodies.twist.iter().enumerate() {
                let centre = bodies.pose[body].apply(model.parameters.com[body]);
                let turn = twist.angular;
                if size(twist.velocity_at(centre)) > 1e-6 {
                    return Err(LinearisationError::NoCoordinate);
                }
                if turn.norm() > 1e-6 {
                    let axis = *axes[body].get_or_insert(turn);
                    if axis.cross(turn).norm() > 1e-6 * axis.norm() {
                        return Err(LinearisationError::NoCoordinate);
                    }
                }
            }
            let moves = (0..topology.joint_types.len()).any(|joint| {
                let at = bodies.frame_k[joint].position;
                let (_, successor) = topology.ends[joint];
                size(bodies.twist[successor].velocity_at(at)) > 1e-6
            });
            if moves {
                return Err(LinearisationError::NoCoordinate);
            }
        }
        Ok(())
    }
}

/// Returns the characteristic rate, 1/s: the natural frequency of a pendulum of the characteristic
/// length, but at least 1/s.
fn self_rate(model: &crate::forward::Forward) -> f64 {
    (model.parameters.gravity.norm() / model.parameters.length).sqrt().max(1.0)
}

fn translates(model: &crate::forward::Forward, (joint, dof): (JointId, usize)) -> bool {
    model.topology.joint_types[joint.0].dofs()[dof].translates()
}
