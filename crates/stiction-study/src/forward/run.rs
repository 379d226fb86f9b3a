//! A simulation carried out.

use super::acting::{Acting, prescribed};
use super::controller::{Turns, by_actuators};
use super::job::{Feed, Job};
use super::rows::freedoms_of;
use super::start;
use crate::inverse;
use crate::{Instants, InstantsError};
use stiction::dynamics::{AppliedLoad, InverseError};
use stiction::forward::{Energies, Event, Forward, ForwardError, Instant};
use stiction::kinematics::{AssemblyError, Target};
use stiction_model::{Course, Diagnostic, Motion};
use thiserror::Error;

/// Everything about one instant.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// The mechanism.
    pub forward: &'a Forward,
    /// Everything that is computed at the instant.
    pub instant: &'a Instant,
    /// Work since the start.
    pub energies: &'a Energies,
    /// What the account of energy has lost since the start, J.
    pub energy_error: f64,
    /// How all scalar freedoms of joints move; angles counted on over full turns.
    pub joints: &'a [Target<f64>],
    /// Where actuators are wanted, if something follows the motion.
    pub wanted: Option<&'a [Target<f64>]>,
    /// The loads from outside.
    pub loads: &'a [AppliedLoad<f64>],
    /// The largest loop-closure error, m (angles times the characteristic length).
    pub closure: f64,
}

/// How a simulation ended.
#[derive(Debug)]
pub enum Ending {
    /// It reached its last instant.
    Reached,
    /// The user stopped it.
    Interrupted,
    /// It cannot go on.
    Failed(Box<Error>),
}

/// What holds of the whole.
#[derive(Debug)]
pub struct Outcome {
    /// How it ended.
    pub ending: Ending,
    /// Number of samples.
    pub samples: usize,
    /// What happened.
    pub events: Vec<Event>,
    /// The instant of the last sample, s.
    pub last: f64,
    /// Redundant constraints, those of contacts that stick among them, the most at any sample.
    pub redundant: usize,
    /// How often accelerations were computed.
    pub evaluations: usize,
    /// Whether the actuators determine the motion, so that inverse dynamics can be asked for it.
    pub invertible: bool,
    /// Whether the rates at the start are others than was asked for, since what is prescribed or locked does
    /// not allow those.
    pub rates_changed: bool,
}

/// Why there is no simulation, or no more of it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// There are no instants.
    #[error(transparent)]
    Instants(#[from] InstantsError),
    /// The motion cannot be followed, or its efforts cannot be computed.
    #[error(transparent)]
    Motion(inverse::Error),
    /// A formula has no finite value.
    #[error("{}", .0.message)]
    NotFinite(Box<Diagnostic>),
    /// The controller's own model cannot be in the position that was measured.
    #[error("{0}")]
    Controller(AssemblyError),
    /// The controller's own model has no efforts.
    #[error("{0}")]
    ControllerForces(InverseError),
    /// The controller had no answer at this time.
    #[error("at t = {time} s the controller has no efforts: {error}")]
    ControllerAt {
        /// s.
        time: f64,
        /// Why.
        error: Box<Error>,
    },
    /// The mechanism cannot go on.
    #[error(transparent)]
    Forward(ForwardError),
    /// The samples could not be received.
    #[error("{0}")]
    Receiver(String),
    /// It was stopped before its first sample.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// Whether the input cannot be used (rather than that the question has no answer).
    pub fn is_bad_input(&self) -> bool {
        let incomplete = |error: &AssemblyError| {
            matches!(error, AssemblyError::Open { .. } | AssemblyError::AngleRange { .. })
        };
        match self {
            Self::Instants(_) | Self::NotFinite(_) => true,
            Self::Motion(error) => error.is_bad_input(),
            Self::Controller(_) | Self::ControllerForces(_) => true,
            Self::Forward(ForwardError::Assembly(error)) => incomplete(error),
            _ => false,
        }
    }
}

/// Rates at the start may differ by this part: projection and rounding.
const CHANGED: f64 = 1e-6;

