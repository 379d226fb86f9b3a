//! A checked study of many designs: the data that all designs share, and the computation of one
//! design.

use super::Sweep;
use crate::error::{Error, ErrorKind};
use crate::inverse::Inverse;
use crate::robot::Robot;
use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use stiction_format::{Contents, Diagnostic, Diagnostics, Key, Place, Setting, Source};
use stiction_run::comparison::Reel;
use stiction_run::inverse::{Animation, Sample, Summary};
use stiction_run::sweep::{Objectives, Row, Status};
use stiction_run::{Job, Sink};

/// A checked study of many designs, with the keys whose values vary between the designs; see
/// [`Sweep::study`].
#[derive(Debug)]
pub struct Study {
    sweep: Sweep,
    keys: Vec<Key>,
    targets: Vec<Target>,
    headers: Vec<String>,
    files: Memory,
}

/// Part of the input to which a varied key belongs, with the path of the key in this part.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Target {
    Model(String),
    /// Key of the motion, which is given as assignments.
    Motion(String),
    /// Key of the load, which is given as assignments.
    Load(String),
}

/// Cache of the files that models name, so that a file is not read again for each design.
#[derive(Debug, Default)]
struct Memory(Mutex<HashMap<String, Contents>>);

impl Study {
    pub(super) fn new(sweep: &Sweep, keys: Vec<Key>) -> Result<Self, Error> {
        let robot = &sweep.robot;
        let motion = sweep.motion.as_deref().or(robot.default_motion_name());
        let load = sweep.load.as_deref().or(robot.model().default_load.as_deref());
        let target = |key: &Key| match key.path.split_once('.') {
            Some(("motion", rest)) => placed(key, rest, ("motion", motion), Target::Motion),
            Some(("load", rest)) => placed(key, rest, ("load", load), Target::Load),
            _ => Ok(Target::Model(key.path.clone())),
        };
        let targets = keys.iter().map(target).collect::<Result<_, _>>()?;
        let mut study = Self {
            sweep: sweep.clone(),
            keys,
            targets,
            headers: Vec::new(),
            files: Memory::default(),
        };
        study.check()?;
        Ok(study)
    }

    /// Checks the varied keys and the objectives on the unchanged model, and stores the headers of
    /// the objectives.
    fn check(&mut self) -> Result<(), Error> {
        let sweep = &self.sweep;
        self.check_keys()?;
        let is_varied = |kind: fn(&Target) -> bool| self.targets.iter().any(kind);
        let mut request = sweep.robot.inverse();
        match &sweep.motion {
            Some(motion) if !is_varied(|target| matches!(target, Target::Motion(_))) => {
                request = request.motion(motion)?;
            }
            // Without its varied keys, the motion is incomplete; the columns of the tables do not
            // depend on the motion.
            Some(_) if request.motion.is_none() => {
                request.motion = Some((stiction_format::Motion::pose(), "as given".to_owned()));
            }
            _ => {}
        }
        if let Some(load) = &sweep.load
            && !is_varied(|target| matches!(target, Target::Load(_)))
        {
            request = request.load(load)?;
        }
        request = self.with_options(request);
        let job = request.job()?;
        if sweep.objectives.is_empty() {
            return Err(Error::input("the study has no objective")
                .with_help(
                    "give an objective, for example \"peak(JOINT.effort)\" or \"min(distance.actuation)\"",
                )
                .with_option("objective"));
        }
        job.instants()?;
        self.headers = Objectives::new(&sweep.objectives, &job)?.headers();
        Ok(())
    }

    /// Checks that the model has the varied keys.
    fn check_keys(&self) -> Result<(), Error> {
        let mut unknown = Diagnostics::new();
        for target in &self.targets {
            let Target::Model(path) = target else { continue };
            let Err(found) = self.sweep.draft.check_keys(&[format!("{path} = 0")]) else {
                continue;
            };
            // The place of the diagnostic is a place in the key as the user has written it.
            let source = Arc::new(Source::new("--vary", path.clone()));
            for diagnostic in found.iter() {
                let span =
                    diagnostic.place.as_ref().map_or(0..path.len(), |place| place.span.clone());
                let place = Place { source: Arc::clone(&source), span };
                unknown.push(diagnostic.clone().at(place, diagnostic.label.clone()));
            }
        }
        if unknown.has_errors() { Err(unknown.into()) } else { Ok(()) }
    }

    /// Rejects a design whose model is invalid because the numbers for a parameter have no unit.
    /// All other designs would fail for the same reason, so [`Self::run`] checks only the first
    /// design.
    ///
    /// # Errors
    /// The numbers of a parameter have no unit.
    pub fn check_units(&self, design: &[Setting]) -> Result<(), Error> {
        let robot = &self.sweep.robot;
        let unit_of = |path: &str| {
            let found = robot.parameters().find(|(name, ..)| *name == path);
            found.map(|(.., unit)| unit).filter(|unit| !unit.is_empty())
        };
        let without = self.keys.iter().zip(design).find_map(|(key, setting)| {
            let is_plain = key.unit.is_empty() && matches!(setting, Setting::Number(_));
            Some((&key.path, unit_of(&key.path).filter(|_| is_plain)?))
        });
        let Some((path, unit)) = without else { return Ok(()) };
        match self.with_job(design, |_| Ok(())) {
            Err(error) if error.kind() == ErrorKind::Input => Err(Error::input(format!(
                "the values of `{path}` have no unit, but the parameter is in {unit}: {}",
                reason(&error)
            ))
            .with_help(format!(
                "write each value with its unit, for example \"{path} = 0.4 {unit}..0.5 {unit} in 5\"; in the header \
                 of a table, write `{path} [{unit}]`"
            ))),
            _ => Ok(()),
        }
    }

