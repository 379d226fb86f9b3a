//! Identification from logs: structure of the regression, fit, verdicts, predictions.

use super::asymmetry;
use super::at_rest;
use super::chosen::{chosen_efforts, refuse};
use super::closed_loop;
use super::delay::{self, Delay};
use super::gear_losses::GearLosses;
use super::identified::{Identified, Named, Prediction};
use super::missing::{self, Missing};
use super::normal_loads::fitted;
use super::options::{Estimator, IdentifySettings};
use super::prepare::{MeasuredLog, Preparation, Prepared};
use super::sanity;
use super::selection::{BodyBound, choice, enough, free_groups, options, scale_by_data};
use super::structure::{combinations, structure};
use super::torque_constants;
use super::{IdentifyError, Progress};
use nalgebra::DVector;
use stiction_format::{Drives, ModelFile, Source};
use stiction_identify::{
    Block, Estimate, Evidence, FitVerdict, Kind, Options, Parameter, Problem, Verdict,
};

/// Identifies inertia and friction of a model from logs. `progress` receives the name of the present step of the
/// computation, and how many of its parts, of how many at most, are done.
///
/// # Errors
/// [`IdentifyError`] if logs or options cannot be used.
pub fn identify(
    model: &ModelFile,
    logs: &[MeasuredLog],
    settings: &IdentifySettings,
    progress: Progress<'_>,
) -> Result<Identified, IdentifyError> {
    let fit = |logs: &[MeasuredLog]| fit(model, logs, settings, progress);
    match &settings.estimator {
        Estimator::OutputError(control) => {
            closed_loop::identify(model, logs, (control, settings.filter), progress, fit)
        }
        Estimator::LeastSquares | Estimator::InstrumentalVariables => fit(logs),
    }
}

