//! Error of a time step: comparison of one whole step with two half steps, and extrapolation.

use super::Simulation;
use super::stepping::StepResult;
use crate::forward::affine_friction::{InterfaceMode, dot};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::time_stepping::TimeStep;
use crate::kinematics::State;
use crate::parameters::Parameters;

/// Tolerated value of [`Simulation::rates_apart`] in steps that are extrapolated. The error that
/// extrapolation leaves is much smaller.
pub(super) const SMOOTH: f64 = 100.0;

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

    /// Returns the largest difference of a rate between one whole step and two half steps, divided by
    /// the largest rate, in units of the tolerance. In contrast to [`Self::apart`], it is not
    /// multiplied by the step: the error of a rate at a transition stays in the motion after it.
    pub(super) fn rates_apart(&self, whole: &StepResult, halves: &StepResult) -> f64 {
        let rates = whole.state.rates.iter().zip(&self.model.columns).map(|(v, c)| (v / c).abs());
        let largest = rates.fold(self.fastest_rate.max(self.natural_rate()), f64::max);
        self.change(&whole.state, &halves.state) / (self.settings.time_step_tolerance * largest)
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

    /// Returns true if an interface has a law with bristles or a regularised law. Steps are longer than
    /// the times in which friction of such a law settles, so their error is not quadratic.
    pub(super) fn has_stiff_laws(&self) -> bool {
        let interfaces = &self.model.parameters.interfaces;
        let mut laws = interfaces.iter().flat_map(|interface| interface.laws());
        laws.any(|law| law.bristles.is_some() || law.regularisation.is_some())
    }

    /// Returns the end of two half steps without the leading term of their error, by Richardson's
    /// extrapolation with the whole step, and true. The term is quadratic in the length of the step
    /// only if the motion is smooth, without a reversal or stick-slip transition. Returns the half
    /// steps as they are, and false, if a friction would not oppose the extrapolated sliding, or if
    /// the extrapolated state cannot satisfy the constraints.
    pub(super) fn extrapolated(
        &mut self,
        time: f64,
        whole: &StepResult,
        first: &StepResult,
        mut second: StepResult,
        inputs: &mut dyn Inputs,
    ) -> (StepResult, bool) {
        let extrapolate = |halves: &mut [f64], whole: &[f64]| {
            halves.iter_mut().zip(whole).for_each(|(b, a)| *b += *b - a);
        };
        if second.frozen.iter().all(|f| *f) {
            extrapolate(&mut second.time_step.input_states, &whole.time_step.input_states);
            return (second, true);
        }
        let mut velocities = second.time_step.velocities.clone();
        extrapolate(velocities.as_flattened_mut(), whole.time_step.velocities.as_flattened());
        let TimeStep { modes, frictions, .. } = &second.time_step;
        let each = modes.iter().zip(frictions).zip(&velocities);
        let mut opposes = each.map(|((mode, friction), velocity)| {
            let direction =
                if let InterfaceMode::Slides(direction) = mode { direction } else { friction };
            dot(*direction, *velocity) >= 0.0 && dot(*friction, *velocity) >= 0.0
        });
        if !opposes.all(|opposes| opposes) {
            return (second, false);
        }
        let mut state = second.state.clone();
        extrapolate(&mut state.coordinates, &whole.state.coordinates);
        extrapolate(&mut state.rates, &whole.state.rates);
        let model = self.model;
        let targets = model.targets(time, inputs);
        let held = (&second.anchors[..], &second.frozen[..]);
        let workspace = &mut self.workspace.projection;
        let projected = model.project_in(time, &mut state, &targets, held, workspace);
        let mut all = state.coordinates.iter().chain(&state.rates);
        if projected.is_err() || !all.all(|x| x.is_finite()) {
            return (second, false);
        }
        second.state = state;
        second.time_step.velocities = velocities;
        extrapolate(&mut second.time_step.input_states, &whole.time_step.input_states);
        let (a, b, all) =
            (&first.time_step.work, &mut second.time_step.work, &whole.time_step.work);
        let sum = |b: &mut [f64], a: &[f64], all: &[f64]| {
            let each = b.iter_mut().zip(a).zip(all);
            each.for_each(|((b, a), all)| *b += *b + a - all);
        };
        sum(&mut b.drives, &a.drives, &all.drives);
        sum(&mut b.interfaces, &a.interfaces, &all.interfaces);
        b.loads += b.loads + a.loads - all.loads;
        b.dampers += b.dampers + a.dampers - all.dampers;
        (second, true)
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
