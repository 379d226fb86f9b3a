//! Linearisation of the equations of motion in independent coordinates.
//!
//! Derivatives are central differences of order six of the accelerations, with closed loops and with the present modes
//! of the friction interfaces. Each step length is a quarter of the previous one, and the estimate that differs least
//! from its successor is taken; the difference estimates the error.

use super::scratch::Scratch;
use super::{Method, Simulation};
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::error::ForwardError;
use crate::forward::inputs::{Inputs, View};
use crate::forward::solve::Unsolved;
use crate::kinematics::{Bodies, State, Target};
use crate::mechanism::JointId;
use crate::spatial::Vec3;
use crate::statics::AppliedLoad;
use nalgebra::{DMatrix, DVector};

/// A joint coordinate counts as dependent if the part of its rate that is independent of the
/// coordinates already chosen is below this fraction of the largest rate of any coordinate.
const DEPENDENT: f64 = 1e-6;
/// Actuated coordinates are chosen before others as long as the independent part of their rate
/// exceeds this fraction of the largest rate of any coordinate.
const PREFERRED: f64 = 1e-2;
/// No linearisation is computed below this singularity distance of the constraints.
const SINGULAR: f64 = 1e-6;
/// Longest first step of a difference: rad or characteristic lengths for positions, rad or
/// characteristic lengths per characteristic time for rates.
const FIRST_STEP: f64 = 2e-2;
/// Largest number of step lengths, each of which is a quarter of the previous one.
const STEPS: usize = 24;
/// Coefficients of the central difference of order six, for one, two and three steps from the centre.
const STENCIL: [f64; 3] = [0.75, -0.15, 1.0 / 60.0];
/// Largest number of corrections that restore the independent coordinates after the loops are closed.
const CORRECTIONS: usize = 12;

/// Reason for which an operating point has no linearisation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinearisationError {
    /// Friction, locks and prescribed motions prevent every motion.
    #[error("the mechanism cannot move at this position: {held}")]
    Held {
        /// The constraint that holds the mechanism, in words.
        held: String,
    },
    /// The constraints lose rank at the operating point.
    #[error(
        "the position is singular: the loop constraints lose rank (singularity index \
         {distance:.1e}), so the accelerations have no derivatives"
    )]
    Singular {
        /// Singularity distance.
        distance: f64,
    },
    /// The friction of an interface at rest is at its limit.
    #[error(
        "friction interface {interface} is at rest at its static friction limit: opposite \
         disturbances cause different motions, so there is no linearisation"
    )]
    AtLimit {
        /// Index of the friction interface.
        interface: usize,
    },
    /// The friction law of an interface has internal states.
    #[error(
        "the friction law of interface {interface} has bristles (dahl, lugre), whose deflections \
         are further states that the linearisation does not include"
    )]
    Bristles {
        /// Index of the friction interface.
        interface: usize,
    },
    /// No acceleration satisfies the friction laws at the operating point.
    #[error("no acceleration satisfies all friction laws at this state")]
    NoAcceleration,
    /// Interfaces begin to slide from rest, so the motion differs on both sides of the operating point.
    #[error(
        "friction interfaces begin to slide from rest at this state: opposite disturbances cause \
         different motions, so there is no linearisation"
    )]
    BeginsToSlide {
        /// Indices of the friction interfaces.
        interfaces: Vec<usize>,
    },
    /// A motion of the mechanism changes no joint coordinate.
    #[error(
        "a motion of the mechanism has no joint coordinate that describes it, such as that of a free \
         body or of a ball joint; replace the ball joint by revolute joints or a universal joint"
    )]
    NoCoordinate,
    /// Accelerations cannot be evaluated at positions or rates near the operating point.
    #[error("{0}")]
    Forward(#[from] ForwardError),
}

