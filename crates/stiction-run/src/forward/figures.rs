//! Plots of a simulation.

use super::job::Job;
use super::rows::{Layout, Rows};
use super::summary::Summary;
use crate::bodies::BodyRow;
use crate::by_leg::ByLeg;
use crate::in_space::SpaceCurves;
use crate::names::legs_of_actuators;
use crate::{Sink, SinkError};
use stiction_core::forward::{Event, EventKind};
use stiction_draw::figure::meaning::{
    ENERGY, FRICTION, LIMIT, LOAD, OF_LEG, POTENTIAL, REFERENCE, RESULT,
};
use stiction_draw::figure::{Figure, Panel, Trace};

/// Collector of the curves for the figures of a simulation. Each sample adds one point to the
/// curves.
#[derive(Clone, Debug)]
pub struct Curves {
    layout: Layout,
    /// Index of the leg of each actuator; `None` for actuators outside the legs.
    legs: Vec<Option<usize>>,
    title: String,
    /// Indices, among all scalar degrees of freedom of joints, of those whose positions are
    /// plotted.
    drawn: Vec<usize>,
    positions: Vec<Trace>,
    reference: Vec<Trace>,
    errors: Vec<Trace>,
    drives: Vec<Trace>,
    friction: ByLeg,
    space: SpaceCurves,
    energy: [Trace; 5],
    first: Option<(f64, f64)>,
}

/// Largest number of panels in the figures of motion, tracking errors and efforts.
const PANELS: usize = 9;

impl Curves {
    /// Creates empty curves with room for `count` samples.
    pub fn new(job: &Job<'_>, count: usize) -> Self {
        let layout = Layout::new(job);
        let trace = Trace::new(count);
        let driven = layout.dof_of_actuator.clone();
        let drawn = if driven.is_empty() { (0..layout.dofs.len()).collect() } else { driven };
        let actuators = layout.names.drives.len();
        Self {
            title: format!("{} - {}", job.model.name, doing(job)),
            positions: vec![trace.clone(); drawn.len()],
            reference: vec![trace.clone(); actuators],
            errors: vec![trace.clone(); actuators],
            drives: vec![trace.clone(); actuators],
            friction: ByLeg::new(job.model, &layout.names, count),
            space: SpaceCurves::new(job.tracked(), job.follows_in_space(), count),
            energy: std::array::from_fn(|_| trace.clone()),
            legs: legs_of_actuators(&job.model.mechanism),
            drawn,
            first: None,
            layout,
        }
    }

