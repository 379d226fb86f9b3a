//! Measured efforts of a log, interpolated to any time by the filter, and the correction of their
//! delay relative to the positions.

use super::filter::RowFilter;
use super::{Prepared, gaps};
use nalgebra::DVector;

/// Largest delay that can be corrected, in periods of the cut-off frequency. It is less than one,
/// because the rows are at least one period away from the ends of a gap-free piece of the log.
const MOST: f64 = 0.75;
/// Step of central differences of filtered efforts, in periods of the cut-off frequency. The filter removes faster
/// changes.
const STEP: f64 = 0.02;

/// Measured efforts of a log before filtering, with the filter to apply to them.
pub(super) struct Efforts {
    pub(super) times: Vec<f64>,
    pub(super) raw: Vec<Vec<f64>>,
    pub(super) filter: RowFilter,
    pub(super) cutoff: f64,
    /// Corrected delay of each effort, s.
    pub(super) delays: Vec<f64>,
}

impl Efforts {
    /// Returns the filtered effort of an actuator at each of the times `times + delay`, s.
    fn at(&self, channel: usize, times: &[f64], delay: f64) -> Vec<f64> {
        let later: Vec<f64> = times.iter().map(|time| time + delay).collect();
        let values = &self.raw[channel];
        let rows = self.filter.apply(&self.times, 1, |k, out| out[0] = values[k], &later);
        rows.into_iter().map(|row| row[0]).collect()
    }

    /// Computes the time derivative of the filtered effort of an actuator at the times
    /// `times[step]`, s, of regression rows, for each `step` in `steps`. `None` if such a time lies
    /// outside the gap-free pieces of the log.
    pub(super) fn slope(
        &self,
        channel: usize,
        steps: &[usize],
        times: &[f64],
    ) -> Option<DVector<f64>> {
        let own: Vec<f64> = steps.iter().map(|&step| times[step]).collect();
        let (delay, step) = (self.delays[channel], STEP / self.cutoff);
        let [before, after] = [-step, step].map(|by| self.at(channel, &own, delay + by));
        (before.len() == own.len() && after.len() == own.len()).then(|| {
            DVector::from_fn(own.len(), |row, _| (after[row] - before[row]) / (2.0 * step))
        })
    }

    /// Multiplies the unfiltered effort of an actuator by a factor.
    pub(super) fn scale(&mut self, channel: usize, factor: f64) {
        self.raw[channel].iter_mut().for_each(|value| *value *= factor);
    }
}

impl Prepared {
    /// Returns the largest delay that can be corrected, s; zero for tables of steady motions.
    pub(in crate::identify) fn greatest_delay(&self) -> f64 {
        self.cutoff.map_or(0.0, |cutoff| MOST.min(gaps::PERIODS) / cutoff)
    }

    /// Corrects the measured efforts in the regression rows for the given delay of each effort, s.
    pub(in crate::identify) fn set_delays(&mut self, delays: &[f64]) {
        let Some(efforts) = &mut self.efforts else { return };
        for (channel, delay) in delays.iter().enumerate() {
            let delay = delay.clamp(-MOST / efforts.cutoff, MOST / efforts.cutoff);
            if delay == efforts.delays[channel] {
                continue;
            }
            let rows = &mut self.block.channels[channel];
            let own: Vec<f64> = rows.steps.iter().map(|&step| self.times[step]).collect();
            let values = efforts.at(channel, &own, delay);
            if values.len() != own.len() {
                continue;
            }
            efforts.delays[channel] = delay;
            let change = DVector::from_vec(values) - &rows.measured;
            rows.measured += &change;
            rows.right += &change;
            self.mu.shift(channel, &change);
        }
    }
}
