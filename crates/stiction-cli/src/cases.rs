//! Runs of a command for all combinations of several motions and loads, and the envelope of the
//! results.

use crate::answer;
use crate::arguments::Report;
use crate::failure::Failure;
use crate::outputs::{ENVELOPE, Outputs};
use crate::print;
use crate::report::{FILE, command_line};
use crate::written::note_folder;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use stiction::Robot;
use stiction_run::comparison::{ComparedRun, Comparison, EffortCurves, Reel, overlay};

/// Combination of a motion and a load, as the user wrote them, with the name of the folder for the
/// results.
pub(crate) struct Case<'a> {
    pub(crate) motion: Option<&'a str>,
    pub(crate) load: Option<&'a str>,
    pub(crate) name: String,
}

/// Results of the run for one [`Case`].
pub(crate) struct Done {
    pub(crate) json: Value,
    pub(crate) compared: ComparedRun,
    pub(crate) efforts: EffortCurves,
    /// Animation of the robot for the report on all cases, if this report is written.
    pub(crate) reel: Option<Reel>,
    /// Paths of the files that this run has written.
    pub(crate) files: Vec<PathBuf>,
}

/// Splits the values of an option into single motions or loads: `a,b` is a list of two names or
/// files. A text that contains an assignment or is the name of an existing file is not split.
pub(crate) fn separate(given: &[String]) -> Vec<&str> {
    given.iter().flat_map(|text| separate_one(text)).collect()
}

fn separate_one(text: &str) -> Vec<&str> {
    if text.contains('=') || !text.contains(',') || Path::new(text).exists() {
        return vec![text];
    }
    text.split(',').map(str::trim).filter(|name| !name.is_empty()).collect()
}

/// Creates a case for each combination of a motion and a load. The cases have distinct names.
pub(crate) fn cases<'a>([motions, loads]: &[Vec<&'a str>; 2]) -> Vec<Case<'a>> {
    let each = |list: &[&'a str]| -> Vec<Option<(usize, &'a str)>> {
        match list {
            [] => vec![None],
            list => list.iter().copied().enumerate().map(Some).collect(),
        }
    };
    let part = |list: &[&str], given: Option<(usize, &str)>, kind: &str| {
        let (index, text) = given.filter(|_| list.len() > 1)?;
        Some(short_name(text).unwrap_or_else(|| format!("{kind}{}", index + 1)))
    };
    let mut cases: Vec<Case<'a>> = Vec::new();
    for motion in each(motions) {
        for load in each(loads) {
            let parts = [part(motions, motion, "motion"), part(loads, load, "load")];
            let name = parts.into_iter().flatten().collect::<Vec<_>>().join("-");
            let is_new = cases.iter().all(|case| case.name != name);
            let name = if is_new { name } else { format!("{name}-{}", cases.len() + 1) };
            let text = |given: Option<(usize, &'a str)>| given.map(|(_, text)| text);
            cases.push(Case { motion: text(motion), load: text(load), name });
        }
    }
    cases
}

/// Returns a short name of a motion or load for the name of a folder: the name in the model, or the
/// file name without folder and extension, with `_` instead of special characters. Returns `None`
/// for assignments.
fn short_name(text: &str) -> Option<String> {
    if text.contains('=') {
        return None;
    }
    let file = text.rsplit(['/', '\\']).next().unwrap_or(text);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let clean: String = stem
        .chars()
        .map(|c| if c.is_alphanumeric() || matches!(c, '-' | '_') { c } else { '_' })
        .collect();
    (!clean.is_empty()).then_some(clean)
}

/// Names of the files that a single run of the command may write: tables (with extension), figures
/// (without) and the log.
#[derive(Clone, Copy)]
pub(crate) struct SingleRun<'a> {
    pub(crate) tables: &'a [&'a str],
    pub(crate) figures: &'a [&'a str],
    pub(crate) log: &'a str,
}

