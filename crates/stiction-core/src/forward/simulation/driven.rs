//! Stepwise simulation: the caller advances the simulation step by step, and may change the inputs
//! between steps.

use super::checkpoint::{FORMAT, Tape};
use super::{Checkpoint, Event, REST, Simulation};
use crate::forward::affine_friction::{InterfaceMode, is_smooth, norm};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;

impl Simulation<'_> {
    /// Advances by one integration step. The step ends at `until`, s, at the latest, and at each
    /// change between stick and slip. [`Self::take_events`] returns these changes.
    ///
    /// The inputs must announce [a change](Inputs::next_change) at `until`. This method does not
    /// apply the change; [`Self::change_inputs`] does.
    ///
    /// # Errors
    /// See [`ForwardError`]. After an error the simulation stays at the last valid instant.
    pub fn advance_step(
        &mut self,
        until: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        self.workspace.knows_inputs = false;
        if self.now.time < until && !self.is_over() {
            self.step_once(until, inputs)?;
        }
        self.change_at = f64::INFINITY;
        Ok(())
    }

    /// Removes and returns the events recorded since the last call, in chronological order.
    pub fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    /// Applies a change of the inputs at the present instant, which must be the end of a step.
    ///
    /// # Errors
    /// See [`ForwardError`]: no accelerations were found after the change.
    pub fn change_inputs(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        self.change_at = self.now.time;
        self.take_change(inputs)
    }

    /// Applies changed friction coefficients and masses at the present instant. The new values are
    /// the parameters of the model with which the simulation was
    /// [resumed](crate::forward::Forward::resume).
    ///
    /// # Errors
    /// See [`ForwardError`]: no accelerations were found after the change.
    pub fn change_parameters(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let model = self.model;
        let before = self.now.account.kinetic + self.now.account.potential;
        let pitch = &model.parameters.pitch;
        for (index, interface) in model.parameters.interfaces.iter().enumerate() {
            // Without dry friction an interface does not stick and has no direction of slip.
            if is_smooth(interface) {
                self.modes[index] = InterfaceMode::Smooth;
            } else if self.modes[index] == InterfaceMode::Smooth {
                let bodies = &self.now.bodies;
                let v = bodies.surface_velocity(&model.topology, interface, pitch[interface.joint]);
                let speed = norm(v);
                self.modes[index] = match speed <= REST * self.fastest {
                    true => InterfaceMode::Sticks,
                    false => InterfaceMode::Slides(v.map(|v| v / speed)),
                };
            }
        }
        self.step = 1e-4 * self.settings.longest_step.min(1.0);
        if self.stepping.is_none() {
            match self.reconsider(inputs, None) {
                Err(error) if self.may_step(&error) => self.begin_stepping(),
                other => other?,
            }
        }
        if self.stepping.is_some() {
            self.forces_of_next_step(inputs)?;
        }
        // From now on the energy balance uses the energy with the new masses.
        let change = self.now.account.kinetic + self.now.account.potential - before;
        self.energies.payloads += change;
        self.energies.turnover += change.abs();
        self.count_turns();
        Ok(())
    }

    /// Consumes the simulation and returns its state without events. The present instant must be
    /// the end of a step.
    pub fn suspend(mut self) -> Checkpoint {
        let mut numbers = vec![FORMAT];
        self.pass(&mut Tape::Out(&mut numbers));
        Checkpoint { numbers, events: Vec::new() }
    }
}
