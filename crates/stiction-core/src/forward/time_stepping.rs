//! Time step of Moreau's method (Moreau 1988, Jean 1999): the unknowns are velocities, and the
//! friction laws hold at the end of the step.
//!
//! With the mass matrix `M` of the spanning tree and the constraint Jacobian `J`, both at the
//! middle of the step, the length `h` of the step, and the velocities `v` before and `w` after the
//! step:
//!
//! ```text
//! M (w - v) = h (efforts and loads) + J^T (impulses of loops and prescribed actuators) + (impulses of friction)
//! ```
//!
//! The velocities `w` satisfy the constraints: `J w` is zero for loops and gearings, and equals the
//! prescribed rate for prescribed actuators. The friction laws relate the friction impulses to `w`.
//! The friction of each interface is bounded by the reaction of the same joint in the same step.
//! Stick onset and reversals within the step need no event detection. A sticking interface has zero
//! velocity at the end of the step. Velocities may jump if friction requires it.
//!
//! Equation (D7) of the book's theory.

use super::Forward;
use super::affine_friction::{InterfaceMode, is_smooth, mode_of, norm};
use super::balance::{Balance, Massless, Response};
use super::complementarity::Members;
use super::data::{Data, FrictionDistribution};
use super::error::ForwardError;
use super::inputs::{InputState, Inputs};
use super::mass_matrix::{MassMatrix, damped, power_of_loads};
use super::simulation::Energies;
use super::solve::Unsolved;
use crate::friction::{Bristles, Law};
use crate::friction_problem::complementarity::{
    DryFriction, Member, MemberLaw, SmoothFriction, Solution,
};
use crate::kinematics::{State, Target};
use crate::linalg::largest;
use crate::parameters::InterfaceParameters;

/// Largest accepted residual of the friction laws, relative to the largest force.
const RESIDUAL: f64 = 1e-9;
/// Weight of the residual rates of sticking interfaces relative to the residual forces, in the
/// residual that [`RESIDUAL`] limits. Accepted residual rates are at most 1e-6 of the largest rate.
const SLACK: f64 = 1e-3;

/// In a velocity jump, largest accepted rate of a sticking interface, relative to the largest rate
/// without friction. Residuals are relative to the largest force; with a self-stress of 1e20 N,
/// interfaces that move as before the jump would count as sticking.
const STUCK: f64 = 1e-6;

/// Weight of the bias accelerations (velocity terms) of constraints and surfaces, whose directions change from
/// the middle of a step to its end. They belong to the velocities before the step, so in a velocity jump they
/// are left out: where a joint reverses, they would permit that the mechanism bounces back without losing
/// energy.
const BIAS: f64 = 0.5;
/// Least change of the rates in a velocity jump, relative to the largest rate before the step.
const JUMPS: f64 = 0.1;

/// If a friction exceeds the largest force without friction by this factor, the friction is part of
/// a velocity jump.
const IMPULSIVE: f64 = 1e3;

/// In a velocity jump, the solution from the continuation replaces another one if its largest friction
/// is less than this fraction of the other's.
const LESS_STRESS: f64 = 1e-3;

/// Results of a time step.
pub(super) struct TimeStep {
    /// State at the end of the step, before projection onto the constraints.
    pub(super) state: State<f64>,
    pub(super) modes: Vec<InterfaceMode>,
    /// Bristle deflections of each interface at the end of the step, m.
    pub(super) bristles: Vec<[f64; 3]>,
    /// Internal states of the inputs at the end of the step.
    pub(super) input_states: Vec<f64>,
    /// Sliding velocities at the surfaces at the end of the step, m/s.
    pub(super) velocities: Vec<[f64; 3]>,
    /// Friction forces at the surfaces, averaged over the step, N.
    pub(super) frictions: Vec<[f64; 3]>,
    /// Normal loads of the interfaces, averaged over the step, N.
    pub(super) loads: Vec<f64>,
    /// Actuator efforts, averaged over the step, N or N m.
    pub(super) drives: Vec<f64>,
    pub(super) response: Response,
    /// Masses at the middle of the step.
    pub(super) masses: MassMatrix,
    /// Largest rate of the spanning tree at the end of the step if friction were absent, rad/s or
    /// characteristic lengths per second.
    pub(super) free_rate: f64,
    /// Work done and energy dissipated in the step, J.
    pub(super) work: Energies,
    /// True if friction is so large that velocities jump.
    pub(super) is_impulsive: bool,
    pub(super) redundant: usize,
    pub(super) open_drives: usize,
    pub(super) mobility: usize,
    pub(super) distance: f64,
}