impl Job<'_> {
    /// The instants of the samples.
    ///
    /// # Errors
    /// See [`InstantsError`].
    pub fn instants(&self) -> Result<Instants, InstantsError> {
        let span = Motion {
            title: String::new(),
            start: self.from,
            duration: (self.until - self.from).max(0.0),
            step: None,
            samples: None,
            coordinates: Vec::new(),
            interpolation: None,
        };
        Instants::of(&span, Some(self.step))
    }

    /// Carries it out; hands each sample to `receive`, and says how far it is to `progress` (samples done,
    /// samples in all). `stopped` is asked again and again whether the user wants it to stop.
    ///
    /// # Errors
    /// Where there is not even a first sample. What happens later is in [`Outcome::ending`].
    pub fn run(
        &self,
        mut receive: impl FnMut(&Sample<'_>) -> Result<(), String>,
        mut progress: impl FnMut(usize, usize),
        stopped: &dyn Fn() -> bool,
    ) -> Result<Outcome, Error> {
        let instants = self.instants()?;
        let count = instants.count();
        let forward = Forward::new(self.model.mechanism.clone(), &prescribed(self));
        let state = start::state(self, &forward)?;
        let mut acting = Acting::new(self, &forward, &state, stopped)?;
        self.check(self.from)?;
        let wished = state.rates.clone();
        let started = forward.start(self.from, state, self.settings, &mut acting);
        if acting.is_stopped {
            return Err(Error::Interrupted);
        }
        let mut simulation = match (started, acting.failed.take()) {
            (_, Some(error)) => return Err(error),
            (Err(error), None) => return Err(Error::Forward(error)),
            (Ok(simulation), None) => simulation,
        };
        let now = simulation.instant();
        let size = wished.iter().fold(0.0_f64, |size, rate| size.max(rate.abs()));
        let changed = wished.iter().zip(&now.state.rates).map(|(a, b)| (a - b).abs());
        let rates_changed = changed.fold(0.0, f64::max) > CHANGED * size;
        let invertible = by_actuators(self.model, &forward, (&now.state, &now.bodies)).is_ok();
        let freedoms = freedoms_of(&self.model.mechanism);
        let mut turns = Turns::new(freedoms.iter().map(|freedom| !freedom.translates).collect());
        let mut joints = Vec::with_capacity(freedoms.len());
        let mut wanted = Vec::new();
        let mut ending = Ending::Reached;
        let (mut done, mut last) = (0, self.from);
        let mut redundant = 0;
        for (k, time) in instants.iter().enumerate() {
            acting.go_to(time);
            let advanced = self
                .check(time)
                .and_then(|()| {
                    let moved = simulation.advance(time, &mut acting);
                    moved.map_err(Error::Forward)
                })
                .and_then(|()| match acting.wanted_at(time)? {
                    None => Ok(()),
                    Some(now) => {
                        wanted.clear();
                        wanted.extend_from_slice(now);
                        Ok(())
                    }
                });
            if acting.is_stopped || (stopped() && done > 0) {
                ending = Ending::Interrupted;
                break;
            }
            if let Some(error) = acting.failed.take() {
                ending = Ending::Failed(Box::new(error));
                break;
            }
            if let Err(error) = advanced {
                ending = Ending::Failed(Box::new(error));
                break;
            }
            let now = simulation.instant();
            joints.clear();
            for (index, freedom) in freedoms.iter().enumerate() {
                let (joint, own) = (freedom.joint, freedom.index);
                let mut motion = forward.joint_motion(&now.state, &now.bodies, joint, own);
                if k == 0 {
                    turns.last_mut()[index] = motion.value;
                }
                motion.value = turns.follow(index, motion.value);
                joints.push(motion);
            }
            let loads: Vec<AppliedLoad<f64>> = self.load.at(time).collect();
            let sample = Sample {
                forward: &forward,
                instant: now,
                energies: simulation.energies(),
                energy_error: simulation.energy_error(),
                joints: &joints,
                wanted: (!wanted.is_empty()).then_some(wanted.as_slice()),
                loads: &loads,
                closure: forward.closure_error(&now.bodies),
            };
            redundant = redundant.max(now.redundant);
            receive(&sample).map_err(Error::Receiver)?;
            done += 1;
            last = time;
            progress(k + 1, count);
        }
        Ok(Outcome {
            ending,
            samples: done,
            events: simulation.events().to_vec(),
            last,
            redundant,
            evaluations: simulation.evaluations(),
            invertible,
            rates_changed,
        })
    }

    /// Whether all formulas have finite values.
    fn check(&self, time: f64) -> Result<(), Error> {
        let drives: &[(usize, Course)] = match self.drives {
            Feed::Given(drives) => &drives.efforts,
            Feed::Inverse => &[],
        };
        let loads = self.load.wrenches.iter().flat_map(|w| w.force.iter().chain(&w.moment));
        for course in drives.iter().map(|(_, course)| course).chain(loads) {
            if let Some(fault) = course.fault_at(time) {
                return Err(Error::NotFinite(Box::new(fault)));
            }
        }
        Ok(())
    }
}
