//! Definition of the C functions that save, restore and serialise states of an instance. FMI 2.0
//! and 3.0 have the same functions under different names.

/// Defines the functions that save, restore, free and serialise states, under the given names.
macro_rules! state_functions {
    ($get:ident $set:ident $free:ident $size:ident $serialize:ident $deserialize:ident) => {
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(instance: Handle, state: *mut State) -> c_int {
            unsafe { with(instance, |instance| boundary::give(state, instance.save())) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(instance: Handle, state: State) -> c_int {
            unsafe {
                with(instance, |instance| {
                    instance.restore(boundary::state(state)?);
                    Ok(())
                })
            }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $free(_instance: Handle, state: *mut State) -> c_int {
            unsafe { boundary::free_state(state) };
            0
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $size(instance: Handle, state: State, size: *mut usize) -> c_int {
            unsafe {
                with(instance, |instance| {
                    put(size, instance.write(boundary::state(state)?).len());
                    Ok(())
                })
            }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $serialize(
            instance: Handle,
            state: State,
            bytes: *mut u8,
            size: usize,
        ) -> c_int {
            unsafe {
                with(instance, |instance| {
                    let written = instance.write(boundary::state(state)?);
                    boundary::copy(&written, array_mut(bytes, size)?)
                })
            }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $deserialize(
            instance: Handle,
            bytes: *const u8,
            size: usize,
            state: *mut State,
        ) -> c_int {
            unsafe {
                with(instance, |instance| {
                    let saved: Saved = instance.read(array(bytes, size)?)?;
                    boundary::give(state, saved)
                })
            }
        }
    };
}

pub(crate) use state_functions;
