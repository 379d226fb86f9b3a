//! Computation of all forces at the samples of a chunk.

use super::certainty::SampleCertainty;
use super::chunks::Work;
use super::efficiency::evaluate_back_driving;
use super::joints::joint_motions;
use super::least_indices::LeastIndices;
use super::sample::Sample;
use super::track::Track;
use super::uniqueness::{Singular, Uniqueness};
use crate::dofs::Dof;
use crate::error::Error;
use crate::job::{Indices, Job};
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, InverseError, Mirror};
use stiction_core::kinematics::State;
use stiction_format::Side;

/// Evaluates the chunks of a motion; computes forces and their uniqueness at each sample.
pub(super) struct Solving<'a> {
    pub(super) job: &'a Job<'a>,
    /// Initial state of the uniqueness analysis. Each chunk starts with a copy of this state.
    pub(super) uniqueness: Uniqueness,
    /// Degrees of freedom whose motion [`Sample::joints`] contains.
    pub(super) dofs: Vec<Dof>,
    /// Configurations known from the scan of the motion.
    pub(super) track: &'a Track,
}

/// Results of the samples of a chunk.
pub(super) struct ChunkResults {
    pub(super) samples: Vec<SampleResult>,
    uniqueness: Uniqueness,
    pub(super) least: LeastIndices,
    mirror: Mirror,
    solved: Option<SolvedAt>,
    /// Greatest bound on the coupling of friction and reactions at the samples of the chunk so far.
    coupling: f64,
    has_failed: bool,
}

/// State and loads of the last sample at which forces were computed. If the next sample has the
/// same state and loads, its forces are the same too.
struct SolvedAt {
    state: State<f64>,
    loads: Vec<AppliedLoad<f64>>,
    /// Index of the sample with this state and these loads in the results of the chunk.
    place: usize,
}

/// Result of one sample.
pub(super) struct SampleResult {
    pub(super) time: f64,
    pub(super) found: Result<Box<Solved>, InverseError>,
}

/// All results of a sample whose forces have a solution.
#[derive(Clone)]
pub(super) struct Solved {
    pub(super) sample: Sample,
    pub(super) redundancy: usize,
    pub(super) is_singular: bool,
    pub(super) singular: Option<Singular>,
    pub(super) certainty: SampleCertainty,
    pub(super) side: Option<f64>,
}

impl Work for Solving<'_> {
    type Piece = ChunkResults;

    fn begin(&self) -> ChunkResults {
        ChunkResults {
            samples: Vec::new(),
            uniqueness: self.uniqueness.clone(),
            least: LeastIndices::default(),
            mirror: Mirror::default(),
            solved: None,
            coupling: 0.0,
            has_failed: false,
        }
    }

    fn evaluate(
        &self,
        piece: &mut ChunkResults,
        solver: &mut InverseDynamics,
        sample: usize,
        time: f64,
    ) -> Result<(), Error> {
        let postpones = self.job.indices == Indices::Least;
        // Forces jump when a part is picked up or placed. The results contain the forces before and
        // after the jump.
        let sides = [Side::Before, Side::After];
        let jumps = self.job.load.jumps_at(time);
        for side in sides.into_iter().skip(usize::from(!jumps)) {
            let mut loads = Vec::new();
            self.job.loads_of(solver, (time, side), &mut loads)?;
            if let Some(found) = piece.known(solver, &loads, time) {
                piece.samples.push(SampleResult { time, found: Ok(found) });
                continue;
            }
            // Tables contain the coupling at all samples, summaries only the greatest coupling.
            let known = if postpones { piece.coupling } else { 0.0 };
            solver.accept_coupling_up_to(known);
            match solver.solve(&loads) {
                Err(error) => {
                    piece.has_failed = true;
                    piece.samples.push(SampleResult { time, found: Err(error) });
                }
                // After a failure, the remaining samples are not computed.
                Ok(_) if piece.has_failed => {}
                Ok(_) => {
                    piece.remember(solver, &loads);
                    let found = self.find(piece, solver, loads, (sample, time));
                    piece.samples.push(SampleResult { time, found: Ok(Box::new(found)) });
                }
            }
        }
        Ok(())
    }
}

impl ChunkResults {
    /// Returns a copy of the result of the last sample with the new time `time`, s, if `loads` and
    /// the state of `solver` are the same as at the last sample.
    fn known(
        &mut self,
        solver: &InverseDynamics,
        loads: &[AppliedLoad<f64>],
        time: f64,
    ) -> Option<Box<Solved>> {
        let same = |last: &SolvedAt| last.loads == loads && last.state == *solver.state();
        let last = self.solved.as_mut().filter(|last| same(last))?;
        let mut found = self.samples.get(last.place)?.found.as_ref().ok()?.clone();
        found.sample.time = time;
        let place = self.samples.len();
        self.least.repeat(last.place, place);
        last.place = place;
        Some(found)
    }

    /// Stores the state and the loads of the sample whose result is added next.
    fn remember(&mut self, solver: &InverseDynamics, loads: &[AppliedLoad<f64>]) {
        let place = self.samples.len();
        match &mut self.solved {
            Some(last) => {
                last.state.clone_from(solver.state());
                last.loads.clear();
                last.loads.extend_from_slice(loads);
                last.place = place;
            }
            none => {
                let (state, loads) = (solver.state().clone(), loads.to_vec());
                *none = Some(SolvedAt { state, loads, place });
            }
        }
    }
}

impl Solving<'_> {
    /// Collects the results of a sample from the solver; the sample is given by its index and its
    /// time, s.
    fn find(
        &self,
        piece: &mut ChunkResults,
        solver: &mut InverseDynamics,
        loads: Vec<AppliedLoad<f64>>,
        (sample, time): (usize, f64),
    ) -> Solved {
        let known = self.track.at(sample);
        let side = known.map_or_else(|| solver.side(), |known| known.side);
        let mut backward = Vec::new();
        if self.job.friction != FrictionMode::Off && !solver.forces().interfaces.is_empty() {
            evaluate_back_driving(solver, &mut piece.mirror, &loads, &mut backward);
        }
        let shares = solver.shares().clone();
        let uniqueness = &mut piece.uniqueness;
        let postpones = self.job.indices == Indices::Least;
        if let Some(travel) = uniqueness.observe(solver, time, postpones) {
            piece.least.postpone(piece.samples.len(), travel);
        }
        let certainty = SampleCertainty::of(solver, &loads, self.job.friction_margin);
        piece.coupling = piece.coupling.max(certainty.coupling.unwrap_or(0.0));
        let sample = Sample {
            time,
            forces: solver.forces().clone(),
            bodies: solver.bodies().clone(),
            origin: solver.parameters().origin,
            joints: joint_motions(solver, &self.dofs),
            loads,
            closure: solver.closure_error(),
            distances: uniqueness.distances,
            determined_reactions: uniqueness.reactions.clone(),
            determined_gearings: uniqueness.gearings.clone(),
            determined_loads: uniqueness.loads.clone(),
            determined_drives: uniqueness.drives.clone(),
            coupling: certainty.coupling,
            friction_margin: certainty.locks_at(),
            shares,
            backward,
            motors: Vec::new(),
        };
        Solved {
            sample,
            redundancy: uniqueness.redundancy,
            is_singular: uniqueness.is_singular,
            singular: uniqueness.singular.take(),
            certainty,
            side,
        }
    }
}
