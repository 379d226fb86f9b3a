//! Instance of an FMU with its variables, its phase and its communication steps, in safe Rust.

use crate::logger::{Logger, Status};
use std::path::Path;
use stiction::{Error, Unit, UnitState};

/// Largest accepted difference between the start of a communication step and the present time of
/// the instance, as a fraction of the step size. The tolerance allows for rounding by the importer.
const SAME: f64 = 1e-6;

/// Phase of an instance, which corresponds to a state of the FMI state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    Instantiated,
    Initializing,
    Event,
    Stepping,
    Terminated,
    /// A panic has left the instance in an unknown state.
    Broken,
}

/// Instance of an FMU.
#[derive(Debug)]
pub(crate) struct Instance {
    unit: Unit,
    /// State of the unit before the initialisation; [`Self::reset`] restores this state.
    fresh: UnitState,
    phase: Phase,
    logger: Logger,
    /// True if the importer receives all messages, false if only errors.
    pub(crate) logging: bool,
    /// True if the importer supports event mode.
    events: bool,
    /// True if the importer accepts steps that end early.
    early: bool,
}

/// Complete state of an instance, which the importer can save and restore.
#[derive(Debug)]
pub(crate) struct Saved {
    state: UnitState,
    phase: Phase,
}

/// Outcome of a communication step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StepEnd {
    pub(crate) time: f64,
    /// True if the step ended early, at an event.
    pub(crate) early: bool,
    /// True if the importer should enter event mode.
    pub(crate) event: bool,
}

impl Instance {
    /// Creates an instance from the folder `resources` of the FMU. `events` is true if the
    /// importer supports event mode, and `early` if it accepts steps that end early.
    pub(crate) fn new(
        resources: &Path,
        token: &str,
        (events, early): (bool, bool),
        logging: bool,
    ) -> Result<Self, Error> {
        let unit = Unit::load(resources)?;
        if unit.token() != token {
            let version = env!("CARGO_PKG_VERSION");
            return Err(Error::input(
                "the identifier (GUID, instantiation token) does not match the model in `resources`",
            )
            .with_help(format!(
                "this library has version {version}: export the FMU again with Stiction {version}"
            )));
        }
        let fresh = unit.state();
        let (phase, logger) = (Phase::Instantiated, Logger::none());
        Ok(Self { unit, fresh, phase, logger, logging, events, early })
    }

    pub(crate) fn with_logger(self, logger: Logger) -> Self {
        Self { logger, ..self }
    }

    pub(crate) fn say(&self, status: Status, category: &str, message: &str) {
        if self.logging || status != Status::Ok {
            self.logger.say(status, category, message);
        }
    }

    pub(crate) fn phase(&self) -> Phase {
        self.phase
    }

    /// Marks the instance as unusable after a panic.
    pub(crate) fn break_down(&mut self) {
        self.phase = Phase::Broken;
    }

    pub(crate) fn time(&self) -> f64 {
        self.unit.time()
    }

    /// Changes to the phase `to`. Fails if the present phase is not in `from`.
    pub(crate) fn go(&mut self, from: &[Phase], to: Phase) -> Result<(), Error> {
        self.expect(from)?;
        self.phase = to;
        Ok(())
    }

    pub(crate) fn expect(&self, phases: &[Phase]) -> Result<(), Error> {
        match phases.contains(&self.phase) {
            true => Ok(()),
            false => {
                let names: Vec<String> = phases.iter().map(|phase| format!("{phase:?}")).collect();
                Err(Error::input(format!(
                    "this call is not possible while the instance is in the state {:?}",
                    self.phase
                ))
                .with_help(format!("it is possible in {}", names.join(", "))))
            }
        }
    }

    pub(crate) fn set_start_time(&mut self, time: f64) -> Result<(), Error> {
        self.expect(&[Phase::Instantiated])?;
        self.unit.set_start_time(time)
    }

    /// Ends the initialisation and starts the simulation.
    pub(crate) fn exit_initialization(&mut self) -> Result<(), Error> {
        self.expect(&[Phase::Initializing])?;
        self.unit.run()?;
        self.phase = if self.events { Phase::Event } else { Phase::Stepping };
        Ok(())
    }

