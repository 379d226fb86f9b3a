//! Local extrapolation of time steps.
//!
//! A time step has an error of second order in its length. The results of a whole step and of two halves,
//! `2 halves - whole`, have one of third order, so that the errors of smooth motions do not add up to one of
//! first order.

use super::stepping::StepResult;
use super::{Energies, Simulation};
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::inputs::Inputs;

/// Extrapolates the results of a step of length `h` to steps of length zero.
fn limit(halves: &mut [f64], whole: &[f64]) {
    halves.iter_mut().zip(whole).for_each(|(half, whole)| *half += *half - whole);
}

impl Energies {
    /// Replaces the work in the second half of a step by the extrapolated work in the step less that in
    /// the first half: `(2 (first + second) - whole) - first`.
    fn extrapolate(&mut self, first: &Self, whole: &Self) {
        let extrapolated = |second: f64, first: f64, whole: f64| first + 2.0 * second - whole;
        let all = |second: &mut [f64], first: &[f64], whole: &[f64]| {
            let each = second.iter_mut().zip(first).zip(whole);
            each.for_each(|((second, first), whole)| {
                *second = extrapolated(*second, *first, *whole);
            });
        };
        all(&mut self.drives, &first.drives, &whole.drives);
        all(&mut self.interfaces, &first.interfaces, &whole.interfaces);
        self.loads = extrapolated(self.loads, first.loads, whole.loads);
        self.dampers = extrapolated(self.dampers, first.dampers, whole.dampers);
    }
}

impl Simulation<'_> {
    /// Returns the extrapolated end of a step to `time`, s, from its results as a whole and in two halves. Where
    /// an interface starts or stops to slip within the step, errors are not smooth in its length, and the
    /// result of the halves is returned, as for bristles.
    pub(super) fn extrapolated(
        &self,
        time: f64,
        (whole, first, second): (&StepResult, &StepResult, StepResult),
        inputs: &mut dyn Inputs,
    ) -> StepResult {
        let kinds = |modes: &[InterfaceMode]| -> Vec<_> {
            modes.iter().map(std::mem::discriminant).collect()
        };
        let before = kinds(&self.modes);
        let is_smooth = [whole, first, &second]
            .into_iter()
            .all(|result| kinds(&result.time_step.modes) == before);
        // Bristles are stiff: at the lengths of the steps, their errors do not yet decrease with a fixed order.
        let interfaces = &self.model.parameters.interfaces;
        let is_stiff = interfaces.iter().any(|interface| interface.law.bristles.is_some());
        if !is_smooth || is_stiff || second.frozen.iter().all(|frozen| *frozen) {
            return second;
        }
        let mut state = second.state.clone();
        limit(&mut state.coordinates, &whole.state.coordinates);
        limit(&mut state.rates, &whole.state.rates);
        let targets = self.model.targets(time, inputs);
        let projected =
            self.model.project(time, &mut state, &targets, &second.anchors, &second.frozen);
        if projected.is_err()
            || !state.coordinates.iter().chain(&state.rates).all(|x| x.is_finite())
        {
            return second;
        }
        let mut result = StepResult { state, ..second };
        let step = &mut result.time_step;
        limit(&mut step.input_states, &whole.time_step.input_states);
        step.work.extrapolate(&first.time_step.work, &whole.time_step.work);
        result
    }
}
