//! Reader of motions through waypoints.

mod blend;
mod curve;
mod fastest;
mod joints;
mod limits;
mod timing;
mod trace;

use super::context::{Context, Record};
use super::motion::Reader;
use super::path::{Meaning, coordinate, leaves, resolve};
use crate::diagnostic::{Diagnostic, number, quoted};
use crate::document::{Table, Value};
use crate::expression::Measure;
use crate::fields::tables::WAYPOINT;
use crate::signal::Signal;
use crate::signal::waypoints::{Course, Moves, Turning};
use std::sync::Arc;
use stiction_core::kinematics::Coordinate;
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::Mat3;
use timing::Timing;

/// Coordinates, duration (s) and description of a motion through waypoints.
pub(super) struct Waypoints {
    pub(super) coordinates: Vec<(Coordinate, Signal)>,
    pub(super) duration: f64,
    /// Number of waypoints and times of arrival, in words.
    pub(super) description: String,
}

/// A coordinate or the orientation of a body, with a value for each waypoint.
struct Channel {
    path: String,
    goal: Goal,
}

enum Goal {
    Scalar(Coordinate, Measure, Vec<f64>),
    Orientation(BodyId, Vec<Mat3<f64>>),
}

/// Value of a coordinate, or orientation of a body, at one waypoint.
#[derive(Clone, Copy)]
enum Given {
    Scalar(Coordinate, Measure, f64),
    Orientation(BodyId, Mat3<f64>),
}

/// Returns the tables of at least two waypoints; reports any other value.
fn tables<'a>(context: &Context<'_>, value: &'a Value) -> Option<Vec<&'a Table>> {
    let Some(list) = value.as_list() else {
        context.wrong(value, "a list of at least two tables of coordinates");
        return None;
    };
    if let Some(other) = list.iter().find(|waypoint| waypoint.as_table().is_none()) {
        context.wrong(other, "a table of coordinates, such as { A = \"30 deg\" }");
        return None;
    }
    if list.len() < 2 {
        let count = if list.is_empty() { "none" } else { "only one" };
        context.push(
            Diagnostic::error(
                "range",
                format!("expected a list of at least two tables of coordinates, found {count}"),
            )
            .at(context.place(&value.span), "a waypoint is missing")
            .help("for a single pose, use a motion with `duration = 0` and coordinates"),
        );
        return None;
    }
    Some(list.iter().filter_map(Value::as_table).collect())
}

/// Reads the waypoints of a motion that starts at the time `start`, s. Returns `None` after an
/// error, which has been reported.
pub(super) fn read(
    reader: &Reader<'_>,
    motion: &Record<'_>,
    value: &Value,
    start: f64,
) -> Option<Waypoints> {
    let context = reader.context;
    let tables = tables(context, value)?;
    let channels = channels(reader, &tables)?;
    let mut limited = match motion.value("limits") {
        Some(value) => limits::read(reader, (motion, value), (&channels, &tables))?,
        None => Vec::new(),
    };
    trace::joints(reader, &channels, &tables, &mut limited)?;
    let turns = channels.iter().any(|channel| matches!(channel.goal, Goal::Orientation(..)));
    let moves =
        Timing { reader, motion, limited: &limited, channels: &channels, tables: &tables, turns }
            .moves(start)?;
    let description = describe(&moves, tables.len());
    let last = moves.0.last()?.end();
    let dwell = |table: &Table| Record::open(context, table, WAYPOINT, "").quantity("dwell");
    let rest = tables.last().and_then(|table| dwell(table)).unwrap_or(0.0);
    let mut coordinates = Vec::new();
    for Channel { path, goal } in channels {
        match goal {
            Goal::Scalar(coordinate, _, values) => {
                let course = Course { moves: Arc::clone(&moves), values };
                coordinates.push((coordinate, Signal::course(course)));
            }
            Goal::Orientation(body, orientations) => {
                let turning = Turning::new(&moves, orientations);
                if let Some(t) = turning.half_turn() {
                    context.push(
                        Diagnostic::error(
                            "range",
                            format!(
                                "{} turns the body by half a turn or more from its zero \
                                 orientation",
                                quoted(&path)
                            ),
                        )
                        .at(context.place(&value.span), format!("at t = {} s", number(t)))
                        .help("prescribe intrinsic angles (`rx`, `ry`, `rz`) instead"),
                    );
                    return None;
                }
                let signals = Signal::turning(turning).into_iter().enumerate();
                coordinates.extend(
                    signals.map(|(axis, s)| (Coordinate::RotationVector { body, axis }, s)),
                );
            }
        }
    }
    Some(Waypoints { coordinates, duration: last + rest - start, description })
}

