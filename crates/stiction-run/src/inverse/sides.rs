//! Detection of singular poses between samples. At an actuation (type 2) singularity, the
//! determinant of the loop constraints with locked actuators changes its sign.

use stiction_core::dynamics::InverseDynamics;

/// Sign of the determinant of the loop constraints with locked actuators, at the last sample.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sides {
    /// Time of the last sample, s, and the sign of the determinant at this sample.
    last: Option<(f64, f64)>,
}

impl Sides {
    /// Adds a sample. Returns the times, s, of the last two samples if the sign of the determinant
    /// changed between them.
    pub(crate) fn observe(
        &mut self,
        solver: &mut InverseDynamics,
        time: f64,
    ) -> Option<(f64, f64)> {
        self.see(solver.side(), time)
    }

    /// Adds a sample at `time`, s; `side` is the sign of the determinant, `None` if it is
    /// undetermined. Returns the times of the previous sample and of this sample if the sign
    /// changes between them.
    pub(super) fn see(&mut self, side: Option<f64>, time: f64) -> Option<(f64, f64)> {
        let now = side.map(|side| (time, side));
        let before = core::mem::replace(&mut self.last, now)?;
        (now?.1 != before.1).then_some((before.0, time))
    }
}
