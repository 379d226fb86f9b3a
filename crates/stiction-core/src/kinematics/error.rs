//! Why a mechanism cannot be brought into a position.

use crate::words::significant;
use thiserror::Error;

/// Why a mechanism could not be assembled or moved as prescribed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AssemblyError {
    /// The loops do not close at the prescribed position.
    #[error("{0}")]
    Gap(Gap),
    /// The prescription leaves freedoms open.
    #[error(
        "the motion leaves {} open: {}; prescribe {} more",
        count(open.len(), "freedom"),
        list(open),
        count(open.len(), "coordinate")
    )]
    Open {
        /// Each open freedom in words.
        open: Vec<OpenDof>,
    },
    /// At a position on the way the prescription leaves freedoms open that it determines elsewhere:
    /// a singular position of what is prescribed, where branches of motion may meet.
    #[error(
        "what is prescribed does not determine the motion at this position: {} (a singular position; \
         prescribe other coordinates, or avoid it)",
        list(open)
    )]
    Undetermined {
        /// Each open freedom in words.
        open: Vec<OpenDof>,
    },
    /// The prescribed second angle is where the other two are not defined.
    #[error(
        "the second rotation angle of body `{body}` is prescribed as {degrees:.3} deg, at or beyond \
         the limit of its range ({range}) where the other two are not defined; prescribe another \
         order of axes"
    )]
    AngleRange {
        /// The body.
        body: String,
        /// The prescribed value, deg.
        degrees: f64,
        /// The range in words.
        range: &'static str,
    },
    /// A prescribed value, rate or acceleration is NaN, or greater than can be computed with.
    #[error(
        "prescribed coordinate {index} (counted from 0) has a value, rate or acceleration that is no number up to 1e30"
    )]
    NotFinite {
        /// Its place among the prescribed coordinates.
        index: usize,
    },
    /// A motion is to be followed from or to a time that is none.
    #[error("a motion cannot be followed from {from} s to {to} s: both must be finite")]
    NoTime {
        /// s.
        from: f64,
        /// s.
        to: f64,
    },
    /// The loops close, but not while they move as prescribed.
    #[error(
        "the loops close at this position, but it cannot be passed with the prescribed {order}: {} by \
         {by:.3e} {unit}; the mechanism does not move that way here",
        match joint {
            Some(joint) => format!("joint `{joint}` would open"),
            None => "one of the prescribed coordinates would be missed".to_owned(),
        }
    )]
    Contradiction {
        /// Rates or accelerations.
        order: &'static str,
        /// The joint that would open most; none if a coordinate would be missed more.
        joint: Option<String>,
        /// How fast.
        by: f64,
        /// In which unit.
        unit: &'static str,
    },
    /// The mechanism cannot follow without changing its assembly mode.
    #[error(
        "the mechanism cannot follow the motion smoothly: between two instants that are {step:.1e} s \
         apart, body `{body}` would jump by {} mm and {} deg (it changes its assembly mode, or passes a singular position)",
        significant(*distance_mm, 4),
        significant(*angle_deg, 4)
    )]
    Jump {
        /// The body that moves most.
        body: String,
        /// Its displacement beyond what its velocity explains, mm.
        distance_mm: f64,
        /// Its rotation beyond that, deg.
        angle_deg: f64,
        /// The time between the two instants, s.
        step: f64,
    },
}

/// By how much a mechanism fails to assemble, at best: loops and prescription are both missed as
/// little as can be, the prescription counting more.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gap {
    /// The joint that is open most; none in a mechanism without loops.
    pub joint: Option<String>,
    /// How far it is open, m.
    pub length: f64,
    /// By which angle it is open, rad.
    pub angle: f64,
    /// By how much prescribed lengths are missed at most, m.
    pub missed_length: f64,
    /// By how much prescribed angles are missed at most, rad.
    pub missed_angle: f64,
    /// How many coordinates are prescribed and how many freedoms the mechanism has, if these are
    /// fewer.
    pub prescribed: Option<(usize, usize)>,
    /// The mechanism's characteristic length, m: what is much smaller is not told.
    pub scale: f64,
}

impl core::fmt::Display for Gap {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let missed = amounts(self.missed_length, self.missed_angle, self.scale);
        let open = amounts(self.length, self.angle, self.scale);
        match (&self.joint, missed.as_str(), open.as_str()) {
            (_, "", "") => write!(f, "the prescribed position is just out of reach")?,
            (Some(joint), "", open) => {
                write!(f, "the loops do not close: at best, joint `{joint}` stays open by {open}")?;
            }
            (Some(_), missed, "") => {
                write!(
                    f,
                    "the prescribed position is out of reach: the nearest one misses it by {missed}"
                )?;
            }
            (Some(joint), missed, open) => write!(
                f,
                "the prescribed position is out of reach: the nearest compromise misses it by {missed} and leaves \
                 joint `{joint}` open by {open}"
            )?,
            (None, missed, _) => write!(
                f,
                "the prescribed coordinates contradict each other: at best they are missed by {missed}"
            )?,
        }
        if let Some((prescribed, dofs)) = self.prescribed {
            write!(
                f,
                " ({prescribed} coordinates are prescribed, but the mechanism has {})",
                count(dofs, "freedom")
            )?;
        }
        Ok(())
    }
}

/// A length and an angle in words; what is smaller than anyone would measure in a mechanism of this scale is left out.
fn amounts(length: f64, angle: f64, scale: f64) -> String {
    let in_words = |length: f64| match length {
        length if length < 1.0 => format!("{} mm", significant(length * 1e3, 4)),
        length => format!("{} m", significant(length, 4)),
    };
    let length = (length > NEGLIGIBLE * scale).then(|| in_words(length));
    let angle = (angle > NEGLIGIBLE).then(|| format!("{} deg", significant(angle.to_degrees(), 4)));
    [length, angle].into_iter().flatten().collect::<Vec<_>>().join(" and ")
}

/// Gaps below this, rad or as a part of the mechanism's scale, are none.
const NEGLIGIBLE: f64 = 1e-6;

/// A freedom that neither the loops nor the prescription determine.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenDof {
    /// The body that moves most.
    pub body: String,
    /// How it moves, in words; places are in the world.
    pub motion: String,
}

fn count(n: usize, what: &str) -> String {
    if n == 1 { format!("one {what}") } else { format!("{n} {what}s") }
}

fn list(open: &[OpenDof]) -> String {
    let told = open.iter().map(|o| format!("body `{}` can still move ({})", o.body, o.motion));
    told.collect::<Vec<_>>().join("; ")
}
