//! Filter of the rows of a log.

use stiction_format::LowPass;

/// Filter of the rows of a log; those of steady motions remain as they are.
#[derive(Clone, Copy, Debug)]
pub(super) enum RowFilter {
    /// Low-pass filter without phase shift.
    LowPass(LowPass),
    /// No filter.
    Unfiltered,
}

impl RowFilter {
    /// Filters signals that `row` writes for each of `times`, and returns their values at other times; without
    /// a filter these are some of `times`.
    pub(super) fn apply(
        &self,
        times: &[f64],
        signals: usize,
        mut row: impl FnMut(usize, &mut [f64]),
        at: &[f64],
    ) -> Vec<Vec<f64>> {
        match self {
            Self::LowPass(filter) => filter.apply(times, signals, row, at),
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