/// Runs all cases and writes the envelope of the results. Calls `each` with the index of a case
/// and, if there is an output folder, with the subfolder of this case. Removes results of an
/// earlier single run, whose names are `single`, from the output folder.
pub(crate) fn run_all(
    robot: &Robot,
    (folder, as_json, report): (Option<&Path>, bool, Report),
    single: SingleRun<'_>,
    cases: &[Case<'_>],
    mut each: impl FnMut(usize, Option<&Path>) -> Result<Done, Failure>,
) -> Result<(), Failure> {
    // The folder of the envelope, which is written last.
    let outputs = folder.map(|dir| Outputs::new(dir, robot.files_read())).transpose()?;
    outputs.as_ref().map_or(Ok(()), Outputs::refuse_interrupted)?;
    let (mut runs, mut compared, mut files) = (Vec::new(), Vec::new(), Vec::new());
    let (mut curves, mut reels) = (Vec::new(), Vec::new());
    for (index, case) in cases.iter().enumerate() {
        let own = folder.map(|dir| dir.join(&case.name));
        if !as_json {
            print(&format!("== {}\n", case.name))?;
        }
        let run = each(index, own.as_deref())
            .map_err(|failure| in_case(failure, cases, index, folder))?;
        if !as_json {
            print("\n")?;
        }
        files.extend(run.files);
        runs.push(json!({ "name": case.name, "summary": run.json }));
        compared.push((case.name.clone(), run.compared));
        curves.push((case.name.clone(), run.efforts));
        reels.extend(run.reel.map(|reel| (case.name.clone(), reel)));
    }
    let comparison = Comparison::of_cases(compared);
    let json = json!({ "cases": runs, "envelope": comparison.json() });
    if as_json {
        answer::give(&json);
    } else {
        let mut text = format!("== envelope of {} runs\n", cases.len());
        // Writing to a string cannot fail.
        let _ = comparison.write_envelope(&mut text);
        print(&text)?;
    }
    if let Some(mut outputs) = outputs {
        let [summary, table] = ENVELOPE;
        outputs.write(summary, format!("{json:#}\n").as_bytes())?;
        outputs.write(table, &comparison.csv())?;
        let title = format!("Actuator efforts: {}", robot.name());
        let figure = overlay(title, curves);
        if report.is_on() {
            let title = format!("{}: envelope", robot.name());
            let about =
                format!("{} runs: each figure with the run in which it is worst.", cases.len());
            let command = command_line();
            let page = comparison.report((&title, &about), &figure, reels, Some(&command));
            outputs.write(FILE, page.as_bytes())?;
        }
        outputs.write_figures(vec![("drives", figure)])?;
        let SingleRun { tables, figures, log } = single;
        // Files of these names are results only if a run has left its summary.
        files.extend(match outputs.follows_a_run() {
            true => outputs.complete_run(tables, figures, log)?,
            false => outputs.complete(&["drives.png", FILE])?,
        });
    }
    if !as_json {
        note_folder(folder, &files);
    }
    report.show(folder);
    Ok(())
}

/// Adds the names of the failed case, of the finished cases, and of the cases that were not run to
/// `failure`.
fn in_case(failure: Failure, cases: &[Case<'_>], failed: usize, folder: Option<&Path>) -> Failure {
    let names = |cases: &[Case<'_>]| {
        cases.iter().map(|case| case.name.as_str()).collect::<Vec<_>>().join(", ")
    };
    let mut failure = failure.in_run(format!("run `{}`", cases[failed].name));
    let (before, after) = (&cases[..failed], &cases[failed + 1..]);
    if !before.is_empty() {
        let place = match folder {
            Some(folder) => format!(", with results in {}", folder.display()),
            None => String::new(),
        };
        failure = failure.note(format!("finished before: {}{place}", names(before)));
    }
    if !after.is_empty() {
        failure = failure.note(format!("not run: {}", names(after)));
    }
    failure.note("no envelope is written, because a run is missing")
}
