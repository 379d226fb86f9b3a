//! Further solutions for a given motion: with other friction forces or from other starting values.

use super::Inverse;
use crate::dynamics::interfaces::Coupling;
use crate::dynamics::model::Model;
use crate::dynamics::settings::{FrictionMode, Settings};
use crate::friction::Resistance;
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::spatial::Wrench;
use crate::topology::Topology;

impl<T: Scalar> Inverse<T> {
    /// Recomputes the normal forces from the given joint wrenches, as a new starting point of the
    /// iteration between friction and reactions.
    pub(in crate::dynamics) fn restart_from(
        &mut self,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        wrenches: &[Wrench<T>],
    ) {
        self.restart_from_each(parameters, bodies, wrenches.iter().copied());
    }

    /// Recomputes the normal forces as [`Self::restart_from`], from an iterator over the wrenches.
    fn restart_from_each(
        &mut self,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        wrenches: impl Iterator<Item = Wrench<T>>,
    ) {
        let joint_wrenches = &mut self.balance.joint_wrenches;
        joint_wrenches.iter_mut().zip(wrenches).for_each(|(to, from)| *to = from);
        self.interfaces.update_normal_forces(parameters, bodies, joint_wrenches);
    }

    /// Adopts a solution of the coupled problem of friction and reactions. `wrench_of` returns
    /// the wrench of a joint. `loads` contains the index and the normal force, N, of each
    /// interface whose friction depends on the normal force.
    ///
    /// Returns false if the solution does not satisfy the balance up to `tolerance`, relative to
    /// the largest joint wrench. Also returns false if the model is not plain (see
    /// [`BalanceStructure::is_plain`](crate::dynamics::structure::BalanceStructure)), after calling
    /// [`Self::restart_from`] with these wrenches. Requires a previous [`Self::begin`] for this
    /// motion, no static friction at interfaces at rest, and a coupling bound below one, which
    /// implies that the determinant has the same sign as without friction.
    pub(in crate::dynamics) fn adopt(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        (settings, tolerance): (&Settings, f64),
        (wrench_of, loads): (impl Fn(usize) -> Wrench<T>, impl Iterator<Item = (usize, T)>),
    ) -> bool {
        let plan = &*model.balance;
        if !plan.structure.is_plain(&plan.topology) {
            let joints = 0..plan.topology.joint_types.len();
            self.restart_from_each(parameters, bodies, joints.map(wrench_of));
            return false;
        }
        // All other wrenches follow by recursion along the tree.
        let cuts = plan.topology.cuts.iter().map(|cut| wrench_of(cut.joint));
        self.balance.carry_plainly(plan, cuts);
        self.interfaces.update_normal_forces(parameters, bodies, &self.balance.joint_wrenches);
        let (mut change, mut largest) = (T::zero(), T::zero());
        for (interface, load) in loads {
            let now = self.interfaces.states[interface].load.value;
            let moved = (now - load).abs();
            // Comparisons ignore NaN, sums propagate it.
            change = (moved - change).if_positive(moved, change) + now * T::zero();
            largest = (now - largest).if_positive(now, largest);
        }
        self.friction_change = change;
        self.finish_friction(model, parameters, bodies);
        self.balance.set_constants(&self.friction_efforts);
        settings.is_settled(change.largest(), largest.largest())
            && self.is_balanced_to(tolerance, model, parameters)
    }

    /// Updates slip and friction laws for friction coefficients multiplied by `part`.
    pub(in crate::dynamics) fn apply_friction_at(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        settings: &Settings,
        part: T,
    ) {
        let rest_speed = T::from_f64(settings.rest_speed);
        self.interfaces.update_slip(topology, parameters, bodies, rest_speed);
        for state in &mut self.interfaces.states {
            state.resistance.coefficient *= part;
        }
    }

    /// Solves again for the present motion after the static friction of interfaces at rest has
    /// changed. The effect of the change is linearised.
    pub(in crate::dynamics) fn update_static_friction(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        settings: &Settings,
    ) {
        let rest_speed = T::from_f64(settings.rest_speed);
        self.interfaces.update_slip(model.topology(), parameters, bodies, rest_speed);
        if self.mode == FrictionMode::Converged {
            // Static friction also changes the normal forces of sliding interfaces.
            self.couple(model, parameters, bodies, Coupling::Linear);
            self.interfaces.update_normal_forces(parameters, bodies, &self.balance.joint_wrenches);
        } else {
            self.couple(model, parameters, bodies, Coupling::Frozen);
        }
        self.finish_friction(model, parameters, bodies);
    }

    /// Solves with prescribed friction forces (N, one per interface, independent of the normal
    /// forces) and the matrix of the frictionless balance. [`Self::efforts`] and
    /// [`Self::joint_wrenches`] then include these friction forces.
    pub fn solve_with(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        frictions: &[T],
    ) {
        for (state, friction) in self.interfaces.states.iter_mut().zip(frictions) {
            state.resistance = Resistance { coefficient: T::zero(), constant: *friction };
        }
        self.couple(model, parameters, bodies, Coupling::Frozen);
        self.finish_friction(model, parameters, bodies);
    }
}
