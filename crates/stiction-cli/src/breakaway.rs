//! `stiction breakaway`: static friction of a robot at rest.

use crate::answer;
use crate::arguments::Breakaway;
use crate::failure::Failure;
use crate::fold::folded;
use crate::outputs::Outputs;
use crate::print;
use crate::report;
use crate::sources::{self, note_friction, warn};
use crate::written::note_files;
use stiction_run::breakaway::draw_report;

pub(crate) fn run(options: &Breakaway) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

fn execute(options: &Breakaway) -> Result<(), Failure> {
    let robot = sources::robot_or_default(&options.model)?;
    if !options.json {
        warn(robot.warnings());
        note_friction(&robot, true);
    }
    let mut request = robot.breakaway();
    if let Some(motion) = &options.motion {
        request = request.motion(motion)?;
    }
    if let Some(load) = &options.load {
        request = request.load(load)?;
    }
    if let Some(time) = options.at {
        request = request.at(time);
    }
    let folder = options.report.folder(options.output.as_deref())?;
    let outputs = folder.as_deref().map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
    outputs.as_ref().map_or(Ok(()), Outputs::refuse_interrupted)?;
    let rest = request.run()?;
    match options.json {
        true => answer::give(rest.to_json()),
        false => print(&folded(&rest.to_string()))?,
    }
    let Some(mut outputs) = outputs else { return Ok(()) };
    outputs.write("breakaway.json", format!("{:#}\n", rest.to_json()).as_bytes())?;
    if options.report.is_on() {
        let command = report::command_line();
        let page = draw_report(&request.job()?, rest.findings(), Some(&command));
        outputs.write(report::FILE, page.as_bytes())?;
    }
    let files = outputs.complete(&[report::FILE])?;
    if !options.json {
        note_files(&files, true);
    }
    options.report.show(folder.as_deref());
    Ok(())
}
