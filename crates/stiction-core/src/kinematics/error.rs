//! Errors of assembly and of tracking.

use crate::words::significant;
use thiserror::Error;

/// Errors of assembly and of tracking along prescribed coordinates.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AssemblyError {
    /// The loops do not close at the prescribed coordinates.
    #[error("{0}")]
    Gap(Gap),
    /// The prescribed coordinates leave degrees of freedom undetermined.
    #[error(
        "the prescribed coordinates leave {} undetermined: {}; prescribe {} more",
        degrees(open.len()),
        list(open),
        count(open.len(), "coordinate")
    )]
    Open {
        /// Description of each undetermined motion.
        open: Vec<OpenDof>,
    },
    /// At an intermediate configuration, the prescribed coordinates do not determine motions that
    /// they determine elsewhere. Such a configuration is singular; branches of motion may meet
    /// there.
    #[error(
        "the prescribed coordinates do not determine the motion at this position{}{} (a singular \
         position; prescribe other coordinates, or avoid this position)",
        if open.is_empty() { "" } else { ": " },
        list(open)
    )]
    Undetermined {
        /// Description of each undetermined motion.
        open: Vec<OpenDof>,
    },
    /// The prescribed second angle has a value at which the other two angles are undefined.
    #[error(
        "the second rotation angle of body `{body}` is prescribed as {degrees:.3} deg, at or \
         beyond the limit of its range ({range}) where the other two are not defined; choose \
         another order of axes"
    )]
    AngleRange {
        /// Name of the body.
        body: String,
        /// The prescribed value, deg.
        degrees: f64,
        /// Description of the permitted range.
        range: &'static str,
    },
    /// A prescribed value, rate or acceleration is NaN or too large for the computation.
    #[error(
        "prescribed coordinate {index} (counted from 0) has a value, rate or acceleration that \
         is not finite or exceeds 1e30 in magnitude"
    )]
    NotFinite {
        /// Index of the prescribed coordinate, counted from 0.
        index: usize,
    },
    /// The start or end time of a motion is not finite.
    #[error("a motion cannot be followed from {from} s to {to} s: both times must be finite")]
    NoTime {
        /// Start time, s.
        from: f64,
        /// End time, s.
        to: f64,
    },
    /// The loops close, but the prescribed rates or accelerations violate them.
    #[error(
        "the loops close at this position, but the prescribed {order} violate a constraint: {} \
         by {by:.3e} {unit}; prescribe {order} that the constraints permit here",
        match joint {
            Some(gearing) if *of_gearing => format!("gearing `{gearing}` would be violated"),
            Some(joint) => format!("joint `{joint}` would open"),
            None => "one of the prescribed coordinates could not be reached".to_owned(),
        }
    )]
    Contradiction {
        /// Name of the quantities that violate a constraint: rates or accelerations.
        order: &'static str,
        /// Joint or gearing with the largest violation; `None` if the violation of a prescribed
        /// coordinate is larger.
        joint: Option<String>,
        /// True if `joint` is a gearing.
        of_gearing: bool,
        /// Magnitude of the violation, in the unit `unit`.
        by: f64,
        /// Unit of the violation.
        unit: &'static str,
    },
    /// The mechanism cannot follow the motion within its assembly mode.
    #[error(
        "the mechanism cannot follow the motion smoothly: between two instants that are {step:.1e} s \
         apart, body `{body}` would jump by {} mm and {} deg (it changes its assembly mode, or passes a singular position)",
        significant(*distance_mm, 4),
        significant(*angle_deg, 4)
    )]
    Jump {
        /// Body with the largest displacement.
        body: String,
        /// Displacement of the body minus that predicted from its velocity, mm.
        distance_mm: f64,
        /// Rotation of the body minus that predicted from its velocity, deg.
        angle_deg: f64,
        /// Time between the two instants, s.
        step: f64,
    },
}

