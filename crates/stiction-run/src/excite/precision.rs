//! Expected precision of parameters that are identified from logs of a motion, and pairs of
//! parameters that these logs confound.
//!
//! The theory is in equation (X4) of the book.

use super::objective::leading;
use nalgebra::DMatrix;
use std::iter::once;
use stiction_identify::{BaseParameters, Kind, Parameter};

/// Correlation of the errors of two parameters above which the parameters count as confounded.
/// Identification uses the same limit.
const CONFOUNDED: f64 = 0.95;
/// Error of parameters that logs do not determine by themselves, in units of their scales: the
/// relative error of inertias that identification expects of a model.
const MODEL_ERROR: f64 = 0.3;

/// Parameter or linear combination of parameters, with its expected standard deviation.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Name of the parameter, or the combination in words.
    pub name: String,
    /// True for a single parameter, false for a combination.
    pub alone: bool,
    /// Value of the parameter or combination in the model, SI units.
    pub value: f64,
    /// Expected standard deviation of the parameter or combination, SI units.
    pub sigma: f64,
    /// SI unit of the parameter or combination.
    pub unit: &'static str,
}

/// Two friction parameters of one bearing that logs with a single payload may confound: the
/// coefficient of friction and the load-independent friction.
#[derive(Clone, Debug, PartialEq)]
pub struct Confounded {
    /// Name of the parameter for the coefficient of friction.
    pub mu: String,
    /// Name of the parameter for the load-independent friction.
    pub coulomb: String,
    /// Correlation of the errors of the two parameters; -1 if only a combination of them is
    /// determined.
    pub correlation: f64,
    /// Load of the model that is not in the plan and separates the two parameters best. The number
    /// is the correlation of their errors if the motion is repeated with this load.
    pub with: Option<(String, f64)>,
}

impl Confounded {
    /// Returns true if the planned logs confound the two parameters.
    pub fn needs_payload(&self) -> bool {
        self.correlation.abs() > CONFOUNDED
    }

    /// Returns true if repeating the motion with the suggested payload separates the two
    /// parameters.
    pub fn is_cured(&self) -> bool {
        self.with.as_ref().is_some_and(|(_, correlation)| correlation.abs() <= CONFOUNDED)
    }
}

/// Returns the covariance matrix of all parameters in units of their scales. `samples` is the number
/// of log samples per sample in the information matrix. `None` if the information matrix of the
/// base parameters is singular.
///
/// Inertias on which the efforts depend only through the normal loads, or only in combination with a
/// leading parameter, have the uncertainty of the model, so that the standard deviations of
/// friction contain theirs.
fn covariance(information: &DMatrix<f64>, leaders: &[usize], samples: f64) -> Option<DMatrix<f64>> {
    leading(information, leaders).cholesky()?;
    let mut all = information * samples;
    for k in (0..all.nrows()).filter(|k| !leaders.contains(k)) {
        all[(k, k)] += MODEL_ERROR.powi(-2);
    }
    Some(all.cholesky()?.inverse())
}

/// Returns the expected standard deviations of all base parameters. `None` if the information
/// matrix is singular.
pub(super) fn expected(
    information: &DMatrix<f64>,
    base: &BaseParameters,
    parameters: &[Parameter],
    samples: f64,
) -> Option<Vec<Expected>> {
    let leaders: Vec<usize> = base.combinations.iter().map(|c| c.leader).collect();
    let covariance = covariance(information, &leaders, samples)?;
    let priors: Vec<f64> = parameters.iter().map(|p| p.prior).collect();
    let mut all: Vec<(usize, Expected)> = base
        .combinations
        .iter()
        .map(|combination| {
            let leader = &parameters[combination.leader];
            let others = combination.others.iter().copied();
            let own: Vec<(usize, f64)> = once((combination.leader, 1.0))
                .chain(others)
                .map(|(k, factor)| (k, factor * parameters[k].scale))
                .collect();
            let products = own.iter().flat_map(|(i, a)| {
                let covariance = &covariance;
                own.iter().map(move |(k, b)| a * b * covariance[(*i, *k)])
            });
            let expected = Expected {
                name: combination.words(parameters, 8),
                alone: combination.others.is_empty(),
                value: combination.value(&priors),
                sigma: products.sum::<f64>().sqrt(),
                unit: leader.unit,
            };
            (combination.leader, expected)
        })
        .collect();
    // The result is sorted by the order of the parameter catalogue.
    all.sort_by_key(|(leader, _)| *leader);
    Some(all.into_iter().map(|(_, expected)| expected).collect())
}

/// Returns, for each bearing, the correlation between the errors of its two friction parameters:
/// the coefficient of friction and the load-independent friction.
pub(super) fn pairs(
    information: &DMatrix<f64>,
    base: &BaseParameters,
    parameters: &[Parameter],
) -> Vec<Confounded> {
    let leaders: Vec<usize> = base.combinations.iter().map(|c| c.leader).collect();
    let covariance = covariance(information, &leaders, 1.0);
    let is_leader = |k: usize| base.is_alone(k) && leaders.contains(&k);
    let mut all = Vec::new();
    for (k, mu) in parameters.iter().enumerate() {
        let Kind::Mu(interface) = mu.kind else { continue };
        let other = parameters.iter().position(|p| p.kind == Kind::Coulomb(interface));
        let Some(other) = other else { continue };
        let correlation = match &covariance {
            Some(c) if is_leader(k) && is_leader(other) => {
                c[(k, other)] / (c[(k, k)] * c[(other, other)]).sqrt()
            }
            _ => -1.0,
        };
        all.push(Confounded {
            mu: mu.name.clone(),
            coulomb: parameters[other].name.clone(),
            correlation,
            with: None,
        });
    }
    all
}

/// Returns the condition number of the weighted base regressor: the square root of the ratio
/// between the largest and the smallest eigenvalue of the information matrix of the base
/// parameters.
pub(super) fn condition(information: &DMatrix<f64>, leaders: &[usize]) -> f64 {
    let values = leading(information, leaders).symmetric_eigenvalues();
    (values.max() / values.min().max(0.0)).sqrt()
}
