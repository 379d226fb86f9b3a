//! Effects that the residuals of a fit show: offsets, delays, curves of friction, dependence on position and load, drift.
//!
//! Each effect is a column that the regression may lack. Those that are certain, that predict left-out parts of
//! the logs better and that matter are added one after the other, each time to a new fit.

use super::delay::{CERTAIN, candidate};
use super::prepare::{EFFECTS, Effect, Prepared};
use nalgebra::DMatrix;
use stiction_identify::{Block, Estimate, Extension, Kind, Options, Parameter, Problem};

/// Effect that a model or its options lack.
#[derive(Clone, Debug)]
pub struct Missing {
    /// Name of the actuator.
    pub actuator: String,
    /// The effect in words.
    pub what: String,
    /// Its size.
    pub value: f64,
    /// Standard deviation of its size.
    pub sigma: f64,
    /// Unit of its size.
    pub unit: &'static str,
    /// Part of the residual squares of left-out fifths of the logs by which they decrease with it.
    pub gain: f64,
    /// Parameters that it changes by more than a standard deviation, with their changes in standard deviations, the
    /// largest first.
    pub changes: Vec<(String, f64)>,
    /// What to write or to do.
    pub cure: String,
}

/// Part of the residual squares of left-out fifths that an effect explains if it matters by itself.
const EXPLAINED: f64 = 0.1;
/// Part of them that it must explain in any case.
const LEAST: f64 = 0.005;
/// Change of a parameter, in standard deviations, that matters.
const CHANGED: f64 = 1.0;
/// Standard deviations up to which an effect is doubtful in the fit with it.
const DOUBTFUL: f64 = 2.0;
/// Parameters that a caution names.
const NAMED: usize = 6;

/// Fit that effects are added to.
pub(super) struct Fit<'a> {
    pub(super) all: &'a [Prepared],
    pub(super) parameters: &'a [Parameter],
    pub(super) options: &'a Options,
    pub(super) estimate: &'a Estimate,
    pub(super) actuators: &'a [(String, &'static str)],
    /// Parameters that count as identified without the effects.
    pub(super) identified: &'a [bool],
}

/// Effects that were found, and the fit with all of them.
pub(super) struct Found {
    pub(super) missing: Vec<Missing>,
    /// Change of each parameter by all effects together, SI units.
    pub(super) changes: Vec<f64>,
}

impl Fit<'_> {
    /// Adds the effects that the residuals show, the one that predicts left-out parts best first.
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
                    rows.matrix = widened(&mut rows.matrix, 0.0);
                    if k == channel {
                        rows.matrix.set_column(rows.matrix.ncols() - 1, signal);
                    }
                }
            }
            for block in &mut blocks {
                for (k, dwells) in block.dwells.iter_mut().enumerate() {
                    // Of all effects, only a constant error of the effort acts at rest, too.
                    let at_rest = effect == Effect::Offset && k == channel;
                    let value = f64::from(u8::from(at_rest));
                    dwells.matrix = widened(&mut dwells.matrix, value);
                    dwells.limits = widened(&mut dwells.limits, 0.0);
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
            // The new fit explains the residuals by its parameters: they had been held by the prior.
            for rows in blocks.iter_mut().flat_map(|block| &mut block.channels) {
                let matrix = std::mem::replace(&mut rows.matrix, DMatrix::zeros(0, 0));
                rows.matrix = matrix.remove_column(index);
            }
            for dwells in blocks.iter_mut().flat_map(|block| &mut block.dwells) {
                for matrix in [&mut dwells.matrix, &mut dwells.limits] {
                    *matrix = std::mem::replace(matrix, DMatrix::zeros(0, 0)).remove_column(index);
                }
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

    /// The effect with the greatest gain among those that are certain and matter.
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

    /// True if a parameter changes by more than a standard deviation.
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

/// A matrix with a last column of this value, without a copy of what it was.
fn widened(matrix: &mut DMatrix<f64>, value: f64) -> DMatrix<f64> {
    let end = matrix.ncols();
    std::mem::replace(matrix, DMatrix::zeros(0, 0)).insert_column(end, value)
}

/// An effect in words, and its cure.
fn words(effect: Effect, (name, unit): (&str, &str), is_positive: bool) -> (String, String) {
    let term = |formula: &str| {
        format!(
            "describe it below [terms] of the options, such as `NAME = \"{name} = 1 {unit}*{formula}\"`"
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
            "estimate it by `offsets = true`, or give the joint friction that depends on the direction (`backward`)"
                .to_owned(),
        ),
        Effect::Delay => (
            "a delay of the effort after the positions".to_owned(),
            "let it be estimated by `delay = \"auto\"`".to_owned(),
        ),
        Effect::SlowFriction(part) => (
            format!(
                "{more} friction below {:.0} % of the highest speed (Stribeck's curve)",
                100.0 * part
            ),
            "give the joint `mu_static` and `stribeck_velocity`, or log faster motions".to_owned(),
        ),
        Effect::FastFriction => (
            format!("{more} friction at high speed than in proportion to the rate"),
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
            "friction that drifts from the middle of the log to its end, as by warming".to_owned(),
            "log after warming up, or choose a part by `from` and `until`".to_owned(),
        ),
        Effect::EffortDrift => (
            "a drift of the effort from the middle of the log to its end".to_owned(),
            "choose a part of the log by `from` and `until`, or mend the sensor".to_owned(),
        ),
    };
    (what, cure)
}

impl Missing {
    /// Caution on the effect.
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
                "; with all that is missing, standard deviations of change: {}{more}",
                named.join(", ")
            ),
        };
        format!(
            "{}: the residuals show {} of {:.4e} +- {:.1e} {}, with which those of left-out parts fall by {:.0} % in \
             square: {}{changes}",
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