/// State at the start of a time step.
#[derive(Clone, Copy)]
pub(super) struct StepStart<'a> {
    pub(super) state: &'a State<f64>,
    pub(super) modes: &'a [InterfaceMode],
    /// Bristle deflections of each interface, m.
    pub(super) bristles: &'a [[f64; 3]],
    /// Initial guess of the friction forces at the surfaces, N.
    pub(super) frictions: &'a [[f64; 3]],
    /// Internal states of the inputs, signs of their switching functions, and unwrapped joint
    /// angles.
    pub(super) input: &'a InputState,
}

/// Regularised friction law, a smooth function of velocity.
#[derive(Clone, Debug)]
struct Regularised {
    interface: InterfaceParameters<f64>,
}

impl SmoothFriction for Regularised {
    fn friction(&self, load: f64, velocity: [f64; 3]) -> [f64; 3] {
        let speed = norm(velocity);
        if speed == 0.0 {
            return [0.0; 3];
        }
        let resistance = self.interface.law_towards(velocity[0]).sliding(speed);
        velocity.map(|v| v / speed * resistance.force(load))
    }
    fn boxed(&self) -> Box<dyn SmoothFriction> {
        Box::new(self.clone())
    }
}

/// Bristle law whose deflection at the end of the step follows from the velocity at the end of the
/// step (implicit Euler).
#[derive(Clone, Debug)]
struct BristleStep {
    interface: InterfaceParameters<f64>,
    bristles: Bristles,
    before: [f64; 3],
    step: f64,
}

impl BristleStep {
    fn deflection(&self, velocity: [f64; 3]) -> [f64; 3] {
        let speed = norm(velocity);
        let coefficient = self.interface.law_towards(velocity[0]).coefficient(speed);
        let decay = self.bristles.stiffness * speed / coefficient;
        [0, 1, 2].map(|i| (self.before[i] + self.step * velocity[i]) / (1.0 + self.step * decay))
    }
}

impl SmoothFriction for BristleStep {
    fn friction(&self, load: f64, velocity: [f64; 3]) -> [f64; 3] {
        let after = self.deflection(velocity);
        let viscous = self.interface.law_towards(velocity[0]).viscous;
        [0, 1, 2].map(|i| {
            let rate = (after[i] - self.before[i]) / self.step;
            load * self.bristles.coefficient(after[i], rate) + viscous * velocity[i]
        })
    }
    fn boxed(&self) -> Box<dyn SmoothFriction> {
        Box::new(self.clone())
    }
}

impl Forward {
    /// Computes a time step of length `step`, s, starting at `time`, s.
    ///
    /// # Errors
    /// [`ForwardError::NoChoice`] if no frictions that satisfy all laws are found,
    /// [`ForwardError::Massless`], and [`ForwardError::NotFinite`] if efforts are not finite.
    pub(super) fn time_step(
        &self,
        time: f64,
        step: f64,
        from: StepStart<'_>,
        inputs: &mut dyn Inputs,
    ) -> Result<TimeStep, ForwardError> {
        let found = self.time_step_with(time, step, from, inputs, BIAS);
        if found.as_ref().is_ok_and(|found| !found.is_impulsive) {
            return found;
        }
        let jump = self.time_step_with(time, step, from, inputs, 0.0);
        if jump.as_ref().is_ok_and(|jump| jump.is_impulsive) { jump } else { found }
    }

