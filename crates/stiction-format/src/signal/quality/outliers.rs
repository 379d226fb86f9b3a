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

/// Returns the distance of acceleration `i`, near an end of the recording, from the nearest
/// extrapolation. The extrapolations use accelerations between sample `i` and the middle of the
/// recording. Returns `None` without enough neighbours.
pub(super) fn excess_at_end(times: &[f64], found: &[Option<(f64, f64)>], i: usize) -> Option<f64> {
    let own = (*found.get(i)?)?.0;
    let is_first = i < found.len() / 2;
    let mut side = [(0.0, 0.0); NEIGHBOURS];
    for (k, point) in side.iter_mut().enumerate() {
        let at = if is_first { i + k + 2 } else { i.checked_sub(k + 2)? };
        *point = (times.get(at)? - times[i], (*found.get(at)?)?.0);
    }
    (1..=NEIGHBOURS).map(|order| (at_zero(&side[..order]) - own).abs()).reduce(f64::min)
}

/// Value at 0 of the polynomial through points, by Neville's scheme.
fn at_zero(points: &[(f64, f64)]) -> f64 {
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
