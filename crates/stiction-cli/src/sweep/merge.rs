//! Merges the parts (shards) of a parameter study.

use super::journal::TABLE;
use super::{Results, part_of};
use crate::arguments::{Shard, Sweep};
use crate::failure::Failure;
use crate::outputs::Outputs;
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use stiction_format::{Key, Variation};
use stiction_run::sweep::{Design, Record};

/// One part of a study, read from its folder.
struct Part {
    folder: PathBuf,
    about: Value,
    shard: Shard,
    lines: BufReader<File>,
    header: String,
}

/// Merges the tables of all parts into one table, in the order of the row numbers.
pub(super) fn merge(options: &Sweep, folders: &[PathBuf]) -> Result<(), Failure> {
    let mut parts = folders.iter().map(|folder| open(folder)).collect::<Result<Vec<_>, _>>()?;
    parts.sort_by_key(|part| part.shard.part);
    let Some(first) = parts.first() else {
        return Err(Failure::input("--merge needs the folders of the parts"));
    };
    let parts_expected = first.shard.parts;
    for part in &parts {
        if part.about["fingerprint"] != first.about["fingerprint"]
            || part.shard.parts != parts_expected
            || part.header != first.header
        {
            return Err(Failure::input(format!(
                "{} and {} are not parts of one study",
                first.folder.display(),
                part.folder.display()
            ))
            .help("merge the folders of one study, whose parts differ only in --shard"));
        }
    }
    for expected in 1..=parts_expected {
        let found = parts.iter().filter(|part| part.shard.part == expected).count();
        if found != 1 {
            let what = if found == 0 { "is missing" } else { "is given twice" };
            return Err(Failure::input(format!("part {expected} of {parts_expected} {what}"))
                .help("give the folder of each part once"));
        }
    }
    let about = first.about.clone();
    let header = first.header.clone();
    let objectives = about["objectives"].as_array().map_or(0, Vec::len);
    let columns: Vec<String> = columns(&header);
    let count_of_keys = columns.len().saturating_sub(objectives + 2);
    let keys = columns.iter().skip(1).take(count_of_keys).map(|name| Key::of_header(name));
    let keys =
        keys.collect::<Result<Vec<_>, _>>().map_err(|why| damaged(&parts[0].folder, &why))?;
    let headers: Vec<String> =
        columns.iter().skip(1 + count_of_keys).take(objectives).cloned().collect();
    let mut results = Results::of(&keys, &headers, shape(&about).as_deref());

    let Some(output) = options.output.as_deref() else {
        return Err(Failure::input("a merged study needs an output folder").help("add -o DIR"));
    };
    let inputs =
        folders.iter().filter_map(|folder| folder.join(TABLE).canonicalize().ok()).collect();
    let mut outputs = Outputs::new(output, inputs)?;
    let mut file = outputs.begin(TABLE)?;
    let count = about["designs"].as_u64().unwrap_or(0);
    writeln!(file, "{header}").map_err(|error| outputs.trouble(TABLE, error))?;
    for row in 0..count {
        let index = (row % parts_expected) as usize;
        let part = &mut parts[index];
        let mut line = String::new();
        let read = part.lines.read_line(&mut line);
        read.map_err(|error| damaged(&part.folder, &error.to_string()))?;
        let record = line
            .strip_suffix('\n')
            .and_then(|line| Record::parse(line, keys.len(), objectives))
            .filter(|record| record.number == row + 1);
        let Some(record) = record else {
            return Err(damaged(&part.folder, &format!("its table has no row {}", row + 1)));
        };
        results.add(record.number, &record.settings, &record.row);
        file.write_all(line.as_bytes()).map_err(|error| outputs.trouble(TABLE, error))?;
    }
    outputs.end(TABLE, file, &[])?;
    let name = about["model"].as_str().unwrap_or_default().to_owned();
    results.finish((options, None), (&name, ""), &about, Some(outputs), None)
}

fn open(folder: &Path) -> Result<Part, Failure> {
    let text = std::fs::read_to_string(folder.join("sweep.json")).map_err(|error| {
        Failure::input(format!(
            "{} does not contain a complete part of a sweep: sweep.json: {error}",
            folder.display()
        ))
        .help("give the folders of parts that have ended; --resume completes an interrupted part")
    })?;
    let value: Value =
        serde_json::from_str(&text).map_err(|error| damaged(folder, &error.to_string()))?;
    let number = |name: &str| value["shard"][name].as_u64();
    let (Some(part), Some(parts)) = (number("part"), number("parts")) else {
        return Err(damaged(folder, "sweep.json does not say which part of the study this is"));
    };
    let file =
        File::open(folder.join(TABLE)).map_err(|error| damaged(folder, &error.to_string()))?;
    let mut lines = BufReader::new(file);
    let mut header = String::new();
    lines.read_line(&mut header).map_err(|error| damaged(folder, &error.to_string()))?;
    let about = value["study"].clone();
    let expected = part_of(about["designs"].as_u64().unwrap_or(0), Shard { part, parts });
    if value["rows"].as_u64() != Some(expected) {
        return Err(damaged(folder, &format!("it should have {expected} rows")));
    }
    let header = header.trim_end_matches('\n').to_owned();
    Ok(Part { folder: folder.to_owned(), about, shard: Shard { part, parts }, lines, header })
}

fn damaged(folder: &Path, why: &str) -> Failure {
    Failure::input(format!("the part in {} cannot be merged: {why}", folder.display()))
        .help("compute this part again")
}

/// Returns the names of the columns in the header of a table.
fn columns(header: &str) -> Vec<String> {
    stiction_run::sweep::fields(header).unwrap_or_default()
}

/// Returns the number of values of each varied key, if the design is a grid.
fn shape(about: &Value) -> Option<Vec<u64>> {
    if about["design"] != "grid" {
        return None;
    }
    let texts = about["vary"].as_array()?.iter().map(Value::as_str);
    let variations = texts.map(|text| Variation::parse(text?).ok()).collect::<Option<Vec<_>>>()?;
    Design::grid(variations).ok()?.shape()
}
