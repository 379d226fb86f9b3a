//! The native class that the Python class `Model` wraps: a robot and the computations on it.

use crate::failure::{computed, exception, input};
use crate::states::NativeStates;
use crate::sweep::{self, Column, Options, Rows};
use crate::tables::{Results, ending, results};
use crate::watch::Watch;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stiction::core::kinematics::Target;
use stiction::format::Note;
use stiction::forward::Forward;
use stiction::run::identify::IdentifySettings;
use stiction::{
    Conversion, Diagnostics, Error, FrictionMode, Import, Inverse, Measured, Method, ModelParts,
    ModelText, Robot,
};

/// Parts of a model: name, text, folder, changes, cut-off frequency of the filter (Hz), and notes
/// of the import, in this order.
type Parts = (String, String, Option<PathBuf>, Vec<String>, Option<f64>, Vec<String>);
/// Time (s), kind, place and detail of an event, in this order.
type Event = (f64, &'static str, String, String);

/// A mechanism with its named motions and loads.
#[pyclass(name = "Model", module = "stiction._native", frozen)]
pub(crate) struct NativeModel {
    robot: Robot,
    /// Notes of the import of a URDF, MJCF or SDF file, one line each.
    notes: Vec<String>,
}

fn load(
    py: Python<'_>,
    text: impl FnOnce() -> Result<ModelText, Error> + Send,
) -> PyResult<NativeModel> {
    let (robot, notes) = computed(py, || {
        let text = text()?.with_fixed_folder();
        let notes = text.notes().iter().map(Note::line).collect();
        Ok((text.read()?, notes))
    })?;
    Ok(NativeModel { robot, notes })
}

#[pymethods]
impl NativeModel {
    /// Reads a model from a file, from the built-in models, or from its text, as `source` suggests.
    #[staticmethod]
    fn find(py: Python<'_>, source: &str) -> PyResult<Self> {
        load(py, || ModelText::find(source))
    }

    /// Reads a model file, or a URDF, MJCF or SDF file.
    #[staticmethod]
    #[pyo3(signature = (path, literal=false, package_paths=Vec::new()))]
    fn file(
        py: Python<'_>,
        path: PathBuf,
        literal: bool,
        package_paths: Vec<PathBuf>,
    ) -> PyResult<Self> {
        let import = Import { literal, package_paths };
        load(py, || ModelText::robot_file(&path, None, &import))
    }

    /// Reads the text of a model file.
    #[staticmethod]
    fn parse(py: Python<'_>, text: &str) -> PyResult<Self> {
        load(py, || Ok(ModelText::text(text)))
    }

    /// Creates a model from the parts that [`Self::parts`] returns.
    #[staticmethod]
    fn from_parts(py: Python<'_>, parts: Parts) -> PyResult<Self> {
        let (name, text, folder, changes, filter, notes) = parts;
        let parts = ModelParts { name, text, folder, changes, filter };
        Ok(Self { notes, ..load(py, || Ok(ModelText::from_parts(parts)))? })
    }

    /// Returns the parts from which [`Self::from_parts`] creates the same model.
    fn parts(&self, py: Python<'_>) -> PyResult<Parts> {
        let text = self.robot.text().ok_or_else(|| {
            input(py, "the model has no text", "load the model from a file or a string")
        })?;
        let ModelParts { name, text, folder, changes, filter } = text.parts();
        Ok((name, text, folder, changes, filter, self.notes.clone()))
    }

    /// Creates a copy of the model with changed values.
    fn changed(&self, py: Python<'_>, changes: Vec<String>) -> PyResult<Self> {
        let text = self.robot.text().ok_or_else(|| {
            input(py, "the model has no text to change", "load the model from a file or a string")
        })?;
        let changed = load(py, || Ok(changes.into_iter().fold(text.clone(), ModelText::with)))?;
        Ok(Self { notes: self.notes.clone(), ..changed })
    }

    #[getter]
    fn name(&self) -> &str {
        self.robot.name()
    }

    #[getter]
    fn title(&self) -> &str {
        self.robot.title()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        let each = self.robot.warnings().iter().map(|warning| Diagnostics::from(warning.clone()));
        each.map(|warning| warning.render(false).trim_end().to_owned()).collect()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    #[getter]
    fn actuators(&self) -> Vec<(&str, &'static str)> {
        self.robot.actuators().zip(self.robot.effort_units()).collect()
    }

    #[getter]
    fn joints(&self) -> Vec<&str> {
        self.robot.joints().collect()
    }

    #[getter]
    fn bodies(&self) -> Vec<&str> {
        self.robot.bodies().collect()
    }

    #[getter]
    fn friction_interfaces(&self) -> Vec<&str> {
        self.robot.friction_interfaces().collect()
    }

    #[getter]
    fn motors(&self) -> Vec<&str> {
        self.robot.motors().collect()
    }

    #[getter]
    fn motions(&self) -> Vec<&str> {
        self.robot.motions().collect()
    }

    #[getter]
    fn loads(&self) -> Vec<&str> {
        self.robot.loads().collect()
    }

    #[getter]
    fn defaults(&self) -> (Option<String>, String) {
        self.robot.defaults()
    }

    #[getter]
    fn parameters(&self) -> Vec<(&str, f64, String)> {
        self.robot.parameters().collect()
    }

    /// Returns a drawing of the mechanism as SVG.
    fn drawing(&self, py: Python<'_>) -> PyResult<String> {
        computed(py, || self.robot.drawing())
    }

    /// Converts the robot to another file format. Returns the text of the file, the text of an
    /// additional YAML file if one is needed, and notes on omitted or changed properties.
    fn converted(
        &self,
        py: Python<'_>,
        to: &str,
    ) -> PyResult<(String, Option<String>, Vec<String>)> {
        let to = match to {
            "mjcf" => Conversion::Mjcf,
            "sdf" => Conversion::Sdf,
            "urdf" => Conversion::Urdf,
            "json" => Conversion::Json,
            "toml" => Conversion::Model,
            _ => {
                let what = format!("there is no format `{}`", to.escape_debug());
                return Err(input(
                    py,
                    &what,
                    "give \"mjcf\", \"urdf\", \"sdf\", \"json\" or \"toml\"",
                ));
            }
        };
        let converted = computed(py, || self.robot.check_along().convert(to))?;
        Ok((converted.text, converted.beside, converted.notes))
    }

    /// Computes inverse dynamics along a motion.
    #[pyo3(signature = (*, motion=None, load=None, friction=None, step=None, threads=None,
                        friction_margin=false, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "the options of one call")]
    fn inverse<'py>(
        &self,
        py: Python<'py>,
        motion: Option<&str>,
        load: Option<&str>,
        friction: Option<&str>,
        step: Option<f64>,
        threads: Option<usize>,
        friction_margin: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Results<'py>> {
        let friction = friction.map(|word| crate::options::friction(py, word)).transpose()?;
        let threads = crate::options::threads(py, threads)?;
        let watch = Watch::new(progress);
        let outcome = computed(py, || {
            let request = inverse_request(&self.robot, motion, load, friction, step)?;
            let request = request.threads(threads).friction_margin(friction_margin);
            request.tabulate(|phase, done, of| watch.goes_on_in(phase, done, of))
        });
        results(py, watch.finish(outcome)?)
    }

    /// Computes inverse dynamics along a motion; returns the report as an HTML page. Files that the
    /// options name are in `folder`.
    #[pyo3(signature = (folder, *, motion=None, load=None, friction=None, step=None, threads=None,
                        friction_margin=false))]
    #[expect(clippy::too_many_arguments, reason = "the options of one call")]
    fn inverse_report(
        &self,
        py: Python<'_>,
        folder: Option<PathBuf>,
        motion: Option<&str>,
        load: Option<&str>,
        friction: Option<&str>,
        step: Option<f64>,
        threads: Option<usize>,
        friction_margin: bool,
    ) -> PyResult<String> {
        let friction = friction.map(|word| crate::options::friction(py, word)).transpose()?;
        let threads = crate::options::threads(py, threads)?;
        let watch = Watch::new(None);
        let page = computed(py, || {
            let robot = self.in_folder(folder.as_deref());
            let request = inverse_request(&robot, motion, load, friction, step)?;
            let request = request.threads(threads).friction_margin(friction_margin);
            Ok(request.report(|phase, done, of| watch.goes_on_in(phase, done, of))?.page)
        });
        watch.finish(page)
    }

    /// Computes statistics of inverse dynamics for many designs.
    #[pyo3(signature = (columns, objectives, *, motion=None, load=None, friction=None, step=None,
                        threads=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "the options of one call")]
    fn sweep<'py>(
        &self,
        py: Python<'py>,
        columns: Vec<(String, Column)>,
        objectives: Vec<String>,
        motion: Option<&str>,
        load: Option<&str>,
        friction: Option<&str>,
        step: Option<f64>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Rows<'py>> {
        let options = Options { objectives, motion, load, friction, step, threads, progress };
        sweep::rows(py, &self.robot, &columns, options)
    }

    /// Simulates the robot (forward dynamics). `calls` lists options of the simulation, each as a
    /// name, a text and a number. Returns the results, the events, and the exception that ended the
    /// simulation early.
    #[pyo3(signature = (calls, *, until=None, step=None, tolerance=None, law=None, stops=Vec::new(), progress=None))]
    #[expect(clippy::too_many_arguments, reason = "the options of one call")]
    fn forward<'py>(
        &self,
        py: Python<'py>,
        calls: Vec<(String, String, f64)>,
        until: Option<f64>,
        step: Option<f64>,
        tolerance: Option<f64>,
        law: Option<(f64, Py<PyAny>)>,
        stops: Vec<(String, Py<PyAny>)>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Results<'py>, Vec<Event>, Option<Bound<'py, PyAny>>)> {
        let watch = Arc::new(Watch::new(progress));
        let outcome = computed(py, || {
            let mut request = self.robot.forward();
            if let Some((period, law)) = law {
                let watch = Arc::clone(&watch);
                let law = move |measured: &Measured<'_>| {
                    called_with_state(&law, "control law", measured, &watch)
                };
                request = request.control_law(period, law)?;
            }
            for (name, function) in stops {
                let watch = Arc::clone(&watch);
                let stop = move |measured: &Measured<'_>| {
                    called_with_state(&function, "stop condition", measured, &watch)
                };
                request = request.stop_function(&name, stop);
            }
            request = with_calls(request, &calls, (until, step, tolerance))?;
            request.tabulate(|done, of| watch.goes_on(done, of))
        });
        let simulation = watch.finish(outcome)?;
        let ended = ending(&simulation.ended).map(|error| exception(py, error).into_value(py));
        let ended = ended.map(|error| error.into_bound(py).into_any());
        let events = simulation.events.into_iter();
        let events = events.map(|event| (event.time, event.event, event.at, event.detail));
        Ok((results(py, simulation.results)?, events.collect(), ended))
    }

    /// Simulates the robot; returns the report as an HTML page. Files that the options name are in
    /// `folder`.
    #[pyo3(signature = (folder, calls, *, until=None, step=None, tolerance=None))]
    fn forward_report(
        &self,
        py: Python<'_>,
        folder: Option<PathBuf>,
        calls: Vec<(String, String, f64)>,
        until: Option<f64>,
        step: Option<f64>,
        tolerance: Option<f64>,
    ) -> PyResult<String> {
        let watch = Watch::new(None);
        let page = computed(py, || {
            let robot = self.in_folder(folder.as_deref());
            let request = with_calls(robot.forward(), &calls, (until, step, tolerance))?;
            Ok(request.plan()?.report(|done, of| watch.goes_on(done, of))?.page)
        });
        watch.finish(page)
    }

    /// Checks mobility, redundancy and singularities; returns the results as JSON and as text.
    #[pyo3(signature = (motion=None, step=None, progress=None))]
    fn check(
        &self,
        py: Python<'_>,
        motion: Option<&str>,
        step: Option<f64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(String, String)> {
        let watch = Watch::new(progress);
        let outcome = computed(py, || {
            let mut request = self.robot.check_along();
            if let Some(motion) = motion {
                request = request.motion(motion)?;
            }
            if let Some(step) = step {
                request = request.step(step);
            }
            let report = request.run_with(|phase, done, of| watch.goes_on_in(phase, done, of))?;
            Ok((report.to_json().to_string(), report.as_text().to_owned()))
        });
        watch.finish(outcome)
    }

    /// Identifies inertia and friction from measured logs. Returns the results as JSON and as text,
    /// and the text of the identified model unless the fit failed.
    #[pyo3(signature = (logs, options=None, filter=None))]
    fn identify(
        &self,
        py: Python<'_>,
        logs: Vec<String>,
        options: Option<PathBuf>,
        filter: Option<f64>,
    ) -> PyResult<(String, String, Option<String>)> {
        computed(py, || {
            let mut settings = match &options {
                Some(path) => self.robot.identify_settings(path)?,
                None => IdentifySettings::default(),
            };
            settings.filter = filter.or(settings.filter);
            let logs = logs.iter().map(|log| self.robot.measured_log(log, &settings));
            let found = self.robot.identify(&logs.collect::<Result<Vec<_>, _>>()?, &settings)?;
            let model = (!found.has_failed()).then(|| found.model_text(self.robot.model()));
            let model = model.transpose().map_err(Error::no_answer)?;
            Ok((found.to_json().to_string(), found.to_text(), model))
        })
    }

    /// Computes static friction at rest; returns the results as JSON and as text.
    #[pyo3(signature = (motion=None, load=None, at=None))]
    fn breakaway(
        &self,
        py: Python<'_>,
        motion: Option<&str>,
        load: Option<&str>,
        at: Option<f64>,
    ) -> PyResult<(String, String)> {
        computed(py, || {
            let mut request = self.robot.breakaway();
            if let Some(motion) = motion {
                request = request.motion(motion)?;
            }
            if let Some(load) = load {
                request = request.load(load)?;
            }
            if let Some(at) = at {
                request = request.at(at);
            }
            let rest = request.run()?;
            Ok((rest.to_json().to_string(), rest.to_string()))
        })
    }

    /// Compiles the robot for batches of states.
    #[pyo3(signature = (*, coordinates=None, motion=None, load=None, friction=None, at=None))]
    fn states(
        &self,
        py: Python<'_>,
        coordinates: Option<Vec<String>>,
        motion: Option<&str>,
        load: Option<&str>,
        friction: Option<&str>,
        at: Option<f64>,
    ) -> PyResult<NativeStates> {
        let friction = friction.map(|word| crate::options::friction(py, word)).transpose()?;
        let states = computed(py, || {
            let mut request = self.robot.states();
            if let Some(coordinates) = &coordinates {
                request = request.coordinates(coordinates)?;
            }
            if let Some(motion) = motion {
                request = request.motion(motion)?;
            }
            if let Some(load) = load {
                request = request.load(load)?;
            }
            if let Some(friction) = friction {
                request = request.friction(friction);
            }
            if let Some(at) = at {
                request = request.at(at);
            }
            request.compile()
        })?;
        Ok(NativeStates::new(states))
    }
}

