//! C functions of FMI 3.0 for co-simulation, with the names and types of the standard.
//!
//! # Safety
//! Pointers must be valid as the standard requires: instances and states of this library that are
//! not freed, and arrays and texts of the stated length.

// The standard defines the names and documents the functions. Every function has the safety
// contract stated above, and passes its pointers on to `boundary`.
#![allow(unsafe_code, non_snake_case, missing_docs, clippy::missing_safety_doc)]
#![allow(clippy::too_many_arguments)]

mod absent;

pub use absent::*;

use crate::boundary::{self, array, array_mut, put, text, with};
use crate::instance::{Instance, Phase, Saved};
use crate::logger::{Logger, Logger3};
use crate::saved_states::state_functions;
use std::ffi::{c_char, c_int, c_void};
use std::path::Path;
use stiction::Error;

type Handle = *mut c_void;
type State = *mut c_void;
type Text = *const c_char;

#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> Text {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: Handle,
    on: bool,
    _count: usize,
    _categories: *const Text,
) -> c_int {
    unsafe {
        with(instance, |instance| {
            instance.logging = on;
            Ok(())
        })
    }
}

fn other_kind(function: Option<Logger3>, environment: *mut c_void) -> Handle {
    boundary::instantiate(Logger::Three { function, environment }, || {
        Err(Error::input("this FMU is for co-simulation only"))
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _name: Text,
    _token: Text,
    _resources: Text,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    logger: Option<Logger3>,
) -> Handle {
    other_kind(logger, environment)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _name: Text,
    _token: Text,
    _resources: Text,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    logger: Option<Logger3>,
    _clock: *const c_void,
    _lock: *const c_void,
    _unlock: *const c_void,
) -> Handle {
    other_kind(logger, environment)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: Text,
    token: Text,
    resources: Text,
    _visible: bool,
    logging: bool,
    event_mode: bool,
    early_return: bool,
    _intermediate: *const u32,
    _count: usize,
    environment: *mut c_void,
    logger: Option<Logger3>,
    _update: *const c_void,
) -> Handle {
    boundary::instantiate(Logger::Three { function: logger, environment }, || {
        let token = unsafe { text(token, "the instantiation token") }?;
        let path = Path::new(unsafe { text(resources, "the path of the folder `resources`") }?);
        Instance::new(path, token, (event_mode, early_return), logging)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: Handle) {
    unsafe { boundary::free(instance) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: Handle,
    _has_tolerance: bool,
    _tolerance: f64,
    start: f64,
    _has_stop: bool,
    _stop: f64,
) -> c_int {
    unsafe {
        with(instance, |instance| {
            instance.set_start_time(start)?;
            instance.go(&[Phase::Instantiated], Phase::Initializing)
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: Handle) -> c_int {
    unsafe { with(instance, Instance::exit_initialization) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(instance: Handle) -> c_int {
    unsafe { with(instance, |i| i.go(&[Phase::Stepping], Phase::Event)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterStepMode(instance: Handle) -> c_int {
    unsafe { with(instance, |i| i.go(&[Phase::Event], Phase::Stepping)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    instance: Handle,
    needs_update: *mut bool,
    terminate: *mut bool,
    nominals_changed: *mut bool,
    values_changed: *mut bool,
    next_event_defined: *mut bool,
    next_event: *mut f64,
) -> c_int {
    unsafe {
        with(instance, |instance| {
            instance.expect(&[Phase::Event])?;
            for flag in
                [needs_update, terminate, nominals_changed, values_changed, next_event_defined]
            {
                put(flag, false);
            }
            put(next_event, 0.0);
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: Handle) -> c_int {
    unsafe { with(instance, |i| i.go(&[Phase::Stepping, Phase::Event], Phase::Terminated)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: Handle) -> c_int {
    unsafe {
        with(instance, |instance| {
            instance.reset();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: Handle,
    time: f64,
    size: f64,
    _no_set_state_before: bool,
    event: *mut bool,
    terminate: *mut bool,
    early_return: *mut bool,
    last_time: *mut f64,
) -> c_int {
    unsafe {
        with(instance, |instance| {
            put(event, false);
            put(terminate, false);
            put(early_return, false);
            put(last_time, instance.time());
            let end = instance.step(time, size)?;
            put(event, end.event);
            put(early_return, end.early);
            put(last_time, end.time);
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: Handle,
    references: *const u32,
    count: usize,
    values: *mut f64,
    value_count: usize,
) -> c_int {
    unsafe {
        with(instance, |i| i.reals(array(references, count)?, array_mut(values, value_count)?))
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: Handle,
    references: *const u32,
    count: usize,
    values: *const f64,
    value_count: usize,
) -> c_int {
    unsafe {
        with(instance, |i| i.set_reals(array(references, count)?, array(values, value_count)?))
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt32(
    instance: Handle,
    references: *const u32,
    count: usize,
    values: *mut i32,
    value_count: usize,
) -> c_int {
    unsafe {
        with(instance, |i| i.integers(array(references, count)?, array_mut(values, value_count)?))
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt32(
    instance: Handle,
    references: *const u32,
    count: usize,
    _values: *const i32,
    _value_count: usize,
) -> c_int {
    unsafe { with(instance, |i| i.set_integers(array(references, count)?)) }
}

state_functions! {
    fmi3GetFMUState fmi3SetFMUState fmi3FreeFMUState fmi3SerializedFMUStateSize fmi3SerializeFMUState
    fmi3DeserializeFMUState
}
