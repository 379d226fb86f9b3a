//! `stiction study`: the studies that are included in the program.

use crate::answer;
use crate::arguments::Study;
use crate::failure::Failure;
use crate::inverse::listen_for_interrupt;
use crate::outputs::Outputs;
use crate::print;
use crate::progress::Progress;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use stiction_format::gallery;
use stiction_zhang2018 as zhang2018;
use stiction_zhang2018::report::Report;

/// Names and titles of all studies.
const STUDIES: [(&str, &str); 1] = [(
    "zhang2018",
    "a paper on a 3-RPS robot with joint friction, checked against independent programs",
)];

pub(crate) fn run(options: &Study) -> Result<(), Failure> {
    execute(options).map_err(|failure| failure.into_json(options.json))
}

fn execute(options: &Study) -> Result<(), Failure> {
    let Some(name) = &options.name else { return list(options.json) };
    if STUDIES.iter().all(|(known, _)| known != name) {
        return Err(unknown(name));
    }
    let interrupted = listen_for_interrupt();
    // Reject an unwritable folder before the computation. With --json, files are written only on
    // request.
    let folder = options
        .output
        .clone()
        .or_else(|| (!options.json).then(|| PathBuf::from(format!("study-{name}"))));
    let mut outputs = folder.as_deref().map(|dir| Outputs::new(dir, Vec::new())).transpose()?;
    let page = outputs.as_mut().map(|outputs| outputs.begin(PAGE)).transpose()?;
    let mut progress = Progress::new();
    let report = zhang2018::study(|what, done, of| {
        progress.update_step(what, done, of);
        !interrupted.load(Ordering::Relaxed)
    });
    progress.clear();
    let report = report.map_err(|error| match error {
        zhang2018::Error::Run(error) => stiction::Error::from(error).into(),
        error => Failure::no_answer(error.to_string()),
    })?;
    if interrupted.load(Ordering::Relaxed) {
        return Err(Failure::interrupted());
    }
    if options.json {
        answer::give(&report.json());
    } else {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = report.write_findings(&mut text);
        print(&text)?;
    }
    if let (Some(outputs), Some(page), Some(folder)) = (outputs, page, folder) {
        outputs.end(PAGE, page, report.html().as_bytes())?;
        let count = write(outputs, &report, &earlier_files(&folder))?;
        if !options.json {
            let page = folder.join(PAGE);
            note!(
                "\nwrote {} and {count} more files: the report in Markdown and JSON, its pictures, \
                 and all numbers as CSV",
                page.display()
            );
        }
    }
    Ok(())
}

/// File name of the report's HTML page.
const PAGE: &str = "report.html";

/// Writes all files of a report except the page, and returns their number. Removes the files in `earlier` that this
/// report does not contain.
fn write(mut outputs: Outputs, report: &Report, earlier: &[String]) -> Result<usize, Failure> {
    outputs.write("report.md", report.markdown().as_bytes())?;
    let files: Vec<(String, String)> =
        report.tables().into_iter().chain(report.pictures()).collect();
    let mut json = report.json();
    json["files"] = files.iter().map(|(name, _)| name.as_str()).collect();
    outputs.write("report.json", format!("{json:#}\n").as_bytes())?;
    for (name, content) in &files {
        outputs.write(name, content.as_bytes())?;
    }
    let earlier: Vec<&str> = earlier.iter().map(String::as_str).collect();
    Ok(outputs.complete(&earlier)?.len() - 1)
}

/// Returns the names of the CSV and SVG files that an earlier report in `folder` lists. Names that
/// contain a path are ignored.
fn earlier_files(folder: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join("report.json")).unwrap_or_default();
    let report: Value = serde_json::from_str(&text).unwrap_or_default();
    let files = report["files"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let is_plain = |name: &&str| Path::new(name).file_name().is_some_and(|own| own == *name);
    let is_ours = |name: &&str| name.ends_with(".csv") || name.ends_with(".svg");
    files.filter(is_plain).filter(is_ours).map(str::to_owned).collect()
}

fn list(for_programs: bool) -> Result<(), Failure> {
    if for_programs {
        let list = STUDIES.map(|(name, title)| json!({ "name": name, "title": title }));
        answer::give(&json!(list));
        return Ok(());
    }
    let mut out = String::new();
    for (name, title) in STUDIES {
        let indent = " ".repeat(name.len() + 2);
        out += &crate::fold::folded_as(title, &format!("{name}  "), &indent);
        out.push('\n');
    }
    out += "\n`stiction study NAME` runs one and writes its report.\n";
    print(&out)
}

fn unknown(name: &str) -> Failure {
    let names = STUDIES.map(|(name, _)| name);
    let known = format!("known studies: {}", names.join(", "));
    let failure = Failure::input(format!("there is no study `{name}`"));
    let is_model = gallery::get(name).is_some() || Path::new(name).is_file();
    let hint = if is_model {
        format!(
            "a study is a fixed sequence of computations, not a model; {known}. `stiction inverse {name}` runs the model"
        )
    } else {
        stiction_format::did_you_mean(name, "known studies", names).unwrap_or(known)
    };
    failure.help(hint)
}
