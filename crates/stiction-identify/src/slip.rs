//! Sliding of friction interfaces, and rest within the noise of the rates.

/// Standard deviations of a speed below which its sign is unknown.
const SIGMAS: f64 = 3.0;
/// Speed, m/s, below which a friction interface is at rest.
const REST_SPEED: f64 = 1e-9;

/// Rest of the friction interfaces that an effort contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rest {
    /// All of them slide.
    Sliding,
    /// The noise of the rates exceeds the speed of one of them, so that the sign of its friction is unknown.
    Uncertain,
    /// One of them is at rest.
    Resting,
}

/// Slip of an interface.
pub(crate) struct Slip {
    pub(crate) direction: [f64; 3],
    pub(crate) speed: f64,
    /// Coefficient of friction at this speed over the one at high speed.
    pub(crate) shape: f64,
    /// Sliding distance per unit of the joint's rate.
    pub(crate) arm: f64,
    pub(crate) rest: Rest,
}

impl Rest {
    /// Rest of a surface with this speed, m/s or rad/s, and the variance of its noise.
    pub(crate) fn of(speed: f64, variance: f64) -> Self {
        match speed {
            s if s <= REST_SPEED => Self::Resting,
            s if s <= SIGMAS * variance.sqrt() => Self::Uncertain,
            _ => Self::Sliding,
        }
    }
}

/// Sign of a rate; zero at rest.
pub(crate) fn sign(rate: f64) -> f64 {
    if rate.abs() <= REST_SPEED { 0.0 } else { rate.signum() }
}
