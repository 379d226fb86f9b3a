//! Equation-by-equation study of the paper Zhang Y., Jin P., Gong J., Liu Q. (2018), Dynamic
//! Modeling of 3-RPS Parallel Robot Considering Joint Friction.
//!
//! This crate contains the closed formulas of one robot and compares their results with the general
//! engine, which does not use the formulas. `screws`, `kinematics`, `lagrangian`, `reactions`,
//! `friction` and `simulation` are the paper's sections 1 to 6; `engine` converts results of the
//! general engine to the paper's notation; `sections` assembles the report.

mod engine;
mod friction;
mod kinematics;
mod lagrangian;
mod reactions;
pub mod report;
mod robot;
mod screws;
mod sections;
mod simulation;

#[cfg(test)]
mod tests;

use engine::{Run, job, model, positions};
use report::{Report, Section};
use stiction_core::dynamics::FrictionMode;
use stiction_run::check::examine;
use stiction_run::{Error as RunError, Job};
use thiserror::Error as ThisError;

/// Errors of the study.
#[derive(Debug, ThisError)]
#[non_exhaustive]
pub enum Error {
    /// A built-in model is invalid.
    #[error("the built-in model `{0}` cannot be used; this is a defect of the program")]
    Gallery(
        /// Name of the model.
        String,
    ),
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A formula has no solution where one is expected.
    #[error(
        "the formulas of the study have no solution at a pose at which they should have one; this \
         is a defect of the program"
    )]
    NoSolution,
}

/// Steps of the study in order, for progress reports.
const STEPS: [&str; 6] = [
    "structure of the printed robot",
    "positions",
    "the regular twin without friction",
    "the regular twin with friction",
    "the printed motion",
    "methods compared",
];

/// Reports progress and tests for cancellation.
struct Steps<F> {
    progress: F,
    step: usize,
}

impl<F: FnMut(&str, usize, usize) -> bool> Steps<F> {
    fn begin(&mut self, step: usize) -> Result<(), Error> {
        self.step = step;
        self.ask()
    }

    fn ask(&mut self) -> Result<(), Error> {
        if self.goes_on() { Ok(()) } else { Err(RunError::Interrupted.into()) }
    }

    fn goes_on(&mut self) -> bool {
        (self.progress)(STEPS[self.step], self.step, STEPS.len())
    }

    fn run(&mut self, job: &Job<'_>) -> Result<Run, Error> {
        Run::of(job, |_, _, _| self.goes_on())
    }
}

