//! Messages to the importer through the logger callbacks of FMI 2.0 and 3.0.

#![allow(unsafe_code)]

use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr;

/// Type `fmi2CallbackLogger` of FMI 2.0. The arguments are the environment, the name of the
/// instance, the status, the category, a `printf` format, and the arguments of the format.
pub type Logger2 =
    unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// Type `fmi3LogMessageCallback` of FMI 3.0. The arguments are the environment, the status, the
/// category, and the message, which is not a format.
pub type Logger3 = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// Status of a call, with the numbers of `fmi2Status` and `fmi3Status`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Status {
    Ok = 0,
    Error = 3,
    Fatal = 4,
}

/// Callback of the importer that receives messages, if there is one.
#[derive(Debug)]
pub(crate) enum Logger {
    Two { function: Option<Logger2>, environment: *mut c_void, name: CString },
    Three { function: Option<Logger3>, environment: *mut c_void },
}

impl Logger {
    /// Sends a message to the importer.
    pub(crate) fn say(&self, status: Status, category: &str, message: &str) {
        let (category, message) = (c_string(category), c_string(message));
        match self {
            Self::Two { function: Some(function), environment, name } => {
                let format = c"%s".as_ptr();
                // SAFETY: the importer gave the function with this type and the environment for it. All strings
                // end in zero and outlive the call. The message is an argument, not a format.
                unsafe {
                    function(
                        *environment,
                        name.as_ptr(),
                        status as c_int,
                        category.as_ptr(),
                        format,
                        message.as_ptr(),
                    );
                }
            }
            Self::Three { function: Some(function), environment } => {
                // SAFETY: the importer gave the function with this type and the environment for it.
                // All strings end in zero and outlive the call.
                unsafe {
                    function(*environment, status as c_int, category.as_ptr(), message.as_ptr());
                }
            }
            _ => {}
        }
    }

    /// Creates a logger without a callback, which discards all messages.
    pub(crate) fn none() -> Self {
        Self::Three { function: None, environment: ptr::null_mut() }
    }
}

/// Converts text to a C string; zero characters in the text are omitted.
pub(crate) fn c_string(text: &str) -> CString {
    let bytes: Vec<u8> = text.bytes().filter(|byte| *byte != 0).collect();
    CString::new(bytes).unwrap_or_default()
}
