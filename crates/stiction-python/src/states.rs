//! The native class for a robot compiled for batches of states; returns results as NumPy arrays.

use crate::arrays::{Numbers, array, numbers, shown};
use crate::failure::{computed, input};
use crate::options;
use crate::watch::Watch;
use numpy::{IntoPyArray, PyArray1, PyArrayDyn};
use pyo3::prelude::*;
use stiction::{Batch, Derivatives, Outputs, States, Status, Workers};

/// All possible outcomes of a row. The code of an outcome is its index in this array.
pub(crate) const OUTCOMES: [Status; 11] = [
    Status::Converged,
    Status::InputNotFinite,
    Status::LoopsOpen { error: 0.0 },
    Status::MotionInconsistent,
    Status::Singular,
    Status::SpringWithoutDirection { spring: 0 },
    Status::NoOverlap { interface: 0 },
    Status::FrictionNotConverged { change: 0.0 },
    Status::FrictionLocks,
    Status::Unbalanced { residual: 0.0 },
    Status::SpringTurned { spring: 0, on_joint: false },
];

/// Returns the code of the outcome of a row: its index in [`OUTCOMES`].
fn code(status: Status) -> i8 {
    let same = |known: &Status| std::mem::discriminant(known) == std::mem::discriminant(&status);
    OUTCOMES.iter().position(same).map_or(i8::MAX, |place| place as i8)
}

type Codes<'py> = Bound<'py, PyArray1<i8>>;
type Floats<'py> = Bound<'py, PyArrayDyn<f64>>;
/// Derivatives of the efforts with respect to positions, rates and accelerations, and a flag for
/// each row that is true if the derivatives of this row exist.
type DerivativeArrays<'py> = (Floats<'py>, Floats<'py>, Floats<'py>, Bound<'py, PyArray1<bool>>);
/// Outcome codes, efforts, efforts without friction, reactions, frictions, torques and speeds of
/// motors, residuals of the power balance, and derivatives, as in [`stiction::InverseRows`].
/// Reactions, frictions, torques and speeds of motors, and derivatives are `None` unless requested.
type InverseArrays<'py> = (
    Codes<'py>,
    Floats<'py>,
    Floats<'py>,
    Option<Floats<'py>>,
    Option<Floats<'py>>,
    Option<Floats<'py>>,
    Option<Floats<'py>>,
    Floats<'py>,
    Option<DerivativeArrays<'py>>,
);
/// Outcome codes, positions, quaternions, twists, and accelerations, as in
/// [`stiction::MotionRows`].
type MotionArrays<'py> = (Codes<'py>, Floats<'py>, Floats<'py>, Floats<'py>, Floats<'py>);

/// A robot compiled for batches of states.
#[pyclass(name = "States", module = "stiction._native", frozen)]
pub(crate) struct NativeStates {
    states: States,
    names: Vec<String>,
    actuators: usize,
    joints: usize,
    interfaces: usize,
    motors: usize,
    bodies: usize,
}

impl NativeStates {
    pub(crate) fn new(states: States) -> Self {
        let robot = states.robot();
        Self {
            names: states.coordinates().iter().map(|c| c.name.clone()).collect(),
            actuators: robot.actuators().count(),
            joints: robot.joints().count(),
            interfaces: robot.friction_interfaces().count(),
            motors: robot.motors().count(),
            bodies: robot.bodies().count(),
            states,
        }
    }

    /// Reads the optional array argument `name`, whose shape must be that of `q`; returns an empty
    /// list if the argument is missing.
    fn like(
        &self,
        name: &str,
        value: Option<&Bound<'_, PyAny>>,
        q: &Numbers,
    ) -> PyResult<Vec<f64>> {
        let Some(value) = value else { return Ok(Vec::new()) };
        let read = numbers(name, value, &self.names)?;
        if (read.rows, read.is_single) != (q.rows, q.is_single) {
            let shape = |n: &Numbers| match n.is_single {
                true => shown(&[self.names.len()]),
                false => shown(&[n.rows, self.names.len()]),
            };
            let what = format!("`{name}` has the shape {}, but `q` has {}", shape(&read), shape(q));
            return Err(input(value.py(), &what, "give both the same shape"));
        }
        Ok(read.values)
    }

    fn derivatives<'py>(
        &self,
        py: Python<'py>,
        all: Derivatives,
        shape: (bool, usize),
    ) -> PyResult<DerivativeArrays<'py>> {
        let array = |values| shaped(py, values, shape, &[self.actuators, self.names.len()]);
        Ok((
            array(all.by_position)?,
            array(all.by_rate)?,
            array(all.by_acceleration)?,
            all.is_defined.into_pyarray(py),
        ))
    }

    /// Runs `compute` with the given number of threads, and stops it when a signal such as Ctrl-C
    /// arrives.
    fn with_workers<T: Send>(
        &self,
        py: Python<'_>,
        rows: usize,
        threads: Option<usize>,
        compute: impl FnOnce(&Workers<'_>) -> Result<T, stiction::Error> + Send,
    ) -> PyResult<T> {
        let threads = options::threads(py, threads)?;
        let watch = Watch::new(None);
        let outcome = computed(py, || {
            let is_stopped = || !watch.goes_on(0, rows);
            compute(&Workers { threads, is_stopped: &is_stopped })
        });
        watch.finish(outcome)
    }
}

