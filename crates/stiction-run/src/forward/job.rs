//! Description of a simulation: model, inputs, initial state, duration, settings.

use super::control_law::ControlLaw;
use super::load_laws::ActingLoads;
use super::stop::Stop;
use crate::error::Error;
use crate::in_space::{Tracked, tracked};
use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::{Known, Settings, View};
use stiction_core::mechanism::JointId;
use stiction_format::{Control, Drives, LoadCase, ModelFile, Motion, Payload, PayloadChange, Side};

/// Model, inputs, initial state, duration and settings of a simulation.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// Model to simulate, as prepared by [`arrange`].
    pub model: &'a ModelFile,
    /// Motion that defines the start of the simulation and the reference of controllers.
    pub motion: Option<&'a Motion>,
    /// Name of the motion.
    pub motion_name: String,
    /// External loads.
    pub load: &'a LoadCase,
    /// Name of the load case.
    pub load_name: String,
    /// Feed-forward efforts: signals, formulas or inverse dynamics.
    pub drives: Feed<'a>,
    /// Name of the feed-forward efforts, for summaries.
    pub drives_name: String,
    /// Controller, whose efforts are added to the feed-forward efforts.
    pub control: Option<&'a Control>,
    /// Name of the controller.
    pub control_name: String,
    /// Model that controllers and inverse dynamics know, for the gains, the internal model and the feed-forward efforts,
    /// with the same geometry as `model`; `None` if they know `model` itself.
    pub known: Option<&'a ModelFile>,
    /// Control law that the caller provides; its efforts are added to the feed-forward efforts.
    pub law: Option<&'a ControlLaw>,
    /// Indices of the actuators whose motion is prescribed; their efforts follow from the motion.
    pub prescribed: Vec<usize>,
    /// Indices of the actuators that are locked at their start positions.
    pub locked: Vec<usize>,
    /// Stop conditions; each of them ends the simulation.
    pub stops: &'a [Stop],
    /// Initial state of the simulation.
    pub start: Start<'a>,
    /// Start time of the simulation, s.
    pub from: f64,
    /// End time of the simulation, s.
    pub until: f64,
    /// Time between samples of the results, s.
    pub step: f64,
    /// Integration scheme and tolerances.
    pub settings: Settings,
    /// True if friction acts.
    pub friction: bool,
}

/// Source of the feed-forward efforts.
#[derive(Clone, Copy, Debug)]
pub enum Feed<'a> {
    /// Efforts given as signals, which depend on time, or as formulas, which may also depend on the
    /// measured state.
    Given(&'a Drives),
    /// Efforts from inverse dynamics along the motion, including friction if [`Job::friction`] is
    /// true. They are updated at each sample of the controller or control law, or every millisecond
    /// if there are no samples.
    Inverse,
}

/// Initial state of a simulation.
#[derive(Clone, Copy, Debug)]
pub enum Start<'a> {
    /// Configuration and rates of the motion at its first instant.
    Moving,
    /// Configuration of the motion at its first instant, at rest.
    AtRest,
    /// Configuration and rates of the given motion at its first instant. Coordinates that the
    /// motion does not prescribe start at the home position, at rest.
    Given(&'a Motion),
    /// Known coordinates and rates. All other coordinates and rates follow from the loop
    /// constraints and from the home position.
    Known(&'a [Known]),
    /// Home position of the model, at rest.
    Home,
}

/// Feed-forward efforts that are all zero.
static NO_DRIVES: Drives = Drives {
    title: String::new(),
    efforts: Vec::new(),
    laws: Vec::new(),
    samples: None,
    interpolation: None,
};

impl<'a> Job<'a> {
    /// Creates a simulation that starts at rest in the home position, and in which only the given
    /// load and friction act. It lasts ten seconds, with a sample every 10 ms.
    pub fn new(model: &'a ModelFile, (load_name, load): (&str, &'a LoadCase)) -> Self {
        let none = || "none".to_owned();
        Self {
            model,
            motion: None,
            motion_name: none(),
            load,
            load_name: load_name.to_owned(),
            drives: Feed::Given(&NO_DRIVES),
            drives_name: none(),
            control: None,
            control_name: none(),
            known: None,
            law: None,
            prescribed: Vec::new(),
            locked: Vec::new(),
            stops: &[],
            start: Start::Home,
            from: 0.0,
            until: 10.0,
            step: 0.01,
            settings: Settings::default(),
            friction: true,
        }
    }

    /// Returns the model that controllers and inverse dynamics know.
    pub(super) fn known_model(&self) -> &'a ModelFile {
        self.known.unwrap_or(self.model)
    }
}

