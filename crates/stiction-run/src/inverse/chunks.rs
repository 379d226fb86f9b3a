//! Parallel evaluation of a motion in chunks: runs of successive samples.
//!
//! Each pose is computed from the previous pose, so each chunk needs a pose to start from. A
//! separate solver, the scout, computes these start poses with large steps along the motion. The
//! chunk size does not depend on the number of threads, and the results are combined in order. The
//! results are therefore bitwise independent of the number of threads. If the scout fails, or if
//! its pose differs from the pose at the end of the preceding chunk, the rest of the motion is
//! evaluated sample by sample.

use super::track::Track;
use crate::Instants;
use crate::error::{Error, check_finite};
use crate::follower::Follower;
use crate::job::Job;
use crate::ordered::in_order;
use std::ops::Range;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::spatial::Pose;

/// Smallest and largest number of samples in a chunk. Results of longer chunks exceed the caches of
/// processors; shorter ones compute more start poses.
const CHUNK: (usize, usize) = (16, 128);
/// Largest work in a chunk: the number of bodies and joints times the number of samples. This limit
/// bounds the memory of results that wait for earlier chunks.
const WEIGHT: usize = 8192;
/// Largest number of samples that the scout advances in one step. Longer steps save no time.
const STRIDE: usize = 16;
/// Tolerance for the equality of two poses, in m for positions and dimensionless for entries of
/// rotation matrices. It is multiplied by one plus the magnitude of the compared number. Newton's
/// method converges to 1e-14, and other assembly modes are far away.
const SAME: f64 = 1e-8;

/// Computation performed at each sample of a chunk.
pub(super) trait Work: Sync {
    /// Result of the computation for one chunk.
    type Piece: Send;
    /// Creates the empty result of a chunk.
    fn begin(&self) -> Self::Piece;
    /// Evaluates a sample at the solver's present pose and adds it to the result.
    fn evaluate(
        &self,
        piece: &mut Self::Piece,
        solver: &mut InverseDynamics,
        sample: usize,
        time: f64,
    ) -> Result<(), Error>;
}

/// Completed evaluation of a chunk.
struct Done<'a, P> {
    piece: P,
    /// Poses of all bodies at the start of the chunk.
    begin: Vec<Pose<f64>>,
    /// Mechanism in the pose of the first sample of the next chunk; `None` at the end of the motion
    /// or after an error.
    end: Option<Follower<'a>>,
    /// Error that stopped the evaluation of the chunk.
    error: Option<Error>,
}

/// Evaluates all chunks on `threads` threads and passes their results to `receive` in order.
/// Configurations stored in `track` are not computed again.
pub(super) fn carry_out<W: Work>(
    job: &Job<'_>,
    start: &Follower<'_>,
    (work, track): (&W, &Track),
    threads: usize,
    mut receive: impl FnMut(Range<usize>, W::Piece) -> Result<(), Error>,
) -> Result<(), Error> {
    let instants = job.instants()?;
    let mechanism = start.solver.mechanism();
    let size = mechanism.bodies().len() + mechanism.joints().len();
    let chunk = (WEIGHT / size.max(1)).clamp(CHUNK.0, CHUNK.1);
    let walk = Walk { job, instants: &instants, work, track, chunk };
    // More threads than chunks would be idle.
    let threads = threads.min(instants.count().div_ceil(chunk));
    let mut collector = Collector { walk, last: None, receive: &mut receive };
    let mut seeds = Seeds::new((&instants, track), start, chunk);
    in_order(
        threads,
        || seeds.next(),
        |(chunk, seed)| (chunk, walk.carry(chunk, seed)),
        |(chunk, done)| collector.take(chunk, done),
    )?;
    collector.finish()
}

/// Inputs for the evaluation of chunks.
struct Walk<'a, W> {
    job: &'a Job<'a>,
    instants: &'a Instants,
    work: &'a W,
    track: &'a Track,
    /// Number of samples in a chunk.
    chunk: usize,
}

impl<W> Clone for Walk<'_, W> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<W> Copy for Walk<'_, W> {}

impl<'a, W: Work> Walk<'a, W> {
    fn range(&self, chunk: usize) -> Range<usize> {
        let count = self.instants.count();
        (chunk * self.chunk).min(count)..((chunk + 1) * self.chunk).min(count)
    }