impl NativeModel {
    /// The robot with the folder of the files that options name; the current folder without it.
    fn in_folder(&self, folder: Option<&Path>) -> Robot {
        folder.map_or_else(|| self.robot.clone(), |folder| self.robot.in_folder(folder))
    }
}

/// Creates a request for inverse dynamics with the options of a Python call.
fn inverse_request(
    robot: &Robot,
    motion: Option<&str>,
    load: Option<&str>,
    friction: Option<FrictionMode>,
    step: Option<f64>,
) -> Result<Inverse, Error> {
    let mut request = robot.inverse();
    if let Some(motion) = motion {
        request = request.motion(motion)?;
    }
    if let Some(load) = load {
        request = request.load(load)?;
    }
    if let Some(friction) = friction {
        request = request.friction(friction);
    }
    if let Some(step) = step {
        request = request.step(step);
    }
    Ok(request)
}

/// Adds options to a request for forward dynamics: the options in `calls`, the end time, s, the
/// time between samples, s, and the tolerance.
fn with_calls(
    mut request: Forward,
    calls: &[(String, String, f64)],
    (until, step, tolerance): (Option<f64>, Option<f64>, Option<f64>),
) -> Result<Forward, Error> {
    for (option, text, number) in calls {
        request = called(request, option, text, *number)?;
    }
    if let Some(until) = until {
        request = request.until(until);
    }
    if let Some(step) = step {
        request = request.step(step);
    }
    match tolerance {
        Some(tolerance) => request.tolerance(tolerance),
        None => Ok(request),
    }
}

