//! Effects that the residuals of a fit show and the model lacks: offsets, delays, other friction
//! curves, dependence on position and load, drift.
//!
//! Each effect is an additional column of the regression. An effect is added if it is certain,
//! improves the prediction of left-out parts of the logs, and matters for the result. Effects are
//! added one by one, and the logs are fitted again after each addition.

use super::delay::{CERTAIN, candidate};
use super::prepare::{EFFECTS, Effect, Prepared};
use nalgebra::DVector;
use stiction_identify::{Block, Estimate, Extension, Kind, Options, Parameter, Problem};

/// Effect that the residuals show and the model lacks.
#[derive(Clone, Debug)]
pub struct Missing {
    /// Name of the actuator whose effort shows the effect.
    pub actuator: String,
    /// Description of the effect in words.
    pub what: String,
    /// Size of the effect: the fitted coefficient, in `unit`.
    pub value: f64,
    /// Standard deviation of `value`, in `unit`.
    pub sigma: f64,
    /// Unit of the fitted coefficient of the effect.
    pub unit: &'static str,
    /// Fraction by which the effect reduces the squared residuals in cross-validation, in which
    /// each fifth of the logs is predicted from the other four.
    pub gain: f64,
    /// Parameters that all missing effects together change by more than one standard deviation,
    /// each with its change in standard deviations. The largest change comes first.
    pub changes: Vec<(String, f64)>,
    /// Advice to the user: the change of the model or of the options that accounts for the effect.
    pub cure: String,
}

/// An effect that explains more than this fraction of the squared residuals of left-out fifths of
/// the logs matters even if it changes no parameter.
const EXPLAINED: f64 = 0.1;
/// An effect that explains less than this fraction of the squared residuals of left-out fifths of
/// the logs is ignored.
const LEAST: f64 = 0.005;
/// Change of a parameter, in standard deviations of this parameter, above which the effect that
/// causes the change matters.
const CHANGED: f64 = 1.0;
/// An effect is doubtful and is removed if, in the fit that includes the effect, its coefficient
/// does not exceed this number of standard deviations.
const DOUBTFUL: f64 = 2.0;
/// Largest number of parameters that a caution names.
const NAMED: usize = 6;

/// Fit of the logs with the original model, from which the search for missing effects starts.
pub(super) struct Fit<'a> {
    pub(super) all: &'a [Prepared],
    pub(super) parameters: &'a [Parameter],
    pub(super) options: &'a Options,
    pub(super) estimate: &'a Estimate,
    pub(super) actuators: &'a [(String, &'static str)],
    /// True for each parameter that counts as identified in the fit without effects.
    pub(super) identified: &'a [bool],
}

/// Effects that the residuals show, and the changes of the parameters due to these effects.
pub(super) struct Found {
    pub(super) missing: Vec<Missing>,
    /// Change of each parameter due to all effects together, SI units.
    pub(super) changes: Vec<f64>,
}

