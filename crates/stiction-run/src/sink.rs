//! Receivers of the records of a run.

/// Receiver of the records of a run in the order of time, such as tables, a summary or curves.
///
/// A run itself takes a closure; to feed several sinks, the closure passes the record to each.
pub trait Sink<Record> {
    /// Receives one record.
    ///
    /// # Errors
    /// A message if the record cannot be written.
    fn add(&mut self, record: &Record) -> Result<(), String>;
}

impl<Record, S: Sink<Record>> Sink<Record> for Option<S> {
    fn add(&mut self, record: &Record) -> Result<(), String> {
        self.as_mut().map_or(Ok(()), |sink| sink.add(record))
    }
}

impl<Record, S: Sink<Record> + ?Sized> Sink<Record> for &mut S {
    fn add(&mut self, record: &Record) -> Result<(), String> {
        (**self).add(record)
    }
}

impl<Record, A: Sink<Record>, B: Sink<Record>> Sink<Record> for (A, B) {
    fn add(&mut self, record: &Record) -> Result<(), String> {
        self.0.add(record)?;
        self.1.add(record)
    }
}

impl<Record, A: Sink<Record>, B: Sink<Record>, C: Sink<Record>> Sink<Record> for (A, B, C) {
    fn add(&mut self, record: &Record) -> Result<(), String> {
        self.0.add(record)?;
        self.1.add(record)?;
        self.2.add(record)
    }
}
