//! Execution of a simulation.

use super::acting_inputs::{Acting, prescribed};
use super::checkpoint::{Figures, RunCheckpoint};
use super::controller::by_actuators;
use super::job::{Feed, Job};
use super::outcome::{Ending, Outcome};
use super::sample::Sample;
use super::start;
use crate::dofs::dofs_of;
use crate::error::{Error, SinkError, check_finite};
use crate::{Instants, InstantsError};
use stiction_core::forward::{Checkpoint, Event, Forward, PayloadChange};
use stiction_format::{LoadCase, Payload, Signal};

/// Largest relative change of the initial rates, due to their projection onto the constraints, that
/// counts as a rounding error.
const CHANGED: f64 = 1e-6;

impl Job<'_> {
    /// Returns the sample times of the results. The last one is [`Self::until`], even if the step
    /// does not divide the duration.
    ///
    /// # Errors
    /// See [`InstantsError`].
    pub fn instants(&self) -> Result<Instants, InstantsError> {
        Instants::up_to(self.from, self.until, self.step)
    }

    /// Runs the simulation. Each sample is passed to `receive`, together with a function that
    /// creates a checkpoint after this sample. The simulation calls `stopped` regularly and ends if
    /// it returns true. With `checkpoint`, the simulation resumes after the last sample of the
    /// checkpoint.
    ///
    /// # Errors
    /// Returns an error if the simulation fails before its first sample. [`Outcome::ending`]
    /// contains later failures.
    pub fn run(
        &self,
        mut receive: impl FnMut(&Sample<'_>, &dyn Fn() -> RunCheckpoint) -> Result<(), SinkError>,
        stopped: &dyn Fn() -> bool,
        checkpoint: Option<&RunCheckpoint>,
    ) -> Result<Outcome, Error> {
        let instants = self.instants()?;
        // One job and one model for each set of payloads that the bodies carry.
        let changes = self.load.payload_changes((self.from, self.until));
        let load = LoadCase { payloads: Vec::new(), ..self.load.clone() };
        let models = self.models_between(&changes);
        let jobs: Vec<Job<'_>> =
            models.iter().map(|model| Job { model, load: &load, ..self.clone() }).collect();
        let mut forwards: Vec<Forward> = jobs
            .iter()
            .map(|job| Forward::new(job.model.mechanism.clone(), &prescribed(job)))
            .collect();
        let (state, assembly_notes) = start::state(&jobs[0], &forwards[0])?;
        let mut changed = checkpoint.map_or(0, |point| point.figures.payload_changes);
        if changed > changes.len() {
            return Err(Error::Checkpoint);
        }
        let starts = std::iter::once(self.from).chain(changes.iter().map(|change| change.time));
        let ends = changes.iter().map(|change| change.time).chain([self.until]);
        let spans = jobs.iter().zip(&mut forwards).zip(starts.zip(ends));
        for ((job, forward), span) in spans.skip(changed) {
            if stopped() {
                return Err(Error::Interrupted);
            }
            job.record_program(forward, &state, span);
        }
        let (mut job, mut forward) = (&jobs[changed], &forwards[changed]);
        let start = state.clone();
        let next_change = |changed: usize| changes.get(changed).map_or(f64::INFINITY, |c| c.time);
        let mut acting = Acting::new(job, forward, &start, stopped)?;
        acting.payload_change = next_change(changed);
        self.check(self.from)?;
        let started = match checkpoint {
            None => forward.start(self.from, state, self.settings, &mut acting),
            Some(checkpoint) => {
                if !checkpoint.fits(&self.model.mechanism) {
                    return Err(Error::Checkpoint);
                }
                // The checkpoint stores the earlier events separately; they are added below.
                let numbers = checkpoint.simulation.clone();
                let point = Checkpoint { numbers, events: Vec::new() };
                let resumed = forward.resume(&point, self.settings);
                let simulation = resumed.map_err(|_| Error::Checkpoint)?;
                acting.restore(&checkpoint.inputs).ok_or(Error::Checkpoint)?;
                Ok(simulation)
            }
        };
        if acting.is_stopped {
            return Err(Error::Interrupted);
        }
        let mut simulation = match (started, acting.failed.take()) {
            (_, Some(error)) => return Err(error),
            (Err(error), None) => {
                let cause = acting.without_load.take();
                return Err(cause.unwrap_or_else(|| self.explain(Error::Forward(error), self.from)));
            }
            (Ok(simulation), None) => simulation,
        };
        let now = simulation.instant();
        let rates_changed = simulation.dropped() > CHANGED;
        let mut figures = match checkpoint {
            Some(checkpoint) => checkpoint.figures,
            None => Figures {
                invertible: by_actuators(job.model, forward, (&now.state, &now.bodies)).is_ok(),
                tuning: acting.tuning(),
                ..Figures::default()
            },
        };
        let dofs = dofs_of(&self.model.mechanism);
        let mut joints = Vec::with_capacity(dofs.len());
        let mut reference = Vec::new();
        let mut reference_poses = Vec::new();
        let tracked = self.followed();
        let mut ending = Ending::Reached;
        let (mut done, mut last) = (0, self.from);
        let mut before = Vec::new();
        if let Some(checkpoint) = checkpoint {
            done = checkpoint.samples;
            last = instants.at(done.saturating_sub(1));
            before.clone_from(&checkpoint.events);
        }
        // Checkpoint after the last sample, without events, and the number of events up to this
        // sample. A resumed run that is interrupted before its first sample keeps its checkpoint.
        let mut kept: Option<(RunCheckpoint, usize)> = checkpoint
            .map(|point| (RunCheckpoint { events: Vec::new(), ..point.clone() }, before.len()));
        // A checkpoint has the state at the start of a step. If it has all samples, the step to the
        // last one is repeated nevertheless, for its events and its number of evaluations.
        let repeats = checkpoint.is_some() && done == instants.count();
        for time in instants.iter().skip(done - usize::from(repeats)) {
            let mut advanced = self.check(time);
            while let Some(change) = changes.get(changed).filter(|change| change.is_due(time)) {
                let at = change.time;
                let moved = advanced
                    .and_then(|()| simulation.advance(at, &mut acting).map_err(Error::Forward));
                if moved.is_err() || simulation.ended_by().is_some() || acting.failed.is_some() {
                    advanced = moved;
                    break;
                }
                changed += 1;
                (job, forward) = (&jobs[changed], &forwards[changed]);
                let state = acting.save();
                advanced = Acting::new(job, forward, &start, stopped).and_then(|mut next| {
                    next.restore(&state).ok_or(Error::Checkpoint)?;
                    next.payload_change = next_change(changed);
                    acting = next;
                    figures.tuning = figures.tuning.worst(acting.tuning());
                    let Payload { body, part, .. } = change.payload;
                    let change = PayloadChange { body: *body, part, picked_up: change.picked_up };
                    simulation.change_payload(forward, change, &mut acting).map_err(Error::Forward)
                });
                if advanced.is_err() {
                    break;
                }
            }
            let advanced = advanced
                .and_then(|()| {
                    let moved = simulation.advance(time, &mut acting);
                    moved.map_err(Error::Forward)
                })
                .and_then(|()| {
                    reference.clear();
                    reference.extend_from_slice(acting.references_at(simulation.instant().time)?);
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
            match (advanced, acting.without_load.take()) {
                (Ok(()), _) => {}
                (Err(Error::Forward(_)), Some(cause)) => {
                    ending = Ending::Failed(Box::new(cause));
                    break;
                }
                (Err(error), _) => {
                    ending = Ending::Failed(Box::new(self.explain(error, time)));
                    break;
                }
            }
            // Loads are evaluated here because time stepping evaluates them only in the middle of
            // its steps.
            let loads = match self.loads_at(&simulation.view()) {
                Ok(loads) => loads,
                Err(error) => {
                    ending = Ending::Failed(Box::new(error));
                    break;
                }
            };
            let time = simulation.instant().time;
            if let Some(stop) = simulation.ended_by().and_then(|k| self.stops.get(k)) {
                ending = Ending::Stopped(stop.text().to_owned());
                if time <= last && done > 0 {
                    last = time;
                    break;
                }
            }
            if repeats {
                break;
            }
            joints.clear();
            joints.extend(dofs.iter().map(|f| simulation.joint_motion(f.joint, f.index)));
            acting.reference_poses(time, &tracked, &mut reference_poses);
            let numbers = simulation.checkpoint_numbers();
            let now = simulation.instant();
            let sample = Sample {
                forward,
                instant: now,
                energies: simulation.energies(),
                energy_error: simulation.energy_error(),
                joints: &joints,
                reference: &reference,
                tracked: &tracked,
                reference_poses: &reference_poses,
                loads: &loads,
                closure: forward.closure_error(&now.bodies, &now.state),
            };
            figures.redundant = figures.redundant.max(now.redundant);
            figures.open_drives = figures.open_drives.max(now.open_drives);
            figures.payload_changes = changed;
            done += 1;
            last = time;
            let bare = |numbers: Vec<f64>| RunCheckpoint {
                samples: done,
                simulation: numbers,
                inputs: acting.save(),
                figures,
                events: Vec::new(),
            };
            let make = || {
                let events = before.iter().chain(simulation.recorded_events());
                let events = events.cloned().collect();
                RunCheckpoint { events, ..bare(numbers.clone()) }
            };
            receive(&sample, &make).map_err(Error::Receiver)?;
            kept = Some((bare(numbers), before.len() + simulation.recorded_events().len()));
            if matches!(ending, Ending::Stopped(_)) {
                break;
            }
        }
        let mut events: Vec<Event> = before.iter().chain(simulation.events()).cloned().collect();
        let stopped = matches!(ending, Ending::Interrupted);
        let checkpoint = kept.filter(|_| stopped).map(|(checkpoint, count)| {
            // Events after the last sample are dropped, because the resumed simulation repeats
            // them.
            events.truncate(count);
            RunCheckpoint { events: events.clone(), ..checkpoint }
        });
        Ok(Outcome {
            assembly_notes,
            samples: done,
            events,
            last,
            checkpoint,
            redundant: figures.redundant,
            open_drives: figures.open_drives,
            evaluations: simulation.evaluations(),
            coarsest: simulation.coarsest(),
            invertible: figures.invertible,
            rates_changed,
            tuning: figures.tuning,
            ending,
        })
    }

    /// Checks that the signals of feed-forward efforts and loads have finite values at `time`, s.
    fn check(&self, time: f64) -> Result<(), Error> {
        let drives: &[(usize, Signal)] = match self.drives {
            Feed::Given(drives) => &drives.efforts,
            Feed::Inverse => &[],
        };
        let drives = drives.iter().map(|(_, signal)| signal);
        check_finite(drives.chain(self.load.signals()), time)
    }

    /// Returns the cause of a failure at `time`, s: the error of a signal that cannot be read or
    /// has no finite value at this time or, if all signals are finite, the given error.
    fn explain(&self, error: Error, time: f64) -> Error {
        let motion = self.motion.iter().flat_map(|motion| motion.signals());
        let fault = check_finite(motion, time).and_then(|()| self.check(time));
        fault.err().unwrap_or(error)
    }
}
