//! Finding and reading models, motions and loads.

use crate::failure::{Failure, describe};
use crate::stored::StoredFile;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use stiction_format::{
    Contents, Control, Drives, LoadCase, ModelFile, Motion, Source, gallery, not_text,
};

/// A model that was found.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) model: ModelFile,
}

/// The files that were read, by their full paths: no result may take their place.
static READ: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Whether a file is one that was read.
pub(crate) fn was_read(path: &Path) -> bool {
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    path.canonicalize().is_ok_and(|path| read.contains(&path))
}

fn note(path: &Path) {
    if let Ok(path) = path.canonicalize() {
        READ.lock().unwrap_or_else(PoisonError::into_inner).push(path);
    }
}

/// The largest file that is read as a whole: as a model or a load, or through a pipe.
const LARGEST: u64 = 1 << 30;
/// Recordings longer than this, bytes, are read piece by piece; kept as a whole they take some five times
/// as much memory.
const LONG: u64 = 8 << 20;

/// Finds a model by the name of a file or of one in the gallery.
pub(crate) fn find(name: &str) -> Result<Found, Failure> {
    if name == "-" {
        return standard_input();
    }
    let path = Path::new(name);
    let looks_like_file = path.extension().is_some() || path.components().count() > 1;
    if !looks_like_file && let Some(text) = gallery::get(name) {
        let source = Source::new(format!("{name}.toml"), text);
        let no_files = |_: &str| Err("a built-in model has no other files".to_owned());
        return Ok(Found { model: stiction_format::read(&source, &no_files)? });
    }
    if !looks_like_file && !path.exists() {
        return Err(unknown_model(name));
    }
    let text = read_text(path).map_err(|why| {
        Failure::input(format!("cannot read the model {name}: {why}"))
            .help("give a model file, or a name from `stiction models`")
    })?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let files = |file: &str| contents(&folder.join(file));
    let model = stiction_format::read(&Source::new(name, text), &files)?;
    Ok(Found { model })
}

/// The model that comes through a pipe. Files that it names are looked for where the user is.
fn standard_input() -> Result<Found, Failure> {
    let text = bounded(std::io::stdin().lock(), LARGEST).map_err(|why| {
        Failure::input(format!("cannot read the model from standard input: {why}"))
            .help("give a model file, or a name from `stiction models`")
    })?;
    let model = stiction_format::read(&Source::new("standard input", text), &beside)?;
    Ok(Found { model })
}

/// There is no such model in the gallery.
pub(crate) fn unknown_model(name: &str) -> Failure {
    // Where a model may stand, a command may have been meant.
    let command = near_command(name);
    let nearest = gallery::names()
        .map(|known| (strsim::damerau_levenshtein(known, name), known))
        .min()
        .filter(|(distance, known)| *distance <= 1 + known.len() / 3);
    let help = match (nearest, command) {
        (_, Some(command)) => format!("did you mean `stiction {command}`?"),
        (Some((_, known)), None) => format!("did you mean `{known}`? `stiction models` lists all"),
        (None, None) => {
            "`stiction models` lists the built-in models; a file's name ends in .toml".to_owned()
        }
    };
    Failure::input(format!("there is no built-in model `{name}`, and no file of that name"))
        .help(help)
}

/// The command whose name is nearly this.
pub(crate) fn near_command(name: &str) -> Option<&'static str> {
    ["inverse", "forward", "check", "breakaway", "study", "convert", "models", "schema", "help"]
        .into_iter()
        .find(|command| strsim::damerau_levenshtein(command, name) <= 2)
}

/// What is in a file that is looked for where the user is.
fn beside(file: &str) -> Result<Contents, String> {
    contents(Path::new(file))
}

/// What is in a file that a model or an option names, or why that cannot be read.
fn contents(path: &Path) -> Result<Contents, String> {
    let about = fs::metadata(path).map_err(|error| describe(&error))?;
    let is_table = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    // What comes through a pipe cannot be read again.
    if about.is_file() && about.len() > LONG && !is_table {
        let stored = StoredFile::open(path, about.len()).map_err(|error| describe(&error))?;
        note(path);
        return Ok(Contents::Stored(Arc::new(stored)));
    }
    read_text(path).map(Contents::Whole)
}

/// The text of a file, or why there is none.
fn read_text(path: &Path) -> Result<String, String> {
    let about = fs::metadata(path).map_err(|error| describe(&error))?;
    if about.is_dir() {
        return Err("it is a folder".to_owned());
    }
    if about.len() > LARGEST {
        return Err(format!("it has {:.1} GB, the most is 1 GB", about.len() as f64 / 1e9));
    }
    let text = bounded(fs::File::open(path).map_err(|error| describe(&error))?, LARGEST)?;
    note(path);
    Ok(text)
}

