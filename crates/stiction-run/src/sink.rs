//! Receivers of the results of a run.

use crate::SinkError;

/// Receiver of the records of a run, which are its results at successive samples in chronological
/// order. Examples are tables, a summary or curves.
///
/// A run passes its records to a closure. To supply several sinks, the closure passes each record
/// to all of them.
pub trait Sink<Record> {
    /// Receives one record.
    ///
    /// # Errors
    /// Returns the reason why the sink could not process the record.
    fn add(&mut self, record: &Record) -> Result<(), SinkError>;
}

impl<Record, S: Sink<Record>> Sink<Record> for Option<S> {
    fn add(&mut self, record: &Record) -> Result<(), SinkError> {
        self.as_mut().map_or(Ok(()), |sink| sink.add(record))
    }
}

impl<Record, S: Sink<Record> + ?Sized> Sink<Record> for &mut S {
    fn add(&mut self, record: &Record) -> Result<(), SinkError> {
        (**self).add(record)
    }
}

impl<Record, A: Sink<Record>, B: Sink<Record>> Sink<Record> for (A, B) {
    fn add(&mut self, record: &Record) -> Result<(), SinkError> {
        self.0.add(record)?;
        self.1.add(record)
    }
}

impl<Record, A: Sink<Record>, B: Sink<Record>, C: Sink<Record>> Sink<Record> for (A, B, C) {
    fn add(&mut self, record: &Record) -> Result<(), SinkError> {
        self.0.add(record)?;
        self.1.add(record)?;
        self.2.add(record)
    }
}
