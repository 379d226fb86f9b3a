//! The instants of a recording's samples.

use crate::signal::recorded::Recorded;
use std::sync::Arc;

/// The first of increasing instants after `t`; nothing after the last.
pub(crate) fn first_after(times: &[f64], t: f64) -> Option<f64> {
    times.get(times.partition_point(|&time| time <= t)).copied()
}

/// The instants of a recording's samples, s, strictly increasing.
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

    /// How many there are.
    pub fn count(&self) -> usize {
        match &self.0 {
            Kind::Listed(list) => list.len(),
            Kind::Recorded(recording) => recording.count(),
        }
    }

    /// Instant `k`, s; the last for any `k` beyond. If the recording cannot be read any more it is NaN, and
    /// [`Signal::fault_at`](crate::Course::fault_at) says why.
    pub fn at(&self, k: usize) -> f64 {
        match &self.0 {
            Kind::Listed(list) => list.get(k).or(list.last()).copied().unwrap_or(f64::NAN),
            Kind::Recorded(recording) => recording.instant(k),
        }
    }

    /// The first and the last, s; nothing if there is none.
    pub fn ends(&self) -> Option<(f64, f64)> {
        match &self.0 {
            Kind::Listed(list) => Some((*list.first()?, *list.last()?)),
            Kind::Recorded(recording) => recording.ends(),
        }
    }

    /// The first after `t`, s; nothing after the last.
    pub fn after(&self, t: f64) -> Option<f64> {
        match &self.0 {
            Kind::Listed(list) => first_after(list, t),
            Kind::Recorded(recording) => recording.after(t),
        }
    }

    /// All of them.
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
