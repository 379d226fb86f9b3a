//! One step of the nonsmooth time stepper (Moreau 1988, Jean 1999): velocity level, laws at its end.
//!
//! With the tree's mass matrix `M` in the middle of the step, velocities `v` before and `w` after it:
//!
//! ```text
//! M (w - v) = h (what drives) + J^T (impulses of loops and drives) + (impulses of friction)
//! ```
//!
//! with `J w` what is prescribed at the end, and friction laws between impulses and `w`: each contact's
//! friction is bounded by its own reaction of the same step. Stops and reversals within the step need no
//! event, a contact that sticks has `w = 0`, and where friction makes velocities jump they jump.
//!
//! Equation (D7) of the book's theory.

use super::Forward;
use super::affine_friction::{InterfaceMode, is_smooth, norm};
use super::balance::{Balance, Response};
use super::complementarity::{Cone, Dry, Found, Kind, Member, Smooth, mode_of};
use super::constraint_jacobian::Rows;
use super::error::ForwardError;
use super::inputs::Inputs;
use super::mass_matrix::{damped, power_of_loads};
use super::situation::Situation;
use super::solve::Unsolved;
use crate::friction::{Bristles, Law};
use crate::kinematics::{State, Target};
use crate::parameters::InterfaceParameters;

/// Laws must hold to this part of the largest force.
const HOLDS: f64 = 1e-9;
/// So much of a rate, as part of the largest, counts as much of a force: what holds has no more than 1e-6.
const SLACK: f64 = 1e-3;

/// What a step ends with.
pub(super) struct Leap {
    /// Not yet projected.
    pub(super) state: State<f64>,
    pub(super) modes: Vec<InterfaceMode>,
    pub(super) bristles: Vec<[f64; 3]>,
    /// Of the surfaces at the end, m/s.
    pub(super) velocities: Vec<[f64; 3]>,
    /// At the surfaces, N.
    pub(super) frictions: Vec<[f64; 3]>,
    /// N.
    pub(super) loads: Vec<f64>,
    pub(super) drives: Vec<f64>,
    pub(super) response: Response,
    /// The largest rate of the tree at the end without friction, lengths in characteristic lengths.
    pub(super) free_rate: f64,
    /// Work of drives and loads, and what dampers and contacts dissipate, J.
    pub(super) work: Work,
    pub(super) redundant: usize,
    pub(super) open_drives: usize,
    pub(super) mobility: usize,
    pub(super) distance: f64,
}

/// Energies of one step, J.
#[derive(Clone, Debug, Default)]
pub(super) struct Work {
    pub(super) drives: Vec<f64>,
    pub(super) loads: f64,
    pub(super) dampers: f64,
    pub(super) interfaces: Vec<f64>,
}

/// A law that is a smooth function of velocity.
#[derive(Clone, Debug)]
struct Regularised {
    interface: InterfaceParameters<f64>,
}

impl Smooth for Regularised {
    fn friction(&self, load: f64, velocity: [f64; 3]) -> [f64; 3] {
        let speed = norm(velocity);
        if speed == 0.0 {
            return [0.0; 3];
        }
        let resistance = self.interface.law_towards(velocity[0]).sliding(speed);
        velocity.map(|v| v / speed * resistance.force(load))
    }
    fn boxed(&self) -> Box<dyn Smooth> {
        Box::new(self.clone())
    }
}

/// Bristles, whose deflection at the end of the step follows from the velocity there (implicit Euler).
#[derive(Clone, Debug)]
struct BristleState {
    interface: InterfaceParameters<f64>,
    own: Bristles,
    before: [f64; 3],
    step: f64,
}

impl BristleState {
    fn deflection(&self, velocity: [f64; 3]) -> [f64; 3] {
        let speed = norm(velocity);
        let decay =
            self.own.stiffness * speed / self.interface.law_towards(velocity[0]).coefficient(speed);
        [0, 1, 2].map(|i| (self.before[i] + self.step * velocity[i]) / (1.0 + self.step * decay))
    }
}

impl Smooth for BristleState {
    fn friction(&self, load: f64, velocity: [f64; 3]) -> [f64; 3] {
        let after = self.deflection(velocity);
        let viscous = self.interface.law_towards(velocity[0]).viscous;
        [0, 1, 2].map(|i| {
            let rate = (after[i] - self.before[i]) / self.step;
            load * self.own.coefficient(after[i], rate) + viscous * velocity[i]
        })
    }
    fn boxed(&self) -> Box<dyn Smooth> {
        Box::new(self.clone())
    }
}

