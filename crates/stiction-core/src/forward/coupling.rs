//! Coupled solution of normal loads, friction and accelerations.
//!
//! For given friction coefficients and modes, joint wrenches and accelerations are affine in the
//! normal loads of the interfaces. The normal loads are therefore the unknowns of a
//! [`LoadProblem`].
//!
//! Equation (D3) of the book's theory.

use super::Forward;
use super::affine_friction::AffineFriction;
use super::balance::{Balance, Response, Workspace};
use super::constraint_jacobian::StickingDof;
use super::data::Data;
use super::transmitted::LoadSide;
use crate::friction_problem::continuation::{Lock, StepPolicy};
use crate::friction_problem::fixed_point::FixedPoint;
use crate::friction_problem::influence::Influence;
use crate::friction_problem::load_problem::{LoadProblem, LoadWorkspace};
use crate::friction_problem::newton::{Accepted, UNBOUNDED};
use crate::friction_problem::uniqueness::BoundStart;
use crate::linalg::largest;
use crate::random::Random;
use crate::spatial::Wrench;

/// Step sizes of the continuation from zero to full friction. The shortest step bounds the
/// computing time: every trial of modes repeats the continuation, which needs about 60 steps to
/// locate the point at which friction locks the mechanism. Near singular configurations a
/// continuation without a shortest step would need millions of steps.
const STEPS: StepPolicy =
    StepPolicy { first: 0.1, growth: 1.5, longest: f64::INFINITY, shortest: 1e-6, most: 300 };
/// Number of random starts in the search for other solutions.
const STARTS: u32 = 24;
/// Uniqueness bound so far below one that it stays below one while the mechanism and the directions
/// of slip hardly move.
pub(super) const CERTAIN: f64 = 0.5;
/// Two solutions count as equal if their normal loads differ by less than this fraction of the
/// largest load.
const SAME: f64 = 1e-7;

/// Solution with friction: normal loads, accelerations and reactions.
#[derive(Clone, Debug, Default)]
pub(super) struct Coupled {
    pub(super) response: Response,
    /// Normal load of each interface, N.
    pub(super) loads: Vec<f64>,
}

/// Problem for the unknown normal loads, and the responses of the mechanism that define its
/// coefficients.
#[derive(Clone, Debug, Default)]
pub(super) struct Coupling {
    /// Wrenches that do not depend on normal loads, each with the index of its joint: wrenches of
    /// actuators, and the constant parts of friction.
    constant: Vec<(usize, Wrench<f64>)>,
    /// Response of the mechanism to the constant wrenches, loads and inertia forces; valid only if
    /// `has_base`.
    base: Response,
    /// True if `base` is up to date.
    has_base: bool,
    problem: LoadProblem,
    /// For each unknown normal load, the index of its joint and the friction wrench per newton of
    /// the load.
    units: Vec<(usize, Wrench<f64>)>,
    /// Index of the interface of each unknown normal load.
    interfaces: Vec<usize>,
    one: Response,
    all: Vec<(usize, Wrench<f64>)>,
    workspace: LoadWorkspace,
    /// Units and interfaces of the last influence matrix.
    influencing: (Vec<(usize, Wrench<f64>)>, Vec<usize>),
    /// True if the influence matrix of the problem is up to date. The size of this matrix is
    /// quadratic in the number of interfaces.
    has_influence: bool,
    /// Uniqueness bound of the present influence matrix, if computed.
    bound: Option<f64>,
    fixed_point: FixedPoint,
}

/// Responses of the mechanism to the friction that one newton of each normal load causes.
struct Responses<'a> {
    model: &'a Forward,
    data: &'a Data,
    balance: &'a Balance,
    units: &'a [(usize, Wrench<f64>)],
    interfaces: &'a [usize],
    load_side: LoadSide<'a>,
    one: &'a mut Response,
    workspace: &'a mut Workspace,
}

impl Influence for Responses<'_> {
    fn visit(&mut self, mut put: impl FnMut(usize, usize, Wrench<f64>)) {
        let Self { model, data, balance, units, interfaces, load_side, one, workspace } = self;
        // The friction of a gear depends on the wrench that the gear transmits. Friction between
        // the gear and its load is not part of this wrench.
        let behind = |row: usize, column: usize| {
            let is_behind = load_side.is_behind(interfaces[row], interfaces[column]);
            if is_behind { units[column].1 } else { Wrench::zero() }
        };
        if balance.is_redundant() || balance.is_sparse() {
            for (column, &unit) in units.iter().enumerate() {
                balance.respond_into(model, data, &[unit], false, workspace, one);
                let rows = units.iter().enumerate();
                rows.for_each(|(row, (joint, _))| {
                    let wrench = one.wrenches[*joint];
                    let held = load_side.held(interfaces[row], &one.multipliers);
                    put(row, column, wrench - held - behind(row, column));
                });
            }
            return;
        }
        for (block, four) in units.chunks(4).enumerate() {
            let (wrenches, multipliers) = balance.respond_to_four(model, data, four, workspace);
            for (row, (joint, _)) in units.iter().enumerate() {
                let held = load_side.held(interfaces[row], multipliers);
                let wrenches = wrenches[*joint] - held;
                for lane in 0..four.len() {
                    let wrench = wrenches.lane(lane);
                    let column = 4 * block + lane;
                    put(row, column, wrench - behind(row, column));
                }
            }
        }
    }
}

