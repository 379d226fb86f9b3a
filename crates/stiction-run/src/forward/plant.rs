//! Plant: a simulation that a caller advances step by step, with constant inputs between the steps.

use super::job::Job;
use super::load_laws::ActingLoads;
use super::sample::Sample;
use super::start;
use crate::bodies::poses_from_ground;
use crate::dofs::{Dof, dofs_of};
use crate::error::{Error, check_finite};
use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::{
    Checkpoint, Event, Forward, Inputs, PayloadChange, Settings, Simulation, View,
};
use stiction_core::kinematics::{Bodies, Target};
use stiction_core::mechanism::{Body, BodyId};
use stiction_core::spatial::Pose;
use stiction_format::LoadCase;

/// Plant: a mechanism with the loads of a load case, for which the caller provides the actuator
/// efforts. A plant does not change during a simulation; [`PlantState`] contains everything that
/// changes.
#[derive(Clone, Debug)]
pub struct Plant {
    /// Models for successive sets of payloads that the bodies carry, in chronological order.
    stages: Vec<Forward>,
    changes: Vec<Change>,
    /// Load case without its payloads.
    load: LoadCase,
    settings: Settings,
    dofs: Vec<Dof>,
}

/// Change of a payload: the instant, s, at which a body picks up or places a part.
#[derive(Clone, Debug)]
struct Change {
    time: f64,
    body: BodyId,
    part: Body,
    picked_up: bool,
}

/// Complete state of a plant as plain numbers. A simulation that continues from a copy of the state
/// yields bitwise equal results.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlantState {
    /// State of the mechanism, see [`Checkpoint::numbers`].
    pub simulation: Vec<f64>,
    /// Number of payload changes that have already happened. A change is a part picked up or
    /// placed.
    pub changes: usize,
}

/// Inputs of a plant that stay constant until the caller changes them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Held {
    /// Effort of each actuator, N or N m.
    pub efforts: Vec<f64>,
    /// Forces and moments on bodies that act in addition to the loads of the load case.
    pub loads: Vec<AppliedLoad<f64>>,
}

/// Initial position and rate of each actuator, and initial pose of each body except the ground, in
/// the frame of the ground.
pub type InitialMotion = (Vec<Target<f64>>, Vec<(BodyId, Pose<f64>)>);

impl Plant {
    /// Creates the plant of a job. The plant ignores the job's controller, feed-forward efforts,
    /// stop conditions and end time.
    pub fn new(job: &Job<'_>) -> Self {
        let all = job.load.payload_changes((job.from, f64::INFINITY));
        let models = job.models_between(&all);
        let changes = all.iter().map(|change| Change {
            time: change.time,
            body: change.payload.body,
            part: change.payload.part.clone(),
            picked_up: change.picked_up,
        });
        Self {
            changes: changes.collect(),
            stages: models.into_iter().map(|m| Forward::new(m.mechanism, &[])).collect(),
            load: LoadCase { payloads: Vec::new(), ..job.load.clone() },
            settings: job.settings,
            dofs: dofs_of(&job.model.mechanism),
        }
    }

    /// Returns the positions and rates of the actuators in the initial state of the job, and the
    /// poses of all bodies except the ground in the frame of the ground.
    ///
    /// # Errors
    /// Fails if the mechanism cannot be assembled in the initial state.
    pub fn initial_motion(&self, job: &Job<'_>) -> Result<InitialMotion, Error> {
        let forward = &self.stages[0];
        let (state, _) = start::state(job, forward)?;
        let mut bodies = Bodies::new(forward.topology());
        bodies.place(forward.topology(), forward.parameters(), &state.coordinates);
        bodies.move_with(forward.topology(), &state.rates);
        let actuators = forward.mechanism().actuators();
        let motion =
            actuators.map(|(j, dof)| forward.joint_motion(&state, &bodies, j, dof)).collect();
        Ok((motion, poses_from_ground(forward, &bodies)))
    }

