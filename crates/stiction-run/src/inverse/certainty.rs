//! How sure the solution of friction and reactions is: whether there are others, and how far it goes on
//! as coefficients grow.

use stiction_core::dynamics::{AppliedLoad, FrictionMargin, InverseDynamics};
use stiction_core::mechanism::Mechanism;

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

/// How sure the solution at one sample is.
#[derive(Clone, Debug, Default)]
pub(super) struct Asked {
    pub(super) coupling: Option<f64>,
    /// The drives of other solutions.
    others: Vec<Vec<f64>>,
    /// None if nobody asked, or nothing is known.
    margin: Option<FrictionMargin>,
}

impl Asked {
    /// Looks at a solved sample; at the margin only if that is asked for.
    pub(super) fn of(
        solver: &mut InverseDynamics,
        loads: &[AppliedLoad<f64>],
        with_margin: bool,
    ) -> Self {
        let coupling = solver.coupling();
        let is_open = coupling.is_some_and(|coupling| coupling >= 1.0);
        let others = if is_open { solver.other_solutions(loads) } else { Vec::new() };
        let margin = if with_margin { solver.friction_margin(loads, MOST_MARGIN) } else { None };
        Self { coupling, others, margin }
    }

    /// The factor by which coefficients can grow; infinite if friction locks nowhere.
    pub(super) fn locks_at(&self) -> Option<f64> {
        self.margin.map(|margin| margin.locks_at.unwrap_or(f64::INFINITY))
    }
}

/// What is known along the motion so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Certainty {
    pub(super) others: Option<OtherSolutions>,
    pub(super) margin: Option<Margin>,
}

impl Certainty {
    /// Adds a sample.
    pub(super) fn add(&mut self, mechanism: &Mechanism, time: f64, asked: &Asked) {
        match &mut self.others {
            _ if asked.others.is_empty() => {}
            Some(others) => others.samples += 1,
            None => {
                let drives = asked.others.clone();
                self.others = Some(OtherSolutions { samples: 1, time, drives });
            }
        }
        let Some(FrictionMargin { locks_at, joint }) = asked.margin else { return };
        let is_less = |known: &Margin| {
            locks_at.is_some_and(|factor| known.factor.is_none_or(|known| factor < known))
        };
        if self.margin.as_ref().is_none_or(is_less) {
            let joint = joint.map(|joint| mechanism.joints()[joint.0].name.clone());
            self.margin = Some(Margin { factor: locks_at, time, joint });
        }
    }
}
