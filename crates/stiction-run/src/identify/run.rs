//! The computation: structure, fit, verdicts, predictions.

use super::IdentifyError;
use super::chosen::{chosen_efforts, refuse};
use super::options::IdentifySettings;
use super::prepare::{MeasuredLog, Prepared};
use super::sanity;
use super::selection::{enough, held_of, options, scale_by_data};
use nalgebra::{DMatrix, DVector};
use stiction_core::mechanism::Mechanism;
use stiction_core::random::Random;
use stiction_format::{Drives, ModelFile, Source};
use stiction_identify::{
    BaseParameters, Block, Choice, Estimate, FitVerdict, Kind, Options, Parameter, Problem, Verdict,
};

/// Identified parameter.
#[derive(Clone, Debug)]
pub struct Named {
    /// Name.
    pub name: String,
    /// Estimated value, SI units.
    pub value: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Unit.
    pub unit: &'static str,
    /// Verdict.
    pub verdict: Verdict,
    /// Value in the model.
    pub prior: f64,
    /// Structural identifiability in words: of the parameter alone, in a combination with others, or not
    /// at all.
    pub structure: &'static str,
}

/// Combination of parameters that the efforts depend on.
#[derive(Clone, Debug)]
pub struct Combined {
    /// The combination in words.
    pub name: String,
    /// Estimated value.
    pub value: f64,
    /// Standard deviation.
    pub sigma: f64,
    /// Unit.
    pub unit: &'static str,
    /// Verdict.
    pub verdict: Verdict,
}

/// Errors on one log.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Name of the log.
    pub log: String,
    /// `true` if the log was fitted.
    pub used_for_fit: bool,
    /// For each actuator: its name, and 100 rms(measured - predicted) / rms(measured), percent.
    pub error_percent: Vec<(String, f64)>,
    /// The same for the model as it was.
    pub prior_percent: Vec<f64>,
}

/// Result of identification.
#[derive(Clone, Debug)]
pub struct Identified {
    /// Verdict on the fit.
    pub verdict: FitVerdict,
    /// Reasons for the verdict, and cautions on the logs.
    pub cautions: Vec<String>,
    /// All parameters.
    pub parameters: Vec<Named>,
    /// All combinations of more than one parameter.
    pub combinations: Vec<Combined>,
    /// Number of combinations that the structure lets be determined, and the gap of this rank.
    pub rank: (usize, f64),
    /// Pairs that the data cannot tell apart, with what would.
    pub confounded: Vec<(String, String, String)>,
    /// Errors on all logs.
    pub predictions: Vec<Prediction>,
    /// The mechanism with the identified values.
    pub mechanism: Mechanism,
    /// Strength of the prior of inertias, in equivalent samples.
    pub strength: f64,
    /// Residuals of left-out blocks over those of the fit, mean squares.
    pub left_out: f64,
    /// The same for least squares without prior.
    pub left_out_plain: f64,
    /// Cut-off frequency of the filter of each log, Hz.
    pub cutoffs: Vec<f64>,
    /// Standard deviation of the residuals of each actuator, N or N m.
    pub residuals: Vec<f64>,
}

/// Sweeps in which normal loads and values determine each other.
const SWEEPS: usize = 12;
/// Change of values, in standard deviations, at which they agree.
const SETTLED: f64 = 0.01;
/// Instants of random rates for the structure.
const STRUCTURE_SAMPLES: usize = 240;

