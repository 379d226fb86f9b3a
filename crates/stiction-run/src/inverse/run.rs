//! Inverse dynamics along a motion: a scan of the motion, followed by the computation of all
//! forces.

use super::chunks;
use super::gathered::Gathered;
use super::motion_scan::{Following, MotionExtremes};
use super::motors::Motors;
use super::sample::Sample;
use super::solving::{ChunkResults, Solving, Spare};
use super::track::Track;
use super::uniqueness::Uniqueness;
use super::verdict::{Verdict, idle_spins};
use crate::dofs::dofs_of;
use crate::error::{Error, SinkError};
use crate::job::Job;
use stiction_core::dynamics::Settings;

/// Phase of a run, for progress displays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Scan of the motion without forces.
    Motion,
    /// Computation of forces.
    Forces,
}

/// Sliding speed, as a fraction of the largest sliding speed of the run, below which a friction
/// interface counts as being at rest. At a reversal, rounding errors leave about 1e-16 of the
/// largest speed instead of zero.
const REST: f64 = 1e-9;
/// Sliding speed, m/s, below which a friction interface counts as being at rest in any motion. This
/// limit applies to motions that consist only of reversals or of a single pose.
const STANDSTILL: f64 = 1e-12;

impl Job<'_> {
    /// Computes the run on one thread. Each sample is passed to `receive`. `progress` receives the
    /// phase, the number of completed samples and the total number; if it returns false, the run
    /// stops.
    ///
    /// # Errors
    /// See [`enum@Error`].
    pub fn run(
        &self,
        receive: impl FnMut(&Sample) -> Result<(), SinkError>,
        progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Verdict, Error> {
        self.run_on(1, receive, progress)
    }

    /// Computes the run on `threads` threads. `receive` and `progress` are called on the caller's
    /// thread, as in [`Self::run`]. The results do not depend on the number of threads.
    ///
    /// # Errors
    /// See [`enum@Error`].
    pub fn run_on(
        &self,
        threads: usize,
        mut receive: impl FnMut(&Sample) -> Result<(), SinkError>,
        mut progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Verdict, Error> {
        let instants = self.instants()?;
        let count = instants.count();
        let mut follower = self.assemble(instants.at(0))?;
        follower.solver.extrapolate();
        self.record_program(&mut follower, &instants);

        // The first pass scans the motion.
        let mut extremes = MotionExtremes::none();
        let following = Following { mobility_at: [0, count / 3, 2 * count / 3] };
        let nothing = Track::default();
        let scan = (&following, &nothing);
        chunks::carry_out(self, &follower, scan, threads, |range, piece: MotionExtremes| {
            extremes.add(piece);
            range.into_iter().try_for_each(|k| go_on(progress(Phase::Motion, k + 1, count)))
        })?;

        let rest_speed = (REST * extremes.fastest).max(STANDSTILL);
        let rest_of = |fastest: &f64| (REST * fastest).max(STANDSTILL);
        let rest_rates: Vec<f64> = extremes.actuators.iter().map(rest_of).collect();
        *follower.solver.settings_mut() =
            Settings { friction: self.friction, rest_speed, ..Settings::default() };
        let start = &follower.solver;
        let spins = start.constraints().spins();
        let actuators = start.mechanism().actuators().count();
        // Mobility for which the mechanism is designed: at most the number of actuated degrees of
        // freedom and local rotations.
        let meant = extremes.mobility.min(actuators + spins.len());
        let verdict = Verdict {
            samples: count,
            assembly_notes: start.assembly_report().notes(),
            mobility: extremes.mobility,
            idle_spins: idle_spins(start),
            idle_axes: spins.iter().map(|spin| (spin.body.0, spin.axis)).collect(),
            redundancy: 0,
            weighting: start.weighting(),
            rest_speed,
            coupling: Some(0.0),
            passed_singularities: Vec::new(),
            other_solutions: None,
            friction_margin: None,
            singular: None,
        };
        let dofs = dofs_of(&self.model.mechanism);
        let uniqueness = Uniqueness::new(start, meant);
        let track = &extremes.track;
        let solving = Solving { job: self, uniqueness, dofs, track, spare: Spare::default() };
        let calculator = solving.uniqueness.proximity.clone();
        let rest_rate = |actuator: usize| rest_rates.get(actuator).copied().unwrap_or_default();
        let motors = Motors::new(&self.model.mechanism, self.friction, rest_rate);
        let mut gathered = Gathered::new(self, calculator, verdict, motors);
        let spare = &solving.spare;
        let solving = (&solving, track);
        chunks::carry_out(self, &follower, solving, threads, |range, piece: ChunkResults| {
            let mut samples = gathered.complete((start.mechanism(), start.parameters()), piece);
            for result in &mut samples {
                gathered.take(start.mechanism(), result, &mut receive)?;
            }
            spare.put(samples);
            range.into_iter().try_for_each(|k| go_on(progress(Phase::Forces, k + 1, count)))
        })?;
        gathered.finish()
    }
}

fn go_on(answer: bool) -> Result<(), Error> {
    if answer { Ok(()) } else { Err(Error::Interrupted) }
}
