//! What is to be simulated.

use super::error::Error;
use stiction_core::forward::{Known, Settings};
use stiction_core::mechanism::JointId;
use stiction_format::{Control, Drives, LoadCase, ModelFile, Motion};

/// What is to be simulated.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// The model as it is simulated, see [`arrange`].
    pub model: &'a ModelFile,
    /// The motion at whose first instant it starts, and which controllers follow.
    pub motion: Option<&'a Motion>,
    /// How the motion is called.
    pub motion_name: String,
    /// The load.
    pub load: &'a LoadCase,
    /// How the load is called.
    pub load_name: String,
    /// Efforts that do not depend on what happens.
    pub drives: Feed<'a>,
    /// How they are called.
    pub drives_name: String,
    /// A controller, whose efforts are added.
    pub control: Option<&'a Control>,
    /// How the controller is called.
    pub control_name: String,
    /// Actuators that move as the motion says, whatever effort that takes.
    pub prescribed: Vec<usize>,
    /// Actuators that stand where they start.
    pub locked: Vec<usize>,
    /// Where it starts.
    pub start: Start<'a>,
    /// The time at which it starts, s.
    pub from: f64,
    /// The last instant, s.
    pub until: f64,
    /// Time between samples, s.
    pub step: f64,
    /// How accurately.
    pub settings: Settings,
    /// Whether friction acts.
    pub friction: bool,
}

/// Efforts that do not depend on what happens.
#[derive(Clone, Copy, Debug)]
pub enum Feed<'a> {
    /// As given.
    Given(&'a Drives),
    /// What inverse dynamics says for the motion, with friction if it acts, updated at each sample of the
    /// controller or every millisecond.
    Inverse,
}

/// Where a simulation starts.
#[derive(Clone, Copy, Debug)]
pub enum Start<'a> {
    /// As the motion does, with its rates.
    Moving,
    /// At the motion's first position, at rest.
    AtRest,
    /// At the first instant of this motion, which need not determine everything: the other freedoms are
    /// where the model puts them, at rest.
    Given(&'a Motion),
    /// At these coordinates and rates; all others follow from the loops and the home position.
    Known(&'a [Known]),
    /// Where the model puts it, at rest.
    Home,
}

impl Job<'_> {
    /// Whether something follows the motion.
    pub fn follows(&self) -> bool {
        let feeds = matches!(self.drives, Feed::Inverse);
        self.control.is_some() || feeds || !self.prescribed.is_empty()
    }

    /// The model whose bodies carry the payloads of the load, and the load without them.
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

    /// For each actuator whether something has it follow the motion.
    pub fn followers(&self) -> Vec<bool> {
        let all = self.control.is_some() || matches!(self.drives, Feed::Inverse);
        let count = self.model.mechanism.actuators().count();
        (0..count).map(|actuator| all || self.prescribed.contains(&actuator)).collect()
    }
}

/// The model as it is simulated: with or without friction, and with locks, which are actuators, on these
/// freedoms as well.
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
