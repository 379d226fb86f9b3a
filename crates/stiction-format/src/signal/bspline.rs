//! B-splines of order six (degree five) on arbitrary knots.

use stiction_core::kinematics::Target;

/// Order of the B-splines: the number of B-splines that can be nonzero in an interval.
pub(super) const ORDER: usize = 6;

/// A nondecreasing sequence of knots; the first and the last occur six times.
pub(super) trait Knots {
    /// Returns the knot with this index.
    fn at(&self, index: usize) -> f64;

    /// Values at `t` of the `K` B-splines of order `K` that are nonzero in one interval between
    /// knots (Cox and de Boor). `first` is the index of the first B-spline of order six that is
    /// nonzero in this interval; the first returned value belongs to the B-spline of order `K` with
    /// index `first + 6 - K`.
    fn splines<const K: usize>(&self, first: usize, t: f64) -> [f64; K] {
        let mut values = [0.0; K];
        // The interval begins at knot `first + 5`.
        let left = first + ORDER - 1;
        if let Some(value) = values.first_mut() {
            *value = 1.0;
        }
        for order in 1..K {
            let mut carried = 0.0;
            for k in 0..order {
                let (below, above) = (self.at(left + k + 1 - order), self.at(left + k + 1));
                let share = values[k] / (above - below);
                values[k] = carried + (above - t) * share;
                carried = (t - below) * share;
            }
            values[order] = carried;
        }
        values
    }

    /// Replaces the coefficients `c` of a spline of this order by those of its derivative, a spline
    /// of one order less: `c'_k = (order - 1) (c_k - c_(k-1)) / (t_(k+order-1) - t_k)`.
    fn differentiate(&self, c: &mut [f64; ORDER], first: usize, order: usize) {
        let degree = order - 1;
        for k in (ORDER - degree..ORDER).rev() {
            let width = self.at(first + k + degree) - self.at(first + k);
            c[k] = degree as f64 * (c[k] - c[k - 1]) / width;
        }
    }

    /// Value, first and second derivative at `t` of a spline, in the interval where the nonzero
    /// B-splines begin with index `first`. `c` are the coefficients of these B-splines.
    fn target(&self, mut c: [f64; ORDER], first: usize, t: f64) -> Target<f64> {
        let value = dot(&c, &self.splines::<ORDER>(first, t));
        self.differentiate(&mut c, first, ORDER);
        let rate = dot(&c[1..], &self.splines::<{ ORDER - 1 }>(first, t));
        self.differentiate(&mut c, first, ORDER - 1);
        let acceleration = dot(&c[2..], &self.splines::<{ ORDER - 2 }>(first, t));
        Target { value, rate, acceleration }
    }
}

/// Returns the six coefficients, beginning with index `first`, of the B-splines that can be nonzero
/// in an interval.
pub(super) fn local(coefficients: &[f64], first: usize) -> [f64; ORDER] {
    std::array::from_fn(|k| coefficients.get(first + k).copied().unwrap_or(f64::NAN))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
