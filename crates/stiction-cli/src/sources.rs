//! Reads models, and suggests names similar to misspelt ones on the command line.

use crate::answer;
use crate::arguments::{Arguments, Filter, Model, Reading};
use crate::failure::Failure;
use crate::fold::folded_diagnostics;
use crate::manners;
use crate::progress::Progress;
use clap::CommandFactory;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use stiction::{Diagnostics, Import, ModelText, ReadProgress, Robot, gallery};
use stiction_format::{Motion, Note};

/// Reads a robot from a model file, from standard input (`-`) or from the built-in models, with changed values.
pub(crate) fn robot(name: &OsStr, changes: &[String], reading: &Reading) -> Result<Robot, Failure> {
    Ok(changed(name, changes, reading)?.read()?)
}

fn changed(name: &OsStr, changes: &[String], reading: &Reading) -> Result<ModelText, Failure> {
    let text = model_text(name, &reading.import())?;
    answer::warn(text.notes().iter().filter_map(Note::warning).map(|warning| warning.message));
    let count = text.notes().iter().filter(|note| !note.affects_results).count();
    if count > 0 {
        let remarks = if count == 1 { "1 remark" } else { &format!("{count} remarks") };
        let shown = Path::new(name).display();
        note!("note: {shown} was converted, with {remarks}: see `stiction convert {shown}`\n");
    }
    Ok(changes.iter().fold(text, |text, change| text.with(change)))
}

/// Reads the text of a model file. A robot file of another program is converted to the text of a
/// model file.
pub(crate) fn model_text(name: &OsStr, import: &Import) -> Result<ModelText, Failure> {
    let path = Path::new(name);
    let file = || ModelText::robot_file(path, Some(read_progress()), import);
    // File names need not be valid UTF-8; names of built-in models are.
    let Some(name) = name.to_str() else {
        return Ok(file()?);
    };
    if name == "-" {
        return Ok(ModelText::standard_input(Some(read_progress()))?);
    }
    let looks_like_file = path.extension().is_some() || path.components().count() > 1;
    if !looks_like_file && gallery::get(name).is_some() {
        return Ok(ModelText::builtin(name)?);
    }
    if !looks_like_file && !path.exists() {
        return Err(unknown_model(name));
    }
    Ok(file()?)
}

/// Reads the robot that the options name, or the default robot.
pub(crate) fn robot_or_default(model: &Model) -> Result<Robot, Failure> {
    robot(model.name.as_deref().unwrap_or(OsStr::new(DEFAULT_MODEL)), &model.set, &model.reading)
}

/// Reads the robot that the options name, or the default robot, with a filter for its recorded motions.
pub(crate) fn filtered_robot(model: &Model, filter: &Filter) -> Result<Robot, Failure> {
    let Some(cutoff) = filter.filter else { return robot_or_default(model) };
    let name = model.name.as_deref().unwrap_or(OsStr::new(DEFAULT_MODEL));
    Ok(changed(name, &model.set, &model.reading)?.with_filter(cutoff).read()?)
}

/// Returns a failure if a filter is given for a motion that is not a recording.
pub(crate) fn refuse_filter(
    filter: &Filter,
    motion: Option<(&str, &Motion)>,
) -> Result<(), Failure> {
    let Some(cutoff) = filter.filter else { return Ok(()) };
    let (message, help) = match motion {
        Some((_, motion)) if motion.samples.is_some() => return Ok(()),
        Some((name, _)) => (
            format!("--filter is {cutoff} Hz, but the motion `{name}` is not a recording"),
            "a filter removes the noise of recordings; leave --filter out",
        ),
        None => (
            format!("--filter is {cutoff} Hz, but there is no motion"),
            "give a recording with --motion",
        ),
    };
    Err(Failure::input(message).help(help))
}

/// Name of the default built-in robot.
pub(crate) const DEFAULT_MODEL: &str = "zhang2018-regular";

