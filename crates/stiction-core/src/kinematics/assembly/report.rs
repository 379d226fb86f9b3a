//! Comparison of the assembled configuration with the given one.

use super::ties::TIE;
use crate::words::significant;
use core::fmt;

/// The user receives a note if [`AssemblyReport::distance`] exceeds this value.
pub(super) const FAR: f64 = 0.5;
/// Another assembly mode is reported if its distance from the given configuration is less than this
/// multiple of the distance of the assembled configuration.
pub(super) const NEARLY_AS_NEAR: f64 = 3.0;

/// A contradiction among `home`, `start` and prescribed coordinates.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Conflict {
    /// The start coordinate of a joint differs from the prescribed value, which takes precedence.
    StartAndPrescribed {
        /// Name of the joint coordinate.
        joint: String,
        /// Difference between the start coordinate and the prescribed value, rad (modulo a turn) or
        /// m.
        by: f64,
        /// True if the coordinate is an angle.
        is_angle: bool,
    },
    /// The home pose of a body differs from the pose that follows from start or prescribed
    /// coordinates, which take precedence.
    Home {
        /// Name of the body.
        body: String,
        /// Displacement between the two poses, m; rotations are multiplied by the characteristic
        /// length.
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

/// Assembly modes that the given data do not distinguish, described by the joint coordinate that
/// differs most between the assembled mode and another one.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct OpenMode {
    /// Name of the joint coordinate.
    pub coordinate: String,
    /// Value of the coordinate in the assembled mode, rad or m.
    pub taken: f64,
    /// Value of the coordinate in another mode, rad or m.
    pub other: f64,
    /// True if the coordinate is an angle.
    pub is_angle: bool,
    /// Number of other assembly modes found; more may exist.
    pub count: usize,
}

impl fmt::Display for OpenMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { coordinate, count, is_angle, .. } = self;
        let [taken, other] = [self.taken, self.other].map(|value| match is_angle {
            true => format!("{} deg", significant(value.to_degrees(), 4)),
            false => format!("{} mm", significant(value * 1e3, 4)),
        });
        let others = match count {
            1 => "another mode".to_owned(),
            count => format!("one of {count} other modes found"),
        };
        write!(
            f,
            "`home`, `start` and the prescribed coordinates agree with several assembly modes: the \
             mode with {coordinate} = {taken} is assembled, but {others} has {coordinate} = \
             {other}; give `home` or `start` of more bodies or joints to choose"
        )
    }
}

/// Comparison of the assembled configuration with the given one.
///
/// Distances are root mean squares over all bodies with poses determined by `home`, `start` and
/// prescribed coordinates. Each body contributes two orthogonal components: the displacement of its
/// origin, divided by the characteristic length, and its rotation angle, rad. For a body with a
/// passive spin, these are the displacement of the centre of mass and the tilt of the spin axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AssemblyReport {
    /// Distance of the assembled configuration from the given one; `None` if the given data do not
    /// determine the pose of any body.
    pub distance: Option<f64>,
    /// Distances of other assembly modes from the given configuration, nearest first. The list
    /// contains only modes that the search found, and may be incomplete.
    pub other_modes: Vec<f64>,
    /// Body farthest from its given pose: name, displacement of its origin, m, and rotation, rad.
    pub farthest: Option<(String, f64, f64)>,
    /// Contradictions among the given data.
    pub conflicts: Vec<Conflict>,
    /// Assembly modes that the given data do not distinguish; `None` if no such modes were found.
    pub open_mode: Option<OpenMode>,
}

impl AssemblyReport {
    /// Composes notes to the user: on conflicts, on assembly modes that the given data do not
    /// distinguish, on a configuration far from the given one, and on another assembly mode at a
    /// similar distance.
    pub fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.conflicts.iter().map(ToString::to_string).collect();
        notes.extend(self.open_mode.as_ref().map(ToString::to_string));
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
                // If a body only translates or only rotates, the other amount is round-off; omit
                // it.
                let moved = (*moved > 1e-9).then(|| format!("{} mm", significant(moved * 1e3, 3)));
                let turned = (*turned > 1e-9)
                    .then(|| format!("{} deg", significant(turned.to_degrees(), 3)));
                let by: Vec<String> = [moved, turned].into_iter().flatten().collect();
                format!("; {body} moves most, by {}", by.join(" and "))
            });
            notes.push(format!(
                "the assembled configuration is far from that given by `home` and `start`: the rms \
                 displacement of the bodies is {found} characteristic lengths{body}{others}"
            ));
        } else if self.open_mode.is_none()
            && self.other_modes.first().is_some_and(|next| *next < NEARLY_AS_NEAR * distance + TIE)
        {
            notes.push(format!(
                "another assembly mode is nearly as close to `home` and `start` as the assembled \
                 one: the rms displacement of the bodies is {found} characteristic \
                 lengths{others}"
            ));
        }
        notes
    }
}
