//! Durations of the moves between waypoints.

use super::Channel;
use super::curve::{Curve, largest};
use super::fastest::{fastest, magnitudes};
use super::limits::{Limited, LimitedPath};
use super::trace::{self, Goals};
use crate::diagnostic::{Diagnostic, number, quoted};
use crate::document::Table;
use crate::fields::tables::WAYPOINT;
use crate::read::context::Record;
use crate::read::motion::Reader;
use crate::signal::law::{Law, Limits, Profile, UNLIMITED};
use crate::signal::waypoints::{Move, Moves};
use crate::source::Span;
use std::sync::Arc;

/// Relative tolerance of limits, for the rounding of durations.
const ROUNDING: f64 = 1e-9;

/// Determines the durations of the moves.
pub(super) struct Timing<'a> {
    pub(super) reader: &'a Reader<'a>,
    pub(super) motion: &'a Record<'a>,
    pub(super) limited: &'a [Limited],
    pub(super) channels: &'a [Channel],
    pub(super) tables: &'a [&'a Table],
    /// True if the waypoints include orientations; moves then do not overlap.
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
        let moves = Arc::new(Moves(moves));
        for (waypoint, blend, span) in &blends {
            self.check_blend((&moves, start), *waypoint, *blend, span)?;
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
                // A move without displacement has no limit.
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

    /// Checks if neighbouring moves may overlap, and that their sum stays within the limits.
    fn check_blend(
        &self,
        (moves, start): (&Arc<Moves>, f64),
        waypoint: usize,
        blend: f64,
        span: &Span,
    ) -> Option<()> {
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
        // Between corners, both moves are smooth.
        let mut corners = vec![after.begin, before.end()];
        for each in [before, after] {
            let own = each.profile.phases().into_iter().map(|time| each.begin + time);
            corners.extend(own.filter(|time| *time > after.begin && *time < before.end()));
        }
        corners.sort_by(f64::total_cmp);
        corners.dedup_by(|a, b| *a - *b <= ROUNDING * blend);
        let state = |each: &Move, interval: usize, t: f64| {
            let middle = 0.5 * (corners[interval] + corners[interval + 1]);
            each.profile.in_phase(each.profile.phase(middle - each.begin), t - each.begin)
        };
        let has_joints =
            self.limited.iter().any(|limited| matches!(limited.way, LimitedPath::Followed(_)));
        let curves = match has_joints {
            true => {
                let goals = Goals::new(self.channels, moves);
                let way = trace::between(self.reader, &goals, self.limited, (start, &corners));
                if way.is_none() {
                    refuse("the mechanism cannot follow the blend".to_owned());
                }
                way?
            }
            false => Vec::new(),
        };
        let mut joint = 0;
        for limited in self.limited {
            let (one, two) = (limited.step(waypoint - 1), limited.step(waypoint));
            let peaks = match &limited.way {
                LimitedPath::Straight(_) => largest(&corners, true, |interval, t| {
                    let [_, v1, a1, j1] = state(before, interval, t);
                    let [_, v2, a2, j2] = state(after, interval, t);
                    [(v1, v2), (a1, a2), (j1, j2)].map(|(a, b)| (one * a + two * b).norm())
                }),
                LimitedPath::Followed(_) => {
                    joint += 1;
                    largest(&corners, true, |interval, t| {
                        magnitudes(curves[interval][joint - 1].iter().map(|curve| curve.at(t)))
                    })
                }
            };
            let over = (0..3).find(|&k| peaks[k] > limited.limits[k] * (1.0 + ROUNDING));
            if let Some(k) = over {
                let what = ["speed", "acceleration", "jerk"][k];
                let factor = peaks[k] / limited.limits[k];
                refuse(format!(
                    "in the blend the {what} of {} reaches {factor:.3} times its limit",
                    quoted(&limited.path)
                ));
                return None;
            }
        }
        Some(())
    }
}

/// Reads a time that must not be negative, by default 0; `None` after an error.
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
