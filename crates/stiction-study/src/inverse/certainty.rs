//! How sure the solution of friction and reactions is: whether there are others, and how far it goes on
//! as coefficients grow.

use stiction::dynamics::{AppliedLoad, FrictionMargin, InverseDynamics};

/// Coefficients are grown to so many times the given ones at most.
pub const MOST_MARGIN: f64 = 100.0;

/// Other solutions that were found.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherSolutions {
    /// At how many samples.
    pub samples: usize,
    /// The first of them, s.
    pub time: f64,
    /// The drives of each other solution there.
    pub drives: Vec<Vec<f64>>,
}

/// The least margin along a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Margin {
    /// The factor by which all coefficients can grow before friction locks the mechanism; none if
    /// they can grow [`MOST_MARGIN`] times.
    pub factor: Option<f64>,
    /// When, s.
    pub time: f64,
    /// The joint that locks.
    pub joint: Option<String>,
}

/// What is known along the motion so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Certainty {
    pub(super) others: Option<OtherSolutions>,
    pub(super) margin: Option<Margin>,
    /// Of the last sample.
    pub(super) coupling: Option<f64>,
    /// Of the last sample; infinite if friction locks nowhere. None if nobody asked.
    pub(super) last_margin: Option<f64>,
}

impl Certainty {
    /// Looks at a solved sample; at the margin only if that is asked for.
    pub(super) fn look(
        &mut self,
        solver: &mut InverseDynamics,
        loads: &[AppliedLoad<f64>],
        time: f64,
        with_margin: bool,
    ) {
        self.coupling = solver.coupling();
        if self.coupling.is_some_and(|coupling| coupling >= 1.0) {
            let drives = solver.other_solutions(loads);
            match &mut self.others {
                _ if drives.is_empty() => {}
                Some(others) => others.samples += 1,
                None => self.others = Some(OtherSolutions { samples: 1, time, drives }),
            }
        }
        self.last_margin = None;
        if !with_margin {
            return;
        }
        let Some(FrictionMargin { locks_at, joint }) = solver.friction_margin(loads, MOST_MARGIN)
        else {
            return;
        };
        self.last_margin = Some(locks_at.unwrap_or(f64::INFINITY));
        let is_less = |known: &Margin| {
            locks_at.is_some_and(|factor| known.factor.is_none_or(|known| factor < known))
        };
        if self.margin.as_ref().is_none_or(is_less) {
            let joint = joint.map(|joint| solver.mechanism().joints()[joint.0].name.clone());
            self.margin = Some(Margin { factor: locks_at, time, joint });
        }
    }
}
