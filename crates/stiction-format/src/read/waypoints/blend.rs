//! Checks of blends at waypoints. In a blend, two consecutive moves overlap in time, and the sum of
//! both must stay within the limits of speed, acceleration and jerk.

use super::curve::largest;
use super::fastest::magnitudes;
use super::limits::LimitedPath;
use super::timing::{ROUNDING, Timing};
use super::trace::{self, Goals};
use crate::diagnostic::{Diagnostic, number, quoted};
use crate::document::{Key, Value};
use crate::signal::waypoints::{Move, Moves};
use crate::source::Span;
use std::sync::Arc;

/// Number of bisections in the search for the longest blend within the limits.
const HALVINGS: usize = 12;
/// Fractions of a blend's duration that the search for the longest blend tries first. If the blend
/// with the smaller fraction exceeds a limit, every blend does. If the mechanism cannot follow that
/// blend, the larger fraction is tried, because rounding may hide the joint motion in so short an
/// interval.
const SHORTEST: [f64; 2] = [1e-3, 0.03];
/// Advice for a blend whose longest possible duration is unknown.
const SHORTEN: &str = "shorten the blend, or stop at this waypoint";

/// A limit that a blend exceeds.
struct Excess {
    path: String,
    /// Exceeded quantity: 0 for speed, 1 for acceleration, 2 for jerk.
    what: usize,
    /// Ratio of the largest value of the quantity during the blend to its limit.
    factor: f64,
}

impl Timing<'_> {
    /// Checks a blend of `blend` seconds at a waypoint, in which the moves to and from the waypoint
    /// overlap. Reports an error and returns `None` if the blend is longer than half of the shorter
    /// move, if the sum of the moves exceeds a limit, or if the mechanism cannot follow it.
    pub(super) fn check_blend(
        &self,
        (moves, start): (&Arc<Moves>, f64),
        waypoint: usize,
        blend: f64,
        span: &Span,
    ) -> Option<()> {
        let context = self.reader.context;
        let refuse = |message: String, help: &str| {
            context.push(
                Diagnostic::error("range", message).at(context.place(span), "too long").help(help),
            );
        };
        let [before, after] = moves.0.get(waypoint.checked_sub(1)?..=waypoint)? else {
            return None;
        };
        let most = before.profile.duration.min(after.profile.duration) / 2.0;
        if blend > most {
            let (blend, most) = (number(blend), number(most));
            refuse(
                format!(
                    "the blend takes {blend} s, but can take at most half of the shorter of its \
                     two moves, {most} s"
                ),
                SHORTEN,
            );
            return None;
        }
        match self.excess((moves, start), waypoint) {
            Ok(None) => Some(()),
            Ok(Some(Excess { path, what, factor })) => {
                let what = ["speed", "acceleration", "jerk"][what];
                // If the time of arrival at the next waypoint is given, a shorter blend would also
                // shorten the move to that waypoint.
                let arrives = |(key, _): &(Key, Value)| key.name == "at";
                let fixed = self.tables.get(waypoint + 1)?.entries.iter().any(arrives);
                let help = match self.longest((moves, start), waypoint, blend) {
                    Ok(Some(_)) if fixed => SHORTEN.to_owned(),
                    Ok(Some(longest)) => {
                        format!("the longest blend within the limits takes {longest} s")
                    }
                    Err(()) => SHORTEN.to_owned(),
                    Ok(None) => format!(
                        "no blend is short enough: both moves have their greatest {what} at this waypoint; use a \
                         smoother `law`, raise the limit, or stop here"
                    ),
                };
                let path = quoted(&path);
                refuse(
                    format!(
                        "in the blend the {what} of {path} reaches {factor:.3} times its limit"
                    ),
                    &help,
                );
                None
            }
            Err(()) => {
                refuse("the mechanism cannot follow the blend".to_owned(), SHORTEN);
                None
            }
        }
    }

    /// Returns the duration, s, of the longest blend at a waypoint that stays within all limits,
    /// rounded down to three digits; `None` if even a very short blend exceeds a limit. `blend` is
    /// the duration, s, of the blend in `moves`.
    ///
    /// # Errors
    /// Returns an error if the mechanism cannot follow one of the blends that are tried.
    fn longest(
        &self,
        (moves, start): (&Arc<Moves>, f64),
        waypoint: usize,
        blend: f64,
    ) -> Result<Option<String>, ()> {
        let keeps = |shorter: f64| {
            let later = |(k, each): (usize, &Move)| {
                let delay = if k < waypoint { 0.0 } else { blend - shorter };
                Move { begin: each.begin + delay, profile: each.profile.clone() }
            };
            let moves = Arc::new(Moves(moves.0.iter().enumerate().map(later).collect()));
            self.excess((&moves, start), waypoint).map(|excess| excess.is_none())
        };
        let [shortest, short] = SHORTEST.map(|part| part * blend);
        let mut low = match keeps(shortest) {
            Ok(true) => shortest,
            Ok(false) => return Ok(None),
            Err(()) if keeps(short)? => short,
            Err(()) => return Err(()),
        };
        let mut high = blend;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if keeps(middle)? { low = middle } else { high = middle }
        }
        let places = 10f64.powf(2.0 - low.log10().floor());
        Ok(Some(number((low * places).floor() / places)))
    }

    /// Returns a limit that is exceeded while the moves to and from a waypoint overlap; `None` if
    /// no limit is exceeded. `start` is the time, s, at which the motion starts.
    ///
    /// # Errors
    /// Returns an error if the mechanism cannot follow the motion during the overlap.
    fn excess(
        &self,
        (moves, start): (&Arc<Moves>, f64),
        waypoint: usize,
    ) -> Result<Option<Excess>, ()> {
        let (before, after) = (&moves.0[waypoint - 1], &moves.0[waypoint]);
        // Corners are the times, s, at which a move or one of its phases begins or ends. Between
        // corners, both moves are smooth.
        let mut corners = vec![after.begin, before.end()];
        for each in [before, after] {
            let own = each.profile.phases().into_iter().map(|time| each.begin + time);
            corners.extend(own.filter(|time| *time > after.begin && *time < before.end()));
        }
        corners.sort_by(f64::total_cmp);
        let blend = before.end() - after.begin;
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
                trace::between(self.reader, &goals, self.limited, (start, &corners)).ok_or(())?
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
            if let Some(what) = (0..3).find(|&k| peaks[k] > limited.limits[k] * (1.0 + ROUNDING)) {
                let factor = peaks[what] / limited.limits[what];
                return Ok(Some(Excess { path: limited.path.clone(), what, factor }));
            }
        }
        Ok(None)
    }
}
