//! Animation of the robot in the report of an inverse dynamics run.

use super::sample::Sample;
use crate::bodies::{BodyRow, poses_in_world};
use crate::job::Job;
use crate::names::Names;
use crate::report::animation::{Animation as Shared, Reel};
use crate::statistics::Least;
use crate::{Sink, SinkError};
use stiction_core::kinematics::Bodies;

/// Collects the samples of an inverse dynamics run for the animation of the robot in the report.
#[derive(Clone, Debug)]
pub struct Animation {
    pub(super) shared: Shared,
    /// Least actuation singularity index, as in the summary.
    least: Least,
    /// Sample with the least actuation singularity index so far; `None` if no index is known.
    pub(super) nearest: Option<Nearest>,
}

/// Pose at which the mechanism is nearest to a singular position of its actuation.
#[derive(Clone, Debug)]
pub(super) struct Nearest {
    /// Time of the sample, s.
    pub(super) time: f64,
    /// Actuation singularity index.
    pub(super) index: f64,
    pub(super) bodies: Bodies<f64>,
}

impl Animation {
    /// Creates an empty animation with room for `count` samples.
    pub fn new(job: &Job<'_>, count: usize) -> Self {
        let mechanism = &job.model.mechanism;
        let quantities = ["drive", "drive_low", "drive_high", "drive_frictionless"];
        let whole = ["distance.actuation [-]", "distance.constraint [-]"];
        let names = Names::new(mechanism);
        let shared =
            Shared::new(job.model, &names, &quantities, &whole, count).with_loads(job.load);
        Self { shared, least: Least::default(), nearest: None }
    }

    /// Returns the animation for an HTML page that shows `runs` runs; `None` if no samples were
    /// added.
    pub fn reel(&self, runs: usize) -> Option<Reel> {
        self.shared.reel(runs)
    }
}

impl Sink<Sample> for Animation {
    fn add(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let forces = &sample.forces;
        let mut values = Vec::new();
        for (k, &(low, high)) in forces.effort_bounds.iter().enumerate() {
            values.extend([forces.efforts[k], low, high, forces.efforts_frictionless[k]]);
        }
        let flag = |value: bool| f64::from(u8::from(value));
        let reactions = forces.reactions.iter().zip(&sample.determined_reactions);
        for ((force, moment), determined) in reactions {
            values.extend(force.to_array().into_iter().chain(moment.to_array()));
            values.push(flag(determined.iter().all(|component| *component)));
        }
        for interface in &forces.interfaces {
            values.extend([interface.velocity, interface.load, interface.friction]);
            values.extend([interface.power, flag(!interface.slides && interface.limit > 0.0)]);
        }
        values.extend(BodyRow::loads(&sample.bodies, &sample.loads));
        values.extend([sample.distances.actuation, sample.distances.constraint]);
        let (known, index) = (self.least.value, sample.distances.actuation);
        self.least.add(sample.time, index);
        if self.least.value < known {
            let bodies = sample.bodies.clone();
            self.nearest = Some(Nearest { time: sample.time, index, bodies });
        }
        self.shared.push(sample.time, poses_in_world(&sample.bodies, sample.origin), values);
        Ok(())
    }
}
