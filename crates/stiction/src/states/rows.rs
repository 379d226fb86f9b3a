//! Computation of the rows of a batch on several threads, in groups of a fixed number of rows.

use super::States;
use crate::error::Error;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;
use stiction_core::dynamics::{Data, Status};

/// Number of rows in a [`Piece`] of a batch. Each piece starts from the home position, so results
/// do not depend on the number of threads.
const PIECE: usize = 256;
/// Time between two calls of [`Workers::is_stopped`] while threads compute.
const PATIENCE: Duration = Duration::from_millis(50);
/// Maximum number of steps in which the mechanism moves from one row to the next.
const MOST_STEPS: f64 = 1e4;

/// Threads that compute a batch, and a function that can stop them.
pub struct Workers<'a> {
    /// Number of threads.
    pub threads: NonZeroUsize,
    /// Called repeatedly on the calling thread; the computation stops when it returns `true`.
    pub is_stopped: &'a dyn Fn() -> bool,
}

impl Default for Workers<'_> {
    /// One thread that is never stopped.
    fn default() -> Self {
        Self { threads: NonZeroUsize::MIN, is_stopped: &|| false }
    }
}

/// Group of consecutive rows that one thread computes, with the memory for their results.
struct Piece<'a> {
    first: usize,
    status: &'a mut [Status],
    /// For each result array, the part that belongs to these rows.
    arrays: Vec<&'a mut [f64]>,
}

/// Access to the memory for the results of one row, in all result arrays.
pub(super) struct Row<'r, 'a> {
    /// Index of the row in the batch.
    pub(super) index: usize,
    place: usize,
    rows: usize,
    arrays: &'r mut [&'a mut [f64]],
}

impl Row<'_, '_> {
    /// Results of this row in the array with the index `array`.
    pub(super) fn of(&mut self, array: usize) -> &mut [f64] {
        let width = self.arrays[array].len() / self.rows;
        &mut self.arrays[array][self.place * width..][..width]
    }

    /// Results of this row in `N` consecutive arrays, the first of which has the index `first`.
    pub(super) fn several<const N: usize>(&mut self, first: usize) -> [&mut [f64]; N] {
        let (place, rows) = (self.place, self.rows);
        let mut arrays = self.arrays[first..][..N].iter_mut();
        std::array::from_fn(|_| {
            let array = arrays.next().map_or(&mut [][..], |array| &mut **array);
            let width = array.len() / rows;
            &mut array[place * width..][..width]
        })
    }
}

