//! Error of a time step: comparison of one whole step with two half steps, and extrapolation.
//!
//! Equation (D9) of the book's theory.

use super::Simulation;
use super::stepping::StepResult;
use crate::forward::affine_friction::{InterfaceMode, dot, norm};
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::time_stepping::TimeStep;
use crate::kinematics::{Bodies, State};
use crate::parameters::Parameters;

/// Tolerated value of [`Simulation::rates_apart`] in steps that are extrapolated. The error that
/// extrapolation leaves is much smaller.
pub(super) const SMOOTH: f64 = 10.0;
/// Largest value of [`Simulation::rates_apart`] in steps with steady accelerations that are
/// extrapolated. It exceeds [`SMOOTH`] because coordinates limit how far steps are shortened.
pub(super) const EXTRAPOLATED: f64 = 50.0;
/// Stops before this fraction of the time to the last stop of a step are at its start.
const AT_START: f64 = 0.02;

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

    /// Returns the difference of the rates between one whole step and two half steps, see
    /// [`Self::relative`]. In contrast to [`Self::apart`], it is not multiplied by the step: the
    /// error of a rate at a transition stays in the motion after it.
    pub(super) fn rates_apart(&self, whole: &StepResult, halves: &StepResult) -> f64 {
        let each = whole.state.rates.iter().zip(&halves.state.rates);
        self.relative(&each.map(|(a, b)| a - b).collect::<Vec<f64>>(), whole)
    }

    /// Returns the interfaces whose sliding stops or reverses in a step, each with the time from the
    /// start of the step to that instant, s.
    pub(super) fn stops(&self, whole: &StepResult, step: f64) -> Vec<(usize, f64)> {
        let each = self.modes.iter().zip(&whole.time_step.modes).enumerate();
        let stops = each.filter_map(|(k, modes)| {
            match modes {
                (InterfaceMode::Slides(a), InterfaceMode::Slides(b)) if dot(*a, *b) < 0.0 => {}
                (InterfaceMode::Slides(_), InterfaceMode::Sticks) => {}
                _ => return None,
            }
            let (before, after) = (self.now.interfaces[k].velocity, whole.time_step.velocities[k]);
            // The sliding slows down at the present rate, which is that of the last step. The change
            // of velocity in the whole step is due to the friction after the stop, which slows it
            // down less.
            let slows = -dot(before, self.model.surface_acceleration(&self.now.bodies, k));
            let speeds = [before, after].map(norm);
            let latest = step * speeds[0] / (speeds[0] + speeds[1]);
            let time = dot(before, before) / slows;
            Some((k, if slows > 0.0 { time.min(latest) } else { latest }))
        });
        stops.filter(|(_, time)| time.is_finite()).collect()
    }

    /// Returns the error of the rates in a step because of `stops`, see [`Self::relative`], and the time
    /// from the start of the step to the first stop that is not at the start, s. The step applies the
    /// friction after a stop from its start on, so the error is the change of the accelerations at the
    /// stop times the time to the last stop. A comparison with half steps does not show it if the stop
    /// lies in the first half. Returns `None` if nothing stops.
    pub(super) fn of_stops(
        &self,
        whole: &StepResult,
        stops: &[(usize, f64)],
    ) -> Option<(f64, f64)> {
        let times = stops.iter().map(|(_, time)| *time);
        let last = times.clone().reduce(f64::max)?;
        let first = times.filter(|time| *time >= AT_START * last).fold(last, f64::min);
        let [before, after] = [&self.now.state, &whole.state].map(|state| &state.accelerations);
        let change: Vec<f64> = before.iter().zip(after).map(|(a, b)| last * (b - a)).collect();
        Some((self.relative(&change, whole), first))
    }

    /// Returns the root of the kinetic energy that a difference of rates has, relative to that of the
    /// motion or, if this is larger, to the weight of all bodies times the characteristic length, in
    /// units of the tolerance. Rates of light bodies, such as the spin of rods, hardly count.
    fn relative(&self, difference: &[f64], at: &StepResult) -> f64 {
        let (topology, parameters) = (&self.model.topology, &self.model.parameters);
        let mut bodies = Bodies::new(topology);
        bodies.place(topology, parameters, &at.state.coordinates);
        let mut kinetic = |rates: &[f64]| {
            bodies.move_with(topology, rates);
            at.time_step.masses.kinetic(&bodies)
        };
        let weight = parameters.mass.iter().sum::<f64>() * parameters.gravity.norm();
        let motion = kinetic(&at.state.rates).max(self.now.account.kinetic);
        let largest = motion.max(weight * parameters.length);
        (kinetic(difference) / largest).sqrt() / self.settings.time_step_tolerance
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
        // Friction and dampers never supply energy.
        let [all, a, b] = [whole, first, &second].map(|result| &result.time_step.work);
        let dissipates = |all: f64, a: f64, b: f64| (2.0 * (a + b) - all) * (a + b) >= 0.0;
        let mut each = all.interfaces.iter().zip(&a.interfaces).zip(&b.interfaces);
        if !each.all(|((all, a), b)| dissipates(*all, *a, *b))
            || !dissipates(all.dampers, a.dampers, b.dampers)
        {
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
