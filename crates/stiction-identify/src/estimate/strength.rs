//! Strength of the prior, chosen by its own error and by left-out data.
//!
//! Equation (I4) of the book's theory.

use super::map::Map;
use super::{FOLDS, Normal, Problem};

/// Strengths of the prior that are compared with the strength of its own error, as multiples of it.
const MULTIPLES: [f64; 7] = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];
/// Strength for estimates that count as made without prior.
const WEAKEST: f64 = 1e-4;
/// Relative increase of the squared left-out residuals up to which strengths of the prior count as equally good.
const LITTLE: f64 = 0.1;

impl Problem<'_> {
    /// Chooses the strength of the prior, and returns it with the mean square of left-out residuals relative to that of
    /// the fit, for the chosen strength and without prior. `own` is the strength of a prior whose errors are those for
    /// which the standard deviations allow; see [`equally_good`] for the choice.
    ///
    /// A weaker prior is not considered. If a motion repeats itself, each piece equals the others, and pieces that are
    /// left out cannot reveal parameters that take up an error of the model: the weakest prior predicts them best, with
    /// bodies of any mass.
    pub(super) fn chosen_strength(
        &self,
        map: &Map,
        (pieces, judged, total): (&[Normal], &[Normal], &Normal),
        own: f64,
    ) -> (f64, f64, f64) {
        let scored = |strength: f64| -> Vec<f64> {
            let folds = pieces.len().clamp(1, FOLDS);
            // Pieces at the same place in all logs are left out together.
            (0..folds)
                .map(|fold| {
                    let mut rest = total.clone();
                    let mut out = Normal::zero(map.size());
                    for (piece, judged) in pieces.iter().zip(judged).skip(fold).step_by(folds) {
                        rest.add(piece, -1.0);
                        out.add(judged, 1.0);
                    }
                    let z = self.minimum(map, &rest, strength);
                    out.cost(&z).max(0.0) / out.rows.max(1.0)
                })
                .collect()
        };
        let mut whole = Normal::zero(map.size());
        judged.iter().for_each(|piece| whole.add(piece, 1.0));
        let ratio = |strength: f64| {
            let z = self.minimum(map, total, strength);
            mean(&scored(strength)) / (whole.cost(&z).max(1e-30) / whole.rows.max(1.0))
        };
        let strength = self.options.strength.unwrap_or_else(|| {
            let scores: Vec<Vec<f64>> = MULTIPLES.iter().map(|m| scored(m * own)).collect();
            own * equally_good(&MULTIPLES, &scores)
        });
        (strength, ratio(strength), ratio(WEAKEST))
    }
}

fn mean(scores: &[f64]) -> f64 {
    scores.iter().sum::<f64>() / scores.len().max(1) as f64
}

/// Smallest multiple that is as good as the best one. `scores` contains the mean squares of the residuals on each
/// left-out piece. A multiple is as good if none of the others predicts better by more than [`LITTLE`] and by more than
/// two standard errors of the difference. Interpolates between multiples, so that the result depends continuously on the
/// scores.
fn equally_good(multiples: &[f64], scores: &[Vec<f64>]) -> f64 {
    // The differences of the same pieces decide, not the scatter between pieces.
    let excess = |k: usize| {
        let each = scores.iter().map(|other| {
            let d: Vec<f64> = scores[k].iter().zip(other).map(|(a, b)| a - b).collect();
            let (m, n) = (mean(&d), d.len() as f64);
            let spread = d.iter().map(|x| (x - m).powi(2)).sum::<f64>();
            let error = (spread / (n * (n - 1.0).max(1.0))).sqrt();
            m - (2.0 * error).max(LITTLE * mean(other))
        });
        each.fold(f64::NEG_INFINITY, f64::max)
    };
    let mut before: Option<(f64, f64)> = None;
    for (k, multiple) in multiples.iter().enumerate() {
        let now = excess(k);
        if now <= 0.0 {
            let Some((least, worse)) = before else { return *multiple };
            let part = worse / (worse - now);
            return least * (multiple / least).powf(part);
        }
        before = Some((*multiple, now));
    }
    // Scores that are not numbers leave the prior as it is.
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equal scores keep the prior; clearly better ones of a stronger prior strengthen it.
    #[test]
    fn only_better_predictions_strengthen_the_prior() {
        let multiples = [1.0, 10.0, 100.0];
        let scores = |means: [f64; 3]| means.map(|m| vec![m, 1.1 * m, 0.9 * m]);
        assert_eq!(equally_good(&multiples, &scores([1.0, 0.95, 0.92])), 1.0);
        let stronger = equally_good(&multiples, &scores([2.0, 1.0, 0.99]));
        assert!((1.0..10.0).contains(&stronger), "{stronger}");
        assert_eq!(equally_good(&multiples, &scores([f64::NAN; 3])), 1.0);
    }

    /// The choice does not jump where two strengths are equally good.
    #[test]
    fn the_choice_is_continuous() {
        let multiples = [1.0, 3.0, 10.0, 30.0];
        let at = |x: f64| {
            // The best strength moves from 30 to 3 as `x` grows; the first one stays worse.
            let scores = [2.0, 1.0 + 0.3 * (1.0 - x), 0.9 + 0.3 * x, 0.8 + 0.5 * x];
            let pieces = scores.map(|s| vec![s, 1.05 * s, 0.97 * s, s, 1.01 * s]);
            equally_good(&multiples, &pieces).ln()
        };
        let steps = 2000;
        let all: Vec<f64> = (0..=steps).map(|k| at(f64::from(k) / f64::from(steps))).collect();
        let jump = all.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        assert!(jump < 0.02, "{jump}");
        assert!(all[0] > all[2000] + 0.1, "{} {}", all[0], all[2000]);
    }
}