impl Fit<'_> {
    /// Finds the effects that the residuals show. The effects are returned in the order in which
    /// the search adds them; the first effect improves the prediction of left-out parts of the logs
    /// most.
    pub(super) fn missing(&self) -> Found {
        let count = self.parameters.len();
        let mut blocks: Vec<Block> =
            self.all.iter().filter(|log| !log.predict).map(|log| log.block.clone()).collect();
        let (mut parameters, mut options) = (self.parameters.to_vec(), self.options.clone());
        let mut estimate = self.estimate.clone();
        let mut chosen: Vec<(usize, Effect, f64)> = Vec::new();
        let mut tried: Vec<(usize, Effect)> = Vec::new();
        while chosen.len() < 2 * self.actuators.len() {
            let problem = Problem { parameters: &parameters, blocks: &blocks, options: &options };
            let Some((channel, effect, found)) = self.best(&problem, &estimate, &tried) else {
                break;
            };
            tried.push((channel, effect));
            let Some(column) = candidate(self.all, channel, effect) else { break };
            for (block, signal) in blocks.iter_mut().zip(&column.signal) {
                for (k, rows) in block.channels.iter_mut().enumerate() {
                    match k == channel {
                        true => rows.push_column(signal),
                        false => rows.push_column(&DVector::zeros(rows.len())),
                    }
                }
            }
            for block in &mut blocks {
                for (k, dwells) in block.dwells.iter_mut().enumerate() {
                    // Of all effects, only a constant error of the effort also acts at rest.
                    let at_rest = effect == Effect::Offset && k == channel;
                    dwells.push_column(f64::from(u8::from(at_rest)));
                }
            }
            let index = parameters.len();
            parameters.push(Parameter {
                name: String::new(),
                unit: "",
                kind: Kind::Offset(channel),
                prior: 0.0,
                scale: found.value.abs(),
            });
            options.held.push(false);
            let problem = Problem { parameters: &parameters, blocks: &blocks, options: &options };
            let new = problem.solve_fixed(&estimate);
            if new.values[index].abs() > DOUBTFUL * new.sigmas[index] {
                estimate = new;
                chosen.push((channel, effect, found.gain));
                continue;
            }
            // In the new fit, parameters that the prior had restrained explain the residuals
            // instead of the effect, so the effect is removed.
            for rows in blocks.iter_mut().flat_map(|block| &mut block.channels) {
                rows.pop_column();
            }
            for dwells in blocks.iter_mut().flat_map(|block| &mut block.dwells) {
                dwells.pop_column();
            }
            parameters.pop();
            options.held.pop();
        }
        let changes: Vec<f64> =
            (0..count).map(|k| estimate.values[k] - self.estimate.values[k]).collect();
        let each = chosen.iter().enumerate().map(|(index, &(channel, effect, gain))| {
            let (value, sigma) = (estimate.values[count + index], estimate.sigmas[count + index]);
            self.described((channel, effect, gain), (value, sigma), &changes)
        });
        Found { missing: each.collect(), changes }
    }

    /// Finds the effect with the largest gain among the effects that are not in `tried`, are
    /// certain, and matter.
    fn best(
        &self,
        problem: &Problem<'_>,
        estimate: &Estimate,
        tried: &[(usize, Effect)],
    ) -> Option<(usize, Effect, Extension)> {
        let residuals = problem.residuals(estimate);
        let mut best: Option<(usize, Effect, Extension)> = None;
        for channel in 0..self.actuators.len() {
            for effect in EFFECTS {
                if tried.contains(&(channel, effect)) {
                    continue;
                }
                let found = candidate(self.all, channel, effect);
                let Some(found) = found.and_then(|column| residuals.extension(&column)) else {
                    continue;
                };
                let is_best = best.as_ref().is_none_or(|(.., best)| found.gain > best.gain);
                if is_best && self.matters(&found) {
                    best = Some((channel, effect, found));
                }
            }
        }
        best
    }

    fn matters(&self, found: &Extension) -> bool {
        let is_certain =
            found.value.abs() > CERTAIN * found.sigma && found.gain > LEAST.max(found.gain_sigma);
        is_certain
            && (found.gain > EXPLAINED
                || (0..self.identified.len()).any(|k| {
                    self.identified[k] && found.changes[k].abs() > CHANGED * self.estimate.sigmas[k]
                }))
    }

    /// Returns whether a change of parameter `k`, SI units, exceeds the standard deviation of the
    /// parameter.
    pub(super) fn is_changed(&self, k: usize, change: f64) -> bool {
        change.abs() > CHANGED * self.estimate.sigmas[k] && self.estimate.sigmas[k] > 0.0
    }

    fn described(
        &self,
        (channel, effect, gain): (usize, Effect, f64),
        (value, sigma): (f64, f64),
        changes: &[f64],
    ) -> Missing {
        let (name, effort) = self.actuators[channel].clone();
        let mut changed: Vec<(String, f64)> = (0..changes.len())
            .filter(|&k| self.identified[k] && self.is_changed(k, changes[k]))
            .map(|k| (self.parameters[k].name.clone(), changes[k] / self.estimate.sigmas[k]))
            .collect();
        changed.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        let (what, cure) = words(effect, (&name, effort), value > 0.0);
        let unit = if effect == Effect::Delay { "s" } else { effort };
        Missing { actuator: name, what, value, sigma, unit, gain, changes: changed, cure }
    }
}