/// Identifies inertia and friction of a model from the motions in the logs.
fn fit(
    model: &ModelFile,
    logs: &[MeasuredLog],
    settings: &IdentifySettings,
    progress: Progress<'_>,
) -> Result<Identified, IdentifyError> {
    let mechanism = &model.mechanism;
    let first =
        logs.first().ok_or_else(|| refuse("no log is given", "give at least one CSV file"))?;
    if logs.iter().all(|log| log.settings.predict) {
        return Err(refuse("all logs are for prediction", "give `use = \"fit\"` to at least one"));
    }
    let terms = read_terms(model, settings)?;
    let choice = choice(mechanism, logs, settings, terms.len())?;
    let at_motors = choice.at_motors;
    for log in logs {
        if chosen_efforts(mechanism, log)?.1 != at_motors {
            return Err(refuse(
                format!("{} and {} measure efforts at different places", first.name, log.name),
                "measure all at the motors or all at the joints",
            ));
        }
    }
    let filter = settings.filter;
    let preparation = Preparation { model, filter, choice: &choice, terms: &terms, progress };
    let prepare = |delays: Option<&[f64]>| -> Result<Vec<Prepared>, IdentifyError> {
        let each = logs.iter().map(|log| {
            let mut own = Prepared::new(preparation, log, delays)?;
            if settings.estimator == Estimator::InstrumentalVariables && !own.predict {
                own.add_reference(preparation, log)?;
            }
            Ok(own)
        });
        let mut all: Vec<Prepared> = each.collect::<Result<_, IdentifyError>>()?;
        let fits = all.iter_mut().filter(|log| !log.predict);
        Block::relate(&mut fits.map(|log| &mut log.block).collect::<Vec<_>>());
        Ok(all)
    };
    let actuators: Vec<String> =
        mechanism.actuators().map(|(j, dof)| mechanism.joints()[j.0].actuator_name(dof)).collect();
    let given = settings.delay.map(|delay| vec![delay; actuators.len()]);
    let mut all = prepare(given.as_deref())?;
    let mut parameters = parameters_of(&all[0], settings);
    let (options, body_bounds) = options(mechanism, &parameters, settings)?;
    let mut cautions: Vec<String> = all.iter().flat_map(|log| log.cautions.clone()).collect();
    let lossy = if at_motors {
        GearLosses::new(mechanism, &parameters, &options.held)
    } else {
        GearLosses::default()
    };
    cautions.extend(lossy.cautions(mechanism));
    let groups = free_groups(&parameters, &options);
    // The structure of the parameters is that of the direct effects of inertia: the effects through
    // the friction of loaded joints are weak, and would make every mass seem identifiable.
    let has_friction =
        |group: &&Vec<usize>| group.iter().any(|&k| parameters[k].kind.interface().is_some());
    let frictions: Vec<Vec<usize>> = groups.iter().filter(has_friction).cloned().collect();
    let mut priors: Vec<f64> = parameters.iter().map(|p| p.prior).collect();
    for log in &mut all {
        log.linearise(&priors, &frictions).map_err(|why| without_forces(&log.name, &why))?;
    }
    torque_constants::start(&mut parameters, &mut all);
    scale_by_data(&mut parameters, &all);
    priors = parameters.iter().map(|p| p.prior).collect();
    all.iter_mut().for_each(|log| log.set_constants(&priors));
    enough(&all, &parameters, &options)?;
    let problem = Problem { parameters: &parameters, blocks: &[], options: &options };
    if !problem.begins_physical() {
        return Err(refuse(
            "options: with `tie`, the values of the model give inertias that no distribution of \
             mass has",
            "tie only parameters of equal bodies, or give equal values in the model",
        ));
    }
    BodyBound::check(&body_bounds, &problem.initial())?;
    let spinning = all[0].regressor.spinning_bodies();
    if !spinning.is_empty() {
        cautions.push(format!(
            "{} can spin freely: their inertia counts as symmetric about the axis of the spin",
            spinning.join(", ")
        ));
    }
    let prior = differences(&parameters, &priors);
    all.iter_mut().for_each(|log| log.keep_prior(&prior));
    let prior_errors: Vec<Vec<Option<f64>>> =
        all.iter().map(|log| errors(&log.block, &prior).1).collect();
    let held = &options.held.clone();
    let structure = structure(&all, &terms, &parameters, held);
    let by_prior = torque_constants::by_prior(&parameters, &structure, settings)?;

    let mut delays = vec![[settings.delay.unwrap_or(0.0), 0.0]; actuators.len()];
    if let Some(given) = &given {
        all.iter_mut().for_each(|log| log.set_delays(given));
    }
    let is_estimated = given.is_none();
    let mut said = Vec::new();
    if is_estimated {
        // The first estimate of the delays uses the normal loads of the original model.
        delays = delay::take_back(&mut all, &delays, |all, take| {
            let blocks = fitted_blocks(all);
            let problem = Problem { parameters: &parameters, blocks: &blocks, options: &options };
            take(&problem, &problem.solve_weakly());
        });
        if delays.iter().any(|[delay, _]| *delay != 0.0) {
            // The second estimate of the delays uses the normal loads of a fit with the first
            // delays.
            let fit = fitted(&mut all, &parameters, (&options, &groups), (&mut said, progress));
            delays = delay::take_back(&mut all, &delays, |all, take| {
                let blocks = fitted_blocks(all);
                let problem =
                    Problem { parameters: &parameters, blocks: &blocks, options: &options };
                take(&problem, &problem.solve_fixed(&fit.0));
            });
            said.clear();
        }
        let known: Vec<f64> = delays.iter().map(|[delay, _]| *delay).collect();
        // The prepared logs are released before they are prepared again with the delays, because
        // both together would need twice the memory.
        all.clear();
        all = prepare(Some(&known))?;
        for log in &mut all {
            log.start_constants(&priors);
            log.linearise(&priors, &frictions).map_err(|why| without_forces(&log.name, &why))?;
            log.keep_prior(&prior);
            log.set_delays(&known);
        }
    }
    let fit = fitted(&mut all, &parameters, (&options, &groups), (&mut said, progress));
    cautions.extend(said);
    let (estimate, is_settled) = fit;
    let (estimate, said) = at_rest::bounded(&mut all, &parameters, &options, estimate);
    cautions.extend(said);
    let left_out = {
        let blocks = fitted_blocks(&all);
        let problem = Problem { parameters: &parameters, blocks: &blocks, options: &options };
        problem.left_out(&estimate)
    };
    for log in &mut all {
        if log.predict
            && let Err(why) = log.linearise(&estimate.values, &groups)
        {
            cautions.push(format!(
                "{}: with the identified friction, no forces can be computed {why}",
                log.name
            ));
        }
    }
    all.iter_mut().for_each(|log| log.set_constants(&estimate.values));
    let mut named: Vec<Named> = parameters
        .iter()
        .enumerate()
        .map(|(k, p)| Named {
            name: p.name.clone(),
            value: estimate.values[k],
            sigma: estimate.sigmas[k],
            unit: p.unit,
            verdict: match held[k] {
                true => Verdict::Held,
                false => Verdict::of(&Evidence {
                    resolution: estimate.resolution[k],
                    value: estimate.values[k],
                    sigma: estimate.sigmas[k],
                    scale: p.scale,
                    is_alone: structure.free.is_alone(k),
                    has_effect: structure.has_effect(k),
                    pull: estimate.pull[k],
                    correlation: sanity::largest_correlation(&estimate, &options, k),
                }),
            },
            prior: match p.kind {
                Kind::TorqueConstant(_) => f64::NAN,
                _ => p.prior,
            },
            filter_bias: 0.0,
            is_inertia: p.body().is_some(),
            is_of_log: matches!(p.kind, Kind::Offset(_) | Kind::Term(_)),
            structure: match () {
                () if structure.all.without_effect.contains(&k) => "none",
                () if structure.all.is_alone(k) => "alone",
                () => "combination",
            },
        })
        .collect();
    cautions.extend(judge_bounds(&mut named, &parameters, &options, &body_bounds));
    cautions.extend(torque_constants::judge(&mut named, &by_prior, estimate.strength));
    let at = differences(&parameters, &estimate.values);
    let predictions: Vec<Prediction> = all
        .iter()
        .zip(prior_errors)
        .map(|(log, prior_percent)| {
            let (residual, percent) = errors(&log.block, &at);
            Prediction {
                log: log.name.clone(),
                used_for_fit: !log.predict,
                error_percent: actuators.iter().cloned().zip(percent).collect(),
                residual,
                prior_percent,
            }
        })
        .collect();
    let mut combinations = combinations(&structure.free, &parameters, &estimate);
    let confounded = sanity::confounded(&named, &estimate, &parameters, &options);
    cautions.extend(sanity::uncertain(&named, &confounded));
    let noise = effort_noise(&all);
    let doubts = wrong_efforts(&all, (&parameters, &estimate.values), &actuators);
    let is_wrong = doubts.iter().any(|(is_fitted, doubt)| *is_fitted && doubt.has_wrong_sign);
    cautions.extend(doubts.into_iter().map(|(_, doubt)| doubt.text));
    cautions.extend(without_rows(&all, &actuators));
    let asymmetries = asymmetry::of_efforts(&all, &actuators, mechanism);
    let delays = delays_of(&all, &actuators, &delays);
    let greatest = all.iter().map(Prepared::greatest_delay).fold(f64::INFINITY, f64::min);
    if is_estimated {
        cautions.extend(delays.iter().map(|delay| delay::words(delay, greatest)));
    }
    let is_excited = named.iter().any(|p| p.verdict == Verdict::Identified)
        || combinations.iter().any(|c| c.verdict == Verdict::Identified);
    if let Some(biases) = filter_biases(&all, &parameters, &options, &estimate, &at) {
        cautions.extend(sanity::judge_filter(
            (&mut named, &mut combinations),
            &structure.free,
            biases.as_slice(),
        ));
    }
    let identified: Vec<bool> = named.iter().map(|p| p.verdict == Verdict::Identified).collect();
    let units: Vec<(String, &'static str)> = actuators
        .iter()
        .cloned()
        .zip(mechanism.actuators().map(|(joint, dof)| {
            let joint_type = mechanism.joints()[joint.0].joint_type;
            if joint_type.dofs()[dof].translates() { "N" } else { "N m" }
        }))
        .collect();
    let fit = missing::Fit {
        all: &all,
        parameters: &parameters,
        options: &options,
        estimate: &estimate,
        actuators: &units,
        identified: &identified,
    };
    let found = fit.missing();
    for (k, p) in named.iter_mut().enumerate() {
        if p.verdict == Verdict::Identified && fit.is_changed(k, found.changes[k]) {
            p.verdict = Verdict::FitsOnly;
        }
    }
    for (c, combination) in combinations.iter_mut().zip(structure.free.shared()) {
        let change = combination.value(&found.changes);
        let is_scaled = std::iter::once(combination.leader)
            .chain(combination.others.iter().map(|(k, _)| *k))
            .any(|k| by_prior.contains(&k));
        if c.verdict == Verdict::Identified && (is_scaled || change.abs() > c.sigma) {
            c.verdict = Verdict::FitsOnly;
        }
    }
    // If an additional effect explains residuals, the model is incomplete, and the fit does not
    // count as converged.
    let is_settled = is_settled && found.missing.is_empty();
    cautions.extend(found.missing.iter().map(Missing::caution));
    let mut verdict = sanity::fit_verdict(
        (&named, &combinations, &predictions),
        (&estimate, left_out),
        &sanity::Residuals {
            noise: noise.as_deref(),
            reference: &references(&all),
            actuators: &actuators,
        },
        is_wrong,
        &mut cautions,
    );
    // The data determine values, but only in a model with additional effects or with a specified
    // strength of the prior.
    let is_only_changed = verdict == FitVerdict::NotExcited && (is_excited || !by_prior.is_empty());
    let is_settled = is_settled && by_prior.is_empty();
    if is_only_changed || (!is_settled && verdict == FitVerdict::Identified) {
        verdict = FitVerdict::FitsOnly;
    }
    let identified = stiction_identify::applied(
        mechanism,
        &parameters,
        &estimate.values,
        (at_motors, &lossy.in_friction),
    );
    Ok(Identified {
        verdict,
        cautions,
        parameters: named,
        combinations,
        rank: (structure.all.rank(), structure.all.gap),
        confounded,
        asymmetries,
        delays,
        missing: found.missing,
        predictions,
        mechanism: identified,
        estimator: settings.estimator.name(),
        simulated: None,
        strength: estimate.strength,
        left_out: left_out.ratio,
        left_out_plain: left_out.plain,
        cutoffs: all.iter().map(|log| log.cutoff).collect(),
        residuals: estimate.noise,
    })
}

pub(super) fn without_forces(log: &str, why: &str) -> IdentifyError {
    refuse(
        format!("{log}: with the friction of the model, no forces can be computed {why}"),
        "give smaller friction coefficients in the model; identification only starts from them",
    )
}

/// Downgrades the verdicts of parameters whose values lie at the bounds that the options set, and
/// returns cautions that name these parameters.
fn judge_bounds(
    named: &mut [Named],
    parameters: &[Parameter],
    options: &Options,
    bodies: &[BodyBound],
) -> Vec<String> {
    let mut cautions = Vec::new();
    let values: Vec<f64> = named.iter().map(|p| p.value).collect();
    let own = options.bounds.iter().map(|&(k, [low, high])| {
        let p = &named[k];
        // Zero bounds such a parameter without options, too.
        let is_natural = parameters[k].is_nonnegative() && low <= 0.0;
        let low = if is_natural { f64::NEG_INFINITY } else { low };
        (k, (p.name.clone(), p.unit), p.value, 0.0, [low, high])
    });
    let bodies = bodies.iter().map(|own| {
        let name = (own.name.clone(), own.unit);
        (own.leader(), name, own.value(&values), own.scale, own.range)
    });
    for (k, (name, unit), value, scale, bounds) in own.chain(bodies).collect::<Vec<_>>() {
        let near = |bound: f64| {
            bound.is_finite() && (value - bound).abs() <= 1e-9 * bound.abs().max(scale)
        };
        let p = &mut named[k];
        let Some(bound) = bounds.into_iter().find(|bound| near(*bound)) else { continue };
        if p.verdict == Verdict::Held {
            continue;
        }
        p.verdict = Verdict::FitsOnly;
        let caution = format!(
            "{name} lies at its bound {}: without `bounds` in the options, its estimate would lie \
             beyond this value",
            format!("{bound} {unit}").trim_end()
        );
        if !cautions.contains(&caution) {
            cautions.push(caution);
        }
    }
    cautions
}

/// Returns the regression rows of the fitted logs.
pub(super) fn fitted_blocks(all: &[Prepared]) -> Vec<Block> {
    all.iter().filter(|log| !log.predict).map(|log| log.block.clone()).collect()
}

/// Returns the errors of all parameters due to the filter, SI units; `None` if these errors cannot
/// be computed for one of the fitted logs, for example a table of steady motions.
fn filter_biases(
    all: &[Prepared],
    parameters: &[Parameter],
    options: &Options,
    estimate: &Estimate,
    at: &DVector<f64>,
) -> Option<DVector<f64>> {
    let fits = all.iter().filter(|log| !log.predict);
    let errors: Option<Vec<_>> = fits.map(|log| log.filter_error(&estimate.values, at)).collect();
    let blocks = fitted_blocks(all);
    let problem = Problem { parameters, blocks: &blocks, options };
    Some(problem.residuals(estimate).response(&errors?))
}

/// Returns the delays that are not zero, with the names of their actuators; an empty list if all
/// logs are tables of steady motions.
fn delays_of(all: &[Prepared], actuators: &[String], delays: &[[f64; 2]]) -> Vec<Delay> {
    let is_recorded = all.iter().any(|log| log.cutoff.is_some());
    let each = actuators.iter().zip(delays).filter(|(_, [value, _])| is_recorded && *value != 0.0);
    each.map(|(actuator, &[value, sigma])| Delay {
        actuator: actuator.clone(),
        value,
        sigma,
        is_corrected: true,
    })
    .collect()
}

/// Returns doubts about signs and units of measured efforts. The flag is true for a doubt that
/// results from the fitted logs, and false for a doubt about a log that only checks the prediction.
fn wrong_efforts(
    all: &[Prepared],
    (parameters, values): (&[Parameter], &[f64]),
    actuators: &[String],
) -> Vec<(bool, sanity::Doubt)> {
    let fits: Vec<&Prepared> = all.iter().filter(|log| !log.predict).collect();
    let mut found: Vec<(bool, sanity::Doubt)> =
        sanity::wrong_efforts(&fits, (parameters, values), actuators)
            .into_iter()
            .map(|doubt| (true, doubt))
            .collect();
    for log in all.iter().filter(|log| log.predict) {
        let own = sanity::wrong_efforts(&[log], (parameters, values), actuators);
        found.extend(own.into_iter().map(|doubt| {
            let text = format!("{}: {}", log.name, doubt.text);
            (false, sanity::Doubt { text, ..doubt })
        }));
    }
    found
}

/// Returns cautions on actuators for which a log has no usable regression row.
fn without_rows(all: &[Prepared], actuators: &[String]) -> Vec<String> {
    let each = all.iter().filter_map(|log| {
        let channels = log.block.channels.iter().zip(actuators);
        let empty: Vec<&str> =
            channels.filter(|(rows, _)| rows.is_empty()).map(|(_, name)| name.as_str()).collect();
        (!empty.is_empty()).then(|| {
            format!(
                "{}: no row of {} is left, so the log says nothing about it",
                log.name,
                empty.join(", ")
            )
        })
    });
    each.collect()
}

/// Returns the scales to which the residuals of each effort are compared: the standard deviation of
/// the measured effort, and the standard deviation of the measured effort minus the effort of the
/// model without friction, N or N m.
fn references(all: &[Prepared]) -> Vec<[f64; 2]> {
    let deviation = |values: Vec<f64>| {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let sum: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
        (sum / values.len().max(1) as f64).sqrt()
    };
    let channels = all.first().map_or(0, |log| log.block.channels.len());
    let each = (0..channels).map(|channel| {
        let fits = || all.iter().filter(|log| !log.predict);
        let measured = fits().flat_map(|log| log.block.channels[channel].measured.iter().copied());
        let left = fits().flat_map(|log| {
            let known = &log.known[channel];
            log.block.channels[channel].measured.iter().zip(known).map(|(y, known)| y - known)
        });
        [deviation(measured.collect()), deviation(left.collect())]
    });
    each.collect()
}

/// Returns the parameters of the regression. The factors of effort terms have the names that the
/// options define.
pub(super) fn parameters_of(prepared: &Prepared, settings: &IdentifySettings) -> Vec<Parameter> {
    let mut parameters: Vec<Parameter> = prepared.regressor.parameters().to_vec();
    for (index, (name, _)) in settings.terms.iter().enumerate() {
        parameters
            .iter_mut()
            .filter(|p| p.kind == Kind::Term(index))
            .for_each(|p| p.name.clone_from(name));
    }
    parameters
}

pub(super) fn read_terms(
    model: &ModelFile,
    settings: &IdentifySettings,
) -> Result<Vec<Drives>, IdentifyError> {
    let each = settings.terms.iter().map(|(name, text)| {
        let source = Source::new(format!("terms.{name}"), text.as_str());
        model.parse_drives(&source, &|_| Err("files cannot be read here".to_owned())).map_err(
            |out| {
                refuse(
                    format!("options: the term `{name}` is not understood:\n{out}"),
                    "write `JOINT = FORMULA`",
                )
            },
        )
    });
    each.collect()
}

/// Converts parameter values to the unknowns of the regression, in which inertial parameters are
/// differences from the model.
pub(super) fn differences(parameters: &[Parameter], values: &[f64]) -> DVector<f64> {
    let each = parameters
        .iter()
        .zip(values)
        .map(|(p, v)| if p.body().is_some() { v - p.prior } else { *v });
    DVector::from_iterator(values.len(), each)
}

/// Returns the root mean square of the residuals of each effort, and its percentage of the root
/// mean square of the measured effort. The percentage is `None` if the measured effort is zero or
/// has no rows.
fn errors(block: &Block, at: &DVector<f64>) -> (Vec<f64>, Vec<Option<f64>>) {
    let each = block.channels.iter().map(|rows| {
        let (error, size) = (rows.residuals(at).norm(), rows.measured.norm());
        let percent = (size > 0.0).then(|| 100.0 * error / size);
        (error / (rows.len().max(1) as f64).sqrt(), percent)
    });
    each.unzip()
}

/// Returns the standard deviation of the noise in each filtered effort, N or N m, averaged over the
/// fitted logs; `None` if no fitted log is filtered.
fn effort_noise(all: &[Prepared]) -> Option<Vec<f64>> {
    let fits: Vec<&Vec<f64>> =
        all.iter().filter(|log| !log.predict).filter_map(|log| log.effort_noise.as_ref()).collect();
    let count = fits.len() as f64;
    let channels = fits.first()?.len();
    Some((0..channels).map(|c| fits.iter().map(|noise| noise[c]).sum::<f64>() / count).collect())
}