impl Job<'_> {
    /// Returns the external loads as inputs of a simulation. The loads may be functions of the
    /// simulated state.
    pub(super) fn acting_loads(&self) -> ActingLoads<'_> {
        ActingLoads { load: self.load, mechanism: &self.model.mechanism }
    }

    /// Returns the external loads at the time and in the state of `view`, including loads that are
    /// formulas of the measured state.
    ///
    /// # Errors
    /// [`Error::NoLoad`] if a formula has no value.
    pub(super) fn loads_at(&self, view: &View<'_>) -> Result<Vec<AppliedLoad<f64>>, Error> {
        let mut loads = Vec::new();
        self.acting_loads().append(view, &[], &mut loads)?;
        Ok(loads)
    }

    /// Returns the external loads at the start time of the simulation, for computations without a
    /// measured state.
    ///
    /// # Errors
    /// [`Error::StateLoad`] if a load is a formula of the measured state.
    pub(super) fn loads_without_state(&self) -> Result<Vec<AppliedLoad<f64>>, Error> {
        match self.load.laws.first() {
            None => Ok(self.load.at(self.from).collect()),
            Some(law) => {
                let body = self.model.mechanism.bodies()[law.body.0].name.clone();
                Err(Error::StateLoad { body })
            }
        }
    }

    /// Returns warnings about the samples of a recorded motion and about payloads that are never
    /// carried, one text for each warning.
    pub(super) fn cautions(&self) -> Vec<String> {
        let of_load = self.load.cautions(&self.model.mechanism, (self.from, self.until));
        self.motion.iter().flat_map(|motion| motion.cautions()).chain(of_load).collect()
    }

    /// Returns whether a controller or a control law acts.
    pub fn is_controlled(&self) -> bool {
        self.control.is_some() || self.law.is_some()
    }

    /// Returns whether a controller, feed-forward efforts or a prescribed actuator follow the motion.
    pub fn follows(&self) -> bool {
        let feeds = matches!(self.drives, Feed::Inverse);
        let has_reference = self.law.is_some() && self.motion.is_some();
        self.control.is_some() || has_reference || feeds || !self.prescribed.is_empty()
    }

    /// Returns a copy of the model in which the bodies carry the payloads of the load case, and a
    /// copy of the load case without payloads. Fails if a body picks up or places a payload during
    /// the simulation.
    pub(super) fn with_payloads(&self) -> Result<(ModelFile, LoadCase), Error> {
        let mut model = self.model.clone();
        let time = (self.from, self.until);
        let attached = self.load.attached(&model.mechanism, time);
        let (mechanism, load) = attached.map_err(|payload| Error::Payload {
            body: model.mechanism.bodies()[payload.body.0].name.clone(),
            from: self.from,
            until: self.until,
        })?;
        model.mechanism = mechanism;
        Ok((model, load))
    }

    /// Returns one model for each set of payloads that the bodies carry: at the start of the
    /// simulation, and after each of the payload changes `changes`.
    pub(super) fn models_between(&self, changes: &[PayloadChange<'_>]) -> Vec<ModelFile> {
        let mut carried: Vec<&Payload> = self
            .load
            .payloads
            .iter()
            .filter(|payload| payload.is_carried(self.from, Side::After))
            .collect();
        let model_of = |carried: &[&Payload]| {
            let mut model = self.model.clone();
            for payload in carried {
                model.mechanism = model.mechanism.with_payload(payload.body, &payload.part);
            }
            model
        };
        let mut models = vec![model_of(&carried)];
        for change in changes {
            if change.picked_up {
                carried.push(change.payload);
            } else {
                carried.retain(|payload| !std::ptr::eq(*payload, change.payload));
            }
            models.push(model_of(&carried));
        }
        models
    }

    /// Returns whether a body picks up or places a part during the simulation.
    pub(crate) fn has_payload_changes(&self) -> bool {
        !self.load.payload_changes((self.from, self.until)).is_empty()
    }

    /// Returns the bodies whose path in space is reported: the bodies that the motion prescribes
    /// or, if it prescribes none, the platforms, the end of an arm, or the couplers.
    pub fn tracked(&self) -> Vec<Tracked> {
        tracked(self.model, self.motion)
    }

    /// Returns [`Self::tracked`] if the simulation has a reference for these bodies; otherwise an
    /// empty list.
    pub fn followed(&self) -> Vec<Tracked> {
        if self.follows_in_space() { self.tracked() } else { Vec::new() }
    }

    /// Returns whether all actuators follow the motion, so that all bodies have a reference.
    pub fn follows_in_space(&self) -> bool {
        let followers = self.followers();
        self.motion.is_some() && !followers.is_empty() && followers.iter().all(|follows| *follows)
    }

    /// Returns one value for each actuator: true if the actuator follows the motion.
    pub fn followers(&self) -> Vec<bool> {
        let has_reference = self.law.is_some() && self.motion.is_some();
        let all = self.control.is_some() || has_reference || matches!(self.drives, Feed::Inverse);
        let count = self.model.mechanism.actuators().count();
        (0..count).map(|actuator| all || self.prescribed.contains(&actuator)).collect()
    }
}

/// Prepares a model for simulation, with or without friction. `locks` lists joint degrees of
/// freedom that become actuators, so that the simulation can lock them.
pub fn arrange(model: &ModelFile, friction: bool, locks: &[(JointId, usize)]) -> ModelFile {
    let mut model = model.clone();
    if !friction {
        model.mechanism = model.mechanism.without_friction();
    }
    for &(joint, dof) in locks {
        model.mechanism = model.mechanism.with_actuator(joint, dof);
    }
    model
}
