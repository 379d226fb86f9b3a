//! Plots of a run.

use super::contributions::ShareCurves;
use super::motor_curves::MotorCurves;
use super::sample::Sample;
use crate::by_leg::ByLeg;
use crate::job::Job;
use crate::names::Names;
use crate::{Sink, SinkError};
use stiction_core::dynamics::FrictionMode;
use stiction_draw::figure::{Figure, Panel, Trace};

/// Collects the curves of a run, sample by sample.
#[derive(Clone, Debug)]
pub struct Curves {
    names: Names,
    has_friction: bool,
    title: String,
    drives: Vec<[Trace; 2]>,
    /// Interval of each actuator's effort at rest, and true once the interval has a width.
    intervals: Vec<([Trace; 2], bool)>,
    friction: ByLeg,
    power: [Trace; 4],
    residual: Trace,
    shares: ShareCurves,
    motors: MotorCurves,
}

impl Curves {
    /// Empty curves for `count` samples.
    pub fn new(job: &Job<'_>, count: usize) -> Self {
        let names = Names::new(&job.model.mechanism);
        let trace = Trace::new(count);
        Self {
            has_friction: job.friction != FrictionMode::Off && !names.interfaces.is_empty(),
            title: format!("{} - {}, load {}", job.model.name, job.motion_name, job.load_name),
            drives: vec![[trace.clone(), trace.clone()]; names.drives.len()],
            intervals: vec![([trace.clone(), trace.clone()], false); names.drives.len()],
            friction: ByLeg::new(job.model, &names, count),
            power: std::array::from_fn(|_| trace.clone()),
            residual: trace,
            shares: ShareCurves::new(&names, count),
            motors: MotorCurves::new(job, count),
            names,
        }
    }

    /// Figures with the names of their files.
    pub fn figures(self) -> Vec<(&'static str, Figure)> {
        let x_label = "time [s]".to_owned();
        let mut figures = Vec::new();

        let mut panels = Vec::new();
        let drives = self.drives.into_iter().zip(self.intervals);
        for ((name, unit), ([with, without], ([least, greatest], has_width))) in
            self.names.drives.iter().zip(drives)
        {
            let mut lines = if self.has_friction {
                vec![with.line("with friction", 0, false), without.line("frictionless", 1, true)]
            } else {
                vec![with.line("drive", 0, false)]
            };
            if has_width {
                lines.push(least.line("least at rest", 2, true));
                lines.push(greatest.line("greatest at rest", 3, true));
            }
            panels.push(Panel { y_label: format!("{name} [{unit}]"), lines });
        }
        if !panels.is_empty() {
            let title = format!("Actuator efforts: {}", self.title);
            figures.push(("drives", Figure { title, x_label: x_label.clone(), panels }));
        }

        figures.extend(self.motors.figure(&self.title).map(|figure| ("motors", figure)));
        if self.has_friction {
            let panels = self.friction.panels(&self.names, "N");
            let title = format!("Friction forces at the friction interfaces: {}", self.title);
            figures.push(("friction", Figure { title, x_label: x_label.clone(), panels }));
            if !self.names.drives.is_empty() {
                let title = format!("Friction contributions to the efforts: {}", self.title);
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

impl Sink<Sample> for Curves {
    fn add(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let (time, forces) = (sample.time, &sample.forces);
        for (k, [with, without]) in self.drives.iter_mut().enumerate() {
            with.push(time, forces.efforts[k]);
            without.push(time, forces.efforts_frictionless[k]);
        }
        for (([least, greatest], has_width), &(low, high)) in
            self.intervals.iter_mut().zip(&forces.effort_bounds)
        {
            if low.is_finite() && high.is_finite() {
                least.push(time, low);
                greatest.push(time, high);
                *has_width |= high > low;
            }
        }
        self.friction.add(time, forces.interfaces.iter().map(|interface| interface.friction));
        self.shares.add(time, &sample.shares);
        self.motors.add(&sample.motors);
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
        Ok(())
    }
}
