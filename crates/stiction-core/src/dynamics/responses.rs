//! Responses of all forces to unit friction forces, from one factorisation of the frictionless balance.

use super::balance::{Balance, LaneWorkspace, UnitFriction, UnitResponse};
use super::inverse::Inverse;
use super::model::Model;
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::spatial::Wrench;
use core::ops::Range;

/// Responses at one position, for the sliding directions at that position. A sliding interface has one
/// component, the friction that opposes its sliding; an interface at rest has one component for each of
/// its DOFs, with the sign of the sliding velocity that it opposes.
#[derive(Clone, Debug, Default)]
pub(super) struct Responses {
    balance: Option<Balance<f64>>,
    units: Vec<UnitFriction>,
    /// Components of each interface.
    of: Vec<Range<usize>>,
    workspace: LaneWorkspace,
    /// Numbers of joints, actuators and local degrees of freedom.
    counts: [usize; 3],
    /// Joint wrenches for all components; empty unless stored.
    wrenches: Vec<Wrench<f64>>,
    efforts: Vec<f64>,
    spins: Vec<f64>,
}

impl Responses {
    /// Lists the components for the sliding directions in `inverse` and factors the frictionless
    /// balance at its position.
    fn begin(
        &mut self,
        inverse: &Inverse<f64>,
        model: &Model,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
    ) {
        self.units.clear();
        self.of.clear();
        for (interface, content) in parameters.interfaces.iter().enumerate() {
            let first = self.units.len();
            let state = &inverse.interfaces()[interface];
            let unit = |against| UnitFriction { interface, against };
            if state.sliding > 0.0 {
                self.units.push(unit(state.against));
            } else {
                let arms = content.arms(parameters.pitch[content.joint]);
                self.units.extend((0..content.shape.dofs().len()).map(|dof| {
                    let mut against = [0.0; 3];
                    against[dof] = -arms[dof];
                    unit(against)
                }));
            }
            self.of.push(first..self.units.len());
        }
        let topology = model.topology();
        self.counts = [
            topology.joint_types.len(),
            topology.actuators.len(),
            model.constraints().spins().len(),
        ];
        self.wrenches.clear();
        self.efforts.clear();
        self.spins.clear();
        let balance = match &mut self.balance {
            Some(balance) if balance.fits(inverse.balance()) => balance,
            other => other.insert(inverse.balance().clone()),
        };
        balance.factor_frictionless(inverse.balance(), &model.balance, parameters, bodies);
    }

    /// Computes all responses; calls `take` with each component and its response, and stores joint
    /// wrenches as well if `store`.
    pub(super) fn update(
        &mut self,
        inverse: &Inverse<f64>,
        model: &Model,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        store: bool,
        mut take: impl FnMut(usize, &UnitResponse),
    ) {
        self.begin(inverse, model, parameters, bodies);
        let Self { balance, units, workspace, wrenches, efforts, spins, .. } = self;
        let Some(balance) = balance else { return };
        let plan = &*model.balance;
        balance.respond(plan, parameters, bodies, units, workspace, |component, response| {
            if store {
                wrenches.extend_from_slice(&response.wrenches);
            }
            efforts.extend_from_slice(&response.efforts);
            spins.extend_from_slice(&response.spins);
            take(component, response);
        });
    }

    /// Number of components.
    pub(super) fn len(&self) -> usize {
        self.units.len()
    }

    /// Components of an interface.
    pub(super) fn components(&self, interface: usize) -> Range<usize> {
        self.of[interface].clone()
    }

    /// Interface of a component.
    pub(super) fn interface(&self, component: usize) -> usize {
        self.units[component].interface
    }

    /// Change of a joint's wrench per newton of a component; requires stored wrenches.
    pub(super) fn wrench(&self, component: usize, joint: usize) -> Wrench<f64> {
        self.wrenches(component)[joint]
    }

    /// Changes of the wrenches of all joints per newton of a component; requires stored wrenches.
    pub(super) fn wrenches(&self, component: usize) -> &[Wrench<f64>] {
        &self.wrenches[component * self.counts[0]..][..self.counts[0]]
    }

    /// Changes of all efforts per newton of a component.
    pub(super) fn efforts(&self, component: usize) -> &[f64] {
        &self.efforts[component * self.counts[1]..][..self.counts[1]]
    }

    /// Changes of the accelerations of local degrees of freedom per newton of a component.
    pub(super) fn spins(&self, component: usize) -> &[f64] {
        &self.spins[component * self.counts[2]..][..self.counts[2]]
    }
}
