//! Parts that bodies pick up or place during a simulation.
//!
//! A part that is picked up was at rest, and takes on the velocity of the body instantly in a
//! plastic impact. The impulses of loops, prescribed actuators and friction balance the momentum,
//! as in a step of the time-stepping method whose length tends to zero. A part that is placed
//! leaves with the velocity of the body, without an impact.
//!
//! Equation (E5) of the book's theory.

use super::between::LastStep;
use super::scratch::Scratch;
use super::stepping::FIRST;
use super::{Event, EventKind, Simulation};
use crate::forward::Forward;
use crate::forward::error::ForwardError;
use crate::forward::inputs::{Inputs, View};
use crate::forward::time_stepping::StepStart;
use crate::kinematics::{Bodies, Target};
use crate::mechanism::{Body, BodyId};
use crate::spatial::Vec3;
use crate::statics::{AppliedLoad, LoadAxes};

/// Length of the time step that contains an impact, s. In this step, other forces change velocities
/// only by 1e-12 of the change that they cause in one second.
const INSTANT: f64 = 1e-12;

/// Payload change: a part that a body picks up or places.
#[derive(Clone, Copy, Debug)]
pub struct PayloadChange<'p> {
    /// Body that picks up or places the part.
    pub body: BodyId,
    /// Mass, centre of mass and inertia of the part, in the frame of the body that carries the
    /// part.
    pub part: &'p Body,
    /// True if the body picks up the part, false if the body places it.
    pub picked_up: bool,
}

impl<'a> Simulation<'a> {
    /// Changes the payload at the end of the present step and continues with `model`, whose bodies
    /// have the masses after the change. The inputs must have [a change](Inputs::next_change) at
    /// this time. `model` must be created from the same mechanism with the same prescribed
    /// actuators; only masses may differ.
    ///
    /// The impact is recorded as an event, and the lost energy is added to
    /// [`super::Energies::impacts`].
    ///
    /// # Errors
    /// See [`ForwardError`]: for example, no velocities after the impact or no accelerations were
    /// found.
    pub fn change_payload(
        &mut self,
        model: &'a Forward,
        change: PayloadChange<'_>,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let before = self.now.bodies.clone();
        let potential = -change.part.mass
            * model.parameters.gravity.dot(before.pose[change.body.0].apply(change.part.com));
        self.model = model;
        *self.workspace = Scratch::new(model);
        self.program_failed = false;
        self.restart_bound();
        self.lists.clear();
        self.last_step = LastStep::default();
        let lost = if change.picked_up {
            self.pick_up(change, &before, inputs)?;
            work(change, &before, &self.now.bodies)
        } else {
            0.0
        };
        let energies = &mut self.energies;
        energies.impacts += lost;
        energies.payloads += match change.picked_up {
            true => potential,
            false => -potential - work(change, &before, &before),
        };
        energies.turnover += lost.abs() + potential.abs();
        let PayloadChange { body, picked_up, .. } = change;
        let kind = EventKind::Payload { body, picked_up, lost };
        self.events.push(Event { time: self.now.time, kind });
        if self.stepping.is_none() {
            self.step = 1e-4 * self.settings.longest_step.min(1.0);
            match self.reconsider(inputs, None) {
                Err(error) if self.may_step(&error) => self.begin_stepping(),
                other => other?,
            }
        }
        if self.stepping.is_some() {
            self.forces_of_next_step(inputs)?;
        }
        self.count_turns();
        Ok(())
    }

    /// Replaces the forces at the present instant by the mean forces over a short time step that
    /// starts at this instant.
    pub(super) fn forces_of_next_step(
        &mut self,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let state = self.now.state.clone();
        let start = StepStart {
            state: &state,
            modes: &self.modes,
            bristles: &self.bristles,
            frictions: &vec![[0.0; 3]; self.modes.len()],
            input: &self.input,
        };
        let time = self.now.time;
        let time_step = self.model.time_step(time, FIRST, start, inputs)?;
        self.now = self.model.instant_of(time, time_step, state, (&self.input, inputs));
        Ok(())
    }

    /// Computes the velocities after the impact with the part, and sets them as the present
    /// velocities.
    fn pick_up(
        &mut self,
        change: PayloadChange<'_>,
        before: &Bodies<f64>,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let PayloadChange { body, part, .. } = change;
        let (com, spin) = velocities(change, before);
        // The part has no momentum before the impact. This impulse subtracts the momentum of a part
        // that moves with the body.
        let impulse = AppliedLoad {
            body,
            point: part.com,
            axes: LoadAxes::World,
            force: com * (-part.mass / INSTANT),
            moment: before.pose[body.0].rotation * (part.inertia * spin) * (-1.0 / INSTANT),
        };
        let from = self.now.state.clone();
        let (modes, bristles) = (self.modes.clone(), self.bristles.clone());
        let near: Vec<[f64; 3]> = self.now.interfaces.iter().map(|c| c.friction).collect();
        let time = self.now.time;
        let input = self.input.clone();
        let mut with_impulse = WithImpulse { inputs: &mut *inputs, impulse };
        let context = (&modes[..], &bristles[..], &near[..]);
        let mut result =
            self.land(time - INSTANT, INSTANT, &from, context, (&input, &mut with_impulse))?;
        // Loads do finite work in the impact only through the impulse, which is not an external
        // load.
        result.time_step.work.loads = 0.0;
        result.time_step.work.dampers = 0.0;
        result.state.coordinates.clone_from(&from.coordinates);
        result.time_step.bristles.clone_from(&bristles);
        result.time_step.input_states.clone_from(&input.values);
        self.settle(time, result, inputs);
        Ok(())
    }
}

/// Returns the velocity of the centre of mass of the part, m/s, in world axes, and the angular
/// velocity of the part, rad/s, in the axes of the body.
fn velocities(change: PayloadChange<'_>, bodies: &Bodies<f64>) -> (Vec3<f64>, Vec3<f64>) {
    let (pose, twist) = (bodies.pose[change.body.0], bodies.twist[change.body.0]);
    let com = twist.velocity_at(pose.apply(change.part.com));
    (com, pose.rotation.transpose_mul(twist.angular))
}

/// Returns half the scalar product of the momentum of the part after the impact and the velocity of
/// the body before the impact, J. This is the energy lost in the impact, excluding the work of
/// friction and actuators. If both motions are equal, the result is the kinetic energy of the part.
fn work(change: PayloadChange<'_>, before: &Bodies<f64>, after: &Bodies<f64>) -> f64 {
    let ((com, spin), (com_after, spin_after)) =
        (velocities(change, before), velocities(change, after));
    let part = change.part;
    0.5 * (part.mass * com.dot(com_after) + spin.dot(part.inertia * spin_after))
}

/// Adds one load to the loads of other inputs: the impulse of a part that is picked up.
struct WithImpulse<'i> {
    inputs: &'i mut dyn Inputs,
    impulse: AppliedLoad<f64>,
}

impl Inputs for WithImpulse<'_> {
    fn efforts(&mut self, view: &View<'_>, efforts: &mut [f64]) {
        self.inputs.efforts(view, efforts);
    }

    fn targets(&mut self, time: f64, targets: &mut [Target<f64>]) {
        self.inputs.targets(time, targets);
    }

    fn loads(&mut self, view: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        self.inputs.loads(view, loads);
        loads.push(self.impulse);
    }

    fn state_rates(&mut self, view: &View<'_>, rates: &mut [f64]) {
        self.inputs.state_rates(view, rates);
    }
}
