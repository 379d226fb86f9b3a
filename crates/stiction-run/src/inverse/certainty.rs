//! Uniqueness of the solution with friction, and the friction margin to jamming.

use stiction_core::dynamics::{AppliedLoad, FrictionMargin, InverseDynamics};
use stiction_core::mechanism::Mechanism;

/// Largest factor on the friction coefficients in the search for jamming.
pub const MOST_MARGIN: f64 = 100.0;

/// Solutions of inverse dynamics with friction that differ from the reported solution, found along
/// a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherSolutions {
    /// Number of samples at which other solutions were found.
    pub samples: usize,
    /// Time of the first sample at which other solutions were found, s.
    pub time: f64,
    /// Efforts of all actuators, N or N m, in each other solution at `time`.
    pub drives: Vec<Vec<f64>>,
}

/// Least friction margin to jamming along a motion: the factor on all friction coefficients that
/// causes jamming.
#[derive(Clone, Debug, PartialEq)]
pub struct Margin {
    /// Factor on all friction coefficients at which the mechanism jams; `None` if it does not jam
    /// up to [`MOST_MARGIN`].
    pub factor: Option<f64>,
    /// Time at which the friction margin is least, s.
    pub time: f64,
    /// Name of the joint that jams; `None` if no joint jams.
    pub joint: Option<String>,
}

/// Uniqueness of the solution and, if requested, the friction margin at one sample.
#[derive(Clone, Debug, Default)]
pub(super) struct SampleCertainty {
    pub(super) coupling: Option<f64>,
    /// Efforts of all actuators, N or N m, in each other solution at this sample.
    others: Vec<Vec<f64>>,
    /// Friction margin at this sample; `None` if it was not requested or is unknown.
    margin: Option<FrictionMargin>,
}

impl SampleCertainty {
    /// Searches for other solutions at a solved sample if the solution may not be unique. Also
    /// computes the friction margin if `with_margin` is true.
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

    /// Returns the factor on all friction coefficients at which the mechanism jams: infinite if it
    /// does not jam, `None` if the factor is unknown.
    pub(super) fn locks_at(&self) -> Option<f64> {
        self.margin.map(|margin| margin.locks_at.unwrap_or(f64::INFINITY))
    }
}

/// Other solutions and least friction margin along the motion so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Certainty {
    pub(super) others: Option<OtherSolutions>,
    pub(super) margin: Option<Margin>,
}

impl Certainty {
    /// Adds a sample.
    pub(super) fn add(&mut self, mechanism: &Mechanism, time: f64, sample: &SampleCertainty) {
        match &mut self.others {
            _ if sample.others.is_empty() => {}
            Some(others) => others.samples += 1,
            None => {
                let drives = sample.others.clone();
                self.others = Some(OtherSolutions { samples: 1, time, drives });
            }
        }
        let Some(FrictionMargin { locks_at, joint }) = sample.margin else { return };
        let is_less = |known: &Margin| {
            locks_at.is_some_and(|factor| known.factor.is_none_or(|known| factor < known))
        };
        if self.margin.as_ref().is_none_or(is_less) {
            let joint = joint.map(|joint| mechanism.joints()[joint.0].name.clone());
            self.margin = Some(Margin { factor: locks_at, time, joint });
        }
    }
}
