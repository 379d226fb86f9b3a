//! Filter of the rows of a log.

use stiction_format::LowPass;

/// Filter of the rows of a log; those of steady motions remain as they are.
#[derive(Clone, Debug)]
pub(super) enum RowFilter {
    /// Low-pass filters without phase shift, one for each piece without gaps, with its ends, s.
    LowPass(Vec<(LowPass, (f64, f64))>),
    /// No filter.
    Unfiltered,
}

impl RowFilter {
    /// Filters signals that `row` writes for each of `times`, and returns their values at other times; without
    /// a filter these are some of `times`. Both times increase.
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

/// Indices of the times from one end to the other, both included.
pub(super) fn within(times: &[f64], (start, end): (f64, f64)) -> std::ops::Range<usize> {
    times.partition_point(|t| *t < start)..times.partition_point(|t| *t <= end)
}
