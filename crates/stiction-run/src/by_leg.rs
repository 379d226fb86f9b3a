//! Plots of a quantity at all friction interfaces, such as the friction force. Each leg has its own
//! panel, and all joints outside the legs share one panel.

use crate::names::Names;
use stiction_core::mechanism::JointId;
use stiction_draw::figure::{JumpTrace, Panel, reversal};
use stiction_format::ModelFile;

/// Curves of a quantity over time, one for each friction interface. The curves of a leg share a
/// panel, as do those of all joints outside the legs.
#[derive(Clone, Debug)]
pub(crate) struct ByLeg {
    panel_names: Vec<String>,
    panel_of_interface: Vec<usize>,
    traces: Vec<JumpTrace>,
    /// Time, s, and sliding velocity at the last plotted point of each interface.
    last: Vec<Option<(f64, f64)>>,
    /// True for each interface that was at rest at its last plotted point.
    rested: Vec<bool>,
    count: usize,
}

impl ByLeg {
    /// Creates empty curves for `count` points.
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
            rested: vec![false; names.interfaces.len()],
            count,
        }
    }

    /// Adds a point to the curve of each interface. For each interface, `values` contains the
    /// sliding velocity, the plotted value, and a flag that is true if the value is unknown because
    /// the interface is at rest.
    pub(crate) fn add(&mut self, time: f64, values: impl Iterator<Item = (f64, f64, bool)>) {
        let values: Vec<_> = values.collect();
        let crossings = self.last.iter().zip(&values);
        let crossings: Vec<Option<f64>> = crossings
            .map(|(last, (velocity, ..))| last.and_then(|last| reversal(last, (time, *velocity))))
            .collect();
        // When the sliding direction of one interface reverses, its friction jumps. Normal loads,
        // and with them the friction of the other interfaces, may jump at the same time.
        let first = crossings.iter().flatten().copied().reduce(f64::min);
        // An interface that comes to rest has unknown friction, which makes the values of all other
        // interfaces unknown at this instant.
        let mut comes_to_rest = false;
        for (rested, (_, _, rests)) in self.rested.iter_mut().zip(&values) {
            comes_to_rest |= *rests && !*rested && self.count > 1;
            *rested = *rests;
        }
        let each = self.traces.iter_mut().zip(&mut self.last).zip(values).zip(crossings);
        for (((trace, last), (velocity, value, rests)), crossing) in each {
            trace.push(time, 0.0, value, rests || comes_to_rest, crossing.or(first));
            *last = Some((time, velocity));
        }
    }

    /// Returns true if the mechanism has no friction interfaces.
    pub(crate) fn is_empty(&self) -> bool {
        self.traces.is_empty()
    }

    /// Returns the colour index of each interface: the number of the interface within its panel,
    /// counted from 0.
    pub(crate) fn colours(&self) -> Vec<usize> {
        let mut counts = vec![0; self.panel_names.len()];
        let next = |panel: &usize| {
            counts[*panel] += 1;
            counts[*panel] - 1
        };
        self.panel_of_interface.iter().map(next).collect()
    }

    /// Converts the curves to panels for plotting; `unit` is the unit of the plotted values.
    pub(crate) fn panels(self, names: &Names, unit: &str) -> Vec<Panel> {
        let panel = |(panel, name): (usize, &String)| {
            let own = self.panel_of_interface.iter().zip(&names.rotates);
            let mut own = own.filter(|(at, _)| **at == panel).map(|(_, rotates)| *rotates);
            let unit = match (own.clone().any(|rotates| !rotates), own.any(|rotates| rotates)) {
                (_, false) => unit.to_owned(),
                (false, true) => format!("{unit} m"),
                (true, true) => format!("{unit}, {unit} m"),
            };
            Panel { y_label: format!("{name} [{unit}]"), ..Panel::default() }
        };
        let mut panels: Vec<Panel> = self.panel_names.iter().enumerate().map(panel).collect();
        let colours = self.colours();
        let traces = self.traces.into_iter().zip(&names.interfaces).zip(colours);
        for (((trace, (name, _)), colour), &panel) in traces.zip(&self.panel_of_interface) {
            panels[panel].lines.push(trace.line(name, colour, false));
        }
        panels
    }
}
