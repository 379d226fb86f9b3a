//! Choice of the strength of the prior by the marginal likelihood of the data.
//!
//! Equation (I4) of the book's theory. Sources: MacKay, *Bayesian interpolation*, Neural Computation 4 (1992); for
//! priors on manifolds Kass, Steffey, *Approximate Bayesian inference in conditionally independent hierarchical
//! models*, JASA 84 (1989).

use super::map::Map;
use super::minimum::log_growth;
use super::{Normal, Problem};
use crate::physical::BodyPrior;
use nalgebra::DVector;

/// Strengths of the prior that are compared, in decreasing order. Each is a starting point for the next.
const STRENGTHS: [f64; 23] = [
    1e7, 3e6, 1e6, 3e5, 1e5, 3e4, 1e4, 3e3, 1e3, 300.0, 100.0, 30.0, 10.0, 3.0, 1.0, 0.3, 0.1,
    3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4,
];
/// The comparison begins with this strength unless the expected one is greater, as for a model with small errors.
const FIRST: f64 = 1e4;
/// Standard deviation of the logarithm of the strength before the data are seen: errors of the
/// model's inertias are known to a factor of about three, strengths to the square of it.
const WIDTH: f64 = 2.3;
/// Strengths above this multiple of the expected one only serve as starting points: the standard
/// deviations allow for the expected errors of the model, which a stronger prior would not let the
/// data reduce.
const STRONGEST: f64 = 1.8;
/// Largest number of alternations between values and noise.
const ALTERNATIONS: usize = 10;
/// Relative change of the noise up to which the alternation has converged.
const SETTLED: f64 = 0.01;

/// Result of the choice of the strength.
pub(super) struct Choice {
    /// Strength of the prior, in equivalent independent samples.
    pub(super) strength: f64,
    /// Free coordinates of the estimate.
    pub(super) z: DVector<f64>,
}

/// The weakest strength that is compared.
pub(super) const WEAKEST: f64 = STRENGTHS[STRENGTHS.len() - 1];

impl Problem<'_> {
    /// Chooses the strength with the greatest posterior probability. For each strength, values and noise are estimated
    /// together, because a prior that is too strong would confirm itself by the noise that it causes. `channels` are
    /// the sums over the rows of each actuator, `least` the least noise in their unit, and `samples` rows count as one
    /// independent row. `bodies` are those of [`Self::priors`].
    pub(super) fn choice(
        &self,
        map: &Map,
        channels: &[Normal],
        least: &[f64],
        samples: f64,
        bodies: &[BodyPrior],
    ) -> Choice {
        let expected = samples / self.options.prior_error.powi(2);
        let empty = Normal::zero(map.size());
        let mut noise: Vec<f64> = vec![1.0; channels.len()];
        let mut z = self.start(map, bodies);
        let mut best: Option<(f64, Choice)> = None;
        let first = f64::max(FIRST, STRONGEST * expected);
        for strength in STRENGTHS.into_iter().filter(|own| *own <= first) {
            let own = self.prior(bodies, strength);
            let mut total = empty.clone();
            for _ in 0..ALTERNATIONS {
                total = empty.clone();
                for (channel, noise) in channels.iter().zip(&noise) {
                    total.add(channel, 1.0 / (noise * noise));
                }
                z = self.minimum_near(map, &total, &own, z);
                let mut change: f64 = 0.0;
                for ((channel, noise), least) in channels.iter().zip(&mut noise).zip(least) {
                    let square = channel.cost(&z).max(0.0) / channel.rows.max(1e-300);
                    let next = square.sqrt().max(*least);
                    change = change.max((next / *noise).ln().abs());
                    *noise = next;
                }
                if change < SETTLED {
                    break;
                }
            }
            if strength > STRONGEST * expected {
                continue;
            }
            let Some((prior, _, before)) = self.objective(map, &empty, &own, &z) else { continue };
            let Some(growth) = log_growth(&before, &total.matrix) else { continue };
            let fit: f64 = channels.iter().zip(&noise).map(|(own, s)| own.rows * s.ln()).sum();
            let unexpected = (strength / expected).ln() / WIDTH;
            // All terms are multiplied by the number of rows that count as one.
            let score = fit + prior + 0.5 * samples * (growth + unexpected * unexpected);
            if best.as_ref().is_none_or(|(least, _)| score < *least) {
                best = Some((score, Choice { strength, z: z.clone() }));
            }
        }
        best.map_or(Choice { strength: expected, z }, |(_, own)| own)
    }
}
