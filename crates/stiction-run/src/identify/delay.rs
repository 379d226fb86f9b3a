//! Delay of the measured efforts relative to the positions: estimation and correction.

use super::prepare::{Effect, Prepared};
use stiction_identify::{Candidate, Estimate, Extension, Problem};

/// Delay of the effort of one actuator relative to the positions in the log.
#[derive(Clone, Debug)]
pub struct Delay {
    /// Name of the actuator.
    pub actuator: String,
    /// Delay, s; negative if the effort precedes the positions.
    pub value: f64,
    /// Standard deviation of the delay, s.
    pub sigma: f64,
    /// True if the efforts were shifted in time by this delay.
    pub is_corrected: bool,
}

/// Largest number of Gauss-Newton iterations.
const STEPS: usize = 6;
/// A delay, or another effect, counts as certain if it exceeds this number of its standard
/// deviations.
pub(super) const CERTAIN: f64 = 5.0;
/// Smallest fraction of the squared residuals that a delay must explain in cross-validation, in
/// which each fifth of the logs is predicted from the other four.
const EXPLAINED: f64 = 0.02;
/// The iteration has converged if each delay changes by less than this number of standard
/// deviations.
const SETTLED: f64 = 0.1;

/// Returns the regressor signals of an effect on the effort of actuator `channel`, one signal for
/// each fitted log; `None` if the signal cannot be computed for one of these logs.
pub(super) fn candidate(all: &[Prepared], channel: usize, effect: Effect) -> Option<Candidate> {
    let fits = all.iter().filter(|log| !log.predict);
    let signal: Option<Vec<_>> = fits.map(|log| log.effect(channel, effect)).collect();
    Some(Candidate { channel, signal: signal? })
}

/// Estimates for each effort the delay that remains after the present correction; `None` if this
/// delay cannot be estimated.
fn remaining(
    all: &[Prepared],
    problem: &Problem<'_>,
    estimate: &Estimate,
) -> Vec<Option<Extension>> {
    let residuals = problem.residuals(estimate);
    let channels = all.first().map_or(0, |log| log.block.channels.len());
    let each =
        (0..channels).map(|channel| residuals.extension(&candidate(all, channel, Effect::Delay)?));
    each.collect()
}

/// Magnitude of the filtered direction of motion below which a regression row is close to a
/// reversal. Before filtering, the direction is 1 or -1.
const CLOSE: f64 = 0.95;

/// Returns the standard deviation of a delay due to the jumps of friction, s. The instant of each
/// jump is known to within one sample. Only rows close to reversals have this error. It is weighted
/// by the part of the information on the delay that these rows contain.
fn jump_error(all: &[Prepared], channel: usize) -> f64 {
    let (mut close, mut total, mut count, mut sample) = (0.0, 0.0, 0.0, 0.0);
    for log in all.iter().filter(|log| !log.predict) {
        let Some(slope) = log.effect(channel, Effect::Delay) else { continue };
        let directions = &log.directions[channel];
        for (slope, [direction, _]) in slope.iter().zip(directions) {
            total += slope * slope;
            if direction.abs() < CLOSE {
                close += slope * slope;
            }
        }
        let reversals = directions.windows(2).filter(|pair| pair[0][0] * pair[1][0] < 0.0).count();
        count += reversals as f64;
        sample = f64::max(sample, log.sample);
    }
    match count > 0.0 && total > 0.0 {
        true => close / total * sample / (12.0 * count).sqrt(),
        false => 0.0,
    }
}

/// Estimates the delays of all efforts together with the parameters by the Gauss-Newton method,
/// starting from the delays `begin`, each with its standard deviation, s. A delay is corrected if
/// it differs significantly from zero and improves the prediction of left-out fifths of the logs.
/// `solve` fits the logs with the present correction, and passes the regression problem and its
/// estimate to its second argument. Returns the delays, s, in the order of the actuators, with
/// standard deviations.
pub(super) fn take_back(
    all: &mut [Prepared],
    begin: &[[f64; 2]],
    solve: impl Fn(&[Prepared], &mut dyn FnMut(&Problem<'_>, &Estimate)),
) -> Vec<[f64; 2]> {
    let most = all.iter().map(Prepared::greatest_delay).fold(f64::INFINITY, f64::min);
    let mut delays = begin.to_vec();
    for step in 0..STEPS {
        let mut found = Vec::new();
        solve(all, &mut |problem, estimate| found = remaining(all, problem, estimate));
        let mut is_settled = true;
        for ((channel, delay), found) in delays.iter_mut().enumerate().zip(found) {
            let Some(found) = found else { continue };
            let is_new = delay[0] == 0.0;
            let is_seen = found.gain > EXPLAINED && found.gain > found.gain_sigma;
            if is_new && (step > 0 || !is_seen || found.value.abs() < CERTAIN * found.sigma) {
                continue;
            }
            is_settled &= found.value.abs() < SETTLED * found.sigma;
            let sigma = found.sigma.hypot(jump_error(all, channel));
            *delay = [(delay[0] + found.value).clamp(-most, most), sigma];
        }
        let values: Vec<f64> = delays.iter().map(|[value, _]| *value).collect();
        all.iter_mut().for_each(|log| log.set_delays(&values));
        if is_settled {
            break;
        }
    }
    delays
}

/// Returns a caution that describes a corrected delay. `greatest` is the largest delay that can be
/// corrected, s.
pub(super) fn words(delay: &Delay, greatest: f64) -> String {
    let Delay { actuator, value, sigma, .. } = delay;
    let (size, sigma) = (1e3 * value.abs(), 1e3 * sigma);
    if value.abs() >= 0.999 * greatest {
        return format!(
            "the effort of {actuator} is delayed by at least {size:.1} ms relative to the \
             positions, the largest delay that this filter can correct: give a lower --filter, or \
             shift the column of the log in time"
        );
    }
    let order =
        if *value > 0.0 { "follows the positions after" } else { "precedes the positions by" };
    format!(
        "the effort of {actuator} {order} {size:.3} +- {sigma:.3} ms: this delay is corrected; `delay = 0` in the \
         options prevents that"
    )
}
