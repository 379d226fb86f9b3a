//! Least singularity indices in a chunk of the motion, without computing the indices of every
//! sample.
//!
//! Between two samples, a singular value changes by at most the norm of the change of its matrix
//! (Weyl). The sum of these norms along the motion therefore gives a lower bound of the index at
//! all samples between two samples with known indices. The index is computed only for samples at
//! which it may be least (Piyavskii 1972, Shubert 1972).

use super::solving::SampleResult;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;
use stiction_core::mechanism::Mechanism;
use stiction_core::parameters::Parameters;
use stiction_core::statics::{Distances, SingularityDistances, SingularityIndex};

/// Relative margin for the errors of singularity indices and for the rounding of their bounds.
const CERTAIN: f64 = 1e-8;

/// Sample whose singularity indices have not been computed: position of the sample in the chunk,
/// and bounds on the changes of the indices since the first postponed sample of the chunk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Postponed {
    place: usize,
    passed: Distances,
}

/// Samples of a chunk whose singularity indices have not been computed.
#[derive(Clone, Debug, Default)]
pub(super) struct LeastIndices {
    postponed: Vec<Postponed>,
    passed: Option<Distances>,
}

impl LeastIndices {
    /// Postpones the computation of the singularity indices of the sample at position `place` in
    /// the chunk; `travel` bounds the changes of the indices since the previous call.
    pub(super) fn postpone(&mut self, place: usize, travel: Distances) {
        let passed = match self.passed {
            // Changes are counted from the first postponed sample.
            None => Distances { actuation: 0.0, constraint: 0.0 },
            Some(passed) => Distances {
                actuation: passed.actuation + travel.actuation,
                constraint: passed.constraint + travel.constraint,
            },
        };
        self.passed = Some(passed);
        self.postponed.push(Postponed { place, passed });
    }

    /// Postpones the singularity indices of the sample at position `place` in the chunk, if the
    /// indices of sample `before` were postponed. Both samples must have the same configuration,
    /// and no other sample may have been postponed between them.
    pub(super) fn repeat(&mut self, before: usize, place: usize) {
        if let Some(&Postponed { passed, place: last }) = self.postponed.last()
            && last == before
        {
            self.postponed.push(Postponed { place, passed });
        }
    }

    /// Computes those postponed singularity indices that may be less than `known`, the least
    /// indices of all samples before the chunk, and updates `known`. The remaining postponed
    /// indices are NaN.
    pub(super) fn compute(
        &self,
        calculator: &mut SingularityDistances,
        known: &mut Distances,
        (mechanism, parameters): (&Mechanism, &Parameters<f64>),
        samples: &mut [SampleResult],
    ) {
        for index in [SingularityIndex::Actuation, SingularityIndex::Constraint] {
            let passed: Vec<f64> = self
                .postponed
                .iter()
                .map(|postponed| *of(index, &mut { postponed.passed }))
                .collect();
            let known = of(index, known);
            let found = least(&passed, known, |k, question| {
                // Only samples whose forces have a solution are postponed.
                let Ok(solved) = samples[self.postponed[k].place].found.as_ref() else {
                    return Some(f64::INFINITY);
                };
                let bodies = &solved.sample.bodies;
                match question {
                    Question::Exceeds(value) => {
                        calculator.exceeds(index, value, (parameters, bodies)).then_some(value)
                    }
                    Question::Value(expected) => {
                        let at = (mechanism, parameters, bodies);
                        Some(calculator.measure_one(index, expected, at))
                    }
                }
            });
            for (postponed, found) in self.postponed.iter().zip(found) {
                let solved = samples[postponed.place].found.as_mut();
                let (Some(value), Ok(solved)) = (found, solved) else { continue };
                *of(index, &mut solved.sample.distances) = value;
            }
        }
    }
}

fn of(index: SingularityIndex, distances: &mut Distances) -> &mut f64 {
    match index {
        SingularityIndex::Actuation => &mut distances.actuation,
        SingularityIndex::Constraint => &mut distances.constraint,
    }
}

