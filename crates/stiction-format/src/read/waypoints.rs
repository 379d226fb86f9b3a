//! Reader of motions through waypoints.

use super::context::Record;
use super::motion::Reader;
use super::path::{Meaning, coordinate, leaves, resolve};
use crate::diagnostic::{Diagnostic, number, quoted};
use crate::document::{Table, Value};
use crate::expression::Measure;
use crate::fields::Field;
use crate::fields::tables::{ANGULAR_LIMITS, LIMITS, WAYPOINT};
use crate::signal::Signal;
use crate::signal::law::{Law, Limits, Profile, UNLIMITED};
use crate::signal::waypoints::{Course, Move, Moves, Turning};
use crate::source::Span;
use std::sync::Arc;
use stiction_core::kinematics::Coordinate;
use stiction_core::mechanism::BodyId;
use stiction_core::spatial::{Mat3, Vec3};

/// Relative error by which limits may be exceeded: rounding of durations.
const ROUNDING: f64 = 1e-9;
/// Instants at which the overlap of two moves is checked against the limits.
const TRIALS: u32 = 400;

/// Coordinates, duration and description of a motion through waypoints.
pub(super) struct Waypoints {
    pub(super) coordinates: Vec<(Coordinate, Signal)>,
    pub(super) duration: f64,
    /// Description of laws and times of arrival.
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

/// A value at one waypoint.
#[derive(Clone, Copy)]
enum Given {
    Scalar(Coordinate, Measure, f64),
    Orientation(BodyId, Mat3<f64>),
}

/// Limits of one distance: a coordinate, the path of a body's origin, or its rotation.
struct Limited {
    path: String,
    limits: Limits,
    /// Displacement of each move; of a coordinate its first component.
    steps: Vec<Vec3<f64>>,
}

impl Limited {
    fn step(&self, k: usize) -> Vec3<f64> {
        self.steps.get(k).copied().unwrap_or(Vec3::zero())
    }
}

/// Reads the waypoints of a motion; `None` after an error.
pub(super) fn read(
    reader: &Reader<'_>,
    motion: &Record<'_>,
    value: &Value,
    start: f64,
) -> Option<Waypoints> {
    let context = reader.context;
    let tables: Vec<&Table> = match value.as_list() {
        Some(list) if list.len() >= 2 => list.iter().filter_map(Value::as_table).collect(),
        _ => Vec::new(),
    };
    if tables.len() < 2 || value.as_list().is_some_and(|list| list.len() != tables.len()) {
        context.wrong(value, "a list of at least two tables of coordinates");
        return None;
    }
    let channels = channels(reader, &tables)?;
    let limited = match motion.value("limits") {
        Some(value) => limits(reader, value, &channels)?,
        None => Vec::new(),
    };
    let turns = channels.iter().any(|channel| matches!(channel.goal, Goal::Orientation(..)));
    let moves =
        Timing { reader, motion, limited: &limited, tables: &tables, turns }.moves(start)?;
    let description = describe(&moves, tables.len());
    let last = moves.0.last()?.end();
    let dwell = |table: &Table| Record::open(context, table, WAYPOINT, "").quantity("dwell");
    let rest = tables.last().and_then(|table| dwell(table)).unwrap_or(0.0);
    let moves = Arc::new(moves);
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
                                "{} turns by half a turn or more from its body's zero",
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

/// Values of all coordinates at all waypoints. A coordinate that a waypoint does not name keeps its
/// value.
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
            Diagnostic::error("motion", "the waypoints name no coordinate")
                .at(context.place(&tables[0].span), "no coordinate")
                .help("for example { tool.x = \"80 mm\", tool.y = \"340 mm\" }"),
        );
    }
    (fine && !channels.is_empty()).then_some(channels)
}

/// Repeats the last value until there are `count`.
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

/// Reads the limits; `None` after an error.
fn limits(reader: &Reader<'_>, value: &Value, channels: &[Channel]) -> Option<Vec<Limited>> {
    let context = reader.context;
    let Some(table) = value.as_table() else {
        context.wrong(value, "a table such as { tool = { speed = \"1 m/s\" } }");
        return None;
    };
    let mut found: Vec<Limited> = Vec::new();
    let mut pending: Vec<(String, &Table, Span)> = vec![(String::new(), table, value.span.clone())];
    while let Some((path, table, span)) = pending.pop() {
        let is_limit = |key: &str| LIMITS.iter().any(|field| field.key == key);
        let (own, inner): (Vec<_>, Vec<_>) =
            table.entries.iter().partition(|(key, _)| is_limit(&key.name));
        for (key, value) in inner {
            match value.as_table() {
                Some(table) => {
                    let dot = if path.is_empty() { "" } else { "." };
                    pending.push((format!("{path}{dot}{}", key.name), table, key.span.clone()));
                }
                None => {
                    context.push(
                        Diagnostic::error("unknown-key", "this is not a limit")
                            .at(context.place(&key.span), "unknown key")
                            .help("limits are `speed`, `acceleration` and `jerk`"),
                    );
                    return None;
                }
            }
        }
        if own.is_empty() {
            continue;
        }
        let Some((steps, fields)) = steps(&path, channels, reader) else {
            let message = match path.as_str() {
                "" => "a limit needs the name of what it limits".to_owned(),
                path => format!("{} is no coordinate of the waypoints", quoted(path)),
            };
            let names: Vec<String> = channels.iter().map(|c| quoted(&c.path)).collect();
            context.push(
                Diagnostic::error("motion", message).at(context.place(&span), "not limited").help(
                    format!(
                        "limits concern coordinates of the waypoints ({}) or a body whose origin \
                         moves, for example `limits.BODY.speed`",
                        names.join(", ")
                    ),
                ),
            );
            return None;
        };
        let mut limits = UNLIMITED;
        for (key, value) in own {
            let index = fields.iter().position(|field| field.key == key.name)?;
            let measure = match fields[index].shape {
                crate::fields::Shape::Quantity(measure) => measure,
                _ => Measure::Any,
            };
            let limit = context.quantity(value, measure)?;
            if limit <= 0.0 {
                context.push(
                    Diagnostic::error(
                        "range",
                        format!("a limit is {}, but must be positive", number(limit)),
                    )
                    .at(context.place(&value.span), "not positive"),
                );
                return None;
            }
            limits[index] = limit;
        }
        found.push(Limited { path, limits, steps });
    }
    Some(found)
}

