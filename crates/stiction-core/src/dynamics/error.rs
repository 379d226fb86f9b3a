//! Errors of inverse dynamics.

use crate::words::significant;
use thiserror::Error;

/// Percentage of the friction coefficients below which the message of [`InverseError::Locked`] says
/// "a small fraction".
pub(crate) const NO_PART: f64 = 0.05;

/// Reason why inverse dynamics has no solution.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum InverseError {
    /// No finite effort balances the load at this configuration.
    #[error(
        "no finite actuator effort balances this load here: with all actuators locked, body \
         `{body}` can still move ({motion}), and {} {unit} of the load along that motion remain \
         unbalanced",
        significant(*missing, 6)
    )]
    CannotCarry {
        /// Name of the body with the largest displacement in the motion that nothing resists.
        body: String,
        /// Description of the motion that nothing resists; positions are in the world frame.
        motion: String,
        /// Unbalanced component of the load along the motion that nothing resists, in `unit`.
        missing: f64,
        /// Unit of `missing`: N m for a rotation, otherwise N.
        unit: &'static str,
    },
    /// Friction locks the mechanism: the forces diverge at a fraction of the given friction
    /// coefficients (see `percent`).
    #[error(
        "{}",
        if *percent < NO_PART {
            format!(
                "at a small fraction of the given friction coefficients the efforts grow without \
                 bound, first at joint `{joint}`: the position is singular or nearly so, or the \
                 coefficients are far too large"
            )
        } else {
            format!(
                "friction locks the mechanism (self-locking): at {percent:.1} % of the given \
                 friction coefficients the efforts grow without bound, first at joint `{joint}`; \
                 with larger coefficients no effort maintains this motion"
            )
        }
    )]
    Locked {
        /// Name of the joint whose normal force grows most.
        joint: String,
        /// Percentage of the given friction coefficients at which the solution branch ends.
        percent: f64,
    },
    /// The ends of a spring coincide, so its force has no direction.
    #[error(
        "the two ends of spring `{spring}` coincide here, so its force has no direction: only a spring \
         of free length 0 without damping may pass through that point"
    )]
    SpringWithoutDirection {
        /// Name of the spring.
        spring: String,
    },
    /// A spring or bushing is rotated too far for its moment to be defined.
    #[error("spring `{spring}`: {problem}")]
    Spring {
        /// Name of the spring or bushing.
        spring: String,
        /// Description of the problem.
        problem: String,
    },
    /// The two supports of a guide no longer overlap.
    #[error(
        "the supports of joint `{joint}` do not overlap here: gland and piston have passed each other \
         by {} mm",
        1e3 * .beyond
    )]
    NoOverlap {
        /// Name of the joint.
        joint: String,
        /// Distance by which the supports have passed each other, m.
        beyond: f64,
    },
    /// A component of an external load is NaN or infinite.
    #[error("the load on body `{body}` is not a finite number")]
    NotFinite {
        /// Name of the body.
        body: String,
    },
    /// Round-off prevents an accurate balance of the forces.
    #[error(
        "the forces cannot be computed here: rounding errors leave {} of the power unaccounted \
         for; the position is too close to a singular one, or the model's parameters differ too \
         much in magnitude",
        percent_of(*.residual)
    )]
    Inaccurate {
        /// Relative power residual; infinite if the forces are not finite.
        residual: f64,
    },
    /// Friction at a singular configuration requires forces that cannot be balanced.
    #[error(
        "the position is singular: without friction this load happens to be balanced, but \
         friction requires forces that neither joints nor actuators can exert"
    )]
    Unsettled,
    /// The configuration is singular: no actuator and no constraint resists some motion, so no
    /// model can be compiled.
    #[error("the position is singular: some motion is resisted by no actuator and no constraint")]
    Singular,
    /// Constraints and actuators are both redundant. This case would require two weightings in
    /// sequence, so no model can be compiled.
    #[error(
        "constraints and actuators are both redundant, and a compiled model cannot distribute \
        forces over both: remove redundant constraints or actuators"
    )]
    TwoWeightings,
}

fn percent_of(part: f64) -> String {
    if part < 1.0 { format!("{:.1e} %", 100.0 * part) } else { "all".to_owned() }
}
