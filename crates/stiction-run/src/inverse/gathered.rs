//! What the samples say together, taken in their order.

use super::certainty::Certainty;
use super::error::{Error, Missing};
use super::sample::Sample;
use super::sides::Sides;
use super::solving::Look;
use super::verdict::Verdict;
use stiction_core::dynamics::InverseError;
use stiction_core::mechanism::Mechanism;
use stiction_core::spatial::Vec3;

/// Everything along the motion so far.
pub(super) struct Gathered {
    verdict: Verdict,
    origin: Vec3<f64>,
    sides: Sides,
    /// From the actuators' singular positions, at the last sample.
    last_distance: f64,
    certainty: Certainty,
    missing: Option<Missing>,
    failed: Option<(f64, InverseError)>,
}

impl Gathered {
    /// Nothing yet, with what is known of the whole motion; `origin` is the kernel's in the world, m.
    pub(super) fn new(verdict: Verdict, origin: Vec3<f64>) -> Self {
        Self {
            verdict,
            origin,
            sides: Sides::default(),
            last_distance: 1.0,
            certainty: Certainty::default(),
            missing: None,
            failed: None,
        }
    }

    /// Adds a sample, and hands it on where there are forces so far.
    pub(super) fn take(
        &mut self,
        mechanism: &Mechanism,
        look: Look,
        receive: &mut impl FnMut(&Sample<'_>) -> Result<(), String>,
    ) -> Result<(), Error> {
        let Look { time, found } = look;
        let verdict = &mut self.verdict;
        let found = match found {
            Ok(found) if self.missing.is_none() && self.failed.is_none() => found,
            Ok(_) => return Ok(()),
            Err(error) => {
                self.sides = Sides::default();
                match error {
                    InverseError::CannotCarry { .. } => {
                        add_missing(&mut self.missing, time, error, verdict.samples);
                    }
                    // What cannot be carried elsewhere says more about why.
                    _ => {
                        self.failed.get_or_insert((time, error));
                    }
                }
                return Ok(());
            }
        };
        let passage = self.sides.see(found.side, time);
        // In singular positions the side is that of rounding.
        if self.last_distance != 0.0 && found.distances.actuation > 0.0 {
            verdict.passed_singularities.extend(passage);
        }
        self.last_distance = found.distances.actuation;
        if found.is_singular {
            match &mut verdict.singular {
                Some(known) => known.samples += 1,
                None => verdict.singular.clone_from(&found.singular),
            }
        }
        self.certainty.add(mechanism, time, &found.asked);
        verdict.coupling = verdict.coupling.zip(found.asked.coupling).map(|(a, b)| a.max(b));
        verdict.redundancy = verdict.redundancy.max(found.redundancy);
        receive(&found.sample(time, self.origin)).map_err(Error::Receiver)
    }

    /// What holds along the whole motion.
    ///
    /// # Errors
    /// Where there are no forces.
    pub(super) fn finish(self) -> Result<Verdict, Error> {
        let Self { mut verdict, certainty, missing, failed, .. } = self;
        match (missing, failed) {
            (None, None) => {
                verdict.other_solutions = certainty.others;
                verdict.friction_margin = certainty.margin;
                Ok(verdict)
            }
            (Some(missing), None) => Err(Error::CannotCarry(Box::new(missing))),
            // A mechanism that locks before says more than one that is singular later.
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
