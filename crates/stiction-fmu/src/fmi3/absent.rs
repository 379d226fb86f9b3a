//! C functions of FMI 3.0 for features that this FMU does not have: variables of types other than
//! `Float64` and `Int32`, clocks, derivatives, model exchange. Importers expect the symbols in the
//! library; the functions return an error and send a message.

use super::{Handle, Text};
use crate::boundary::with;
use std::ffi::c_int;
use stiction::Error;

type References = *const u32;

/// Defines functions that get and set variables of types that do not occur in this FMU. They
/// succeed only for zero variables.
macro_rules! no_variables {
    ($($name:ident($values:ty);)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            instance: Handle,
            _references: References,
            reference_count: usize,
            _values: $values,
            count: usize,
        ) -> c_int {
            unsafe {
                with(instance, |_| match reference_count + count {
                    0 => Ok(()),
                    _ => Err(Error::input("this FMU has no variables of this type")),
                })
            }
        }
    )*};
}

no_variables! {
    fmi3GetFloat32(*mut f32);
    fmi3SetFloat32(*const f32);
    fmi3GetInt8(*mut i8);
    fmi3SetInt8(*const i8);
    fmi3GetUInt8(*mut u8);
    fmi3SetUInt8(*const u8);
    fmi3GetInt16(*mut i16);
    fmi3SetInt16(*const i16);
    fmi3GetUInt16(*mut u16);
    fmi3SetUInt16(*const u16);
    fmi3GetUInt32(*mut u32);
    fmi3SetUInt32(*const u32);
    fmi3GetInt64(*mut i64);
    fmi3SetInt64(*const i64);
    fmi3GetUInt64(*mut u64);
    fmi3SetUInt64(*const u64);
    fmi3GetBoolean(*mut bool);
    fmi3SetBoolean(*const bool);
    fmi3GetString(*mut Text);
    fmi3SetString(*const Text);
}

/// Defines functions for capabilities that `modelDescription.xml` does not declare. They always
/// return an error.
macro_rules! refused {
    ($($name:ident($($argument:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: Handle $(, _: $argument)*) -> c_int {
            unsafe {
                with(instance, |_| {
                    Err(Error::input(concat!("`", stringify!($name), "` is not provided"))
                        .with_help("see the capabilities in modelDescription.xml"))
                })
            }
        }
    )*};
}

refused! {
    fmi3GetBinary(References, usize, *mut usize, *mut *const u8, usize);
    fmi3SetBinary(References, usize, *const usize, *const *const u8, usize);
    fmi3GetClock(References, usize, *mut bool);
    fmi3SetClock(References, usize, *const bool);
    fmi3GetNumberOfVariableDependencies(u32, *mut usize);
    fmi3GetVariableDependencies(u32, *mut usize, *mut u32, *mut usize, *mut c_int, usize);
    fmi3GetDirectionalDerivative(References, usize, References, usize, *const f64, usize, *mut f64, usize);
    fmi3GetAdjointDerivative(References, usize, References, usize, *const f64, usize, *mut f64, usize);
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3GetIntervalDecimal(References, usize, *mut f64, *mut c_int);
    fmi3GetIntervalFraction(References, usize, *mut u64, *mut u64, *mut c_int);
    fmi3GetShiftDecimal(References, usize, *mut f64);
    fmi3GetShiftFraction(References, usize, *mut u64, *mut u64);
    fmi3SetIntervalDecimal(References, usize, *const f64);
    fmi3SetIntervalFraction(References, usize, *const u64, *const u64);
    fmi3SetShiftDecimal(References, usize, *const f64);
    fmi3SetShiftFraction(References, usize, *const u64, *const u64);
    fmi3EvaluateDiscreteStates();
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(bool, *mut bool, *mut bool);
    fmi3SetTime(f64);
    fmi3SetContinuousStates(*const f64, usize);
    fmi3GetContinuousStateDerivatives(*mut f64, usize);
    fmi3GetEventIndicators(*mut f64, usize);
    fmi3GetContinuousStates(*mut f64, usize);
    fmi3GetNominalsOfContinuousStates(*mut f64, usize);
    fmi3GetNumberOfEventIndicators(*mut usize);
    fmi3GetNumberOfContinuousStates(*mut usize);
    fmi3GetOutputDerivatives(References, usize, *const i32, *mut f64, usize);
    fmi3ActivateModelPartition(u32, f64);
}
