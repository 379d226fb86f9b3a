//! Access to the text of a recording.

use crate::contents::{Contents, Store};
use crate::signal::recorded::Pages;
use crate::signal::recorded::lines::unify_line_ends;
use crate::source::Source;
use std::sync::Arc;

/// Text of a recording, either in memory or read page by page from a store.
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

    /// Creates the input from a source that contains the whole text.
    pub(crate) fn of_source(source: &Source) -> Self {
        Self::new(&source.name, Contents::Whole(source.text.clone()))
    }

    /// Returns the pages of the text from beginning to end. A text in memory is a single page.
    pub(super) fn pages(&self) -> Box<dyn Iterator<Item = Result<Arc<Source>, String>> + '_> {
        match self {
            Self::Whole(source) => Box::new(std::iter::once(Ok(Arc::clone(source)))),
            Self::Stored { store, name } => Box::new(Pages::new(store.as_ref(), name)),
        }
    }

    /// Returns an input with the whole text in memory.
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