/// The displacements of all moves that a limit of this name concerns, and the keys of the limit.
fn steps(
    path: &str,
    channels: &[Channel],
    reader: &Reader<'_>,
) -> Option<(Vec<Vec3<f64>>, &'static [Field])> {
    let along = |values: &[f64], axis: usize| -> Vec<Vec3<f64>> {
        values.windows(2).map(|pair| Vec3::unit(axis) * (pair[1] - pair[0])).collect()
    };
    if let Some(channel) = channels.iter().find(|channel| channel.path == path) {
        return Some(match &channel.goal {
            Goal::Orientation(_, values) => {
                let turn = |pair: &[Mat3<f64>]| (pair[0].transpose() * pair[1]).rotation_vector();
                (values.windows(2).map(turn).collect(), ANGULAR_LIMITS)
            }
            Goal::Scalar(_, Measure::Angle, values) => (along(values, 0), ANGULAR_LIMITS),
            Goal::Scalar(_, _, values) => (along(values, 0), LIMITS),
        });
    }
    let body = reader.names.body(path)?;
    let mut sums: Vec<Vec3<f64>> = Vec::new();
    for channel in channels {
        if let Goal::Scalar(Coordinate::Position { body: moved, axis }, _, values) = &channel.goal
            && *moved == body
        {
            let steps = along(values, *axis);
            sums.resize(steps.len(), Vec3::zero());
            sums.iter_mut().zip(steps).for_each(|(sum, step)| *sum += step);
        }
    }
    (!sums.is_empty()).then_some((sums, LIMITS))
}

/// Durations of the moves.
struct Timing<'a> {
    reader: &'a Reader<'a>,
    motion: &'a Record<'a>,
    limited: &'a [Limited],
    tables: &'a [&'a Table],
    /// True if orientations are given: their moves do not overlap.
    turns: bool,
}

