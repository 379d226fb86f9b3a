//! State of an import of a robot file: messages, remarks, and access to files to which the robot
//! file refers.

use crate::diagnostic::{Diagnostic, Diagnostics, quoted};
use crate::source::{Place, Source};
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

/// Function that reads a file to which the robot file refers. Its argument is the name as written,
/// relative to the folder of the robot file. It returns the bytes of the file, or the reason for a
/// failure.
pub type FileLoader<'a> = dyn Fn(&str) -> Result<Vec<u8>, String> + 'a;

/// A remark on a property of the robot file that the model does not express, or that was
/// interpreted differently from how it is written.
#[derive(Clone, Debug)]
pub struct Note {
    /// The remark, a sentence without a full stop.
    pub message: String,
    /// Places in the robot file to which the remark refers.
    pub places: Vec<Place>,
    /// True if results differ from those of the robot file, for example because a force is left out: every command shows
    /// the remark as a warning.
    pub affects_results: bool,
}

impl Note {
    /// The remark, preceded by its file and lines: `models/arm.urdf:12, 15: …`.
    pub fn line(&self) -> String {
        self.line_with(|name| name)
    }

    /// The remark as a warning of the model, if results differ from those of the robot file.
    pub fn warning(&self) -> Option<Diagnostic> {
        /// Number of places that the warning shows.
        const SHOWN: usize = 3;
        if !self.affects_results {
            return None;
        }
        let message = self.message.strip_prefix("WARNING: ").unwrap_or(&self.message);
        let more = match self.places.len().saturating_sub(SHOWN) {
            0 => String::new(),
            1 => ", here and at 1 more place".to_owned(),
            more => format!(", here and at {more} more places"),
        };
        let mut warning = Diagnostic::warning("import", format!("{message}{more}"));
        for (index, place) in self.places.iter().take(SHOWN).enumerate() {
            warning = match index {
                0 => warning.at(place.clone(), ""),
                _ => warning.also(place.clone(), ""),
            };
        }
        Some(warning)
    }

    /// The remark, preceded by its file and lines. `shown` converts the name of the file to the
    /// name that is printed.
    pub(super) fn line_with(&self, shown: fn(&str) -> &str) -> String {
        let mut text = String::new();
        let mut file = None;
        for place in &self.places {
            let name = place.source.name.as_str();
            let line = place.line_column().0;
            match file {
                Some(known) if known == name => text += &format!(", {line}"),
                _ => {
                    let comma = if text.is_empty() { "" } else { ", " };
                    text += &format!("{comma}{}:{line}", shown(name));
                }
            }
            file = Some(name);
        }
        if text.is_empty() { self.message.clone() } else { format!("{text}: {}", self.message) }
    }
}

/// State of an import: access to files, messages and remarks.
pub(super) struct Context<'a> {
    pub(super) files: &'a FileLoader<'a>,
    /// True to import each joint as it is in the file, without merging joints.
    pub(super) literal: bool,
    pub(super) out: RefCell<Diagnostics>,
    notes: RefCell<Vec<Note>>,
    /// Mesh files by path, with `true` for those that can be read.
    meshes: RefCell<HashMap<String, bool>>,
    /// Mesh files that cannot be read, with the places that name them.
    missing: RefCell<Vec<(String, Place)>>,
    /// For each text of a remark, the index of the remark in `notes`, to which further places are
    /// added.
    known: RefCell<HashMap<String, usize>>,
}

impl<'a> Context<'a> {
    pub(super) fn new(files: &'a FileLoader<'a>, literal: bool) -> Self {
        Self {
            files,
            literal,
            out: RefCell::default(),
            notes: RefCell::default(),
            meshes: RefCell::default(),
            missing: RefCell::default(),
            known: RefCell::default(),
        }
    }

    pub(super) fn push(&self, diagnostic: Diagnostic) {
        self.out.borrow_mut().push(diagnostic);
    }

    /// Adds the messages about another file, such as an included one.
    pub(super) fn append(&self, diagnostics: Diagnostics) {
        self.out.borrow_mut().append(diagnostics);
    }

