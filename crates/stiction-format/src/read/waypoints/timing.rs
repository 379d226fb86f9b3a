//! Durations of the moves between waypoints.

use super::Channel;
use super::curve::Curve;
use super::fastest::fastest;
use super::limits::Limited;
use crate::diagnostic::{Diagnostic, least, number};
use crate::document::Table;
use crate::fields::tables::WAYPOINT;
use crate::read::context::Record;
use crate::read::motion::Reader;
use crate::signal::law::{Law, Limits, Profile, UNLIMITED};
use crate::signal::waypoints::{Move, Moves};
use crate::source::Span;
use std::sync::Arc;

/// Relative tolerance of limits, which allows for the rounding of durations.
pub(super) const ROUNDING: f64 = 1e-9;

/// Data from which the durations of the moves are determined.
pub(super) struct Timing<'a> {
    pub(super) reader: &'a Reader<'a>,
    pub(super) motion: &'a Record<'a>,
    pub(super) limited: &'a [Limited],
    pub(super) channels: &'a [Channel],
    pub(super) tables: &'a [&'a Table],
    /// True if the waypoints contain orientations; moves then cannot overlap.
    pub(super) turns: bool,
}

impl Timing<'_> {
    pub(super) fn moves(&self, start: f64) -> Option<Arc<Moves>> {
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
                        (_, true) => "at a waypoint with a `dwell`",
                        _ => "between waypoints with a `rotation`",
                    };
                    context.push(
                        Diagnostic::error("motion", format!("`blend` is not possible {why}"))
                            .at(context.place(&record.span("blend")), "the motion stops here")
                            .help("delete `blend`"),
                    );
                    return None;
                }
                blends.push((index, blend, record.span("blend")));
            }
            free += dwell;
        }
        let moves = Arc::new(Moves(moves));
        for (waypoint, blend, span) in &blends {
            self.check_blend((&moves, start), *waypoint, *blend, span)?;
        }
        Some(moves)
    }

    /// Determines the profile of move `k`, which begins at time `begin`, s, and ends at the
    /// waypoint of `record`. Reports an error and returns `None` if the duration of the move is
    /// missing or too short.
    fn profile(&self, k: usize, record: &Record<'_>, law: Law, begin: f64) -> Option<Profile> {
        let context = self.reader.context;
        let mut limits = UNLIMITED;
        for limited in self.limited {
            let distance = limited.step(k).norm();
            for (limit, given) in limits.iter_mut().zip(limited.limits) {
                // A quantity that does not change in this move does not limit its duration.
                if distance > 0.0 {
                    *limit = limit.min(given / distance);
                }
            }
        }
        let curves: Vec<(&[Curve], Limits)> = self
            .limited
            .iter()
            .filter_map(|limited| Some((limited.curve(k)?, limited.limits)))
            .collect();
        let moves = self.limited.iter().any(|limited| limited.step(k).norm() > 0.0);
        let moves = moves || !curves.is_empty();
        let fastest = fastest(law, limits, &curves);
        let (key, duration) = match (record.value("at"), record.value("duration")) {
            (Some(value), Some(other)) => {
                context.push(
                    Diagnostic::error("duplicate", "the time of a waypoint is given twice")
                        .at(context.place(&other.span), "a duration")
                        .also(context.place(&value.span), "the time of arrival")
                        .help("keep `at` or `duration`"),
                );
                return None;
            }
            (Some(_), None) => ("at", record.quantity("at")? - begin),
            (None, Some(_)) => ("duration", record.quantity("duration")?),
            (None, None) => {
                if fastest.is_none() {
                    let message = match moves {
                        true => {
                            format!(
                                "a {law_name} move needs {}",
                                law.needs(),
                                law_name = law.name()
                            )
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
        let shortest = fastest.as_ref().map_or(0.0, |fastest| fastest.duration);
        if duration <= 0.0 || duration < shortest * (1.0 - ROUNDING) {
            let message = match duration <= 0.0 {
                true => format!(
                    "the move to this waypoint takes {} s, but must take more than 0 s",
                    number(duration)
                ),
                false => format!(
                    "the move takes {} s, but its limits require at least {} s",
                    number(duration),
                    least(shortest)
                ),
            };
            context.push(
                Diagnostic::error("range", message)
                    .at(context.place(&record.span(key)), "too short")
                    .help("give a longer `duration`, or a later `at`"),
            );
            return None;
        }
        Some(match fastest {
            Some(fastest) => fastest.stretched(duration),
            None => Profile::lasting(law, duration),
        })
    }
}

/// Reads a time, s, that must not be negative. Returns 0 if the key is missing; reports an error
/// and returns `None` if the time is invalid.
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
