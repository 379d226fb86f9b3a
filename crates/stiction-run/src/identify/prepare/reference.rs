//! Commanded motion of a log, which yields instruments (instrumental variables) for the columns of
//! the measured motion.
//!
//! The theory is in equation (I11) of the book.

use super::{MeasuredLog, Preparation, Prepared};
use crate::identify::IdentifyError as Error;
use crate::identify::chosen::refuse;
use nalgebra::DMatrix;
use stiction_format::LogRole;

impl MeasuredLog {
    /// Returns whether the log has commanded positions.
    pub(in crate::identify) fn is_commanded(&self) -> bool {
        self.log.columns.iter().any(|column| matches!(column.role, LogRole::Reference(_)))
    }

    /// Refuses a log without commanded positions; `purpose` tells, after "has no commanded motion", what needs them.
    pub(in crate::identify) fn needs_command(&self, purpose: &str) -> Result<(), Error> {
        if self.log.is_steady {
            return Err(refuse(
                format!("{}: a table of steady motions has no commanded motion", self.name),
                "write `estimator = \"least-squares\"` in the options",
            ));
        }
        if !self.is_commanded() {
            return Err(refuse(
                format!("{} has no commanded motion{purpose}", self.name),
                "log the commanded positions as columns such as `JOINT.reference [rad]`, or write \
                 `estimator = \"least-squares\"`",
            ));
        }
        Ok(())
    }

    /// Returns a copy of the log with the commanded positions in place of the measured positions.
    fn commanded(&self) -> Self {
        let mut log = self.without_motion();
        for column in &mut log.log.columns {
            if let LogRole::Reference(coordinate) = column.role {
                column.role = LogRole::Coordinate(coordinate);
            }
        }
        log
    }
}

impl Prepared {
    /// Adds the instruments: regression columns of the model along the commanded motion of the log,
    /// filtered like the columns along the measured motion.
    ///
    /// # Errors
    /// Fails if the log has no commanded motion, or if the model cannot follow the commanded motion
    /// everywhere.
    pub(in crate::identify) fn add_reference(
        &mut self,
        preparation: Preparation<'_>,
        log: &MeasuredLog,
    ) -> Result<(), Error> {
        log.needs_command(" for instrumental variables")?;
        let commanded = log.commanded();
        let preparation = Preparation { filter: self.cutoff, ..preparation };
        let other = Self::new(preparation, &commanded, None).map_err(|error| {
            refuse(format!("the commanded motion of {}", error.message), error.help)
        })?;
        if other.times != self.times {
            return Err(refuse(
                format!("{}: the model cannot follow the commanded motion everywhere", log.name),
                "check units, signs and offsets of the commanded positions",
            ));
        }
        self.reference = Some(Box::new(other));
        self.set_instruments();
        Ok(())
    }

    /// Stores the regression columns along the commanded motion as instruments of the regression
    /// rows. The instruments are zero in rows in which the commanded motion is at rest.
    pub(super) fn set_instruments(&mut self) {
        let Some(reference) = &self.reference else { return };
        for (rows, own) in self.block.channels.iter_mut().zip(&reference.block.channels) {
            let mut all = DMatrix::zeros(rows.len(), own.matrix.ncols());
            for (row, step) in rows.steps.iter().enumerate() {
                if let Ok(place) = own.steps.binary_search(step) {
                    all.row_mut(row).copy_from(&own.matrix.row(place));
                }
            }
            rows.instruments = Some(all);
        }
    }
}
