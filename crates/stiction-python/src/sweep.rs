//! Studies of many designs, with the objectives returned as a NumPy array.

use crate::arrays::array;
use crate::failure::{computed, input};
use crate::options;
use crate::watch::Watch;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use stiction::format::{Key, Setting};
use stiction::{Error, Robot};

/// Values of one varied key, one for each design: numbers or texts. An empty text stands for the
/// value in the model.
#[derive(FromPyObject)]
pub(crate) enum Column {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
}

impl Column {
    fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Texts(texts) => texts.len(),
        }
    }

    fn setting(&self, row: usize) -> Setting {
        match self {
            Self::Numbers(numbers) => Setting::Number(numbers[row]),
            Self::Texts(texts) => Setting::of_cell(&texts[row]),
        }
    }
}

/// Objectives of a study of many designs, and the options of the inverse dynamics of each design.
pub(crate) struct Options<'a> {
    pub(crate) objectives: Vec<String>,
    pub(crate) motion: Option<&'a str>,
    pub(crate) load: Option<&'a str>,
    pub(crate) friction: Option<&'a str>,
    pub(crate) step: Option<f64>,
    pub(crate) threads: Option<usize>,
    pub(crate) progress: Option<Py<PyAny>>,
}

/// Headers of the objectives, values of the objectives of shape (objectives, designs), and the
/// status of each design.
pub(crate) type Rows<'py> = (Vec<String>, Bound<'py, PyArrayDyn<f64>>, Vec<String>);

/// Computes the objectives of each design. Results do not depend on the number of threads.
pub(crate) fn rows<'py>(
    py: Python<'py>,
    robot: &Robot,
    columns: &[(String, Column)],
    options: Options<'_>,
) -> PyResult<Rows<'py>> {
    let Options { objectives, motion, load, friction, step, threads, progress } = options;
    let friction = friction.map(|word| options::friction(py, word)).transpose()?;
    let threads = options::threads(py, threads)?;
    let count = columns.first().map_or(1, |(_, column)| column.len());
    if let Some((name, column)) = columns.iter().find(|(_, column)| column.len() != count) {
        let what = format!(
            "column `{}` has {} values, but the first has {count}",
            name.escape_debug(),
            column.len()
        );
        return Err(input(py, &what, "give a value of every key for every design"));
    }
    let watch = Watch::new(progress);
    let outcome = computed(py, || {
        let mut sweep = robot.sweep()?;
        if let Some(motion) = motion {
            sweep = sweep.motion(motion);
        }
        if let Some(load) = load {
            sweep = sweep.load(load);
        }
        if let Some(friction) = friction {
            sweep = sweep.friction(friction);
        }
        if let Some(step) = step {
            sweep = sweep.step(step);
        }
        for objective in objectives {
            sweep = sweep.objective(objective);
        }
        let keys = columns.iter().map(|(name, _)| Key::of_header(name).map_err(Error::input));
        let study = sweep.study(keys.collect::<Result<_, _>>()?)?;
        let designs = (0..count)
            .map(|row| Ok(columns.iter().map(|(_, column)| column.setting(row)).collect()));
        let width = study.headers().len();
        let mut values = vec![f64::NAN; width * count];
        let mut statuses = Vec::with_capacity(count);
        let mut goes_on = true;
        study.run(designs, threads, |_, row| {
            let at = statuses.len();
            for (objective, value) in row.values.iter().enumerate() {
                values[objective * count + at] = value.unwrap_or(f64::NAN);
            }
            statuses.push(row.status.to_string());
            goes_on = watch.goes_on(statuses.len(), count);
            Ok(goes_on)
        })?;
        if !goes_on && statuses.len() < count {
            return Err(Error::interrupted("interrupted".to_owned()));
        }
        Ok((study.headers().to_vec(), values, statuses))
    });
    let (headers, values, statuses) = watch.finish(outcome)?;
    let shape = [headers.len(), count];
    Ok((headers, array(py, values, &shape)?, statuses))
}
