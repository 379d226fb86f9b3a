//! Steps across singular configurations.
//!
//! Near a singular configuration of the loops, at the singularity index `s`, a closure error `e`
//! due to round-off changes the coordinates by `e / s`, the rates by `e / s^2` and the
//! accelerations by `e / s^3`: the constraints do not distinguish the branches of motion that meet
//! there. On each branch the motion is smooth nevertheless. Therefore a single step crosses the
//! singular configuration, with its stages as far from this configuration as possible.

use super::Simulation;
use crate::forward::integrator::NODES_OF_OUTPUT;
use crate::statics::least_index;

/// Singularity index above which the search for a singular configuration ahead is skipped.
const NEAR: f64 = 0.5;
/// Largest singularity index of a minimum that counts as a singular configuration.
const NARROW: f64 = 0.02;
/// A minimum of the singularity index counts as a singular configuration only if the index on both
/// sides exceeds the minimum by this factor.
const RISES: f64 = 3.0;
/// Condition for a singular configuration in one half of the searched interval: over the other
/// half, the singularity index changes by at least this fraction of the index at the outer end of
/// the tested half. The reason is that the index near a singular configuration is proportional to
/// the time until or since this configuration.
const CHANGES: f64 = 0.3;
/// Number of subintervals of the searched interval; the singularity index is sampled at their ends.
const SAMPLES: usize = 24;
/// Length of the searched interval as a multiple of the intended step.
const AHEAD: f64 = 1.7;
/// Number of candidate lengths of a step.
const LENGTHS: usize = 100;
/// Shortest candidate length, as a fraction of the intended step.
const SHORTEST: f64 = 0.25;
/// Largest possible time between the singular configuration and the nearest stage, as a fraction of
/// the step.
const BEST: f64 = 0.13;
/// Fraction of the largest possible time between the singular configuration and the nearest stage,
/// over all candidate steps. The longest candidate step that reaches this fraction is selected.
const GIVEN_UP: f64 = 0.75;
/// Round-off of the relative closure error, including its amplification within a step.
const ROUNDING: f64 = 2e-14;
/// Smallest relative tolerance with which the error due to round-off is compared. A smaller
/// tolerance in the settings is replaced by this value.
const FINE: f64 = 1e-10;

impl Simulation<'_> {
    /// Returns the length of the next step, s, such that its stages avoid a singular configuration
    /// ahead. Returns the intended length `wish`, s, if no singular configuration is near.
    pub(super) fn length_across(&mut self, wish: f64) -> f64 {
        let far = 2.0 * wish * self.fastest_rate;
        let distance = self.now.distance;
        self.workspace.crosses = None;
        if self.model.topology.closures() == 0 || distance > NEAR.min(far.max(0.2)) {
            return wish;
        }
        let Some((crossing, slope)) = self.crossing_ahead(AHEAD * wish) else { return wish };
        let mut options = [(0.0, 0.0); LENGTHS];
        for (k, (length, value)) in options.iter_mut().enumerate() {
            let part = 1.0 - (1.0 - SHORTEST) * k as f64 / LENGTHS as f64;
            *length = part * wish;
            let rest = crossing - *length;
            let nearest = NODES_OF_OUTPUT.iter().map(|node| (crossing - node * *length).abs());
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            *value = match rest > 0.0 {
                // If the step ends before the singular configuration, the next step crosses it.
                true => (0.28 * rest).min(BEST * wish),
                false => nearest.min(BEST * wish),
            };
        }
        let best = options.iter().map(|(_, value)| *value).fold(0.0, f64::max);
        let chosen = options.iter().find(|(_, value)| *value >= GIVEN_UP * best);
        let Some(&(length, _)) = chosen else { return wish };
        if length > crossing {
            let passed = BEST * length * slope;
            self.workspace.crosses = Some(2.0 * ROUNDING / (passed * passed));
        }
        length
    }

    /// Finds the next singular configuration within `time`, s, by extrapolation with the present
    /// accelerations. Returns the time until the singular configuration, s, and the slope of the
    /// singularity index next to it, 1/s.
    fn crossing_ahead(&mut self, time: f64) -> Option<(f64, f64)> {
        let (model, state) = (self.model, &self.now.state);
        let ranks = &mut self.workspace.ranks;
        let mut at = |t: f64| {
            let mut ahead = state.clone();
            let rates = state.rates.iter().zip(&state.accelerations);
            let by: Vec<f64> = rates.map(|(v, a)| t * (v + 0.5 * t * a)).collect();
            ahead.advance(&model.topology, &by);
            ranks.at(model, &ahead)
        };
        let [(rank, first), (_, middle), (_, last)] = [0.0, 0.5, 1.0].map(|part| at(part * time));
        let passes_early = (last - middle).abs() >= CHANGES * first;
        let passes_late = (first - middle).abs() >= CHANGES * last;
        if !passes_early && !passes_late {
            return None;
        }
        let spacing = time / SAMPLES as f64;
        let values: Vec<f64> = (0..=SAMPLES).map(|k| at(k as f64 * spacing).1).collect();
        let is_least = |k: &usize| values[*k] <= values[k - 1] && values[*k] <= values[k + 1];
        (1..SAMPLES).filter(is_least).find_map(|k| {
            let known = [k - 1, k, k + 1].map(|k| (k as f64 * spacing, values[k]));
            // The index does not vary continuously where the rank is smaller.
            let found = least_index(known, (), |t| {
                let (here, index) = at(t);
                (here == rank).then_some((index, ()))
            });
            let (crossing, narrow) = (found.passage, found.index);
            let beside = [-2.0, 2.0].map(|k| at(crossing + k * spacing).1);
            let beside = beside[0].min(beside[1]);
            (narrow < NARROW && beside > RISES * narrow)
                .then_some((crossing, (beside - narrow) / (2.0 * spacing)))
        })
    }

    /// Returns true if the error due to round-off of the closure is below the tolerance at the
    /// singularity index `distance`.
    pub(super) fn is_resolved_at(&self, distance: f64) -> bool {
        ROUNDING / (distance * distance) < self.settings.relative.max(FINE)
    }

    /// Returns the relative tolerance of the last step: the tolerance of the settings, or a larger
    /// value, at most [`COARSEST`], if round-off near a singular configuration prevents this
    /// tolerance.
    pub(super) fn attainable_tolerance(&self) -> f64 {
        let nearest = self.workspace.nearest;
        let rounding = (ROUNDING / (nearest * nearest)).max(self.workspace.crosses.unwrap_or(0.0));
        self.settings.relative.max(rounding.min(COARSEST))
    }
}

/// Largest relative tolerance of a step through a singular configuration.
const COARSEST: f64 = 1e-6;