    /// Computes a time step as [`Self::time_step`], with the weight `bias` of the bias accelerations.
    fn time_step_with(
        &self,
        time: f64,
        step: f64,
        from: StepStart<'_>,
        inputs: &mut dyn Inputs,
        bias: f64,
    ) -> Result<TimeStep, ForwardError> {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let start = from.state;
        let mut middle = start.clone();
        let half: Vec<f64> = start.rates.iter().map(|v| 0.5 * step * v).collect();
        middle.advance(topology, &half);
        let data = self.data(
            time + 0.5 * step,
            middle,
            from.bristles,
            &FrictionDistribution::default(),
            (from.input, inputs),
        );
        if !data.efforts.iter().all(|effort| effort.is_finite()) {
            let what = "the effort of an actuator";
            return Err(ForwardError::NotFinite { time, what });
        }
        let ends = self.targets(time + step, inputs);
        let still: Vec<_> = ends.iter().map(|end| Target { acceleration: 0.0, ..*end }).collect();
        let mut rows = self.constraint_rows(&data.bodies, &still, &[]);
        let n = topology.dofs();
        for (index, row) in rows.rows.iter_mut().enumerate() {
            let entries = &rows.matrix[index * n..(index + 1) * n];
            let rate: f64 = entries.iter().zip(&start.rates).map(|(a, b)| a * b).sum();
            let end = index.checked_sub(topology.closures()).map_or(0.0, |k| ends[k].rate);
            // The row is evaluated at the middle of the step and changes until the end of the step;
            // `right` is minus the rate of change of the row.
            row.right = (end - rate) / step + bias * row.right;
        }
        let massless = |m: Massless| self.unsolved(time, Unsolved::Massless(m));
        let balance = Balance::new(self, &data, rows).map_err(massless)?;
        let efforts: Vec<_> = self.actuator_wrenches(&data).collect();
        let base = balance.respond(self, &data, &efforts, true);
        let mut members = Members::new(self, &data, &balance);
        for (interface, mode) in from.modes.iter().enumerate() {
            let joint = parameters.interfaces[interface].joint;
            let wrenches = self.unit_frictions(&data.bodies, interface);
            for &wrench in &wrenches {
                let effort = Some((joint, wrench));
                balance.check_passive_spins(self, &data, effort).map_err(massless)?;
            }
            let law = self.law(&data, interface, *mode, step);
            members.add(interface, law, wrenches);
        }
        let drifting = self.accelerated(&data.bodies, &vec![0.0; n]);
        let free = |interface: usize| {
            let turning = self.surface_acceleration(&drifting, interface);
            let rate =
                |rates: &[f64], place| self.surface_rate(&data.bodies, rates, interface, place);
            let mut free = [0.0; 3];
            for place in 0..parameters.interfaces[interface].shape.dofs().len() {
                free[place] = rate(&start.rates, place)
                    + step * (rate(&base.accelerations, place) + bias * turning[place]);
            }
            free
        };
        let prescribed: Vec<f64> = ends.iter().map(|end| end.rate).collect();
        let mut problem = members.problem(&base, step, free, &prescribed);
        // Redundant rows are consistent to third order in the step; projection removes the
        // remaining error.
        problem.slack = SLACK;
        let mut near: Vec<f64> = problem
            .members
            .iter()
            .flat_map(|m| from.frictions[m.interface][..m.places.len()].to_vec())
            .collect();
        // Frictions in a velocity jump are impulses divided by a short time. Where static frictions
        // are statically indeterminate, a search that starts from such large values would keep them
        // as a self-stress.
        let forces = base.wrenches.iter().map(|wrench| wrench.force.norm());
        let impulsive = IMPULSIVE * forces.fold(0.0, f64::max);
        if largest(&near) > impulsive {
            near.fill(0.0);
        }
        let is_solution = |found: &Solution| {
            found.residual <= RESIDUAL
                && (largest(&found.amounts) <= impulsive || found.residual_slip <= STUCK)
        };
        let mut found = problem.solve_near(&near).filter(is_solution);
        if found.is_none() && near.iter().any(|amount| *amount != 0.0) {
            // After a jump the frictions of the previous step may be a bad initial guess.
            found = problem.solve_near(&vec![0.0; near.len()]).filter(is_solution);
        }
        let found = found.or_else(|| problem.solve_by_continuation().filter(is_solution));
        let Some(mut found) = found else {
            let interface = problem.worst(&near).unwrap_or(0);
            let joint =
                self.joint_name(parameters.interfaces.get(interface).map_or(0, |c| c.joint));
            return Err(ForwardError::NoChoice { time, joint });
        };
        // Where friction stops the mechanism close to a singular position, self-stresses of any size
        // satisfy the laws. Their round-off would spoil the energy balance and even the motion.
        if largest(&found.amounts) > impulsive
            && let Some(other) = problem.solve_from_stick().filter(is_solution)
            && largest(&other.amounts) < LESS_STRESS * largest(&found.amounts)
        {
            found = other;
        }
        let rate = |k: usize| (start.rates[k] + step * base.accelerations[k]) / self.columns[k];
        let free_rate = (0..n).fold(0.0_f64, |m, k| m.max(rate(k).abs()));
        let mut response = base;
        for (unit, amount) in members.units.iter().zip(&found.amounts) {
            response.add(unit, *amount);
        }
        let columns = || response.accelerations.iter().zip(&self.columns);
        let change = columns().fold(0.0_f64, |m, (a, column)| m.max((step * a / column).abs()));
        let rates = start.rates.iter().zip(&self.columns);
        let fastest = rates.fold(0.0_f64, |m, (rate, column)| m.max((rate / column).abs()));
        // In zero gravity, friction may exceed the other forces by far without a jump.
        let is_impulsive = largest(&found.amounts) > impulsive && change > JUMPS * fastest;
        let solution = (&problem.members[..], &found, free_rate);
        let end = self.end_of_step(&data, from, step, solution, (&balance, response));
        Ok(TimeStep { is_impulsive, ..end })
    }

