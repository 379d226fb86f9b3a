//! Export of inverse dynamics (feed-forward) as a functional mock-up unit (FMU).

use super::{Export, Recorded};
use crate::error::Error;
use stiction_core::dynamics::FrictionMode;
use stiction_program::emit::fmu::Fmi;
use stiction_program::emit::{Adapters, Functions, Precision, SourceFile};

/// Content of a functional mock-up unit, without binaries.
#[derive(Clone, Debug)]
pub struct Fmu {
    /// Name of the binary; also the prefix of the functions in static linking.
    pub identifier: String,
    /// Files with their paths in the unit.
    pub files: Vec<SourceFile>,
    /// Paths of the files to compile, relative to `sources/`.
    pub sources: Vec<String>,
}

impl Export {
    /// Differences between the exported code and the results of
    /// [`Robot::inverse`](crate::Robot::inverse) without options, one sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let (_, load) = self.robot.default_load();
        if self.robot.model().default_load.is_some() && load != "none" {
            remarks.push(format!(
                "the code does not contain the load `{load}`, which `stiction inverse` applies by default"
            ));
        }
        let mode = match self.robot.model().default_friction {
            Some(FrictionMode::Off) => "leaves it out",
            Some(FrictionMode::OnePass) => "computes it in one pass",
            Some(FrictionMode::Converged) | None => return remarks,
        };
        remarks.push(format!(
            "the code iterates friction to convergence, but `stiction inverse` {mode} by default for this model"
        ));
        remarks
    }

    /// Records the program and writes it as an FMU for co-simulation with source code: inputs are
    /// positions, rates and accelerations of the actuators, outputs their efforts.
    ///
    /// # Errors
    /// The program cannot be recorded for this robot (the error states the reason), or an option
    /// contains an unknown name.
    pub fn fmu(&self, fmi: Fmi) -> Result<Fmu, Error> {
        if self.options.precision == Precision::Float {
            return Err(Error::input("the variables of an FMU have double precision")
                .with_help("leave --precision out")
                .with_option("precision"));
        }
        if self.options.functions != Functions::default() {
            return Err(Error::input("an FMU contains only inverse dynamics")
                .with_help("leave --functions out")
                .with_option("functions"));
        }
        if self.options.adapters != Adapters::default() {
            return Err(Error::input("adapters are for C").with_help("leave --adapters out"));
        }
        let Recorded { program, labels, options, .. } = self.record()?;
        let files = program.fmu(fmi, &labels, &options).map_err(|error| {
            Error::input(format!("no FMU for `{}`: {error}", self.robot.name()))
        })?;
        let is_source = |file: &&SourceFile| file.name.ends_with(".c");
        let sources = files.iter().filter(is_source);
        let sources =
            sources.filter_map(|file| Some(file.name.strip_prefix("sources/")?.to_owned()));
        let sources = sources.collect();
        Ok(Fmu { identifier: options.name, files, sources })
    }
}
