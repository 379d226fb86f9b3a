//! Accuracy and integration scheme of a simulation.

/// Accuracy and integration scheme of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Relative tolerance of an event-driven step.
    pub relative: f64,
    /// Absolute tolerance of an event-driven step: rad for angles and rad/s for rates; lengths are
    /// in characteristic lengths.
    pub absolute: f64,
    /// Longest step, s. Steps grow to this length while nothing moves; an input pulse between two
    /// stages of such a long step is missed.
    pub longest_step: f64,
    /// Shortest step, s. The event-driven method fails if the tolerance requires a shorter step.
    pub shortest_step: f64,
    /// True to search for other accelerations that satisfy all friction laws, at instants at which
    /// the uniqueness of the solution is not guaranteed.
    pub look_for_others: bool,
    /// Integration scheme: event-driven, time-stepping, or automatic.
    pub method: Method,
    /// Tolerance of a step of the time-stepping method: of coordinates, rad or characteristic
    /// lengths, and of rates at isolated stick-slip transitions, relative to the speed of the motion.
    pub time_step_tolerance: f64,
}

/// Integration scheme: event-driven, time-stepping, or automatic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Event-driven where possible. Time stepping where events are too frequent, where steps become
    /// too short, or where no accelerations satisfy all friction laws.
    /// [`super::Simulation::method`] returns the present scheme; [`super::EventKind::Method`]
    /// records each change.
    #[default]
    Automatic,
    /// Steps of order eight, or of order four or five before a sample of a controller; each stick or
    /// slip onset ends a step.
    EventDriven,
    /// Steps at velocity level (Moreau 1988, Jean 1999), of second order without stick-slip
    /// transitions and of first order with them; stick and slip onsets lie within steps.
    /// Accelerations and reactions are means over the last step. If no accelerations satisfy the
    /// friction laws, velocities jump; [`super::EventKind::Jump`] records each jump.
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
