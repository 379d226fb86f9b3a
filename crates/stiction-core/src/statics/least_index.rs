//! Search for the least singularity index along a motion.

/// Largest number of steps of a search. Without parabolas, a step shortens the interval by the
/// golden ratio on average.
const STEPS: usize = 60;
/// Indices that differ by at most this value count as equal.
const SAME: f64 = 1e-13;
/// Index above which a minimum along the motion is smooth, not a passage.
const SMOOTH: f64 = 1e-6;
/// Distance of the two least points of a search, as a fraction of the searched interval, from which
/// the parabola through the three least points is accurate.
const CLOSE: f64 = 1e-3;
/// Length of the shorter part of an interval divided by the golden ratio.
const SHORTER_PART: f64 = 0.381_966_011_250_105;

/// Least singularity index along a motion.
#[derive(Clone, Copy, Debug)]
pub struct LeastIndex<T> {
    /// Least index found.
    pub index: f64,
    /// Time of the least index found, s.
    pub time: f64,
    /// Configuration at this time.
    pub configuration: T,
    /// Time at which the singularity index vanishes, s, by linear extrapolation from both sides.
    pub passage: f64,
}

/// Locates the least singularity index between the first and the last of three points, pairs of
/// time and index, of which the second has the least index, except for rounding. `at` computes the
/// index and the configuration at a time, or returns `None` if they are undetermined there;
/// `configuration` is the one at the second point.
///
/// Successive parabolic interpolation, with golden-section steps where it does not converge (Brent
/// 1973). The parabolas interpolate the squared index, which is smooth even where the index passes
/// zero.
pub fn least_index<T>(
    [mut low, mut least, mut high]: [(f64, f64); 3],
    mut configuration: T,
    mut at: impl FnMut(f64) -> Option<(f64, T)>,
) -> LeastIndex<T> {
    // The second and third least points, and the last two steps.
    let (mut second, mut third) = if low.1 < high.1 { (low, high) } else { (high, low) };
    let span = high.0 - low.0;
    let (mut step, mut step_before) = (span, span);
    for _ in 0..STEPS {
        let time = least.0;
        let (back, ahead) = (low.0 - time, high.0 - time);
        let smallest = 1e-14 * low.0.abs().max(high.0.abs());
        if ahead - back <= 4.0 * smallest {
            break;
        }
        let vertex = vertex([least, second, third]);
        // Close to a smooth minimum, the parabola shows that the index decreases no further.
        let is_close = (second.0 - time).abs() < CLOSE * span;
        if let Some((_, decrease)) = vertex
            && is_close
            && least.1 > SMOOTH
            && decrease <= 2.0 * least.1 * SAME
        {
            break;
        }
        let last_but_one = core::mem::replace(&mut step_before, step);
        step = match vertex.map(|(step, _)| step) {
            Some(x) if x > back && x < ahead && 2.0 * x.abs() < last_but_one.abs() => x,
            _ => {
                step_before = if ahead > -back { ahead } else { back };
                SHORTER_PART * step_before
            }
        };
        // A step that is too short would repeat a known point.
        step = step.clamp(back + smallest, ahead - smallest);
        if step.abs() < smallest {
            step = smallest.copysign(ahead + back);
        }
        // At the singular pose itself the motion may be undetermined.
        let parts = [1.0, 1.0 - 1e-6, 1.0 - 1e-4, 0.99, 0.9, 0.5, 0.1].into_iter();
        let mut nearby = parts.map(|part| time + part * step);
        let Some((time, (index, found))) = nearby.find_map(|time| Some((time, at(time)?))) else {
            break;
        };
        let next = (time, index);
        let is_flat = [next, second].iter().all(|other| (other.1 - least.1).abs() <= SAME);
        if next.1 <= least.1 {
            *(if time > least.0 { &mut low } else { &mut high }) = least;
            (third, second, least) = (second, least, next);
            configuration = found;
        } else {
            *(if time > least.0 { &mut high } else { &mut low }) = next;
            if next.1 <= second.1 {
                (third, second) = (second, next);
            } else if next.1 <= third.1 {
                third = next;
            }
        }
        // The instant of a smooth minimum is accurate only to the square root of the rounding
        // error.
        if is_flat && least.1 > SMOOTH {
            break;
        }
    }
    let passage = tip([low, least, high]);
    LeastIndex { index: least.1, time: least.0, configuration, passage }
}

