//! Design of excitation motions, from which chosen parameters of a robot can be identified.

use crate::error::Error;
use crate::robot::Robot;
use stiction_run::excite::{Excitation, ExciteError, ExciteSettings, excite};

impl Robot {
    /// Designs a motion, within the limits of the robot, from which the chosen parameters can be
    /// identified best. `progress` receives the number of search steps done and their maximum
    /// number; the search stops when `progress` returns `false`.
    ///
    /// # Errors
    /// The settings do not suit the robot, or no motion is possible within the limits.
    pub fn excite(
        &self,
        settings: &ExciteSettings,
        progress: impl FnMut(usize, usize) -> bool,
    ) -> Result<Excitation, Error> {
        Ok(excite(self.model(), settings, progress)?)
    }
}

impl From<ExciteError> for Error {
    fn from(error: ExciteError) -> Self {
        let ExciteError { message, help, no_answer, interrupted } = error;
        let found = match (interrupted, no_answer) {
            (true, _) => Self::interrupted(message),
            (_, true) => Self::no_answer(message),
            _ => Self::input(message),
        };
        if help.is_empty() { found } else { found.with_help(help) }
    }
}
