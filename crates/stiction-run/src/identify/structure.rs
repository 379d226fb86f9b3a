//! Structure of the regression: the linear combinations of parameters on which the efforts depend.

use super::identified::Combined;
use super::prepare::{Prepared, write_terms};
use super::run::differences;
use super::torque_constants;
use nalgebra::DMatrix;
use stiction_core::kinematics::Target;
use stiction_core::random::Random;
use stiction_format::Drives;
use stiction_identify::{BaseParameters, Estimate, Evidence, Kind, Parameter, Verdict};

/// Approximate number of instants, in all fitted logs together, at which the structure of the
/// regression is computed. The positions are logged, the rates and accelerations are random.
const STRUCTURE_SAMPLES: usize = 240;

/// Linear combinations of parameters that the efforts determine, computed at logged positions with
/// random rates and accelerations.
pub(super) struct Structure {
    /// Combinations of all parameters, including those that are fixed.
    pub(super) all: BaseParameters,
    /// Combinations of the parameters that are not fixed.
    pub(super) free: BaseParameters,
}

impl Structure {
    /// Returns `false` if the efforts do not depend on a parameter. All parameters count as effective
    /// if no reactions can be computed for the random motions.
    pub(super) fn has_effect(&self, k: usize) -> bool {
        let without_effect = &self.free.without_effect;
        self.free.combinations.is_empty() || !without_effect.contains(&k)
    }
}

/// Computes the linear combinations of parameters that the efforts of the mechanism determine.
/// `held` is true for each fixed parameter; `terms` are the effort terms of the options.
pub(super) fn structure(
    all: &[Prepared],
    terms: &[Drives],
    parameters: &[Parameter],
    held: &[bool],
) -> Structure {
    let priors: Vec<f64> = parameters.iter().map(|p| p.prior).collect();
    let mut at = differences(parameters, &priors);
    for (value, p) in at.iter_mut().zip(parameters) {
        if matches!(p.kind, Kind::StaticExcess(_)) {
            // The columns of sliding friction contain the excess.
            *value = 0.0;
        }
    }
    let has_excess = parameters.iter().any(|p| matches!(p.kind, Kind::StaticExcess(_)));
    let mut random = Random::new(1);
    let mut rows: Vec<nalgebra::RowDVector<f64>> = Vec::new();
    // Logs that only check the prediction, and the payloads in these logs, determine no parameters.
    let fits = || all.iter().filter(|log| !log.predict);
    let per_log = STRUCTURE_SAMPLES.div_ceil(fits().count().max(1));
    for log in fits() {
        let constants: Vec<Option<usize>> =
            log.constants().map(|own| own.map(|(parameter, _)| parameter)).collect();
        let mut regressor = log.regressor.clone();
        let mut engine = regressor.engine_data();
        let nominal = regressor.engine_parameters(&priors);
        let size = |pick: fn(&[Vec<f64>; 3]) -> &Vec<f64>| {
            let all = log.instants.iter().flat_map(|(_, motion)| pick(motion));
            all.fold(1e-6, |max: f64, x| max.max(x.abs()))
        };
        let (fastest, most) = (size(|m| &m[1]), size(|m| &m[2]));
        let stride = (log.instants.len() / per_log).max(1);
        for (time, [q, ..]) in log.instants.iter().step_by(stride) {
            // Static friction has an effect at low speed only, so the rates then cover four orders of magnitude.
            let slowed = if has_excess { 10_f64.powf(2.0 * random.number() - 2.0) } else { 1.0 };
            let v: Vec<f64> = q.iter().map(|_| slowed * fastest * random.number()).collect();
            let a: Vec<f64> = q.iter().map(|_| most * random.number()).collect();
            let Ok(mut columns) = regressor.at(q, &v, &a) else { continue };
            let Ok(solved) = regressor.loads(&nominal, &mut engine, [q, &v, &a]) else { continue };
            let motion = q.iter().zip(&v).zip(&a);
            let targets: Vec<Target<f64>> = motion
                .map(|((&value, &rate), &acceleration)| Target { value, rate, acceleration })
                .collect();
            let coordinates = regressor.model().constraints().coordinates();
            write_terms(terms, *time, (coordinates, &targets), parameters, &mut columns.matrix);
            if columns.matrix.iter().any(|x| !x.is_finite()) {
                // A formula may have no value at rates that the log does not contain.
                continue;
            }
            for channel in 0..columns.matrix.nrows() {
                let mut row = columns.matrix.row(channel).into_owned();
                for (k, p) in parameters.iter().enumerate() {
                    match p.kind {
                        Kind::Mu(i) => row[k] *= solved.loads[i],
                        Kind::StaticExcess(i) => {
                            let interface = &nominal.interfaces[i];
                            row[k] *= interface.law.mu * (solved.loads[i] + interface.load.preload);
                        }
                        _ => {}
                    }
                }
                let unknown = (columns.known[channel], constants[channel]);
                torque_constants::complete(&mut row, unknown, (parameters, &at));
                rows.push(row);
            }
        }
    }
    let whole = match rows.is_empty() {
        true => DMatrix::zeros(0, parameters.len()),
        false => DMatrix::from_rows(&rows),
    };
    let mut free = whole.clone();
    for (k, held) in held.iter().enumerate() {
        if *held {
            free.column_mut(k).fill(0.0);
        }
    }
    Structure {
        all: BaseParameters::of(&whole, parameters),
        free: BaseParameters::of(&free, parameters),
    }
}

/// Computes the value, the standard deviation and the verdict of each combination that contains
/// more than one parameter.
pub(super) fn combinations(
    structure: &BaseParameters,
    parameters: &[Parameter],
    estimate: &Estimate,
) -> Vec<Combined> {
    let each = structure.shared().map(|c| {
        let members: Vec<(usize, f64)> =
            std::iter::once((c.leader, 1.0)).chain(c.others.iter().copied()).collect();
        let (variance, resolution, pull) = estimate.combined(&members);
        let size: f64 = members.iter().map(|(i, a)| (a * parameters[*i].scale).powi(2)).sum();
        let (value, sigma) = (c.value(&estimate.values), variance.sqrt());
        let verdict = Verdict::of(&Evidence {
            resolution,
            value,
            sigma,
            scale: size.sqrt(),
            is_alone: true,
            has_effect: true,
            pull,
            correlation: 0.0,
        });
        let leader = &parameters[c.leader];
        let (name, unit) = (c.words(parameters, 8), leader.unit);
        Combined { name, value, sigma, unit, verdict, filter_bias: 0.0 }
    });
    each.collect()
}
