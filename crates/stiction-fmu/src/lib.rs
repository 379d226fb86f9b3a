//! The library inside plant FMUs. It provides forward dynamics with stick and slip through the C
//! functions of the Functional Mock-up Interface (FMI), versions 2.0 and 3.0, for co-simulation.
//!
//! The library reads the model from the folder `resources` of the FMU, so the same library is used
//! for all models. The functions follow the specifications FMI 2.0.5 and 3.0.2 of the Modelica
//! Association.
//!
//! All data belong to an instance (module `instance`): there are no global variables, and instances
//! on different threads are independent. The module `boundary` converts pointers to references, and
//! errors and panics to the statuses of the standard. A call that is not possible returns *Error*
//! with a message for the importer's logger. After a panic, all further calls of the instance
//! return *Fatal*.

mod boundary;
pub mod fmi2;
pub mod fmi3;
mod instance;
mod logger;
mod saved_states;

pub use logger::{Logger2, Logger3};

/// Text with the version of this library. `stiction export` recognises the library by this text in
/// the binary.
#[used]
static VERSION: [u8; MARK.len()] = {
    let mut bytes = [0; MARK.len()];
    let mut k = 0;
    while k < bytes.len() {
        bytes[k] = MARK.as_bytes()[k];
        k += 1;
    }
    bytes
};

const MARK: &str = concat!("stiction-fmu version ", env!("CARGO_PKG_VERSION"), ";");