/// Returns the time at which a singularity index vanishes, close to the least of three points. The
/// points are pairs of time and index in chronological order, and the second is the least. Near its
/// zero the index is V-shaped, with the same slope on both sides: the steeper chord lies on one side
/// of the tip, the other chord includes the tip.
fn tip([low, least, high]: [(f64, f64); 3]) -> f64 {
    let falls = (low.1 - least.1) / (least.0 - low.0);
    let rises = (high.1 - least.1) / (high.0 - least.0);
    let time = least.0 + if falls >= rises { least.1 / falls } else { -least.1 / rises };
    if time.is_finite() { time.clamp(low.0, high.0) } else { least.0 }
}

/// Returns the step from the first of three points, pairs of time and index, to the vertex of the
/// parabola through the squared indices, and the decrease of the squared index in this step; `None`
/// if the points lie on no parabola with a minimum.
fn vertex([(origin, value), second, third]: [(f64, f64); 3]) -> Option<(f64, f64)> {
    let relative = |point: (f64, f64)| (point.0 - origin, point.1.powi(2) - value.powi(2));
    let ((a, above_a), (b, above_b)) = (relative(second), relative(third));
    // Slope at the first point and half the second derivative, both times a b (b - a).
    let slope = above_a * b * b - above_b * a * a;
    let bend = above_b * a - above_a * b;
    let size = a * b * (b - a);
    let step = -0.5 * slope / bend;
    let is_minimum = bend * size > 0.0 && step.is_finite();
    is_minimum.then(|| (step, bend / size * step * step))
}

#[cfg(test)]
mod tests {
    use super::{least_index, tip, vertex};

    /// A passage in the middle between two samples has equal indices at both. Rounding can make the
    /// index at the second sample the larger one.
    #[test]
    fn a_passage_between_equal_samples_is_found() {
        for error in [-1e-15, 0.0, 1e-15] {
            let points = [(0.0, 0.3), (1.0, 0.3 + error), (2.0, 0.9)];
            let at = |t: f64| Some((0.6 * (t - 0.5).abs(), t));
            let found = least_index(points, 1.0, at);
            assert!(found.index < 1e-12 && (found.passage - 0.5).abs() < 1e-12, "{found:?}");
            assert_eq!(found.time, found.configuration);
        }
    }

    /// A parabola through squared indices finds a smooth minimum and the tip of a V.
    #[test]
    fn a_parabola_through_squares_finds_its_vertex() {
        let smooth = |t: f64| (t, (0.2 + 3.0 * (t - 0.7).powi(2)).sqrt());
        let passage = |t: f64| (t, 5.0 * (t - 0.7).abs());
        for (points, least) in [
            ([0.6, 0.1, 0.9].map(smooth), 0.2_f64.sqrt()),
            ([0.75, 0.9, 0.3].map(smooth), 0.2_f64.sqrt()),
            ([0.8, 0.4, 1.0].map(passage), 0.0),
        ] {
            let (step, decrease) = vertex(points).unwrap();
            assert!((points[0].0 + step - 0.7).abs() < 1e-14, "{points:?}");
            assert!((points[0].1.powi(2) - decrease - least.powi(2)).abs() < 1e-14, "{points:?}");
        }
        // A maximum, a line and equal points have no minimum.
        assert_eq!(vertex([(0.5, 2.0), (0.0, 1.0), (1.0, 1.0)]), None);
        assert_eq!(vertex([(0.5, 1.0), (0.0, 1.0), (1.0, 1.0)]), None);
        assert_eq!(vertex([(0.5, 1.0), (0.5, 1.0), (1.0, 2.0)]), None);
    }

    /// The tip of a V lies beyond the least point, on the side of the flatter chord; a least point
    /// that is zero is the tip.
    #[test]
    fn the_tip_of_a_passage_lies_beyond_the_least_point() {
        let index = |t: f64| (t, 5.0 * (t - 0.7).abs());
        assert!((tip([0.0, 0.69, 1.0].map(index)) - 0.7).abs() < 1e-15);
        assert!((tip([0.65, 0.71, 1.0].map(index)) - 0.7).abs() < 1e-15);
        assert_eq!(tip([0.2, 0.7, 1.0].map(index)), 0.7);
        assert_eq!(tip([(0.0, 1.0), (0.5, 1.0), (1.0, 1.0)]), 0.5);
    }
}