fn codes<'py>(py: Python<'py>, status: &[Status]) -> Codes<'py> {
    status.iter().map(|status| code(*status)).collect::<Vec<_>>().into_pyarray(py)
}

/// Creates an array of shape (rows, `rest`…), or of shape `rest` for a single state. `q` is true
/// for a single state, with the number of rows.
fn shaped<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    q: (bool, usize),
    rest: &[usize],
) -> PyResult<Floats<'py>> {
    let (is_single, rows) = q;
    let mut shape = Vec::with_capacity(4);
    shape.extend((!is_single).then_some(rows));
    shape.extend_from_slice(rest);
    array(py, values, &shape)
}

#[pymethods]
impl NativeStates {
    #[getter]
    fn coordinates(&self) -> Vec<(&str, &'static str)> {
        self.states.coordinates().iter().map(|c| (c.name.as_str(), c.unit)).collect()
    }

    #[getter]
    fn home<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.states.home().to_vec().into_pyarray(py)
    }

    #[getter]
    fn load(&self) -> &str {
        self.states.load_name()
    }

    /// Computes inverse dynamics of all rows.
    #[pyo3(signature = (q, v=None, a=None, threads=None, reactions=false, frictions=false,
                        derivatives=false, motors=false))]
    #[expect(clippy::too_many_arguments, reason = "the options of one call")]
    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: Option<&Bound<'py, PyAny>>,
        a: Option<&Bound<'py, PyAny>>,
        threads: Option<usize>,
        reactions: bool,
        frictions: bool,
        derivatives: bool,
        motors: bool,
    ) -> PyResult<InverseArrays<'py>> {
        let q = numbers("q", q, &self.names)?;
        let (v, a) = (self.like("v", v, &q)?, self.like("a", a, &q)?);
        let rows = self.with_workers(py, q.rows, threads, |workers| {
            let batch = Batch { q: &q.values, v: &v, a: &a };
            let outputs = Outputs { reactions, frictions, motors, derivatives };
            self.states.inverse_dynamics(batch, outputs, workers)
        })?;
        let shape = (q.is_single, q.rows);
        let asked = |wanted: bool, values: Vec<f64>, rest: &[usize]| {
            wanted.then(|| shaped(py, values, shape, rest)).transpose()
        };
        Ok((
            codes(py, &rows.status),
            shaped(py, rows.efforts, shape, &[self.actuators])?,
            shaped(py, rows.efforts_frictionless, shape, &[self.actuators])?,
            asked(reactions, rows.reactions, &[self.joints, 6])?,
            asked(frictions, rows.frictions, &[self.interfaces, 4])?,
            asked(motors, rows.motor_torques, &[self.motors])?,
            asked(motors, rows.motor_speeds, &[self.motors])?,
            shaped(py, rows.power_residual, shape, &[])?,
            rows.derivatives.map(|all| self.derivatives(py, all, shape)).transpose()?,
        ))
    }

    /// Computes the motion of all bodies in all rows.
    #[pyo3(signature = (q, v=None, a=None, threads=None))]
    fn kinematics<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: Option<&Bound<'py, PyAny>>,
        a: Option<&Bound<'py, PyAny>>,
        threads: Option<usize>,
    ) -> PyResult<MotionArrays<'py>> {
        let q = numbers("q", q, &self.names)?;
        let (v, a) = (self.like("v", v, &q)?, self.like("a", a, &q)?);
        let rows = self.with_workers(py, q.rows, threads, |workers| {
            self.states.kinematics(Batch { q: &q.values, v: &v, a: &a }, workers)
        })?;
        let (shape, bodies) = ((q.is_single, q.rows), self.bodies);
        Ok((
            codes(py, &rows.status),
            shaped(py, rows.positions, shape, &[bodies, 3])?,
            shaped(py, rows.quaternions, shape, &[bodies, 4])?,
            shaped(py, rows.twists, shape, &[bodies, 6])?,
            shaped(py, rows.accelerations, shape, &[bodies, 6])?,
        ))
    }

    /// Computes the Jacobians of all bodies in all rows.
    #[pyo3(signature = (q, threads=None))]
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        threads: Option<usize>,
    ) -> PyResult<(Codes<'py>, Floats<'py>)> {
        let q = numbers("q", q, &self.names)?;
        let rows = self.with_workers(py, q.rows, threads, |workers| {
            self.states.jacobian(&q.values, workers)
        })?;
        let rest = [self.bodies, 6, self.names.len()];
        Ok((codes(py, &rows.status), shaped(py, rows.values, (q.is_single, q.rows), &rest)?))
    }

    /// Computes the mass matrices of all rows.
    #[pyo3(signature = (q, threads=None))]
    fn mass_matrix<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        threads: Option<usize>,
    ) -> PyResult<(Codes<'py>, Floats<'py>)> {
        let q = numbers("q", q, &self.names)?;
        let rows = self.with_workers(py, q.rows, threads, |workers| {
            self.states.mass_matrix(&q.values, workers)
        })?;
        let rest = [self.names.len(); 2];
        Ok((codes(py, &rows.status), shaped(py, rows.values, (q.is_single, q.rows), &rest)?))
    }
}