/// What comes out of a file, a pipe or a device, if it is text and ends.
fn bounded(from: impl Read, most: u64) -> Result<String, String> {
    let mut bytes = Vec::new();
    from.take(most + 1).read_to_end(&mut bytes).map_err(|error| describe(&error))?;
    if bytes.len() as u64 > most {
        return Err(format!("more than {:.1} GB comes out of it, the most", most as f64 / 1e9));
    }
    String::from_utf8(bytes)
        .map_err(|error| not_text(error.as_bytes(), error.utf8_error().valid_up_to(), (0, 0)))
}

impl Found {
    /// The motion that the user asks for, or the model's default, with its name.
    pub(crate) fn motion(&self, given: Option<&str>) -> Result<(Motion, String), Failure> {
        let model = &self.model;
        let known = || model.motions.iter().map(|(name, _)| name.as_str());
        match given {
            Some(text) => {
                let motion = model.parse_motion(&Source::new("--motion", text), &beside)?;
                Ok((motion, label(text)))
            }
            None => {
                let name = model.default_motion.clone().or_else(|| only(known()));
                let found =
                    name.as_ref().and_then(|name| Some((model.motion(name)?.clone(), name)));
                let Some((motion, name)) = found else {
                    return Err(nothing_chosen("motion", known()));
                };
                Ok((motion, name.clone()))
            }
        }
    }

    /// The motion that the user asks for, or the model's default, if there is one.
    pub(crate) fn motion_if_any(
        &self,
        given: Option<&str>,
    ) -> Result<Option<(Motion, String)>, Failure> {
        if given.is_none() && self.model.default_motion.is_none() && self.model.motions.is_empty() {
            return Ok(None);
        }
        self.motion(given).map(Some)
    }

    /// A motion of which only the first instant counts.
    pub(crate) fn state(&self, text: &str) -> Result<Motion, Failure> {
        Ok(self.model.parse_motion(&Source::new("--from", text), &beside)?)
    }

    /// Efforts, with their name.
    pub(crate) fn drives(&self, text: &str) -> Result<(Drives, String), Failure> {
        Ok((self.model.parse_drives(&Source::new("--drives", text), &beside)?, label(text)))
    }

    /// A controller, with its name.
    pub(crate) fn controller(&self, text: &str) -> Result<(Control, String), Failure> {
        Ok((self.model.parse_control(&Source::new("--controller", text), &beside)?, label(text)))
    }

    /// The load that the user asks for, or the model's default, or none, with its name.
    pub(crate) fn load(&self, given: Option<&str>) -> Result<(LoadCase, String), Failure> {
        let model = &self.model;
        match given {
            Some(text) => {
                let load = model.parse_load(&Source::new("--load", text), &beside)?;
                Ok((load, label(text)))
            }
            None => match &model.default_load {
                Some(name) => {
                    let load = model.load(name).cloned().unwrap_or_default();
                    Ok((load, name.clone()))
                }
                None => Ok((LoadCase::default(), "none".to_owned())),
            },
        }
    }
}

/// What a motion or load given on the command line is called in results.
fn label(text: &str) -> String {
    let text = text.trim();
    if text.contains('=') { "from the command line".to_owned() } else { text.to_owned() }
}

fn only<'a>(mut names: impl Iterator<Item = &'a str>) -> Option<String> {
    let first = names.next()?;
    names.next().is_none().then(|| first.to_owned())
}

fn nothing_chosen<'a>(what: &str, names: impl Iterator<Item = &'a str>) -> Failure {
    let names: Vec<&str> = names.collect();
    let failure = Failure::input(format!("the model does not say which {what} is meant"));
    let example = match what {
        "motion" => "\"JOINT = 0; duration = 0\" for a single pose",
        _ => "\"...\"",
    };
    if names.is_empty() {
        failure.help(format!(
            "add one to the model as [{what}s.NAME], or give one: --{what} {example}"
        ))
    } else {
        failure.help(format!("give one with --{what}: {}", names.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A device may have no end.
    #[test]
    fn what_does_not_end_is_refused() {
        let why = bounded(std::io::repeat(b'x'), 100_000_000).unwrap_err();
        assert_eq!(why, "more than 0.1 GB comes out of it, the most");
        assert_eq!(bounded(&b"abc"[..], 3).as_deref(), Ok("abc"));
        assert!(bounded(&b"abcd"[..], 3).is_err());
    }
}
