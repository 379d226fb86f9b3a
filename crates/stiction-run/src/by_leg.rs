//! Curves of friction interfaces: one panel for each leg, and one panel for all joints outside the legs.

use crate::names::Names;
use stiction_core::mechanism::JointId;
use stiction_draw::figure::{JumpTrace, Panel, reversal};
use stiction_format::ModelFile;

/// One curve for each friction interface.
#[derive(Clone, Debug)]
pub(crate) struct ByLeg {
    panel_names: Vec<String>,
    panel_of_interface: Vec<usize>,
    traces: Vec<JumpTrace>,
    /// Time and sliding velocity of each interface at the last sample.
    last: Vec<Option<(f64, f64)>>,
}

impl ByLeg {
    /// Creates empty curves with room for `count` points.
    pub(crate) fn new(model: &ModelFile, names: &Names, count: usize) -> Self {
        let mut panel_names: Vec<String> = Vec::new();
        let panel_of_interface = names
            .interfaces
            .iter()
            .map(|(_, joint)| {
                let leg = model.leg_of_joint(JointId(*joint));
                let panel = leg.map_or("joints", |leg| leg.name.as_str());
                panel_names.iter().position(|known| known == panel).unwrap_or_else(|| {
                    panel_names.push(panel.to_owned());
                    panel_names.len() - 1
                })
            })
            .collect();
        Self {
            panel_names,
            panel_of_interface,
            traces: vec![JumpTrace::new(count); names.interfaces.len()],
            last: vec![None; names.interfaces.len()],
        }
    }

    /// Adds a point to the curve of each interface. `values` contains sliding velocity, plotted value, and true if the
    /// value is unknown because the interface is at rest.
    pub(crate) fn add(&mut self, time: f64, values: impl Iterator<Item = (f64, f64, bool)>) {
        let each = self.traces.iter_mut().zip(&mut self.last).zip(values);
        for ((trace, last), (velocity, value, rests)) in each {
            let now = (time, velocity);
            let crossing = last.and_then(|before| reversal(before, now));
            trace.push(time, 0.0, value, rests, crossing);
            *last = Some(now);
        }
    }

    /// Returns whether there is no friction interface.
    pub(crate) fn is_empty(&self) -> bool {
        self.traces.is_empty()
    }

    /// Returns the panels of the curves; `unit` is the unit of the values.
    pub(crate) fn panels(self, names: &Names, unit: &str) -> Vec<Panel> {
        let panel =
            |name: &String| Panel { y_label: format!("{name} [{unit}]"), ..Panel::default() };
        let mut panels: Vec<Panel> = self.panel_names.iter().map(panel).collect();
        let traces = self.traces.into_iter().zip(&names.interfaces);
        for ((trace, (name, _)), &panel) in traces.zip(&self.panel_of_interface) {
            let lines = &mut panels[panel].lines;
            lines.push(trace.line(name, lines.len(), false));
        }
        panels
    }
}
