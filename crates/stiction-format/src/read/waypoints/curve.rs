//! Piecewise polynomials for the first three derivatives of a smooth function. They are fitted to
//! samples of the first two derivatives, and used to find the largest magnitudes of all three.

use std::f64::consts::PI;

/// Number of Chebyshev nodes on each polynomial piece of a curve.
const NODES: usize = 17;
/// Maximum number of polynomial pieces of a curve.
const MOST: usize = 64;
/// Tolerance of the interpolated derivatives. It is relative to the largest second derivative, or
/// to the largest first derivative divided by the length of the interval, whichever is greater.
const ACCURACY: f64 = 1e-11;
/// Number of equal steps into which the search for the maximum of a function divides an interval
/// between corners.
const SAMPLES: usize = 48;
/// Displacement, m or rad, below which a joint counts as at rest.
const AT_REST: f64 = 1e-12;

/// First three derivatives of a function on an interval, as piecewise polynomials through values at
/// Chebyshev nodes.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    from: f64,
    to: f64,
    pieces: Vec<[[f64; NODES]; 3]>,
}

/// Position of Chebyshev node `k` in the interval from 0 to 1.
fn node(k: usize) -> f64 {
    0.5 * (1.0 - (PI * k as f64 / (NODES - 1) as f64).cos())
}

/// Barycentric weight of Chebyshev node `k`.
fn weight(k: usize) -> f64 {
    let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    if k == 0 || k == NODES - 1 { 0.5 * sign } else { sign }
}

/// Evaluates, at `x` from 0 to 1, the polynomial with these values at the Chebyshev nodes.
fn interpolated(values: &[f64; NODES], x: f64) -> f64 {
    let (mut above, mut below) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        let distance = x - node(k);
        if distance == 0.0 {
            return *value;
        }
        let part = weight(k) / distance;
        above += part * value;
        below += part;
    }
    above / below
}

/// Returns the derivatives, at the Chebyshev nodes from 0 to 1, of the polynomial with these values
/// at the nodes.
fn differentiated(values: &[f64; NODES]) -> [f64; NODES] {
    std::array::from_fn(|i| {
        let others = (0..NODES).filter(|k| *k != i);
        // Differences of values are used so that a constant adds no round-off.
        let each =
            others.map(|k| weight(k) / weight(i) * (values[k] - values[i]) / (node(i) - node(k)));
        each.sum()
    })
}

impl Curve {
    /// Fits curves of `count` functions on the interval from `from` to `to`. For a list of
    /// increasing arguments, `sample` returns the first two derivatives of each function at each
    /// argument. Returns `None` if the functions are not smooth enough for [`MOST`] pieces, and an
    /// error if `sample` fails.
    pub(super) fn fit<E>(
        (from, to): (f64, f64),
        count: usize,
        mut sample: impl FnMut(&[f64]) -> Result<Vec<Vec<[f64; 2]>>, E>,
    ) -> Result<Option<Vec<Self>>, E> {
        let mut known: Option<Vec<Self>> = None;
        let mut pieces = 1;
        while pieces <= MOST {
            let width = (to - from) / pieces as f64;
            let place = |i: usize| from + width * (i / NODES) as f64 + width * node(i % NODES);
            let arguments: Vec<f64> = (0..pieces * NODES).map(place).collect();
            let samples = sample(&arguments)?;
            let next: Vec<Self> = (0..count)
                .map(|function| {
                    let piece = |own: &[Vec<[f64; 2]>]| {
                        let part = |d: usize| std::array::from_fn(|k| own[k][function][d]);
                        let second: [f64; NODES] = part(1);
                        let third = differentiated(&second).map(|slope| slope / width);
                        [part(0), second, third]
                    };
                    Self { from, to, pieces: samples.chunks(NODES).map(piece).collect() }
                })
                .collect();
            let agrees = |(coarse, fine): (&Self, &Self)| coarse.agrees(fine, &arguments);
            if known.is_some_and(|known| known.iter().zip(&next).all(agrees)) {
                return Ok(Some(next));
            }
            known = Some(next);
            pieces *= 2;
        }
        Ok(None)
    }

    /// Tests whether the first two derivatives of this curve agree with those of the curve `fine`
    /// at `arguments`, the nodes of `fine`.
    fn agrees(&self, fine: &Self, arguments: &[f64]) -> bool {
        let size = |d: usize| {
            let each = fine.pieces.iter().flat_map(|piece| piece[d]);
            each.fold(0.0_f64, |most, value| most.max(value.abs()))
        };
        let span = self.to - self.from;
        let scale = size(1).max(size(0) / span).max(f64::MIN_POSITIVE);
        arguments.iter().enumerate().all(|(i, x)| {
            let exact = &fine.pieces[i / NODES];
            let found = self.at(*x);
            let errors = [0, 1].map(|d| (found[d] - exact[d][i % NODES]).abs());
            errors[0] <= ACCURACY * scale * span && errors[1] <= ACCURACY * scale
        })
    }

    /// Evaluates the first three derivatives of the function at `x`.
    pub(super) fn at(&self, x: f64) -> [f64; 3] {
        let count = self.pieces.len();
        let place = (x - self.from) / (self.to - self.from) * count as f64;
        let index = (place.max(0.0) as usize).min(count - 1);
        let inside = (place - index as f64).clamp(0.0, 1.0);
        [0, 1, 2].map(|d| interpolated(&self.pieces[index][d], inside))
    }