/// Runs the study. `progress` receives the current step, the number of completed steps and their
/// total, several times per step, and returns false to cancel.
///
/// # Errors
/// See [`enum@Error`].
pub fn study(progress: impl FnMut(&str, usize, usize) -> bool) -> Result<Report, Error> {
    let mut steps = Steps { progress, step: 0 };
    let (printed, regular) = (model("zhang2018")?, model("zhang2018-regular")?);

    steps.begin(0)?;
    let unloaded = job(&printed, "printed", "none", FrictionMode::Off)?;
    let ideal = job(&regular, "regular", "L0", FrictionMode::Off)?;
    let mut examined = |job: &Job<'_>| examine(job, |_, _, _| steps.goes_on());
    let findings = [examined(&unloaded)?, examined(&ideal)?];
    steps.begin(1)?;
    let of_printed = positions(&unloaded)?;
    let of_twin = positions(&ideal)?;
    steps.begin(2)?;
    let frictionless = steps.run(&ideal)?;
    steps.begin(3)?;
    let mut with = |load: &str, friction| steps.run(&job(&regular, "regular", load, friction)?);
    let none = with("L0", FrictionMode::Converged)?;
    let moderate = with("L1", FrictionMode::Converged)?;
    let heavy = with("LP", FrictionMode::Converged)?;
    let one_pass = with("L0", FrictionMode::OnePass)?;
    let runs = sections::twin::Runs { none: &none, moderate: &moderate, printed: &heavy };
    steps.begin(4)?;
    // The printed case has no solution. This failure is the expected result.
    let hopeless = job(&printed, "printed", "printed", FrictionMode::Off)?;
    let refused = match hopeless.run(|_| Ok(()), |_, _, _| steps.goes_on()) {
        Err(RunError::Interrupted) => return Err(RunError::Interrupted.into()),
        Err(error) => error,
        Ok(_) => return Err(Error::NoSolution),
    };
    steps.begin(5)?;
    let loaded = job(&regular, "regular", "L0", FrictionMode::Converged)?;
    let mut sections = vec![sections::structure::write(findings.each_ref(), [&unloaded, &ideal])?];
    let mut add = |section: Section| {
        sections.push(section);
        steps.ask()
    };
    add(sections::kinematics::write(&of_printed, &of_twin))?;
    add(sections::ideal::write(&frictionless.samples))?;
    add(sections::reactions::write(&frictionless.samples))?;
    let friction = sections::friction::write(&none.samples, &one_pass.samples);
    add(friction.ok_or(Error::NoSolution)?)?;
    add(sections::simulation::write(&refused))?;
    add(sections::twin::write(&runs, &loaded)?)?;
    add(sections::engines::write())?;
    add(sections::headline::write())?;
    add(sections::map::write())?;
    Ok(Report {
        title: "A 3-RPS parallel robot with joint friction: a paper checked equation by equation"
            .into(),
        lead: lead(),
        sections,
        footer: footer(),
    })
}

fn lead() -> Vec<String> {
    vec![
        "The paper models a 3-RPS parallel robot whose R axes are parallel: mobility by screw \
         theory, kinematics, Lagrangian dynamics, all joint reactions by D’Alembert's principle, \
         friction that depends on those reactions, and driving forces corrected for it. This study \
         computes every equation of the paper, states which of them hold, and repeats the \
         computation for the nearest robot whose driving forces exist."
            .into(),
        "In short: the kinematics are right. Three moments of inertia, the equilibrium of the \
         legs, and the way in which friction enters are wrong. The printed robot is singular in \
         every pose, and its printed motion lies on a second singularity. Therefore its driving \
         forces do not exist without friction, and they are not determined with friction. The \
         [regular twin](#twin) differs in the tilt of its platform's triangle; for this robot, \
         every number is certain."
            .into(),
    ]
}

fn footer() -> Vec<String> {
    vec![
        "The paper: Zhang Y., Jin P., Gong J., Liu Q. (2018). Dynamic Modeling of 3-RPS Parallel Robot Considering Joint \
         Friction. Transactions of the Chinese Society for Agricultural Machinery 49(9), 374–381 (in Chinese). Equation \
         numbers are the paper's."
            .into(),
        "Added here, not in the paper: moments of inertia about x and z, which have no influence; \
         the point P; and the regular twin with its motion."
            .into(),
        "The study was compared with an independent review of the paper. It differs in these \
         numbers: the axis O<sub>1</sub>y<sub>1</sub> is 0.39 m from the bases of legs 2 and 3, \
         not 0.42 m; up to 56.05 N m are missing under the reversed load, not 56.1; and (28) adds \
         18.35 % in leg 3, not 18.4 %. All other numbers agree to the published digits."
            .into(),
        format!(
            "stiction {}, `stiction study zhang2018`. SI units unless a column says otherwise.",
            env!("CARGO_PKG_VERSION")
        ),
    ]
}

/// Point k of a low-discrepancy sequence in the unit cube: fractional parts of multiples of the
/// inverse powers of the generalised golden ratio in three dimensions (root of x^4 = x + 1).
fn even(k: usize) -> [f64; 3] {
    const ROOT: f64 = 1.220_744_084_605_759_6;
    let part = |power: i32| ((k + 1) as f64 * ROOT.powi(-power)).fract();
    [part(1), part(2), part(3)]
}
