//! A parsed model text that can be read repeatedly with changed values.

use super::{completed, influence, read_document};
use crate::contents::Contents;
use crate::diagnostic::Diagnostics;
use crate::document::{self, Document};
use crate::model_file::ModelFile;
use crate::source::Source;
use std::sync::Arc;

/// Text of a model that is parsed once and can be read repeatedly with changed values.
///
/// Reading with changes gives the same model as [`read`](crate::read) of the text with these changes.
#[derive(Clone, Debug)]
pub struct Draft {
    /// Text of the model without changes.
    source: Source,
    /// Changes that belong to the text itself; they are applied before those passed to
    /// [`Self::read`].
    changes: Vec<String>,
    document: Document,
}

impl Draft {
    /// Parses the text of a model. Changes that `source` already contains
    /// ([`Source::with_changes`]) are applied before those passed to [`Self::read`].
    ///
    /// # Errors
    /// All syntax errors, each with its place.
    pub fn parse(source: &Source) -> Result<Self, Diagnostics> {
        let own = source.changes().map(|changes| changes.text.lines().map(str::to_owned).collect());
        let source = source.clone().with_changes::<&str>([]);
        let mut out = Diagnostics::new();
        let document = document::parse_unchanged(&Arc::new(source.clone()), &mut out);
        match document {
            Some(document) if !out.has_errors() => {
                Ok(Self { source, changes: own.unwrap_or_default(), document })
            }
            _ => {
                out.sort();
                Err(out)
            }
        }
    }

    /// Reads the model with changes of single values, each as in [`Source::with_changes`].
    ///
    /// # Errors
    /// All errors, each with its place.
    pub fn read<S: AsRef<str>>(
        &self,
        changes: &[S],
        files: &dyn Fn(&str) -> Result<Contents, String>,
    ) -> Result<ModelFile, Diagnostics> {
        let mut out = Diagnostics::new();
        let (source, document) = self.changed(changes, &mut out);
        let model = read_document(&source, &document, files, &mut out);
        completed(model, out)
    }

    /// Checks that the model has all keys to which these changes refer. The values of the changes
    /// are not checked.
    ///
    /// # Errors
    /// All unknown keys, each with the nearest known keys.
    pub fn check_keys<S: AsRef<str>>(&self, changes: &[S]) -> Result<(), Diagnostics> {
        let mut out = Diagnostics::new();
        self.changed(changes, &mut out);
        if out.has_errors() { Err(out) } else { Ok(()) }
    }

    /// Tests if a value has an influence on friction alone, so that it has no effect while friction is off: the key is
    /// in a table `friction`, or the parameter occurs in formulas of friction and nowhere else. `path` is the path of
    /// the key or the name of the parameter, as in [`Source::with_changes`].
    pub fn affects_only_friction(&self, path: &str) -> bool {
        influence::is_only_on_friction(&self.document.root, path)
    }

    fn changed<S: AsRef<str>>(
        &self,
        changes: &[S],
        out: &mut Diagnostics,
    ) -> (Arc<Source>, Document) {
        let all = self.changes.iter().map(String::as_str).chain(changes.iter().map(AsRef::as_ref));
        let source = Arc::new(self.source.clone().with_changes(all));
        let mut document = self.document.clone();
        document::apply(&source, &mut document, out);
        (source, document)
    }
}
