//! `stiction study`: the studies that the program brings with it.

use crate::arguments::Study;
use crate::failure::Failure;
use crate::inverse::{failure_of, listen_for_interrupt};
use crate::outputs::Outputs;
use crate::print;
use crate::progress::Progress;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use stiction_model::gallery;
use stiction_study::report::Report;
use stiction_study::zhang2018;

/// Names and titles of all studies.
const STUDIES: [(&str, &str); 1] = [(
    "zhang2018",
    "a paper on a 3-RPS robot with joint friction, equation by equation, beside independent programs",
)];

pub(crate) fn run(options: &Study) -> Result<(), Failure> {
    carry_out(options).map_err(|failure| failure.for_programs(options.json))
}

fn carry_out(options: &Study) -> Result<(), Failure> {
    let Some(name) = &options.name else { return list(options.json) };
    if STUDIES.iter().all(|(known, _)| known != name) {
        return Err(unknown(name));
    }
    // A folder that cannot be written is told before anything is computed. Programs that read the
    // report from standard output get files only if they ask for them.
    let folder = options
        .output
        .clone()
        .or_else(|| (!options.json).then(|| PathBuf::from(format!("study-{name}"))));
    let mut outputs = folder.as_deref().map(Outputs::new).transpose()?;
    let interrupted = listen_for_interrupt();
    let mut progress = Progress::new();
    let report = zhang2018::study(|what, done, of| {
        progress.tell_step(what, done, of);
        !interrupted.load(Ordering::Relaxed)
    });
    progress.clear();
    let report = report.map_err(|error| match error {
        zhang2018::Error::Run(error) => failure_of(error),
        error => Failure::no_answer(error.to_string()),
    })?;
    if options.json {
        print(&format!("{:#}\n", report.json()))?;
    } else {
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = report.write_findings(&mut text);
        print(&text)?;
    }
    if let (Some(outputs), Some(folder)) = (outputs.take(), folder) {
        let count = write(outputs, &report)?;
        if !options.json {
            let page = folder.join("report.html");
            eprintln!(
                "\nwrote {} and {count} more files: the same in Markdown and JSON, pictures, and all numbers as CSV",
                page.display()
            );
        }
    }
    Ok(())
}

/// Writes all files of a report but the first, `report.html`, of which it gives no count.
fn write(mut outputs: Outputs, report: &Report) -> Result<usize, Failure> {
    outputs.write("report.html", report.html().as_bytes())?;
    outputs.write("report.md", report.markdown().as_bytes())?;
    outputs.write("report.json", format!("{:#}\n", report.json()).as_bytes())?;
    for (name, content) in report.tables().iter().chain(&report.pictures()) {
        outputs.write(name, content.as_bytes())?;
    }
    Ok(outputs.complete(&[])?.len() - 1)
}

fn list(for_programs: bool) -> Result<(), Failure> {
    if for_programs {
        let list = STUDIES.map(|(name, title)| json!({ "name": name, "title": title }));
        return print(&format!("{:#}\n", json!(list)));
    }
    let mut out = String::new();
    for (name, title) in STUDIES {
        out += &format!("{name}  {title}\n");
    }
    out += "\n`stiction study NAME` carries one out and writes its report.\n";
    print(&out)
}

fn unknown(name: &str) -> Failure {
    let names = STUDIES.map(|(name, _)| name);
    let known = format!("there is: {}", names.join(", "));
    let failure = Failure::input(format!("there is no study `{name}`"));
    let is_model = gallery::get(name).is_some() || Path::new(name).exists();
    let near = names.iter().find(|known| strsim::jaro_winkler(known, name) > 0.8);
    let hint = if is_model {
        format!(
            "a study is a fixed programme, not a model; {known}. `stiction inverse {name}` runs a model"
        )
    } else {
        near.map_or(known, |near| format!("did you mean `{near}`?"))
    };
    failure.help(hint)
}
