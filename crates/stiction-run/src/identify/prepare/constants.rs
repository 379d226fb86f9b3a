//! Unknown torque constants: factors that convert measured currents to torques.
//!
//! The theory is in equation (I10) of the book.

use super::Prepared;
use crate::identify::chosen::EffortColumn;
use crate::identify::run::differences;
use nalgebra::DVector;
use stiction_identify::{Kind, Parameter};

/// Largest factor by which one iteration increases or decreases a torque constant.
const STEP: f64 = 2.0;

/// Unknown torque constant of a motor whose measured current serves as the effort of an actuator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constant {
    /// Index of the parameter that represents the torque constant.
    parameter: usize,
    /// Present value of the torque constant, N m/A, with which the measured efforts are computed.
    value: f64,
}

impl Constant {
    /// Returns the unknown torque constants of the effort columns, with the initial value 1 N m/A.
    pub(super) fn of_columns(
        columns: &[EffortColumn],
        parameters: &[Parameter],
    ) -> Vec<Option<Self>> {
        let place =
            |train: usize| parameters.iter().position(|p| p.kind == Kind::TorqueConstant(train));
        let each = columns
            .iter()
            .map(|own| own.unknown.and_then(place).map(|parameter| Self { parameter, value: 1.0 }));
        each.collect()
    }
}

impl Prepared {
    /// Returns the parameter index and the present value, N m/A, of each actuator's unknown torque
    /// constant.
    pub(in crate::identify) fn constants(&self) -> impl Iterator<Item = Option<(usize, f64)>> {
        self.constants.iter().map(|own| own.map(|own| (own.parameter, own.value)))
    }

    /// Separates the part of the bounds of a measured effort that is proportional to the unknown
    /// torque constant K of its motor. The separated part is `effort K/K0`, where `effort` is the
    /// mean effort and K0 the present value. Returns the bounds minus `effort`, the index of the
    /// parameter K, and the coefficient `-effort/K0` of K in the bounded expression. Without an
    /// unknown torque constant, the bounds are unchanged.
    pub(super) fn scaled_by_constant(
        &self,
        channel: usize,
        bounds: [f64; 2],
        effort: f64,
    ) -> ([f64; 2], Option<(usize, f64)>) {
        match self.constants[channel] {
            Some(own) => {
                (bounds.map(|bound| bound - effort), Some((own.parameter, -effort / own.value)))
            }
            None => (bounds, None),
        }
    }

    /// Linearises the efforts about the parameter values `values`: load-dependent friction by
    /// [`Self::update_loads`], and torque constants by [`Self::set_constants`].
    ///
    /// # Errors
    /// If too many instants fail, returns the first time at which the forces have no solution, with
    /// the reason.
    pub(in crate::identify) fn linearise(
        &mut self,
        values: &[f64],
        groups: &[Vec<usize>],
    ) -> Result<(), String> {
        self.release_constants();
        let mut result = self.update_loads(values, groups);
        if let Some(reference) = &mut self.reference {
            result = result.and(reference.linearise(values, groups));
        }
        self.set_constants(values);
        result
    }

    /// Recomputes the measured efforts with the torque constants in `values`, each within a factor
    /// [`STEP`] of its present value. The regression column of a torque constant K is K times the
    /// derivative of the predicted current with respect to K. The column is computed from the
    /// effort that `values` predict, and therefore contains no noise of the current.
    pub(in crate::identify) fn set_constants(&mut self, values: &[f64]) {
        self.release_constants();
        let unknowns = differences(self.regressor.parameters(), values);
        for channel in 0..self.constants.len() {
            let Some(own) = self.constants[channel] else { continue };
            let bounds = (own.value / STEP, own.value * STEP);
            let value = values[own.parameter].clamp(bounds.0, bounds.1);
            self.scale_efforts(channel, value / own.value);
            self.constants[channel] = Some(Constant { value, ..own });
            let rows = &mut self.block.channels[channel];
            let predicted = rows.predicted(&unknowns);
            rows.matrix.set_column(own.parameter, &(&predicted / -value));
            rows.right -= predicted;
        }
        if let Some(reference) = &mut self.reference {
            reference.set_constants(values);
        }
        self.set_instruments();
    }

    /// Recomputes the measured efforts with the torque constants in `values`. Unlike
    /// [`Self::set_constants`], this function does not limit the changes of the torque constants,
    /// and leaves their regression columns zero.
    pub(in crate::identify) fn start_constants(&mut self, values: &[f64]) {
        self.release_constants();
        for channel in 0..self.constants.len() {
            let Some(own) = self.constants[channel] else { continue };
            let value = values[own.parameter];
            self.scale_efforts(channel, value / own.value);
            self.constants[channel] = Some(Constant { value, ..own });
        }
        if let Some(reference) = &mut self.reference {
            reference.start_constants(values);
        }
    }

    /// Sets the regression columns of torque constants to zero. The right-hand sides then contain
    /// the measured efforts minus the efforts of the model again.
    fn release_constants(&mut self) {
        for (rows, own) in self.block.channels.iter_mut().zip(&self.constants) {
            let Some(own) = own else { continue };
            let column: DVector<f64> = rows.matrix.column(own.parameter).into_owned();
            rows.right.axpy(-own.value, &column, 1.0);
            rows.matrix.column_mut(own.parameter).fill(0.0);
        }
    }

    fn scale_efforts(&mut self, channel: usize, factor: f64) {
        let rows = &mut self.block.channels[channel];
        let change = &rows.measured * (factor - 1.0);
        rows.measured += &change;
        rows.right += &change;
        self.mu.shift(channel, &change);
        if let Some(efforts) = &mut self.efforts {
            efforts.scale(channel, factor);
        }
        if let Some(noise) = &mut self.effort_noise {
            noise[channel] *= factor;
        }
        for standstill in &mut self.standstills {
            standstill.scale(channel, factor);
        }
    }
}
