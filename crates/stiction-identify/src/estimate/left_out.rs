//! Prediction of left-out parts of the logs: each fifth of the logs is predicted by a fit to the others.

use super::map::Map;
use super::minimum::Prior;
use super::strength::WEAKEST;
use super::{Estimate, FOLDS, Normal, Problem, pieces};
use nalgebra::DVector;

/// Round-off of a sum of squared residuals, as a fraction of the sum of squared efforts. Residuals of
/// exact logs are smaller.
const ROUNDED: f64 = 1e-14;

/// Residuals of left-out parts of the logs, compared with those of the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOut {
    /// Mean squared weighted residual of left-out parts, relative to that of the fit; one if the
    /// rows cannot be divided.
    pub ratio: f64,
    /// Ratio as in `ratio`, but for the weakest prior that the choice of the strength compares.
    pub plain: f64,
}

impl Problem<'_> {
    /// Predicts the left-out parts of the logs with the strength of the prior and with the weights of the rows that
    /// belong to `estimate`.
    pub fn left_out(&self, estimate: &Estimate) -> LeftOut {
        let (map, bodies, shift) = (self.map(), self.priors(), self.shift());
        let at = DVector::from_column_slice(&estimate.values) - &shift;
        let weights = self.weights(&at, &estimate.noise);
        let sums = |blocks| pieces(blocks, &map, &shift, (&estimate.noise, &weights)).folds;
        let design = self.design(estimate.projection.as_ref());
        let fitted = sums(&design);
        // The fit uses the columns that the instruments explain; predictions use the complete
        // columns.
        let judged = estimate.projection.as_ref().map(|_| sums(self.blocks));
        let judged = judged.as_ref().unwrap_or(&fitted);
        let total = self.total(&map, &shift, &estimate.noise, &fitted);
        let ratio = |strength: f64| {
            let prior = self.prior(&bodies, strength);
            self.ratio(&map, (&fitted, judged, &total), &prior).unwrap_or(1.0)
        };
        let own = ratio(estimate.strength);
        let plain = if estimate.strength > WEAKEST { ratio(WEAKEST) } else { own };
        LeftOut { ratio: own, plain }
    }

    /// Computes the mean square of left-out residuals relative to that of the fit for one prior; `None` unless at least
    /// two fifths have rows. `fitted` and `judged` are the sums over the pieces for fits and for predictions.
    fn ratio(
        &self,
        map: &Map,
        (fitted, judged, total): (&[Normal], &[Normal], &Normal),
        prior: &Prior<'_>,
    ) -> Option<f64> {
        let whole = self.minimum(map, total, prior);
        let (mut sum, mut count) = (0.0, 0.0);
        let mut all = Normal::zero(map.size());
        for fold in 0..FOLDS {
            let mut rest = total.clone();
            let mut out = Normal::zero(map.size());
            // Pieces at the same place in all logs are left out together.
            for (fitted, judged) in fitted.iter().zip(judged).skip(fold).step_by(FOLDS) {
                rest.add(fitted, -1.0);
                out.add(judged, 1.0);
            }
            if out.rows > 0.0 {
                let z = self.minimum_near(map, &rest, prior, whole.clone());
                sum += out.cost(&z).max(ROUNDED * out.square) / out.rows;
                count += 1.0;
                all.add(&out, 1.0);
            }
        }
        (count > 1.0).then(|| sum / count * all.rows / all.cost(&whole).max(ROUNDED * all.square))
    }
}
