//! C functions of FMI 2.0 for co-simulation, with the names and types of the standard.
//!
//! # Safety
//! Pointers must be valid as the standard requires: instances and states of this library that are
//! not freed, and arrays and texts of the stated length.

// The standard defines the names and documents the functions. Every function has the safety
// contract stated above, and passes its pointers on to `boundary`.
#![allow(unsafe_code, non_snake_case, missing_docs, clippy::missing_safety_doc)]
#![allow(clippy::too_many_arguments)]

use crate::boundary::{self, array, array_mut, missing, put, text, with};
use crate::instance::{Instance, Phase, Saved};
use crate::logger::{Logger, Logger2, c_string};
use crate::saved_states::state_functions;
use std::ffi::{c_char, c_int, c_void};
use stiction::Error;

type Handle = *mut c_void;
type State = *mut c_void;
type Text = *const c_char;

/// C structure `fmi2CallbackFunctions` of the standard.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Callbacks {
    pub logger: Option<Logger2>,
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    pub environment: *mut c_void,
}

/// Value `fmi2CoSimulation` of the enumeration `fmi2Type`.
const CO_SIMULATION: c_int = 1;
/// Value `fmi2Discard` of the enumeration `fmi2Status`.
const DISCARD: c_int = 2;
/// Values `fmi2LastSuccessfulTime` and `fmi2Terminated` of the enumeration `fmi2StatusKind`.
const LAST_TIME: c_int = 2;
const TERMINATED: c_int = 3;

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> Text {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> Text {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    instance: Handle,
    on: c_int,
    _count: usize,
    _categories: *const Text,
) -> c_int {
    unsafe {
        with(instance, |instance| {
            instance.logging = on != 0;
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: Text,
    kind: c_int,
    guid: Text,
    resources: Text,
    functions: *const Callbacks,
    _visible: c_int,
    logging: c_int,
) -> Handle {
    let functions = unsafe { functions.as_ref() };
    let plain = unsafe { text(name, "the name of the instance") }.unwrap_or_default();
    let logger = Logger::Two {
        function: functions.and_then(|functions| functions.logger),
        environment: functions.map_or(std::ptr::null_mut(), |functions| functions.environment),
        name: c_string(plain),
    };
    boundary::instantiate(logger, || {
        if kind != CO_SIMULATION {
            return Err(Error::input("this FMU is for co-simulation only"));
        }
        let guid = unsafe { text(guid, "the GUID") }?;
        let resources = unsafe { text(resources, "the location of the folder `resources`") }?;
        Instance::new(&boundary::path_of(resources), guid, (false, false), logging != 0)
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(instance: Handle) {
    unsafe { boundary::free(instance) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    instance: Handle,
    _has_tolerance: c_int,
    _tolerance: f64,
    start: f64,
    _has_stop: c_int,
    _stop: f64,
) -> c_int {
    unsafe { with(instance, |instance| instance.set_start_time(start)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(instance: Handle) -> c_int {
    unsafe { with(instance, |i| i.go(&[Phase::Instantiated], Phase::Initializing)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(instance: Handle) -> c_int {
    unsafe { with(instance, Instance::exit_initialization) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(instance: Handle) -> c_int {
    unsafe { with(instance, |i| i.go(&[Phase::Stepping], Phase::Terminated)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(instance: Handle) -> c_int {
    unsafe {
        with(instance, |instance| {
            instance.reset();
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    instance: Handle,
    references: *const u32,
    count: usize,
    values: *mut f64,
) -> c_int {
    unsafe { with(instance, |i| i.reals(array(references, count)?, array_mut(values, count)?)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    instance: Handle,
    references: *const u32,
    count: usize,
    values: *const f64,
) -> c_int {
    unsafe { with(instance, |i| i.set_reals(array(references, count)?, array(values, count)?)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(
    instance: Handle,
    references: *const u32,
    count: usize,
    values: *mut c_int,
) -> c_int {
    unsafe { with(instance, |i| i.integers(array(references, count)?, array_mut(values, count)?)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    instance: Handle,
    references: *const u32,
    count: usize,
    _values: *const c_int,
) -> c_int {
    unsafe { with(instance, |i| i.set_integers(array(references, count)?)) }
}

/// Defines functions that get and set variables of types that do not occur in this FMU. They
/// succeed only for zero variables.
macro_rules! absent {
    ($($name:ident($values:ty);)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            instance: Handle,
            _references: *const u32,
            count: usize,
            _values: $values,
        ) -> c_int {
            unsafe {
                with(instance, |_| match count {
                    0 => Ok(()),
                    _ => Err(Error::input("this FMU has no variables of this type")),
                })
            }
        }
    )*};
}

absent! {
    fmi2GetBoolean(*mut c_int);
    fmi2SetBoolean(*const c_int);
    fmi2GetString(*mut Text);
    fmi2SetString(*const Text);
}

state_functions! {
    fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate fmi2SerializedFMUstateSize fmi2SerializeFMUstate
    fmi2DeSerializeFMUstate
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    instance: Handle,
    _unknowns: *const u32,
    _unknown_count: usize,
    _knowns: *const u32,
    _known_count: usize,
    _seed: *const f64,
    _sensitivity: *mut f64,
) -> c_int {
    unsafe {
        with(instance, |_| Err(Error::input("this FMU does not provide directional derivatives")))
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    instance: Handle,
    _references: *const u32,
    _count: usize,
    _orders: *const c_int,
    _values: *const f64,
) -> c_int {
    unsafe {
        with(instance, |_| {
            Err(Error::input(
                "this FMU holds inputs constant during a step, so \
        their derivatives cannot be set",
            ))
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    instance: Handle,
    _references: *const u32,
    _count: usize,
    _orders: *const c_int,
    _values: *mut f64,
) -> c_int {
    unsafe {
        with(instance, |_| Err(Error::input("this FMU does not provide derivatives of outputs")))
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    instance: Handle,
    time: f64,
    size: f64,
    _no_set_state_before: c_int,
) -> c_int {
    unsafe { with(instance, |instance| instance.step(time, size).map(|_| ())) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(instance: Handle) -> c_int {
    unsafe {
        with(instance, |_| {
            Err(Error::input(
                "there is no step to cancel: fmi2DoStep returns \
        when the step is complete",
            ))
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(
    instance: Handle,
    kind: c_int,
    value: *mut f64,
) -> c_int {
    if kind != LAST_TIME {
        return DISCARD;
    }
    unsafe {
        with(instance, |instance| {
            if value.is_null() {
                return Err(missing("the pointer to the value"));
            }
            put(value, instance.time());
            Ok(())
        })
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    instance: Handle,
    kind: c_int,
    value: *mut c_int,
) -> c_int {
    if kind != TERMINATED {
        return DISCARD;
    }
    unsafe {
        with(instance, |_| {
            put(value, 0);
            Ok(())
        })
    }
}

/// Defines the status functions that the standard provides only for asynchronous steps. They return
/// `fmi2Discard`, because steps of this FMU are synchronous.
macro_rules! discarded {
    ($($name:ident($value:ty);)*) => {$(
        #[unsafe(no_mangle)]
        pub extern "C" fn $name(_instance: Handle, _kind: c_int, _value: $value) -> c_int {
            DISCARD
        }
    )*};
}

discarded! {
    fmi2GetStatus(*mut c_int);
    fmi2GetIntegerStatus(*mut c_int);
    fmi2GetStringStatus(*mut Text);
}
