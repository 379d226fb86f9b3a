//! Reads motions, loads, efforts and controllers that are given outside the model file: by name, in
//! a file, or as assignments. Also reads stop conditions.

use super::actuators::Actuators;
use super::context::Context;
use super::motion::{self, Files};
use super::names::Names;
use super::path::Orders;
use super::recording::{self, Input};
use super::{assignments, control, drives, load, measured};
use crate::contents::Contents;
use crate::diagnostic::{Diagnostic, Diagnostics, did_you_mean, quoted};
use crate::document::{self, Document, Table};
use crate::law::Condition;
use crate::model_file::{Control, Drives, LoadCase, ModelFile, Motion};
use crate::source::{Place, Source, Span};
use std::sync::Arc;

/// Forms in which the text of an option specifies a motion, load, effort or controller.
enum Given<'a> {
    Assignments,
    File(&'a str),
    Name(&'a str),
}

fn kind(text: &str) -> Given<'_> {
    let text = text.trim();
    let lower = text.to_lowercase();
    let is_file = [".csv", ".toml", ".txt", ".npz", ".mcap"].iter().any(|end| lower.ends_with(end))
        || text.contains(['/', '\\']);
    match text {
        _ if is_file && !text.contains('=') => Given::File(text),
        _ if text.contains('=') || text.contains(';') => Given::Assignments,
        _ => Given::Name(text),
    }
}

impl ModelFile {
    /// Reads a motion from the text of an option: the name of one of the model's motions, a CSV or TOML file, or
    /// assignments such as `platform.x = 5 mm*sin(2*pi*t); platform.z = 0.5; duration = 2 s`. `given.name` is used in
    /// messages, for example `--motion`.
    ///
    /// # Errors
    /// All errors, each with its place.
    pub fn parse_motion(
        &self,
        given: &Source,
        files: &dyn Fn(&str) -> Result<Contents, String>,
    ) -> Result<Motion, Diagnostics> {
        let source = Arc::new(given.clone());
        match kind(&given.text) {
            Given::Name(name) => match self.motion(name) {
                // The motions of the model were filtered when the model was read.
                Some(motion) => Ok(motion.clone()),
                None => Err(unknown(&source, "motion", name, self.motions.iter().map(|(n, _)| n))),
            },
            Given::File(name) => self.motion_file(&source, name, files),
            Given::Assignments => self.assigned(&source, |context, names, table| {
                let read = motion::read(context, (names, Some(self.assembly())), table, files);
                read.map(|motion| with_doubts(context, motion))
            }),
        }
    }

    /// Reads a motion from a file: CSV samples, or (if its name ends in `.toml`) a TOML file with
    /// the content of a motion's table.
    ///
    /// # Errors
    /// All errors, each with its place.
    pub fn read_motion(
        &self,
        source: &Source,
        files: &dyn Fn(&str) -> Result<Contents, String>,
    ) -> Result<Motion, Diagnostics> {
        let source = Arc::new(source.clone());
        if is_toml(&source.name) {
            return self.motion_table(&source, files);
        }
        self.recording(&source, &Input::of_source(&source), |input, context, names| {
            recording::read(input, names, &Orders::new(), context, None)
        })
    }

    fn motion_file(
        &self,
        source: &Arc<Source>,
        name: &str,
        files: Files<'_>,
    ) -> Result<Motion, Diagnostics> {
        if is_toml(name) {
            let table = file(source, name, files)?.with_filter(source.filter());
            return self.motion_table(&Arc::new(table), files);
        }
        let contents = files(name).map_err(|reason| unreadable(source, &reason))?;
        self.recording(source, &Input::new(name, contents), |input, context, names| {
            recording::read(input, names, &Orders::new(), context, None)
        })
    }

    fn motion_table(&self, source: &Arc<Source>, files: Files<'_>) -> Result<Motion, Diagnostics> {
        self.document(source, |context, names, table| {
            let read = motion::read(context, (names, Some(self.assembly())), table, files);
            read.map(|motion| with_doubts(context, motion))
        })
    }

