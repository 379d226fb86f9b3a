//! Bound on the coupling of friction and reactions, by the sparse balance of inverse dynamics.
//!
//! Equations (F6) and (F7) of the book's theory.

use super::balance::Balance;
use super::interfaces::InterfaceState;
use super::inverse::Inverse;
use super::model::Model;
use crate::friction::Resistance;
use crate::friction_problem::influence::Influence;
use crate::friction_problem::normal_load::Configuration;
use crate::friction_problem::uniqueness::{self, BoundWorkspace};
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::spatial::Wrench;

/// Buffers for the bound on the coupling.
#[derive(Clone, Debug, Default)]
pub(super) struct CouplingWorkspace {
    balance: Option<Balance<f64>>,
    efforts: Vec<f64>,
    sliding: Vec<usize>,
    bound: BoundWorkspace,
}

/// Influence of the normal loads of sliding interfaces. Each column is a solution of the
/// frictionless balance, whose matrix is factored once.
struct BalanceInfluence<'a> {
    inverse: &'a Inverse<f64>,
    model: &'a Model,
    at: Configuration<'a>,
    sliding: &'a [usize],
    balance: &'a mut Balance<f64>,
    efforts: &'a mut [f64],
}

impl Influence for BalanceInfluence<'_> {
    fn visit(&mut self, mut put: impl FnMut(usize, usize, Wrench<f64>)) {
        let Self { inverse, model, at, sliding, balance, efforts } = self;
        let Configuration { parameters, bodies } = *at;
        balance.factor_frictionless(inverse.balance(), &model.balance, parameters, bodies);
        for (column, &from) in sliding.iter().enumerate() {
            let state = &inverse.interfaces()[from];
            let constant = state.resistance.coefficient;
            let resistance = Resistance { coefficient: 0.0, constant };
            let unit = InterfaceState { resistance, ..*state };
            let interface = &parameters.interfaces[from];
            balance.apply_friction_alone(
                &model.balance,
                parameters,
                bodies,
                interface,
                &unit,
                efforts,
            );
            for (row, &to) in sliding.iter().enumerate() {
                put(row, column, balance.joint_wrenches[at.joint(to)]);
            }
        }
    }
}

impl CouplingWorkspace {
    /// Computes the bound on the coupling of friction and normal loads at the solution in
    /// `inverse`: below one the solution is unique.
    pub(super) fn bound(
        &mut self,
        inverse: &Inverse<f64>,
        model: &Model,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) -> f64 {
        let Self { balance, efforts, sliding, bound } = self;
        sliding.clear();
        sliding.extend((0..parameters.interfaces.len()).filter(|&interface| {
            let state = &inverse.interfaces()[interface];
            state.sliding > 0.0 && state.resistance.coefficient > 0.0
        }));
        let balance = match balance {
            Some(balance) if balance.fits(inverse.balance()) => balance,
            other => other.insert(inverse.balance().clone()),
        };
        efforts.resize(inverse.efforts().len(), 0.0);
        let at = Configuration { parameters, bodies };
        let coefficient = |&interface: &usize| {
            (interface, inverse.interfaces()[interface].resistance.coefficient)
        };
        let each = sliding.iter().map(coefficient);
        let mut influence = BalanceInfluence { inverse, model, at, sliding, balance, efforts };
        uniqueness::coupling_bound(at, each, &mut influence, bound)
    }
}