    fn with_options(&self, mut request: Inverse) -> Inverse {
        if let Some(friction) = self.sweep.friction {
            request = request.friction(friction);
        }
        if let Some(step) = self.sweep.step {
            request = request.step(step);
        }
        request
    }

    /// The varied keys.
    pub fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// Headers of the objectives, with units.
    pub fn headers(&self) -> &[String] {
        &self.headers
    }

    /// Computes the objectives of a design, which contains a value for each key. The row depends
    /// only on the study and on the design.
    pub fn row(&self, design: &[Setting]) -> Row {
        self.computed(design).unwrap_or_else(|error| {
            Row::failed(self.headers.len(), error.kind() == ErrorKind::Input, &reason(&error))
        })
    }

    fn computed(&self, design: &[Setting]) -> Result<Row, Error> {
        self.with_job(design, |job| {
            let mut objectives = Objectives::new(&self.sweep.objectives, job)?;
            let mut summary = Summary::new(job);
            let receive = |sample: &Sample| (&mut objectives, &mut summary).add(sample);
            let verdict = job.run(receive, |_phase, _done, _of| true)?;
            let mut doubts = summary.doubts(job, &verdict);
            doubts.extend(objectives.doubts());
            Ok(Row { values: objectives.values(), status: Status::Computed { doubts } })
        })
    }

    /// Computes the animation of a design for a report page that shows `runs` designs; `None` if
    /// the design has no samples.
    ///
    /// # Errors
    /// The design has no results.
    pub fn reel(&self, design: &[Setting], runs: usize) -> Result<Option<Reel>, Error> {
        self.with_job(design, |job| {
            let mut animation = Animation::new(job, job.instants()?.count());
            job.run(|sample| animation.add(sample), |_phase, _done, _of| true)?;
            Ok(animation.reel(runs))
        })
    }

    /// Reads the model, the motion and the load with the values of a design, and calls `use_job`
    /// with the resulting job.
    fn with_job<T>(
        &self,
        design: &[Setting],
        use_job: impl FnOnce(&Job<'_>) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let sweep = &self.sweep;
        let (mut changes, mut motion, mut load) =
            (Vec::new(), sweep.motion.clone(), sweep.load.clone());
        for ((key, target), setting) in self.keys.iter().zip(&self.targets).zip(design) {
            let change =
                |path: &str| Key { path: path.to_owned(), unit: key.unit.clone() }.change(setting);
            match target {
                Target::Model(path) => changes.extend(change(path)),
                Target::Motion(path) => append(&mut motion, change(path)),
                Target::Load(path) => append(&mut load, change(path)),
            }
        }
        let model = sweep.draft.read(&changes, &|file| self.files.contents(&sweep.text, file))?;
        let robot = Robot::of_text(model, sweep.text.clone());
        let mut request = robot.inverse();
        if let Some(motion) = motion {
            request = request.motion(&motion)?;
        }
        if let Some(load) = load {
            request = request.load(&load)?;
        }
        let request = self.with_options(request);
        use_job(&request.job()?)
    }
}

/// Appends the assignment `part` to `text`, which contains assignments; does nothing if either is
/// `None`.
fn append(text: &mut Option<String>, part: Option<String>) {
    if let (Some(text), Some(part)) = (text, part) {
        *text = format!("{}; {part}", text.trim_end().trim_end_matches(';'));
    }
}

/// Determines whether a key of the motion or load belongs to the model or to the given assignments.
/// `rest` is the path of the key without `kind`, and `given` is the name, file or assignments of
/// the motion or load.
fn placed(
    key: &Key,
    rest: &str,
    (kind, given): (&str, Option<&str>),
    target: fn(String) -> Target,
) -> Result<Target, Error> {
    let source = Arc::new(Source::new("--vary", key.path.clone()));
    let fault = |message: String, help: String| {
        let place = Place { source: Arc::clone(&source), span: 0..key.path.len() };
        let diagnostic = Diagnostic::error("variation", message).at(place, "no such key");
        let mut all = Diagnostics::new();
        all.push(diagnostic.maybe_help(Some(help)));
        Error::from(all)
    };
    match given.map(str::trim) {
        Some(text) if text.contains('=') => Ok(target(rest.to_owned())),
        Some(name) if Path::new(name).extension().is_some() => Err(fault(
            format!("the {kind} is the file {name}, which has no keys to vary"),
            format!("give assignments, or name a {kind} of the model"),
        )),
        Some("none") | None => Err(fault(
            format!("the study has no {kind}"),
            format!("give assignments, or name a {kind} of the model (option --{kind})"),
        )),
        Some(name) => Ok(Target::Model(format!("{kind}s.\"{name}\".{rest}"))),
    }
}

impl Memory {
    fn contents(&self, text: &crate::robot::ModelText, file: &str) -> Result<Contents, String> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(contents) = known.get(file) {
            return Ok(contents.clone());
        }
        let contents = text.contents(file)?;
        known.insert(file.to_owned(), contents.clone());
        Ok(contents)
    }
}

/// Message of an error, with the changed value or the place in the model text that caused the
/// error.
fn reason(error: &Error) -> String {
    let first = error.diagnostics().and_then(|diagnostics| {
        let first = diagnostics.iter().find(|diagnostic| diagnostic.is_error())?;
        let Some(place) = &first.place else { return Some(first.message.clone()) };
        let (line, column) = place.line_column();
        let at = match place.source.name.as_str() {
            "--set" => place.source.text.lines().nth(line - 1).unwrap_or_default().to_owned(),
            name => format!("{name}:{line}:{column}"),
        };
        Some(format!("{} ({at})", first.message))
    });
    first.unwrap_or_else(|| error.message())
}
