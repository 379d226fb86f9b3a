//! Numerical derivatives of the accelerations at the operating point.

use super::super::Simulation;
use super::{Linearisation, LinearisationError, translates};
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::error::ForwardError;
use crate::forward::inputs::{Inputs, View};
use crate::kinematics::{Bodies, State, Target};
use crate::mechanism::JointId;
use crate::statics::AppliedLoad;

/// Largest number of step sizes for which a difference quotient is computed. Each step size is a
/// quarter of the previous step size.
const STEPS: usize = 24;
/// Weights of the central difference of order six for the points one, two and three steps from the
/// centre.
const STENCIL: [f64; 3] = [0.75, -0.15, 1.0 / 60.0];
/// Largest number of iterations that correct the independent coordinates and close the loops again.
const CORRECTIONS: usize = 12;

/// Inputs in which the effort of one actuator is changed by a constant amount, N or N m.
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

/// Variable that is changed for a difference quotient, with its index: an independent coordinate,
/// the rate of an independent coordinate, or the effort of an actuator.
#[derive(Clone, Copy)]
pub(super) enum Change {
    Position(usize),
    Rate(usize),
    Effort(usize),
}

/// Accelerations of the independent coordinates, and displacements of the actuator coordinates from
/// the operating point, at a state near this point; or the derivatives of both.
pub(super) type Beside = (Vec<f64>, Vec<f64>);

impl Simulation<'_> {
    /// Returns the state whose independent coordinates differ from the operating point by `change`.
    /// The rates of these coordinates are `rates`, or the rates at the operating point if `rates`
    /// is `None`.
    pub(super) fn state_beside(
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

    /// Evaluates the accelerations of the independent coordinates, and the displacements of the
    /// actuator coordinates, after one variable has been changed by `amount`. Returns `None` if a
    /// sliding interface would reverse.
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
        // The derivatives are valid only while no sliding interface reverses.
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

    /// Returns the derivatives of the accelerations and actuator coordinates with respect to one
    /// variable, and the estimated error of the accelerations' derivatives. `first` is the largest
    /// step size of the difference quotients.
    pub(super) fn difference(
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
                        // Round-off errors grow with each smaller step.
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

    /// Lists the interfaces whose mode is slip but whose velocity is zero, so that they are about
    /// to slide.
    fn at_rest(&self) -> Vec<usize> {
        let speed =
            |c: usize| self.now.interfaces[c].velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        let fastest = (0..self.modes.len()).map(speed).fold(self.fastest, f64::max);
        let slides = |c: &usize| matches!(self.modes[*c], InterfaceMode::Slides(_));
        let slow = (0..self.modes.len()).filter(slides).filter(|c| speed(*c) <= 1e-6 * fastest);
        slow.collect()
    }

    /// Returns the central difference quotients of order six with respect to one variable, for the
    /// step size `step`. Returns `None` if a sliding interface would reverse.
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

/// Reduces an angle difference to the range from -pi to pi by full turns. Returns a length
/// difference unchanged.
fn nearest_turn(model: &crate::forward::Forward, at: (JointId, usize), change: f64) -> f64 {
    if translates(model, at) {
        return change;
    }
    let turn = std::f64::consts::TAU;
    change - turn * (change / turn).round()
}
