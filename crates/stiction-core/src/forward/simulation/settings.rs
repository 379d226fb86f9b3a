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
    /// How time is passed.
    pub method: Method,
    /// Error of a step of the nonsmooth time stepper, rad or in characteristic lengths.
    pub time_step_tolerance: f64,
}

/// How time is passed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// From event to event where that goes; in steps where many contacts stick or switch, or where no
    /// acceleration satisfies all laws though velocities do. [`super::Simulation::method`] and
    /// [`super::EventKind::Method`] say which.
    #[default]
    Automatic,
    /// Steps of order eight from one stop or start of sliding to the next.
    EventDriven,
    /// Steps of first order at the level of velocities (Moreau and Jean), with stops and starts wherever
    /// they fall. Accelerations and reactions are means of the last step. Where friction leaves no
    /// acceleration velocities jump, and [`super::EventKind::Jump`] says so.
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
