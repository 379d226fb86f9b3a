//! `stiction identify`: inertia and friction from measured logs.

use crate::answer;
use crate::arguments::Identify;
use crate::failure::Failure;
use crate::outputs::Outputs;
use crate::print;
use crate::progress::Progress;
use crate::report;
use crate::sources::{self, warn};
use crate::written::note_files;
use std::cell::RefCell;
use std::path::PathBuf;
use stiction::run::identify::{Identified, IdentifySettings, TEMPLATE, Traces};
use stiction_identify::FitVerdict;

/// Name of the file with the identified model.
const MODEL: &str = "identified.toml";
/// Name of the file with the results as JSON.
const RESULT: &str = "identify.json";
/// Name of the file with measured and computed efforts.
const EFFORTS: &str = "efforts.csv";

pub(crate) fn run(options: &Identify) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

fn execute(options: &Identify) -> Result<(), Failure> {
    if options.template {
        return print(TEMPLATE);
    }
    // Without `--template`, clap rejects arguments that lack the model.
    let Some(name) = options.model.as_deref() else { return Ok(()) };
    let robot = sources::robot(name, &options.set, &options.reading)?;
    warn(robot.warnings());
    let beside = options.logs.first().map(|log| PathBuf::from(log).with_extension("toml"));
    let file = options.options.clone().or_else(|| {
        // The model itself may lie beside a log of the same name.
        beside.filter(|path| path.is_file() && path.as_os_str() != name)
    });
    let mut settings = match &file {
        Some(path) => robot.identify_settings(path)?,
        None => IdentifySettings::default(),
    };
    if options.filter.is_some() {
        settings.filter = options.filter;
    }
    for known in &settings.logs {
        let meant: Vec<_> = options.logs.iter().filter(|log| known.is_at(log)).collect();
        match meant.as_slice() {
            [] => {
                note!("note: the options describe `{}`, which is not among the logs\n", known.file)
            }
            [_] => {}
            [first, second, ..] => {
                return Err(Failure::input(format!(
                    "options: `{}` names {} logs, among them {first} and {second}",
                    known.file,
                    meant.len()
                ))
                .help(
                    "write a longer part of the path in `file`, so that it matches only one log",
                ));
            }
        }
    }
    let logs = options
        .logs
        .iter()
        .map(|log| robot.measured_log(log, &settings))
        .collect::<Result<Vec<_>, _>>()?;
    let folder = options.report.folder(options.output.as_deref())?;
    let outputs = folder.as_deref().map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
    outputs.as_ref().map_or(Ok(()), Outputs::refuse_interrupted)?;
    let progress = RefCell::new(Progress::new());
    let identified = robot.identify_with(&logs, &settings, &|step, done, of| {
        progress.borrow_mut().update_parts(step, done, of);
    })?;
    progress.borrow_mut().clear();
    match options.json {
        true => answer::give(&identified.to_json()),
        false => print(&identified.to_text())?,
    }
    let Some(outputs) = outputs else { return Ok(()) };
    let traces = robot.identify_traces(&logs, &settings, &identified)?;
    write(options, &robot, (&identified, &traces), outputs)?;
    options.report.show(folder.as_deref());
    Ok(())
}

fn write(
    options: &Identify,
    robot: &stiction::Robot,
    (identified, traces): (&Identified, &Traces),
    mut outputs: Outputs,
) -> Result<(), Failure> {
    outputs.write(RESULT, format!("{:#}\n", identified.to_json()).as_bytes())?;
    outputs.write(EFFORTS, traces.csv().as_bytes())?;
    if options.report.is_on() {
        let page = identified.report(robot.model(), traces, Some(&report::command_line()));
        outputs.write(report::FILE, page.as_bytes())?;
    }
    let is_exported = identified.verdict != FitVerdict::Failed || options.force;
    if is_exported {
        let text = identified.model_text(robot.model()).map_err(Failure::no_answer)?;
        outputs.write(MODEL, text.as_bytes())?;
    } else {
        let text = format!("note: the fit failed, so {MODEL} is not written; --force writes it");
        note!("{text}");
    }
    let files = outputs.complete(&[MODEL, RESULT, EFFORTS, report::FILE])?;
    if !options.json {
        note_files(&files, true);
    }
    Ok(())
}
