//! Prediction of normal loads within a step, from which the solution for the normal loads starts.

/// Largest extrapolation, as a multiple of the time between the last two solutions.
const FAR: f64 = 4.0;

/// Normal loads of the last two solutions at different times of a step, N.
#[derive(Clone, Debug, Default)]
pub(super) struct LoadPrediction {
    /// Times of the solutions, s, the last one first.
    times: [f64; 2],
    /// Loads of the solutions, the last one first; empty if there is no such solution.
    loads: [Vec<f64>; 2],
    predicted: Vec<f64>,
}

impl LoadPrediction {
    /// Forgets all loads.
    pub(super) fn clear(&mut self) {
        self.loads.iter_mut().for_each(Vec::clear);
    }

    /// Returns true if no loads are known.
    pub(super) fn is_empty(&self) -> bool {
        self.loads[0].is_empty()
    }

    /// Starts a step at `time`, s, with the loads at its start.
    pub(super) fn start(&mut self, time: f64, loads: impl Iterator<Item = f64>) {
        self.clear();
        self.times[0] = time;
        self.loads[0].extend(loads);
    }

    /// Adds the loads of a solution at `time`, s.
    pub(super) fn add(&mut self, time: f64, loads: &[f64]) {
        if time != self.times[0] {
            self.times.swap(0, 1);
            self.loads.swap(0, 1);
        }
        self.times[0] = time;
        self.loads[0].clear();
        self.loads[0].extend_from_slice(loads);
    }

    /// Predicts the loads at `time`, s, by linear extrapolation.
    pub(super) fn at(&mut self, time: f64) -> &[f64] {
        let Self { times: [last, before], loads: [now, earlier], predicted } = self;
        predicted.clone_from(now);
        let part = (time - *last) / (*last - *before);
        if earlier.len() == now.len() && part.abs() <= FAR {
            for (load, earlier) in predicted.iter_mut().zip(earlier) {
                *load = (*load + part * (*load - *earlier)).max(0.0);
            }
        }
        predicted
    }
}
