//! Forward dynamics step by step: a plant that a caller advances, and whose inputs remain constant
//! during each step.

mod quantities;
pub(crate) mod resources;
mod state_bytes;
mod tunable;
mod unit;

pub use unit::{Unit, UnitState};

use crate::error::Error;
use crate::forward::{Event, Forward, Plan, Sample, named};
use std::sync::Arc;
use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::Known;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::{Pose, Vec3};
use stiction_core::statics::LoadAxes;
use stiction_format::ModelFile;
use stiction_run::forward::{Held, Job, Plant as Engine, PlantState, Sample as Record, Start};
use tunable::Named;

/// A robot whose motion a caller advances step by step. Efforts and forces remain constant during
/// each step. See [`Forward::plant`](crate::Forward::plant).
///
/// ```
/// let robot = stiction::Robot::builtin("five-bar")?;
/// let mut plant = robot.forward().from("rest")?.plant()?;
/// for step in 1..=100 {
///     let angle = plant.sample()?.position("left_motor")?;
///     plant.set_effort("left_motor", -5.0 * (angle - 2.0))?;
///     plant.advance(0.001 * f64::from(step))?;
/// }
/// assert!((plant.time() - 0.1).abs() < 1e-12);
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Plant {
    setup: Arc<Setup>,
    /// Simulation engine for the model with the parameters that currently act.
    engine: Arc<Engine>,
    /// Inputs and parameters that act from the present instant on.
    set: Choice,
    /// Inputs and parameters that acted up to the present instant. The parameters are those in
    /// `engine`.
    acting: Choice,
    /// Time of the start, s, to which [`Self::begin`] resets the plant.
    from: f64,
    /// Positions and rates of the actuators at the start; `None` if they are those of the request.
    starts: Option<Vec<Target<f64>>>,
    state: Option<PlantState>,
    sample: Option<Sample>,
}

/// Inputs, and values of the tunable parameters, at one instant.
#[derive(Clone, Debug, Default)]
struct Choice {
    values: Vec<f64>,
    held: Held,
}

/// Data of a plant that remain constant after its creation.
#[derive(Debug)]
struct Setup {
    plan: Plan,
    tunables: Vec<Named>,
    /// Positions and rates of the actuators at the start of the requested simulation.
    initial: Vec<Target<f64>>,
    /// Poses of the bodies at the requested start, in the ground's frame. If the start is changed,
    /// they are the initial guesses that preserve the assembly mode.
    poses: Vec<(BodyId, Pose<f64>)>,
}

impl Forward {
    /// Creates a plant that the caller advances step by step, with the load, the initial state, the
    /// friction and the tolerance of this request. No efforts act besides those of the caller:
    /// controllers, feed-forward efforts, locks and stop conditions are rejected.
    ///
    /// # Errors
    /// The request contains one of these options, or the robot cannot be assembled at its start.
    pub fn plant(&self) -> Result<Plant, Error> {
        if let Some(what) = self.unfit_for_plant() {
            return Err(Error::input(format!("{what} cannot be part of a plant")).with_help(
                "leave it out: the program that imports the plant supplies efforts, controllers \
                 and the end time",
            ));
        }
        let plan = self.clone().controller("none")?.plan()?;
        let job = plan.job();
        let engine = Engine::new(&job);
        let tunables = tunable::tunables(&job.model.mechanism);
        let (initial, poses) = engine.initial_motion(&job)?;
        let choice = Choice {
            values: tunables.iter().map(|(.., value)| *value).collect(),
            held: Held { efforts: vec![0.0; initial.len()], loads: Vec::new() },
        };
        let from = job.from;
        Ok(Plant {
            engine: Arc::new(engine),
            set: choice.clone(),
            acting: choice,
            from,
            starts: None,
            state: None,
            sample: None,
            setup: Arc::new(Setup { plan, tunables, initial, poses }),
        })
    }
}

impl Plant {
    /// Present time of the plant, s.
    pub fn time(&self) -> f64 {
        self.sample.as_ref().map_or(self.from, |sample| sample.time)
    }

