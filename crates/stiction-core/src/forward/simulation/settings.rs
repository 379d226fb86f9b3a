//! Accuracy and integration scheme of a simulation.

/// Accuracy and integration scheme of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Relative tolerance of an event-driven step.
    pub relative: f64,
    /// Absolute tolerance of an event-driven step, rad and rad/s; lengths in characteristic lengths.
    pub absolute: f64,
    /// Longest step, s. Steps grow to this length while nothing moves; a pulse of an input between the stages of a step
    /// then has no effect.
    pub longest_step: f64,
    /// Shortest step, s. The event-driven method fails if the tolerance requires a shorter one.
    pub shortest_step: f64,
    /// True to search for further solutions where uniqueness is not certain.
    pub look_for_others: bool,
    /// Integration scheme.
    pub method: Method,
    /// Tolerance of a step of the nonsmooth time stepper, rad or characteristic lengths.
    pub time_step_tolerance: f64,
}

/// Integration scheme: event-driven, time-stepping, or automatic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Event-driven where possible. Time stepping where events come too densely, where steps become too
    /// short, or where no acceleration satisfies all friction laws. [`super::Simulation::method`] returns the
    /// present scheme; [`super::EventKind::Method`] records each change.
    #[default]
    Automatic,
    /// Steps of order eight; every stick and slip onset ends a step.
    EventDriven,
    /// Steps of first order at velocity level (Moreau 1988, Jean 1999); stick and slip onsets fall within
    /// steps. Accelerations and reactions are means over the last step. Velocities jump where no
    /// acceleration satisfies the law of friction; [`super::EventKind::Jump`] records it.
    TimeStepping,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            relative: 1e-10,
            absolute: 1e-12,
            longest_step: 0.1,
            shortest_step: 1e-14,
            look_for_others: true,
            method: Method::Automatic,
            time_step_tolerance: 1e-7,
        }
    }
}