/// Identifies inertia and friction of a model from logs.
///
/// # Errors
/// Logs or options that cannot be used.
pub fn identify(
    model: &ModelFile,
    logs: &[MeasuredLog],
    settings: &IdentifySettings,
) -> Result<Identified, IdentifyError> {
    let mechanism = &model.mechanism;
    let first =
        logs.first().ok_or_else(|| refuse("no log is given", "give at least one CSV file"))?;
    if logs.iter().all(|log| log.settings.predict) {
        return Err(refuse("all logs are for prediction", "give `use = \"fit\"` to at least one"));
    }
    let (_, at_motors) = chosen_efforts(mechanism, first)?;
    let terms = read_terms(model, settings)?;
    let choice = Choice { at_motors, offsets: settings.offsets, terms: terms.len(), ..Choice::ALL };
    let mut all = Vec::new();
    for log in logs {
        if chosen_efforts(mechanism, log)?.1 != at_motors {
            return Err(refuse(
                format!("{} and {} measure efforts at different places", first.name, log.name),
                "measure all at the motors or all at the joints",
            ));
        }
        all.push(Prepared::new(model, log, (settings.filter, choice), &terms)?);
    }
    let mut parameters: Vec<Parameter> = all[0].regressor.parameters().to_vec();
    for (index, (name, _)) in settings.terms.iter().enumerate() {
        parameters
            .iter_mut()
            .filter(|p| p.kind == Kind::Term(index))
            .for_each(|p| p.name.clone_from(name));
    }
    scale_by_data(&mut parameters, &all);
    let options = options(mechanism, &parameters, settings)?;
    let actuators: Vec<String> =
        mechanism.actuators().map(|(j, dof)| mechanism.joints()[j.0].actuator_name(dof)).collect();
    let priors: Vec<f64> = parameters.iter().map(|p| p.prior).collect();
    let mut cautions: Vec<String> = all.iter().flat_map(|log| log.cautions.clone()).collect();
    for log in &mut all {
        log.update_loads(&priors).map_err(|why| {
            refuse(
                format!("{}: the model with its own friction has no forces {why}", log.name),
                "give smaller coefficients of friction in the model; they are only the start",
            )
        })?;
    }
    enough(&all, &parameters, &options)?;
    let spinning = all[0].regressor.spinning_bodies();
    if !spinning.is_empty() {
        cautions.push(format!(
            "{} can spin freely: their inertia counts as symmetric about the axis of the spin",
            spinning.join(", ")
        ));
    }
    let prior_errors: Vec<Vec<f64>> =
        all.iter().map(|log| errors(&log.block, &parameters, &priors)).collect();
    let structure = structure(&all, &parameters);

    let (estimate, blocks, is_settled) = fitted(&mut all, &parameters, options, &mut cautions);
    for log in &mut all {
        if log.predict
            && let Err(why) = log.update_loads(&estimate.values)
        {
            cautions.push(format!(
                "{}: with the identified friction there are no forces {why}",
                log.name
            ));
        }
    }
    let held = &held_of(&parameters, settings);
    let named: Vec<Named> = parameters
        .iter()
        .enumerate()
        .map(|(k, p)| Named {
            name: p.name.clone(),
            value: estimate.values[k],
            sigma: estimate.sigmas[k],
            unit: p.unit,
            verdict: match held[k] {
                true => Verdict::Held,
                false => Verdict::of(
                    estimate.resolution[k],
                    estimate.sigmas[k],
                    estimate.values[k],
                    p.scale,
                    structure.is_alone(k),
                ),
            },
            prior: p.prior,
            structure: match () {
                () if structure.without_effect.contains(&k) => "none",
                () if structure.is_alone(k) => "alone",
                () => "combination",
            },
        })
        .collect();
    let predictions: Vec<Prediction> = all
        .iter()
        .zip(prior_errors)
        .map(|(log, prior_percent)| Prediction {
            log: log.name.clone(),
            used_for_fit: !log.predict,
            error_percent: actuators
                .iter()
                .cloned()
                .zip(errors(&log.block, &parameters, &estimate.values))
                .collect(),
            prior_percent,
        })
        .collect();
    let combinations = combinations(&structure, &parameters, &estimate, held);
    let confounded = sanity::confounded(&named, &estimate, &parameters, held);
    let noise = effort_noise(&all);
    cautions.extend(sanity::wrong_efforts(&blocks, &parameters, &actuators));
    let mut verdict = sanity::fit_verdict(
        (&named, &combinations, &predictions),
        &estimate,
        (&noise, &actuators),
        &mut cautions,
    );
    if !is_settled && verdict == FitVerdict::Identified {
        verdict = FitVerdict::FitsOnly;
    }
    let identified = stiction_identify::applied(mechanism, &parameters, &estimate.values);
    Ok(Identified {
        verdict,
        cautions,
        parameters: named,
        combinations,
        rank: (structure.rank(), structure.gap),
        confounded,
        predictions,
        mechanism: identified,
        strength: estimate.strength,
        left_out: estimate.left_out_ratio,
        left_out_plain: estimate.left_out_ratio_plain,
        cutoffs: all.iter().map(|log| log.cutoff).collect(),
        residuals: estimate.noise,
    })
}