    /// Tests if the function changes by more than round-off.
    pub(super) fn moves(&self) -> bool {
        let rates = self.pieces.iter().flat_map(|piece| piece[0]);
        rates.fold(0.0_f64, |most, rate| most.max(rate.abs())) * (self.to - self.from) > AT_REST
    }

    /// Arguments at which two pieces of the curve meet.
    pub(super) fn joints(&self) -> impl Iterator<Item = f64> + '_ {
        let width = (self.to - self.from) / self.pieces.len() as f64;
        (1..self.pieces.len()).map(move |k| self.from + width * k as f64)
    }
}

/// Returns the largest magnitudes of three functions, which are smooth between successive arguments
/// of the increasing list `corners`. `at` evaluates the functions in an interval between corners,
/// given by its index. If `exact` is false, only the values at some samples are compared.
pub(super) fn largest(
    corners: &[f64],
    exact: bool,
    at: impl Fn(usize, f64) -> [f64; 3],
) -> [f64; 3] {
    let mut most = [0.0_f64; 3];
    for (interval, pair) in corners.windows(2).enumerate() {
        let [from, to] = [pair[0], pair[1]];
        let count = if exact { SAMPLES } else { SAMPLES / 4 };
        let place = |k: usize| from + (to - from) * k as f64 / count as f64;
        let samples: Vec<[f64; 3]> =
            (0..=count).map(|k| at(interval, place(k)).map(f64::abs)).collect();
        for d in 0..3 {
            let best = samples.iter().fold(0.0_f64, |most, values| most.max(values[d]));
            most[d] = most[d].max(best);
            if !exact {
                continue;
            }
            for k in 0..=count {
                // A maximum may lie between a sample and its neighbours, or next to an end of the
                // interval. It exceeds these samples only a little, so samples below 90 % of the
                // largest value so far need no search.
                let (before, after) = (k.saturating_sub(1), (k + 1).min(count));
                let here = samples[k][d];
                if here >= samples[before][d] && here >= samples[after][d] && here >= 0.9 * most[d]
                {
                    let value = |x: f64| at(interval, x)[d].abs();
                    most[d] = most[d].max(maximum(place(before), place(after), value));
                }
            }
        }
    }
    most
}

/// Maximum of a unimodal function between two arguments, by golden-section search.
pub(super) fn maximum(from: f64, to: f64, value: impl Fn(f64) -> f64) -> f64 {
    let least = minimum((from, to), 60, |x| -value(x));
    value(least)
}

/// Argument of the minimum of a unimodal function between two arguments, by golden-section search.
pub(super) fn minimum(
    (mut from, mut to): (f64, f64),
    steps: usize,
    value: impl Fn(f64) -> f64,
) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (to - golden * (to - from), from + golden * (to - from));
    let (mut at_low, mut at_high) = (value(low), value(high));
    for _ in 0..steps {
        if at_low <= at_high {
            (to, high, at_high) = (high, low, at_low);
            low = to - golden * (to - from);
            at_low = value(low);
        } else {
            (from, low, at_low) = (low, high, at_high);
            high = from + golden * (to - from);
            at_high = value(high);
        }
    }
    if at_low <= at_high { low } else { high }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the derivatives and the largest values of a sine and a line against closed forms,
    /// maxima next to the ends of an interval, and that a function with a kink is rejected.
    #[test]
    fn curves_of_known_functions() {
        let sample = |at: &[f64]| -> Result<_, ()> {
            let each = at
                .iter()
                .map(|x| vec![[3.0 * (3.0 * x).cos(), -9.0 * (3.0 * x).sin()], [1.0, 0.0]]);
            Ok(each.collect())
        };
        let curves = Curve::fit((0.0, 2.0), 2, sample).unwrap().unwrap();
        for k in 0..=100 {
            let x = f64::from(k) / 50.0;
            let [first, second, third] = curves[0].at(x);
            assert!((first - 3.0 * (3.0 * x).cos()).abs() < 1e-11);
            assert!((second + 9.0 * (3.0 * x).sin()).abs() < 1e-11);
            assert!((third + 27.0 * (3.0 * x).cos()).abs() < 1e-9, "{third}");
            assert_eq!(curves[1].at(x)[2], 0.0);
        }
        let most = largest(&[0.0, 2.0], true, |_, x| curves[0].at(x));
        for (found, expected) in most.into_iter().zip([3.0, 9.0, 27.0]) {
            assert!((found - expected).abs() < 1e-9, "{most:?}");
        }
        // A maximum next to an end of the interval: 1 - (x - 0.005)^2 is largest at 0.005, before the second sample.
        let beside = largest(&[0.0, 1.0], true, |_, x| {
            let off = x - 0.005;
            [1.0 - off * off, 0.0, 0.0]
        });
        assert!((beside[0] - 1.0).abs() < 1e-15, "{beside:?}");
        let beside = largest(&[0.0, 1.0], true, |_, x| {
            let off = x - 0.995;
            [1.0 - off * off, 0.0, 0.0]
        });
        assert!((beside[0] - 1.0).abs() < 1e-15, "{beside:?}");
        let rough = |at: &[f64]| -> Result<_, ()> {
            Ok(at.iter().map(|x| vec![[(x - 0.3).abs(), (x - 0.3).signum()]]).collect())
        };
        assert!(Curve::fit((0.0, 1.0), 1, rough).unwrap().is_none());
    }
}
