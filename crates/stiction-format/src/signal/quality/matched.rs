//! Detects wrong values in smooth stretches of a signal: single values, jumps, and exchanged values.
//!
//! A polynomial is fitted to the samples around a suspicious one. If the residuals have the shape
//! that one wrong value causes, this value is wrong. A corner of the signal, such as a step of the
//! acceleration, causes residuals of another shape. Unlike predictions from a few neighbours, the
//! polynomial is accurate at ten samples per period.

use std::array::from_fn;
use std::ops::Range;

/// Number of samples on either side of a tested one.
pub(super) const HALF: usize = 10;
const WIDTH: usize = 2 * HALF + 1;
/// Number of coefficients of the polynomial.
const TERMS: usize = 12;
/// Maximum ratio of the time steps between the samples.
const GAP: f64 = 3.0;

type Window = [f64; WIDTH];

/// Kind of wrong values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// One value is wrong.
    Single,
    /// All values from the tested sample on are displaced.
    Jump,
    /// The value is exchanged with the one at this distance after it.
    Exchange(usize),
}

impl Kind {
    /// Returns the kinds of errors that are looked for in the column of an order. Slopes of rates
    /// and values of accelerations may jump, which resembles jumps of these columns.
    pub(super) fn of(order: usize) -> impl Iterator<Item = Self> {
        let all =
            [Self::Single, Self::Jump, Self::Exchange(1), Self::Exchange(2), Self::Exchange(3)];
        all.into_iter().take(if order == 0 { all.len() } else { 1 })
    }

    /// Fraction of the squares of the residuals that errors of this kind must explain. At one step
    /// of the acceleration or the jerk of a clean motion, single values explain up to 0.87, jumps
    /// 0.94 and exchanges 0.79. Two steps within four samples may explain more.
    fn explained(self) -> f64 {
        if self == Self::Jump { 0.97 } else { 0.93 }
    }
}

/// Samples around one that is tested.
pub(super) struct Matched {
    first: usize,
    /// Orthonormal polynomials at the samples.
    basis: [Window; TERMS],
    residuals: Window,
}

impl Matched {
    /// Fits the polynomial to the samples around sample `i`. Returns `None` near the ends of the
    /// recording and near gaps, where the polynomial would be ill-conditioned.
    pub(super) fn new(times: &[f64], values: &[f64], i: usize) -> Option<Self> {
        let first = i.checked_sub(HALF)?;
        let t = times.get(first..=i + HALF)?;
        let y = values.get(first..=i + HALF)?;
        let steps = t.windows(2).map(|pair| pair[1] - pair[0]);
        let (least, most) = steps.fold((f64::INFINITY, 0.0_f64), |(a, b), h| (a.min(h), b.max(h)));
        if most > GAP * least {
            return None;
        }
        let scale = 2.0 / (t[WIDTH - 1] - t[0]);
        let x: Window = from_fn(|k| (t[k] - t[HALF]) * scale);
        let mut basis = [[1.0; WIDTH]; TERMS];
        for term in 0..TERMS {
            let (known, rest) = basis.split_at_mut(term);
            let own = &mut rest[0];
            if let Some(last) = known.last() {
                *own = from_fn(|k| last[k] * x[k]);
            }
            remove(known, own);
            let norm = dot(own, own).sqrt();
            own.iter_mut().for_each(|v| *v /= norm);
        }
        let mut residuals: Window = from_fn(|k| y[k] - y[HALF]);
        remove(&basis, &mut residuals);
        Some(Self { first, basis, residuals })
    }

    /// Returns the indices of the samples, of which `i` is the middle one.
    pub(super) fn range(&self) -> Range<usize> {
        self.first..self.first + WIDTH
    }

    /// Returns the size of errors of this kind, in units of the values, if the residuals have their
    /// shape; otherwise `None`.
    pub(super) fn error(&self, kind: Kind) -> Option<f64> {
        let mut error: Window = from_fn(|k| match kind {
            Kind::Single => f64::from(k == HALF),
            Kind::Jump => f64::from(k >= HALF),
            Kind::Exchange(distance) => f64::from(k == HALF) - f64::from(k == HALF + distance),
        });
        remove(&self.basis, &mut error);
        let (along, square) = (dot(&error, &self.residuals), dot(&error, &error));
        // If all residuals are zero, the comparison is false.
        let is_explained =
            along * along > kind.explained() * square * dot(&self.residuals, &self.residuals);
        is_explained.then(|| (along / square).abs())
    }
}

fn dot(a: &Window, b: &Window) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Removes the components along orthonormal vectors.
fn remove(basis: &[Window], vector: &mut Window) {
    // A second pass removes what rounding leaves.
    for _ in 0..2 {
        for own in basis {
            let along = dot(own, vector);
            vector.iter_mut().zip(own).for_each(|(v, b)| *v -= along * b);
        }
    }
}
