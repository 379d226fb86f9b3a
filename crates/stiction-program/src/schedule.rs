//! The order of steps: recorded code goes leg by leg, and each leg is a chain of waits. Steps that wait
//! for nothing are taken first, those with the longest way to the end before others.

use crate::code::{Code, Source, Step};

/// How far ahead steps are taken: farther, and too many values wait in registers.
const WINDOW: usize = 48;
/// Steps that begin in a cycle.
const WIDTH: u32 = 2;

/// Cycles until a result is there: of no processor in particular.
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
    /// The same with its steps in another order.
    pub(crate) fn scheduled(&self) -> Self {
        let count = self.steps.len();
        let before = |step: &Step| {
            step.operands().filter_map(|source| match source {
                Source::Step(other) => Some(other as usize),
                _ => None,
            })
        };
        // The way from each step to the end.
        let mut way = vec![0; count];
        for k in (0..count).rev() {
            way[k] += latency(&self.steps[k]);
            for other in before(&self.steps[k]).collect::<Vec<_>>() {
                way[other] = way[other].max(way[k]);
            }
        }
        let mut place = vec![None; count];
        // In units of one step's turn.
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
            // Of those that can start now the most urgent; else the one that can start first.
            let rank = |k: usize| starts(k).map(|at| (at.max(now), u32::MAX - way[k], k));
            let best = open.iter().copied().filter_map(|k| rank(k).map(|rank| (rank, k))).min();
            // The first open one always has its operands.
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
        let moved = |source: Source| match source {
            Source::Step(step) => Source::Step(place[step as usize].unwrap_or(step)),
            other => other,
        };
        Self {
            steps: order.iter().map(|k| self.steps[*k].map(moved)).collect(),
            constants: self.constants.clone(),
            stores: self.stores.iter().map(|(source, slot)| (moved(*source), *slot)).collect(),
        }
    }
}
