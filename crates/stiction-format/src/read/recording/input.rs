//! Source of the text of a recording.

use crate::contents::{Contents, Store};
use crate::signal::recorded::Pages;
use crate::signal::recorded::lines::unify_line_ends;
use crate::source::Source;
use std::sync::Arc;

/// Text of a recording, in memory or read in pieces.
pub(crate) enum Input {
    Whole(Arc<Source>),
    Stored { store: Arc<dyn Store>, name: String },
}

impl Input {
    pub(crate) fn new(name: &str, contents: Contents) -> Self {
        match contents {
            Contents::Whole(text) => {
                Self::Whole(Arc::new(Source::new(name, unify_line_ends(text))))
            }
            Contents::Stored(store) => Self::Stored { store, name: name.to_owned() },
        }
    }

    /// Creates the input from a source, whose whole text is in memory.
    pub(crate) fn of_source(source: &Source) -> Self {
        Self::new(&source.name, Contents::Whole(source.text.clone()))
    }

    /// The text from beginning to end in pages; a text in memory is a single page.
    pub(super) fn pages(&self) -> Box<dyn Iterator<Item = Result<Arc<Source>, String>> + '_> {
        match self {
            Self::Whole(source) => Box::new(std::iter::once(Ok(Arc::clone(source)))),
            Self::Stored { store, name } => Box::new(Pages::new(store.as_ref(), name)),
        }
    }

    /// Loads the text into memory.
    pub(super) fn in_memory(&self) -> Result<Self, String> {
        let (mut name, mut text) = (String::new(), String::new());
        for page in self.pages() {
            let page = page?;
            name.clone_from(&page.name);
            text.push_str(&page.text);
        }
        Ok(Self::Whole(Arc::new(Source::new(name, text))))
    }
}
