//! Iteration between the fit of the parameters and the normal loads that their friction depends on.

use super::Progress;
use super::prepare::Prepared;
use super::run::fitted_blocks;
use stiction_identify::{Estimate, Kind, Options, Parameter, Problem};

/// Largest number of iterations that alternate between the fit of parameter values and the
/// computation of normal loads.
const SWEEPS: usize = 12;
/// Number of iterations that choose the strength of the prior anew. Errors of the first normal loads
/// act as errors of the model, so the strength that suits them is not final.
const CHOICES: usize = 3;
/// The iteration has converged if the values change by at most this number of standard deviations.
const SETTLED: f64 = 0.01;
/// Remaining change of a parameter value, in standard deviations, above which a caution reports it.
const VISIBLE: f64 = 0.1;
/// Remaining change of a parameter value, in standard deviations, above which no parameter counts
/// as identified.
const UNSETTLED: f64 = 1.0;

/// Fits the logs and recomputes the normal loads for the fitted values, alternately, until both
/// converge. The second result is true if no parameter value changes by more than [`UNSETTLED`]
/// standard deviations in the last iteration.
pub(super) fn fitted(
    all: &mut [Prepared],
    parameters: &[Parameter],
    (options, groups): (&Options, &[Vec<usize>]),
    (cautions, progress): (&mut Vec<String>, Progress<'_>),
) -> (Estimate, bool) {
    let is_nonlinear =
        parameters.iter().any(|p| matches!(p.kind, Kind::Mu(_) | Kind::TorqueConstant(_)));
    let mut blocks = fitted_blocks(all);
    let mut estimate = Problem { parameters, blocks: &blocks, options }.solve();
    let mut last = f64::INFINITY;
    let mut at: Vec<f64> = estimate.values.clone();
    for sweep in 0..if is_nonlinear { SWEEPS } else { 0 } {
        progress("fitting the parameters", sweep, SWEEPS);
        let failed = all
            .iter_mut()
            .filter(|log| !log.predict)
            .find_map(|log| log.linearise(&at, groups).err());
        if let Some(why) = failed {
            // Beyond self-locking, forces do not exist, so the friction coefficients are halved.
            for (value, p) in at.iter_mut().zip(parameters) {
                if matches!(p.kind, Kind::Mu(_)) {
                    *value *= 0.5;
                }
            }
            let halved = format!(
                "with the identified friction, forces could not be computed {why}; coefficients of \
                 friction were halved"
            );
            if !cautions.contains(&halved) {
                cautions.push(halved);
            }
            last = f64::INFINITY;
            continue;
        }
        blocks = fitted_blocks(all);
        let problem = Problem { parameters, blocks: &blocks, options };
        estimate = match sweep < CHOICES {
            true => problem.solve(),
            false => problem.solve_fixed(&estimate),
        };
        let change = (0..parameters.len())
            .filter(|&k| estimate.sigmas[k] > 0.0)
            .map(|k| (estimate.values[k] - at[k]).abs() / estimate.sigmas[k])
            .fold(0.0, f64::max);
        at.clone_from(&estimate.values);
        last = change;
        if change < SETTLED {
            break;
        }
    }
    let is_settled = !is_nonlinear || last <= UNSETTLED;
    if is_nonlinear && last > VISIBLE {
        cautions.push(match last.is_finite() {
            true => format!(
                "the fit has not fully converged: normal loads, coefficients of friction and \
                 torque constants still change by {last:.2} standard deviations in the last \
                 iteration"
            ),
            false => "the fit has not converged: its normal loads were computed with friction \
                coefficients that differ from the identified ones"
                .to_owned(),
        });
    }
    (estimate, is_settled)
}
