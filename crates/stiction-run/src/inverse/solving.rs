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
use std::sync::{Mutex, PoisonError};
use stiction_core::dynamics::{
    AppliedLoad, Contributions, FrictionMode, InverseDynamics, InverseError, Mirror,
};
use stiction_core::kinematics::State;
use stiction_core::statics::Distances;
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
    /// Results whose buffers later chunks reuse, because allocating them anew costs more than
    /// filling them.
    pub(super) spare: Spare,
}

/// Results of samples that are no longer in use.
#[derive(Default)]
pub(super) struct Spare(Mutex<Vec<SampleResult>>);

impl Spare {
    /// Adds the results of a chunk whose samples have been received.
    pub(super) fn put(&self, samples: Vec<SampleResult>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend(samples);
    }

    /// Removes all results.
    fn take(&self) -> Vec<SampleResult> {
        core::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Results of the samples of a chunk.
pub(super) struct ChunkResults {
    pub(super) samples: Vec<SampleResult>,
    /// Results of earlier chunks, whose buffers this chunk reuses.
    spare: Vec<SampleResult>,
    /// Loads at the present sample.
    loads: Vec<AppliedLoad<f64>>,
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
            spare: self.spare.take(),
            loads: Vec::new(),
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
            self.job.loads_of(solver, (time, side), &mut piece.loads)?;
            if let Some(found) = piece.known(solver, time) {
                piece.samples.push(SampleResult { time, found: Ok(found) });
                continue;
            }
            // Tables contain the coupling at all samples, summaries only the greatest coupling.
            let known = if postpones { piece.coupling } else { 0.0 };
            solver.accept_coupling_up_to(known);
            match solver.solve(&piece.loads) {
                Err(error) => {
                    piece.has_failed = true;
                    piece.samples.push(SampleResult { time, found: Err(error) });
                }
                // After a failure, the remaining samples are not computed.
                Ok(_) if piece.has_failed => {}
                Ok(_) => {
                    piece.remember(solver);
                    let spare = piece.spare.pop().and_then(|spare| spare.found.ok());
                    let mut found = spare.unwrap_or_else(|| Solved::at(solver));
                    self.find(piece, solver, (sample, time), &mut found);
                    piece.samples.push(SampleResult { time, found: Ok(found) });
                }
            }
        }
        Ok(())
    }
}

impl ChunkResults {
    /// Returns a copy of the result of the last sample with the new time `time`, s, if the present
    /// loads and the state of `solver` are the same as at the last sample.
    fn known(&mut self, solver: &InverseDynamics, time: f64) -> Option<Box<Solved>> {
        let same = |last: &SolvedAt| last.loads == self.loads && last.state == *solver.state();
        let last = self.solved.as_mut().filter(|last| same(last))?;
        let mut found = self.samples.get(last.place)?.found.as_ref().ok()?.clone();
        found.sample.time = time;
        let place = self.samples.len();
        self.least.repeat(last.place, place);
        last.place = place;
        Some(found)
    }

    /// Stores the state and the loads of the sample whose result is added next.
    fn remember(&mut self, solver: &InverseDynamics) {
        let place = self.samples.len();
        match &mut self.solved {
            Some(last) => {
                last.state.clone_from(solver.state());
                last.loads.clone_from(&self.loads);
                last.place = place;
            }
            none => {
                let (state, loads) = (solver.state().clone(), self.loads.clone());
                *none = Some(SolvedAt { state, loads, place });
            }
        }
    }
}

impl Solved {
    /// Returns a result with buffers for the mechanism of `solver`, which [`Solving::find`] fills.
    fn at(solver: &InverseDynamics) -> Box<Self> {
        let unknown = Distances { actuation: f64::NAN, constraint: f64::NAN };
        let sample = Sample {
            time: 0.0,
            forces: solver.forces().clone(),
            bodies: solver.bodies().clone(),
            origin: solver.parameters().origin,
            joints: Vec::new(),
            loads: Vec::new(),
            closure: 0.0,
            distances: unknown,
            determined_reactions: Vec::new(),
            determined_gearings: Vec::new(),
            determined_loads: Vec::new(),
            determined_drives: Vec::new(),
            coupling: None,
            friction_margin: None,
            shares: Contributions::new(0, 0),
            backward: Vec::new(),
            motors: Vec::new(),
        };
        let certainty = SampleCertainty::default();
        let (redundancy, is_singular, singular, side) = (0, false, None, None);
        Box::new(Self { sample, redundancy, is_singular, singular, certainty, side })
    }
}

impl Solving<'_> {
    /// Collects the results of a sample from the solver in `found`; the sample is given by its
    /// index and its time, s.
    fn find(
        &self,
        piece: &mut ChunkResults,
        solver: &mut InverseDynamics,
        (sample, time): (usize, f64),
        found: &mut Solved,
    ) {
        let known = self.track.at(sample);
        found.side = known.map_or_else(|| solver.side(), |known| known.side);
        let loads = &piece.loads;
        let sample = &mut found.sample;
        sample.backward.clear();
        if self.job.friction != FrictionMode::Off && !solver.forces().interfaces.is_empty() {
            evaluate_back_driving(solver, &mut piece.mirror, loads, &mut sample.backward);
        }
        sample.shares.clone_from(solver.shares());
        let uniqueness = &mut piece.uniqueness;
        let postpones = self.job.indices == Indices::Least;
        if let Some(travel) = uniqueness.observe(solver, time, postpones) {
            piece.least.postpone(piece.samples.len(), travel);
        }
        found.certainty = SampleCertainty::of(solver, loads, self.job.friction_margin);
        let coupling = found.certainty.coupling;
        piece.coupling = piece.coupling.max(coupling.unwrap_or(0.0));
        sample.time = time;
        sample.forces.clone_from(solver.forces());
        sample.bodies.clone_from(solver.bodies());
        sample.joints.clear();
        sample.joints.extend(joint_motions(solver, &self.dofs));
        sample.loads.clone_from(loads);
        sample.closure = known.map_or_else(|| solver.closure_error(), |known| known.closure);
        sample.distances = uniqueness.distances;
        sample.determined_reactions.clone_from(&uniqueness.reactions);
        sample.determined_gearings.clone_from(&uniqueness.gearings);
        sample.determined_loads.clone_from(&uniqueness.loads);
        sample.determined_drives.clone_from(&uniqueness.drives);
        sample.coupling = coupling;
        sample.friction_margin = found.certainty.locks_at();
        sample.motors.clear();
        found.redundancy = uniqueness.redundancy;
        found.is_singular = uniqueness.is_singular;
        found.singular = uniqueness.singular.take();
    }
}