    fn assembly(&self) -> motion::Assembly<'_> {
        motion::Assembly { mechanism: &self.mechanism, initial_poses: &self.initial_poses }
    }

    /// Reads a recording from `input` with the function `read`. If the file cannot be read, the
    /// error is located in `source`, the text that names the file.
    fn recording<T>(
        &self,
        source: &Arc<Source>,
        input: &Input,
        read: impl FnOnce(&Input, &Context<'_>, &Names) -> Result<Option<T>, String>,
    ) -> Result<T, Diagnostics> {
        let mut failed = None;
        let result = self.reading(source, &[], |context, names| {
            read(input, context, names).unwrap_or_else(|reason| {
                failed = Some(reason);
                None
            })
        });
        match failed {
            Some(reason) => Err(unreadable(source, &reason)),
            None => result,
        }
    }

    /// Reads a load from the text of an option: the name of one of the model's loads, `none`, a
    /// TOML file, or assignments such as `platform.force = [20 N, 0, 0]; platform.mz = 3 N m`.
    ///
    /// # Errors
    /// All errors, each with its place.
    pub fn parse_load(
        &self,
        given: &Source,
        files: &dyn Fn(&str) -> Result<Contents, String>,
    ) -> Result<LoadCase, Diagnostics> {
        let source = Arc::new(given.clone());
        match kind(&given.text) {
            Given::Name(name) => match self.load(name) {
                Some(load) => Ok(load.clone()),
                None if name == "none" => Ok(LoadCase::default()),
                None => Err(unknown(&source, "load", name, self.loads.iter().map(|(n, _)| n))),
            },
            Given::File(name) => self.read_load(&file(&source, name, files)?),
            Given::Assignments => self
                .assigned(&source, |context, names, table| Some(load::read(context, names, table))),
        }
    }

    /// Reads a load from a TOML file with the content of a load's table.
    ///
    /// # Errors
    /// All errors, each with its place.
    pub fn read_load(&self, source: &Source) -> Result<LoadCase, Diagnostics> {
        let source = Arc::new(source.clone());
        self.document(&source, |context, names, table| Some(load::read(context, names, table)))
    }

    /// Reads efforts from the text of an option: `none`, a CSV or TOML file, or assignments such as
    /// `leg1.P = 50 N; leg2.P = 20 N*sin(2*pi*t)`, which may contain measured coordinates and their rates:
    /// `leg1.P = -2 kN/m*leg1.P - 80 N s/m*d(leg1.P)`.
    ///
    /// # Errors
    /// All errors, each with its place.
    pub fn parse_drives(
        &self,
        given: &Source,
        files: &dyn Fn(&str) -> Result<Contents, String>,
    ) -> Result<Drives, Diagnostics> {
        let source = Arc::new(given.clone());
        let actuators = Actuators::of(&self.mechanism);
        match kind(&given.text) {
            Given::Name("none") => Ok(Drives::default()),
            Given::Name(name) => Err(drives::unknown(&source, name)),
            Given::File(name) => {
                if is_toml(name) {
                    let source = Arc::new(file(&source, name, files)?);
                    return self.document(&source, |context, names, table| {
                        Some(drives::read(context, (names, &actuators), table))
                    });
                }
                let contents = files(name).map_err(|reason| unreadable(&source, &reason))?;
                self.recording(&source, &Input::new(name, contents), |input, context, _| {
                    recording::read_drives(input, &actuators, context)
                })
            }
            Given::Assignments => self.assigned(&source, |context, names, table| {
                Some(drives::read(context, (names, &actuators), table))
            }),
        }
    }

    /// Reads a controller from the text of an option: `pd`, `computed-torque` or
    /// `computed-torque+friction` with default settings, a TOML file, or assignments such as `type
    /// = pd; period = 2 ms; leg1.P.limit = 300 N`.
    ///
    /// # Errors
    /// All errors, each with its place.
    pub fn parse_control(
        &self,
        given: &Source,
        files: &dyn Fn(&str) -> Result<Contents, String>,
    ) -> Result<Control, Diagnostics> {
        let source = Arc::new(given.clone());
        let actuators = Actuators::of(&self.mechanism);
        match kind(&given.text) {
            Given::Name(name) => {
                control::usual(name, &actuators).ok_or_else(|| control::unknown(&source, name))
            }
            Given::File(name) => {
                let source = Arc::new(file(&source, name, files)?);
                self.document(&source, |context, _, table| {
                    control::read(context, &actuators, table)
                })
            }
            Given::Assignments => self
                .assigned(&source, |context, _, table| control::read(context, &actuators, table)),
        }
    }

    /// Reads a condition that ends a simulation, such as `platform.z < 100 mm` or `d(leg1.P) > 0.5 m/s`; it may
    /// contain the time `t`, coordinates and their rates.
    ///
    /// # Errors
    /// All errors, each with its place.
    pub fn parse_condition(&self, given: &Source) -> Result<Condition, Diagnostics> {
        let source = Arc::new(given.clone());
        let context = Context::new(&source, &self.parameters, &[]);
        measured::condition(&context, &Names::of(&self.mechanism), &source)
    }

    fn assigned<T>(
        &self,
        source: &Arc<Source>,
        read: impl FnOnce(&Context<'_>, &Names, &Table) -> Option<T>,
    ) -> Result<T, Diagnostics> {
        self.reading(source, &[], |context, names| {
            let table = assignments::read(context);
            read(context, names, &table)
        })
    }

    fn document<T>(
        &self,
        source: &Arc<Source>,
        read: impl FnOnce(&Context<'_>, &Names, &Table) -> Option<T>,
    ) -> Result<T, Diagnostics> {
        let mut out = Diagnostics::new();
        let Some(Document { root, broken }) = document::parse(source, &mut out) else {
            return Err(out);
        };
        let result = self.reading(source, &broken, |context, names| read(context, names, &root));
        match result {
            Ok(value) if !out.has_errors() => Ok(value),
            Ok(_) => Err(out),
            Err(more) => {
                out.append(more);
                out.sort();
                Err(out)
            }
        }
    }

    fn reading<T>(
        &self,
        source: &Arc<Source>,
        broken: &[Span],
        read: impl FnOnce(&Context<'_>, &Names) -> Option<T>,
    ) -> Result<T, Diagnostics> {
        let context = Context::new(source, &self.parameters, broken);
        let value = read(&context, &Names::of(&self.mechanism));
        let mut out = context.out.into_inner();
        out.sort();
        match value {
            Some(value) if !out.has_errors() => Ok(value),
            _ => Err(out),
        }
    }
}

/// Adds the warnings about the text of a motion, collected in `context`, to the motion.
fn with_doubts(context: &Context<'_>, mut motion: Motion) -> Motion {
    let found = context.out.borrow();
    for warning in found.iter().filter(|found| !found.is_error()) {
        motion.warnings.push(warning.clone());
    }
    motion
}

fn is_toml(name: &str) -> bool {
    name.to_lowercase().ends_with(".toml")
}

/// Reads the whole text of the file `name`, which `source` names. Recordings are not read by this
/// function, because they are read in parts.
fn file(source: &Arc<Source>, name: &str, files: Files<'_>) -> Result<Source, Diagnostics> {
    match files(name).and_then(Contents::whole) {
        Ok(text) => Ok(Source::new(name, text)),
        Err(reason) => Err(unreadable(source, &reason)),
    }
}

fn unreadable(source: &Arc<Source>, reason: &str) -> Diagnostics {
    let message = format!("the file cannot be read: {reason}");
    let place = Place::new(source, 0..source.text.len());
    Diagnostic::error("file", message).at(place, "this file").into()
}

fn unknown<'a>(
    source: &Arc<Source>,
    kind: &str,
    name: &str,
    known: impl Iterator<Item = &'a String>,
) -> Diagnostics {
    let help = did_you_mean(name, &format!("{kind}s"), known.map(String::as_str));
    let place = Place::new(source, 0..source.text.len());
    let example = match kind {
        "motion" => "write assignments such as `platform.x = 5 mm*sin(2*pi*t)`",
        _ => "write assignments such as `platform.fz = -100 N`",
    };
    Diagnostic::error("unknown-name", format!("the model has no {kind} {}", quoted(name)))
        .at(place, format!("unknown {kind}"))
        .help(match help {
            Some(near) if near.ends_with('?') => near,
            Some(list) => format!("{list}; {example}"),
            None => example.to_owned(),
        })
        .into()
}
