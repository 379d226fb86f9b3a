//! Place of a log in a motion that several logs repeat.

/// Place of a log in a motion that several logs repeat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Repetition {
    /// Number of the motion.
    pub(crate) motion: usize,
    /// Instant of the motion at which the log begins.
    pub(crate) shift: usize,
    /// Number of instants of the motion.
    pub(crate) length: usize,
}

impl Repetition {
    /// Returns the instant of the motion at the instant `step` of the log.
    pub(crate) fn instant(self, step: usize) -> usize {
        self.shift + step
    }
}
