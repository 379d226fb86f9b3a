//! Where a simulation begins.

use super::{Energies, REST, Settings, Simulation};
use crate::forward::Forward;
use crate::forward::error::ForwardError;
use crate::forward::inputs::{Inputs, View};
use crate::forward::integrator::Steps;
use crate::forward::rub::{Contact, is_smooth, norm};
use crate::forward::stick::Choice;
use crate::kinematics::State;

impl Forward {
    /// Starts at a state, which is moved to where loops are closed.
    ///
    /// # Errors
    /// See [`ForwardError`].
    pub fn start(
        &self,
        time: f64,
        state: State<f64>,
        settings: Settings,
        inputs: &mut dyn Inputs,
    ) -> Result<Simulation<'_>, ForwardError> {
        Simulation::new(self, time, state, settings, inputs)
    }
}

impl<'a> Simulation<'a> {
    fn new(
        model: &'a Forward,
        time: f64,
        mut state: State<f64>,
        settings: Settings,
        inputs: &mut dyn Inputs,
    ) -> Result<Self, ForwardError> {
        let contacts = &model.parameters.contacts;
        let bristles = vec![[0.0; 3]; contacts.len()];
        let frozen = vec![false; model.topology.freedoms()];
        let targets = model.targets(time, inputs);
        model.project(time, &mut state, &targets, &[], &frozen)?;
        let mut bodies = crate::kinematics::Bodies::new(&model.topology);
        bodies.place(&model.topology, &model.parameters, &state.coordinates);
        bodies.move_with(&model.topology, &state.rates);
        inputs.change(&View { time, state: &state, bodies: &bodies, topology: &model.topology });
        let mut ground = model.ground(time, state, &bristles, (&[], &[]), inputs);
        let fastest = ground.velocities.iter().map(|v| norm(*v)).fold(0.0, f64::max);
        let mut modes = Vec::with_capacity(contacts.len());
        let mut resting = Vec::new();
        for (index, contact) in contacts.iter().enumerate() {
            let velocity = ground.velocities[index];
            let speed = norm(velocity);
            modes.push(if is_smooth(contact) {
                Contact::Smooth
            } else if speed <= REST * fastest {
                resting.push(index);
                Contact::Sticks
            } else {
                Contact::Slides(velocity.map(|v| v / speed))
            });
        }
        let Choice { modes, solved } = model.choose(&mut ground, &modes, &resting)?;
        let (grips, shares) = (ground.grips.clone(), ground.shares.clone());
        let overload = ground.overload;
        let now = model.instant(ground, &modes, &solved);
        let energies = Energies {
            drives: vec![0.0; model.topology.actuators.len()],
            contacts: vec![0.0; contacts.len()],
            ..Energies::default()
        };
        let mut simulation = Self {
            model,
            settings,
            energy_at_start: now.account.kinetic + now.account.potential,
            now,
            modes: modes.clone(),
            anchors: Vec::new(),
            frozen,
            bristles,
            grips,
            shares,
            overload,
            energies,
            fastest,
            fastest_rate: 0.0,
            step: 0.0,
            events: Vec::new(),
            told_of_others: false,
            told_of_shares: 0,
            stalled: 0,
            steps: Steps::default(),
            scales: Vec::new(),
            evaluations: 0,
        };
        simulation.scales = simulation.error_scales();
        simulation.hold(inputs)?;
        simulation.look_for_others(inputs)?;
        simulation.step = 1e-4 * settings.longest_step.min(1.0);
        Ok(simulation)
    }
}