    /// Returns the friction law of an interface at the end of a time step.
    fn law(&self, data: &Data, interface: usize, mode: InterfaceMode, step: f64) -> MemberLaw {
        let content = &self.parameters.interfaces[interface];
        let velocity = data.velocities[interface];
        let law = content.law_towards(velocity[0]);
        if let Some(bristles) = law.bristles {
            let (interface, before) = (content.clone(), data.bristles[interface]);
            return MemberLaw::Smooth(Box::new(BristleStep { interface, bristles, before, step }));
        }
        if law.regularisation.is_some() {
            return MemberLaw::Smooth(Box::new(Regularised { interface: content.clone() }));
        }
        let speed = norm(velocity);
        let slides = matches!(mode, InterfaceMode::Slides(_)) && speed > 0.0;
        let coefficient = |law: &Law| {
            if is_smooth(content) {
                0.0
            } else if slides {
                law.coefficient(speed)
            } else {
                law.at_rest()
            }
        };
        let [forward, backward] = content.laws().map(coefficient);
        MemberLaw::Dry(DryFriction { forward, backward, viscous: law.viscous })
    }

    /// Computes the results of a time step from the solution of the complementarity problem.
    fn end_of_step(
        &self,
        data: &Data,
        from: StepStart<'_>,
        step: f64,
        (members, found, free_rate): (&[Member], &Solution, f64),
        (balance, response): (&Balance, Response),
    ) -> TimeStep {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let (start, count) = (from.state, from.modes.len());
        let mut state = start.clone();
        for (rate, a) in state.rates.iter_mut().zip(&response.accelerations) {
            *rate += step * a;
        }
        let mean: Vec<f64> =
            start.rates.iter().zip(&state.rates).map(|(v, w)| 0.5 * (v + w)).collect();
        let change: Vec<f64> = mean.iter().map(|v| step * v).collect();
        state.advance(topology, &change);
        state.accelerations.clone_from(&response.accelerations);
        let mut bodies = data.bodies.clone();
        bodies.move_with(topology, &mean);
        let (mut modes, mut loads) = (from.modes.to_vec(), vec![0.0; count]);
        let (mut velocities, mut frictions) = (vec![[0.0; 3]; count], vec![[0.0; 3]; count]);
        let mut bristles = data.bristles.clone();
        let mut work = Energies { interfaces: vec![0.0; count], ..Energies::default() };
        for ((member, load), sticks) in members.iter().zip(&found.loads).zip(&found.sticks) {
            let interface = member.interface;
            let content = &parameters.interfaces[interface];
            loads[interface] = *load;
            for (place, i) in member.places.clone().enumerate() {
                velocities[interface][place] = found.rates[i];
                frictions[interface][place] = found.amounts[i];
                let rate = self.surface_rate(&data.bodies, &mean, interface, place);
                work.interfaces[interface] += step * found.amounts[i] * rate;
            }
            if let (MemberLaw::Smooth(_), Some(own)) = (&member.law, content.law.bristles) {
                let before = bristles[interface];
                let interface_step =
                    BristleStep { interface: content.clone(), bristles: own, before, step };
                bristles[interface] = interface_step.deflection(velocities[interface]);
            }
            if is_smooth(content) {
                continue;
            }
            modes[interface] = if *sticks {
                velocities[interface] = [0.0; 3];
                InterfaceMode::Sticks
            } else {
                match mode_of(&found.rates[member.places.clone()], 0.0) {
                    InterfaceMode::AtLimit(direction) => InterfaceMode::Slides(direction),
                    other => other,
                }
            };
        }
        let mut drives = data.efforts.clone();
        for (k, &actuator) in self.prescribed.iter().enumerate() {
            drives[actuator] = response.multipliers[topology.closures() + k];
        }
        let rate = |actuator: usize| bodies.actuator_rate(topology, topology.actuators[actuator]);
        work.drives = drives.iter().enumerate().map(|(k, f)| step * f * rate(k)).collect();
        work.loads = step * power_of_loads(&data.loads, &bodies);
        work.dampers = step * damped(parameters, &bodies);
        TimeStep {
            state,
            modes,
            bristles,
            input_states: {
                let each = from.input.values.iter().zip(&data.input_rates);
                each.map(|(value, rate)| value + step * rate).collect()
            },
            velocities,
            frictions,
            loads,
            drives,
            redundant: balance.redundant(),
            open_drives: balance.redundancy.open_efforts(),
            mobility: balance.mobility(topology.dofs()),
            distance: balance.distance(),
            response,
            masses: data.masses.clone(),
            free_rate,
            work,
            is_impulsive: false,
        }
    }
}
