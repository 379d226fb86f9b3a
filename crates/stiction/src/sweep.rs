//! Studies of many designs: inverse dynamics of a robot with different parameter values in each
//! design, and statistics of the results.

mod study;

pub use study::Study;

use crate::error::Error;
use crate::robot::{ModelText, Robot};
use std::num::NonZeroUsize;
use std::sync::Arc;
use stiction_core::dynamics::FrictionMode;
use stiction_format::{Draft, Key, Setting};
use stiction_run::sweep::{Row, in_order};

/// Study of many designs of a robot: the motion, the load, and the objectives to compute for each
/// design.
///
/// ```
/// use stiction::{Robot, format::Setting};
///
/// let study = Robot::builtin("five-bar")?.sweep()?.objective("peak(left_motor.effort)");
/// let rows = [[Setting::Number(200.0)], [Setting::Number(220.0)]];
/// for row in stiction::sweep(&study, &["crank [mm]"], &rows)? {
///     println!("{:?} N m, {}", row.values, row.status);
/// }
/// # Ok::<(), stiction::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sweep {
    text: ModelText,
    robot: Robot,
    draft: Arc<Draft>,
    motion: Option<String>,
    load: Option<String>,
    friction: Option<FrictionMode>,
    step: Option<f64>,
    objectives: Vec<String>,
}

/// Computes a row with the values of the objectives for each design. The result depends only on the
/// arguments, so the rows of a large table may be computed in any groups and on any machine.
///
/// `keys` are headers such as `mu` or `tool.mass [kg]`: paths of keys or names of parameters, as in
/// [`Robot::with`], with the unit of the numbers; `motion.KEY` and `load.KEY` are keys of the
/// motion and load of the study. Each design has a value for each key. A row that fails contains no
/// values, and its status states the reason.
///
/// # Errors
/// The study itself is defective: an unknown key, objective or motion, or a design with another length than `keys`.
pub fn sweep<D: AsRef<[Setting]> + Sync>(
    sweep: &Sweep,
    keys: &[impl AsRef<str>],
    designs: &[D],
) -> Result<Vec<Row>, Error> {
    let keys = keys.iter().map(|key| Key::of_header(key.as_ref()).map_err(Error::input));
    let study = sweep.study(keys.collect::<Result<_, _>>()?)?;
    let count = study.keys().len();
    if let Some(place) = designs.iter().position(|design| design.as_ref().len() != count) {
        return Err(Error::input(format!(
            "row {} has {} values for {count} keys",
            place + 1,
            designs[place].as_ref().len()
        )));
    }
    Ok(designs.iter().map(|design| study.row(design.as_ref())).collect())
}

impl Sweep {
    pub(crate) fn of(robot: &Robot) -> Result<Self, Error> {
        let text = robot.text().cloned().ok_or_else(|| {
            Error::input("the robot has no model text to change: it was described in code")
                .with_help("write the robot to a model file first")
        })?;
        let draft = Arc::new(text.draft()?);
        Ok(Self {
            text,
            robot: robot.clone(),
            draft,
            motion: None,
            load: None,
            friction: None,
            step: None,
            objectives: Vec::new(),
        })
    }

    /// Sets the motion, as in [`Request::motion`](crate::Request::motion).
    #[must_use]
    pub fn motion(self, motion: impl Into<String>) -> Self {
        Self { motion: Some(motion.into()), ..self }
    }

    /// Sets the load, as in [`Request::load`](crate::Request::load).
    #[must_use]
    pub fn load(self, load: impl Into<String>) -> Self {
        Self { load: Some(load.into()), ..self }
    }

    /// Sets how friction is coupled with the reactions that cause it. Default: the setting of the
    /// model.
    #[must_use]
    pub fn friction(self, friction: FrictionMode) -> Self {
        Self { friction: Some(friction), ..self }
    }

    /// Sets the time between samples, s. Default: the time step of the motion, else 0.01 s.
    #[must_use]
    pub fn step(self, step: f64) -> Self {
        Self { step: Some(step), ..self }
    }

    /// Adds an objective such as `peak(leg1.P.effort)`: see
    /// [`Objectives`](stiction_run::sweep::Objectives).
    #[must_use]
    pub fn objective(mut self, objective: impl Into<String>) -> Self {
        self.objectives.push(objective.into());
        self
    }

    /// Checks all settings that do not depend on the varied values, and creates the data that all
    /// designs share.
    ///
    /// # Errors
    /// The motion, the load, an objective or a key is unknown or defective.
    pub fn study(&self, keys: Vec<Key>) -> Result<Study, Error> {
        Study::new(self, keys)
    }
}

impl Study {
    /// Computes the rows of `designs` on several threads. Passes each row to `receive` on the
    /// calling thread, in the order of the designs, and stops when `receive` returns `false`.
    /// Results are bit-identical for any number of threads.
    ///
    /// # Errors
    /// The first error that `receive` returned or `designs` contained. Also an error if the first
    /// design fails because the numbers for a parameter have no unit.
    pub fn run(
        &self,
        designs: impl Iterator<Item = Result<Vec<Setting>, Error>> + Send,
        threads: NonZeroUsize,
        mut receive: impl FnMut(Vec<Setting>, Row) -> Result<bool, Error>,
    ) -> Result<(), Error> {
        let mut designs = designs.peekable();
        if let Some(Ok(first)) = designs.peek() {
            self.check_units(first)?;
        }
        in_order(
            threads.get(),
            || designs.next(),
            |design| design.map(|settings| (self.row(&settings), settings)),
            |row| {
                let (row, settings) = row?;
                receive(settings, row)
            },
        )
    }
}
