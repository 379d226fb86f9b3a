//! Start of a simulation.

use super::between::LastStep;
use super::economy::Economy;
use super::method_change::{QUIET, is_without_acceleration};
use super::scratch::Scratch;
use super::stepping::{FIRST, JUMPS};
use super::{Energies, Method, REST, Settings, Simulation};
use crate::forward::Forward;
use crate::forward::affine_friction::{InterfaceMode, is_smooth, norm};
use crate::forward::data::FrictionDistribution;
use crate::forward::error::ForwardError;
use crate::forward::inputs::{InputState, Inputs, View};
use crate::forward::integrator::Steps;
use crate::forward::stick::Choice;
use crate::forward::time_stepping::StepStart;
use crate::kinematics::{Bodies, State};

impl Forward {
    /// Starts a simulation at `time`, s, from a state of the spanning tree of this model, such as
    /// that of [`Forward::assemble`]. The state is first projected onto the loop constraints. The
    /// spanning tree of inverse dynamics may be another one.
    ///
    /// # Errors
    /// See [`ForwardError`].
    ///
    /// # Panics
    /// If the numbers of coordinates and rates in the state differ from those of the spanning tree
    /// of this model.
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

/// Checks that the state has the dimensions of the model, and that its coordinates and rates are
/// finite. Accelerations in the state are ignored.
fn check(model: &Forward, time: f64, state: &State<f64>) -> Result<(), ForwardError> {
    let sizes = |state: &State<f64>| {
        [state.coordinates.len(), state.rates.len(), state.accelerations.len()]
    };
    let dofs = model.topology.dofs();
    let (found, expected) = (sizes(state), [model.topology.coordinates(), dofs, dofs]);
    assert!(
        found == expected,
        "the state has {found:?} coordinates, rates and accelerations for a tree that has {expected:?}"
    );
    let what = "a coordinate or a rate of the start";
    let mut values = state.coordinates.iter().chain(&state.rates);
    match values.all(|value| value.is_finite()) {
        true => Ok(()),
        false => Err(ForwardError::NotFinite { time, what }),
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
        check(model, time, &state)?;
        let interfaces = &model.parameters.interfaces;
        let bristles = vec![[0.0; 3]; interfaces.len()];
        let frozen = vec![false; model.topology.dofs()];
        let targets = model.targets(time, inputs);
        let mut bodies = Bodies::new(&model.topology);
        bodies.place(&model.topology, &model.parameters, &state.coordinates);
        bodies.move_with(&model.topology, &state.rates);
        // Sliding velocities before the projection onto the constraints. The projection may reduce
        // these velocities to their round-off, which must not count as slip.
        let pitch = &model.parameters.pitch;
        let velocities =
            interfaces.iter().map(|c| bodies.surface_velocity(&model.topology, c, pitch[c.joint]));
        let asked = velocities.map(norm).fold(0.0, f64::max);
        let wished = state.rates.clone();
        model.project(time, &mut state, &targets, &[], &frozen)?;
        bodies.place(&model.topology, &model.parameters, &state.coordinates);
        bodies.move_with(&model.topology, &state.rates);
        let size = |of: &dyn Fn(usize) -> f64| {
            let each = model.columns.iter().enumerate();
            each.map(|(k, column)| (of(k) / column).abs()).fold(0.0, f64::max)
        };
        let largest = size(&|k| wished[k]);
        let changed = size(&|k| wished[k] - state.rates[k]);
        let stands = targets.iter().all(|target| target.rate == 0.0);
        if stands && size(&|k| state.rates[k]) <= REST * largest {
            // The constraints allow none of the given rates. What the projection leaves is round-off,
            // which no constraint satisfies.
            state.rates.fill(0.0);
            bodies.move_with(&model.topology, &state.rates);
        }
        let dropped = if largest > 0.0 { changed / largest } else { 0.0 };
        let own = inputs.initial_states();
        let (topology, parameters) = (&model.topology, &model.parameters);
        let mut input = InputState {
            values: own.iter().map(|(value, _)| *value).collect(),
            scales: own.iter().map(|(_, scale)| *scale).collect(),
            sides: Vec::new(),
            angles: model.angles(time, &state, &bodies),
        };
        let (view_state, view_bodies) = (&state, &bodies);
        let view = |input| View {
            time,
            state: view_state,
            bodies: view_bodies,
            topology,
            parameters,
            input,
        };
        inputs.change(&view(&input));
        let mut values = Vec::new();
        inputs.switches(&view(&input), &mut values);
        input.sides = values.iter().map(|value| *value >= 0.0).collect();
        let mut situation = model.data(
            time,
            state,
            &bristles,
            &FrictionDistribution::default(),
            (&input, &mut *inputs),
        );
        model.check_accelerations(&situation)?;
        let fastest = situation.velocities.iter().map(|v| norm(*v)).fold(asked, f64::max);
        let mut modes = Vec::with_capacity(interfaces.len());
        let mut resting = Vec::new();
        for (index, interface) in interfaces.iter().enumerate() {
            let velocity = situation.velocities[index];
            let speed = norm(velocity);
            modes.push(if is_smooth(interface) {
                InterfaceMode::Smooth
            } else if speed <= REST * fastest {
                if let Some(prescribed) = model.prescribed_mode(index, (time, fastest), inputs) {
                    prescribed
                } else {
                    resting.push(index);
                    InterfaceMode::Sticks
                }
            } else {
                InterfaceMode::Slides(velocity.map(|v| v / speed))
            });
        }
        let in_steps = settings.method == Method::TimeStepping;
        let chosen = (!in_steps).then(|| model.choose(&mut situation, &modes, &resting, None));
        let distribution = match chosen {
            Some(_) => situation.distribution.clone(),
            None => FrictionDistribution::even(interfaces.len()),
        };
        let limit_factor = situation.limit_factor;
        // Reason why no accelerations exist at the start, if any.
        let mut refusal = None;
        let (now, modes, stepping) = match chosen {
            Some(Ok(Choice { modes, solved })) => {
                (model.instant(&situation, &modes, &solved), modes, false)
            }
            // Velocities after a time step may exist even if accelerations do not.
            Some(Err(error))
                if settings.method != Method::Automatic || !is_without_acceleration(&error) =>
            {
                return Err(error);
            }
            failed => {
                let state = situation.state;
                let first = model.time_step(
                    time,
                    FIRST,
                    StepStart {
                        state: &state,
                        modes: &modes,
                        bristles: &bristles,
                        frictions: &bristles,
                        input: &input,
                    },
                    inputs,
                );
                let time_step = match (first, failed) {
                    (Ok(time_step), failed) => {
                        refusal = failed.and_then(Result::err);
                        time_step
                    }
                    (Err(_), Some(Err(error))) | (Err(error), _) => return Err(error),
                };
                let modes = time_step.modes.clone();
                (model.instant_of(time, time_step, state, (&input, &mut *inputs)), modes, true)
            }
        };
        if let Some(what) = now.nonfinite() {
            return Err(ForwardError::NotFinite { time, what });
        }
        let energies = Energies {
            drives: vec![0.0; model.topology.actuators.len()],
            interfaces: vec![0.0; interfaces.len()],
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
            distribution,
            limit_factor,
            switch_at: f64::INFINITY,
            switching: vec![false; input.sides.len()],
            ended_by: None,
            switches_at_once: (0, 0.0),
            shortened_at: f64::NEG_INFINITY,
            chatter: (0, 0.0, 0.0),
            input,
            energies,
            fastest,
            fastest_rate: 0.0,
            coarsest: 0.0,
            step: 0.0,
            longest_of_lower_order: [settings.longest_step; 2],
            program_failed: false,
            motion_since_bound: 0.0,
            bound_reach: 1.0,
            events: Vec::new(),
            in_passage: false,
            reported_others: false,
            reported_shares: 0,
            stalled: 0,
            steps: Steps::default(),
            scales: Vec::new(),
            evaluations: 0,
            stepping: None,
            event_rate: (0, time),
            dropped,
            jumps: (JUMPS, time),
            stiff: (0, 0),
            crawling: 0,
            progress: (0, time),
            unsolved_steps: 0,
            wait: QUIET,
            economy: Economy::new(time),
            workspace: Box::new(Scratch::new(model)),
            lists: Vec::new(),
            last_step: LastStep::default(),
            change_at: f64::INFINITY,
        };
        let rates = simulation.now.state.rates.iter().zip(&model.columns);
        simulation.fastest_rate = rates.map(|(v, c)| (v / c).abs()).fold(0.0, f64::max);
        simulation.scales = simulation.error_scales();
        simulation.end_at_start(inputs);
        simulation.step = 1e-4 * settings.longest_step.min(1.0);
        if stepping {
            simulation.begin_stepping();
            // The simulation can start in this way only if the following step also succeeds;
            // otherwise, the error of the mode search, if any, is returned.
            let mut trial = simulation.clone();
            let goes_on = trial.step_through(time + settings.longest_step, inputs);
            return match goes_on {
                Ok(()) => Ok(simulation),
                Err(error) => Err(refusal.unwrap_or(error)),
            };
        }
        simulation.hold(inputs)?;
        model.check_finite_motion(&simulation.now, (&simulation.input, &mut *inputs))?;
        simulation.start_on_one_way(inputs)?;
        simulation.look_for_others(inputs)?;
        Ok(simulation)
    }
}