/// Remaining errors of a mechanism that cannot be assembled, at the minimum of the weighted errors
/// of loops and prescribed coordinates. Prescribed coordinates have the larger weight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gap {
    /// Joint or gearing with the largest gap; `None` in a mechanism without loops and gearings.
    pub joint: Option<String>,
    /// True if `joint` is a gearing.
    pub of_gearing: bool,
    /// Distance by which `joint` is open, or the error of a gearing between lengths, m.
    pub length: f64,
    /// Angle by which `joint` is open, or the error of a gearing between angles, rad.
    pub angle: f64,
    /// Largest deviation from a prescribed length, m.
    pub missed_length: f64,
    /// Largest deviation from a prescribed angle, rad.
    pub missed_angle: f64,
    /// Number of prescribed coordinates and mobility; `None` unless the number exceeds the
    /// mobility.
    pub prescribed: Option<(usize, usize)>,
    /// Characteristic length of the mechanism, m. Gaps that are negligible compared with this
    /// length are not reported.
    pub scale: f64,
}

impl core::fmt::Display for Gap {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        // If all amounts of a gap are small, report every amount that is not negligible compared
        // with the largest one.
        let sizes = [self.length, self.missed_length].map(|length| length / self.scale);
        let angles = [self.angle, self.missed_angle];
        let largest = sizes.into_iter().chain(angles).fold(0.0, f64::max);
        let negligible = NEGLIGIBLE.min(PART * largest);
        let missed = amounts(self.missed_length, self.missed_angle, self.scale, negligible);
        let open = amounts(self.length, self.angle, self.scale, negligible);
        match (&self.joint, missed.as_str(), open.as_str()) {
            (_, "", "") | (None, "", _) => write!(f, "the loops do not close")?,
            (Some(gearing), "", open) if self.of_gearing => {
                write!(f, "gearing `{gearing}` cannot be satisfied: at best, it is off by {open}")?;
            }
            (Some(joint), "", open) => {
                write!(f, "the loops do not close: at best, joint `{joint}` stays open by {open}")?;
            }
            (Some(_), missed, "") => {
                write!(
                    f,
                    "the prescribed position is out of reach: the nearest one misses it by {missed}"
                )?;
            }
            (Some(gearing), missed, open) if self.of_gearing => write!(
                f,
                "the prescribed position is out of reach: the best compromise misses it by \
                 {missed} and leaves gearing `{gearing}` off by {open}"
            )?,
            (Some(joint), missed, open) => write!(
                f,
                "the prescribed position is out of reach: the best compromise misses it by \
                 {missed} and leaves joint `{joint}` open by {open}"
            )?,
            (None, missed, _) => write!(
                f,
                "the prescribed coordinates contradict each other: the nearest position misses them by {missed}"
            )?,
        }
        if let Some((prescribed, dofs)) = self.prescribed {
            write!(
                f,
                " ({prescribed} coordinates are prescribed, but the mechanism has {})",
                degrees(dofs)
            )?;
        }
        Ok(())
    }
}

/// Formats a length and an angle, omitting values that are negligible at the mechanism's scale.
fn amounts(length: f64, angle: f64, scale: f64, negligible: f64) -> String {
    let in_words = |length: f64| match length {
        length if length < 1.0 => format!("{} mm", significant(length * 1e3, 4)),
        length => format!("{} m", significant(length, 4)),
    };
    let length = (length > negligible * scale).then(|| in_words(length));
    let angle = (angle > negligible).then(|| format!("{} deg", significant(angle.to_degrees(), 4)));
    [length, angle].into_iter().flatten().collect::<Vec<_>>().join(" and ")
}

/// Amounts of a gap below this value, in rad or characteristic lengths, are not reported.
const NEGLIGIBLE: f64 = 1e-6;
/// If the whole gap is small, this fraction of the largest amount replaces [`NEGLIGIBLE`] as the
/// limit of reported amounts.
const PART: f64 = 1e-3;

/// A motion that loops and prescribed coordinates leave undetermined.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenDof {
    /// Body with the largest displacement.
    pub body: String,
    /// Description of the motion; positions are in the world frame.
    pub motion: String,
}

fn degrees(n: usize) -> String {
    if n == 1 { "one degree of freedom".to_owned() } else { format!("{n} degrees of freedom") }
}

fn count(n: usize, what: &str) -> String {
    if n == 1 { format!("one {what}") } else { format!("{n} {what}s") }
}

fn list(open: &[OpenDof]) -> String {
    let each = open.iter().map(|o| format!("body `{}` can still move ({})", o.body, o.motion));
    each.collect::<Vec<_>>().join("; ")
}
