//! Messages: whether notes are printed, and in colour.

use crate::arguments::Messages;
use clap::ColorChoice;
use std::io::IsTerminal;
use std::sync::OnceLock;

static CHOSEN: OnceLock<Messages> = OnceLock::new();

/// Sets what the options ask for, once.
pub(crate) fn set(messages: Messages) {
    let _ = CHOSEN.set(messages);
}

/// True if notes and progress are not wanted.
pub(crate) fn is_quiet() -> bool {
    CHOSEN.get().is_some_and(|chosen| chosen.quiet)
}

/// True if messages on standard error are coloured.
pub(crate) fn coloured() -> bool {
    match CHOSEN.get().map(|chosen| chosen.color) {
        Some(ColorChoice::Always) => true,
        Some(ColorChoice::Never) => false,
        _ => std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none(),
    }
}