/// Question about one value of a function, asked in the search for the least value.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Question {
    /// Asks for the value. The number, if given, is an estimate of the value.
    Value(Option<f64>),
    /// Asks whether this number is a lower bound of the value. The answer is the number, or `None`
    /// if the value may be less.
    Exceeds(f64),
}

/// Position of the tested lower bound between the least known value (0) and the expected value (1).
/// It is less than one, because the expected value is an estimate.
const ASKED: f64 = 0.98;

/// Computes the values of a function at all indices at which the value may be less than `least`,
/// and lowers `least` to the least computed value. Between two indices, the function changes by at
/// most the difference of `passed` between these indices. `ask` answers a question about the value
/// at an index. The result is `None` at indices without a computed value.
fn least(
    passed: &[f64],
    least: &mut f64,
    mut ask: impl FnMut(usize, Question) -> Option<f64>,
) -> Vec<Option<f64>> {
    let mut compute = |k: usize, question| ask(k, question).unwrap_or(f64::NEG_INFINITY);
    let mut found = vec![None; passed.len()];
    if passed.is_empty() {
        return found;
    }
    // A first value in the middle excludes ranges in which all values are far above the least
    // value.
    let half = 0.5 * passed[passed.len() - 1];
    let middle = passed.partition_point(|p| *p < half);
    let value = compute(middle, Question::Value(None));
    found[middle] = Some(value);
    *least = least.min(value);
    let mut gaps = BinaryHeap::new();
    let push = |gaps: &mut BinaryHeap<Bounded>, gap: Gap| {
        if !gap.inner.is_empty() {
            gaps.push(Bounded { bound: gap.bound(passed), gap });
        }
    };
    push(&mut gaps, Gap { from: None, to: Some((middle, value)), inner: 0..middle });
    let behind = middle + 1..passed.len();
    push(&mut gaps, Gap { from: Some((middle, value)), to: None, inner: behind });
    while let Some(Bounded { bound, gap }) = gaps.pop() {
        if bound > *least * (1.0 + CERTAIN) {
            break;
        }
        if let Some(value) = gap.constant(passed) {
            found[gap.inner].fill(Some(value));
            continue;
        }
        let (k, expected) = gap.next(passed);
        // To prove that a value exceeds the least value is cheaper than to compute the value.
        let asked = *least + ASKED * (expected - *least);
        let is_useful = asked > *least * (1.0 + 2.0 * CERTAIN);
        let mut value = match is_useful {
            true => compute(k, Question::Exceeds(asked)),
            false => f64::NEG_INFINITY,
        };
        if value == f64::NEG_INFINITY {
            value = compute(k, Question::Value(Some(expected)));
            found[k] = Some(value);
            *least = least.min(value);
        }
        let known = Some((k, value));
        push(&mut gaps, Gap { from: gap.from, to: known, inner: gap.inner.start..k });
        push(&mut gaps, Gap { from: known, to: gap.to, inner: k + 1..gap.inner.end });
    }
    found
}

/// Range of indices without computed values. `from` and `to` are the indices directly before and
/// after the range, each with the value of the function or a lower bound of it. At least one of
/// them is given.
#[derive(Clone, Debug)]
struct Gap {
    from: Option<(usize, f64)>,
    to: Option<(usize, f64)>,
    inner: Range<usize>,
}

/// Range without computed values, and a lower bound of these values. The greatest element in the
/// order of this type has the least bound.
#[derive(Clone, Debug)]
struct Bounded {
    bound: f64,
    gap: Gap,
}

impl Ord for Bounded {
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound)
    }
}

impl PartialOrd for Bounded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Bounded {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Bounded {}

impl Gap {
    /// Returns a lower bound of the values in the range.
    fn bound(&self, passed: &[f64]) -> f64 {
        let inner = &passed[self.inner.clone()];
        match (self.from, self.to) {
            (Some(from), Some(to)) => 0.5 * (from.1 + to.1 - (passed[to.0] - passed[from.0])),
            (Some(from), None) => from.1 - (inner[inner.len() - 1] - passed[from.0]),
            (None, Some(to)) => to.1 - (passed[to.0] - inner[0]),
            (None, None) => f64::NEG_INFINITY,
        }
    }