/// Linear equations of motion about an operating point: `dq/dt = v`, `dv/dt = a0 + K q + D v + B u`, outputs `y = C q`.
/// Here `q` and `v` are the deviations of the independent coordinates and their rates from the operating point, and `u`
/// those of the efforts.
#[derive(Clone, Debug)]
pub struct Linearisation {
    /// Independent joint coordinates: joint and index of the degree of freedom.
    pub coordinates: Vec<(JointId, usize)>,
    /// Position (rad or m), rate and acceleration of each independent coordinate at the operating point.
    pub motion: Vec<Target<f64>>,
    /// Matrix `K`: derivatives of the accelerations with respect to the independent coordinates, row by row.
    pub by_position: Vec<Vec<f64>>,
    /// Matrix `D`: derivatives of the accelerations with respect to the rates, row by row.
    pub by_rate: Vec<Vec<f64>>,
    /// Matrix `B`: derivatives of the accelerations with respect to the efforts of [`Self::inputs`], row by row.
    pub by_effort: Vec<Vec<f64>>,
    /// Indices of the actuators that exert efforts.
    pub inputs: Vec<usize>,
    /// Matrix `C`: derivatives of the positions of all actuators with respect to the independent coordinates, row by
    /// row.
    pub outputs: Vec<Vec<f64>>,
    /// Positions of all actuators at the operating point, rad or m.
    pub positions: Vec<f64>,
    /// Efforts of all actuators at the operating point, N or N m.
    pub efforts: Vec<f64>,
    /// Modes of the friction interfaces, which the linearisation assumes constant.
    pub modes: Vec<InterfaceMode>,
    /// Number of local degrees of freedom that the linearisation omits, such as the spin of a rod about its own axis.
    pub local: usize,
    /// Largest estimated error of a derivative, relative to the largest entry of its matrix.
    pub error: f64,
    /// Rates of the tree for a unit rate of each independent coordinate.
    directions: Vec<Vec<f64>>,
}

/// Inputs with one effort changed by a constant amount.
struct Nudged<'a> {
    inner: &'a mut dyn Inputs,
    actuator: usize,
    amount: f64,
}

impl Inputs for Nudged<'_> {
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        self.inner.efforts(view, efforts);
        if let Some(effort) = efforts.get_mut(self.actuator) {
            *effort += self.amount;
        }
    }

    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        self.inner.targets(time, targets);
    }

    fn loads(&mut self, view: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        self.inner.loads(view, loads);
    }
}

/// Variable with respect to which a difference is taken.
#[derive(Clone, Copy)]
enum Change {
    Position(usize),
    Rate(usize),
    Effort(usize),
}

/// Accelerations of the independent coordinates, and actuator positions, near the operating point.
type Beside = (Vec<f64>, Vec<f64>);

