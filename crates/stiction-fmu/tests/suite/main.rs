//! Plant FMUs through their C functions.

#![allow(unsafe_code)]

mod against_forward;
mod at_rest;
mod by_names;
mod importer;
mod loads;
mod recordings;
mod starts;
mod states;
mod wrong_calls;
