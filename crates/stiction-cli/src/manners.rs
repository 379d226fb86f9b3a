//! Settings for messages: quiet or with notes, coloured or not.

use crate::arguments::Messages;
use clap::ColorChoice;
use std::io::IsTerminal;
use std::sync::OnceLock;

static CHOSEN: OnceLock<Messages> = OnceLock::new();

/// Sets the options for messages; only the first call has an effect.
pub(crate) fn set(messages: Messages) {
    let _ = CHOSEN.set(messages);
}

/// Returns whether notes and progress are suppressed.
pub(crate) fn is_quiet() -> bool {
    CHOSEN.get().is_some_and(|chosen| chosen.quiet)
}

/// Returns whether messages on standard error are coloured.
pub(crate) fn coloured() -> bool {
    match CHOSEN.get().map(|chosen| chosen.color) {
        Some(ColorChoice::Always) => true,
        Some(ColorChoice::Never) => false,
        _ => std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none(),
    }
}
