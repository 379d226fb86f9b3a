//! The design: a random motion within the limits, its improvement, the check between the samples.

use super::ascent::{Point, search};
use super::coordinates::{Chosen, choose};
use super::limits::{Limits, Used};
use super::objective::{Grid, Objective, Sweep};
use super::precision::{Confounded, Expected, condition, expected, pairs};
use super::probe::{Index, Probe};
use super::series::Series;
use super::{ExciteError, ExciteSettings};
use crate::identify::fits;
use crate::names::{Names, listed};
use nalgebra::{DMatrix, DVector, RowDVector};
use std::f64::consts::TAU;
use stiction_core::kinematics::Coordinate;
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_core::random::Random;
use stiction_format::{ModelFile, did_you_mean};
use stiction_identify::{BaseParameters, Choice, Kind, Parameter, Regressor};

/// Instants per period of the highest harmonic during the search.
const PER_PERIOD: usize = 16;
/// Evaluations of the singularity index among them where it takes long.
const INDICES: usize = 4;
/// Refinement of this grid for the last check.
const FINER: usize = 10;
/// Part of the greatest possible size at which the random motion starts, inside all limits.
const START: f64 = 0.95;
/// Least size of a random motion, as part of the reach of the coordinates.
const LEAST: f64 = 1e-3;
/// Random motions that the search begins with.
const STARTS: usize = 5;
/// Weights of the barrier, one after the other, per leading parameter.
const BARRIER: [f64; 3] = [0.3, 0.03, 0.003];
/// Shrinkage of a motion that leaves a limit between the samples of the search, and the most often that happens.
const SHRINK: f64 = 0.99;
const SHRINKS: usize = 100;
/// Standard deviation of efforts without `noise`, as part of their root mean square.
const NOISE: f64 = 0.02;

/// Quality of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Natural logarithm of the determinant of the information matrix of the base parameters, in units of their
    /// sizes in the model.
    pub log_det: f64,
    /// Condition number of the weighted base regressor in these units.
    pub condition: f64,
}

