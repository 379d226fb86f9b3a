//! `stiction breakaway`: a position at rest.

use crate::arguments::Breakaway;
use crate::failure::Failure;
use crate::inverse::{DEFAULT_MODEL, failure_of, warn};
use crate::print;
use crate::sources;
use stiction_core::dynamics::{FrictionMode, InverseError};
use stiction_run::breakaway::{BreakawayError, look, write_report};
use stiction_run::inverse::{Error, Job};

pub(crate) fn run(options: &Breakaway) -> Result<(), Failure> {
    carry_out(options).map_err(|failure| failure.for_programs(options.json))
}

fn carry_out(options: &Breakaway) -> Result<(), Failure> {
    let found = sources::find(options.model.as_deref().unwrap_or(DEFAULT_MODEL))?;
    if !options.json {
        warn(&found.model.warnings);
    }
    let (motion, motion_name) = found.motion(options.motion.as_deref())?;
    let (load, load_name) = found.load(options.load.as_deref())?;
    let job = Job {
        model: &found.model,
        motion: &motion,
        motion_name,
        load: &load,
        load_name,
        friction: FrictionMode::Converged,
        step: None,
        friction_margin: false,
    };
    if !options.json && job.model.mechanism.joints().iter().all(|j| j.friction.is_empty()) {
        tell!("note: the model declares no friction in any joint\n");
    }
    let findings = look(&job, options.at).map_err(|error| match error {
        BreakawayError::Job(Error::Forces { time, error: InverseError::Unsettled }) => {
            Failure::no_answer(format!(
                "at t = {time} s the mechanism is singular, or redundant in constraints and actuators at \
                 once: what static friction does there is not computed"
            ))
            .help("take another position with --at")
        }
        BreakawayError::Job(error) => failure_of(error),
        error => Failure::input(error.to_string()).help("give another instant with --at"),
    })?;
    if options.json {
        return print(&format!("{:#}\n", findings.json(&job)));
    }
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = write_report(&mut text, &job, &findings);
    print(&text)
}
