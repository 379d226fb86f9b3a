//! Scheduling of the steps of straight-line code. Steps are first ordered result by result, so that
//! few values are live at a time. Then, among nearby independent steps, those with the longest
//! critical path are moved to the front, to hide latencies.

use crate::code::{Code, Source, Step};

/// Number of steps among which the scheduler chooses. A larger window keeps too many values in
/// registers, and processors reorder instructions themselves.
const WINDOW: usize = 16;
/// Number of steps that a processor can begin in one cycle.
const WIDTH: u32 = 2;

/// Typical latency of a step in cycles. The values do not depend on the present processor.
fn latency(step: &Step) -> u32 {
    match step {
        Step::Neg(_) => 1,
        Step::Add(..) | Step::Sub(..) | Step::Mul(..) => 4,
        Step::Fused(..) => 4,
        Step::Select { .. } => 5,
        Step::Div(..) => 14,
        Step::Sqrt(_) => 20,
    }
}

impl Code {
    /// Reorders the steps for fast execution: with few live values and little waiting for
    /// latencies.
    pub(crate) fn scheduled(&self) -> Self {
        self.depth_first().spread()
    }

    /// Orders the steps result by result, depth first: the operand that needs the most registers
    /// comes first. Omits steps that no result needs.
    fn depth_first(&self) -> Self {
        let count = self.steps.len();
        let before = |k: usize| {
            let mut steps: Vec<usize> = self.steps[k]
                .operands()
                .filter_map(|source| match source {
                    Source::Step(other) => Some(other as usize),
                    _ => None,
                })
                .collect();
            steps.sort_unstable();
            steps.dedup();
            steps
        };
        // For each step, the number of registers that its computation from memory needs (Sethi and
        // Ullman 1970).
        let mut need = vec![1; count];
        for k in 0..count {
            let mut own: Vec<usize> = before(k).iter().map(|other| need[*other]).collect();
            own.sort_unstable_by(|a, b| b.cmp(a));
            need[k] = own.iter().enumerate().map(|(i, n)| n + i).max().unwrap_or(1);
        }
        let mut done = vec![false; count];
        let mut order = Vec::with_capacity(count);
        let mut roots: Vec<usize> = self
            .stores
            .iter()
            .filter_map(|(source, _)| match source {
                Source::Step(step) => Some(*step as usize),
                _ => None,
            })
            .collect();
        roots.sort_unstable();
        let mut stack = Vec::new();
        for root in roots {
            stack.push((root, false));
            while let Some((k, operands_are_done)) = stack.pop() {
                if done[k] {
                    continue;
                }
                if operands_are_done {
                    done[k] = true;
                    order.push(k);
                    continue;
                }
                stack.push((k, true));
                let mut operands = before(k);
                operands.sort_by_key(|other| need[*other]);
                stack.extend(operands.into_iter().map(|other| (other, false)));
            }
        }
        self.in_order(&order)
    }

    /// Reorders the steps; `order` lists the old index of each new step.
    fn in_order(&self, order: &[usize]) -> Self {
        let mut place = vec![0; self.steps.len()];
        for (at, step) in order.iter().enumerate() {
            place[*step] = at as u32;
        }
        let moved = |source: Source| match source {
            Source::Step(step) => Source::Step(place[step as usize]),
            other => other,
        };
        Self {
            steps: order.iter().map(|k| self.steps[*k].map(moved)).collect(),
            constants: self.constants.clone(),
            stores: self.stores.iter().map(|(source, slot)| (moved(*source), *slot)).collect(),
        }
    }

    /// Reorders steps within a window of [`WINDOW`] steps: a step whose operands are available
    /// early comes first, and among several such steps the one with the longest critical path.
    fn spread(&self) -> Self {
        let count = self.steps.len();
        let before = |step: &Step| {
            step.operands().filter_map(|source| match source {
                Source::Step(other) => Some(other as usize),
                _ => None,
            })
        };
        // Latency of the critical path from each step to the end.
        let mut way = vec![0; count];
        for k in (0..count).rev() {
            way[k] += latency(&self.steps[k]);
            for other in before(&self.steps[k]).collect::<Vec<_>>() {
                way[other] = way[other].max(way[k]);
            }
        }
        let mut place = vec![None; count];
        // Times are in units of the issue time of one step.
        let mut ready = vec![0; count];
        let mut order = Vec::with_capacity(count);
        let mut open: Vec<usize> = (0..count.min(WINDOW)).collect();
        let mut next = open.len();
        while !open.is_empty() {
            let now = order.len() as u32;
            let starts = |k: usize| {
                before(&self.steps[k]).try_fold(0_u32, |latest, other| {
                    place[other].map(|_: u32| latest.max(ready[other]))
                })
            };
            // Chooses the step with the longest critical path among those that can start now. If no
            // step can start now, chooses the step that can start first.
            let rank = |k: usize| starts(k).map(|at| (at.max(now), u32::MAX - way[k], k));
            let best = open.iter().copied().filter_map(|k| rank(k).map(|rank| (rank, k))).min();
            // The operands of the first open step are always scheduled.
            let step = best.map_or(open[0], |(_, k)| k);
            place[step] = Some(now);
            ready[step] = now + WIDTH * latency(&self.steps[step]);
            order.push(step);
            open.retain(|k| *k != step);
            if next < count {
                open.push(next);
                next += 1;
            }
        }
        self.in_order(&order)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_core::random::Random;

    /// Checks that the new order does not change the results of random sums and products.
    #[test]
    fn order_changes_no_result() {
        let mut random = Random::new(6);
        let mut pick = |bound: usize| ((random.number() + 1.0) * 0.5 * bound as f64) as usize;
        let count = 400;
        let mut code = Code { constants: vec![0.5], ..Code::default() };
        for k in 0..count {
            let mut source = || match pick(4) {
                _ if k == 0 => Source::Slot(0),
                0 => Source::Slot(pick(8) as u32),
                1 => Source::Constant(0),
                _ => Source::Step(pick(k) as u32),
            };
            let (a, b) = (source(), source());
            code.steps.push(if pick(2) == 0 { Step::Add(a, b) } else { Step::Mul(a, b) });
            if pick(5) == 0 {
                code.stores.push((Source::Step(k as u32), 8 + code.stores.len() as u32));
            }
        }
        let slots = 8 + code.stores.len();
        let run = |code: &Code| {
            let mut slots: Vec<f64> = (0..slots).map(|k| 0.3 + 0.01 * k as f64).collect();
            code.interpret::<1>(&mut slots, &[], &mut vec![0.0; code.steps.len()]);
            slots
        };
        let scheduled = code.scheduled();
        assert!(scheduled.steps.len() <= code.steps.len());
        assert_eq!(run(&scheduled), run(&code));
    }
}