    /// Names of the files of the figures of all runs, without extension.
    pub const FILES: [&'static str; 7] =
        ["motion", "error", "path", "space-error", "drives", "friction", "energy"];

    /// Returns all figures, each with the name of its file without extension.
    pub fn figures(self, summary: &Summary, events: &[Event]) -> Vec<(&'static str, Figure)> {
        let x_label = "time [s]".to_owned();
        let layout = &self.layout;
        let follows = layout.reference.contains(&true);
        let mut figures = Vec::new();

        let mut panels = Vec::new();
        let mut reference = self.reference.into_iter();
        for (&dof, trace) in self.drawn.iter().zip(self.positions).take(PANELS) {
            let dof = &layout.dofs[dof];
            let mut lines = vec![trace.line("position", OF_LEG, false)];
            let reference =
                reference.next().filter(|_| dof.actuator.is_some_and(|a| layout.reference[a]));
            lines.extend(reference.map(|reference| reference.line("reference", REFERENCE, true)));
            let y_label = format!("{} [{}]", dof.name, dof.units()[0]);
            let leg = dof.actuator.and_then(|a| self.legs[a]);
            panels.push(Panel { y_label, lines, leg, ..Panel::default() });
        }
        if !panels.is_empty() {
            let title = format!("Motion: {}", self.title);
            figures.push(("motion", Figure { title, x_label: x_label.clone(), panels }));
        }
        if follows {
            let errors = self.errors.into_iter().zip(&layout.dof_of_actuator);
            let errors =
                errors.zip(&layout.reference).filter(|(_, reference)| **reference).take(PANELS);
            let panels = errors.map(|((trace, &dof), _)| {
                let dof = &layout.dofs[dof];
                let y_label = format!("{} [m{}]", dof.name, dof.units()[0]);
                let lines = vec![trace.line("error", OF_LEG, false)];
                let leg = dof.actuator.and_then(|a| self.legs[a]);
                Panel { y_label, lines, leg, ..Panel::default() }
            });
            let title = format!("Tracking error: {}", self.title);
            let panels = panels.collect();
            figures.push(("error", Figure { title, x_label: x_label.clone(), panels }));
        }
        figures.extend(self.space.figures(&self.title));
        let drives = self.drives.into_iter().zip(&layout.names.drives).zip(&self.legs).take(PANELS);
        let panels: Vec<Panel> = drives
            .map(|((trace, (name, unit)), &leg)| Panel {
                y_label: format!("{name} [{unit}]"),
                lines: vec![trace.line("effort", OF_LEG, false)],
                leg,
                ..Panel::default()
            })
            .collect();
        if !panels.is_empty() {
            let title = format!("Actuator efforts: {}", self.title);
            figures.push(("drives", Figure { title, x_label: x_label.clone(), panels }));
        }
        if !self.friction.is_empty() {
            let mut panels = self.friction.panels(&layout.names, "N");
            let line = sticking(summary, events).line("sticking", LIMIT, false);
            if line.points.iter().any(|point| point.1 > 0.0) {
                panels.push(Panel {
                    y_label: "friction interfaces that stick".to_owned(),
                    lines: vec![line],
                    is_count: true,
                    ..Panel::default()
                });
            }
            let title = format!("Friction: {}", self.title);
            figures.push(("friction", Figure { title, x_label: x_label.clone(), panels }));
        }
        let labels = [
            ("kinetic", ENERGY),
            ("potential", POTENTIAL),
            ("by actuators", RESULT),
            ("by loads", LOAD),
            ("dissipated", FRICTION),
        ];
        let lines = labels.iter().zip(self.energy);
        let lines =
            lines.map(|((label, colour), trace)| trace.line(label, *colour, false)).collect();
        let y_label = "energy since the start [J]".to_owned();
        let panels = vec![Panel { y_label, lines, ..Panel::default() }.without_zeros()];
        let title = format!("Energy balance: {}", self.title);
        figures.push(("energy", Figure { title, x_label, panels }));
        debug_assert!(figures.iter().all(|(name, _)| Self::FILES.contains(name)));
        figures
    }
}

impl Sink<Rows> for Curves {
    fn add(&mut self, rows: &Rows) -> Result<(), SinkError> {
        let time = rows.time;
        for (trace, &dof) in self.positions.iter_mut().zip(&self.drawn) {
            trace.push(time, self.layout.motion_in(&rows.forward, dof)[0]);
        }
        for actuator in 0..self.drives.len() {
            let (drive, reference) = self.layout.drive_in(&rows.forward, actuator);
            self.drives[actuator].push(time, drive);
            if let Some(reference) = reference {
                let dof = self.layout.dof_of_actuator[actuator];
                let position = self.layout.motion_in(&rows.forward, dof)[0];
                self.reference[actuator].push(time, reference);
                self.errors[actuator].push(time, 1e3 * (position - reference));
            }
        }
        let row = |body: usize| &rows.bodies[BodyRow::WIDTH * (body - 1)..][..BodyRow::WIDTH];
        self.space.add(|body| BodyRow::pose(row(body)).position);
        self.space.add_references(time, &rows.space);
        // The third value is false, because a simulation also determines the friction of sticking
        // interfaces.
        self.friction.add(time, rows.friction.chunks_exact(6).map(|row| (row[0], row[2], false)));
        let energy = &rows.energy;
        let drives = self.drives.len();
        let first = *self.first.get_or_insert((energy[0], energy[1]));
        let work: f64 = energy[2..2 + drives].iter().sum();
        let dissipated: f64 = energy[3 + drives..energy.len() - 2].iter().sum();
        let parts =
            [energy[0] - first.0, energy[1] - first.1, work, energy[2 + drives], dissipated];
        for (trace, value) in self.energy.iter_mut().zip(parts) {
            trace.push(time, value);
        }
        Ok(())
    }
}

/// Returns the number of sticking friction interfaces as a curve over time, computed from the
/// events.
fn sticking(summary: &Summary, events: &[Event]) -> Trace {
    let mut at_rest = summary.at_rest_first();
    let mut trace = Trace::new(2 * events.len() + 2);
    let (first, last) = summary.span();
    let count = |at_rest: &[bool]| at_rest.iter().filter(|rests| **rests).count() as f64;
    trace.push(first, count(&at_rest));
    for event in events {
        let before = count(&at_rest);
        match event.kind {
            EventKind::Sticks { interface, .. } => at_rest[interface] = true,
            EventKind::Slides { interface, .. } => at_rest[interface] = false,
            _ => continue,
        }
        if count(&at_rest) != before {
            trace.push(event.time, before);
            trace.push(event.time, count(&at_rest));
        }
    }
    trace.push(last, count(&at_rest));
    trace
}

/// Describes the actuation for titles: the names of the motion and the controller or, without a
/// controller, the name of the feed-forward efforts.
fn doing(job: &Job<'_>) -> String {
    match job.is_controlled() {
        true => format!("motion {}, controller {}", job.motion_name, job.control_name),
        false => format!("drives {}", job.drives_name),
    }
}
