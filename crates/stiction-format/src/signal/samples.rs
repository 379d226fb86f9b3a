//! Times of a recording's samples.

use crate::signal::recorded::Recorded;
use std::sync::Arc;

/// Returns the first time after `t` in the increasing list `times`; `None` if no time follows.
pub(crate) fn first_after(times: &[f64], t: f64) -> Option<f64> {
    times.get(times.partition_point(|&time| time <= t)).copied()
}

/// Times of a recording's samples, s, strictly increasing.
#[derive(Clone, Debug)]
pub struct SampleTimes(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Listed(Arc<[f64]>),
    Recorded(Arc<Recorded>),
}

impl SampleTimes {
    pub(crate) fn recorded(recording: &Arc<Recorded>) -> Self {
        Self(Kind::Recorded(Arc::clone(recording)))
    }

    /// Number of samples.
    pub fn count(&self) -> usize {
        match &self.0 {
            Kind::Listed(list) => list.len(),
            Kind::Recorded(recording) => recording.count(),
        }
    }

    /// Time of sample `k`, s; for an index beyond the last sample, the time of the last one. NaN if the recording can
    /// no longer be read; [`Signal::fault_at`](crate::Signal::fault_at) gives the reason.
    pub fn at(&self, k: usize) -> f64 {
        match &self.0 {
            Kind::Listed(list) => list.get(k).or(list.last()).copied().unwrap_or(f64::NAN),
            Kind::Recorded(recording) => recording.instant(k),
        }
    }

    /// Times of the first and last sample, s; `None` if there are no samples.
    pub fn ends(&self) -> Option<(f64, f64)> {
        match &self.0 {
            Kind::Listed(list) => Some((*list.first()?, *list.last()?)),
            Kind::Recorded(recording) => recording.ends(),
        }
    }

    /// Time of the first sample after `t`, s; `None` if no sample follows.
    pub fn after(&self, t: f64) -> Option<f64> {
        match &self.0 {
            Kind::Listed(list) => first_after(list, t),
            Kind::Recorded(recording) => recording.after(t),
        }
    }

    /// Iterator over all times, s.
    pub fn iter(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.count()).map(|k| self.at(k))
    }
}

impl From<Arc<[f64]>> for SampleTimes {
    fn from(list: Arc<[f64]>) -> Self {
        Self(Kind::Listed(list))
    }
}

impl PartialEq for SampleTimes {
    fn eq(&self, other: &Self) -> bool {
        self.count() == other.count() && self.iter().eq(other.iter())
    }
}
