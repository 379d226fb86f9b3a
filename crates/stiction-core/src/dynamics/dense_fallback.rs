//! The careful path: inverse dynamics by dense decompositions, for positions and mechanisms that
//! the kernels cannot plan, and as their oracle.

use super::continuation::Lock;
use super::contributions::Shares;
use super::dense_coupling::{self, Reactions};
use super::interfaces::Interfaces;
use super::settings::{FrictionMode, Settings};
use crate::kinematics::Bodies;
use crate::mechanism::Mechanism;
use crate::parameters::Parameters;
use crate::spatial::Wrench;
use crate::statics::newton_euler::Unknown;
use crate::statics::{AppliedLoad, InfeasibleLoad, Statics};
use crate::topology::Topology;
use nalgebra::DVector;

/// Steps of the fixed point between friction and reactions; where it needs more, Newton's method is
/// faster.
const FIXED_POINT_STEPS: usize = 200;

/// All forces, by dense decompositions.
#[derive(Clone, Debug)]
pub(super) struct DenseForces {
    pub(super) efforts: Vec<f64>,
    pub(super) efforts_frictionless: Vec<f64>,
    pub(super) wrenches: Vec<Wrench<f64>>,
    pub(super) interfaces: Interfaces<f64>,
    /// What each friction causes of each drive.
    pub(super) shares: Shares<f64>,
    /// Motion of the bodies with the accelerations of idle spins.
    pub(super) bodies: Bodies<f64>,
    /// Whether friction was found, or that it locks.
    pub(super) settled: bool,
    /// Where friction locks the mechanism, if it does; all else is then without meaning.
    pub(super) lock: Option<Lock>,
}

/// A position and what is known about it.
pub(super) struct Position<'a> {
    pub(super) mechanism: &'a Mechanism,
    pub(super) topology: &'a Topology,
    pub(super) parameters: &'a Parameters<f64>,
    pub(super) statics: &'a Statics,
    pub(super) bodies: &'a Bodies<f64>,
}

/// Solves the balance with friction by a plain fixed point: friction from the reactions, reactions
/// with that friction, again. Idle spins accelerate as the joints let them: `accelerations` are
/// those of the tree, `spin_responses` those for unit spins.
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
    // What spinning a body without inertia demands is rounding, and must not be magnified.
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
    interfaces.slide(topology, parameters, bodies, settings.rest_speed);
    let mut friction = vec![Wrench::zero(); mechanism.joints().len()];
    // The balance with the present friction; idle spins take what the joints cannot.
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
    interfaces.press_frictionless(parameters, bodies, &wrenches);
    let steps = match settings.friction {
        FrictionMode::Off => 0,
        FrictionMode::OnePass => 1,
        FrictionMode::Converged => FIXED_POINT_STEPS,
    };
    let mut settled = steps < 2 || interfaces.states.is_empty();
    for _ in 0..steps {
        interfaces.friction_at_joints(topology, parameters, bodies, &mut friction);
        // Without friction the load was carried: what is lost now is lost in the size of frictions
        // that grow without bound.
        let Ok(carried) = carry(&friction) else { break };
        (unknowns, wrenches, amounts) = carried;
        if settings.friction == FrictionMode::OnePass {
            break;
        }
        let (change, largest) = interfaces.press(parameters, bodies, &wrenches);
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
        // The fixed point does not contract: Newton's method on the loads, from no friction.
        let none = vec![Wrench::zero(); friction.len()];
        let base = carry(&none)?.1;
        let mut responses = Vec::with_capacity(interfaces.states.len());
        for (interface, state) in parameters.interfaces.iter().zip(&interfaces.states) {
            friction.fill(Wrench::zero());
            friction[interface.joint] = bodies.wrench_of(topology, interface, state.against);
            // Here friction asks for a load that nothing carries: known to have an answer only if the
            // fixed point finds it.
            let Ok((_, with, _)) = carry(&friction) else { break };
            responses.push(with.iter().zip(&base).map(|(a, b)| *a - *b).collect());
        }
        interfaces.slide(topology, parameters, bodies, settings.rest_speed);
        let reactions = Reactions { base: &base, responses: &responses };
        if responses.len() == interfaces.states.len() {
            settled = true;
            match dense_coupling::follow(&mut interfaces, parameters, bodies, &reactions) {
                Err(found) => lock = Some(found),
                Ok(()) => {
                    interfaces.friction_at_joints(topology, parameters, bodies, &mut friction);
                    (unknowns, wrenches, amounts) = carry(&friction)?;
                }
            }
        }
    }
    let mut shares = Shares::new(topology.actuators.len(), parameters.interfaces.len());
    if settings.friction != FrictionMode::Off {
        // The same frictions once more, one at a time, with nothing else to be carried.
        let nothing = &demand * 0.0;
        for (index, (interface, state)) in
            parameters.interfaces.iter().zip(&interfaces.states).enumerate()
        {
            friction.fill(Wrench::zero());
            // Only what slides has friction here: see `Interfaces::held`.
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
