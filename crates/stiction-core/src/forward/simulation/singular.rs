//! Passage through configurations at which the loop constraints lose rank.
//!
//! At a singular configuration two branches of motion meet, and the rates alone do not determine
//! which branch the motion follows. The simulation continues smoothly: coordinates and rates are
//! smooth functions of time on a branch, so a step across the configuration stays on the branch and
//! need not end there. An event records the passage, because the real mechanism, with its
//! clearances, may follow the other branch.

use super::scratch::Scratch;
use super::{Event, EventKind, Simulation};
use crate::forward::affine_friction::InterfaceMode;
use crate::forward::error::ForwardError;
use crate::forward::inputs::Inputs;
use crate::forward::instant::InterfaceSample;
use crate::spatial::Wrench;
use crate::statics::least_index;

/// Singularity index above which no passage through a singular configuration is possible in the
/// next step.
pub(super) const NEAR: f64 = 0.2;
/// A minimum of the singularity index counts as a singular configuration if the index is below this
/// value.
const PASSED: f64 = 1e-6;
/// Singularity index above which the passage through a singular configuration has ended.
const LEFT: f64 = 0.01;
/// Spacing of the configurations from which the results at a singular start are extrapolated, as
/// motion of the fastest degree of freedom, rad or characteristic lengths.
const BESIDE: f64 = 1e-3;
/// Fraction of a step over which the slope of the singularity index at either end of the step is
/// computed.
const LITTLE: f64 = 1e-3;
/// Longest time until the singularity index would vanish at its rates at both ends of a step, as a
/// multiple of the step. A passage within the step takes about one step.
const PASSES: f64 = 8.0;

