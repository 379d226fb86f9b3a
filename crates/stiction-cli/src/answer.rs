//! JSON result of a command.
//!
//! Standard output of a command with `--json` is one object. Some failures are known only after the
//! result, for example that a file cannot be written. Therefore the result is kept until the command
//! has ended, and printed with the error, if any.

use serde_json::Value;
use std::sync::{Mutex, PoisonError};

static ANSWER: Mutex<Option<Value>> = Mutex::new(None);

/// Keeps the result of the command.
pub(crate) fn give(result: &Value) {
    *ANSWER.lock().unwrap_or_else(PoisonError::into_inner) = Some(result.clone());
}

/// Returns the result that was kept, if any, and keeps it no longer.
pub(crate) fn take() -> Option<Value> {
    ANSWER.lock().unwrap_or_else(PoisonError::into_inner).take()
}
