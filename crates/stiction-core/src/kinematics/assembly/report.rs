//! Comparison of the assembled configuration with the given one.

use crate::words::significant;
use core::fmt;

/// Distance from the given configuration above which a note is reported, in the metric of
/// [`AssemblyReport::distance`].
pub(super) const FAR: f64 = 0.5;
/// Distance ratio below which another assembly mode is reported.
pub(super) const NEARLY_AS_NEAR: f64 = 3.0;

/// A contradiction among `home`, `start` and prescribed coordinates.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Conflict {
    /// A joint's start differs from the prescribed value, which takes precedence.
    StartAndPrescribed {
        /// The joint's coordinate.
        joint: String,
        /// The difference, rad (modulo a turn) or m.
        by: f64,
        /// True for an angle.
        is_angle: bool,
    },
    /// A body's home differs from its pose by starts or prescribed coordinates, which take
    /// precedence.
    Home {
        /// The body.
        body: String,
        /// The displacement between both poses, m (angles times the characteristic length).
        by: f64,
    },
}

impl fmt::Display for Conflict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StartAndPrescribed { joint, by, is_angle } => {
                let by = match is_angle {
                    true => format!("{} deg", significant(by.to_degrees(), 3)),
                    false => format!("{} mm", significant(by * 1e3, 3)),
                };
                write!(
                    f,
                    "the `start` of {joint} differs by {by} from its prescribed value, \
                           which takes precedence"
                )
            }
            Self::Home { body, by } => write!(
                f,
                "the `home` of {body} differs by {} mm (angles times the characteristic length) \
                 from the pose given by `start` and prescribed coordinates, which take precedence",
                significant(by * 1e3, 3)
            ),
        }
    }
}

/// Comparison of the assembled configuration with the given one.
///
/// Distances are root mean squares over all bodies with poses determined by `home`, `start` and
/// prescribed coordinates. Each body contributes the displacement of its origin, divided by the
/// characteristic length, and its rotation angle, rad, as two orthogonal components; a body with
/// a passive spin contributes the displacement of its centre of mass and the tilt of the spin axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AssemblyReport {
    /// Distance of the assembled configuration from the given one; `None` without given data.
    pub distance: Option<f64>,
    /// Distances of other assembly modes that the search found, nearest first. The list may be
    /// incomplete.
    pub other_modes: Vec<f64>,
    /// Body farthest from its given pose: name, displacement of its origin, m, and rotation, rad.
    pub farthest: Option<(String, f64, f64)>,
    /// Contradictions in the given data.
    pub conflicts: Vec<Conflict>,
}

impl AssemblyReport {
    /// Composes notes to the user: conflicts, a configuration far from the given one, and another assembly
    /// mode at a similar distance.
    pub fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.conflicts.iter().map(ToString::to_string).collect();
        let Some(distance) = self.distance else { return notes };
        let others: Vec<String> = self.other_modes.iter().map(|x| significant(*x, 2)).collect();
        let others = match others.as_slice() {
            [] => String::new(),
            [one] => format!("; another assembly mode is at {one}"),
            [first, .., last] => {
                format!("; {} other assembly modes are at {first} to {last}", others.len())
            }
        };
        let found = significant(distance, 2);
        if distance > FAR {
            let body = self.farthest.as_ref().map_or_else(String::new, |(body, moved, turned)| {
                format!(
                    ", most of all {body} by {} mm and {} deg",
                    significant(moved * 1e3, 3),
                    significant(turned.to_degrees(), 3)
                )
            });
            notes.push(format!(
                "the assembled configuration is far from that given by `home` and `start`: rms \
                 displacement of the bodies {found} characteristic lengths{body}{others}"
            ));
        } else if self.other_modes.first().is_some_and(|next| *next < NEARLY_AS_NEAR * distance) {
            notes.push(format!(
                "another assembly mode is nearly as close to `home` and `start` as the assembled \
                 one: rms displacement of the bodies {found} characteristic lengths{others}"
            ));
        }
        notes
    }
}
