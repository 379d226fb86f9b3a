//! Description of a run along a motion.

use super::error::Error;
use crate::{Instants, InstantsError};
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, Settings};
use stiction_core::kinematics::{AssemblyError, Coordinate, Target, locks};
use stiction_core::mechanism::BodyId;
use stiction_format::{LoadCase, ModelFile, Motion, Side, Signal};

/// Description of a run of inverse dynamics along a motion.
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
    /// Coupling of friction and reactions.
    pub friction: FrictionMode,
    /// Time between samples, s; by default that of the motion.
    pub step: Option<f64>,
    /// True to compute the friction margin to jamming.
    pub friction_margin: bool,
}

impl Job<'_> {
    /// Sample times.
    ///
    /// # Errors
    /// See [`InstantsError`].
    pub fn instants(&self) -> Result<Instants, InstantsError> {
        Instants::of(self.motion, self.step)
    }

    /// Assembles the mechanism at the pose that the motion prescribes at an instant, s.
    ///
    /// # Errors
    /// [`Error::Assembly`] if the loops do not close there, [`Error::NotFinite`] if the motion has no value.
    pub fn assemble(&self, time: f64) -> Result<InverseDynamics, Error> {
        let coordinates: Vec<Coordinate> =
            self.motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect();
        let mut targets =
            vec![Target { value: 0.0, rate: 0.0, acceleration: 0.0 }; coordinates.len()];
        self.check_motion(time)?;
        self.targets_at(time, &mut targets);
        let (mechanism, initial_poses) = (self.model.mechanism.clone(), &self.model.initial_poses);
        InverseDynamics::new(mechanism, initial_poses, &coordinates, &targets, Settings::default())
            .map_err(|error| Error::Assembly { time, error })
    }

    /// Names of the coordinates that must be locked to determine the configuration at the first
    /// instant, and a motion that consists of this instant with these coordinates locked; `None` if
    /// the motion alone determines the configuration.
    ///
    /// # Errors
    /// The mechanism cannot be assembled for another reason.
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

    /// Moves an assembled mechanism along the motion from one instant to another, s.
    ///
    /// # Errors
    /// See [`Job::assemble`].
    pub fn follow(&self, solver: &mut InverseDynamics, from: f64, to: f64) -> Result<(), Error> {
        self.check_motion(to)?;
        let followed = solver.follow(from, to, |t, targets| self.targets_at(t, targets));
        followed.or_else(|error| {
            // Reading a recording may fail during the step.
            self.check_motion(to)?;
            Err(Error::Assembly { time: to, error })
        })
    }

    fn targets_at(&self, time: f64, targets: &mut [Target<f64>]) {
        for (target, (_, signal)) in targets.iter_mut().zip(&self.motion.coordinates) {
            *target = signal.at(time);
        }
    }

    /// Checks that the motion has a finite value at an instant, s.
    pub(crate) fn check_motion(&self, time: f64) -> Result<(), Error> {
        for (_, signal) in &self.motion.coordinates {
            if let Some(fault) = signal.fault_at(time) {
                return Err(Error::NotFinite(Box::new(fault)));
            }
        }
        Ok(())
    }

    /// Replaces `loads` by the external wrenches at the solver's instant, s, and by the weights and
    /// inertia forces of the payloads carried on one side of it.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a load has no value; [`Error::Payload`] for a payload on a body that
    /// can spin freely, because its acceleration is unknown before the forces are computed.
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
                return Err(Error::Payload { body });
            }
            loads.push(AppliedLoad::of_payload(body, &payload.part, gravity, solver.bodies()));
        }
        Ok(())
    }

    /// Replaces `loads` by the external wrenches at an instant, s, and by the weights of the
    /// payloads carried after it, for a mechanism at rest.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a load has no value.
    pub fn loads_at_rest(&self, time: f64, loads: &mut Vec<AppliedLoad<f64>>) -> Result<(), Error> {
        self.loads_at(time, loads)?;
        let gravity = self.model.mechanism.gravity();
        let carried = self.load.payloads.iter().filter(|load| load.is_carried(time, Side::After));
        loads.extend(carried.map(|load| AppliedLoad::of_weight(load.body, &load.part, gravity)));
        Ok(())
    }

    /// Replaces `loads` by the external wrenches at an instant, s, without payloads.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a load has no value.
    pub fn loads_at(&self, time: f64, loads: &mut Vec<AppliedLoad<f64>>) -> Result<(), Error> {
        loads.clear();
        for wrench in &self.load.wrenches {
            for signal in wrench.force.iter().chain(&wrench.moment) {
                if let Some(fault) = signal.fault_at(time) {
                    return Err(Error::NotFinite(Box::new(fault)));
                }
            }
            loads.push(wrench.at(time));
        }
        Ok(())
    }
}
