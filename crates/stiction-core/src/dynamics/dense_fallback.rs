//! Dense fallback: inverse dynamics by dense decompositions of the Newton-Euler equations, for
//! configurations and mechanisms that the sparse balance cannot solve. Tests compare the sparse
//! balance with this fallback.

use super::contributions::Contributions;
use super::interfaces::{InterfaceState, Interfaces};
use super::settings::{FrictionMode, Settings};
use crate::friction_problem::continuation::{Lock, StepPolicy};
use crate::friction_problem::influence::Influence;
use crate::friction_problem::load_problem::{LoadProblem, LoadWorkspace};
use crate::friction_problem::normal_load::Configuration;
use crate::kinematics::Bodies;
use crate::mechanism::Mechanism;
use crate::parameters::{InterfaceParameters, Parameters};
use crate::spatial::Wrench;
use crate::statics::newton_euler::Unknown;
use crate::statics::{AppliedLoad, InfeasibleLoad, Statics};
use crate::topology::Topology;
use nalgebra::DVector;

/// Largest number of steps of the fixed-point iteration between friction and reactions. If more
/// steps are needed, Newton's method is faster.
const FIXED_POINT_STEPS: usize = 200;

/// Step sizes of the continuation from zero friction to the given friction coefficients.
const STEPS: StepPolicy = StepPolicy {
    first: 0.15,
    growth: 1.5,
    longest: f64::INFINITY,
    shortest: 1e-6,
    most: usize::MAX,
};

/// Joint wrenches as affine functions of the friction forces.
struct Reactions<'a> {
    frictionless: &'a [Wrench<f64>],
    /// Change of all joint wrenches per newton of friction, for each interface.
    responses: &'a [Vec<Wrench<f64>>],
}

/// Change of the joint wrenches per newton of normal load at each coupled interface, due to
/// friction.
struct DenseInfluence<'a> {
    at: Configuration<'a>,
    /// Index and friction coefficient of each coupled interface (whose friction depends on its
    /// normal load).
    coupled: &'a [(usize, f64)],
    responses: &'a [Vec<Wrench<f64>>],
}

impl Influence for DenseInfluence<'_> {
    fn visit(&mut self, mut put: impl FnMut(usize, usize, Wrench<f64>)) {
        for (row, &(to, _)) in self.coupled.iter().enumerate() {
            for (column, &(from, coefficient)) in self.coupled.iter().enumerate() {
                put(row, column, self.responses[from][self.at.joint(to)] * coefficient);
            }
        }
    }
}

impl Reactions<'_> {
    /// Solves for the normal loads of `interfaces` with known sliding velocities and friction laws,
    /// by continuation from zero friction.
    ///
    /// # Errors
    /// Returns the point at which friction locks the mechanism, where the continuation ends.
    fn solve(&self, interfaces: &mut Interfaces<f64>, at: Configuration<'_>) -> Result<(), Lock> {
        let states = &mut interfaces.states;
        let mut base = self.frictionless.to_vec();
        for (state, response) in states.iter().zip(self.responses) {
            let constant = state.resistance.constant;
            base.iter_mut().zip(response).for_each(|(sum, unit)| *sum += *unit * constant);
        }
        let coupled: Vec<(usize, f64)> = states
            .iter()
            .enumerate()
            .map(|(interface, state)| (interface, state.resistance.coefficient))
            .filter(|(_, coefficient)| *coefficient != 0.0)
            .collect();
        let mut problem = LoadProblem::default();
        for &(interface, _) in &coupled {
            problem.add(interface, states[interface].own_friction(), base[at.joint(interface)]);
        }
        problem.set_influence(&mut DenseInfluence {
            at,
            coupled: &coupled,
            responses: self.responses,
        });
        let mut workspace = LoadWorkspace::default();
        problem.solve(at, None, STEPS, &mut workspace)?;
        for ((interface, _), load) in coupled.iter().zip(&workspace.loads) {
            states[*interface].load.value = *load;
        }
        let mut wrenches = base;
        for (&(interface, coefficient), load) in coupled.iter().zip(&workspace.loads) {
            let friction = coefficient * load;
            let response = &self.responses[interface];
            wrenches.iter_mut().zip(response).for_each(|(sum, unit)| *sum += *unit * friction);
        }
        interfaces.update_normal_forces(at.parameters, at.bodies, &wrenches);
        Ok(())
    }
}

