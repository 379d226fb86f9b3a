//! JSON result of a command.
//!
//! Standard output of a command with `--json` is one object. Some failures are known only after the
//! result, for example that a file cannot be written. Therefore the result is kept until the command
//! has ended, and printed with the error, if any.

use serde_json::Value;
use std::sync::{Mutex, PoisonError};

static ANSWER: Mutex<Option<Value>> = Mutex::new(None);

/// Warnings of the import of the robot.
static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Adds warnings that the result contains under the key `warnings`.
pub(crate) fn warn(warnings: impl Iterator<Item = String>) {
    WARNINGS.lock().unwrap_or_else(PoisonError::into_inner).extend(warnings);
}

/// Keeps the result of the command.
pub(crate) fn give(result: &Value) {
    *ANSWER.lock().unwrap_or_else(PoisonError::into_inner) = Some(with_warnings(result.clone()));
}

/// Adds the warnings of the import to the list `warnings` of an object.
pub(crate) fn with_warnings(mut result: Value) -> Value {
    let own = WARNINGS.lock().unwrap_or_else(PoisonError::into_inner).clone();
    if let Some(object) = result.as_object_mut().filter(|_| !own.is_empty()) {
        let all = object.entry("warnings").or_insert_with(|| Value::Array(Vec::new()));
        if let Some(all) = all.as_array_mut() {
            let missing = own.into_iter().map(Value::from);
            let missing: Vec<Value> = missing.filter(|warning| !all.contains(warning)).collect();
            all.extend(missing);
        }
    }
    result
}

/// Returns the result that was kept, if any, and keeps it no longer.
pub(crate) fn take() -> Option<Value> {
    ANSWER.lock().unwrap_or_else(PoisonError::into_inner).take()
}
