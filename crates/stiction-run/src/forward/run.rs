//! Run of a simulation.

use super::acting_inputs::{Acting, prescribed};
use super::checkpoint::{Figures, Mark};
use super::controller::by_actuators;
use super::job::{Feed, Job};
use super::outcome::{Ending, Outcome};
use super::sample::Sample;
use super::start;
use crate::dofs::dofs_of;
use crate::error::{Error, SinkError, check_finite};
use crate::{Instants, InstantsError};
use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::{Checkpoint, Event, Forward};
use stiction_format::Signal;

/// Relative change of the rates at the start that projection and rounding explain.
const CHANGED: f64 = 1e-6;

impl Job<'_> {
    /// Sample times; the last is [`Self::until`], even if the step does not divide the duration.
    ///
    /// # Errors
    /// See [`InstantsError`].
    pub fn instants(&self) -> Result<Instants, InstantsError> {
        Instants::up_to(self.from, self.until, self.step)
    }

    /// Runs the simulation. Passes each sample to `receive`, with a function that creates a
    /// checkpoint after it. Polls `stopped` for the user's request to stop. With `mark` the
    /// simulation resumes after the last sample of that checkpoint.
    ///
    /// # Errors
    /// The simulation fails before its first sample. Later failures are in [`Outcome::ending`].
    pub fn run(
        &self,
        mut receive: impl FnMut(&Sample<'_>, &dyn Fn() -> Mark) -> Result<(), SinkError>,
        stopped: &dyn Fn() -> bool,
        mark: Option<&Mark>,
    ) -> Result<Outcome, Error> {
        if !self.load.payloads.is_empty() {
            let (model, load) = self.with_payloads()?;
            let job = Job { model: &model, load: &load, ..self.clone() };
            return job.run(receive, stopped, mark);
        }
        let instants = self.instants()?;
        let forward = Forward::new(self.model.mechanism.clone(), &prescribed(self));
        let (state, assembly_notes) = start::state(self, &forward)?;
        let mut acting = Acting::new(self, &forward, &state, stopped)?;
        self.check(self.from)?;
        let started = match mark {
            None => forward.start(self.from, state, self.settings, &mut acting),
            Some(mark) => {
                if !mark.fits(&self.model.mechanism) {
                    return Err(Error::Mark);
                }
                // The checkpoint contains the earlier events.
                let numbers = mark.simulation.clone();
                let point = Checkpoint { numbers, events: Vec::new() };
                let resumed = forward.resume(&point, self.settings);
                let simulation = resumed.map_err(|_| Error::Mark)?;
                acting.restore(&mark.inputs).ok_or(Error::Mark)?;
                Ok(simulation)
            }
        };
        if acting.is_stopped {
            return Err(Error::Interrupted);
        }
        let mut simulation = match (started, acting.failed.take()) {
            (_, Some(error)) => return Err(error),
            (Err(error), None) => return Err(self.explain(Error::Forward(error), self.from)),
            (Ok(simulation), None) => simulation,
        };
        let now = simulation.instant();
        let rates_changed = simulation.dropped() > CHANGED;
        let mut figures = match mark {
            Some(mark) => mark.figures,
            None => Figures {
                invertible: by_actuators(self.model, &forward, (&now.state, &now.bodies)).is_ok(),
                ..Figures::default()
            },
        };
        let dofs = dofs_of(&self.model.mechanism);
        let mut joints = Vec::with_capacity(dofs.len());
        let mut wanted = Vec::new();
        let mut ending = Ending::Reached;
        let (mut done, mut last) = (0, self.from);
        let mut before = Vec::new();
        if let Some(mark) = mark {
            done = mark.samples;
            last = instants.at(done.saturating_sub(1));
            before.clone_from(&mark.events);
        }
        // Last checkpoint without its events, and the number of those events.
        let mut kept: Option<(Mark, usize)> = None;
        for time in instants.iter().skip(done) {
            let advanced = self
                .check(time)
                .and_then(|()| {
                    let moved = simulation.advance(time, &mut acting);
                    moved.map_err(Error::Forward)
                })
                .and_then(|()| {
                    wanted.clear();
                    wanted.extend_from_slice(acting.wanted_at(time)?);
                    Ok(())
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
                ending = Ending::Failed(Box::new(self.explain(error, time)));
                break;
            }
            let now = simulation.instant();
            joints.clear();
            joints.extend(dofs.iter().map(|f| simulation.joint_motion(f.joint, f.index)));
            let loads: Vec<AppliedLoad<f64>> = self.load.at(time).collect();
            let sample = Sample {
                forward: &forward,
                instant: now,
                energies: simulation.energies(),
                energy_error: simulation.energy_error(),
                joints: &joints,
                wanted: &wanted,
                loads: &loads,
                closure: forward.closure_error(&now.bodies),
            };
            figures.redundant = figures.redundant.max(now.redundant);
            figures.open_drives = figures.open_drives.max(now.open_drives);
            done += 1;
            last = time;
            let bare = || Mark {
                samples: done,
                simulation: simulation.checkpoint().numbers,
                inputs: acting.save(),
                figures,
                events: Vec::new(),
            };
            let make = || {
                let events = before.iter().chain(simulation.recorded_events());
                let events = events.cloned().collect();
                Mark { events, ..bare() }
            };
            receive(&sample, &make).map_err(Error::Receiver)?;
            kept = Some((bare(), before.len() + simulation.recorded_events().len()));
        }
        let mut events: Vec<Event> = before.iter().chain(simulation.events()).cloned().collect();
        let stopped = matches!(ending, Ending::Interrupted);
        let mark = kept.filter(|_| stopped).map(|(mark, count)| {
            // Events after the last sample recur after a restart.
            events.truncate(count);
            Mark { events: events.clone(), ..mark }
        });
        Ok(Outcome {
            assembly_notes,
            samples: done,
            events,
            last,
            mark,
            redundant: figures.redundant,
            open_drives: figures.open_drives,
            evaluations: simulation.evaluations(),
            coarsest: simulation.coarsest(),
            invertible: figures.invertible,
            rates_changed,
            ending,
        })
    }

    /// Checks that all signals have finite values at an instant, s.
    fn check(&self, time: f64) -> Result<(), Error> {
        let drives: &[(usize, Signal)] = match self.drives {
            Feed::Given(drives) => &drives.efforts,
            Feed::Inverse => &[],
        };
        let drives = drives.iter().map(|(_, signal)| signal);
        check_finite(drives.chain(self.load.signals()), time)
    }

    /// Finds the cause of an error: an unreadable recording or a signal without a value; else
    /// returns the error.
    fn explain(&self, error: Error, time: f64) -> Error {
        let motion = self.motion.iter().flat_map(|motion| motion.signals());
        let fault = check_finite(motion, time).and_then(|()| self.check(time));
        fault.err().unwrap_or(error)
    }
}
