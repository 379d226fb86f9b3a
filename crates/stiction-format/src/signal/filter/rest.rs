//! Rest of filtered signals: dwells, and rest at the beginning or end of a recording.
//!
//! A robot that stands still has zero rate, but filtered noise has a nonzero rate, whose sign would determine the
//! direction of friction. Rest is therefore imposed as a condition of the fit where the samples are consistent with
//! rest: rate and acceleration differ from zero by less than three standard deviations, and the sum of squares grows
//! by no more than noise explains. The spline is constant between two knots if all of its coefficients there are
//! equal, so equal coefficients become one unknown.

use super::super::banded::Banded;
use super::super::bspline::ORDER;
use super::knots::{BAND, EqualKnots};
use super::{Equations, KNOTS_PER_PERIOD, Solution, dot};
use std::ops::RangeInclusive;
use stiction_core::kinematics::Target;

/// Largest deviation of rate and acceleration from zero, in standard deviations of their noise, at
/// which a knot is consistent with rest.
const SIGMAS: f64 = 3.0;
/// Number of knots removed from an interval of rest where it borders on motion, because the filter spreads the
/// beginning of the motion.
const BORDER: usize = 2;
/// Minimum length of a dwell in knots: one period of the cut-off frequency.
const MIN_DWELL: usize = KNOTS_PER_PERIOD as usize;

/// Interval of time, s, in which a signal is at rest: a dwell, or a single instant at an end of the
/// recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rest {
    pub(crate) from: f64,
    pub(crate) until: f64,
}

/// Condition of rest that a fit must satisfy. The numbers are indices of knots.
#[derive(Clone, Debug, PartialEq)]
enum Condition {
    /// The signal is constant from the first to the last knot of the range.
    Dwell(RangeInclusive<usize>),
    /// Rate and acceleration are zero at this knot, which is the first or the last.
    End(usize),
    /// The rate is zero at this knot, which is the first or the last; the acceleration is free.
    Stop(usize),
}

impl Condition {
    /// Range of the spline coefficients that the condition makes equal.
    fn merged(&self, knots: &EqualKnots) -> RangeInclusive<usize> {
        let last = knots.size() - 1;
        match self {
            Self::Dwell(range) => *range.start()..=range.end() + ORDER - 2,
            Self::End(0) => 0..=2,
            Self::End(_) => last - 2..=last,
            Self::Stop(0) => 0..=1,
            Self::Stop(_) => last - 1..=last,
        }
    }

    fn rest(&self, knots: &EqualKnots) -> Option<Rest> {
        let (from, until) = match self {
            Self::Dwell(range) => (*range.start(), *range.end()),
            Self::End(knot) => (*knot, *knot),
            Self::Stop(_) => return None,
        };
        Some(Rest { from: knots.knot(from), until: knots.knot(until) })
    }
}

/// Fit of a signal that satisfies conditions of rest.
pub(super) struct Rested<'a> {
    equations: &'a Equations,
    coefficients: Vec<f64>,
    /// For each coefficient, the index of its unknown; equal coefficients have the same unknown.
    unknowns: Vec<usize>,
    pub(super) rests: Vec<Rest>,
}

/// Fits a signal again, with conditions of rest where the samples are consistent with rest. `free`
/// are the spline coefficients of the fit without conditions, `noise` is the standard deviation of
/// the signal's noise.
pub(super) fn impose<'a>(
    solution: &Solution<'a>,
    signal: usize,
    free: &[f64],
    noise: f64,
) -> Rested<'a> {
    let equations = solution.equations;
    let variance = noise * noise * equations.step();
    let explained = dot(free, &equations.rights[signal]);
    let is_consistent = |rested: &Rested<'_>| {
        let lost = explained - dot(&rested.coefficients, &equations.rights[signal]);
        let conditions = (free.len() - rested.unknown_count()) as f64;
        lost <= variance * (conditions + 2.0 * SIGMAS * (2.0 * conditions).sqrt())
    };
    let still = still_knots(solution, free, noise);
    // Dwells are tried first, then shortened dwells, then rest at the ends alone.
    for border in [Some(BORDER), Some(2 * BORDER), Some(4 * BORDER), None] {
        let conditions = conditions(&still, border);
        let rested = Rested::new(equations, signal, &conditions);
        if conditions.is_empty() || is_consistent(&rested) {
            return rested;
        }
    }
    Rested::new(equations, signal, &[])
}

