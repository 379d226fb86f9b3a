//! An importer of FMUs for the tests: extracted files, instances of both FMI versions, and
//! messages.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::PathBuf;
use std::ptr::{self, null, null_mut};
use std::{env, fs, process};
use stiction::{Fmi, PlantExport};
use stiction_fmu::fmi2::{self, Callbacks};
use stiction_fmu::{Logger2, fmi3};

pub(crate) const OK: c_int = 0;
pub(crate) const ERROR: c_int = 3;

/// Files of a unit in a folder, which is removed at the end.
pub(crate) struct Extracted {
    folder: PathBuf,
    /// Names of the variables in the order of their value references.
    names: Vec<String>,
    token: CString,
}

impl Extracted {
    pub(crate) fn new(name: &str, export: &PlantExport) -> Self {
        let folder = env::temp_dir().join(format!("stiction-fmu-test-{name}-{}", process::id()));
        let unit = export.fmu(Fmi::Three).unwrap();
        let mut xml = String::new();
        for file in &unit.files {
            let path = folder.join(&file.name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, &file.text).unwrap();
            if file.name == "modelDescription.xml" {
                xml.clone_from(&file.text);
            }
        }
        let attribute = |line: &str, key: &str| {
            let at = line.find(&format!("{key}=\"")).unwrap() + key.len() + 2;
            line[at..].split('"').next().unwrap().to_owned()
        };
        let variables =
            xml.lines().filter(|line| line.contains("<Float64") || line.contains("<Int32"));
        let mut names = Vec::new();
        for variable in variables {
            assert_eq!(attribute(variable, "valueReference"), names.len().to_string());
            names.push(attribute(variable, " name"));
        }
        let token = CString::new(attribute(&xml, "instantiationToken")).unwrap();
        Self { folder, names, token }
    }

    pub(crate) fn reference(&self, name: &str) -> u32 {
        let found = self.names.iter().position(|known| known == name);
        u32::try_from(found.unwrap_or_else(|| panic!("no variable {name}"))).unwrap()
    }

    pub(crate) fn count(&self) -> u32 {
        u32::try_from(self.names.len()).unwrap()
    }

    fn resources(&self) -> String {
        self.folder.join("resources").display().to_string()
    }
}

impl Drop for Extracted {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// Version and options of an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Version {
    Two,
    Three { events: bool },
}

/// An instance with the messages that it sent.
pub(crate) struct Importer<'a> {
    pub(crate) unit: &'a Extracted,
    pub(crate) version: Version,
    pub(crate) handle: *mut c_void,
    messages: Box<RefCell<Vec<String>>>,
    /// Callbacks, to which an FMI 2.0 instance keeps a pointer.
    _callbacks: Box<Callbacks>,
}

/// Receives messages of FMI 2.0 whose format is `%s`.
///
/// The C function has variable arguments. On the platforms of the tests, a pointer among them is passed like a
/// declared one.
unsafe extern "C" fn logger2(
    environment: *mut c_void,
    _name: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
    message: *const c_char,
) {
    assert_eq!(unsafe { CStr::from_ptr(format) }.to_bytes(), b"%s");
    unsafe { logger3(environment, status, category, message) }
}

unsafe extern "C" fn logger3(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    let messages = unsafe { &*environment.cast::<RefCell<Vec<String>>>() };
    let [category, message] =
        [category, message].map(|text| unsafe { CStr::from_ptr(text) }.to_string_lossy());
    messages.borrow_mut().push(format!("{status} {category}: {message}"));
}

impl<'a> Importer<'a> {
    /// Creates an instance, before its initialisation.
    pub(crate) fn new(unit: &'a Extracted, version: Version) -> Self {
        let token = unit.token.clone();
        let importer = Self::with_token(unit, version, &token);
        assert!(!importer.handle.is_null(), "{:?}", importer.messages());
        importer
    }