    /// Sets the effort of an actuator from now on, N or N m.
    ///
    /// # Errors
    /// The actuator does not exist, or the effort is not finite.
    pub fn set_effort(&mut self, actuator: &str, effort: f64) -> Result<(), Error> {
        let index = self.setup.plan.names().actuator(actuator)?;
        finite(effort, || format!("the effort of `{actuator}`"))?;
        self.set.held.efforts[index] = effort;
        self.forget_start();
        Ok(())
    }

    /// Sets a force (N) and a moment (N m) on a body at its origin, along world axes, from now on. They act in
    /// addition to the loads of the request.
    ///
    /// # Errors
    /// The body does not exist, or a component is not finite.
    pub fn set_force(
        &mut self,
        body: &str,
        force: [f64; 3],
        moment: [f64; 3],
    ) -> Result<(), Error> {
        let index = self.setup.plan.names().body(body)?;
        for component in force.iter().chain(&moment) {
            finite(*component, || format!("a component of the force on `{body}`"))?;
        }
        self.put_force(index, force, moment);
        Ok(())
    }

    fn put_force(&mut self, body: usize, force: [f64; 3], moment: [f64; 3]) {
        let load = force_on(body, force, moment);
        let loads = &mut self.set.held.loads;
        match loads.iter_mut().find(|known| known.body.0 == body) {
            Some(known) => *known = load,
            None => loads.push(load),
        }
        self.forget_start();
    }

