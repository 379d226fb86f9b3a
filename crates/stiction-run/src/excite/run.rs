//! Design of a motion: random motions within the limits, their improvement by a search, and the
//! final check between the samples of the search.

use super::ascent::{Point, search};
use super::coordinates::choose;
use super::feasible::{held_between, random_start, refuse_at_rest, resumed};
use super::limits::Limits;
use super::objective::{Grid, Objective, Sweep};
use super::plan::{columns, loaded, noise_of, scale_unknown, suggest_payloads};
use super::precision::{Confounded, condition, expected, pairs};
use super::probe::{Index, Probe};
use super::reference::{Sampled, actuators};
use super::result::{Excitation, Quality};
use super::series::Series;
use super::structure::structure;
use super::{ExciteError, ExciteSettings};
use crate::names::{Names, listed};
use stiction_core::random::Random;
use stiction_format::ModelFile;
use stiction_identify::{Choice, Kind, Parameter, Regressor};

/// Number of instants at which the search evaluates the robot, per period of the highest harmonic.
const PER_PERIOD: usize = 16;
/// Number of instants at which the singularity index is evaluated, per period of the highest
/// harmonic, if its evaluation is slow.
const INDICES: usize = 4;
/// Factor by which the time grid of the final check is finer than that of the search.
const FINER: usize = 10;
/// Number of random motions among which the search chooses its start.
const STARTS: usize = 5;
/// Weights of the barrier, divided by the number of base parameters; the search is repeated with
/// each weight in turn.
const BARRIER: [f64; 3] = [0.3, 0.03, 0.003];

