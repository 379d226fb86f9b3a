//! Sliding and rest of friction interfaces, subject to the noise of the measured rates.

/// The sign of a speed is unknown if the speed is at most this number of its standard deviations.
const SIGMAS: f64 = 3.0;
/// A friction interface or actuator is at rest if its speed is at most this value, m/s or rad/s.
const REST_SPEED: f64 = 1e-9;

/// State of the friction interfaces whose friction an effort contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rest {
    /// All interfaces slide.
    Sliding,
    /// The speed of at least one interface is within the noise of the rates, so the sign of its
    /// friction is unknown.
    Uncertain,
    /// At least one interface is certainly at rest.
    Resting,
}

/// Speed of a friction interface, and its state: sliding or rest.
pub(crate) struct Slip {
    pub(crate) direction: [f64; 3],
    /// Speed, m/s, with the sign of the velocity's first component.
    pub(crate) velocity: f64,
    pub(crate) rest: Rest,
}

impl Rest {
    /// Decides the state of a friction interface or actuator from its speed, m/s or rad/s, and the
    /// variance of the speed due to noise.
    pub(crate) fn of(speed: f64, variance: f64) -> Self {
        match speed {
            s if s <= REST_SPEED => Self::Resting,
            s if s <= SIGMAS * variance.sqrt() => Self::Uncertain,
            _ => Self::Sliding,
        }
    }
}

/// Returns the sign of a rate; zero at rest.
pub(crate) fn sign(rate: f64) -> f64 {
    if rate.abs() <= REST_SPEED { 0.0 } else { rate.signum() }
}
