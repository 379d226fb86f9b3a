//! Error of a time step: comparison of one whole step with two half steps, and extrapolation.

use super::Simulation;
use super::stepping::StepResult;
use crate::forward::affine_friction::{InterfaceMode, dot};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::time_stepping::TimeStep;
use crate::kinematics::State;
use crate::parameters::Parameters;

/// Tolerated difference of the rates between one whole step and two half steps of a smooth motion,
/// as a multiple of the tolerance and of the largest rate. The error that extrapolation leaves is
/// much smaller.
const SMOOTH: f64 = 100.0;

impl Simulation<'_> {
    /// Computes one whole step, and two steps of half its length, from the same start.
    pub(super) fn two_halves(
        &mut self,
        time: f64,
        half: f64,
        from: &State<f64>,
        (modes, bristles): (&[InterfaceMode], &[[f64; 3]]),
        inputs: &mut dyn Inputs,
    ) -> Result<(StepResult, StepResult, StepResult), ForwardError> {
        let near: Vec<[f64; 3]> = self.now.interfaces.iter().map(|c| c.friction).collect();
        let mut input = self.input.clone();
        let whole =
            self.land(time, 2.0 * half, from, (modes, bristles, &near), (&input, &mut *inputs))?;
        let near = &whole.time_step.frictions;
        let first = self.land(time, half, from, (modes, bristles, near), (&input, &mut *inputs))?;
        let TimeStep { modes, bristles, frictions, input_states, .. } = &first.time_step;
        input.values.clone_from(input_states);
        let next = (&modes[..], &bristles[..], &frictions[..]);
        let second = self.land(time + half, half, &first.state, next, (&input, inputs))?;
        Ok((whole, first, second))
    }

    /// Returns the difference between one whole step and two half steps in units of the tolerance:
    /// the largest difference of coordinates, of rates times the step, and of internal states of
    /// the inputs.
    pub(super) fn apart(&self, whole: &StepResult, halves: &StepResult, step: f64) -> f64 {
        let (a, b) = (&whole.state, &halves.state);
        let tolerance = self.settings.time_step_tolerance;
        let columns = &self.model.columns;
        let count = a.coordinates.len();
        let moved = a.coordinates.iter().zip(&b.coordinates).zip(&self.scales[..count]);
        let moved = moved.map(|((a, b), s)| (a - b).abs() / s);
        let rates = a.rates.iter().zip(&b.rates).zip(columns);
        let rates = rates.map(|((a, b), c)| step * (a - b).abs() / c);
        let (a, b) = (&whole.time_step.input_states, &halves.time_step.input_states);
        let scales = &self.scales[self.scales.len() - a.len()..];
        let states = a.iter().zip(b).zip(scales);
        let states = states.map(|((a, b), s)| (a - b).abs() / s.max(a.abs()));
        moved.chain(rates).chain(states).fold(0.0, f64::max) / tolerance
    }

    /// Returns the largest difference of a rate between one whole step and two half steps in units
    /// of its tolerance. In contrast to [`Self::apart`], the tolerance does not grow as steps become
    /// shorter: the error of a rate at a stick-slip transition stays in the motion after it.
    pub(super) fn rates_apart(
        &self,
        whole: &StepResult,
        halves: &StepResult,
        transition: bool,
    ) -> f64 {
        let factor = if transition { 1.0 } else { SMOOTH };
        let largest = self.fastest_rate.max(self.natural_rate());
        let tolerance = factor * self.settings.time_step_tolerance * largest;
        self.change(&whole.state, &halves.state) / tolerance
    }

    /// Returns the natural rate `sqrt(gravity / length)`, rad/s.
    pub(super) fn natural_rate(&self) -> f64 {
        let Parameters { gravity, length, .. } = &self.model.parameters;
        (gravity.norm() / length).sqrt()
    }

    /// Returns the largest change of a rate between two states, rad/s or characteristic lengths per
    /// second.
    pub(super) fn change(&self, from: &State<f64>, to: &State<f64>) -> f64 {
        let rates = from.rates.iter().zip(&to.rates).zip(&self.model.columns);
        rates.map(|((a, b), c)| (a - b).abs() / c).fold(0.0, f64::max)
    }

    /// Returns the end of two half steps without the leading term of their error, by Richardson's
    /// extrapolation with the whole step. The term is quadratic in the length of the step only if
    /// the motion is smooth, without a stick-slip transition. Returns the half steps as they are if
    /// the extrapolation reverses the slip of an interface or cannot satisfy the constraints.
    pub(super) fn extrapolated(
        &self,
        time: f64,
        whole: &StepResult,
        first: &StepResult,
        second: StepResult,
        inputs: &mut dyn Inputs,
    ) -> StepResult {
        if second.frozen.iter().all(|f| *f) {
            return second;
        }
        let extrapolate = |halves: &mut [f64], whole: &[f64]| {
            halves.iter_mut().zip(whole).for_each(|(b, a)| *b += *b - a);
        };
        let mut state = second.state.clone();
        extrapolate(&mut state.coordinates, &whole.state.coordinates);
        extrapolate(&mut state.rates, &whole.state.rates);
        let targets = self.model.targets(time, inputs);
        let projected =
            self.model.project(time, &mut state, &targets, &second.anchors, &second.frozen);
        if projected.is_err()
            || !state.coordinates.iter().chain(&state.rates).all(|x| x.is_finite())
        {
            return second;
        }
        let mut velocities = second.time_step.velocities.clone();
        extrapolate(velocities.as_flattened_mut(), whole.time_step.velocities.as_flattened());
        let reverses = |(mode, velocity): (&InterfaceMode, &[f64; 3])| match mode {
            InterfaceMode::Slides(direction) => dot(*direction, *velocity) <= 0.0,
            _ => false,
        };
        if second.time_step.modes.iter().zip(&velocities).any(reverses) {
            return second;
        }
        let StepResult { mut time_step, anchors, frozen, .. } = second;
        time_step.velocities = velocities;
        extrapolate(&mut time_step.input_states, &whole.time_step.input_states);
        extrapolate(time_step.bristles.as_flattened_mut(), whole.time_step.bristles.as_flattened());
        let (a, b, all) = (&first.time_step.work, &mut time_step.work, &whole.time_step.work);
        let sum = |b: &mut [f64], a: &[f64], all: &[f64]| {
            let each = b.iter_mut().zip(a).zip(all);
            each.for_each(|((b, a), all)| *b += *b + a - all);
        };
        sum(&mut b.drives, &a.drives, &all.drives);
        sum(&mut b.interfaces, &a.interfaces, &all.interfaces);
        b.loads += b.loads + a.loads - all.loads;
        b.dampers += b.dampers + a.dampers - all.dampers;
        StepResult { time_step, state, anchors, frozen }
    }
}

/// Returns true if each interface sticks, slides or follows a smooth law both in `before` and in
/// `after`, and no sliding interface has reversed.
pub(super) fn same_slip(before: &[InterfaceMode], after: &[InterfaceMode]) -> bool {
    before.iter().zip(after).all(|(before, after)| match (before, after) {
        (InterfaceMode::Slides(a), InterfaceMode::Slides(b)) => dot(*a, *b) > 0.0,
        (before, after) => std::mem::discriminant(before) == std::mem::discriminant(after),
    })
}
