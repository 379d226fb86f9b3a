//! Detection of accelerations that are inconsistent with the previous and the next ones.

/// Number of neighbours on either side from which accelerations are predicted. The nearest neighbours are omitted,
/// because a wrong sample also disturbs them.
const NEIGHBOURS: usize = 4;

/// Returns the distance of acceleration `i` from the nearest prediction; `None` near the ends of
/// the recording. Predictions are extrapolations from each side, the interval between these
/// extrapolations, and interpolations.
///
/// A step of the acceleration lies in the interval, a smooth signal near the extrapolations and
/// interpolations; a wrong sample is far from all predictions.
pub(super) fn excess(times: &[f64], found: &[Option<(f64, f64)>], i: usize) -> Option<f64> {
    let own = (*found.get(i)?)?.0;
    let mut before = [(0.0, 0.0); NEIGHBOURS];
    let mut after = [(0.0, 0.0); NEIGHBOURS];
    for k in 0..NEIGHBOURS {
        let (last, next) = (i.checked_sub(k + 2)?, i + k + 2);
        before[k] = (times[last] - times[i], (*found.get(last)?)?.0);
        after[k] = (times.get(next)? - times[i], (*found.get(next)?)?.0);
    }
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut least = f64::INFINITY;
    for order in 1..=NEIGHBOURS {
        let both: Vec<(f64, f64)> =
            before[..order].iter().chain(&after[..order]).copied().collect();
        least = least.min((at_zero(&both) - own).abs());
        for side in [at_zero(&before[..order]), at_zero(&after[..order])] {
            least = least.min((side - own).abs());
            if order < NEIGHBOURS {
                (low, high) = (low.min(side), high.max(side));
            }
        }
    }
    let outside = (low - own).max(own - high).max(0.0);
    least = least.min(outside);
    Some(least)
}

/// Deviation of an acceleration near an end of a recording.
#[derive(Clone, Copy, Debug)]
pub(super) struct AtEnd {
    /// Distance from the nearest prediction.
    pub(super) error: f64,
    /// Magnitude of the next acceleration towards the middle of the recording.
    pub(super) beside: f64,
    /// True if the next acceleration towards the end has the opposite sign, as where a wrong sample
    /// disturbs a coordinate at rest.
    pub(super) alternates: bool,
}

/// Compares acceleration `i`, near an end of the recording, with predictions. Returns `None` without
/// enough neighbours.
///
/// Predictions are extrapolations from accelerations towards the middle, and the interval between
/// the first of them and the next acceleration towards the end. A motion that begins or ends here
/// changes the acceleration gradually and lies between or near them. The accelerations that a wrong
/// sample disturbs have alternating signs, and the first of them is outside.
pub(super) fn excess_at_end(
    times: &[f64],
    found: &[Option<(f64, f64)>],
    i: usize,
) -> Option<AtEnd> {
    let own = (*found.get(i)?)?.0;
    let is_first = i < found.len() / 2;
    let at = |distance: usize| {
        let at = if is_first { i + distance } else { i.checked_sub(distance)? };
        Some((times.get(at)? - times[i], (*found.get(at)?)?.0))
    };
    let mut inner = [(0.0, 0.0); NEIGHBOURS + 1];
    for (k, point) in inner.iter_mut().enumerate() {
        *point = at(k + 1)?;
    }
    let far = (1..=NEIGHBOURS).map(|order| at_zero(&inner[1..=order]));
    let near = (1..NEIGHBOURS).map(|order| at_zero(&inner[..order]));
    let mut least = far.chain(near).map(|side| (side - own).abs()).fold(f64::INFINITY, f64::min);
    let outer = if is_first { i.checked_sub(1) } else { Some(i + 1) };
    let outer = outer.and_then(|at| *found.get(at)?);
    if let Some((outer, _)) = outer {
        let (low, high) = (outer.min(inner[1].1), outer.max(inner[1].1));
        least = least.min((low - own).max(own - high).max(0.0));
    }
    let alternates = outer.is_some_and(|(outer, _)| outer * own < 0.0);
    Some(AtEnd { error: least, beside: inner[0].1.abs(), alternates })
}

/// Value at 0 of the polynomial through points, by Neville's scheme.
pub(super) fn at_zero(points: &[(f64, f64)]) -> f64 {
    let mut values = [0.0; 2 * NEIGHBOURS];
    for (value, point) in values.iter_mut().zip(points) {
        *value = point.1;
    }
    for width in 1..points.len() {
        for k in 0..points.len() - width {
            let (a, b) = (points[k].0, points[k + width].0);
            values[k] = (b * values[k] - a * values[k + 1]) / (b - a);
        }
    }
    values[0]
}
