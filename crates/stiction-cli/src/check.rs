//! `stiction check`: mobility, redundancy and singularities of a robot.

use crate::answer;
use crate::arguments::Check;
use crate::failure::Failure;
use crate::fold::folded;
use crate::inverse::listen_for_interrupt;
use crate::outputs::Outputs;
use crate::print;
use crate::progress::Progress;
use crate::report;
use crate::sources::{self, warn};
use crate::written::note_files;
use std::sync::atomic::Ordering;
use stiction::Error;
use stiction_run::check::draw_page;

pub(crate) fn run(options: &Check) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

fn execute(options: &Check) -> Result<(), Failure> {
    let robot = sources::filtered_robot(&options.model, &options.filter)?;
    if !options.json {
        warn(robot.warnings());
    }
    let mut request = robot.check_along();
    if let Some(motion) = &options.motion {
        request = request.motion(motion)?;
    }
    if let Some(step) = options.sampling.step {
        request = request.step(step);
    }
    let job = request.job()?;
    sources::refuse_filter(&options.filter, Some((&job.motion_name, job.motion)))?;
    let interrupted = listen_for_interrupt();
    // Reject an unwritable folder before the computation.
    let folder = options.report.folder(options.output.as_deref())?;
    let mut outputs =
        folder.as_deref().map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
    let files = match &mut outputs {
        None => None,
        Some(outputs) => Some((
            outputs.begin("check.json")?,
            outputs.begin("mechanism.svg")?,
            options.report.is_on().then(|| outputs.begin(report::FILE)).transpose()?,
        )),
    };
    let mut progress = Progress::new();
    let findings = request.run_with(|phase, done, of| {
        progress.update(phase, done, of);
        !interrupted.load(Ordering::Relaxed)
    });
    progress.clear();
    let findings = findings?;
    match options.json {
        true => answer::give(findings.to_json()),
        false => print(&folded(findings.as_text()))?,
    }
    let (Some(outputs), Some((data, picture, html))) = (outputs, files) else { return Ok(()) };
    let page =
        draw_page(&job, findings.findings(), Some(&report::command_line())).map_err(Error::from)?;
    outputs.end("check.json", data, format!("{:#}\n", findings.to_json()).as_bytes())?;
    outputs.end("mechanism.svg", picture, page.picture.as_bytes())?;
    if let Some(html) = html {
        outputs.end(report::FILE, html, page.html.as_bytes())?;
    }
    let files = outputs.complete(&[report::FILE])?;
    if !options.json {
        note_files(&files, true);
    }
    options.report.show(folder.as_deref());
    Ok(())
}
