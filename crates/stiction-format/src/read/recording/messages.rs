//! Collection of the messages about a recording, each with its place in the file.

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::source::{Place, Source, Span};
use std::sync::Arc;

/// Maximum number of messages shown for a file.
const MAX_MESSAGES: usize = 20;

/// Messages about a file. The first [`MAX_MESSAGES`] messages are stored; further messages are only
/// counted.
pub(super) struct Messages {
    /// Page of the text that is being read. The spans of new messages are byte ranges of this page.
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
            self.out.add_omitted_errors(1);
            return;
        }
        let place = Place::new(&self.page, span);
        self.out.push(Diagnostic::error(code, message).at(place, label).maybe_help(help));
    }

    /// Tests whether [`MAX_MESSAGES`] messages are stored, so that further messages are only
    /// counted.
    pub(super) fn is_full(&self) -> bool {
        self.out.len() >= MAX_MESSAGES
    }
}
