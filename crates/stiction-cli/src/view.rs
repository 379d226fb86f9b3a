//! `stiction view`: a robot and its motion, without forces.

use crate::arguments::{Report, Switch, View};
use crate::failure::Failure;
use crate::outputs::Outputs;
use crate::report;
use crate::sources::{self, warn};
use crate::written::note_files;
use stiction::Error;
use stiction_core::kinematics::AssemblyError;
use stiction_run::{Error as RunError, Job, draw_view};

/// Name of the file with the animated picture.
const PICTURE: &str = "moving.svg";

pub(crate) fn run(options: &View) -> Result<(), Failure> {
    let robot = sources::filtered_robot(&options.model, &options.filter)?;
    warn(robot.warnings());
    let mut request = robot.check_along();
    if let Some(motion) = &options.motion {
        request = request.motion(motion)?;
    }
    if let Some(step) = options.sampling.step {
        request = request.step(step);
    }
    let job = request.job()?;
    sources::refuse_filter(&options.filter, Some((&job.motion_name, job.motion)))?;
    // Without an output folder, the page is opened in a browser.
    let shown = Report { report: Switch::On, open: options.open || options.output.is_none() };
    let folder = shown.folder(options.output.as_deref())?;
    let outputs = folder.as_deref().map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
    let Some(mut outputs) = outputs else { return Ok(()) };
    outputs.refuse_interrupted()?;
    let view = draw_view(&job).map_err(|error| explained(&job, error))?;
    outputs.write(PICTURE, view.picture.as_bytes())?;
    outputs.write(report::FILE, view.html.as_bytes())?;
    let files = outputs.complete(&[])?;
    note_files(&files, true);
    shown.show(folder.as_deref());
    Ok(())
}

/// Converts the error of a view. Without a motion, a mechanism with degrees of freedom has no
/// position to show.
fn explained(job: &Job<'_>, error: RunError) -> Failure {
    let is_free = matches!(&error, RunError::Assembly { error: AssemblyError::Open { .. }, .. });
    if !(is_free && job.motion.coordinates.is_empty()) {
        return Error::from(error).into();
    }
    Failure::input("no motion is given, and the model has none: its position is undetermined").help(
        "give a motion with --motion, for example \"JOINT = 0; duration = 0\" for a single pose, or add \
         [motions.NAME] to the model",
    )
}
