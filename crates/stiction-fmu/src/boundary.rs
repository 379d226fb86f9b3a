//! Boundary between C and Rust: converts pointers to references, and errors and panics to statuses.

#![allow(unsafe_code)]

use crate::instance::{Instance, Phase, Saved};
use crate::logger::{Logger, Status};
use std::any::Any;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::slice;
use stiction::Error;

/// Creates an instance with `make` and returns a pointer to the instance. On failure, logs a
/// message and returns null.
pub(crate) fn instantiate(
    logger: Logger,
    make: impl FnOnce() -> Result<Instance, Error>,
) -> *mut c_void {
    let (status, category, message) = match catch_unwind(AssertUnwindSafe(make)) {
        Ok(Ok(instance)) => {
            return Box::into_raw(Box::new(instance.with_logger(logger))).cast();
        }
        Ok(Err(error)) => (Status::Error, "logStatusError", error.to_string()),
        Err(panic) => (Status::Fatal, "logStatusFatal", defect(&*panic)),
    };
    logger.say(status, category, &message);
    std::ptr::null_mut()
}

/// Calls a function with an instance, and returns the FMI status of the call.
///
/// # Safety
/// `instance` is null, or was returned by [`instantiate`], was not freed, and is not in use by another call: the
/// standard forbids concurrent calls on one instance.
pub(crate) unsafe fn with(
    instance: *mut c_void,
    call: impl FnOnce(&mut Instance) -> Result<(), Error>,
) -> c_int {
    // SAFETY: by the contract of this function.
    let Some(instance) = (unsafe { instance.cast::<Instance>().as_mut() }) else {
        return Status::Error as c_int;
    };
    if instance.phase() == Phase::Broken {
        return Status::Fatal as c_int;
    }
    let status = match catch_unwind(AssertUnwindSafe(|| call(instance))) {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(error)) => {
            instance.say(Status::Error, "logStatusError", &error.to_string());
            Status::Error
        }
        Err(panic) => {
            instance.break_down();
            instance.say(Status::Fatal, "logStatusFatal", &defect(&*panic));
            Status::Fatal
        }
    };
    status as c_int
}

/// Formats the message that reports a panic.
fn defect(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a panic");
    let version = env!("CARGO_PKG_VERSION");
    format!("a defect of the library, version {version}: {text}; please report it")
}

/// Copies the bytes of a serialised state to the caller's array `to`. Fails if this array is too
/// short.
pub(crate) fn copy(from: &[u8], to: &mut [u8]) -> Result<(), Error> {
    let room = to.len();
    match to.get_mut(..from.len()) {
        Some(place) => {
            place.copy_from_slice(from);
            Ok(())
        }
        None => Err(Error::input(format!(
            "the state has {} bytes, but the given array has room for {room}",
            from.len()
        ))),
    }
}

/// Frees an instance.
///
/// # Safety
/// The contract of [`with`] applies, and the instance must not be used again.
pub(crate) unsafe fn free(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: the pointer came from `Box::into_raw` in `instantiate`.
        let instance = unsafe { Box::from_raw(instance.cast::<Instance>()) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(instance)));
    }
}

/// Converts the caller's array to a slice; the slice is empty if `count` is zero.
///
/// # Safety
/// `first` points to `count` values that do not change during the call, or is null.
pub(crate) unsafe fn array<'a, T>(first: *const T, count: usize) -> Result<&'a [T], Error> {
    match (first.is_null(), count) {
        (_, 0) => Ok(&[]),
        (true, _) => Err(missing("an array")),
        // SAFETY: by the contract of this function.
        (false, _) => Ok(unsafe { slice::from_raw_parts(first, count) }),
    }
}

/// Converts the caller's array for results to a slice. The array is set to zero first, because the
/// caller's memory need not be initialised.
///
/// # Safety
/// `first` points to `count` values that nothing else uses during the call, or is null.
pub(crate) unsafe fn array_mut<'a, T>(first: *mut T, count: usize) -> Result<&'a mut [T], Error> {
    match (first.is_null(), count) {
        (_, 0) => Ok(&mut []),
        (true, _) => Err(missing("an array")),
        // SAFETY: by the contract of this function. `T` is a number type, for which all bits zero
        // are a valid value.
        (false, _) => Ok(unsafe {
            first.write_bytes(0, count);
            slice::from_raw_parts_mut(first, count)
        }),
    }
}