/// Designs a motion that excites the chosen parameters. `progress` receives the number of completed
/// search steps and the largest number of search steps; if it returns false, the search stops.
///
/// # Errors
/// Returns [`ExciteError`] for options that do not suit the model, a limit that no motion
/// satisfies, or parameters without effect, and if `progress` stops the search.
pub fn excite(
    model: &ModelFile,
    settings: &ExciteSettings,
    mut progress: impl FnMut(usize, usize) -> bool,
) -> Result<Excitation, ExciteError> {
    let (frequency, periods) = settings.periods()?;
    let step = settings.sample_step(frequency)?;
    if !(0.0..1.0).contains(&settings.margin) {
        return Err(ExciteError::input(
            format!("--singularity-margin is {}", settings.margin),
            "give a fraction of the singularity index at the first position, from 0 to less than 1",
        ));
    }
    let chosen = choose(model, settings)?;
    let loaded = loaded(model, settings)?;
    let choice = Choice { at_motors: settings.at_motors, ..Choice::ALL };
    let index = Index::new(&chosen.solver);
    let mut limits = Limits::new(&model.mechanism, &chosen, settings, loaded.len())?;
    let home =
        index.clone().at(&model.mechanism, chosen.solver.parameters(), chosen.solver.bodies());
    limits.keep_from_singular(settings.margin * home);
    let regressor = Regressor::new(chosen.solver.clone(), &choice).map_err(|unsuitable| {
        ExciteError::input(
            unsuitable.to_string(),
            "robots with redundant actuation cannot be identified yet; give --actuators if the \
             motion prescribes other coordinates",
        )
    })?;
    let wanted = columns(regressor.parameters(), settings)?;
    let length = model.mechanism.characteristic_length();
    let reach: Vec<f64> =
        (0..chosen.names.len()).map(|k| limits.reach(&chosen, k, length)).collect();
    let series = Series::new(frequency, settings.harmonics);
    let period = 1.0 / frequency;
    let coarse = PER_PERIOD * settings.harmonics;
    let stride = if index.is_fast() { 1 } else { PER_PERIOD / INDICES };
    let grid = Grid::new(&series, period, (coarse, stride), &chosen.centre, &reach);
    let mut probe = Probe::new(regressor, &loaded, limits, index);
    refuse_at_rest(&mut probe, &chosen)?;
    let mut objective = Objective::new(probe, grid);
    objective.columns.retain(|(k, _)| wanted.contains(k));

    let mut random = Random::new(settings.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5eed);
    let start = random_start(&mut objective, &mut random, series.free(), &chosen)?;
    let names = Names::new(&model.mechanism);
    let noise = noise_of(&names, settings, &start.sweep)?;
    scale_unknown(&mut objective, &start.sweep);
    objective.weights = noise.iter().map(|sigma| 1.0 / sigma).collect();
    let parameters: Vec<Parameter> = objective
        .columns
        .iter()
        .map(|&(k, scale)| Parameter { scale, ..objective.probe().parameters()[k].clone() })
        .collect();
    let base = structure(&mut objective, &start.x, &parameters, settings.seed);
    if base.rank() == 0 {
        return Err(ExciteError::input(
            "none of the chosen parameters acts on the efforts",
            format!(
                "choose other parameters than {}",
                listed(parameters.iter().map(|p| &p.name), 5)
            ),
        ));
    }
    objective.leaders = base.combinations.iter().map(|c| c.leader).collect();
    let quality = |objective: &Objective, sweep: &Sweep| Quality {
        log_det: objective.log_det(sweep).unwrap_or(f64::NEG_INFINITY),
        condition: condition(&sweep.information, &objective.leaders),
    };
    let begun = resumed(&mut objective, &start.x)?;
    let first = quality(&objective, &begun.sweep);
    if !first.log_det.is_finite() {
        return Err(ExciteError::no_answer(
            "the random motion does not excite all chosen parameters",
            "choose fewer parameters with --parameters, more harmonics, or another --seed",
        ));
    }

    let mut done = 0;
    let mut is_stopped = false;
    let mut go_on = || {
        is_stopped |= !progress(done, settings.iterations);
        done += usize::from(!is_stopped);
        !is_stopped
    };
    // Short searches compare several random motions; longer searches continue from the best of
    // their results.
    let each = settings.iterations.div_ceil(BARRIER.len());
    let weight = |k: usize| BARRIER[k] * base.rank() as f64;
    let mut now = Point { x: begun.x.clone(), sweep: begun.sweep.clone() };
    for k in 0..STARTS {
        let from = match k {
            0 => Point { x: now.x.clone(), sweep: now.sweep.clone() },
            _ => random_start(&mut objective, &mut random, series.free(), &chosen)?,
        };
        let steps = each / STARTS;
        let found = search(&mut objective, from, weight(0), steps, &mut random, &mut go_on);
        if objective.log_det(&found.sweep) > objective.log_det(&now.sweep) {
            now = found;
        }
    }
    for k in 1..BARRIER.len() {
        now = search(&mut objective, now, weight(k), each, &mut random, &mut go_on);
    }
    if is_stopped {
        return Err(ExciteError::interrupted());
    }
    if objective.log_det(&now.sweep).unwrap_or(f64::NEG_INFINITY) < first.log_det {
        now = begun;
    }

    let fine = Grid::new(&series, period, (FINER * coarse, 1), &chosen.centre, &reach);
    let (x, sweep) = held_between(&mut objective, &fine, now.x)?;
    let coarse_sweep = resumed(&mut objective, &x)?.sweep;
    let per_sample = settings.duration / step / fine.len() as f64;
    let information = &objective
        .sweep_through_loads(&fine, &x)
        .ok_or_else(|| {
            ExciteError::no_answer("the robot cannot follow the motion", "try another --seed")
        })?
        .information;
    let expected = expected(information, &base, &parameters, per_sample).ok_or_else(|| {
        ExciteError::no_answer("the information matrix is singular", "choose fewer parameters")
    })?;
    let mut confounded = pairs(&sweep.information, &base, &parameters);
    if confounded.iter().any(Confounded::needs_payload) {
        suggest_payloads(model, settings, (&objective, &x, &parameters), &loaded, &mut confounded);
    }
    let size = series.free();
    let coefficients = (0..chosen.names.len()).map(|i| {
        let own: Vec<f64> = x.rows(i * size, size).iter().map(|free| reach[i] * free).collect();
        series.coefficients(&own)
    });
    let count = (settings.duration / step).round() as usize;
    let per_period = Sampled { series: &series, x: &x, grid: &fine };
    let held: Vec<String> = objective
        .probe()
        .parameters()
        .iter()
        .enumerate()
        .filter(|(k, _)| !wanted.contains(k))
        .map(|(_, p)| p.name.clone())
        .collect();
    let holds_inertia = parameters.iter().all(|p| p.body().is_none());
    let mut cautions = Vec::new();
    if !objective.probe().limits.has_dynamic() {
        cautions.push(
            "no speed, acceleration or effort is limited: only the travel and the harmonics bound the motion; give \
             --limit, or `limits` of the [actuators] in the model"
                .to_owned(),
        );
    }
    let reference: Vec<(f64, [Vec<f64>; 3])> =
        (0..=count).map(|k| per_period.at(k as f64 * step, period)).collect();
    let inertias = objective.probe().parameters().iter();
    let inertias = inertias.filter(|p| p.body().is_some() || matches!(p.kind, Kind::Rotor(_)));
    Ok(Excitation {
        inertias: inertias.map(|p| p.name.clone()).collect(),
        actuators: actuators(&mut objective, &chosen, &reference)?,
        coordinates: (0..chosen.names.len())
            .map(|k| (chosen.names[k].clone(), chosen.unit(k)))
            .collect(),
        centre: chosen.centre.clone(),
        coefficients: coefficients.collect(),
        frequency,
        periods,
        duration: settings.duration,
        step,
        seed: settings.seed,
        payloads: settings.payloads.clone(),
        start: first,
        quality: quality(&objective, &coarse_sweep),
        steps: done,
        limits: objective.used(&sweep).into_iter().filter(|used| used.bound > 0.0).collect(),
        noise: names.drives.iter().zip(&noise).map(|((n, u), s)| (n.clone(), *s, *u)).collect(),
        is_noise_assumed: settings.noise.is_empty(),
        expected,
        without_effect: base.without_effect.iter().map(|&k| parameters[k].name.clone()).collect(),
        pairs: confounded,
        cautions,
        held,
        holds_inertia,
        at_motors: settings.at_motors,
        reference,
    })
}
