//! The text of a model: a file, standard input or a built-in model, not yet interpreted.

use crate::error::Error;
use crate::files::{Files, ReadProgress, standard_input};
use crate::names::find;
use crate::robot::Robot;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stiction_format::{Source, gallery};

/// The text of a model, not yet interpreted, so that single values can still be changed.
///
/// ```
/// use stiction::ModelText;
///
/// let robot = ModelText::builtin("five-bar")?.with("tool.mass = 0.7 kg").read()?;
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct ModelText {
    source: Source,
    /// Folder in which files that the model names are read; `None` for a built-in model, which names no files.
    folder: Option<PathBuf>,
    files: Files,
    changes: Vec<String>,
}

impl ModelText {
    /// A model file. Files that the model names are looked for in its folder.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn file(path: &Path, progress: Option<Arc<ReadProgress>>) -> Result<Self, Error> {
        let files = Files::with_progress(progress);
        let name = path.display().to_string();
        let text = files.text(path).map_err(|why| {
            Error::input(format!("cannot read the model {name}: {why}"))
                .with_help("give a model file, or the name of a built-in model")
        })?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Self::new(Source::new(name, text), Some(folder), files))
    }

    /// Standard input, up to its end. Files that the model names are looked for in the current folder.
    ///
    /// # Errors
    /// Standard input cannot be read.
    pub fn standard_input(progress: Option<Arc<ReadProgress>>) -> Result<Self, Error> {
        let text = standard_input().map_err(|why| {
            Error::input(format!("cannot read the model from standard input: {why}"))
                .with_help("give a model file, or the name of a built-in model")
        })?;
        let files = Files::with_progress(progress);
        Ok(Self::new(Source::new("standard input", text), Some(PathBuf::new()), files))
    }

    /// A text. Files that the model names are looked for in the current folder.
    pub fn text(text: impl Into<String>) -> Self {
        Self::new(Source::new("model", text), Some(PathBuf::new()), Files::default())
    }

    /// A built-in model; [`gallery::names`] lists all.
    ///
    /// # Errors
    /// There is no built-in model of that name.
    pub fn builtin(name: &str) -> Result<Self, Error> {
        let known: Vec<String> = gallery::names().map(str::to_owned).collect();
        find("built-in model", name, &known)?;
        let text = gallery::get(name).unwrap_or_default();
        Ok(Self::new(Source::new(format!("{name}.toml"), text), None, Files::default()))
    }

    fn new(source: Source, folder: Option<PathBuf>, files: Files) -> Self {
        Self { source, folder, files, changes: Vec::new() }
    }

    /// Changes a value: `KEY = VALUE` with the path of a key (`bodies.platform.mass = 2 kg`) or the name
    /// of a parameter (`mu = 0.12`). See [`Source::with_changes`].
    #[must_use]
    pub fn with(mut self, change: impl Into<String>) -> Self {
        self.changes.push(change.into());
        self
    }

    /// Reads the robot.
    ///
    /// # Errors
    /// The text or a change is defective: the error lists all defects, each with its place.
    pub fn read(self) -> Result<Robot, Error> {
        let source = self.source.clone().with_changes(&self.changes);
        let model = stiction_format::read(&source, &|file| match &self.folder {
            Some(folder) => self.files.contents(&folder.join(file)),
            None => Err("a built-in model has no other files".to_owned()),
        })?;
        Ok(Robot::of_text(model, self))
    }

    pub(crate) fn files(&self) -> &Files {
        &self.files
    }
}
