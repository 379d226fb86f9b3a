//! What is wrong with a recording, at its place.

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::source::{Place, Source, Span};
use std::sync::Arc;

/// So many messages about one file are shown.
const MOST_MESSAGES: usize = 20;

/// Messages about a file, the first few of them.
pub(super) struct Messages {
    /// The page that is being read; places are places in it.
    pub(super) page: Arc<Source>,
    pub(super) out: Diagnostics,
}

impl Messages {
    pub(super) fn new(page: Arc<Source>) -> Self {
        Self { page, out: Diagnostics::new() }
    }

    pub(super) fn push(&mut self, code: &'static str, message: String, span: Span, label: &str) {
        self.push_help(code, message, span, label, None);
    }

    pub(super) fn push_help(
        &mut self,
        code: &'static str,
        message: String,
        span: Span,
        label: &str,
        help: Option<String>,
    ) {
        if self.is_full() {
            self.out.add_untold_errors(1);
            return;
        }
        let place = Place::new(&self.page, span);
        self.out.push(Diagnostic::error(code, message).at(place, label).maybe_help(help));
    }

    /// Whether what follows is only counted.
    pub(super) fn is_full(&self) -> bool {
        self.out.len() >= MOST_MESSAGES
    }
}