/// Returns the wrench of a friction force at an interface and the index of its joint.
fn friction_wrench(
    (model, data): (&Forward, &Data),
    interface: usize,
    friction: [f64; 3],
) -> (usize, Wrench<f64>) {
    let content = &model.parameters.interfaces[interface];
    let wrench = data.bodies.wrench_of(&model.topology, content, friction.map(|x| -x));
    (content.joint, wrench)
}

impl Coupling {
    /// Discards the influence matrix. Called after the equations of motion have been factorised
    /// again.
    pub(super) fn forget_influence(&mut self) {
        self.has_influence = false;
    }

    /// Sets up the problem for given frictions. `efforts` are the wrenches of the actuators, each
    /// with the index of its joint.
    pub(super) fn update(
        &mut self,
        (model, data): (&Forward, &Data),
        frictions: &[AffineFriction],
        efforts: &[(usize, Wrench<f64>)],
    ) {
        std::mem::swap(&mut self.units, &mut self.influencing.0);
        std::mem::swap(&mut self.interfaces, &mut self.influencing.1);
        self.has_base = false;
        let Self { constant, units, interfaces, .. } = self;
        constant.clear();
        constant.extend_from_slice(efforts);
        units.clear();
        interfaces.clear();
        for (interface, friction) in frictions.iter().enumerate() {
            if friction.constant != [0.0; 3] {
                constant.push(friction_wrench((model, data), interface, friction.constant));
            }
            if friction.per_load != [0.0; 3] {
                units.push(friction_wrench((model, data), interface, friction.per_load));
                interfaces.push(interface);
            }
        }
        self.has_influence &=
            self.units == self.influencing.0 && self.interfaces == self.influencing.1;
    }

    /// Computes the unknowns of the problem and the influence of the normal loads on each other, unless
    /// they are already up to date.
    pub(super) fn need_influence(
        &mut self,
        (model, data): (&Forward, &Data),
        frictions: &[AffineFriction],
        balance: &Balance,
        sticking: &[StickingDof],
        workspace: &mut Workspace,
    ) {
        let Self { constant, base, problem, units, interfaces, one, .. } = self;
        let (rows, bodies) = (&balance.rows.rows[..], &data.bodies);
        let load_side = LoadSide { model, bodies, sticking, rows };
        if !std::mem::replace(&mut self.has_base, true) {
            balance.respond_into(model, data, constant, true, workspace, base);
            problem.clear();
            for (&interface, unit) in interfaces.iter().zip(&*units) {
                let mut own = base.wrenches[unit.0] - load_side.held(interface, &base.multipliers);
                for other in load_side.behind(interface) {
                    own -= friction_wrench((model, data), other, frictions[other].constant).1;
                }
                problem.add(interface, frictions[interface].own, own);
            }
        }
        if !std::mem::replace(&mut self.has_influence, true) {
            self.bound = None;
            let mut responses =
                Responses { model, data, balance, units, interfaces, load_side, one, workspace };
            problem.set_influence(&mut responses);
        }
    }

    /// Solves for the normal loads by fixed-point iteration, starting from the normal loads
    /// `known`, N, one for each interface. Each iteration solves the equations of motion once,
    /// whereas Newton's method solves them once per interface. Returns false if the iteration does
    /// not contract, or if the normal load of an interface depends on the effort that a gear
    /// transmits. `tolerance` is the relative error of the loads at which the iteration may end; it
    /// continues to round-off if `tolerance` is zero.
    pub(super) fn iterate(
        &mut self,
        (model, data): (&Forward, &Data),
        frictions: &[AffineFriction],
        balance: &Balance,
        (known, tolerance): (&[f64], f64),
        (workspace, coupled): (&mut Workspace, &mut Coupled),
    ) -> bool {
        self.workspace.continuation_steps = 0;
        let has_gear = |i: &usize| model.parameters.interfaces[*i].load.gear.is_some();
        if self.interfaces.iter().any(has_gear) {
            return false;
        }
        let at = model.configuration(data);
        let Self { constant, units, interfaces, all, fixed_point, workspace: own, .. } = self;
        let Coupled { response, loads: found } = coupled;
        if units.is_empty() {
            own.loads.clear();
            balance.respond_into(model, data, constant, true, workspace, response);
        } else {
            own.loads.clear();
            own.loads.extend(interfaces.iter().map(|interface| known[*interface]));
            balance.prepare_whole(model, data, workspace);
            let solved = fixed_point.solve(&mut own.loads, tolerance, |loads, out| {
                all.clone_from(constant);
                let units = units.iter().zip(loads);
                all.extend(units.map(|(&(joint, unit), load)| (joint, unit * *load)));
                balance.respond_whole(model, data, all, workspace, response);
                out.clear();
                out.extend(interfaces.iter().map(|&interface| {
                    let wrench = response.wrenches[at.joint(interface)];
                    at.normal_load(interface, wrench, frictions[interface].own).value
                }));
            });
            if !solved {
                return false;
            }
        }
        self.note_loads((model, data), frictions, response, found);
        true
    }

