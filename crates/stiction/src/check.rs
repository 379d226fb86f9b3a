//! Mobility, redundancy and singularities of a robot.

use crate::error::Error;
use crate::request::Request;
use crate::robot::Robot;
use serde_json::Value;
use std::fmt;
use stiction_core::dynamics::FrictionMode;
use stiction_format::{LoadCase, Motion};
use stiction_run::Job;
use stiction_run::check::{Findings, Kind, examine, write_report};
use stiction_run::inverse::Phase;

/// Request to check mobility, redundancy and singularities of a robot along a motion; see
/// [`Robot::check_along`].
pub type Check = Request<Examination>;

/// Options specific to a [`Check`]. A check has only the options of all requests, so this type is
/// empty.
#[derive(Clone, Debug)]
pub struct Examination;

impl Check {
    pub(crate) fn of(robot: &Robot) -> Self {
        let mut check = Self::new(robot, Examination);
        check.load = (LoadCase::default(), "none".to_owned());
        if robot.model().motions.is_empty() {
            check.motion = Some((Motion::pose(), "none".to_owned()));
        }
        check
    }

    /// Converts the request to a job of `stiction_run`.
    ///
    /// # Errors
    /// The model has several motions, but no default, and none was set.
    pub fn job(&self) -> Result<Job<'_>, Error> {
        self.along(FrictionMode::Off)
    }

    /// Examines the robot along the motion, without loads and friction.
    ///
    /// # Errors
    /// The mechanism cannot follow the motion.
    pub fn run(&self) -> Result<Report, Error> {
        self.run_with(|_phase, _done, _of| true)
    }

    /// Examines the robot along the motion, without loads and friction, and reports progress: the phase, the number
    /// of samples done, and the number of all samples. Stops when `progress` returns `false`.
    ///
    /// # Errors
    /// The mechanism cannot follow the motion, or `progress` stopped the computation.
    pub fn run_with(
        &self,
        progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Report, Error> {
        let job = self.job()?;
        let findings = examine(&job, progress)?;
        let json = findings.json(&job);
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = write_report(&mut text, &job, &findings);
        Ok(Report { findings, json, text })
    }
}

/// Results of a check. `Display` prints them as the command `stiction check` does.
#[derive(Clone, Debug)]
pub struct Report {
    findings: Findings,
    json: Value,
    text: String,
}

/// Degrees of freedom at the first instant of the motion, counted in three ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mobility {
    /// Mobility by the Grübler–Kutzbach count; negative if the mechanism is over-constrained.
    pub gruebler: i64,
    /// Instantaneous mobility, from the rank of the constraints.
    pub instantaneous: usize,
    /// Finite (full-cycle) mobility; `None` if it is undecided.
    pub finite: Option<usize>,
}

/// Smallest distance of the motion from singular positions of one kind, as a singularity index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Singularity {
    /// Smallest singularity index along the motion, dimensionless; zero at a singular position.
    pub index: f64,
    /// Time at which the index is smallest, s.
    pub time: f64,
    /// `true` if the motion passes through or touches a singular position, at a sample or between
    /// samples.
    pub is_met: bool,
}

impl Report {
    /// Number of degrees of freedom at the first instant of the motion, counted in three ways.
    pub fn mobility(&self) -> Mobility {
        let mobility = &self.findings.mobility;
        Mobility {
            gruebler: mobility.gruebler,
            instantaneous: mobility.instantaneous,
            finite: mobility.finite.decided(),
        }
    }

    /// Number of redundant constraints.
    pub fn redundant_constraints(&self) -> usize {
        self.findings.mobility.redundant_constraints
    }

    /// Statically indeterminate components of the reactions, as `JOINT.COMPONENT`, for example
    /// `pin.fz`.
    pub fn undetermined_reactions(&self) -> Vec<String> {
        let open = self.findings.undetermined.iter();
        open.flat_map(|(joint, components)| components.iter().map(move |c| format!("{joint}.{c}")))
            .collect()
    }

    /// Nearest approach to type-2 (actuation) singularities, at which the actuators do not determine the motion.
    pub fn actuation_singularity(&self) -> Singularity {
        self.singularity(Kind::Actuation).unwrap_or(NEVER)
    }

    /// Nearest approach to constraint singularities, at which the mechanism gains a degree of freedom.
    pub fn constraint_singularity(&self) -> Singularity {
        self.singularity(Kind::Constraint).unwrap_or(NEVER)
    }

    /// Nearest approach to type-1 (leg) singularities; `None` for a mechanism without legs.
    pub fn leg_singularity(&self) -> Option<Singularity> {
        self.singularity(Kind::Leg)
    }

    fn singularity(&self, kind: Kind) -> Option<Singularity> {
        let (_, nearness) = self.findings.singularities().find(|(known, _)| *known == kind)?;
        let is_met = self.findings.is_singular(kind);
        Some(Singularity { index: nearness.least, time: nearness.time, is_met })
    }

    /// Warnings about the mechanism and its motion.
    pub fn warnings(&self) -> &[String] {
        &self.findings.warnings
    }

    /// All results as a `stiction_run` type.
    pub fn findings(&self) -> &Findings {
        &self.findings
    }

    /// All results as plain text, as the command `stiction check` prints them.
    pub fn as_text(&self) -> &str {
        &self.text
    }

    /// All results as JSON, with the keys of `stiction check --json`.
    pub fn to_json(&self) -> &Value {
        &self.json
    }
}

/// Result for a kind of singularity that cannot occur in the mechanism.
const NEVER: Singularity = Singularity { index: f64::INFINITY, time: 0.0, is_met: false };

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}
