//! How accurately, and how.

/// How accurately, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Error of a step in units of the numbers themselves.
    pub relative: f64,
    /// Error of a step, rad and rad/s, or in characteristic lengths.
    pub absolute: f64,
    /// The longest step, s. Where nothing moves steps grow to it, and inputs between its stages are
    /// not seen.
    pub longest_step: f64,
    /// Steps shorter than this, s, end the simulation.
    pub shortest_step: f64,
    /// Whether other solutions are looked for where uniqueness is not certain.
    pub look_for_others: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            relative: 1e-10,
            absolute: 1e-12,
            longest_step: 0.1,
            shortest_step: 1e-14,
            look_for_others: true,
        }
    }
}
