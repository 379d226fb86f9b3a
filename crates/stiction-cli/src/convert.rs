//! `stiction convert`: conversion of a mechanism from and to formats of other programs.

use crate::arguments::{Convert, Format};
use crate::failure::Failure;
use crate::outputs::Outputs;
use crate::print;
use crate::sources::{self, warn};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use stiction::{Conversion, Converted, Robot};

pub(crate) fn run(options: &Convert) -> Result<(), Failure> {
    let text = sources::model_text(&options.model, &options.reading.import())?;
    // Remarks that affect results are warnings of the robot.
    for remark in text.notes().iter().filter(|remark| !remark.affects_results) {
        note!("note: {}", remark.line());
    }
    let is_import = text.is_imported();
    let own = text.as_text().to_owned();
    let robot = options.set.iter().fold(text, |text, change| text.with(change)).read()?;
    warn(robot.warnings());
    let format = format(options, is_import)?;
    // The model text of an imported robot contains comments, units and legs, which the assembled
    // mechanism does not contain.
    let is_text =
        format == Format::Model && is_import && options.set.is_empty() && options.motion.is_none();
    let Converted { text, beside, .. } = match is_text {
        true => Converted { text: own, beside: None, notes: Vec::new() },
        false => converted(options, &robot, format)?,
    };
    match &options.output {
        None => {
            if beside.is_some() {
                note!(
                    "note: loop closures and motors are in a separate YAML file; -o FILE writes \
                    both files"
                );
            }
            print(&text)
        }
        Some(path) => {
            let yaml = path.with_extension("yaml");
            if let Some(beside) = &beside {
                keep_foreign(&yaml, path, beside)?;
            }
            write(path, text.as_bytes(), robot.files_read())?;
            beside.map_or(Ok(()), |beside| write(&yaml, beside.as_bytes(), robot.files_read()))
        }
    }
}

/// Returns a failure if the file `yaml`, which the user did not name, exists and does not end with the line by which
/// files of this program end.
fn keep_foreign(yaml: &Path, named: &Path, text: &str) -> Result<(), Failure> {
    let last = |text: &str| text.trim_end().lines().last().map(str::to_owned);
    // A file that cannot be read as text is foreign.
    let is_own = || std::fs::read_to_string(yaml).is_ok_and(|old| last(&old) == last(text));
    if !yaml.is_file() || is_own() {
        return Ok(());
    }
    let (yaml, named) = (yaml.display(), named.display());
    let message = format!(
        "cannot write {named}: its loop closures and motors belong into {yaml}, which exists and was not written by \
         stiction"
    );
    Err(Failure::input(message).help("move that file, or give another name with -o"))
}

/// Chooses the output format: that of `--to`, else that of the output's file extension. Without
/// both, an imported robot becomes a model file.
fn format(options: &Convert, is_import: bool) -> Result<Format, Failure> {
    if let Some(format) = options.to {
        return Ok(format);
    }
    let ending = options.output.as_deref().and_then(Path::extension).and_then(|e| e.to_str());
    match ending.map(str::to_ascii_lowercase).as_deref() {
        Some("toml") => Ok(Format::Model),
        Some("json") => Ok(Format::Json),
        Some("xml" | "mjcf") => Ok(Format::Mjcf),
        Some("urdf") => Ok(Format::Urdf),
        Some("sdf") => Ok(Format::Sdf),
        None if is_import => Ok(Format::Model),
        _ => {
            let help = "choose it with --to, or by the extension of the output file (-o): .toml, \
                .urdf, .sdf, .xml, .json";
            Err(Failure::input("the format of the output is not known").help(help))
        }
    }
}

/// Converts the mechanism to `format` and prints notes on properties that this format cannot
/// express.
fn converted(options: &Convert, robot: &Robot, format: Format) -> Result<Converted, Failure> {
    let mut request = robot.check_along();
    if let Some(motion) = &options.motion {
        request = request.motion(motion)?;
    }
    let converted = request.convert(match format {
        Format::Json => Conversion::Json,
        Format::Model => Conversion::Model,
        Format::Mjcf => Conversion::Mjcf,
        Format::Urdf => Conversion::Urdf,
        Format::Sdf => Conversion::Sdf,
    })?;
    for note in &converted.notes {
        note!("note: {note}");
    }
    Ok(converted)
}

/// Writes a file atomically. Pipes and devices receive the text directly.
pub(crate) fn write(path: &Path, text: &[u8], files_read: Vec<PathBuf>) -> Result<(), Failure> {
    let failure = |why: String| {
        Failure::input(format!("cannot write {}: {why}", path.display()))
            .help("give the name of a file with -o")
    };
    if path.is_dir() || path.as_os_str().to_string_lossy().ends_with('/') {
        return Err(failure("it is a folder".into()));
    }
    if path.is_symlink() && !path.exists() {
        return Err(failure("it is a link to a file that does not exist".into()));
    }
    // Keep a symbolic link and write its target.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if files_read.contains(&target) {
        return Err(failure("it is an input of this conversion".into()));
    }
    if target.exists() && !target.is_file() {
        let into = std::fs::OpenOptions::new().write(true).open(&target);
        return into
            .and_then(|mut into| into.write_all(text))
            .map_err(|error| failure(error.to_string()));
    }
    let name = target.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| failure("its name is not valid UTF-8".into()))?;
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    if folder.exists() && !folder.is_dir() {
        return Err(failure(format!("{} is a file", folder.display())));
    }
    let mut outputs = Outputs::new(folder, files_read)?;
    outputs.write(name, text)?;
    outputs.complete(&[])?;
    note!("wrote {}", path.display());
    Ok(())
}
