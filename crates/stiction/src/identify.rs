//! Identification of the inertia and friction parameters of a robot from measured logs.

use crate::error::Error;
use crate::robot::Robot;
use std::path::Path;
use stiction_format::{Log, LogFormat};
use stiction_run::identify::{
    Identified, IdentifyError, IdentifySettings, MeasuredLog, Progress, Traces, identify,
};

impl Robot {
    /// Reads the options of an identification from a TOML file.
    ///
    /// # Errors
    /// The file cannot be read, or contains an unknown key or an invalid value.
    pub fn identify_settings(&self, path: &Path) -> Result<IdentifySettings, Error> {
        let name = path.display().to_string();
        let text = self.file_text(path)?;
        Ok(IdentifySettings::parse(&name, &text, self.model()).map_err(|mut error| {
            error.message = error.message.replacen("options:", &format!("{name}:"), 1);
            error
        })?)
    }

    /// Reads a measured log, and selects the options in `settings` that apply to this log.
    ///
    /// # Errors
    /// The file cannot be read, or contains an unknown column.
    pub fn measured_log(
        &self,
        path: &str,
        settings: &IdentifySettings,
    ) -> Result<MeasuredLog, Error> {
        let contents = self.log_contents(path)?;
        let own = settings.of_log(path);
        let format = LogFormat {
            renamed: &settings.columns,
            is_steady: own.steady,
            header: &settings.header,
            step: settings.step,
        };
        let log: Log = self.model().read_log(path, contents, format)?;
        Ok(MeasuredLog::new(path, log, own))
    }

    /// Identifies inertia and friction parameters from measured logs.
    ///
    /// # Errors
    /// The logs do not suit the robot, or are too short.
    pub fn identify(
        &self,
        logs: &[MeasuredLog],
        settings: &IdentifySettings,
    ) -> Result<Identified, Error> {
        self.identify_with(logs, settings, &|_, _, _| {})
    }

    /// Identifies parameters as [`Self::identify`] does. `progress` receives the name of the present step of the
    /// computation, and how many of its parts, of how many at most, are done.
    ///
    /// # Errors
    /// See [`Self::identify`].
    pub fn identify_with(
        &self,
        logs: &[MeasuredLog],
        settings: &IdentifySettings,
        progress: Progress<'_>,
    ) -> Result<Identified, Error> {
        Ok(identify(self.model(), logs, settings, progress)?)
    }

    /// Computes the curves of the identification report: the measured efforts of the logs, the
    /// efforts that the identified model predicts, and friction as a function of speed.
    ///
    /// # Errors
    /// See [`Self::identify`].
    pub fn identify_traces(
        &self,
        logs: &[MeasuredLog],
        settings: &IdentifySettings,
        identified: &Identified,
    ) -> Result<Traces, Error> {
        Ok(Traces::new(self.model(), logs, settings, identified)?)
    }
}

impl From<IdentifyError> for Error {
    fn from(error: IdentifyError) -> Self {
        let IdentifyError { message, help } = error;
        let input = Self::input(message);
        if help.is_empty() { input } else { input.with_help(help) }
    }
}
