//! Efforts of several runs in one plot.

use crate::names::{Names, legs_of_actuators};
use stiction_core::mechanism::Mechanism;
use stiction_draw::figure::meaning::{OF_LEG, REFERENCE};
use stiction_draw::figure::{Figure, Panel, Trace};

/// Curves of the efforts of one run, for a plot of several runs.
#[derive(Clone, Debug)]
pub struct EffortCurves {
    names: Vec<(String, &'static str)>,
    legs: Vec<Option<usize>>,
    traces: Vec<Trace>,
}

impl EffortCurves {
    /// Creates empty curves for `count` samples of a mechanism.
    pub fn new(mechanism: &Mechanism, count: usize) -> Self {
        let names = Names::new(mechanism).drives;
        Self {
            traces: vec![Trace::new(count); names.len()],
            legs: legs_of_actuators(mechanism),
            names,
        }
    }

    /// Adds the efforts of all actuators at `time`, s.
    pub(crate) fn push(&mut self, time: f64, efforts: impl Iterator<Item = f64>) {
        for (trace, effort) in self.traces.iter_mut().zip(efforts) {
            trace.push(time, effort);
        }
    }
}

/// Draws the efforts of several runs in one figure, with a panel for each actuator. Of two runs,
/// the first is drawn in the colours of the legs, and the second in grey and dashed. If there are
/// more than two runs, each run has one colour in all panels.
pub fn overlay(title: String, runs: Vec<(String, EffortCurves)>) -> Figure {
    let mut panels: Vec<Panel> = Vec::new();
    let is_pair = runs.len() <= 2;
    for (run, (label, curves)) in runs.into_iter().enumerate() {
        let colour = match run {
            0 if is_pair => OF_LEG,
            1 if is_pair => REFERENCE,
            run => run,
        };
        for (((name, unit), leg), trace) in curves.names.iter().zip(curves.legs).zip(curves.traces)
        {
            let y_label = format!("{name} [{unit}]");
            let line = trace.line(&label, colour, run % 2 == 1);
            let leg = leg.filter(|_| is_pair);
            match panels.iter_mut().find(|panel| panel.y_label == y_label) {
                Some(panel) => panel.lines.push(line),
                None => panels.push(Panel { y_label, lines: vec![line], leg, ..Panel::default() }),
            }
        }
    }
    Figure { title, x_label: "time [s]".to_owned(), panels }
}
