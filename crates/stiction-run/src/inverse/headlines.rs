//! Headline figures of an inverse dynamics run, for comparison with other runs.

use super::page::verdicts;
use super::sample::Sample;
use super::summary::Summary;
use super::verdict::Verdict;
use crate::comparison::{ComparedRun, Conditions, EffortCurves, Headline, Travel, motor_headlines};
use crate::job::{Job, friction_word};
use crate::{Sink, SinkError};

impl Summary {
    /// Returns the results that a comparison with other runs uses.
    pub fn compared(&self, job: &Job<'_>, verdict: &Verdict) -> ComparedRun {
        ComparedRun {
            conditions: Conditions {
                motion: job.motion_name.clone(),
                load: job.load_name.clone(),
                friction: friction_word(job.friction),
            },
            mobility: Some(verdict.mobility.saturating_sub(verdict.idle_spins.len())),
            travel: self.travel().collect(),
            headlines: self.headlines(),
            cautions: self.cautions(job),
            findings: verdicts::of(job, self, verdict),
        }
    }

    /// Returns the range of each actuator's coordinate.
    fn travel(&self) -> impl Iterator<Item = Travel> {
        let positions = self.names.drives.iter().zip(self.positions());
        positions.filter_map(|((name, unit), range)| {
            let unit = if *unit == "N" { "m" } else { "rad" };
            Some(Travel { name: name.clone(), unit, ends: range.ends()? })
        })
    }

    /// Returns the headline figures: peak magnitude and root mean square of each effort; peak power
    /// of each actuator; torque, speed, power and limits of each motor; work; the largest joint
    /// reaction; and the least singularity indices.
    fn headlines(&self) -> Vec<Headline> {
        let mut all = Vec::new();
        let mut add = |name: String, unit, value: f64, at| {
            all.push(Headline::new(name, unit, value, at));
        };
        let efforts = self.drives.iter().map(|drive| drive.with.peak.abs());
        let effort = efforts.fold(0.0, f64::max);
        for ((name, unit), comparison) in self.names.drives.iter().zip(&self.drives) {
            let with = &comparison.with;
            let (peak, time) = (with.peak.abs(), Some(with.peak_time));
            add(format!("{name} effort, peak"), unit, peak, (time, effort));
            add(format!("{name} effort, rms"), unit, with.rms(), (None, effort));
        }
        let power = self.powers().map(|power| power.peak.abs()).fold(0.0, f64::max);
        for ((name, _), own) in self.names.drives.iter().zip(self.powers()) {
            let at = (Some(own.peak_time), power);
            add(format!("{name} power, peak"), "W", own.peak.abs(), at);
        }
        // Work over the whole motion may vanish although the powers do not.
        let work = power * self.duration();
        let (drives, friction) = (self.work.drives.value, self.work.dissipated.value);
        add("work of the actuators".to_owned(), "J", drives, (None, work));
        add("work dissipated by friction".to_owned(), "J", friction, (None, work));
        let largest = self.reactions.0.iter().map(|(force, _)| force);
        if let Some(force) = largest.max_by(|a, b| a.peak.abs().total_cmp(&b.peak.abs())) {
            let (name, peak) = ("largest joint reaction".to_owned(), force.peak.abs());
            add(name, "N", peak, (Some(force.peak_time), peak));
        }
        all.extend(motor_headlines(self.motors.loads().map(|(train, load, _)| (train, load))));
        for (kind, least) in [("actuation", &self.actuation), ("constraint", &self.constraint)] {
            if least.value.is_finite() {
                let name = format!("singularity index of {kind}, least");
                let own = Headline::new(name, "-", least.value, (Some(least.time), 1.0));
                all.push(Headline { least_is_worst: true, ..own });
            }
        }
        all
    }
}

impl Sink<Sample> for EffortCurves {
    fn add(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.push(sample.time, sample.forces.efforts.iter().copied());
        Ok(())
    }
}