impl States {
    /// Computes all rows of coordinates `q`. For each row, moves the mechanism in `Data` close to
    /// the coordinates of the row and calls `compute`, which moves the mechanism to these
    /// coordinates and writes the results. `widths` is the number of values per row in each result
    /// array. Values are NaN in rows that did not converge.
    ///
    /// # Errors
    /// The computation was stopped.
    pub(super) fn each_row(
        &self,
        q: &[f64],
        widths: &[usize],
        workers: &Workers<'_>,
        compute: impl Fn(&mut Data<f64>, &mut Row<'_, '_>) -> Status + Sync,
    ) -> Result<(Vec<Status>, Vec<Vec<f64>>), Error> {
        let rows = q.len() / self.home.len().max(1);
        let mut status = vec![Status::InputNotFinite; rows];
        let mut arrays: Vec<Vec<f64>> = widths.iter().map(|w| vec![f64::NAN; rows * w]).collect();
        {
            let mut left: Vec<&mut [f64]> = arrays.iter_mut().map(Vec::as_mut_slice).collect();
            let pieces = status.chunks_mut(PIECE).enumerate().map(|(k, status)| {
                let cut = left.iter_mut().zip(widths).map(|(left, width)| {
                    let (piece, rest) = std::mem::take(left).split_at_mut(status.len() * width);
                    *left = rest;
                    piece
                });
                let arrays = cut.collect();
                Piece { first: k * PIECE, status, arrays }
            });
            let run = |piece: Piece<'_>, data: &mut Data<f64>| {
                self.piece(q, piece, data, &compute);
            };
            carry_out(self, pieces, workers, &run)?;
        }
        Ok((status, arrays))
    }

    fn piece(
        &self,
        q: &[f64],
        mut piece: Piece<'_>,
        data: &mut Data<f64>,
        compute: &impl Fn(&mut Data<f64>, &mut Row<'_, '_>) -> Status,
    ) {
        self.go_home(data);
        let count = self.home.len();
        let mut last = self.home.clone();
        let (rows, mut arrays) = (piece.status.len(), std::mem::take(&mut piece.arrays));
        for (place, status) in piece.status.iter_mut().enumerate() {
            let index = piece.first + place;
            let position = &q[index * count..][..count];
            if !position.iter().all(|x| x.is_finite()) {
                continue;
            }
            let mut row = Row { index, place, rows, arrays: &mut arrays };
            *status = match self.walk(data, &last, position, 1.0) {
                Ok(()) => compute(data, &mut row),
                Err(status) => status,
            };
            if matches!(status, Status::LoopsOpen { .. } | Status::Singular) {
                // Repeats the row from the home position, in shorter steps.
                self.go_home(data);
                *status = match self.walk(data, &self.home, position, 8.0) {
                    Ok(()) => compute(data, &mut row),
                    Err(status) => status,
                };
            }
            if has_position(*status) {
                last.copy_from_slice(position);
            } else {
                // The data may be at any position between the two rows, so the next row starts from
                // the home position.
                self.go_home(data);
                last.copy_from_slice(&self.home);
            }
            if *status != Status::Converged {
                (0..row.arrays.len()).for_each(|array| row.of(array).fill(f64::NAN));
            }
        }
    }

    /// Moves the mechanism in `data` along the straight line in coordinate space from `from` toward
    /// `to`, and stops one step before `to`. `finer` is the factor by which the steps are shorter
    /// than the longest permitted steps of the coordinates.
    fn walk(
        &self,
        data: &mut Data<f64>,
        from: &[f64],
        to: &[f64],
        finer: f64,
    ) -> Result<(), Status> {
        let each = from.iter().zip(to).zip(&self.coordinates);
        let steps = each.map(|((a, b), c)| (b - a).abs() / c.step).fold(0.0, f64::max) * finer;
        if steps <= 1.0 {
            return Ok(());
        }
        if steps > MOST_STEPS {
            return Err(Status::LoopsOpen { error: f64::INFINITY });
        }
        let steps = steps.ceil();
        let rest = vec![0.0; from.len()];
        let mut between = from.to_vec();
        for k in 1..steps as usize {
            let part = k as f64 / steps;
            for ((x, a), b) in between.iter_mut().zip(from).zip(to) {
                *x = a + part * (b - a);
            }
            match self.model.move_to(data, &between, &rest, &rest) {
                status if has_position(status) => {}
                status => return Err(status),
            }
        }
        Ok(())
    }
}

/// True if the loops are closed after a computation with this status.
fn has_position(status: Status) -> bool {
    !matches!(status, Status::LoopsOpen { .. } | Status::InputNotFinite | Status::Singular)
}

/// Computes all pieces on at most `workers.threads` threads.
fn carry_out<'a>(
    states: &States,
    mut pieces: impl ExactSizeIterator<Item = Piece<'a>> + Send,
    workers: &Workers<'_>,
    run: &(impl Fn(Piece<'_>, &mut Data<f64>) + Sync),
) -> Result<(), Error> {
    let threads = workers.threads.get().min(pieces.len());
    let stopped = || Error::interrupted("interrupted; there are no results");
    if threads <= 1 {
        let mut data = states.borrow_data();
        let all = pieces.try_for_each(|piece| {
            if piece.first > 0 && (workers.is_stopped)() {
                return Err(stopped());
            }
            run(piece, &mut data);
            Ok(())
        });
        states.return_data(data);
        return all;
    }
    let (queue, halt) = (Mutex::new(pieces), AtomicBool::new(false));
    thread::scope(|scope| {
        let (end, ended) = channel::<()>();
        for _ in 0..threads {
            let (queue, halt, end) = (&queue, &halt, end.clone());
            let worker = move || {
                let _end = end;
                let mut data = states.borrow_data();
                while !halt.load(Ordering::Relaxed) {
                    let next = queue.lock().unwrap_or_else(PoisonError::into_inner).next();
                    let Some(piece) = next else { break };
                    run(piece, &mut data);
                }
                states.return_data(data);
            };
            let started =
                thread::Builder::new().name("stiction".to_owned()).spawn_scoped(scope, worker);
            if let Err(error) = started {
                halt.store(true, Ordering::Relaxed);
                return Err(Error::no_answer(format!("the system cannot start a thread: {error}"))
                    .with_help("ask for fewer threads")
                    .with_option("threads"));
            }
        }
        drop(end);
        loop {
            match ended.recv_timeout(PATIENCE) {
                Err(RecvTimeoutError::Timeout) if (workers.is_stopped)() => {
                    halt.store(true, Ordering::Relaxed);
                    return Err(stopped());
                }
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
                _ => {}
            }
        }
    })
}