/// Returns a description of an effect, and advice to the user on how to account for it. `name` is
/// the actuator, `unit` the unit of its effort, and `is_positive` the sign of the coefficient.
fn words(effect: Effect, (name, unit): (&str, &str), is_positive: bool) -> (String, String) {
    let term = |formula: &str| {
        format!(
            "describe it below [terms] of the options, for example `NAME = \"{name} = 1 {unit}*{formula}\"`"
        )
    };
    let (rate, sine) = match unit {
        "N" => ("m/s", format!("{name}/(1 m)")),
        _ => ("rad/s", format!("sin({name})")),
    };
    let more = if is_positive { "more" } else { "less" };
    let (what, cure) = match effect {
        Effect::Offset => (
            "a constant error of the effort".to_owned(),
            "set `offsets = true` to estimate it, or declare direction-dependent friction of the joint (`backward`)"
                .to_owned(),
        ),
        Effect::Delay => (
            "a delay of the effort relative to the positions".to_owned(),
            "set `delay = \"auto\"` to estimate it".to_owned(),
        ),
        Effect::SlowFriction(part) => (
            format!(
                "{more} friction below {:.0} % of the highest speed (Stribeck's curve)",
                100.0 * part
            ),
            "give the joint `mu_static` and `stribeck_velocity`, or log faster motions".to_owned(),
        ),
        Effect::FastFriction => (
            format!("{more} friction at high speed than viscous friction predicts"),
            term(&format!("d({name})*abs(d({name}))/(1 {rate})^2")),
        ),
        Effect::Position | Effect::PositionSquare => (
            "an effort that depends on the position, such as a spring, a cable or a balancer".to_owned(),
            term(&sine),
        ),
        Effect::PositionFriction => (
            "friction that depends on the position".to_owned(),
            term(&format!("sign(d({name}))*{sine}")),
        ),
        Effect::LoadFriction => (
            "friction that depends on the load".to_owned(),
            "give the joint a coefficient of friction `mu`".to_owned(),
        ),
        Effect::FrictionDrift | Effect::ViscousDrift => (
            "friction that drifts during the second half of the log, for example as the joints warm up"
                .to_owned(),
            "log after warming up, or choose a part with `from` and `until`".to_owned(),
        ),
        Effect::EffortDrift => (
            "a drift of the effort during the second half of the log".to_owned(),
            "choose a part of the log with `from` and `until`, or repair the sensor".to_owned(),
        ),
    };
    (what, cure)
}

impl Missing {
    /// Returns a caution that describes the effect and its consequences.
    pub(super) fn caution(&self) -> String {
        let named = self.changes.iter().take(NAMED);
        let named: Vec<String> =
            named.map(|(name, change)| format!("{name} by {change:+.1}")).collect();
        let more = match self.changes.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let changes = match named.is_empty() {
            true => String::new(),
            false => format!(
                "; modelling all missing effects would change {}{more} (in standard deviations)",
                named.join(", ")
            ),
        };
        format!(
            "{}: the residuals show {} of {:.4e} +- {:.1e} {}; estimating it lowers the squared \
             residuals of left-out parts by {:.0} %: {}{changes}",
            self.actuator,
            self.what,
            self.value,
            self.sigma,
            self.unit,
            100.0 * self.gain,
            self.cure
        )
    }
}