    /// Names and present values of the parameters that can be changed at any time: friction coefficients and
    /// masses.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, f64)> {
        let names = self.setup.tunables.iter().map(|(_, name, _)| name.as_str());
        names.zip(self.set.values.iter().copied())
    }

    /// Changes a parameter from now on.
    ///
    /// # Errors
    /// There is no such parameter, or the value is negative or not finite, or a mass is zero.
    pub fn set_parameter(&mut self, name: &str, value: f64) -> Result<(), Error> {
        let names: Vec<String> = self.setup.tunables.iter().map(|(_, n, _)| n.clone()).collect();
        let index = crate::names::find("parameter", name, &names)?;
        self.put_parameter(index, value)
    }

    fn put_parameter(&mut self, index: usize, value: f64) -> Result<(), Error> {
        let (tunable, name, _) = &self.setup.tunables[index];
        finite(value, || format!("the parameter `{name}`"))?;
        let is_mass = matches!(tunable, tunable::Tunable::Mass(_));
        if value < 0.0 || is_mass && value == 0.0 {
            let limit = if is_mass { "positive" } else { "zero or positive" };
            return Err(Error::input(format!("the parameter `{name}` is {value}"))
                .with_help(format!("give a {limit} number")));
        }
        self.set.values[index] = value;
        self.forget_start();
        Ok(())
    }

    /// Resets the plant to its start. Sets the time of the start, s, and the positions and rates of
    /// all actuators at the start; `None` selects those of the request.
    ///
    /// # Errors
    /// A number is not finite.
    fn begin(&mut self, from: f64, starts: Option<Vec<Target<f64>>>) -> Result<(), Error> {
        finite(from, || "the start time".to_owned())?;
        (self.from, self.starts) = (from, starts);
        (self.state, self.sample) = (None, None);
        Ok(())
    }

    /// Discards the state if the plant is still at its start, so that changed inputs and parameters apply to the
    /// start.
    fn forget_start(&mut self) {
        if self.state.is_some() && self.sample.as_ref().is_some_and(|now| now.time <= self.from) {
            (self.state, self.sample) = (None, None);
        }
    }

    /// State, forces and friction at the present instant, with the inputs that act up to this instant.
    ///
    /// # Errors
    /// The robot cannot start.
    pub fn sample(&mut self) -> Result<&Sample, Error> {
        if self.sample.is_none() {
            self.start()?;
        }
        self.sample.as_ref().ok_or_else(|| Error::no_answer("the plant has no state"))
    }

    /// Computes the state at the start with the present inputs and parameters.
    fn start(&mut self) -> Result<(), Error> {
        let (model, known) = self.arranged(&self.set.values)?;
        let job = self.job(&model, &known);
        let engine = Engine::new(&job);
        let mut sample = None;
        let names = self.setup.plan.names();
        let mut receive = |now: &Record<'_>| sample = Some(Sample::new(Arc::clone(names), now));
        let state = engine.start(&job, &self.set.held, &mut receive)?;
        (self.state, self.sample, self.engine) = (Some(state), sample, Arc::new(engine));
        self.acting = self.set.clone();
        Ok(())
    }

    /// Returns the model with the given values of the tunable parameters, and the actuator
    /// coordinates at the start; the coordinates are empty unless the start was changed.
    fn arranged(&self, values: &[f64]) -> Result<(ModelFile, Vec<Known>), Error> {
        let mut model = self.setup.plan.job().model.clone();
        model.mechanism = tunable::tuned(&model.mechanism, &self.setup.tunables, values)?;
        if self.starts.is_some() {
            model.initial_poses.clone_from(&self.setup.poses);
        }
        let each = model.mechanism.actuators().zip(self.starts.iter().flatten());
        let known = each.map(|((joint, dof), start)| Known {
            coordinate: Coordinate::Joint { joint, dof },
            value: Some(start.value),
            rate: Some(start.rate),
        });
        let known = known.collect();
        Ok((model, known))
    }

    fn job<'a>(&'a self, model: &'a ModelFile, known: &'a [Known]) -> Job<'a> {
        let job = self.setup.plan.job();
        let start = if known.is_empty() { job.start } else { Start::Known(known) };
        Job { model, start, from: self.from, ..job }
    }

    /// Advances to a time, s, with the inputs and parameters that are set, and returns the events. Does nothing if
    /// the time is not later than the present.
    ///
    /// # Errors
    /// The robot cannot start or continue; the state of the plant is then unchanged.
    pub fn advance(&mut self, until: f64) -> Result<Vec<Event>, Error> {
        self.go(until, false)
    }

    /// Advances as [`Self::advance`] does, but stops at the end of the integration step in which a
    /// friction interface begins to stick or to slip, or velocities jump. Slip that a change of the
    /// inputs causes is detected at the end of the next step.
    ///
    /// # Errors
    /// See [`Self::advance`].
    pub fn advance_to_event(&mut self, until: f64) -> Result<Vec<Event>, Error> {
        self.go(until, true)
    }

    fn go(&mut self, until: f64, to_event: bool) -> Result<Vec<Event>, Error> {
        finite(until, || "the end of the step".to_owned())?;
        if self.state.is_none() {
            self.start()?;
        }
        let Some(mut state) = self.state.clone() else { return Ok(Vec::new()) };
        if until <= self.time() {
            return Ok(Vec::new());
        }
        let names = Arc::clone(self.setup.plan.names());
        let mut sample = None;
        let mut receive = |now: &Record<'_>| sample = Some(Sample::new(Arc::clone(&names), now));
        let mut events = Vec::new();
        let mut engine = Arc::clone(&self.engine);
        if self.set.values != self.acting.values {
            let (model, known) = self.arranged(&self.set.values)?;
            engine = Arc::new(Engine::new(&self.job(&model, &known)));
            events = engine.change_parameters(&mut state, &self.acting.held, &mut receive)?;
        }
        let held = (&self.acting.held, &self.set.held);
        events.extend(engine.advance(&mut state, held, until, to_event, &mut receive)?);
        (self.state, self.sample, self.engine) = (Some(state), sample, engine);
        self.acting = self.set.clone();
        Ok(named(&names, &events))
    }
}

/// Force and moment on a body at its origin, along world axes.
fn force_on(body: usize, force: [f64; 3], moment: [f64; 3]) -> AppliedLoad<f64> {
    let [point, force, moment] = [[0.0; 3], force, moment].map(|[x, y, z]| Vec3::new(x, y, z));
    AppliedLoad { body: BodyId(body), point, axes: LoadAxes::World, force, moment }
}

/// Rejects a number that is not finite.
fn finite(value: f64, what: impl FnOnce() -> String) -> Result<(), Error> {
    match value.is_finite() {
        true => Ok(()),
        false => Err(Error::input(format!("{} is {value}", what()))
            .with_help("give a finite number in SI units")),
    }
}