fn describe(moves: &Moves, count: usize) -> String {
    const MOST: usize = 8;
    let times: Vec<String> =
        moves.0.iter().take(MOST).map(|each| format!("{:.4}", each.end())).collect();
    let more = if moves.0.len() > MOST { ", …" } else { "" };
    format!("through {count} waypoints, reached at {}{more} s", times.join(", "))
}

/// Reads the values of all coordinates at all waypoints. A coordinate that is not named at a
/// waypoint has the same value as at the previous waypoint. Returns `None` after an error.
fn channels(reader: &Reader<'_>, tables: &[&Table]) -> Option<Vec<Channel>> {
    let context = reader.context;
    let mut channels: Vec<Channel> = Vec::new();
    let mut fine = true;
    for (index, table) in tables.iter().enumerate() {
        for leaf in leaves(table, WAYPOINT) {
            let Some(value) = leaf.value else { continue };
            let Some(given) = reader.waypoint_value(&leaf, value) else {
                fine = false;
                continue;
            };
            let known = channels.iter_mut().find(|channel| channel.path == leaf.path);
            match (known, given) {
                (
                    Some(Channel { goal: Goal::Scalar(_, _, values), .. }),
                    Given::Scalar(_, _, x),
                ) => {
                    values.push(x);
                }
                (
                    Some(Channel { goal: Goal::Orientation(_, values), .. }),
                    Given::Orientation(_, x),
                ) => values.push(x),
                (None, given) if index == 0 => {
                    let goal = match given {
                        Given::Scalar(coordinate, measure, x) => {
                            Goal::Scalar(coordinate, measure, vec![x])
                        }
                        Given::Orientation(body, x) => Goal::Orientation(body, vec![x]),
                    };
                    channels.push(Channel { path: leaf.path.clone(), goal });
                }
                (known, _) => {
                    fine = false;
                    if known.is_none() {
                        let message =
                            format!("the first waypoint does not give {}", quoted(&leaf.path));
                        context.push(
                            Diagnostic::error("motion", message)
                                .at(context.place(&leaf.key), "first named here")
                                .also(context.place(&tables[0].span), "the first waypoint")
                                .help("give all coordinates at the first waypoint; later ones need only those that change"),
                        );
                    }
                }
            }
        }
        for channel in &mut channels {
            match &mut channel.goal {
                Goal::Scalar(_, _, values) => keep(values, index + 1),
                Goal::Orientation(_, values) => keep(values, index + 1),
            }
        }
    }
    if fine && channels.is_empty() {
        context.push(
            Diagnostic::error("motion", "the waypoints do not give any coordinate")
                .at(context.place(&tables[0].span), "no coordinate")
                .help("for example { tool.x = \"80 mm\", tool.y = \"340 mm\" }"),
        );
    }
    (fine && !channels.is_empty()).then_some(channels)
}

/// Repeats the last value once if the list contains fewer than `count` values.
fn keep<T: Clone>(values: &mut Vec<T>, count: usize) {
    if let Some(last) = values.last().cloned()
        && values.len() < count
    {
        values.push(last);
    }
}

impl Reader<'_> {
    fn waypoint_value(&self, leaf: &super::path::Leaf<'_>, value: &Value) -> Option<Given> {
        let meaning = match resolve(self.names, &leaf.path) {
            Ok(Meaning::Body(body, "rotation")) => {
                return Some(Given::Orientation(body, self.context.rotation(value)?));
            }
            Ok(meaning) => meaning,
            Err(unresolved) => {
                self.unresolved(leaf, unresolved);
                return None;
            }
        };
        match coordinate(meaning, &self.orders) {
            Ok((coordinate, measure)) => {
                Some(Given::Scalar(coordinate, measure, self.context.quantity(value, measure)?))
            }
            Err(unresolved) => {
                self.unresolved(leaf, unresolved);
                None
            }
        }
    }
}
