//! Second order of time steps in which no interface changes its mode.
//!
//! Without a change of mode the end of a step is a smooth function of its length, and its error of
//! first order cancels in twice the result of two halves less that of the whole step (Richardson
//! extrapolation).

use super::Simulation;
use super::stepping::StepResult;
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::inputs::Inputs;
use crate::kinematics::State;

/// Extrapolated value from that of a whole step and that of two halves.
fn extrapolate(to: &mut [f64], whole: &[f64]) {
    to.iter_mut().zip(whole).for_each(|(to, whole)| *to = 2.0 * *to - whole);
}

/// Returns whether two modes are of one kind, with slip in about the same direction.
fn is_same(a: InterfaceMode, b: InterfaceMode) -> bool {
    match (a, b) {
        (InterfaceMode::Slides(a), InterfaceMode::Slides(b)) => {
            a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() > 0.0
        }
        _ => std::mem::discriminant(&a) == std::mem::discriminant(&b),
    }
}

impl Simulation<'_> {
    /// Extrapolates the end of a step to `time`, s, from the whole step and its halves; the end is
    /// that of the second half if an interface changes its mode or would reverse.
    pub(super) fn extrapolated(
        &self,
        time: f64,
        from: &State<f64>,
        (whole, first, second): (&StepResult, &StepResult, StepResult),
        inputs: &mut dyn Inputs,
    ) -> StepResult {
        let steps = [&whole.time_step, &first.time_step, &second.time_step];
        let same = |step: &&crate::forward::time_stepping::TimeStep| {
            self.modes.iter().zip(&step.modes).all(|(a, b)| is_same(*a, *b))
        };
        if !steps.iter().all(same) || second.frozen.iter().all(|frozen| *frozen) {
            return second;
        }
        let mut end = second.clone();
        let (to, from_whole) = (&mut end.time_step, &whole.time_step);
        for (interface, mode) in self.modes.iter().enumerate() {
            let (velocity, before) =
                (&mut to.velocities[interface], from_whole.velocities[interface]);
            let halves = *velocity;
            extrapolate(velocity, &before);
            let along: f64 = velocity.iter().zip(halves).map(|(a, b)| a * b).sum();
            if matches!(mode, InterfaceMode::Slides(_)) && along <= 0.0 {
                return second;
            }
        }
        for (bristles, whole) in to.bristles.iter_mut().zip(&from_whole.bristles) {
            extrapolate(bristles, whole);
        }
        extrapolate(&mut to.input_states, &from_whole.input_states);
        // The work of the first half is counted by itself.
        let (work, all, half) = (&mut to.work, &from_whole.work, &first.time_step.work);
        let rest = |to: &mut f64, all: &f64, half: &f64| *to = 2.0 * *to - all + half;
        let each = |to: &mut [f64], all: &[f64], half: &[f64]| {
            to.iter_mut().zip(all).zip(half).for_each(|((to, all), half)| rest(to, all, half));
        };
        each(&mut work.drives, &all.drives, &half.drives);
        each(&mut work.interfaces, &all.interfaces, &half.interfaces);
        rest(&mut work.loads, &all.loads, &half.loads);
        rest(&mut work.dampers, &all.dampers, &half.dampers);
        extrapolate(&mut end.state.coordinates, &whole.state.coordinates);
        extrapolate(&mut end.state.rates, &whole.state.rates);
        self.restore(from, &mut end.state, &end.frozen);
        let model = self.model;
        let targets = model.targets(time, inputs);
        let closed = model.project(time, &mut end.state, &targets, &end.anchors, &end.frozen);
        let finite = end.state.coordinates.iter().chain(&end.state.rates).all(|x| x.is_finite());
        if closed.is_ok() && finite { end } else { second }
    }
}