    /// Returns the value of the function in the whole range, if `passed` does not change between
    /// the range and a known value next to it.
    fn constant(&self, passed: &[f64]) -> Option<f64> {
        let inner = &passed[self.inner.clone()];
        let known = self.from.or(self.to)?;
        let ends = [inner[0], inner[inner.len() - 1]];
        ends.iter().all(|end| *end == passed[known.0]).then_some(known.1)
    }

    /// Returns the index in the range at which the function may attain its lower bound, and the
    /// value that is expected at this index.
    fn next(&self, passed: &[f64]) -> (usize, f64) {
        match (self.from, self.to) {
            (Some(from), Some(to)) => {
                let crossing = 0.5 * (from.1 - to.1 + passed[from.0] + passed[to.0]);
                let inner = &passed[self.inner.clone()];
                let place = inner.partition_point(|p| *p < crossing).min(inner.len() - 1);
                let k = self.inner.start + place;
                let travel = passed[to.0] - passed[from.0];
                let part = (passed[k] - passed[from.0]) / travel;
                (k, from.1 + part * (to.1 - from.1))
            }
            (Some(from), None) => (self.inner.end - 1, from.1),
            (None, to) => (self.inner.start, to.map_or(0.0, |to| to.1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Question, least};

    /// Answers a question about a function with the value `value`.
    fn answer(value: f64, question: Question) -> Option<f64> {
        match question {
            Question::Value(_) => Some(value),
            Question::Exceeds(bound) => (value > bound).then_some(bound),
        }
    }

    /// Checks that the least value is computed at the first index at which it occurs, and that most
    /// other values are not computed.
    #[test]
    fn the_least_value_is_always_computed() {
        let count = 256;
        let functions: [fn(f64) -> f64; 5] = [
            |t| 2.0 - t,
            |t| 1.0 + (t - 0.3).powi(2),
            |t| 0.5 + 0.1 * (9.0 * t).sin(),
            |t| (t - 0.7).abs(),
            |t| 0.3 + 0.01 * (40.0 * t).cos() + 0.2 * t,
        ];
        for (number, function) in functions.into_iter().enumerate() {
            let values: Vec<f64> = (0..count).map(|k| function(f64::from(k) / 255.0)).collect();
            // Each bound on a change is ten times the change, because matrices change more than
            // their singular values.
            let mut passed = vec![0.0];
            for pair in values.windows(2) {
                passed.push(passed[passed.len() - 1] + 10.0 * (pair[1] - pair[0]).abs() + 1e-6);
            }
            let expected = values.iter().copied().fold(f64::INFINITY, f64::min);
            let first = values.iter().position(|value| *value == expected).unwrap();
            let mut known = f64::INFINITY;
            let mut questions = 0;
            let found = least(&passed, &mut known, |k, question| {
                questions += 1;
                answer(values[k], question)
            });
            assert_eq!((found[first], known), (Some(expected), expected), "{number}");
            let computed = found.iter().flatten().count();
            assert!(computed < 100 && questions < 200, "{number}: {computed} {questions}");
            // If all values are far above the known least value, one computation suffices to show
            // it.
            let mut below = expected - 12.0 * passed[passed.len() - 1];
            let found = least(&passed, &mut below, |k, question| answer(values[k], question));
            assert_eq!(found.iter().flatten().count(), 1, "{number}");
        }
    }

    /// Checks that only one sample is computed while the mechanism rests, and that all samples of
    /// the rest get the computed value.
    #[test]
    fn a_dwell_is_computed_once() {
        let mut calls = 0;
        let mut known = f64::INFINITY;
        let found = least(&[1.0; 100], &mut known, |_, _| {
            calls += 1;
            Some(0.25)
        });
        assert_eq!((calls, found), (1, vec![Some(0.25); 100]));
        assert_eq!(least(&[], &mut known, |_, _| None), []);
        assert_eq!(least(&[0.0], &mut known, |_, _| Some(0.125)), [Some(0.125)]);
        assert_eq!(known, 0.125);
    }
}