/// Results of inverse dynamics by dense decompositions.
#[derive(Clone, Debug)]
pub(super) struct DenseForces {
    pub(super) efforts: Vec<f64>,
    pub(super) efforts_frictionless: Vec<f64>,
    pub(super) gearings: Vec<f64>,
    pub(super) wrenches: Vec<Wrench<f64>>,
    pub(super) interfaces: Interfaces<f64>,
    /// Contribution of the friction of each interface to each effort.
    pub(super) shares: Contributions<f64>,
    /// Motion of the bodies, including the accelerations of local degrees of freedom.
    pub(super) bodies: Bodies<f64>,
    /// True if friction has converged, or if it locks the mechanism.
    pub(super) settled: bool,
    /// Point at which friction locks the mechanism; `None` if friction does not lock it. If
    /// friction locks the mechanism, all other results are meaningless.
    pub(super) lock: Option<Lock>,
}

/// Configuration of a mechanism with the decomposed equilibrium equations.
pub(super) struct Position<'a> {
    pub(super) mechanism: &'a Mechanism,
    pub(super) topology: &'a Topology,
    pub(super) parameters: &'a Parameters<f64>,
    pub(super) statics: &'a Statics,
    pub(super) bodies: &'a Bodies<f64>,
}

/// Solves the Newton-Euler equations with friction by a fixed-point iteration, which alternately
/// computes friction from the reactions and reactions from this friction. A body with a local
/// degree of freedom accelerates about the axis of this degree of freedom as the unbalanced moment
/// requires. `accelerations` are the accelerations of the spanning tree, and `spin_responses` the
/// accelerations per unit acceleration of each local degree of freedom.
///
/// # Errors
/// Fails with the load that the joints cannot carry, if there is one.
pub(super) fn solve(
    position: &Position<'_>,
    accelerations: &[f64],
    spin_responses: &[Vec<f64>],
    loads: &[AppliedLoad<f64>],
    settings: &Settings,
) -> Result<DenseForces, InfeasibleLoad> {
    let &Position { mechanism, topology, parameters, statics, bodies } = position;
    let system = statics.system();
    let spin = |amounts: &[f64]| {
        let mut with = bodies.clone();
        let mut sum = accelerations.to_vec();
        for (response, amount) in spin_responses.iter().zip(amounts) {
            sum.iter_mut().zip(response).for_each(|(a, r)| *a += r * amount);
        }
        with.accelerate(topology, &sum);
        with
    };
    let still = spin(&[]);
    let demand = system.demand(parameters, &still, loads);
    // The wrench that spins a body without inertia is round-off and must not be amplified.
    let masses: f64 = parameters.mass.iter().sum();
    let inertias: f64 = parameters.inertia.iter().map(|inertia| inertia.trace()).sum();
    let negligible = 1e-12 * (masses * parameters.length + inertias / parameters.length);
    let units: Vec<_> = (0..spin_responses.len())
        .map(|k| {
            let amounts: Vec<f64> = (0..=k).map(|i| if i == k { 1.0 } else { 0.0 }).collect();
            let unit = system.demand(parameters, &spin(&amounts), loads) - &demand;
            let size = (0..unit.len())
                .map(|row| (unit[row] * system.row_scale(row)).abs())
                .fold(0.0, f64::max);
            if size > negligible { unit } else { unit * 0.0 }
        })
        .collect();

    let mut interfaces = Interfaces::new(parameters.interfaces.len());
    interfaces.update_slip(topology, parameters, bodies, settings.rest_speed);
    let mut friction = vec![Wrench::zero(); mechanism.joints().len()];
    // Reactions for given friction; passive spins balance the moments that the joints cannot carry.
    let carry = |friction: &[Wrench<f64>]| {
        let amounts = statics.amounts_into_reach(&demand, friction, &units);
        let mut with_spins = demand.clone();
        for (unit, amount) in units.iter().zip(&amounts) {
            with_spins += unit * *amount;
        }
        let unknowns = statics.carry(&with_spins, friction)?.unknowns;
        let wrenches = system.joint_wrenches(&unknowns, friction);
        Ok::<_, InfeasibleLoad>((unknowns, wrenches, amounts))
    };
    let (mut unknowns, mut wrenches, mut amounts) = carry(&friction)?;
    let efforts_frictionless = efforts(statics, &unknowns);
    interfaces.update_frictionless_normal_forces(parameters, bodies, &wrenches);
    let steps = match settings.friction {
        FrictionMode::Off => 0,
        FrictionMode::OnePass => 1,
        FrictionMode::Converged => FIXED_POINT_STEPS,
    };
    let mut settled = steps < 2 || interfaces.states.is_empty();
    for _ in 0..steps {
        interfaces.friction_at_joints(topology, parameters, bodies, &mut friction);
        // The load was feasible without friction, so infeasibility means that friction has grown
        // without bound.
        let Ok(carried) = carry(&friction) else { break };
        (unknowns, wrenches, amounts) = carried;
        if settings.friction == FrictionMode::OnePass {
            break;
        }
        let (change, largest) = interfaces.update_normal_forces(parameters, bodies, &wrenches);
        if settings.is_settled(change, largest) {
            settled = true;
            break;
        }
        if !change.is_finite() {
            break;
        }
    }
    let mut lock = None;
    if !settled && settings.friction == FrictionMode::Converged {
        // The fixed-point iteration does not contract: solve for the normal loads.
        interfaces.update_slip(topology, parameters, bodies, settings.rest_speed);
        friction.fill(Wrench::zero());
        let frictionless = carry(&friction)?.1;
        let respond = |(interface, state): (&InterfaceParameters<f64>, &InterfaceState<f64>)| {
            let mut friction = vec![Wrench::zero(); frictionless.len()];
            friction[interface.joint] = bodies.wrench_of(topology, interface, state.against);
            let wrenches = carry(&friction)?.1;
            Ok(wrenches.iter().zip(&frictionless).map(|(a, b)| *a - *b).collect::<Vec<_>>())
        };
        let each = parameters.interfaces.iter().zip(&interfaces.states);
        // If the joints cannot carry some friction force, only the fixed-point iteration may find a
        // solution.
        if let Ok(responses) = each.map(respond).collect::<Result<Vec<_>, InfeasibleLoad>>() {
            settled = true;
            let reactions = Reactions { frictionless: &frictionless, responses: &responses };
            match reactions.solve(&mut interfaces, Configuration { parameters, bodies }) {
                Err(found) => lock = Some(found),
                Ok(()) => {
                    interfaces.friction_at_joints(topology, parameters, bodies, &mut friction);
                    (unknowns, wrenches, amounts) = carry(&friction)?;
                }
            }
        }
    }
    let mut shares = Contributions::new(topology.actuators.len(), parameters.interfaces.len());
    if settings.friction != FrictionMode::Off {
        // Change of the efforts due to each of these friction forces alone, without other loads.
        let nothing = &demand * 0.0;
        for (index, (interface, state)) in
            parameters.interfaces.iter().zip(&interfaces.states).enumerate()
        {
            friction.fill(Wrench::zero());
            // Interfaces at rest have no friction here.
            friction[interface.joint] =
                bodies.wrench_of(topology, interface, state.against) * state.friction();
            let amounts = statics.amounts_into_reach(&nothing, &friction, &units);
            let mut with_spins = nothing.clone();
            for (unit, amount) in units.iter().zip(&amounts) {
                with_spins += unit * *amount;
            }
            let response = statics.carry_what_can_be(&with_spins, &friction).unknowns;
            shares.set_interface(index, &efforts(statics, &response));
        }
    }
    Ok(DenseForces {
        efforts: efforts(statics, &unknowns),
        efforts_frictionless,
        gearings: gearings(statics, parameters, &unknowns),
        wrenches,
        interfaces,
        shares,
        bodies: spin(&amounts),
        settled: settled || settings.friction != FrictionMode::Converged,
        lock,
    })
}

fn efforts(statics: &Statics, unknowns: &DVector<f64>) -> Vec<f64> {
    let pairs = statics.system().unknowns.iter().zip(unknowns.iter());
    pairs.filter(|(u, _)| matches!(u, Unknown::Drive { .. })).map(|(_, &x)| x).collect()
}

fn gearings(statics: &Statics, parameters: &Parameters<f64>, unknowns: &DVector<f64>) -> Vec<f64> {
    let pairs = statics.system().unknowns.iter().zip(unknowns.iter());
    let multiplier = |(unknown, value): (&Unknown, &f64)| match *unknown {
        Unknown::Gearing { gearing } => Some(value / parameters.gearings[gearing].size),
        _ => None,
    };
    pairs.filter_map(multiplier).collect()
}