/// Returns two flags for each knot. The first flag is true if the rate is consistent with zero, the
/// second if the acceleration is.
fn still_knots(solution: &Solution<'_>, c: &[f64], noise: f64) -> Vec<[bool; 2]> {
    let knots = &solution.equations.knots;
    let is_still = |knot: usize| {
        let (first, weights) = knots.derivative_weights(knot);
        let spread = solution.spread(knot);
        std::array::from_fn(|order| {
            let value = dot(&weights[order], c.get(first..first + ORDER).unwrap_or_default());
            value.abs() <= SIGMAS * noise * spread[order]
        })
    };
    (0..=knots.intervals).map(is_still).collect()
}

/// Determines the conditions of rest from the flags of [`still_knots`]. Each dwell is shortened by
/// `border` knots where it borders on motion. Without `border`, rest is imposed only at the ends.
fn conditions(still: &[[bool; 2]], border: Option<usize>) -> Vec<Condition> {
    let last = still.len() - 1;
    let mut found: Vec<Condition> = Vec::new();
    let mut knot = 0;
    while let Some(border) = border
        && knot <= last
    {
        let length = still.iter().skip(knot).take_while(|still| **still == [true; 2]).count();
        let end = knot + length;
        if length > 0 {
            let from = if knot == 0 { 0 } else { knot + border };
            let until = if end > last { last } else { (end - 1).saturating_sub(border) };
            let is_long = until >= from + MIN_DWELL;
            // Between two dwells, the spline needs at least five intervals to move.
            let is_apart = match found.last() {
                Some(Condition::Dwell(before)) => from >= before.end() + ORDER,
                _ => true,
            };
            if is_long && is_apart {
                found.push(Condition::Dwell(from..=until));
            }
        }
        knot = end.max(knot) + 1;
    }
    for end in [0, last] {
        let is_covered = found
            .iter()
            .any(|known| matches!(known, Condition::Dwell(range) if range.contains(&end)));
        match still[end] {
            _ if is_covered => {}
            [true, true] => found.push(Condition::End(end)),
            [true, false] => found.push(Condition::Stop(end)),
            _ => {}
        }
    }
    // `Rested::new` needs the conditions in increasing order of their coefficients.
    found.sort_by_key(|condition| match condition {
        Condition::Dwell(range) => *range.start(),
        Condition::End(knot) | Condition::Stop(knot) => *knot,
    });
    found
}

impl<'a> Rested<'a> {
    fn new(equations: &'a Equations, signal: usize, conditions: &[Condition]) -> Self {
        let knots = &equations.knots;
        let mut unknowns: Vec<usize> = Vec::with_capacity(knots.size());
        let mut rests = Vec::new();
        let mut all = conditions.iter().map(|condition| (condition, condition.merged(knots)));
        let mut next = all.next();
        for coefficient in 0..knots.size() {
            while let Some((condition, merged)) = &next
                && *merged.end() < coefficient
            {
                rests.extend(condition.rest(knots));
                next = all.next();
            }
            let joins = next
                .as_ref()
                .is_some_and(|(_, m)| m.contains(&coefficient) && *m.start() != coefficient);
            let number = match unknowns.last() {
                None => 0,
                Some(last) if joins => *last,
                Some(last) => last + 1,
            };
            unknowns.push(number);
        }
        rests
            .extend(next.into_iter().chain(all).filter_map(|(condition, _)| condition.rest(knots)));
        let count = unknowns.last().map_or(0, |last| last + 1);
        let (full, mut matrix) = (equations.matrix(), Banded::new(count, BAND));
        let mut right = vec![0.0; count];
        for (row, &i) in unknowns.iter().enumerate() {
            for column in row.saturating_sub(BAND)..(row + BAND + 1).min(unknowns.len()) {
                matrix.add(i, unknowns[column], full.get(row, column));
            }
            right[i] += equations.rights[signal][row];
        }
        matrix.factor().solve(&mut right);
        let coefficients = unknowns.iter().map(|&i| right[i]).collect();
        Self { equations, coefficients, unknowns, rests }
    }

    fn unknown_count(&self) -> usize {
        self.unknowns.last().map_or(0, |last| last + 1)
    }

    /// Returns value, rate and acceleration at all knots; `offset` is added to the values.
    pub(super) fn knots(&self, offset: f64) -> Vec<Target<f64>> {
        let knots = &self.equations.knots;
        let mut all: Vec<Target<f64>> =
            (0..=knots.intervals).map(|k| knots.target_at(&self.coefficients, k)).collect();
        // Where all coefficients are equal, the spline is constant. Set its derivatives exactly to
        // zero, as rounding errors would remain otherwise.
        for (interval, equal) in self.unknowns.windows(ORDER).enumerate() {
            if equal.first() == equal.last() {
                let value = self.coefficients[interval];
                for knot in [interval, interval + 1] {
                    all[knot] = Target { value, rate: 0.0, acceleration: 0.0 };
                }
            }
        }
        for knot in &mut all {
            knot.value += offset;
        }
        all
    }
}
