//! Accumulation of the results of a run, sample by sample in chronological order.

use super::certainty::Certainty;
use super::joints::Turns;
use super::motors::Motors;
use super::sample::Sample;
use super::sides::Sides;
use super::solving::{ChunkResults, SampleResult};
use super::verdict::Verdict;
use crate::dofs::{actuated, dofs_of};
use crate::error::{Error, Missing, SinkError};
use crate::job::Job;
use stiction_core::dynamics::InverseError;
use stiction_core::mechanism::Mechanism;
use stiction_core::parameters::Parameters;
use stiction_core::statics::{Distances, SingularityDistances};

/// Results accumulated along the motion so far.
pub(super) struct Gathered<'a> {
    verdict: Verdict,
    sides: Sides,
    turns: Turns<'a>,
    motors: Motors,
    /// Index of each actuator's degree of freedom among the scalar degrees of freedom of all joints.
    actuated: Vec<usize>,
    /// Actuation singularity index at the last added sample; NaN if it was not computed.
    last_distance: f64,
    /// Calculator of the singularity indices whose computation was postponed.
    calculator: Option<SingularityDistances>,
    /// Least singularity indices so far.
    least: Distances,
    certainty: Certainty,
    missing: Option<Missing>,
    failed: Option<(f64, InverseError)>,
}

impl<'a> Gathered<'a> {
    /// Creates an empty result; `verdict` contains the results of the motion scan.
    pub(super) fn new(
        job: &Job<'a>,
        calculator: Option<SingularityDistances>,
        verdict: Verdict,
        motors: Motors,
    ) -> Self {
        Self {
            calculator,
            least: Distances { actuation: f64::INFINITY, constraint: f64::INFINITY },
            verdict,
            sides: Sides::default(),
            turns: Turns::new(job),
            motors,
            actuated: actuated(&dofs_of(&job.model.mechanism)),
            last_distance: 1.0,
            certainty: Certainty::default(),
            missing: None,
            failed: None,
        }
    }

    /// Computes the postponed singularity indices of a chunk, and returns the samples of the chunk,
    /// which the caller then passes to [`Self::take`]. The chunks must come in chronological order,
    /// so that results do not depend on the number of threads.
    pub(super) fn complete(
        &mut self,
        at: (&Mechanism, &Parameters<f64>),
        mut piece: ChunkResults,
    ) -> Vec<SampleResult> {
        if let Some(calculator) = &mut self.calculator {
            piece.least.compute(calculator, &mut self.least, at, &mut piece.samples);
        }
        piece.samples
    }

    /// Adds a sample and passes it to `receive`, unless the forces of an earlier sample had no solution.
    pub(super) fn take(
        &mut self,
        mechanism: &Mechanism,
        result: &mut SampleResult,
        receive: &mut impl FnMut(&Sample) -> Result<(), SinkError>,
    ) -> Result<(), Error> {
        let SampleResult { time, found } = result;
        let time = *time;
        let verdict = &mut self.verdict;
        let found = match found {
            Ok(found) if self.missing.is_none() && self.failed.is_none() => found,
            Ok(_) => return Ok(()),
            Err(error) => {
                self.sides = Sides::default();
                match error {
                    InverseError::CannotCarry { .. } => {
                        add_missing(&mut self.missing, time, error.clone(), verdict.samples);
                    }
                    // The run continues, because a load that cannot be carried at a later sample
                    // explains the failure better.
                    _ => {
                        self.failed.get_or_insert_with(|| (time, error.clone()));
                    }
                }
                return Ok(());
            }
        };
        let actuation = found.sample.distances.actuation;
        self.turns.add(time, &mut found.sample.joints);
        let passage = self.sides.see(found.side, time);
        // At singular poses only rounding determines the sign of the determinant. An index that was
        // not computed, because it is above the least index, is NaN.
        if self.last_distance != 0.0 && actuation != 0.0 {
            verdict.passed_singularities.extend(passage);
        }
        self.last_distance = actuation;
        if found.is_singular {
            match &mut verdict.singular {
                Some(known) => known.samples += 1,
                None => verdict.singular.clone_from(&found.singular),
            }
        }
        self.certainty.add(mechanism, time, &found.certainty);
        verdict.coupling = verdict.coupling.zip(found.certainty.coupling).map(|(a, b)| a.max(b));
        verdict.redundancy = verdict.redundancy.max(found.redundancy);
        let sample = &mut found.sample;
        let motion = |actuator: usize| sample.joints[self.actuated[actuator]];
        let forces = &sample.forces;
        let bounds = Some(&forces.effort_bounds[..]);
        sample.motors.clear();
        let motors = self.motors.evaluate(&forces.efforts, bounds, motion, &sample.bodies);
        sample.motors.extend(motors);
        receive(sample).map_err(Error::Receiver)
    }

    /// Returns the verdict on the whole motion.
    ///
    /// # Errors
    /// [`Error::CannotCarry`] or [`Error::Forces`] if the forces at a sample have no solution.
    pub(super) fn finish(self) -> Result<Verdict, Error> {
        let Self { mut verdict, certainty, missing, failed, .. } = self;
        match (missing, failed) {
            (None, None) => {
                verdict.other_solutions = certainty.others;
                verdict.friction_margin = certainty.margin;
                Ok(verdict)
            }
            (Some(missing), None) => Err(Error::CannotCarry(Box::new(missing))),
            // Jamming before a singular pose explains the failure better than the singular pose.
            (Some(missing), Some((time, error @ InverseError::Locked { .. })))
                if missing.time > time =>
            {
                Err(Error::Forces { time, error })
            }
            (Some(missing), Some(_)) => Err(Error::CannotCarry(Box::new(missing))),
            (None, Some((time, error))) => Err(Error::Forces { time, error }),
        }
    }
}

fn add_missing(missing: &mut Option<Missing>, time: f64, error: InverseError, of: usize) {
    let InverseError::CannotCarry { missing: amount, unit, .. } = error else { return };
    match missing {
        Some(known) => {
            known.samples += 1;
            if known.unit == unit {
                known.range = (known.range.0.min(amount), known.range.1.max(amount));
            }
        }
        None => {
            let range = (amount, amount);
            *missing = Some(Missing { first: error, time, range, unit, samples: 1, of });
        }
    }
}
