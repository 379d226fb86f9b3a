//! Animation of the robot in the report of a simulation.

use super::job::Job;
use super::rows::{Layout, Rows};
use crate::bodies::BodyRow;
use crate::report::animation::{Animation as Shared, Reel};
use crate::{Sink, SinkError};
use stiction_core::spatial::Pose;

/// Collector of simulation samples for the animation of the robot in the report.
#[derive(Clone, Debug)]
pub struct Animation {
    layout: Layout,
    ground: Pose<f64>,
    pub(super) shared: Shared,
}

/// Number of columns that contain the external load of a body. They are the last columns of the
/// body in `bodies.csv`.
const LOAD: usize = 6;

impl Animation {
    /// Creates an empty animation for `count` samples.
    pub fn new(job: &Job<'_>, count: usize) -> Self {
        let layout = Layout::new(job);
        let mechanism = &job.model.mechanism;
        let shared =
            Shared::new(job.model, &layout.names, &["drive"], &[], count).with_loads(job.load);
        Self { layout, ground: mechanism.base(), shared }
    }

    /// Returns the animation for a page that shows `runs` runs; `None` if no samples were added.
    pub fn reel(&self, runs: usize) -> Option<Reel> {
        self.shared.reel(runs)
    }
}

impl Sink<Rows> for Animation {
    fn add(&mut self, rows: &Rows) -> Result<(), SinkError> {
        let drives = 0..self.layout.names.drives.len();
        let drives = drives.map(|actuator| self.layout.drive_in(&rows.forward, actuator).0);
        let mut values: Vec<f64> = drives.collect();
        values.extend_from_slice(&rows.reactions);
        for row in rows.friction.chunks_exact(6) {
            values.extend([row[0], row[1], row[2], row[4], row[5]]);
        }
        let bodies = || rows.bodies.chunks_exact(BodyRow::WIDTH);
        values.extend(bodies().flat_map(|row| row[BodyRow::WIDTH - LOAD..].iter().copied()));
        let poses = std::iter::once(self.ground).chain(bodies().map(BodyRow::pose));
        self.shared.push(rows.time, poses, values);
        Ok(())
    }
}