/// The fit, alternating with the normal loads that the values cause.
fn fitted(
    all: &mut [Prepared],
    parameters: &[Parameter],
    mut options: Options,
    cautions: &mut Vec<String>,
) -> (Estimate, Vec<Block>, bool) {
    let own_strength = options.strength;
    let blocks_of = |all: &[Prepared]| -> Vec<Block> {
        all.iter().filter(|log| !log.predict).map(|log| log.block.clone()).collect()
    };
    let has_loads = parameters.iter().any(|p| matches!(p.kind, Kind::Mu(_)));
    let mut blocks = blocks_of(all);
    let mut estimate = Problem { parameters, blocks: &blocks, options: &options }.solve();
    let mut last = f64::INFINITY;
    let mut at: Vec<f64> = estimate.values.clone();
    for _ in 0..if has_loads { SWEEPS } else { 0 } {
        let failed =
            all.iter_mut().filter(|log| !log.predict).find_map(|log| log.update_loads(&at).err());
        if let Some(why) = failed {
            // Half the coefficients: friction beyond a lock has no forces.
            for (value, p) in at.iter_mut().zip(parameters) {
                if matches!(p.kind, Kind::Mu(_)) {
                    *value *= 0.5;
                }
            }
            let locks = format!("the identified friction locks the mechanism {why}");
            if !cautions.contains(&locks) {
                cautions.push(locks);
            }
            last = f64::INFINITY;
            continue;
        }
        blocks = blocks_of(all);
        options.strength = own_strength.or(Some(estimate.strength));
        let (left_out, plain) = (estimate.left_out_ratio, estimate.left_out_ratio_plain);
        let before = estimate;
        estimate = Problem { parameters, blocks: &blocks, options: &options }.solve_fixed(&before);
        (estimate.left_out_ratio, estimate.left_out_ratio_plain) = (left_out, plain);
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
    let is_settled = !has_loads || last <= 1.0;
    if !is_settled {
        cautions.push(match last.is_finite() {
            true => format!(
                "normal loads and coefficients of friction still change by {last:.1} standard deviations"
            ),
            false => "the normal loads are those of another friction than the identified one".to_owned(),
        });
    }
    (estimate, blocks, is_settled)
}

pub(super) fn read_terms(
    model: &ModelFile,
    settings: &IdentifySettings,
) -> Result<Vec<Drives>, IdentifyError> {
    let each = settings.terms.iter().map(|(name, text)| {
        let source = Source::new(format!("terms.{name}"), text.as_str());
        model.parse_drives(&source, &|_| Err("no files here".to_owned())).map_err(|out| {
            refuse(
                format!("options: the term `{name}` is not understood:\n{out}"),
                "write `JOINT = FORMULA`",
            )
        })
    });
    each.collect()
}

/// Values as differences that rows multiply: inertias from the model's.
pub(super) fn differences(parameters: &[Parameter], values: &[f64]) -> DVector<f64> {
    let each = parameters
        .iter()
        .zip(values)
        .map(|(p, v)| if p.body().is_some() { v - p.prior } else { *v });
    DVector::from_iterator(values.len(), each)
}

/// Relative errors of all efforts, percent.
fn errors(block: &Block, parameters: &[Parameter], values: &[f64]) -> Vec<f64> {
    let at = differences(parameters, values);
    let each = block.channels.iter().map(|rows| {
        let size = rows.measured.norm();
        if size > 0.0 { 100.0 * rows.residuals(&at).norm() / size } else { 0.0 }
    });
    each.collect()
}

/// Combinations that the mechanism lets be determined about the positions of the logs, with random rates.
fn structure(all: &[Prepared], parameters: &[Parameter]) -> BaseParameters {
    let mut random = Random::new(1);
    let mut rows: Vec<nalgebra::RowDVector<f64>> = Vec::new();
    let per_log = STRUCTURE_SAMPLES.div_ceil(all.len());
    for log in all {
        let mut regressor = log.regressor.clone();
        let mut engine = regressor.engine_data();
        let nominal =
            regressor.engine_parameters(&parameters.iter().map(|p| p.prior).collect::<Vec<_>>());
        let size = |pick: fn(&[Vec<f64>; 3]) -> &Vec<f64>| {
            let all = log.instants.iter().flat_map(|(_, motion)| pick(motion));
            all.fold(1e-6, |max: f64, x| max.max(x.abs()))
        };
        let (fastest, most) = (size(|m| &m[1]), size(|m| &m[2]));
        let stride = (log.instants.len() / per_log).max(1);
        for (_, [q, ..]) in log.instants.iter().step_by(stride) {
            let v: Vec<f64> = q.iter().map(|_| fastest * random.number()).collect();
            let a: Vec<f64> = q.iter().map(|_| most * random.number()).collect();
            let Ok(columns) = regressor.at(q, &v, &a) else { continue };
            let Ok(loads) = regressor.loads(&nominal, &mut engine, [q, &v, &a]) else { continue };
            for channel in 0..columns.matrix.nrows() {
                let mut row = columns.matrix.row(channel).into_owned();
                for (k, p) in parameters.iter().enumerate() {
                    if let Kind::Mu(i) = p.kind {
                        row[k] *= loads[i] - nominal.interfaces[i].load.preload;
                    }
                }
                rows.push(row);
            }
        }
    }
    if rows.is_empty() {
        return BaseParameters::of(&DMatrix::zeros(0, parameters.len()), parameters);
    }
    BaseParameters::of(&DMatrix::from_rows(&rows), parameters)
}

fn combinations(
    structure: &BaseParameters,
    parameters: &[Parameter],
    estimate: &Estimate,
    held: &[bool],
) -> Vec<Combined> {
    let several = structure.combinations.iter().filter(|c| !c.others.is_empty());
    let each = several.filter(|c| !held[c.leader]).map(|c| {
        let members: Vec<(usize, f64)> =
            std::iter::once((c.leader, 1.0)).chain(c.others.iter().copied()).collect();
        let mut variance = 0.0;
        let mut size = 0.0;
        for (i, a) in &members {
            size += (a * parameters[*i].scale).powi(2);
            for (k, b) in &members {
                variance += a * b * estimate.covariance[(*i, *k)];
            }
        }
        let (value, sigma) = (c.value(&estimate.values), variance.max(0.0).sqrt());
        let reach = size.sqrt();
        let verdict = match sigma {
            s if s < 0.1 * reach => Verdict::Identified,
            s if s < 0.5 * reach => Verdict::FitsOnly,
            _ => Verdict::NotExcited,
        };
        let leader = &parameters[c.leader];
        Combined { name: c.words(parameters, 8), value, sigma, unit: leader.unit, verdict }
    });
    each.collect()
}

/// Mean noise of each effort after the filter.
fn effort_noise(all: &[Prepared]) -> Vec<f64> {
    let fits: Vec<&Prepared> = all.iter().filter(|log| !log.predict).collect();
    let count = fits.len().max(1) as f64;
    let channels = all[0].block.channels.len();
    (0..channels).map(|c| fits.iter().map(|log| log.effort_noise[c]).sum::<f64>() / count).collect()
}
