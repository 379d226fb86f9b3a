//! A job carried out: first the motion alone, then all forces.

use super::chunks;
use super::error::Error;
use super::gathered::Gathered;
use super::job::Job;
use super::motion_scan::{Following, Pace};
use super::sample::Sample;
use super::solving::{Looks, Solving};
use super::uniqueness::Uniqueness;
use super::verdict::{Verdict, idle_spins};
use stiction_core::dynamics::Settings;

/// What the job is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Following the motion.
    Motion,
    /// Computing forces.
    Forces,
}

/// Slower than this part of the fastest sliding speed of the motion is rest: reversals come out of
/// the arithmetic as 1e-16 of it, not as zero.
const REST: f64 = 1e-9;
/// Slower than this is rest whatever the motion, m/s: an atom's width in minutes. It tells where all
/// samples are reversals, as a single pose may be, and nothing in the motion is fast.
const STANDSTILL: f64 = 1e-12;

impl Job<'_> {
    /// Carries out the job; hands each sample to `receive`, and says how far it is to `progress`
    /// (phase, samples done, samples in all), which answers whether to go on.
    ///
    /// # Errors
    /// See [`enum@Error`].
    pub fn run(
        &self,
        receive: impl FnMut(&Sample<'_>) -> Result<(), String>,
        progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Verdict, Error> {
        self.run_on(1, receive, progress)
    }

    /// The same on so many threads; `receive` and `progress` are called on this one. What comes out does
    /// not depend on their number.
    ///
    /// # Errors
    /// See [`enum@Error`].
    pub fn run_on(
        &self,
        threads: usize,
        mut receive: impl FnMut(&Sample<'_>) -> Result<(), String>,
        mut progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Verdict, Error> {
        let instants = self.instants()?;
        let count = instants.count();
        let mut start = self.assemble(instants.at(0))?;

        // First the motion alone: can it be followed, how fast does it slide.
        let mut pace = Pace::none();
        let following = Following { mobility_at: [0, count / 3, 2 * count / 3] };
        chunks::carry_out(self, &start, &following, threads, |range, piece: Pace| {
            pace.add(piece);
            range.into_iter().try_for_each(|k| go_on(progress(Phase::Motion, k + 1, count)))
        })?;

        let rest_speed = (REST * pace.fastest).max(STANDSTILL);
        *start.settings_mut() =
            Settings { friction: self.friction, rest_speed, ..Settings::default() };
        let spins = start.constraints().spins().len();
        let actuators = start.mechanism().actuators().count();
        // What the mechanism is meant to leave: what its actuators can govern.
        let meant = pace.mobility.min(actuators + spins);
        let verdict = Verdict {
            samples: count,
            assembly_notes: start.assembly_report().notes(),
            mobility: pace.mobility,
            idle_spins: idle_spins(&start),
            redundancy: 0,
            weighting: start.weighting(),
            rest_speed,
            coupling: Some(0.0),
            passed_singularities: Vec::new(),
            other_solutions: None,
            friction_margin: None,
            singular: None,
        };
        let solving = Solving { job: self, uniqueness: Uniqueness::new(&start, meant) };
        let mut gathered = Gathered::new(verdict, start.parameters().origin);
        chunks::carry_out(self, &start, &solving, threads, |range, piece: Looks| {
            for look in piece.looks {
                gathered.take(start.mechanism(), look, &mut receive)?;
            }
            range.into_iter().try_for_each(|k| go_on(progress(Phase::Forces, k + 1, count)))
        })?;
        gathered.finish()
    }
}

fn go_on(answer: bool) -> Result<(), Error> {
    if answer { Ok(()) } else { Err(Error::Interrupted) }
}
