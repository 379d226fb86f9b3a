//! Plant FMUs through their C functions.

#![allow(unsafe_code)]

mod against_forward;
mod by_names;
mod importer;
mod loads;
mod recordings;
mod states;
mod wrong_calls;
