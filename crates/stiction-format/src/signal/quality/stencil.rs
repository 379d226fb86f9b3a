//! Residuals of interpolation: a sample minus the polynomial through its neighbours.

use std::ops::Range;

/// Number of neighbours on either side for the interpolation of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stencil(usize);

impl Stencil {
    /// Stencils with six, eight and ten neighbours. All stencils estimate white noise equally well.
    /// For smooth signals, residuals are smallest with the most neighbours; for signals with
    /// corners, they are smallest with the fewest.
    pub(super) const ALL: [Self; 3] = [Self(3), Self(4), Self(5)];
}

/// Stencil with eight neighbours.
pub(super) const WIDE: Stencil = Stencil(4);

/// Returns the magnitudes of the residuals of samples, scaled so that white noise and its residuals
/// have the same variance. Samples without enough neighbours have no residual.
pub(super) fn residuals(
    stencil: Stencil,
    times: &[f64],
    values: &[f64],
    samples: Range<usize>,
) -> Vec<f64> {
    let scaled = |i| residual(stencil, times, values, i).map(|(sum, norm)| sum.abs() / norm);
    samples.filter_map(scaled).collect()
}

/// Returns the residual of sample `i` and its standard deviation for white noise of unit variance;
/// `None` without enough neighbours.
pub(super) fn residual(
    Stencil(half): Stencil,
    times: &[f64],
    values: &[f64],
    i: usize,
) -> Option<(f64, f64)> {
    let first = i.checked_sub(half)?;
    let t = times.get(first..=i + half)?;
    let y = values.get(first..=i + half)?;
    // The barycentric weights of all nodes give the divided difference; divided by the weight of the middle node,
    // it is the residual.
    let mut weights = [0.0; 11];
    let scale = t[half + 1] - t[half];
    for (j, weight) in weights.iter_mut().enumerate().take(t.len()) {
        let product: f64 =
            (0..t.len()).filter(|&k| k != j).map(|k| (t[j] - t[k]) / scale).product();
        *weight = 1.0 / product;
    }
    let middle = weights[half];
    let (mut sum, mut squares) = (0.0, 0.0);
    for (weight, value) in weights.iter().zip(y) {
        sum += weight / middle * (value - y[half]);
        squares += (weight / middle).powi(2);
    }
    Some((sum, squares.sqrt()))
}