impl Forward {
    /// A step of length `step` from a state in which contacts do what `modes` says; `near` are frictions at
    /// the surfaces nearby, N.
    pub(super) fn leap(
        &self,
        time: f64,
        step: f64,
        from: &State<f64>,
        (modes, bristles, near): (&[InterfaceMode], &[[f64; 3]], &[[f64; 3]]),
        inputs: &mut dyn Inputs,
    ) -> Result<Leap, ForwardError> {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let mut middle = from.clone();
        let half: Vec<f64> = from.rates.iter().map(|v| 0.5 * step * v).collect();
        middle.advance(topology, &half);
        let situation = self.situation(time + 0.5 * step, middle, bristles, (&[], &[]), inputs);
        let ends = self.targets(time + step, inputs);
        let still: Vec<_> = ends.iter().map(|end| Target { acceleration: 0.0, ..*end }).collect();
        let (held, _) = self.held(&still, &[], &[], &[]);
        let mut rows = Rows::new(topology, parameters, &situation.bodies, &held);
        let n = topology.dofs();
        for (index, row) in rows.rows.iter_mut().enumerate() {
            let entries = &rows.matrix[index * n..(index + 1) * n];
            let has: f64 = entries.iter().zip(&from.rates).map(|(a, b)| a * b).sum();
            let wanted = index.checked_sub(topology.constraints).map_or(0.0, |k| ends[k].rate);
            // At the end the row has changed by half a step's change; `right` is minus the rate of that.
            row.right = (wanted - has) / step + 0.5 * row.right;
        }
        let scene = self.scene(&situation);
        let balance = Balance::new(&scene, rows)
            .map_err(|m| self.unsolved(time, Unsolved::Massless(m.body)))?;
        let smooth = vec![InterfaceMode::Sticks; modes.len()];
        let (_, efforts) = self.acting(&situation, &smooth);
        let base = balance.respond(&scene, &efforts, true);
        let (mut members, mut units) = (Vec::new(), Vec::new());
        for interface in 0..modes.len() {
            let first = units.len();
            for wrench in self.unit_frictions(&situation.bodies, interface) {
                let joint = parameters.interfaces[interface].joint;
                balance
                    .pushed(&scene, Some((joint, wrench)))
                    .map_err(|m| self.unsolved(time, Unsolved::Massless(m.body)))?;
                units.push(balance.respond(&scene, &[(joint, wrench)], false));
            }
            let kind =
                self.kind(&situation, interface, modes[interface], bristles[interface], step);
            members.push(Member { interface, places: first..units.len(), kind });
        }
        let count = units.len();
        let (mut free, mut change) = (vec![0.0; count], vec![0.0; count * count]);
        let drifting = self.accelerated(&situation.bodies, &vec![0.0; n]);
        for member in &members {
            let drift = self.surface_acceleration(&drifting, member.interface);
            for (place, i) in member.places.clone().enumerate() {
                let rate = |rates: &[f64]| {
                    self.surface_rate(&situation.bodies, rates, member.interface, place)
                };
                free[i] =
                    rate(&from.rates) + step * (rate(&base.accelerations) + 0.5 * drift[place]);
                for (j, unit) in units.iter().enumerate() {
                    change[i * count + j] = step * rate(&unit.accelerations);
                }
            }
        }
        let rate = |k: usize| (from.rates[k] + step * base.accelerations[k]) / self.columns[k];
        let free_rate = (0..n).fold(0.0_f64, |m, k| m.max(rate(k).abs()));
        let mut cone =
            Cone::new(parameters, &situation.bodies, members, free, change, (&base, &units));
        // What is redundant agrees to the third power of the step; projection removes the rest.
        cone.slack = SLACK;
        let start: Vec<f64> = cone
            .members
            .iter()
            .flat_map(|m| near[m.interface][..m.places.len()].to_vec())
            .collect();
        let mut found = cone.solve(&start, 1.0).filter(|found| found.missed <= HOLDS);
        if found.is_none() && start.iter().any(|amount| *amount != 0.0) {
            // What lies near may mislead, after a jump above all.
            found = cone.solve(&vec![0.0; count], 1.0).filter(|found| found.missed <= HOLDS);
        }
        let Some(found) = found else {
            let interface = cone.worst(&start).unwrap_or(0);
            let joint =
                self.joint_name(parameters.interfaces.get(interface).map_or(0, |c| c.joint));
            return Err(ForwardError::NoChoice { time, joint });
        };
        let members = cone.members;
        let mut response = base;
        for (unit, amount) in units.iter().zip(&found.amounts) {
            response.add(unit, *amount);
        }
        Ok(self.land(
            &situation,
            from,
            step,
            (&members, &found, free_rate),
            (modes, balance, response),
        ))
    }

