//! Singular positions between samples: the determinant of the actuators changes its sign.

use stiction_core::dynamics::InverseDynamics;

/// Watches on which side of the singular positions of its actuators a mechanism is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sides {
    /// The last sample, s, and the side there.
    last: Option<(f64, f64)>,
}

impl Sides {
    /// Looks at the next sample; the two samples, s, between which the side changed.
    pub(crate) fn look(&mut self, solver: &mut InverseDynamics, time: f64) -> Option<(f64, f64)> {
        self.see(solver.side(), time)
    }

    /// The same with the side at the sample.
    pub(super) fn see(&mut self, side: Option<f64>, time: f64) -> Option<(f64, f64)> {
        let now = side.map(|side| (time, side));
        let before = core::mem::replace(&mut self.last, now)?;
        (now?.1 != before.1).then_some((before.0, time))
    }
}
