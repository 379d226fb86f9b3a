//! Headline figures of a simulation, for comparison with other runs.

use super::job::Job;
use super::outcome::Outcome;
use super::page::verdicts;
use super::rows::{Layout, Rows};
use super::summary::Summary;
use crate::comparison::{ComparedRun, Conditions, EffortCurves, Headline, motor_headlines};
use crate::{Sink, SinkError};

impl Summary {
    /// Returns the results that a comparison with other runs uses.
    pub fn compared(&self, job: &Job<'_>, outcome: &Outcome) -> ComparedRun {
        ComparedRun {
            conditions: Conditions {
                motion: job.motion_name.clone(),
                load: job.load_name.clone(),
                friction: if job.friction { "on" } else { "off" },
            },
            mobility: None,
            travel: Vec::new(),
            headlines: self.headlines(),
            cautions: self.cautions(job, outcome),
            findings: verdicts::of(job, self, outcome),
        }
    }

    /// Returns the headline figures: peak magnitude and root mean square of each effort, peak
    /// tracking errors, work of actuators and friction, the largest joint reaction, and torque,
    /// speed, power and limits of each motor.
    fn headlines(&self) -> Vec<Headline> {
        let mut all = Vec::new();
        let mut add = |name: String, unit, value: f64, at| {
            all.push(Headline::new(name, unit, value, at));
        };
        let effort = self.drives.iter().map(|drive| drive.peak.abs()).fold(0.0, f64::max);
        for ((name, unit), drive) in self.layout.names.drives.iter().zip(&self.drives) {
            let (peak, time) = (drive.peak.abs(), Some(drive.peak_time));
            add(format!("{name} effort, peak"), unit, peak, (time, effort));
            add(format!("{name} effort, rms"), unit, drive.rms(), (None, effort));
        }
        for (k, error) in self.errors.iter().enumerate().filter(|(k, _)| self.layout.reference[*k])
        {
            let dof = &self.layout.dofs[self.layout.dof_of_actuator[k]];
            let (name, peak) = (format!("{} tracking error, peak", dof.name), error.peak.abs());
            add(name, dof.units()[0], peak, (Some(error.peak_time), peak));
        }
        let account = self.account();
        let turnover = account.turnover;
        let drives = account.drives.iter().sum();
        add("work of the actuators".to_owned(), "J", drives, (None, turnover));
        let friction = account.interfaces.iter().sum();
        add("work dissipated by friction".to_owned(), "J", friction, (None, turnover));
        let largest = self.reactions.0.iter().map(|(force, _)| force);
        if let Some(force) = largest.max_by(|a, b| a.peak.abs().total_cmp(&b.peak.abs())) {
            let (name, peak) = ("largest joint reaction".to_owned(), force.peak.abs());
            add(name, "N", peak, (Some(force.peak_time), peak));
        }
        all.extend(motor_headlines(self.layout.motors.trains().zip(&self.motors)));
        all
    }
}

/// Collector of the actuator efforts in the table rows of a simulation.
#[derive(Clone, Debug)]
pub struct RowEfforts {
    layout: Layout,
    /// Effort of each actuator over time, as collected so far.
    pub curves: EffortCurves,
}

impl RowEfforts {
    /// Creates empty curves with room for `count` samples.
    pub fn new(job: &Job<'_>, count: usize) -> Self {
        Self { layout: Layout::new(job), curves: EffortCurves::new(&job.model.mechanism, count) }
    }
}

impl Sink<Rows> for RowEfforts {
    fn add(&mut self, rows: &Rows) -> Result<(), SinkError> {
        let count = self.layout.dof_of_actuator.len();
        let efforts = (0..count).map(|actuator| self.layout.drive_in(&rows.forward, actuator).0);
        self.curves.push(rows.time, efforts);
        Ok(())
    }
}
