//! Places of errors in the text of the model file, which the user does not have: the places of the parts of the robot file
//! that the text describes.

use super::description::Description;
use super::text::header;
use crate::diagnostic::Diagnostics;
use crate::source::Place;

/// Greatest length of a line of the model file in a message, characters.
const LONGEST: usize = 80;

/// Moves each message about the model file `text` to the joint or body in whose table it is. The message shows the line of
/// the model file.
pub(super) fn to_robot_file(robot: &Description, text: &str, errors: Diagnostics) -> Diagnostics {
    let mut moved = Diagnostics::new();
    for mut error in errors.iter().cloned() {
        let line = error.place.as_ref().map(|place| place.line_column().0);
        if let Some(line) = line
            && let Some(place) = part_at(robot, text, line)
        {
            let shown: String =
                text.lines().nth(line - 1).unwrap_or_default().chars().take(LONGEST).collect();
            error.message = format!("{}: {}", error.message, shown.trim());
            (error.place, error.label, error.related) = (Some(place), String::new(), Vec::new());
        }
        moved.push(error);
    }
    moved
}

/// Place of the joint or body whose table contains a line of the model file; lines are counted from 1.
fn part_at(robot: &Description, text: &str, line: usize) -> Option<Place> {
    let header_of = text.lines().take(line).filter(|line| line.starts_with('[')).last()?;
    let begins = |kind: &str, name: &str| header_of.starts_with(&header(kind, name));
    let joint = robot.joints.iter().find(|joint| begins("joints", &joint.name));
    let body = || robot.bodies.iter().find(|body| begins("bodies", &body.name));
    joint.map_or_else(|| body()?.place.clone(), |joint| joint.place.clone())
}