    pub(crate) fn with_token(unit: &'a Extracted, version: Version, token: &CStr) -> Self {
        let messages = Box::new(RefCell::new(Vec::new()));
        let environment = ptr::from_ref(&*messages).cast_mut().cast::<c_void>();
        type Plain = unsafe extern "C" fn(
            *mut c_void,
            *const c_char,
            c_int,
            *const c_char,
            *const c_char,
            *const c_char,
        );
        let logger: Logger2 = unsafe { std::mem::transmute::<Plain, Logger2>(logger2) };
        let callbacks = Box::new(Callbacks {
            logger: Some(logger),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            environment,
        });
        let name = c"instance".as_ptr();
        let handle = unsafe {
            match version {
                Version::Two => {
                    let uri = format!("file://{}", unit.resources().replace(' ', "%20"));
                    let uri = CString::new(uri).unwrap();
                    let (guid, uri) = (token.as_ptr(), uri.as_ptr());
                    fmi2::fmi2Instantiate(name, 1, guid, uri, &raw const *callbacks, 0, 1)
                }
                Version::Three { events } => {
                    let path = CString::new(unit.resources()).unwrap();
                    let (token, path) = (token.as_ptr(), path.as_ptr());
                    fmi3::fmi3InstantiateCoSimulation(
                        name,
                        token,
                        path,
                        false,
                        true,
                        events,
                        events,
                        null(),
                        0,
                        environment,
                        Some(logger3),
                        null(),
                    )
                }
            }
        };
        Self { unit, version, handle, messages, _callbacks: callbacks }
    }

    pub(crate) fn messages(&self) -> Vec<String> {
        self.messages.borrow().clone()
    }

    /// The last message.
    pub(crate) fn said(&self) -> String {
        self.messages.borrow().last().cloned().unwrap_or_default()
    }

    pub(crate) fn enter(&self, start: f64) {
        let status = unsafe {
            match self.version {
                Version::Two => {
                    assert_eq!(fmi2::fmi2SetupExperiment(self.handle, 0, 0.0, start, 0, 0.0), OK);
                    fmi2::fmi2EnterInitializationMode(self.handle)
                }
                Version::Three { .. } => {
                    fmi3::fmi3EnterInitializationMode(self.handle, false, 0.0, start, false, 0.0)
                }
            }
        };
        assert_eq!(status, OK, "{}", self.said());
    }

    pub(crate) fn exit(&self) -> c_int {
        unsafe {
            match self.version {
                Version::Two => fmi2::fmi2ExitInitializationMode(self.handle),
                Version::Three { events } => {
                    let status = fmi3::fmi3ExitInitializationMode(self.handle);
                    if events && status == OK { self.handle_event() } else { status }
                }
            }
        }
    }

    /// Enters and leaves event mode without any change.
    pub(crate) fn handle_event(&self) -> c_int {
        let mut flags = [true; 5];
        let mut time = 1.0;
        let [a, b, c, d, e] = &mut flags;
        let status =
            unsafe { fmi3::fmi3UpdateDiscreteStates(self.handle, a, b, c, d, e, &mut time) };
        assert_eq!((status, flags), (OK, [false; 5]), "{}", self.said());
        unsafe { fmi3::fmi3EnterStepMode(self.handle) }
    }

    pub(crate) fn set_by(&self, reference: u32, value: f64) -> c_int {
        let (references, values) = (&raw const reference, &raw const value);
        unsafe {
            match self.version {
                Version::Two => fmi2::fmi2SetReal(self.handle, references, 1, values),
                Version::Three { .. } => {
                    fmi3::fmi3SetFloat64(self.handle, references, 1, values, 1)
                }
            }
        }
    }

    pub(crate) fn set(&self, name: &str, value: f64) {
        let status = self.set_by(self.unit.reference(name), value);
        assert_eq!(status, OK, "{name}: {}", self.said());
    }

    pub(crate) fn get_by(&self, reference: u32) -> Result<f64, c_int> {
        let mut value = f64::NAN;
        let (references, values) = (&raw const reference, &raw mut value);
        let status = unsafe {
            match self.version {
                Version::Two => fmi2::fmi2GetReal(self.handle, references, 1, values),
                Version::Three { .. } => {
                    fmi3::fmi3GetFloat64(self.handle, references, 1, values, 1)
                }
            }
        };
        if status == OK { Ok(value) } else { Err(status) }
    }

    pub(crate) fn get(&self, name: &str) -> f64 {
        let value = self.get_by(self.unit.reference(name));
        value.unwrap_or_else(|status| panic!("{name}: {status}, {}", self.said()))
    }

