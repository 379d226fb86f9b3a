//! Description of a run along a motion.

use crate::error::{Error, check_finite};
use crate::follower::Follower;
use crate::{Instants, InstantsError};
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics};
use stiction_core::kinematics::{AssemblyError, Coordinate, Target, locks};
use stiction_core::mechanism::BodyId;
use stiction_format::{LoadCase, ModelFile, Motion, Side, Signal};

/// Description of a run along a motion: inverse dynamics, static friction, a check or a conversion.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// Model of the mechanism.
    pub model: &'a ModelFile,
    /// Prescribed motion.
    pub motion: &'a Motion,
    /// Name of the motion.
    pub motion_name: String,
    /// External loads.
    pub load: &'a LoadCase,
    /// Name of the load case.
    pub load_name: String,
    /// Friction mode: coupled with the reactions, decoupled, or off.
    pub friction: FrictionMode,
    /// Time between samples, s; `None` for the step of the motion.
    pub step: Option<f64>,
    /// True to compute the friction margin to jamming.
    pub friction_margin: bool,
    /// Choice of the samples at which the singularity indices are computed.
    pub indices: Indices,
}

/// Choice of the samples at which a run computes the singularity indices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Indices {
    /// All samples.
    #[default]
    All,
    /// Samples that may have the least index of the motion. At other samples, the indices are NaN,
    /// and the coupling of friction and reactions is an upper bound that does not exceed the
    /// greatest coupling. This is sufficient for summaries.
    Least,
}

impl<'a> Job<'a> {
    /// Describes a run along a motion of the model under a load, with coupled friction.
    pub fn new(
        model: &'a ModelFile,
        (motion_name, motion): (&str, &'a Motion),
        (load_name, load): (&str, &'a LoadCase),
    ) -> Self {
        Self {
            model,
            motion,
            motion_name: motion_name.to_owned(),
            load,
            load_name: load_name.to_owned(),
            friction: FrictionMode::Converged,
            step: None,
            friction_margin: false,
            indices: Indices::All,
        }
    }

    /// Returns the sample times of the run.
    ///
    /// # Errors
    /// See [`InstantsError`].
    pub fn instants(&self) -> Result<Instants, InstantsError> {
        Instants::of(self.motion, self.step)
    }

    /// Returns cautions about the samples of a recorded motion, and about payloads that are never
    /// carried during the motion.
    pub(crate) fn cautions(&self) -> Vec<String> {
        let ends = (self.motion.start, self.motion.start + self.motion.duration);
        let of_load = self.load.cautions(&self.model.mechanism, ends);
        self.motion.cautions().chain(of_load).collect()
    }

    /// Assembles the mechanism at the pose that the motion prescribes at an instant, s.
    ///
    /// # Errors
    /// See [`Follower::new`].
    pub fn assemble(&self, time: f64) -> Result<Follower<'a>, Error> {
        Follower::new(self.model, self.motion, time)
    }

    /// Completes a motion that does not determine the configuration at its first instant. Returns a
    /// motion that consists of this instant with further coordinates locked, and the names of these
    /// coordinates. `None` if the motion alone determines the configuration.
    ///
    /// # Errors
    /// Returns an error if the mechanism cannot be assembled for a reason other than an
    /// undetermined configuration.
    pub fn locked_start(&self) -> Result<Option<(Motion, Vec<String>)>, Error> {
        let time = self.motion.start;
        match self.assemble(time) {
            Err(Error::Assembly {
                error: AssemblyError::Open { .. } | AssemblyError::Undetermined { .. },
                ..
            }) => {}
            other => return other.map(|_| None),
        }
        let coordinates: Vec<Coordinate> =
            self.motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect();
        let targets: Vec<Target<f64>> = self.motion.at(time).collect();
        let (mechanism, homes) = (&self.model.mechanism, &self.model.initial_poses);
        let found = locks(mechanism, homes, &coordinates, &targets)
            .map_err(|error| Error::Assembly { time, error })?;
        let mut motion = Motion { duration: 0.0, samples: None, ..self.motion.clone() };
        let mut names = Vec::new();
        for (coordinate, value) in found {
            let axes = ["x", "y", "z"];
            let body = |body: BodyId| &mechanism.bodies()[body.0].name;
            names.push(match coordinate {
                Coordinate::Joint { joint, dof } => mechanism.joints()[joint.0].dof_name(dof),
                Coordinate::Position { body: b, axis } => format!("{}.{}", body(b), axes[axis]),
                Coordinate::RotationVector { body: b, axis } => {
                    format!("{}.r{}", body(b), axes[axis])
                }
                Coordinate::Angle { body: b, .. } => body(b).clone(),
            });
            motion.coordinates.push((coordinate, Signal::constant(value)));
        }
        Ok(Some((motion, names)))
    }

    /// Replaces `loads` by the external loads at `time`, s, and by the weights and inertia forces
    /// of payloads. The solver must be at this time. If a payload changes at this instant, `side`
    /// selects the payloads before or after the change.
    ///
    /// # Errors
    /// The errors of [`Self::loads_at`]; [`Error::SpinningPayload`] for a payload on a body that
    /// can spin freely, because the acceleration of such a body is unknown before the forces are
    /// computed.
    pub fn loads_of(
        &self,
        solver: &InverseDynamics,
        (time, side): (f64, Side),
        loads: &mut Vec<AppliedLoad<f64>>,
    ) -> Result<(), Error> {
        self.loads_at(time, loads)?;
        let gravity = self.model.mechanism.gravity();
        let carried = self.load.payloads.iter().filter(|load| load.is_carried(time, side));
        for payload in carried {
            let body = payload.body;
            if solver.idle_axes().iter().any(|(spinning, _)| *spinning == body.0) {
                let body = self.model.mechanism.bodies()[body.0].name.clone();
                return Err(Error::SpinningPayload { body });
            }
            loads.push(AppliedLoad::of_payload(body, &payload.part, gravity, solver.bodies()));
        }
        Ok(())
    }

    /// Replaces `loads` by the external loads at an instant, s, for a mechanism at rest. The loads
    /// include the weights of the payloads that the bodies carry after this instant.
    ///
    /// # Errors
    /// See [`Self::loads_at`].
    pub fn loads_at_rest(&self, time: f64, loads: &mut Vec<AppliedLoad<f64>>) -> Result<(), Error> {
        self.loads_at(time, loads)?;
        let gravity = self.model.mechanism.gravity();
        let carried = self.load.payloads.iter().filter(|load| load.is_carried(time, Side::After));
        loads.extend(carried.map(|load| AppliedLoad::of_weight(load.body, &load.part, gravity)));
        Ok(())
    }

    /// Replaces `loads` by the external loads at an instant, s, without payloads.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a load is not finite; [`Error::StateLoad`] if a load is a formula of
    /// the state of the mechanism.
    pub fn loads_at(&self, time: f64, loads: &mut Vec<AppliedLoad<f64>>) -> Result<(), Error> {
        if let Some(law) = self.load.laws.first() {
            let body = self.model.mechanism.bodies()[law.body.0].name.clone();
            return Err(Error::StateLoad { body });
        }
        check_finite(self.load.signals(), time)?;
        loads.clear();
        loads.extend(self.load.at(time));
        Ok(())
    }
}

/// Returns the keyword of a friction mode, as in a model file and on the command line.
pub(crate) fn friction_word(mode: FrictionMode) -> &'static str {
    match mode {
        FrictionMode::Converged => "on",
        FrictionMode::OnePass => "one-pass",
        FrictionMode::Off => "off",
    }
}
