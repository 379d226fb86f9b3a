//! Why there are no forces.

use crate::words::significant;
use thiserror::Error;

/// A part of the coefficients, percent, below which it would be told as none.
pub(crate) const NO_PART: f64 = 0.05;

/// Why there are no forces to tell.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum InverseError {
    /// No finite driving force carries the load at this position.
    #[error(
        "no finite driving force carries this load here: with all actuators locked, body `{body}` \
         can still move ({motion}), and along that motion {} {unit} are asked for that nothing can give",
        significant(*missing, 6)
    )]
    CannotCarry {
        /// The body that moves most.
        body: String,
        /// How it moves, in words; places are in the world.
        motion: String,
        /// What is missing, N m for a motion that turns, else N.
        missing: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// Friction locks the mechanism: the forces grow without bound before the coefficients reach
    /// their values.
    #[error(
        "{}",
        if *percent < NO_PART {
            format!(
                "with a small part of the given friction coefficients the driving forces grow without bound, first \
                 through joint `{joint}`: the position is singular, or as good as, or the coefficients are immense"
            )
        } else {
            format!(
                "friction locks the mechanism (self-locking): at {percent:.1} % of the given friction \
                 coefficients the driving forces grow without bound, first through joint `{joint}`; beyond, \
                 no driving force keeps this motion going"
            )
        }
    )]
    Locked {
        /// The joint whose load grows most.
        joint: String,
        /// The part of the coefficients at which the solution is lost, percent.
        percent: f64,
    },
    /// A spring that pushes or pulls, but on no line.
    #[error(
        "the two ends of spring `{spring}` coincide here, so its force has no direction: only a spring \
         of free length 0 without damping may pass through that point"
    )]
    SpringWithoutDirection {
        /// The spring.
        spring: String,
    },
    /// The supports of a guide, one on each body, have passed each other.
    #[error(
        "the supports of joint `{joint}` do not overlap here: gland and piston have passed each other \
         by {} mm",
        1e3 * .beyond
    )]
    NoOverlap {
        /// The joint.
        joint: String,
        /// By how much, m.
        beyond: f64,
    },
    /// A load is NaN or infinite.
    #[error("the load on body `{body}` is no finite number")]
    NotFinite {
        /// The body.
        body: String,
    },
    /// What was computed does not balance: rounding has eaten it.
    #[error(
        "the forces cannot be computed here: rounding errors leave {} of the power unaccounted for; \
         the position is too close to a singular one, or the model's numbers differ too much in size",
        percent_of(*.residual)
    )]
    Inaccurate {
        /// The power residual as a part of what is turned over; infinite where forces are not finite.
        residual: f64,
    },
    /// At a singular position friction asks for loads that nothing carries.
    #[error(
        "the position is singular: without friction this load is carried by chance, but friction asks \
         there for loads that neither joints nor actuators can carry"
    )]
    Unsettled,
}

fn percent_of(part: f64) -> String {
    if part < 1.0 { format!("{:.1e} %", 100.0 * part) } else { "all".to_owned() }
}
