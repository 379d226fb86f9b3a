//! Test whether a singularity index exceeds a value.

use super::{SMALL, SingularityDistances, SingularityIndex};
use crate::kinematics::Bodies;
use crate::parameters::Parameters;

impl SingularityDistances {
    /// Returns `true` if the index `index` certainly exceeds `value` at the configuration of
    /// `bodies`. The index exceeds the value if the Gram matrix, less the square of the value times
    /// the unit matrix, has a Cholesky decomposition. The test costs less than computing the index.
    /// Returns `false` if round-off does not permit a decision.
    pub fn exceeds(
        &mut self,
        index: SingularityIndex,
        value: f64,
        (parameters, bodies): (&Parameters<f64>, &Bodies<f64>),
    ) -> bool {
        self.place(parameters, bodies);
        let largest = self.largest();
        if value.is_nan() || value <= SMALL * largest {
            return false;
        }
        let by = value * value + self.round_off(largest);
        let matrix = self.gram_matrix(index);
        matrix.shift(by);
        matrix.factor()
    }
}