    /// The law of one contact at the end of a step.
    fn kind(
        &self,
        situation: &Situation,
        interface: usize,
        mode: InterfaceMode,
        deflection: [f64; 3],
        step: f64,
    ) -> Kind {
        let content = &self.parameters.interfaces[interface];
        let velocity = situation.velocities[interface];
        let law = content.law_towards(velocity[0]);
        if let Some(own) = law.bristles {
            let interface = content.clone();
            let bristly = BristleState { interface, own, before: deflection, step };
            return Kind::Smooth(Box::new(bristly));
        }
        if law.regularisation.is_some() {
            return Kind::Smooth(Box::new(Regularised { interface: content.clone() }));
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
        Kind::Dry(Dry { forward, backward, viscous: law.viscous })
    }

    fn land(
        &self,
        situation: &Situation,
        from: &State<f64>,
        step: f64,
        (members, found, free_rate): (&[Member], &Found, f64),
        (before, balance, response): (&[InterfaceMode], Balance, Response),
    ) -> Leap {
        let (topology, parameters) = (&self.topology, &self.parameters);
        let count = before.len();
        let mut state = from.clone();
        for (rate, a) in state.rates.iter_mut().zip(&response.accelerations) {
            *rate += step * a;
        }
        let mean: Vec<f64> =
            from.rates.iter().zip(&state.rates).map(|(v, w)| 0.5 * (v + w)).collect();
        let by: Vec<f64> = mean.iter().map(|v| step * v).collect();
        state.advance(topology, &by);
        state.accelerations.clone_from(&response.accelerations);
        let mut bodies = situation.bodies.clone();
        bodies.move_with(topology, &mean);
        let (mut modes, mut loads) = (before.to_vec(), vec![0.0; count]);
        let (mut velocities, mut frictions) = (vec![[0.0; 3]; count], vec![[0.0; 3]; count]);
        let mut bristles = situation.bristles.clone();
        let mut work = Work { interfaces: vec![0.0; count], ..Work::default() };
        for ((member, load), holds) in members.iter().zip(&found.loads).zip(&found.holds) {
            let interface = member.interface;
            let content = &parameters.interfaces[interface];
            loads[interface] = *load;
            for (place, i) in member.places.clone().enumerate() {
                velocities[interface][place] = found.rates[i];
                frictions[interface][place] = found.amounts[i];
                let rate = self.surface_rate(&situation.bodies, &mean, interface, place);
                work.interfaces[interface] += step * found.amounts[i] * rate;
            }
            if let Kind::Smooth(_) = &member.kind
                && let Some(own) = content.law.bristles
            {
                let before = bristles[interface];
                let bristly = BristleState { interface: content.clone(), own, before, step };
                bristles[interface] = bristly.deflection(velocities[interface]);
            }
            if is_smooth(content) {
                continue;
            }
            modes[interface] = if *holds {
                velocities[interface] = [0.0; 3];
                InterfaceMode::Sticks
            } else {
                match mode_of(&found.rates[member.places.clone()], 0.0) {
                    InterfaceMode::AtLimit(direction) => InterfaceMode::Slides(direction),
                    other => other,
                }
            };
        }
        let mut drives = situation.efforts.clone();
        for (k, &actuator) in self.prescribed.iter().enumerate() {
            drives[actuator] = response.multipliers[topology.constraints + k];
        }
        let rate = |actuator: usize| bodies.actuator_rate(topology, topology.actuators[actuator]);
        work.drives = drives.iter().enumerate().map(|(k, f)| step * f * rate(k)).collect();
        work.loads = step * power_of_loads(&situation.loads, &bodies);
        work.dampers = step * damped(parameters, &bodies);
        Leap {
            state,
            modes,
            bristles,
            velocities,
            frictions,
            loads,
            drives,
            redundant: balance.spread.stresses.len(),
            open_drives: balance.spread.open_drives(),
            mobility: balance.mobility(topology.dofs()),
            distance: balance.distance(),
            response,
            free_rate,
            work,
        }
    }
}