    pub(crate) fn integer_by(&self, reference: u32) -> Result<i32, c_int> {
        let mut value = -1;
        let (references, values) = (&raw const reference, &raw mut value);
        let status = unsafe {
            match self.version {
                Version::Two => fmi2::fmi2GetInteger(self.handle, references, 1, values),
                Version::Three { .. } => fmi3::fmi3GetInt32(self.handle, references, 1, values, 1),
            }
        };
        if status == OK { Ok(value) } else { Err(status) }
    }

    pub(crate) fn integer(&self, name: &str) -> i32 {
        self.integer_by(self.unit.reference(name)).unwrap_or_else(|_| panic!("{}", self.said()))
    }

    /// Takes a step. Returns the time that was reached and two flags: event, and early return.
    pub(crate) fn try_step(&self, time: f64, size: f64) -> Result<(f64, bool, bool), c_int> {
        let mut end = (time + size, false, false);
        let mut terminate = true;
        let status = unsafe {
            match self.version {
                Version::Two => fmi2::fmi2DoStep(self.handle, time, size, 1),
                Version::Three { .. } => {
                    let (reached, event, early) = (&mut end.0, &mut end.1, &mut end.2);
                    fmi3::fmi3DoStep(
                        self.handle,
                        time,
                        size,
                        true,
                        event,
                        &mut terminate,
                        early,
                        reached,
                    )
                }
            }
        };
        if status == OK { Ok(end) } else { Err(status) }
    }

    pub(crate) fn step(&self, time: f64, size: f64) -> (f64, bool, bool) {
        self.try_step(time, size).unwrap_or_else(|_| panic!("{}", self.said()))
    }

    pub(crate) fn get_state(&self) -> *mut c_void {
        let mut state = null_mut();
        let status = unsafe {
            match self.version {
                Version::Two => fmi2::fmi2GetFMUstate(self.handle, &raw mut state),
                Version::Three { .. } => fmi3::fmi3GetFMUState(self.handle, &raw mut state),
            }
        };
        assert_eq!(status, OK, "{}", self.said());
        state
    }

    pub(crate) fn set_state(&self, state: *mut c_void) -> c_int {
        unsafe {
            match self.version {
                Version::Two => fmi2::fmi2SetFMUstate(self.handle, state),
                Version::Three { .. } => fmi3::fmi3SetFMUState(self.handle, state),
            }
        }
    }

    pub(crate) fn free_state(&self, mut state: *mut c_void) {
        unsafe { fmi3::fmi3FreeFMUState(self.handle, &raw mut state) };
        assert!(state.is_null());
    }

    pub(crate) fn serialize(&self, state: *mut c_void) -> Vec<u8> {
        let mut size = 0;
        unsafe {
            assert_eq!(fmi3::fmi3SerializedFMUStateSize(self.handle, state, &raw mut size), OK);
            let mut bytes = vec![0; size];
            let status = match self.version {
                Version::Two => {
                    fmi2::fmi2SerializeFMUstate(self.handle, state, bytes.as_mut_ptr(), size)
                }
                Version::Three { .. } => {
                    fmi3::fmi3SerializeFMUState(self.handle, state, bytes.as_mut_ptr(), size)
                }
            };
            assert_eq!(status, OK, "{}", self.said());
            bytes
        }
    }

    pub(crate) fn deserialize(&self, bytes: &[u8]) -> Result<*mut c_void, c_int> {
        let mut state = null_mut();
        let (first, size) = (bytes.as_ptr(), bytes.len());
        let status = unsafe {
            match self.version {
                Version::Two => {
                    fmi2::fmi2DeSerializeFMUstate(self.handle, first, size, &raw mut state)
                }
                Version::Three { .. } => {
                    fmi3::fmi3DeserializeFMUState(self.handle, first, size, &raw mut state)
                }
            }
        };
        if status == OK { Ok(state) } else { Err(status) }
    }
}

impl Drop for Importer<'_> {
    fn drop(&mut self) {
        unsafe {
            match self.version {
                Version::Two => fmi2::fmi2FreeInstance(self.handle),
                Version::Three { .. } => fmi3::fmi3FreeInstance(self.handle),
            }
        }
    }
}