impl Simulation<'_> {
    /// Determines accelerations and reactions if the motion starts at a configuration at which the
    /// loop constraints lose rank. The results are limits along the branch of motion to which the
    /// initial rates belong. The constraints at the configuration itself do not determine the
    /// results, since a constraint row can vanish there while its time derivative does not.
    pub(super) fn start_on_one_way(&mut self, inputs: &mut dyn Inputs) -> Result<(), ForwardError> {
        let (model, time) = (self.model, self.now.time);
        if model.topology.closures() == 0 || self.fastest_rate == 0.0 {
            return Ok(());
        }
        let state = self.now.state.clone();
        let ranks = &mut self.workspace.ranks;
        model.targets_into(time, inputs, &mut ranks.targets);
        let (rank, _) = ranks.at(model, &state);
        let little = BESIDE / self.fastest_rate;
        let (beside, _) = ranks.ahead(model, &state, little);
        if beside <= rank {
            return Ok(());
        }
        self.report_singular(time, beside - rank);
        let start = self.pack();
        let coordinates = state.coordinates.len();
        let mut found = self.now.clone();
        found.state.accelerations.fill(0.0);
        found.drives.fill(0.0);
        found.gearings.fill(0.0);
        found.wrenches.iter_mut().for_each(|w| *w = Wrench::zero());
        for interface in &mut found.interfaces {
            (interface.load, interface.friction, interface.limit) = (0.0, [0.0; 3], 0.0);
        }
        found.bristle_rates.fill([0.0; 3]);
        // Extrapolates the results to the start, with an error of fourth order in the spacing.
        for (k, weight) in [(1.0, 4.0), (2.0, -6.0), (3.0, 4.0), (4.0, -1.0)] {
            let mut there = state.clone();
            let by: Vec<f64> = state.rates.iter().map(|rate| k * little * rate).collect();
            there.advance(&model.topology, &by);
            let mut y = start.clone();
            y[..coordinates].copy_from_slice(&there.coordinates);
            let there = self.arrive(time + k * little, &y, inputs)?;
            let sum = |to: &mut [f64], from: &[f64]| {
                to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
            };
            sum(&mut found.state.accelerations, &there.state.accelerations);
            sum(&mut found.drives, &there.drives);
            sum(&mut found.gearings, &there.gearings);
            for (to, from) in found.wrenches.iter_mut().zip(&there.wrenches) {
                *to += *from * weight;
            }
            for (to, from) in found.interfaces.iter_mut().zip(&there.interfaces) {
                to.load += weight * from.load;
                to.limit += weight * from.limit;
                sum(&mut to.friction, &from.friction);
            }
            for (to, from) in found.bristle_rates.iter_mut().zip(&there.bristle_rates) {
                sum(to, from);
            }
        }
        let topology = &model.topology;
        found.bodies.accelerate(topology, &found.state.accelerations);
        for (index, power) in found.account.drives.iter_mut().enumerate() {
            let rate = found.bodies.actuator_rate(topology, topology.actuators[index]);
            *power = found.drives[index] * rate;
        }
        found.account.interfaces =
            found.interfaces.iter().map(InterfaceSample::dissipated).collect();
        self.now = found;
        self.restart_bound();
        Ok(())
    }

    /// Records the singular configuration that the last step has passed, if any. The step began at
    /// `time`, s, in the state [`Scratch::before`].
    pub(super) fn watch_rank(
        &mut self,
        time: f64,
        inputs: &mut dyn Inputs,
    ) -> Result<(), ForwardError> {
        let model = self.model;
        let step = self.now.time - time;
        if model.topology.closures() == 0 || step <= 0.0 {
            return Ok(());
        }
        let Scratch { ranks, before, .. } = &mut *self.workspace;
        model.targets_into(self.now.time, inputs, &mut ranks.targets);
        // In this order, the configuration at the start of the step is that of the last call.
        let (rank_before, distance_before) = ranks.at(model, before);
        // Without sticking interfaces, the dense equations of motion have the same constraints.
        if model.closures.is_none() && !self.modes.contains(&InterfaceMode::Sticks) {
            let rank = model.topology.dofs() - self.now.mobility;
            ranks.know(&self.now.state, rank, self.now.distance);
        }
        let (rank, distance) = ranks.at(model, &self.now.state);
        self.in_passage &= distance.min(distance_before) < LEFT || rank != rank_before;
        if rank != rank_before {
            // The step ended exactly at a singular configuration, or began at rest at a singular
            // configuration.
            let (at, lost) = if rank < rank_before {
                (self.now.time, rank_before - rank)
            } else {
                (time, rank - rank_before)
            };
            self.report_singular(at, lost);
            return Ok(());
        }
        if self.in_passage || distance.min(distance_before) > NEAR {
            return Ok(());
        }
        let little = LITTLE * step;
        let falls = distance_before - ranks.ahead(model, before, little).1;
        let rises = distance - ranks.ahead(model, &self.now.state, -little).1;
        // The index of a passage is proportional to the time until or since the passage.
        let until_zero = little * (distance_before / falls + distance / rises);
        let may_pass = falls > 0.0 && rises > 0.0 && until_zero <= PASSES * step;
        if !may_pass {
            return Ok(());
        }
        // Searches for the minimum of the singularity index along the dense output of the step.
        let mut ranks = ranks.clone();
        let mut last = self.list();
        self.derivative_into(&self.now, &mut last);
        let mut steps = std::mem::take(&mut self.steps);
        let prepared =
            steps.interpolate(time, &last, |t, y, rates| self.derivative(t, y, rates, inputs));
        self.steps = steps;
        prepared?;
        // The index does not vary continuously where the rank is smaller.
        let mut at = |part: f64| {
            self.steps.at(part, &mut last);
            let (state, _) = self.unpack(&last);
            let (here, index) = ranks.precisely_at(model, &state);
            (here == rank).then_some((index, ()))
        };
        let points = [0.0, LITTLE, 0.5, 1.0 - LITTLE, 1.0].map(|part| Some((part, at(part)?.0)));
        let [Some(begin), a, b, c, Some(end)] = points else { return Ok(()) };
        let least = [a, b, c].into_iter().flatten().min_by(|a, b| a.1.total_cmp(&b.1));
        let Some(middle) = least.filter(|(_, index)| *index < begin.1.min(end.1)) else {
            return Ok(());
        };
        let found = least_index([begin, middle, end], (), at);
        if found.index < PASSED {
            self.report_singular(time + found.passage * step, 1);
        }
        Ok(())
    }

    /// Records a singular configuration as an event, once for each passage.
    fn report_singular(&mut self, time: f64, lost: usize) {
        if std::mem::replace(&mut self.in_passage, true) {
            return;
        }
        self.events.push(Event { time, kind: EventKind::Singular { lost } });
    }
}
