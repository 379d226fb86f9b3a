//! Computation on a separate thread that returns its results one by one.

use crate::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};
use stiction_run::SinkError;

/// Maximum number of samples that wait for the receiver; the computation pauses when this number is
/// reached.
const WAITING: usize = 64;

/// Iterator over the samples of a computation on another thread, which runs ahead by at most
/// [`WAITING`] samples.
///
/// After the iterator has returned the last sample, [`Self::result`] returns the result of the
/// whole computation. Dropping the stream stops the computation.
pub(crate) struct Stream<T, R> {
    /// Receiving end of the channel; `None` after all samples were received or the computation was
    /// asked to stop.
    receiver: Option<Receiver<T>>,
    worker: Option<JoinHandle<Result<R, Error>>>,
    stopped: Arc<AtomicBool>,
    result: Option<R>,
}

/// Sending side of a [`Stream`], used by the computation.
pub(crate) struct Sender<T> {
    sender: SyncSender<T>,
    stopped: Arc<AtomicBool>,
}

impl<T> Sender<T> {
    /// Sends a sample; fails if the caller has dropped the stream.
    pub(crate) fn send(&self, sample: T) -> Result<(), SinkError> {
        self.sender.send(sample).map_err(|_| "the receiver of the samples was dropped".into())
    }

    /// True if the caller has dropped the stream.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}

impl<T: Send + 'static, R: Send + 'static> Stream<T, R> {
    /// Starts a computation on a separate thread.
    pub(crate) fn start(
        compute: impl FnOnce(&Sender<T>) -> Result<R, Error> + Send + 'static,
    ) -> Result<Self, Error> {
        let (sender, receiver) = sync_channel(WAITING);
        let stopped = Arc::new(AtomicBool::new(false));
        let sender = Sender { sender, stopped: Arc::clone(&stopped) };
        let worker = Builder::new()
            .name("stiction".to_owned())
            .spawn(move || compute(&sender))
            .map_err(|error| {
                Error::no_answer(format!(
                    "the system cannot start a thread for the computation: {error}"
                ))
                .with_help("raise the limit on threads, or use `each` in place of `samples`")
            })?;
        Ok(Self { receiver: Some(receiver), worker: Some(worker), stopped, result: None })
    }
}

impl<T, R> Stream<T, R> {
    /// Result of the whole computation; `None` until the iterator has returned all samples, and if
    /// the computation failed.
    pub(crate) fn result(&self) -> Option<&R> {
        self.result.as_ref()
    }

    fn join(&mut self) -> Option<Result<R, Error>> {
        match self.worker.take()?.join() {
            Ok(result) => Some(result),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }
}

impl<T, R> Iterator for Stream<T, R> {
    type Item = Result<T, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(receiver) = &self.receiver {
            if let Ok(sample) = receiver.recv() {
                return Some(Ok(sample));
            }
            self.receiver = None;
        }
        match self.join()? {
            Ok(result) => {
                self.result = Some(result);
                None
            }
            Err(error) => Some(Err(error)),
        }
    }
}

impl<T, R> Drop for Stream<T, R> {
    fn drop(&mut self) {
        self.stopped.store(true, Ordering::Relaxed);
        self.receiver = None;
        // Joins the thread, so that no computation outlives its stream; its outcome is no longer
        // needed.
        if let Some(worker) = self.worker.take() {
            let _ = worker.join();
        }
    }
}
