//! Plan of the logs to record: payloads, chosen parameters, noise, and suggestions of further
//! payloads that would separate friction parameters.

use super::objective::{Objective, Sweep};
use super::precision::{Confounded, pairs};
use super::structure::structure;
use super::{ExciteError, ExciteSettings};
use crate::names::{Names, listed};
use nalgebra::DVector;
use stiction_core::mechanism::Mechanism;
use stiction_format::{ModelFile, did_you_mean, fits};
use stiction_identify::Parameter;

/// Standard deviation of a measured effort if the option `noise` is not set, as a fraction of the
/// root mean square of the effort.
const NOISE: f64 = 0.02;

/// Returns the mechanism with each payload of the plan. A plan without payloads yields the
/// mechanism alone.
pub(super) fn loaded(
    model: &ModelFile,
    settings: &ExciteSettings,
) -> Result<Vec<Mechanism>, ExciteError> {
    if settings.payloads.is_empty() {
        return Ok(vec![model.mechanism.clone()]);
    }
    let each = settings.payloads.iter().enumerate().map(|(k, name)| {
        if settings.payloads[..k].contains(name) {
            return Err(ExciteError::input(
                format!("the load `{name}` is named twice"),
                "give each load once; for longer logs, increase --duration",
            ));
        }
        let load = match model.load(name) {
            Some(load) => load,
            None if name == "none" => return Ok(model.mechanism.clone()),
            None => return Err(unknown_load(model, name)),
        };
        if !load.wrenches.is_empty() || !load.laws.is_empty() {
            return Err(ExciteError::input(
                format!("the load `{name}` has forces"),
                "give a load that consists only of payloads, whose forces follow from the motion",
            ));
        }
        Ok(carrying(&model.mechanism, &load.payloads))
    });
    each.collect()
}

pub(super) fn unknown_load(model: &ModelFile, name: &str) -> ExciteError {
    let names: Vec<&str> =
        model.loads.iter().map(|(name, _)| name.as_str()).chain(["none"]).collect();
    let near = did_you_mean(name, "loads", names.iter().copied());
    ExciteError::input(
        format!("the model has no load `{name}`"),
        near.unwrap_or_else(|| format!("the loads are {}", listed(&names, 8))),
    )
}

pub(super) fn carrying(mechanism: &Mechanism, payloads: &[stiction_format::Payload]) -> Mechanism {
    payloads.iter().fold(mechanism.clone(), |carrier, payload| {
        carrier.with_payload(payload.body, &payload.part)
    })
}

/// Returns the indices of the parameters that the options choose.
pub(super) fn columns(
    parameters: &[Parameter],
    settings: &ExciteSettings,
) -> Result<Vec<usize>, ExciteError> {
    for pattern in &settings.parameters {
        if !parameters.iter().any(|p| fits(pattern, &p.name)) {
            let names = || parameters.iter().map(|p| p.name.as_str());
            let near = did_you_mean(pattern, "parameters", names());
            return Err(ExciteError::input(
                format!("no parameter matches `{pattern}` of --parameters"),
                near.unwrap_or_else(|| format!("choose from {}", listed(names(), 8))),
            ));
        }
    }
    let is_wanted = |p: &Parameter| {
        settings.parameters.is_empty() || settings.parameters.iter().any(|own| fits(own, &p.name))
    };
    Ok((0..parameters.len()).filter(|&k| is_wanted(&parameters[k])).collect())
}

/// Returns the standard deviation of the measurement noise of each actuator effort, N or N m.
pub(super) fn noise_of(
    names: &Names,
    settings: &ExciteSettings,
    sweep: &Sweep,
) -> Result<Vec<f64>, ExciteError> {
    let largest = sweep.rms.iter().copied().fold(0.0, f64::max);
    let each = names.drives.iter().zip(&sweep.rms).map(|((name, unit), rms)| {
        if settings.noise.is_empty() {
            // An actuator without effort gets a small positive noise, which follows from the
            // largest effort.
            return Ok(NOISE * rms.max(1e-3 * largest).max(1e-12));
        }
        let found = settings.noise.iter().find_map(|amount| match amount.unit.as_str() {
            "" => Some(amount.number),
            _ => amount.to_unit(unit).ok(),
        });
        found.filter(|sigma| *sigma > 0.0).ok_or_else(|| {
            ExciteError::input(
                format!("--noise gives no positive standard deviation in {unit} for the effort of {name}"),
                "repeat --noise for efforts in N and in N m, as in --noise \"2 N\" --noise \"0.1 N m\"",
            )
        })
    });
    each.collect()
}

/// Sets the scale of each friction parameter whose value in the model is zero. A parameter whose
/// value equals this scale would explain a tenth of the efforts.
pub(super) fn scale_unknown(objective: &mut Objective, sweep: &Sweep) {
    let efforts: f64 = sweep.rms.iter().map(|rms| rms * rms).sum();
    let samples = objective.grid.len() as f64;
    let parameters = objective.probe().parameters().to_vec();
    for (row, (k, scale)) in objective.columns.iter_mut().enumerate() {
        let p = &parameters[*k];
        let column = sweep.information[(row, row)] / samples;
        if p.prior == 0.0 && p.body().is_none() && column > 0.0 && efforts > 0.0 {
            *scale *= 0.1 * (efforts / column).sqrt();
        }
    }
}

/// Tries every payload of the model that is not in the plan. For each pair of confounded
/// parameters, records the payload that separates the two parameters best.
pub(super) fn suggest_payloads(
    model: &ModelFile,
    settings: &ExciteSettings,
    (objective, x, parameters): (&Objective, &DVector<f64>, &[Parameter]),
    loaded: &[Mechanism],
    confounded: &mut [Confounded],
) {
    for (name, load) in &model.loads {
        let is_payload =
            load.wrenches.is_empty() && load.laws.is_empty() && !load.payloads.is_empty();
        if !is_payload || settings.payloads.contains(name) {
            continue;
        }
        let more: Vec<Mechanism> =
            loaded.iter().cloned().chain([carrying(&model.mechanism, &load.payloads)]).collect();
        let Some(mut extended) = objective.with_payloads(&more) else { continue };
        let base = structure(&mut extended, x, parameters, settings.seed);
        let Some(sweep) = extended.sweep(x) else { continue };
        for (pair, other) in confounded.iter_mut().zip(pairs(&sweep.information, &base, parameters))
        {
            let best = pair.with.as_ref().map_or(1.0, |(_, known)| known.abs());
            if other.correlation.abs() < best {
                pair.with = Some((name.clone(), other.correlation));
            }
        }
    }
}
