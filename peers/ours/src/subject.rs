//! A timed computation.

/// A method that evaluates the states of a motion one after the other.
///
/// Add a faster method in [`crate::kernels::subjects`]. Its name selects the comparison: names that
/// begin with `forward` are compared with the other engines' forward dynamics, all others with
/// their inverse dynamics.
pub(crate) struct Subject<'a> {
    pub(crate) name: &'static str,
    /// Largest relative difference from the forces that the program prints.
    pub(crate) difference: f64,
    /// Evaluates at least the given number of states, starting after the last evaluated one, and
    /// returns the actual number.
    pub(crate) batch: Box<dyn FnMut(usize) -> usize + 'a>,
}
