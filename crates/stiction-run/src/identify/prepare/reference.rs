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
    /// Returns a copy of the log with the commanded positions in place of the measured positions;
    /// `None` if the log has no commanded positions.
    fn commanded(&self) -> Option<Self> {
        let mut log = self.clone();
        let mut has_reference = false;
        for column in &mut log.log.columns {
            column.role = match column.role {
                LogRole::Coordinate(_) | LogRole::Rate(_) => LogRole::Unused,
                LogRole::Reference(coordinate) => {
                    has_reference = true;
                    LogRole::Coordinate(coordinate)
                }
                role => role,
            };
        }
        has_reference.then_some(log)
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
        let help = "log the commanded positions as columns such as `JOINT.reference [rad]`, or write \
                    `estimator = \"least-squares\"`";
        if log.log.is_steady {
            return Err(refuse(
                format!("{}: a table of steady motions has no commanded motion", log.name),
                "write `estimator = \"least-squares\"` in the options",
            ));
        }
        let Some(commanded) = log.commanded() else {
            return Err(refuse(
                format!("{} has no commanded motion for instrumental variables", log.name),
                help,
            ));
        };
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
