//! Other frictions at the same motion: what forces would be with them.

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
    /// Loads as if the joints carried these wrenches: another start of the coupling.
    pub(in crate::dynamics) fn press_with(
        &mut self,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        wrenches: &[Wrench<T>],
    ) {
        self.balance.joint_wrenches.copy_from_slice(wrenches);
        self.interfaces.press(parameters, bodies, wrenches);
    }

    /// Speeds, directions and laws again, with this part of the coefficients.
    pub(in crate::dynamics) fn apply_friction_at(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        settings: &Settings,
        part: T,
    ) {
        let rest_speed = T::from_f64(settings.rest_speed);
        self.interfaces.slide(topology, parameters, bodies, rest_speed);
        for state in &mut self.interfaces.states {
            state.resistance.coefficient *= part;
        }
    }

    /// Solves again with the friction that contacts hold by at rest, everything else as it was, to
    /// first order in what they hold by.
    pub(in crate::dynamics) fn hold_again(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        settings: &Settings,
    ) {
        let rest_speed = T::from_f64(settings.rest_speed);
        self.interfaces.slide(model.topology(), parameters, bodies, rest_speed);
        if self.mode == FrictionMode::Converged {
            // Where no friction holds directly it still changes the loads of what slides.
            self.couple(model, parameters, bodies, Coupling::Linear);
            self.interfaces.press(parameters, bodies, &self.balance.joint_wrenches);
        } else {
            self.couple(model, parameters, bodies, Coupling::Frozen);
        }
        self.finish_friction(model.topology(), parameters, bodies);
    }

    /// Sets what every contact resists with; for probing.
    pub(in crate::dynamics) fn set_resistances(&mut self, resistance: Resistance<T>) {
        self.interfaces.states.iter_mut().for_each(|state| state.resistance = resistance);
    }

    /// Sets what one contact resists with; for probing.
    pub(in crate::dynamics) fn set_resistance(
        &mut self,
        interface: usize,
        resistance: Resistance<T>,
    ) {
        self.interfaces.states[interface].resistance = resistance;
    }

    /// All forces with given friction forces, N, one for each contact, whatever its load: solves once more,
    /// with the matrix of the frictionless balance. [`Self::efforts`] and [`Self::joint_wrenches`] are
    /// those with these frictions then.
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
        self.finish_friction(model.topology(), parameters, bodies);
    }

    /// The joints' wrenches with the present frictions, whatever their loads.
    pub(in crate::dynamics) fn frozen_wrenches(
        &mut self,
        model: &Model,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) -> &[Wrench<T>] {
        self.couple(model, parameters, bodies, Coupling::Frozen);
        &self.balance.joint_wrenches
    }
}