/// Designed motion with its limits and the precision that its logs promise.
#[derive(Clone, Debug)]
pub struct Excitation {
    /// Names of the coordinates, with their units.
    pub coordinates: Vec<(String, &'static str)>,
    /// Position at which every period begins and ends at rest, rad or m.
    pub centre: Vec<f64>,
    /// Coefficients of sines and cosines of each coordinate, the first harmonic first.
    pub coefficients: Vec<[Vec<f64>; 2]>,
    /// Frequency of the first harmonic, Hz.
    pub frequency: f64,
    /// Number of periods.
    pub periods: usize,
    /// Duration, s.
    pub duration: f64,
    /// Time between samples, s.
    pub step: f64,
    /// Seed of the random start.
    pub seed: u64,
    /// Names of the loads with which the motion is repeated; empty for the robot alone.
    pub payloads: Vec<String>,
    /// Quality of the random start.
    pub start: Quality,
    /// Quality of the result.
    pub quality: Quality,
    /// Steps of the search.
    pub steps: usize,
    /// Parts of all limits that the motion uses, on the fine grid.
    pub limits: Vec<Used>,
    /// Standard deviation of the measured effort of each actuator: name, value, unit.
    pub noise: Vec<(String, f64, &'static str)>,
    /// True if the noise is an assumption.
    pub is_noise_assumed: bool,
    /// Expected standard deviations.
    pub expected: Vec<Expected>,
    /// Chosen parameters without effect on the efforts.
    pub without_effect: Vec<String>,
    /// Pairs of friction parameters of one bearing.
    pub pairs: Vec<Confounded>,
    /// Things to know before the motion is used.
    pub cautions: Vec<String>,
    /// Names of all other parameters, which identification shall hold.
    pub held: Vec<String>,
    /// True if all inertial parameters are among them.
    pub holds_inertia: bool,
    /// Names of all inertial parameters.
    pub(super) inertias: Vec<String>,
    /// True if efforts are measured at the motors.
    pub at_motors: bool,
    /// Reference: times, s, then positions, rates and accelerations of all coordinates.
    pub reference: Vec<(f64, [Vec<f64>; 3])>,
    /// The same of the actuators, with their names and units; `None` if these are the coordinates.
    pub actuators: Option<(Vec<(String, &'static str)>, Vec<[Vec<f64>; 3]>)>,
}

/// Designs a motion. `progress` receives the steps done and their greatest number, and stops the search by
/// returning `false`.
///
/// # Errors
/// Options that do not suit the model, a limit that no motion keeps, or parameters without effect.
pub fn excite(
    model: &ModelFile,
    settings: &ExciteSettings,
    mut progress: impl FnMut(usize, usize) -> bool,
) -> Result<Excitation, ExciteError> {
    let (frequency, periods) = settings.periods()?;
    let step = settings.sample_step(frequency)?;
    if !(0.0..1.0).contains(&settings.margin) {
        return Err(ExciteError::input(
            format!("the margin from singular positions is {}", settings.margin),
            "give --singularity-margin from 0 to less than 1, a part of the index at the first position",
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
    let regressor = Regressor::new(chosen.solver.clone(), choice).map_err(|unsuitable| {
        ExciteError::input(
            unsuitable.to_string(),
            "redundant actuation is not identified yet; give --actuators if the motion prescribes other coordinates",
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
            format!("choose others than {}", listed(parameters.iter().map(|p| &p.name), 5)),
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
            "the random motion does not excite all chosen parameters to any degree",
            "choose fewer parameters by --parameters, more harmonics, or another --seed",
        ));
    }

    let mut done = 0;
    let mut is_stopped = false;
    let mut go_on = || {
        is_stopped |= !progress(done, settings.iterations);
        done += usize::from(!is_stopped);
        !is_stopped
    };
    // The maxima near several random motions, in short, then the best of them on and on.
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
    let expected =
        expected(&sweep.information, &base, &parameters, per_sample).ok_or_else(|| {
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

/// Motion at any time.
struct Sampled<'a> {
    series: &'a Series,
    x: &'a DVector<f64>,
    grid: &'a Grid,
}

impl Sampled<'_> {
    fn at(&self, time: f64, period: f64) -> (f64, [Vec<f64>; 3]) {
        let turns = time / period;
        if (turns - turns.round()).abs() < 1e-9 {
            // Rest without rounding errors.
            let rest = vec![0.0; self.grid.centre.len()];
            return (time, [self.grid.centre.clone(), rest.clone(), rest]);
        }
        // Phases of the first period, so that all periods have the same numbers up to the time's rounding.
        let phase = time - period * turns.floor();
        let factors = self.series.factors(phase);
        let size = self.series.free();
        let motion = [0, 1, 2].map(|order| {
            let each = (0..self.grid.centre.len()).map(|i| {
                let base = if order == 0 { self.grid.centre[i] } else { 0.0 };
                base + self.grid.reach[i] * factors[order].dot(&self.x.rows(i * size, size))
            });
            each.collect()
        });
        (time, motion)
    }
}

/// The reference in the coordinates of the actuators, angles without jumps.
#[expect(clippy::type_complexity, reason = "names with units, and rows")]
fn actuators(
    objective: &mut Objective,
    chosen: &Chosen,
    reference: &[(f64, [Vec<f64>; 3])],
) -> Result<Option<(Vec<(String, &'static str)>, Vec<[Vec<f64>; 3]>)>, ExciteError> {
    let mechanism = objective.probe().mechanism().clone();
    let driven: Vec<(JointId, usize)> = mechanism.actuators().collect();
    let own = driven.iter().map(|&(joint, dof)| Coordinate::Joint { joint, dof });
    if own.eq(chosen.coordinates.iter().copied()) {
        return Ok(None);
    }
    let names = driven.iter().map(|&(joint, dof)| {
        let content = &mechanism.joints()[joint.0];
        let translates = content.joint_type.dofs()[dof].translates();
        (content.dof_name(dof), if translates { "m" } else { "rad" })
    });
    let mut rows: Vec<[Vec<f64>; 3]> = Vec::with_capacity(reference.len());
    for (_, motion) in reference {
        let found = objective.actuators_at(motion.each_ref().map(Vec::as_slice), &driven);
        let Some(mut row) = found else {
            return Err(ExciteError::no_answer(
                "the robot cannot follow the motion at its samples",
                "give a smaller --step, or another --seed",
            ));
        };
        if let Some(before) = rows.last() {
            for ((value, before), &(joint, dof)) in row[0].iter_mut().zip(&before[0]).zip(&driven) {
                if !mechanism.joints()[joint.0].joint_type.dofs()[dof].translates() {
                    *value += TAU * ((before - *value) / TAU).round();
                }
            }
        }
        rows.push(row);
    }
    Ok(Some((names.collect(), rows)))
}

/// The mechanism with each payload of the plan; without a plan, the mechanism alone.
fn loaded(model: &ModelFile, settings: &ExciteSettings) -> Result<Vec<Mechanism>, ExciteError> {
    if settings.payloads.is_empty() {
        return Ok(vec![model.mechanism.clone()]);
    }
    let each = settings.payloads.iter().enumerate().map(|(k, name)| {
        if settings.payloads[..k].contains(name) {
            return Err(ExciteError::input(
                format!("the load `{name}` is named twice"),
                "name every load once; --duration makes logs longer",
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
                "only payloads are known in every position; name a load with payloads",
            ));
        }
        Ok(carrying(&model.mechanism, &load.payloads))
    });
    each.collect()
}

fn unknown_load(model: &ModelFile, name: &str) -> ExciteError {
    let names: Vec<&str> =
        model.loads.iter().map(|(name, _)| name.as_str()).chain(["none"]).collect();
    let near = did_you_mean(name, "loads", names.iter().copied());
    ExciteError::input(
        format!("the model has no load `{name}`"),
        near.unwrap_or_else(|| format!("the loads are {}", listed(&names, 8))),
    )
}

fn carrying(mechanism: &Mechanism, payloads: &[stiction_format::Payload]) -> Mechanism {
    payloads.iter().fold(mechanism.clone(), |carrier, payload| {
        carrier.with_payload(payload.body, &payload.part)
    })
}

/// Columns of the chosen parameters.
fn columns(parameters: &[Parameter], settings: &ExciteSettings) -> Result<Vec<usize>, ExciteError> {
    for pattern in &settings.parameters {
        if !parameters.iter().any(|p| fits(pattern, &p.name)) {
            let names = || parameters.iter().map(|p| p.name.as_str());
            let near = did_you_mean(pattern, "parameters", names());
            return Err(ExciteError::input(
                format!("--parameters names no parameter: `{pattern}`"),
                near.unwrap_or_else(|| format!("there are {}", listed(names(), 8))),
            ));
        }
    }
    let is_wanted = |p: &Parameter| {
        settings.parameters.is_empty() || settings.parameters.iter().any(|own| fits(own, &p.name))
    };
    Ok((0..parameters.len()).filter(|&k| is_wanted(&parameters[k])).collect())
}

/// Refuses a first position that has no forces, or that leaves a limit at rest.
fn refuse_at_rest(probe: &mut Probe, chosen: &Chosen) -> Result<(), ExciteError> {
    let rest = vec![0.0; chosen.centre.len()];
    let Some(reading) = probe.at([&chosen.centre, &rest, &rest], None) else {
        return Err(ExciteError::no_answer(
            "the robot has no finite forces at rest at the first position",
            "choose another motion by --motion; `stiction check` says what is singular",
        ));
    };
    let greatest: Vec<f64> = reading.parts.iter().map(|part| part.abs()).collect();
    let used = probe.limits.used(&greatest);
    let worst = used.iter().max_by(|a, b| a.part.total_cmp(&b.part));
    match worst {
        Some(worst) if worst.part >= 1.0 => Err(ExciteError::no_answer(
            format!(
                "no motion is feasible: at rest at the first position, {} is at {:.0} % of its limit of {:.4} {}",
                worst.name,
                100.0 * worst.part,
                worst.bound,
                worst.unit
            ),
            "widen the limit, or choose another first position by --motion",
        )),
        _ => Ok(()),
    }
}

/// Random motion, scaled until it nearly reaches a limit.
fn random_start(
    objective: &mut Objective,
    random: &mut Random,
    size: usize,
    chosen: &Chosen,
) -> Result<Point, ExciteError> {
    let count = size * chosen.centre.len();
    let x = DVector::from_fn(count, |_, _| random.number()) / (size as f64).sqrt();
    let feasible = |objective: &mut Objective, factor: f64| -> Option<Sweep> {
        let sweep = objective.sweep(&(&x * factor))?;
        sweep.greatest.iter().all(|part| *part < 1.0).then_some(sweep)
    };
    let mut high = 1.0;
    // Halving finds the order of magnitude, bisection the rest.
    while high >= LEAST && feasible(objective, high).is_none() {
        high *= 0.5;
    }
    if high < LEAST {
        let sweep = objective.sweep(&(&x * high));
        let why = sweep.and_then(|sweep| {
            let used = objective.used(&sweep);
            let worst = used.into_iter().max_by(|a, b| a.part.total_cmp(&b.part))?;
            Some(format!("{} reaches its limit of {:.4} {}", worst.name, worst.bound, worst.unit))
        });
        let why = why.unwrap_or_else(|| "the robot cannot follow".to_owned());
        return Err(ExciteError::no_answer(
            format!("no motion is feasible: even the smallest random motion fails, because {why}"),
            "widen the limits, lower --base-frequency, or choose another first position by --motion",
        ));
    }
    let mut low = high;
    if high < 1.0 {
        high *= 2.0;
        for _ in 0..6 {
            let middle = 0.5 * (low + high);
            match feasible(objective, middle) {
                Some(_) => low = middle,
                None => high = middle,
            }
        }
    }
    resumed(objective, &(&x * (START * low)))
}

/// The sums of a motion that is known to be feasible.
fn resumed(objective: &mut Objective, x: &DVector<f64>) -> Result<Point, ExciteError> {
    let sweep = objective.sweep(x).ok_or_else(|| {
        ExciteError::no_answer(
            "the robot cannot follow the motion",
            "give another --seed or tighter limits",
        )
    })?;
    Ok(Point { x: x.clone(), sweep })
}

/// Standard deviation of each effort.
fn noise_of(
    names: &Names,
    settings: &ExciteSettings,
    sweep: &Sweep,
) -> Result<Vec<f64>, ExciteError> {
    let largest = sweep.rms.iter().copied().fold(0.0, f64::max);
    let each = names.drives.iter().zip(&sweep.rms).map(|((name, unit), rms)| {
        if settings.noise.is_empty() {
            // An idle actuator has the noise of a small part of the others.
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

/// Scales friction without a value in the model by what explains a tenth of the efforts.
fn scale_unknown(objective: &mut Objective, sweep: &Sweep) {
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

/// Combinations that efforts determine near the motion, at random rates.
fn structure(
    objective: &mut Objective,
    x: &DVector<f64>,
    parameters: &[Parameter],
    seed: u64,
) -> BaseParameters {
    let grid = objective.grid.clone();
    let columns = objective.columns.clone();
    let mut random = Random::new(seed ^ 0x57);
    let mut greatest = [0.0_f64; 2];
    for k in 0..grid.len() {
        let [_, v, a] = grid.motion(k, x);
        for (size, values) in greatest.iter_mut().zip([v, a]) {
            *size = values.iter().fold(*size, |max, x| max.max(x.abs()));
        }
    }
    let mut rows: Vec<RowDVector<f64>> = Vec::new();
    // Twice over the grid: enough rows for every parameter of a robot with few actuators.
    for _ in 0..2 {
        let _ = objective.read(&grid, x, |probe, k, reading| {
            let [q, ..] = grid.motion(k, x);
            let mut some = |size: f64| q.iter().map(|_| size * random.number()).collect::<Vec<_>>();
            let (v, a) = (some(greatest[0]), some(greatest[1]));
            let Some(reading) = probe.at([&q, &v, &a], Some(reading.index)) else { return };
            for row in reading.rows.row_iter() {
                rows.push(RowDVector::from_iterator(
                    columns.len(),
                    columns.iter().map(|&(k, _)| row[k]),
                ));
            }
        });
    }
    match rows.is_empty() {
        true => BaseParameters::of(&DMatrix::zeros(0, parameters.len()), parameters),
        false => BaseParameters::of(&DMatrix::from_rows(&rows), parameters),
    }
}

/// Shrinks a motion until all limits hold on a finer grid, too.
fn held_between(
    objective: &mut Objective,
    fine: &Grid,
    mut x: DVector<f64>,
) -> Result<(DVector<f64>, Sweep), ExciteError> {
    for _ in 0..SHRINKS {
        if let Some(sweep) = objective.sweep_on(fine, &x)
            && sweep.greatest.iter().all(|part| *part <= 1.0)
        {
            return Ok((x, sweep));
        }
        x *= SHRINK;
    }
    Err(ExciteError::no_answer(
        "the designed motion leaves its limits between the samples of the search",
        "give another --seed or fewer harmonics",
    ))
}

/// Tries every load of the model that the plan lacks for the pairs that need a payload.
fn suggest_payloads(
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