    pub(crate) fn reset(&mut self) {
        self.unit.set_state(&self.fresh);
        self.phase = Phase::Instantiated;
    }

    pub(crate) fn reals(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        same_count(references.len(), values.len())?;
        for (reference, value) in references.iter().zip(values) {
            *value = self.unit.real(*reference)?;
        }
        Ok(())
    }

    pub(crate) fn integers(&mut self, references: &[u32], values: &mut [i32]) -> Result<(), Error> {
        same_count(references.len(), values.len())?;
        for (reference, value) in references.iter().zip(values) {
            *value = self.unit.integer(*reference)?;
        }
        Ok(())
    }

    pub(crate) fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        self.expect(&[Phase::Instantiated, Phase::Initializing, Phase::Event, Phase::Stepping])?;
        same_count(references.len(), values.len())?;
        self.unit.set_reals(references, values)
    }

    pub(crate) fn set_integers(&mut self, references: &[u32]) -> Result<(), Error> {
        references.iter().try_for_each(|reference| self.unit.set_integer(*reference))
    }

    /// Advances the simulation by one communication step of `size`, s, from the present time of the
    /// instance, which `time`, s, must match.
    pub(crate) fn step(&mut self, time: f64, size: f64) -> Result<StepEnd, Error> {
        self.expect(&[Phase::Stepping])?;
        if !(size.is_finite() && size > 0.0) {
            return Err(Error::input(format!(
                "the step is {size} s long, but must be longer than 0 s"
            ))
            .with_help("give a positive step size"));
        }
        let now = self.unit.time();
        let rounding = SAME * size + 4.0 * f64::EPSILON * now.abs();
        // The comparison is also false for NaN.
        let begins_now = (time - now).abs() <= rounding;
        if !begins_now {
            return Err(Error::input(format!(
                "the step begins at {time} s, but the instance is at {now} s"
            ))
            .with_help("begin each step where the last one ended"));
        }
        let until = time + size;
        if until <= now {
            return Err(Error::input(format!(
                "a step of {size} s at {now} s is shorter than the \
                rounding error of the time"
            ))
            .with_help("give a longer step"));
        }
        let events = self.unit.advance(until, self.events && self.early)?;
        if self.logging {
            for event in &events {
                let message = format!("t = {} s: {} {:?}", event.time, event.at, event.kind);
                self.say(Status::Ok, "logEvents", &message);
            }
        }
        let time = self.unit.time();
        let event =
            self.events && self.early && events.iter().any(|event| event.kind.changes_motion());
        Ok(StepEnd { time, early: time < until, event })
    }

    pub(crate) fn save(&self) -> Saved {
        Saved { state: self.unit.state(), phase: self.phase }
    }

    pub(crate) fn restore(&mut self, saved: &Saved) {
        self.unit.set_state(&saved.state);
        self.phase = saved.phase;
    }

    /// Converts a saved state to bytes: one byte for the phase, then the bytes of the state of the
    /// unit.
    pub(crate) fn write(&self, saved: &Saved) -> Vec<u8> {
        let mut bytes = vec![saved.phase as u8];
        bytes.extend(self.unit.write_state(&saved.state));
        bytes
    }

    pub(crate) fn read(&self, bytes: &[u8]) -> Result<Saved, Error> {
        let (first, rest) = bytes.split_first().unwrap_or((&u8::MAX, &[]));
        let known = [
            Phase::Instantiated,
            Phase::Initializing,
            Phase::Event,
            Phase::Stepping,
            Phase::Terminated,
        ];
        let phase = known.into_iter().find(|phase| *phase as u8 == *first);
        let phase =
            phase.ok_or_else(|| Error::input("these bytes are not a state of this model"))?;
        Ok(Saved { state: self.unit.read_state(rest)?, phase })
    }
}

fn same_count(references: usize, values: usize) -> Result<(), Error> {
    match references == values {
        true => Ok(()),
        false => Err(Error::input(format!(
            "there are {references} value references, but {values} values: every variable is scalar"
        ))),
    }
}