impl Simulation<'_> {
    /// Linearises the equations of motion about the present instant, with the present modes of the friction interfaces.
    ///
    /// # Errors
    /// See [`LinearisationError`].
    pub fn linearise(
        &mut self,
        inputs: &mut dyn Inputs,
    ) -> Result<Linearisation, LinearisationError> {
        self.linearised(inputs, true)
    }

    /// Linearises as [`Self::linearise`], but computes derivatives with respect to positions only; those with respect
    /// to rates and efforts are empty.
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

    /// Returns a state at rest near the operating point, whose independent coordinates differ from it by `change`, rad
    /// or m.
    ///
    /// # Errors
    /// [`ForwardError::Open`] if the loops cannot be closed there.
    pub fn displaced(
        &mut self,
        lin: &Linearisation,
        change: &[f64],
        inputs: &mut dyn Inputs,
    ) -> Result<State<f64>, ForwardError> {
        let rates = vec![0.0; change.len()];
        self.state_beside(lin, change, Some(&rates), inputs)
    }

    /// Force scale of the first effort step, N: the weight of the mechanism, at least one newton.
    fn force_scale(&self) -> f64 {
        let bodies = self.model.simulated().bodies();
        let mass: f64 = bodies.iter().map(|body| body.mass).sum();
        (mass * self.model.parameters.gravity.norm()).max(1.0)
    }

    /// Chooses independent joint coordinates for the motions in `basis` (null space of the constraints), actuated
    /// coordinates first. Returns the coordinates, the tree rates for a unit rate of each, and the number of local
    /// degrees of freedom.
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
        // Pivoted orthogonalisation of the rows.
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

    /// Checks that every motion in `basis` that changes none of the chosen coordinates is a local spin: it moves
    /// neither joints nor centres of mass.
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
            // Component of a basis vector that changes none of the chosen coordinates.
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
            // A spin keeps the centre of mass in place and has one axis; a body in a ball joint tumbles.
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

    /// Returns the state whose independent coordinates differ from the operating point by `change`. Their rates are
    /// `rates`, or those of the operating point if `rates` is `None`.
    fn state_beside(
        &mut self,
        lin: &Linearisation,
        change: &[f64],
        rates: Option<&[f64]>,
        inputs: &mut dyn Inputs,
    ) -> Result<State<f64>, ForwardError> {
        let (model, time) = (self.model, self.now.time);
        let targets = model.targets(time, inputs);
        let mut state = self.now.state.clone();
        let topology = &model.topology;
        let along = |amounts: &[f64]| {
            let mut sum = vec![0.0; topology.dofs()];
            for (direction, amount) in lin.directions.iter().zip(amounts) {
                sum.iter_mut().zip(direction).for_each(|(s, d)| *s += amount * d);
            }
            sum
        };
        let mut bodies = Bodies::new(topology);
        let wanted: Vec<(f64, f64)> = lin
            .motion
            .iter()
            .enumerate()
            .map(|(k, motion)| (motion.value + change[k], rates.map_or(motion.rate, |r| r[k])))
            .collect();
        if rates.is_some_and(|rates| rates.iter().all(|rate| *rate == 0.0)) {
            state.rates.fill(0.0);
        }
        let mut missing: (Vec<f64>, Vec<f64>) = (change.to_vec(), vec![0.0; change.len()]);
        let mut before = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            state.advance(topology, &along(&missing.0));
            let more = along(&missing.1);
            state.rates.iter_mut().zip(&more).for_each(|(rate, more)| *rate += more);
            model.project(time, &mut state, &targets, &self.anchors, &self.frozen)?;
            bodies.place(topology, &model.parameters, &state.coordinates);
            bodies.move_with(topology, &state.rates);
            let mut worst = 0.0_f64;
            for (k, &(joint, dof)) in lin.coordinates.iter().enumerate() {
                let has = model.joint_motion(&state, &bodies, joint, dof);
                missing.0[k] = nearest_turn(model, (joint, dof), wanted[k].0 - has.value);
                missing.1[k] = wanted[k].1 - has.rate;
                worst = worst.max(missing.0[k].abs()).max(missing.1[k].abs());
            }
            if worst == 0.0 || worst >= 0.5 * before && worst < 1e-12 {
                break;
            }
            before = worst;
        }
        Ok(state)
    }

    /// Evaluates the accelerations of the independent coordinates and the positions of the actuators with one variable
    /// changed by `amount`. `None` if a sliding interface would reverse.
    fn beside(
        &mut self,
        lin: &Linearisation,
        change: Change,
        amount: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<Beside>, ForwardError> {
        let (model, time) = (self.model, self.now.time);
        let mut shift = vec![0.0; lin.coordinates.len()];
        let state = match change {
            Change::Position(k) => {
                shift[k] = amount;
                self.state_beside(lin, &shift, None, inputs)?
            }
            Change::Rate(k) => {
                let mut rates: Vec<f64> = lin.motion.iter().map(|motion| motion.rate).collect();
                rates[k] += amount;
                self.state_beside(lin, &shift, Some(&rates), inputs)?
            }
            Change::Effort(_) => self.now.state.clone(),
        };
        let mut y = Vec::new();
        self.pack_into(&mut y);
        let (coordinates, rest) = y.split_at_mut(state.coordinates.len());
        coordinates.copy_from_slice(&state.coordinates);
        rest[..state.rates.len()].copy_from_slice(&state.rates);
        let at = match change {
            Change::Effort(actuator) => {
                self.evaluate(time, &y, &mut Nudged { inner: inputs, actuator, amount }, false)?
            }
            _ => self.evaluate(time, &y, inputs, false)?,
        };
        // A sliding interface must not reverse.
        let reverses = self.modes.iter().zip(&at.interfaces).any(|(mode, interface)| match mode {
            InterfaceMode::Slides(direction) => {
                let along = interface.velocity.iter().zip(direction).map(|(v, d)| v * d);
                along.sum::<f64>() <= 0.0
            }
            _ => false,
        });
        if reverses {
            self.workspace.spare(at);
            return Ok(None);
        }
        let motion =
            |joint: JointId, dof: usize| model.joint_motion(&at.state, &at.bodies, joint, dof);
        let accelerations =
            lin.coordinates.iter().map(|&(joint, dof)| motion(joint, dof).acceleration);
        let positions = model.topology.actuators.iter().map(|actuator| {
            let at = (JointId(actuator.joint), actuator.dof);
            let value = motion(at.0, at.1).value;
            let base = model.joint_motion(&self.now.state, &self.now.bodies, at.0, at.1).value;
            nearest_turn(model, at, value - base)
        });
        Ok(Some((accelerations.collect(), positions.collect())))
    }

    /// Returns the derivative with respect to one variable, and its estimated error; `first` is the longest step.
    fn difference(
        &mut self,
        lin: &Linearisation,
        change: Change,
        first: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<(Beside, f64), LinearisationError> {
        let mut best: Option<(Beside, f64)> = None;
        let mut before: Option<Beside> = None;
        let mut failed = None;
        let mut step = first;
        for _ in 0..STEPS {
            let estimate = self.central(lin, change, step, inputs);
            step *= 0.25;
            let estimate = match estimate {
                Ok(Some(estimate)) => estimate,
                Ok(None) => continue,
                Err(error) => {
                    failed = Some(error);
                    continue;
                }
            };
            if let Some(before) = &before {
                let apart = estimate.0.iter().zip(&before.0).map(|(a, b)| (a - b).abs());
                let apart = apart.fold(0.0_f64, f64::max);
                match &best {
                    Some((_, least)) if apart >= *least => {
                        // Rounding errors grow with each shorter step.
                        if apart > 4.0 * least {
                            break;
                        }
                    }
                    _ => best = Some((before.clone(), apart)),
                }
                if apart == 0.0 {
                    break;
                }
            }
            before = Some(estimate);
        }
        match (best, failed) {
            (Some(best), _) => Ok(best),
            (None, Some(error)) => Err(error.into()),
            (None, None) => Err(LinearisationError::BeginsToSlide { interfaces: self.at_rest() }),
        }
    }

    /// Lists the interfaces whose mode is slip but whose velocity is zero: they begin to slide.
    fn at_rest(&self) -> Vec<usize> {
        let speed =
            |c: usize| self.now.interfaces[c].velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        let fastest = (0..self.modes.len()).map(speed).fold(self.fastest, f64::max);
        let slides = |c: &usize| matches!(self.modes[*c], InterfaceMode::Slides(_));
        let slow = (0..self.modes.len()).filter(slides).filter(|c| speed(*c) <= 1e-6 * fastest);
        slow.collect()
    }

    /// Central difference of order six with respect to one variable; `None` if a sliding interface would reverse.
    fn central(
        &mut self,
        lin: &Linearisation,
        change: Change,
        step: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<Option<Beside>, ForwardError> {
        let mut sum: Option<Beside> = None;
        for (k, weight) in STENCIL.iter().enumerate() {
            for side in [1.0, -1.0] {
                let amount = side * (k + 1) as f64 * step;
                let Some(at) = self.beside(lin, change, amount, inputs)? else {
                    return Ok(None);
                };
                let factor = side * weight / step;
                let sum = sum.get_or_insert_with(|| (vec![0.0; at.0.len()], vec![0.0; at.1.len()]));
                sum.0.iter_mut().zip(&at.0).for_each(|(s, x)| *s += factor * x);
                sum.1.iter_mut().zip(&at.1).for_each(|(s, x)| *s += factor * x);
            }
        }
        Ok(sum)
    }
}

/// Characteristic rate, 1/s: the natural frequency of a pendulum of the characteristic length, at least one.
fn self_rate(model: &crate::forward::Forward) -> f64 {
    (model.parameters.gravity.norm() / model.parameters.length).sqrt().max(1.0)
}

fn translates(model: &crate::forward::Forward, (joint, dof): (JointId, usize)) -> bool {
    model.topology.joint_types[joint.0].dofs()[dof].translates()
}

/// Reduces the difference of a coordinate: an angle to the range from -pi to pi by full turns; a length is unchanged.
fn nearest_turn(model: &crate::forward::Forward, at: (JointId, usize), change: f64) -> f64 {
    if translates(model, at) {
        return change;
    }
    let turn = std::f64::consts::TAU;
    change - turn * (change / turn).round()
}
