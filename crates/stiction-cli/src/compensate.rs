//! `stiction compensate`: controllers with and without friction compensation.

use crate::answer;
use crate::arguments::Compensate;
use crate::failure::Failure;
use crate::outputs::Outputs;
use crate::print;
use crate::progress::Progress;
use crate::report;
use crate::sources::{self, warn};
use crate::written::note_files;
use std::cell::RefCell;
use stiction::Compensator;
use stiction_run::compensation::draw_report;

pub(crate) fn run(options: &Compensate) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

fn execute(options: &Compensate) -> Result<(), Failure> {
    let robot = sources::robot_or_default(&options.model)?;
    if !options.json {
        warn(robot.warnings());
    }
    let mut request = robot
        .compensation()
        .load(&options.load)
        .transitions(&options.transition)
        .bandwidth(options.bandwidth)
        .period(options.period)
        .known_to(options.known_to, options.seed)
        .sensors(options.resolution, options.noise)
        .delay(options.delay);
    if let Some(motion) = &options.motion {
        request = request.motion(motion);
    }
    if !options.controller.is_empty() {
        let laws: Result<Vec<_>, _> = options.controller.iter().map(|name| law(name)).collect();
        request = request.laws(&laws?);
    }
    let folder = options.report.folder(options.output.as_deref())?;
    let outputs = folder.as_deref().map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
    outputs.as_ref().map_or(Ok(()), Outputs::refuse_interrupted)?;
    let progress = RefCell::new(Progress::new());
    let compared = request.run_with(&|step, done, of| {
        progress.borrow_mut().update_samples(step, done, of);
    });
    progress.borrow_mut().clear();
    let compared = compared?;
    let result = compared.to_json();
    match options.json {
        true => answer::give(&result),
        false => print(&compared.to_string())?,
    }
    let Some(mut outputs) = outputs else { return Ok(()) };
    outputs.write("compensate.json", format!("{result:#}\n").as_bytes())?;
    outputs.write("compensate.csv", compared.errors_csv().as_bytes())?;
    let space = compared.space_csv();
    if !space.is_empty() {
        outputs.write("compensate-space.csv", space.as_bytes())?;
    }
    if options.report.is_on() {
        let command = report::command_line();
        let page = draw_report(robot.model(), &compared.report(), Some(&command));
        outputs.write(report::FILE, page.as_bytes())?;
    }
    let files = outputs.complete(&["compensate-space.csv", report::FILE])?;
    if !options.json {
        note_files(&files, true);
    }
    options.report.show(folder.as_deref());
    Ok(())
}

/// Parses the name of a control law.
fn law(name: &str) -> Result<Compensator, Failure> {
    let all = Compensator::ALL;
    all.into_iter().find(|law| law.name() == name).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|law| law.name()).collect();
        let message = format!("there is no controller `{}`", name.escape_debug());
        let near = stiction_format::did_you_mean(name, "controller", names.iter().copied());
        Failure::input(message)
            .help(near.unwrap_or_else(|| format!("the controllers are {}", names.join(", "))))
    })
}
