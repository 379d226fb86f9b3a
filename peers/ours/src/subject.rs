//! Something that is timed.

/// A way to evaluate the states of a motion one after the other.
///
/// A faster one is one more of these in [`crate::kernels::subjects`]. The comparison takes it up by
/// its name: what begins with `forward` is compared with the peers' forward dynamics, all else with
/// their inverse dynamics.
pub(crate) struct Subject<'a> {
    pub(crate) name: &'static str,
    /// Largest difference from the forces that the program prints, relative.
    pub(crate) difference: f64,
    /// Evaluates at least so many states, going on where it stopped the last time, and says how
    /// many it were.
    pub(crate) batch: Box<dyn FnMut(usize) -> usize + 'a>,
}
