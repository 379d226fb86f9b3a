//! Filter for the signals of a log.

use stiction_format::LowPass;

/// Filter for the signals of a log. Tables of steady motions are not filtered.
#[derive(Clone, Debug)]
pub(super) enum RowFilter {
    /// Low-pass filters without phase shift: one for each gap-free piece of the log, with start and
    /// end of the piece, s.
    LowPass(Vec<(LowPass, (f64, f64))>),
    /// No filter.
    Unfiltered,
}

impl RowFilter {
    /// Filters signals that are sampled at `times`, s, and returns their values at the times `at`,
    /// s. `row(k, out)` writes the values of all signals at `times[k]` to `out`. Without a filter,
    /// the times `at` must be among `times`. Both lists of times must increase.
    pub(super) fn apply(
        &self,
        times: &[f64],
        signals: usize,
        mut row: impl FnMut(usize, &mut [f64]),
        at: &[f64],
    ) -> Vec<Vec<f64>> {
        match self {
            Self::LowPass(pieces) => {
                let mut all = Vec::with_capacity(at.len());
                for (filter, ends) in pieces {
                    let [samples, wanted] = [times, at].map(|times| within(times, *ends));
                    let first = samples.start;
                    let read = |k: usize, out: &mut [f64]| row(first + k, out);
                    all.extend(filter.apply(&times[samples], signals, read, &at[wanted]));
                }
                all
            }
            Self::Unfiltered => {
                let one = |time: &f64| {
                    let mut values = vec![0.0; signals];
                    row(times.partition_point(|t| t < time), &mut values);
                    values
                };
                at.iter().map(one).collect()
            }
        }
    }
}

/// Returns the range of the indices of the times from `start` to `end`, both inclusive.
pub(super) fn within(times: &[f64], (start, end): (f64, f64)) -> std::ops::Range<usize> {
    times.partition_point(|t| *t < start)..times.partition_point(|t| *t <= end)
}
