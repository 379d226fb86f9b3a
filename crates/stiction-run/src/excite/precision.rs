//! Precision that logs of a motion promise, and parameters that they confound.
//!
//! Equation (X4) of the book's theory.

use super::objective::leading;
use nalgebra::DMatrix;
use stiction_identify::{BaseParameters, Kind, Parameter};

/// Correlation of errors above which two parameters cannot be distinguished, as in identification.
const CONFOUNDED: f64 = 0.95;

/// Parameter, or combination of parameters, with the standard deviation that the logs promise.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Name, or the combination in words.
    pub name: String,
    /// True if it is no combination with others.
    pub alone: bool,
    /// Value in the model.
    pub value: f64,
    /// Expected standard deviation.
    pub sigma: f64,
    /// SI unit.
    pub unit: &'static str,
}

/// Coefficient of friction and load-independent friction of one bearing, which one payload confounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Confounded {
    /// Name of the coefficient of friction.
    pub mu: String,
    /// Name of the load-independent friction.
    pub coulomb: String,
    /// Correlation of their errors; minus one if only a combination of both is determined.
    pub correlation: f64,
    /// A load of the model that the plan lacks, with the correlation when the motion is repeated with it.
    pub with: Option<(String, f64)>,
}

impl Confounded {
    /// True if logs of the plan do not distinguish them.
    pub fn needs_payload(&self) -> bool {
        self.correlation.abs() > CONFOUNDED
    }

    /// True if the motion repeated with a load of the model distinguishes them.
    pub fn is_cured(&self) -> bool {
        self.with.as_ref().is_some_and(|(_, correlation)| correlation.abs() <= CONFOUNDED)
    }
}

/// Covariance of the leading parameters in units of their scales. `samples` is the number of samples of the
/// logs per sample of the information.
fn covariance(information: &DMatrix<f64>, leaders: &[usize], samples: f64) -> Option<DMatrix<f64>> {
    Some(leading(information, leaders).cholesky()?.inverse() / samples)
}

/// Expected standard deviations of all combinations.
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
        .enumerate()
        .map(|(row, combination)| {
            let leader = &parameters[combination.leader];
            let expected = Expected {
                name: combination.words(parameters, 8),
                alone: combination.others.is_empty(),
                value: combination.value(&priors),
                sigma: covariance[(row, row)].sqrt() * leader.scale,
                unit: leader.unit,
            };
            (combination.leader, expected)
        })
        .collect();
    // In the order of the catalogue.
    all.sort_by_key(|(leader, _)| *leader);
    Some(all.into_iter().map(|(_, expected)| expected).collect())
}

/// Correlations of the coefficient of friction with the load-independent friction of each bearing.
pub(super) fn pairs(
    information: &DMatrix<f64>,
    base: &BaseParameters,
    parameters: &[Parameter],
) -> Vec<Confounded> {
    let leaders: Vec<usize> = base.combinations.iter().map(|c| c.leader).collect();
    let covariance = covariance(information, &leaders, 1.0);
    let row = |k: usize| {
        let alone = base.is_alone(k);
        leaders.iter().position(|leader| *leader == k).filter(|_| alone)
    };
    let mut all = Vec::new();
    for (k, mu) in parameters.iter().enumerate() {
        let Kind::Mu(interface) = mu.kind else { continue };
        let other = parameters.iter().position(|p| p.kind == Kind::Coulomb(interface));
        let Some(other) = other else { continue };
        let correlation = match (row(k), row(other), &covariance) {
            (Some(i), Some(k), Some(c)) => c[(i, k)] / (c[(i, i)] * c[(k, k)]).sqrt(),
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

/// Condition number of the weighted columns of the leading parameters: root of the ratio of the extreme
/// eigenvalues of their information.
pub(super) fn condition(information: &DMatrix<f64>, leaders: &[usize]) -> f64 {
    let values = leading(information, leaders).symmetric_eigenvalues();
    (values.max() / values.min().max(0.0)).sqrt()
}
