//! The plots of a run.

use super::contributions::ShareCurves;
use super::job::Job;
use super::sample::Sample;
use crate::by_leg::ByLeg;
use crate::names::Names;
use stiction_core::dynamics::FrictionMode;
use stiction_draw::figure::{Figure, Panel, Trace};

/// Gathers a run's curves sample by sample.
#[derive(Clone, Debug)]
pub struct Curves {
    names: Names,
    has_friction: bool,
    title: String,
    drives: Vec<[Trace; 2]>,
    friction: ByLeg,
    power: [Trace; 4],
    residual: Trace,
    shares: ShareCurves,
}

impl Curves {
    /// No points yet; `count` samples will come.
    pub fn new(job: &Job<'_>, count: usize) -> Self {
        let names = Names::new(&job.model.mechanism);
        let trace = Trace::new(count);
        Self {
            has_friction: job.friction != FrictionMode::Off && !names.interfaces.is_empty(),
            title: format!("{} - {}, load {}", job.model.name, job.motion_name, job.load_name),
            drives: vec![[trace.clone(), trace.clone()]; names.drives.len()],
            friction: ByLeg::new(job.model, &names, count),
            power: std::array::from_fn(|_| trace.clone()),
            residual: trace,
            shares: ShareCurves::new(&names, count),
            names,
        }
    }

    /// Adds a sample.
    pub fn add(&mut self, sample: &Sample<'_>) {
        let (time, forces) = (sample.time, sample.forces);
        for (k, [with, without]) in self.drives.iter_mut().enumerate() {
            with.push(time, forces.efforts[k]);
            without.push(time, forces.efforts_frictionless[k]);
        }
        self.friction.add(time, forces.interfaces.iter().map(|interface| interface.friction));
        self.shares.add(time, sample.shares);
        let power = &forces.power;
        for (trace, value) in self.power.iter_mut().zip([
            power.actuators,
            power.loads,
            power.energy,
            power.dissipated,
        ]) {
            trace.push(time, value);
        }
        let relative = if power.turnover > 0.0 { power.residual() / power.turnover } else { 0.0 };
        self.residual.push(time, relative);
    }

    /// The figures, each with the name of its file.
    pub fn figures(self) -> Vec<(&'static str, Figure)> {
        let x_label = "time [s]".to_owned();
        let mut figures = Vec::new();

        let mut panels = Vec::new();
        for ((name, unit), [with, without]) in self.names.drives.iter().zip(self.drives) {
            let lines = if self.has_friction {
                vec![with.line("with friction", 0, false), without.line("frictionless", 1, true)]
            } else {
                vec![with.line("drive", 0, false)]
            };
            panels.push(Panel { y_label: format!("{name} [{unit}]"), lines });
        }
        if !panels.is_empty() {
            let title = format!("Driving forces: {}", self.title);
            figures.push(("drives", Figure { title, x_label: x_label.clone(), panels }));
        }

        if self.has_friction {
            let panels = self.friction.panels(&self.names, "N");
            let title = format!("Friction forces at the sliding surfaces: {}", self.title);
            figures.push(("friction", Figure { title, x_label: x_label.clone(), panels }));
            if !self.names.drives.is_empty() {
                let title = format!("What friction makes of the driving forces: {}", self.title);
                let figure = self.shares.figure(&self.names, title, x_label.clone());
                figures.push(("shares", figure));
            }
        }

        let labels = ["drives", "loads", "d/dt energy", "dissipated"];
        let lines = labels.iter().zip(self.power).enumerate();
        let lines = lines.map(|(k, (label, trace))| trace.line(label, k, false)).collect();
        let panels = vec![
            Panel { y_label: "power [W]".to_owned(), lines },
            Panel {
                y_label: "residual / turnover".to_owned(),
                lines: vec![self.residual.line("residual", 6, false)],
            },
        ];
        let title = format!("Power balance: {}", self.title);
        figures.push(("power", Figure { title, x_label, panels }));
        figures
    }
}