    /// Reports an error at a place.
    pub(super) fn error(&self, code: &'static str, message: String, place: &Place, help: &str) {
        let diagnostic = Diagnostic::error(code, message).at(place.clone(), "");
        let help = (!help.is_empty()).then(|| help.to_owned());
        self.push(diagnostic.maybe_help(help));
    }

    pub(super) fn has_errors(&self) -> bool {
        self.out.borrow().has_errors()
    }

    /// Adds a remark. Remarks with the same text are combined into one with all places.
    pub(super) fn note(&self, message: impl Into<String>, place: Option<Place>) {
        self.remark(message.into(), place, false);
    }

    /// Adds a remark that every command shows as a warning, because results differ from those of the robot file.
    pub(super) fn warn(&self, message: impl Into<String>, place: Option<Place>) {
        self.remark(message.into(), place, true);
    }

    fn remark(&self, message: String, place: Option<Place>, affects_results: bool) {
        let mut notes = self.notes.borrow_mut();
        let mut known = self.known.borrow_mut();
        let index = *known.entry(message.clone()).or_insert_with(|| {
            notes.push(Note { message, places: Vec::new(), affects_results });
            notes.len() - 1
        });
        notes[index].affects_results |= affects_results;
        let same = |known: &Place, place: &Place| {
            Arc::ptr_eq(&known.source, &place.source)
                && known.line_column().0 == place.line_column().0
        };
        if let Some(place) = place
            && !notes[index].places.last().is_some_and(|known| same(known, &place))
        {
            notes[index].places.push(place);
        }
    }

    /// Puts back remarks that were taken.
    pub(super) fn put_notes(&self, notes: Vec<Note>) {
        for Note { message, places, affects_results } in notes {
            let first = places.is_empty().then_some(None);
            for place in places.into_iter().map(Some).chain(first) {
                self.remark(message.clone(), place, affects_results);
            }
        }
    }

    pub(super) fn take_notes(&self) -> Vec<Note> {
        self.known.borrow_mut().clear();
        std::mem::take(&mut *self.notes.borrow_mut())
    }

    /// Tests if a mesh can be shown: its file can be read, and the format of the file is known.
    /// Adds a remark about a mesh that cannot be shown.
    pub(super) fn has_mesh(&self, file: &str, place: Place) -> bool {
        if !self.is_mesh_file(file, &place) {
            return false;
        }
        let ending = file.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
        let is_shown = ["stl", "obj", "glb", "gltf"].contains(&ending.as_str());
        if !is_shown {
            let message = "only meshes in STL, OBJ, GLB and glTF files are shown";
            self.note(message, Some(place));
        }
        is_shown
    }

    /// Tests if the file of a mesh can be read. Files that cannot be read are stored for
    /// `note_missing_meshes`.
    pub(super) fn is_mesh_file(&self, file: &str, place: &Place) -> bool {
        let known = self.meshes.borrow().get(file).copied();
        let is_read = known.unwrap_or_else(|| (self.files)(file).is_ok());
        self.meshes.borrow_mut().insert(file.to_owned(), is_read);
        if !is_read {
            self.missing.borrow_mut().push((file.to_owned(), place.clone()));
        }
        is_read
    }

    /// Reports all mesh files that cannot be read, in one remark.
    pub(super) fn note_missing_meshes(&self) {
        const MOST: usize = 6;
        let missing = self.missing.take();
        let mut names: Vec<String> = Vec::new();
        for (file, _) in &missing {
            let name = quoted(file);
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let more = names.len().saturating_sub(MOST);
        names.truncate(MOST);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let message = format!(
            "mesh files that cannot be read are not shown: {}{more}; --package-path names folders in which package:// \
             and model:// files are searched",
            names.join(", ")
        );
        for (_, place) in missing {
            self.note(message.clone(), Some(place));
        }
    }

    /// Reads a file to which the robot file refers and which must be UTF-8 text.
    pub(super) fn text(&self, name: &str) -> Result<Arc<Source>, String> {
        let bytes = (self.files)(name)?;
        let text = String::from_utf8(bytes).map_err(|_| "it is not UTF-8 text".to_owned())?;
        Ok(Arc::new(Source::new(name, text)))
    }
}