/// Writes a result to `place`; does nothing for a null pointer.
///
/// # Safety
/// `place` is null, or points to a value that may be written.
pub(crate) unsafe fn put<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: by the contract of this function.
        unsafe { place.write(value) };
    }
}

/// Converts the caller's string to UTF-8 text. `what` names the string in error messages.
///
/// # Safety
/// `text` is null, or points to a string that ends in zero and does not change during the call.
pub(crate) unsafe fn text<'a>(text: *const c_char, what: &str) -> Result<&'a str, Error> {
    if text.is_null() {
        return Err(missing(what));
    }
    // SAFETY: by the contract of this function.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| Error::input(format!("{what} is not UTF-8 text")))
}

pub(crate) fn missing(what: &str) -> Error {
    Error::input(format!("{what} is missing: the pointer is null"))
}

/// Stores a state at the caller's pointer. If the pointer already refers to a state, its memory is
/// reused.
///
/// # Safety
/// `place` is null, or points to a pointer that is null or refers to a state of this library.
pub(crate) unsafe fn give(place: *mut *mut c_void, saved: Saved) -> Result<(), Error> {
    if place.is_null() {
        return Err(missing("the pointer to the state"));
    }
    // SAFETY: by the contract of this function, states are boxes.
    unsafe {
        if let Some(known) = (*place).cast::<Saved>().as_mut() {
            *known = saved;
        } else {
            *place = Box::into_raw(Box::new(saved)).cast();
        }
    }
    Ok(())
}

/// Returns the state to which the caller's pointer refers.
///
/// # Safety
/// `state` is null, or points to a state of this library that is not freed.
pub(crate) unsafe fn state<'a>(state: *mut c_void) -> Result<&'a Saved, Error> {
    // SAFETY: by the contract of this function.
    unsafe { state.cast::<Saved>().as_ref() }.ok_or_else(|| missing("the state"))
}

/// Frees a state, and sets the caller's pointer to null.
///
/// # Safety
/// `place` is null, or points to a pointer that is null or refers to a state of this library. The
/// state must not be used again.
pub(crate) unsafe fn free_state(place: *mut *mut c_void) {
    if place.is_null() {
        return;
    }
    // SAFETY: by the contract of this function, states are boxes.
    unsafe {
        if !(*place).is_null() {
            drop(Box::from_raw((*place).cast::<Saved>()));
        }
        *place = std::ptr::null_mut();
    }
}

/// Converts a `file` URI to a path. FMI 2.0 specifies the resources folder as a `file` URI; text
/// without the prefix `file:` is used as a path.
pub(crate) fn path_of(uri: &str) -> PathBuf {
    let Some(rest) = uri.strip_prefix("file:") else { return PathBuf::from(uri) };
    // `file:/a`, `file:///a` and `file://localhost/a` denote the same path.
    let rest = match rest.strip_prefix("//") {
        Some(after) => after.find('/').map_or(after, |slash| &after[slash..]),
        None => rest,
    };
    let digit = |byte: Option<&u8>| char::from(*byte?).to_digit(16);
    let (bytes, mut plain, mut k) = (rest.as_bytes(), Vec::new(), 0);
    while k < bytes.len() {
        let coded = (bytes[k] == b'%')
            .then(|| Some(16 * digit(bytes.get(k + 1))? + digit(bytes.get(k + 2))?))
            .flatten();
        plain.push(coded.map_or(bytes[k], |code| code as u8));
        k += if coded.is_some() { 3 } else { 1 };
    }
    let path = String::from_utf8_lossy(&plain).into_owned();
    // `file:///C:/a` denotes the path `C:/a`.
    let is_drive = path.len() > 2 && path.starts_with('/') && path.as_bytes()[2] == b':';
    PathBuf::from(if is_drive { path[1..].to_owned() } else { path })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_of_files_are_paths() {
        for (uri, path) in [
            ("file:///tmp/a%20b/resources", "/tmp/a b/resources"),
            ("file:/tmp/resources/", "/tmp/resources/"),
            ("file://localhost/tmp/%C3%BC", "/tmp/\u{fc}"),
            ("file:///C:/unit/resources", "C:/unit/resources"),
            ("/tmp/100%", "/tmp/100%"),
            ("file:///tmp/100%", "/tmp/100%"),
        ] {
            assert_eq!(path_of(uri), PathBuf::from(path), "{uri}");
        }
    }
}
