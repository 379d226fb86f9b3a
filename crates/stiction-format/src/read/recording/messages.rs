//! Messages about a recording with their places.

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::source::{Place, Source, Span};
use std::sync::Arc;

/// Maximum number of messages shown for a file.
const MAX_MESSAGES: usize = 20;

/// The first messages about a file; further messages are only counted.
pub(super) struct Messages {
    /// The current page, to which places refer.
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

    /// Tests if further messages are only counted.
    pub(super) fn is_full(&self) -> bool {
        self.out.len() >= MAX_MESSAGES
    }
}