impl Timing<'_> {
    fn moves(&self, start: f64) -> Option<Moves> {
        let context = self.reader.context;
        let law = |record: &Record<'_>| match record.value("law") {
            Some(_) => record.choice("law").map(Law::from_name),
            None => Some(None),
        };
        let general = law(self.motion)?.unwrap_or(Law::Quintic);
        let mut moves: Vec<Move> = Vec::new();
        let mut free = start;
        let mut blends: Vec<(usize, f64, Span)> = Vec::new();
        for (index, table) in self.tables.iter().enumerate() {
            let record = Record::open(context, table, WAYPOINT, "a waypoint");
            let dwell = nonnegative(&record, "dwell")?;
            if let Some(k) = index.checked_sub(1) {
                let blend = blends.last().filter(|(at, ..)| *at == k);
                let begin = free - blend.map_or(0.0, |(_, time, _)| *time);
                let law = law(&record)?.unwrap_or(general);
                let profile = self.profile(k, &record, law, begin)?;
                moves.push(Move { begin, profile });
                free = moves.last()?.end();
            } else if let Some(key) =
                ["at", "duration", "law"].into_iter().find(|key| record.value(key).is_some())
            {
                context.push(
                    Diagnostic::error("motion", format!("the first waypoint cannot have `{key}`"))
                        .at(context.place(&record.span(key)), "no move leads here")
                        .help("the time of the first waypoint is the `start` of the motion"),
                );
                return None;
            }
            let blend = nonnegative(&record, "blend")?;
            if blend > 0.0 {
                let at_end = index == 0 || index + 1 == self.tables.len();
                if at_end || dwell > 0.0 || self.turns {
                    let why = match (at_end, dwell > 0.0) {
                        (true, _) => "at the first or last waypoint",
                        (_, true) => "with a dwell",
                        _ => "between orientations",
                    };
                    context.push(
                        Diagnostic::error("motion", format!("there is no `blend` {why}"))
                            .at(context.place(&record.span("blend")), "the motion stops here"),
                    );
                    return None;
                }
                blends.push((index, blend, record.span("blend")));
            }
            free += dwell;
        }
        let moves = Moves(moves);
        for (waypoint, blend, span) in &blends {
            self.check_blend(&moves, *waypoint, *blend, span)?;
        }
        Some(moves)
    }

    /// Profile of move `k`, which ends at the waypoint of `record`.
    fn profile(&self, k: usize, record: &Record<'_>, law: Law, begin: f64) -> Option<Profile> {
        let context = self.reader.context;
        let mut limits = UNLIMITED;
        for limited in self.limited {
            let distance = limited.step(k).norm();
            for (limit, given) in limits.iter_mut().zip(limited.limits) {
                // A move without distance has no limit.
                if distance > 0.0 {
                    *limit = limit.min(given / distance);
                }
            }
        }
        let moves = self.limited.iter().any(|limited| limited.step(k).norm() > 0.0);
        let fastest = Profile::fastest(law, limits);
        let (key, duration) = match (record.value("at"), record.value("duration")) {
            (Some(value), Some(other)) => {
                context.push(
                    Diagnostic::error("duplicate", "the time of a waypoint is given twice")
                        .at(context.place(&other.span), "a duration")
                        .also(context.place(&value.span), "the time of arrival"),
                );
                return None;
            }
            (Some(_), None) => ("at", record.quantity("at")? - begin),
            (None, Some(_)) => ("duration", record.quantity("duration")?),
            (None, None) => {
                if fastest.is_none() {
                    let message = match moves {
                        true => {
                            format!("a {law_name} move needs {}", law.needs(), law_name = name(law))
                        }
                        false => {
                            "the duration of the move to this waypoint is not given".to_owned()
                        }
                    };
                    context.push(
                        Diagnostic::error("missing-key", message)
                            .at(context.place(&record.table.span), "no time")
                            .help(
                                "give `duration` or `at`, or `limits` of a coordinate that moves",
                            ),
                    );
                }
                return fastest;
            }
        };
        let least = fastest.as_ref().map_or(0.0, |fastest| fastest.duration);
        if duration <= 0.0 || duration < least * (1.0 - ROUNDING) {
            let message = match duration <= 0.0 {
                true => "a move takes longer than no time".to_owned(),
                false => format!(
                    "the move takes {} s; within its limits it needs {} s",
                    number(duration),
                    number(least)
                ),
            };
            context.push(
                Diagnostic::error("range", message)
                    .at(context.place(&record.span(key)), "too short")
                    .help("allow more time"),
            );
            return None;
        }
        Some(match fastest {
            Some(fastest) => fastest.stretched(duration),
            None => Profile::lasting(law, duration),
        })
    }

    /// Checks that neighbouring moves may overlap, and that their sum stays within the limits.
    fn check_blend(&self, moves: &Moves, waypoint: usize, blend: f64, span: &Span) -> Option<()> {
        let context = self.reader.context;
        let [before, after] = moves.0.get(waypoint.checked_sub(1)?..=waypoint)? else {
            return None;
        };
        let most = before.profile.duration.min(after.profile.duration) / 2.0;
        let refuse = |message: String| {
            context.push(
                Diagnostic::error("range", message)
                    .at(context.place(span), "too long")
                    .help("shorten the blend, or stop at this waypoint"),
            );
        };
        if blend > most {
            refuse(format!(
                "the blend takes {} s; it can be half of the shorter of both moves, {} s",
                number(blend),
                number(most)
            ));
            return None;
        }
        for limited in self.limited {
            let (one, two) = (limited.step(waypoint - 1), limited.step(waypoint));
            for trial in 0..=TRIALS {
                let t = after.begin + blend * f64::from(trial) / f64::from(TRIALS);
                let [_, v1, a1] = before.profile.at(t - before.begin);
                let [_, v2, a2] = after.profile.at(t - after.begin);
                let sums = [(one * v1 + two * v2).norm(), (one * a1 + two * a2).norm()];
                let over =
                    [0, 1].into_iter().find(|&k| sums[k] > limited.limits[k] * (1.0 + ROUNDING));
                if let Some(k) = over {
                    let what = ["speed", "acceleration"][k];
                    let factor = sums[k] / limited.limits[k];
                    refuse(format!(
                        "in the blend the {what} of {} reaches {factor:.3} times its limit",
                        quoted(&limited.path)
                    ));
                    return None;
                }
            }
        }
        Some(())
    }
}

fn name(law: Law) -> &'static str {
    let named = |name: &&&str| Law::from_name(name) == Some(law);
    Law::NAMES.iter().find(named).copied().unwrap_or_default()
}

/// A time that must not be negative, by default 0; `None` after an error.
fn nonnegative(record: &Record<'_>, key: &str) -> Option<f64> {
    if record.value(key).is_none() {
        return Some(0.0);
    }
    let time = record.quantity(key)?;
    if time < 0.0 {
        record.context.push(
            Diagnostic::error(
                "range",
                format!("`{key}` is {} s, but must not be negative", number(time)),
            )
            .at(record.context.place(&record.span(key)), "negative"),
        );
        return None;
    }
    Some(time)
}