    /// Starts a simulation with the inputs `held`, and passes the results at the start to
    /// `receive`. `job` is the job from which the plant was created; it defines the initial state
    /// and the start time.
    ///
    /// # Errors
    /// Fails if the mechanism cannot be assembled, or has no accelerations in the initial state.
    pub fn start(
        &self,
        job: &Job<'_>,
        held: &Held,
        receive: &mut dyn FnMut(&Sample<'_>),
    ) -> Result<PlantState, Error> {
        let forward = &self.stages[0];
        let (state, _) = start::state(job, forward)?;
        check_finite(self.load.signals(), job.from)?;
        let mut inputs = self.inputs(held, 0, f64::INFINITY);
        let started = forward.start(job.from, state, self.settings, &mut inputs);
        let simulation = inputs.outcome(started)?;
        self.show(&simulation, (0, held), receive)?;
        Ok(PlantState { simulation: simulation.suspend().numbers, changes: 0 })
    }

    /// Advances the simulation to `until`, s, passes the results at its end to `receive`, and
    /// returns the events. If `to_event` is true, the simulation ends earlier, at the first step
    /// with an event that [changes the motion](stiction_core::forward::EventKind::changes_motion).
    /// `before` contains the inputs until now, and `held` the inputs from now on.
    ///
    /// # Errors
    /// Returns an error if the simulation cannot continue; the state is then unchanged.
    pub fn advance(
        &self,
        state: &mut PlantState,
        (before, held): (&Held, &Held),
        until: f64,
        to_event: bool,
        receive: &mut dyn FnMut(&Sample<'_>),
    ) -> Result<Vec<Event>, Error> {
        check_finite(self.load.signals(), until)?;
        let mut stage = state.changes;
        let mut simulation = self.resume(state, stage)?;
        let mut events = Vec::new();
        if held != before {
            let mut inputs = self.inputs(held, stage, until);
            let changed = simulation.change_inputs(&mut inputs);
            inputs.outcome(changed)?;
        }
        loop {
            let change = self.changes.get(stage);
            let end = change.map_or(until, |change| change.time.min(until));
            let mut inputs = self.inputs(held, stage, end);
            while simulation.instant().time < end {
                let advanced = simulation.advance_step(end, &mut inputs);
                inputs.outcome(advanced)?;
                events.extend(simulation.take_events());
                if to_event && events.iter().any(|event| event.kind.changes_motion()) {
                    break;
                }
            }
            let time = simulation.instant().time;
            let Some(change) = change.filter(|change| change.time <= time) else { break };
            stage += 1;
            let Change { body, part, picked_up, .. } = change;
            let change = PayloadChange { body: *body, part, picked_up: *picked_up };
            let mut inputs = self.inputs(held, stage, until);
            let changed = simulation.change_payload(&self.stages[stage], change, &mut inputs);
            inputs.outcome(changed)?;
            events.extend(simulation.take_events());
            if time >= until || to_event {
                break;
            }
        }
        self.show(&simulation, (stage, held), receive)?;
        *state = PlantState { simulation: simulation.suspend().numbers, changes: stage };
        Ok(events)
    }

    /// Continues a simulation of another plant, whose present state is `state`, with the parameters
    /// of this plant. Both plants describe the same mechanism, possibly with different friction
    /// coefficients or masses.
    ///
    /// # Errors
    /// Returns an error if the mechanism has no accelerations with the new values; the state is
    /// then unchanged.
    pub fn change_parameters(
        &self,
        state: &mut PlantState,
        held: &Held,
        receive: &mut dyn FnMut(&Sample<'_>),
    ) -> Result<Vec<Event>, Error> {
        let stage = state.changes;
        let mut simulation = self.resume(state, stage)?;
        let mut inputs = self.inputs(held, stage, f64::INFINITY);
        let changed = simulation.change_parameters(&mut inputs);
        inputs.outcome(changed)?;
        let events = simulation.take_events();
        self.show(&simulation, (stage, held), receive)?;
        state.simulation = simulation.suspend().numbers;
        Ok(events)
    }

    /// Evaluates the given state, for example a state saved earlier, and passes the results to
    /// `receive`.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] if the state does not belong to this plant.
    pub fn restore(
        &self,
        state: &PlantState,
        held: &Held,
        receive: &mut dyn FnMut(&Sample<'_>),
    ) -> Result<(), Error> {
        let simulation = self.resume(state, state.changes)?;
        self.show(&simulation, (state.changes, held), receive)
    }

    fn resume(&self, state: &PlantState, stage: usize) -> Result<Simulation<'_>, Error> {
        let forward = self.stages.get(stage).ok_or(Error::Checkpoint)?;
        let point = Checkpoint { numbers: state.simulation.clone(), events: Vec::new() };
        forward.resume(&point, self.settings).map_err(|_| Error::Checkpoint)
    }

    fn loads(&self, stage: usize) -> ActingLoads<'_> {
        ActingLoads { load: &self.load, mechanism: self.stages[stage].mechanism() }
    }

    fn inputs<'a>(&'a self, held: &'a Held, stage: usize, until: f64) -> HeldInputs<'a> {
        HeldInputs { loads: self.loads(stage), held, until, without_load: None }
    }

    fn show(
        &self,
        simulation: &Simulation<'_>,
        (stage, held): (usize, &Held),
        receive: &mut dyn FnMut(&Sample<'_>),
    ) -> Result<(), Error> {
        let forward = &self.stages[stage];
        let now = simulation.instant();
        let motion = |dof: &Dof| simulation.joint_motion(dof.joint, dof.index);
        let joints: Vec<_> = self.dofs.iter().map(motion).collect();
        let view = simulation.view();
        let mut loads = Vec::new();
        self.loads(stage).append(&view, view.sides(), &mut loads)?;
        loads.extend_from_slice(&held.loads);
        receive(&Sample {
            forward,
            instant: now,
            energies: simulation.energies(),
            energy_error: simulation.energy_error(),
            joints: &joints,
            reference: &[],
            tracked: &[],
            reference_poses: &[],
            loads: &loads,
            closure: forward.closure_error(&now.bodies, &now.state),
        });
        Ok(())
    }
}

/// Inputs of a simulation: efforts and loads of the caller that stay constant until a time, and the
/// loads of the load case.
struct HeldInputs<'a> {
    loads: ActingLoads<'a>,
    held: &'a Held,
    until: f64,
    /// Error of the last evaluation of the loads, if a load formula had no finite value in the
    /// evaluated state. The simulation first tries to avoid such states by shorter steps.
    without_load: Option<Error>,
}

impl HeldInputs<'_> {
    /// Converts the result of a computation with these inputs. If a load formula had no finite
    /// value, the error of this formula replaces the error of the computation, because it is the
    /// cause.
    fn outcome<T>(
        &mut self,
        result: Result<T, stiction_core::forward::ForwardError>,
    ) -> Result<T, Error> {
        let cause = self.without_load.take();
        result.map_err(|error| cause.unwrap_or(Error::Forward(error)))
    }
}

impl Inputs for HeldInputs<'_> {
    fn efforts(&mut self, _view: &View<'_>, efforts: &mut [f64]) {
        efforts.iter_mut().zip(&self.held.efforts).for_each(|(effort, held)| *effort = *held);
    }

    fn loads(&mut self, view: &View<'_>, loads: &mut Vec<AppliedLoad<f64>>) {
        self.without_load = self.loads.append(view, view.sides(), loads).err();
        loads.extend_from_slice(&self.held.loads);
    }

    fn switches(&mut self, view: &View<'_>, values: &mut Vec<f64>) {
        self.loads.switches(view, view.sides(), values);
    }

    fn switch_name(&self, switch: usize) -> String {
        self.loads.switch_name(switch).unwrap_or_else(|| "a formula".to_owned())
    }

    fn next_change(&self, time: f64) -> Option<f64> {
        Some(self.until).filter(|until| *until > time && until.is_finite())
    }

    fn steady_until(&self, time: f64) -> f64 {
        if self.loads.are_steady() { f64::INFINITY } else { time }
    }

    fn seen_until(&self, time: f64) -> f64 {
        self.loads.seen_until(time)
    }
}