/// Calls a function that the Python caller supplied with the measured state. `what` names the
/// function in messages. If the function raises an exception, the simulation stops.
fn called_with_state<T: for<'a, 'py> FromPyObject<'a, 'py>>(
    function: &Py<PyAny>,
    what: &str,
    measured: &Measured<'_>,
    watch: &Watch,
) -> Result<T, Error> {
    let result = Python::attach(|py| {
        let array = |numbers: &[f64]| numbers.to_vec().into_pyarray(py);
        let reference = |number: fn(&Target<f64>) -> f64| {
            array(&measured.reference.iter().map(number).collect::<Vec<f64>>())
        };
        let reference = (
            reference(|target| target.value),
            reference(|target| target.rate),
            reference(|target| target.acceleration),
        );
        let state = (measured.time, array(measured.positions), array(measured.rates), reference);
        function.call1(py, state)?.extract::<T>(py).map_err(Into::into)
    });
    result.map_err(|error: PyErr| {
        watch.keep(error);
        Error::interrupted(format!("the {what} raised an exception"))
    })
}

/// Adds one option to a request for forward dynamics. The option is given by its name and by a text
/// or a number, as the option requires.
fn called(request: Forward, option: &str, text: &str, number: f64) -> Result<Forward, Error> {
    match option {
        "motion" => request.motion(text),
        "load" => request.load(text),
        "drives" => request.drives(text),
        "controller" => request.controller(text),
        "start" => request.from(text),
        "at" => request.at(text, number),
        "rate" => request.rate(text, number),
        "prescribe" => request.prescribe(text),
        "hold" => request.hold(text),
        "stop" => request.stop(text),
        "friction" => Ok(request.friction(text == "on")),
        "method" => match text {
            "automatic" => Ok(request.method(Method::Automatic)),
            "event-driven" => Ok(request.method(Method::EventDriven)),
            "time-stepping" => Ok(request.method(Method::TimeStepping)),
            _ => Err(Error::input(format!("there is no method `{}`", text.escape_debug()))
                .with_help("give \"automatic\", \"event-driven\" or \"time-stepping\"")
                .with_option("method")),
        },
        _ => Err(Error::input(format!("there is no option `{}`", option.escape_debug()))),
    }
}