    /// Evaluates a chunk; `follower` must be in the pose of the first sample of the chunk.
    fn carry(&self, chunk: usize, mut follower: Follower<'a>) -> Done<'a, W::Piece> {
        let range = self.range(chunk);
        let begin = follower.solver.bodies().pose.clone();
        let mut piece = self.work.begin();
        let walked = self.walk(range, &mut follower, &mut piece);
        let (end, error) = match walked {
            Ok(true) => (Some(follower), None),
            Ok(false) => (None, None),
            Err(error) => (None, Some(error)),
        };
        Done { piece, begin, end, error }
    }

    /// Evaluates all samples of a range, then moves `follower` to the first sample after the range.
    /// `follower` must be at the first sample of the range. Returns false if no sample follows the
    /// range.
    fn walk(
        &self,
        range: Range<usize>,
        follower: &mut Follower<'a>,
        piece: &mut W::Piece,
    ) -> Result<bool, Error> {
        let count = self.instants.count();
        check_finite(self.job.motion.signals(), self.instants.at(range.start))?;
        for sample in range {
            let time = self.instants.at(sample);
            self.work.evaluate(piece, &mut follower.solver, sample, time)?;
            if sample + 1 == count {
                return Ok(false);
            }
            let next = self.instants.at(sample + 1);
            let known = self.track.at(sample + 1);
            if !known.is_some_and(|known| follower.return_to(next, known.state, known.targets)) {
                follower.go_to(next)?;
            }
        }
        Ok(true)
    }
}

/// Combines the results of all chunks in chronological order.
struct Collector<'a, 'b, W: Work, R> {
    walk: Walk<'a, W>,
    /// Index of the first sample after the last combined chunk, and the mechanism in the pose of
    /// this sample.
    last: Option<(usize, Follower<'a>)>,
    receive: &'b mut R,
}

impl<'a, W: Work, R> Collector<'a, '_, W, R>
where
    R: FnMut(Range<usize>, W::Piece) -> Result<(), Error>,
{
    /// Adds the result of the next chunk. Returns false if the chunk does not start in the pose at
    /// the end of the previous chunk.
    fn take(&mut self, chunk: usize, done: Done<'a, W::Piece>) -> Result<bool, Error> {
        if let Some((_, arrived)) = &self.last
            && !is_same(&arrived.solver.bodies().pose, &done.begin)
        {
            return Ok(false);
        }
        let range = self.walk.range(chunk);
        (self.receive)(range.clone(), done.piece)?;
        if let Some(error) = done.error {
            return Err(error);
        }
        self.last = done.end.map(|end| (range.end, end));
        Ok(true)
    }

    /// Evaluates the remaining samples one by one on this thread.
    fn finish(mut self) -> Result<(), Error> {
        while let Some((first, mut follower)) = self.last.take() {
            let range = first..(first + self.walk.chunk).min(self.walk.instants.count());
            let mut piece = self.walk.work.begin();
            let walked = self.walk.walk(range.clone(), &mut follower, &mut piece);
            (self.receive)(range.clone(), piece)?;
            if walked? {
                self.last = Some((range.end, follower));
            }
        }
        Ok(())
    }
}

fn is_same(a: &[Pose<f64>], b: &[Pose<f64>]) -> bool {
    let entries = |pose: &Pose<f64>| {
        let turn = pose.rotation.columns.map(|column| column.to_array());
        turn.into_iter().flatten().chain(pose.position.to_array()).collect::<Vec<_>>()
    };
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME * (1.0 + a.abs());
    a.iter().zip(b).all(|(a, b)| entries(a).iter().zip(&entries(b)).all(near))
}

/// Computes the start poses of chunks in large steps, unless they are known from an earlier pass.
struct Seeds<'a> {
    instants: &'a Instants,
    /// Configurations that an earlier pass along the motion has stored.
    track: &'a Track,
    /// Mechanism that moves ahead in large steps to the first samples of chunks; `None` after a
    /// failure.
    scout: Option<Follower<'a>>,
    at: usize,
    /// Index of the next chunk.
    next: usize,
    /// Number of samples in each chunk.
    chunk: usize,
    stride: usize,
}

impl<'a> Seeds<'a> {
    fn new(
        (instants, track): (&'a Instants, &'a Track),
        start: &Follower<'a>,
        chunk: usize,
    ) -> Self {
        let scout = Some(start.clone());
        Self { instants, track, scout, at: 0, next: 0, chunk, stride: STRIDE }
    }

    /// Returns the index of the next chunk, and the mechanism in the pose of its first sample.
    /// `None` after the last chunk, or if the scout has failed.
    fn next(&mut self) -> Option<(usize, Follower<'a>)> {
        let first = self.next * self.chunk;
        if first >= self.instants.count() {
            return None;
        }
        let mut scout = self.scout.take()?;
        if first > 0
            && let Some(known) = self.track.at(first)
            && scout.return_to(self.instants.at(first), known.state, known.targets)
        {
            self.at = first;
        }
        while self.at < first {
            self.advance(&mut scout, first)?;
        }
        let next = self.next;
        self.next += 1;
        self.scout = Some(scout.clone());
        Some((next, scout))
    }

    /// Advances the scout by one step along the motion, at most to the sample with index `first`.
    /// If the step is too long, the scout stays where it is, and the step is halved for the next
    /// call. Returns `None` if the scout cannot follow the motion even to the next sample.
    fn advance(&mut self, scout: &mut Follower<'a>, first: usize) -> Option<()> {
        let samples = self.stride.min(first - self.at);
        let to = self.instants.at(self.at + samples);
        if samples == 1 {
            scout.go_to(to).ok()?;
        } else if !scout.step_to(to) {
            self.stride = samples / 2;
            return Some(());
        }
        self.at += samples;
        self.stride = (2 * self.stride).min(STRIDE);
        Some(())
    }
}