    /// Solves for the normal loads by Newton's method, starting from the normal loads `known`, N,
    /// one for each interface. If Newton's method does not converge or `known` is `None`, solves by
    /// continuation from the frictionless solution.
    pub(super) fn solve(
        &mut self,
        (model, data): (&Forward, &Data),
        frictions: &[AffineFriction],
        balance: &Balance,
        known: Option<&[f64]>,
        (workspace, coupled): (&mut Workspace, &mut Coupled),
    ) -> Result<(), Lock> {
        let at = model.configuration(data);
        self.problem.solve(at, known, STEPS, &mut self.workspace)?;
        self.complete((model, data), frictions, balance, workspace, coupled);
        Ok(())
    }

    /// Returns the number of continuation steps in the last solution; zero if the last solution
    /// needed no continuation.
    pub(super) fn continuation_steps(&self) -> usize {
        self.workspace.continuation_steps
    }

    /// Returns the uniqueness bound of the normal loads for the present modes. If the bound is
    /// below one, no other normal loads satisfy the friction laws in these modes. A bound below
    /// [`CERTAIN`] need not be the smallest one.
    pub(super) fn bound(&mut self, model: &Forward, data: &Data) -> f64 {
        if let Some(bound) = self.bound {
            return bound;
        }
        // The bound must not depend on bounds computed earlier, because a resumed simulation does
        // not have them.
        let start = (BoundStart::New, CERTAIN);
        let at = model.configuration(data);
        let bound = self.problem.coupling_bound(at, start, &mut self.workspace);
        self.bound = Some(bound);
        bound
    }

    /// Searches from many random starts for solutions whose normal loads differ from those of
    /// `known`.
    pub(super) fn others(
        &mut self,
        (model, data): (&Forward, &Data),
        frictions: &[AffineFriction],
        balance: &Balance,
        known: &Coupled,
        workspace: &mut Workspace,
    ) -> Vec<Coupled> {
        let at = model.configuration(data);
        let mut start = Vec::new();
        self.problem.uncoupled_loads(at, &mut start);
        let size = largest(&start).max(f64::MIN_POSITIVE);
        let mut found: Vec<Coupled> = Vec::new();
        let mut random = Random::new(1);
        for k in 0..STARTS {
            let reach = size * 3f64.powi(k as i32 / 4 + 1);
            let mut loads: Vec<f64> =
                start.iter().map(|_| random.vector().x.abs() * reach).collect();
            let accepted = Accepted::below(UNBOUNDED * size);
            if !self.problem.solve_from(at, &mut loads, accepted, &mut self.workspace) {
                continue;
            }
            self.workspace.loads = loads;
            let mut other = Coupled::default();
            self.complete((model, data), frictions, balance, workspace, &mut other);
            let differs = |a: &Coupled| {
                let largest = a.loads.iter().chain(&other.loads).fold(0.0_f64, |m, x| m.max(*x));
                a.loads.iter().zip(&other.loads).any(|(x, y)| (x - y).abs() > SAME * largest)
            };
            if differs(known) && found.iter().all(differs) {
                found.push(other);
            }
        }
        found
    }

    /// Computes accelerations and reactions from the normal loads of the last solution.
    fn complete(
        &mut self,
        (model, data): (&Forward, &Data),
        frictions: &[AffineFriction],
        balance: &Balance,
        workspace: &mut Workspace,
        coupled: &mut Coupled,
    ) {
        let Coupled { response, loads: found } = coupled;
        let loads = &self.workspace.loads;
        if self.units.is_empty() {
            response.clone_from(&self.base);
        } else {
            self.all.clone_from(&self.constant);
            let units = self.units.iter().zip(loads);
            self.all.extend(units.map(|(&(joint, unit), load)| (joint, unit * *load)));
            balance.respond_into(model, data, &self.all, true, workspace, response);
        }
        self.note_loads((model, data), frictions, response, found);
    }

    /// Writes the normal loads of all interfaces to `found`. Normal loads that are not unknowns of
    /// the problem are computed from `response`.
    fn note_loads(
        &self,
        (model, data): (&Forward, &Data),
        frictions: &[AffineFriction],
        response: &Response,
        found: &mut Vec<f64>,
    ) {
        let loads = &self.workspace.loads;
        let at = model.configuration(data);
        found.clear();
        let mut solved = self.interfaces.iter().copied().zip(loads).peekable();
        for (interface, friction) in frictions.iter().enumerate() {
            let wrench = response.wrenches[at.joint(interface)];
            found.push(match solved.next_if(|(next, _)| *next == interface) {
                Some((_, load)) => *load,
                None => at.normal_load(interface, wrench, friction.own).value,
            });
        }
    }
}