/// Creates a progress bar for reading long files.
fn read_progress() -> Arc<ReadProgress> {
    let progress: Mutex<Option<Progress>> = Mutex::new(None);
    Arc::new(move |file: &str, done: u64, of: u64| {
        let mut progress = progress.lock().unwrap_or_else(PoisonError::into_inner);
        match done < of {
            true => progress.get_or_insert_with(Progress::new).update_bytes(file, done, of),
            false => *progress = None,
        }
    })
}

/// Prints warnings to standard error.
pub(crate) fn warn(warnings: &Diagnostics) {
    if !warnings.is_empty() {
        message!("{}", folded_diagnostics(&warnings.render(manners::coloured())));
    }
}

/// Prints a note if a computation with friction is of a model without friction, or if values of friction were changed
/// for a computation without friction.
pub(crate) fn note_friction(robot: &Robot, is_on: bool) {
    if !is_on {
        let changed = robot.text().into_iter().flat_map(ModelText::changed_keys);
        return note_without_effect(robot, changed);
    }
    if robot.mechanism().joints().iter().all(|joint| joint.friction.is_empty()) {
        note!("note: the model declares no friction in any joint\n");
    }
}

/// Prints a note for each of the changed keys that affects friction alone, for computations without friction.
pub(crate) fn note_without_effect<'a>(robot: &Robot, keys: impl IntoIterator<Item = &'a str>) {
    for key in keys.into_iter().filter(|key| robot.affects_only_friction(key)) {
        note!("note: friction is off, so `{key}` has no effect; add --friction on\n");
    }
}

/// Largest edit distance between the word `name` and the name `known` for which `known` is
/// suggested. If the first letters agree, as in `goff` for `gough`, the distance may be larger by
/// one.
fn tolerance(known: &str, name: &str) -> usize {
    1 + known.len() / 3 + usize::from(known.chars().next() == name.chars().next())
}

/// True for a word that is neither an option, nor a file, nor a built-in model.
pub(crate) fn is_neither_file_nor_model(name: &str) -> bool {
    !name.starts_with('-') && gallery::get(name).is_none() && !Path::new(name).exists()
}

/// Creates a failure for a name that is neither a file nor a built-in model.
pub(crate) fn unknown_model(name: &str) -> Failure {
    // A misspelt command is parsed as a model.
    let command = near_command(name);
    let nearest = gallery::names()
        .map(|known| (strsim::damerau_levenshtein(known, name), known))
        .min()
        .filter(|(distance, known)| *distance <= tolerance(known, name));
    let help = match (nearest, command) {
        (_, Some(command)) => format!("did you mean `stiction {command}`?"),
        (Some((_, known)), None) => format!("did you mean `{known}`? `stiction models` lists all"),
        (None, None) => {
            "`stiction models` lists the built-in models; the name of a file ends in .toml"
                .to_owned()
        }
    };
    Failure::input(format!("there is no built-in model and no file named `{name}`")).help(help)
}

/// Returns the command that begins with `name`, if `name` has at least three letters and exactly
/// one command begins with it. Otherwise returns the command with the most similar name, if its
/// edit distance from `name` is at most two.
pub(crate) fn near_command(name: &str) -> Option<String> {
    /// Least number of letters that abbreviate a command.
    const SHORTEST: usize = 3;
    let program = Arguments::command();
    let commands = || program.get_subcommands().map(clap::Command::get_name).chain(["help"]);
    let mut longer = commands().filter(|command| command.starts_with(name));
    if name.len() >= SHORTEST
        && let (Some(command), None) = (longer.next(), longer.next())
    {
        return Some(command.to_owned());
    }
    commands()
        .map(|command| {
            let other_letter = command.chars().next() != name.chars().next();
            (strsim::damerau_levenshtein(command, name), other_letter, command)
        })
        .min()
        .filter(|(distance, ..)| *distance <= 2)
        .map(|(.., command)| command.to_owned())
}
