//! Sums of products, accumulated with twice the working precision.

/// Sum with twice the working precision: the rounded sum `high` and its accumulated rounding error
/// `low`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Twofold {
    high: f64,
    low: f64,
}

impl Twofold {
    /// Adds the product `a * b` with twice the working precision (Ogita, Rump, Oishi 2005: Dot2).
    pub(crate) fn add_product(&mut self, a: f64, b: f64) {
        let (product, product_error) = exact_product(a, b);
        let (sum, sum_error) = exact_sum(self.high, product);
        self.high = sum;
        self.low += product_error + sum_error;
    }

    /// Adds `factor` times another sum, including the rounding error of that sum.
    pub(crate) fn add_multiple(&mut self, factor: f64, other: Self) {
        self.add_product(factor, other.high);
        self.low += factor * other.low;
    }

    /// Returns the sum, rounded once to working precision.
    pub(crate) fn value(self) -> f64 {
        self.high + self.low
    }
}

/// Returns the rounded sum of two numbers and its rounding error (Knuth).
fn exact_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let from_b = sum - a;
    (sum, (a - (sum - from_b)) + (b - from_b))
}

/// Returns the rounded product of two numbers and its rounding error (Dekker 1971). Uses no fused
/// multiply-add, because not every processor has this instruction. Valid for numbers far from
/// overflow and underflow.
fn exact_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (halves(a), halves(b));
    let error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
    (product, error)
}

/// Splits a number into the sum of two numbers with half as many significant digits (Veltkamp).
fn halves(x: f64) -> (f64, f64) {
    const SPLITTER: f64 = 134_217_729.0;
    let shifted = SPLITTER * x;
    let high = shifted - (shifted - x);
    (high, x - high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cancelling_terms_keep_their_digits() {
        // (1 + e)(1 - e) - 1 = -e^2 exactly; plain arithmetic gives zero.
        let e = 2.0_f64.powi(-30);
        let mut sum = Twofold::default();
        sum.add_product(1.0 + e, 1.0 - e);
        sum.add_product(-1.0, 1.0);
        assert_eq!((1.0 + e) * (1.0 - e) - 1.0, 0.0);
        assert_eq!(sum.value(), -e * e);
        let mut twice = Twofold::default();
        twice.add_multiple(3.0, sum);
        assert_eq!(twice.value(), -3.0 * e * e);
    }
}
