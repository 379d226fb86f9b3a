//! Results of an identification.

use super::asymmetry::Asymmetry;
use super::closed_loop::Simulated;
use super::delay::Delay;
use super::missing::Missing;
use stiction_core::mechanism::Mechanism;
use stiction_identify::{FitVerdict, Verdict};

/// Identified parameter with its estimate and verdict.
#[derive(Clone, Debug)]
pub struct Named {
    /// Name of the parameter.
    pub name: String,
    /// Estimated value, SI units.
    pub value: f64,
    /// Standard deviation of the estimate, SI units.
    pub sigma: f64,
    /// SI unit of the parameter.
    pub unit: &'static str,
    /// Verdict on the estimate.
    pub verdict: Verdict,
    /// Value of the parameter in the model, SI units; NaN for torque constants that the model
    /// lacks.
    pub prior: f64,
    /// First-order error of the estimate due to the filter, SI units. The filter attenuates a part
    /// of the motion.
    pub filter_bias: f64,
    /// Structural identifiability in words: the efforts determine the parameter alone, only in a
    /// combination with other parameters, or not at all.
    pub structure: &'static str,
    /// True for the offset of an effort and for the factor of an effort term. These parameters
    /// describe the log and are not part of the identified model.
    pub is_of_log: bool,
    /// True for a mass, a first moment of mass or an inertia of a body.
    pub is_inertia: bool,
}

/// Linear combination of parameters that the efforts determine, with its estimate.
#[derive(Clone, Debug)]
pub struct Combined {
    /// Description of the combination in words.
    pub name: String,
    /// Estimated value of the combination, SI units.
    pub value: f64,
    /// Standard deviation of the estimated combination, SI units.
    pub sigma: f64,
    /// SI unit of the combination.
    pub unit: &'static str,
    /// Verdict on the estimated combination.
    pub verdict: Verdict,
    /// First-order error of the estimated combination due to the filter, SI units. The filter
    /// attenuates a part of the motion.
    pub filter_bias: f64,
}

/// Errors of the predicted efforts on one log.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Name of the log.
    pub log: String,
    /// True if the log was fitted; false if it only checks the prediction.
    pub used_for_fit: bool,
    /// Name of each actuator, and its relative error 100 rms(measured - predicted) / rms(measured),
    /// percent. The error is `None` if the log has no rows of this actuator.
    pub error_percent: Vec<(String, Option<f64>)>,
    /// Root mean square of the residuals of each actuator, N or N m.
    pub residual: Vec<f64>,
    /// Relative error of the original model for each actuator, computed like `error_percent`,
    /// percent.
    pub prior_percent: Vec<Option<f64>>,
}

/// Result of an identification.
#[derive(Clone, Debug)]
pub struct Identified {
    /// Verdict on the fit.
    pub verdict: FitVerdict,
    /// Reasons for the verdict, and cautions on the logs.
    pub cautions: Vec<String>,
    /// All parameters of the regression, with estimates and verdicts.
    pub parameters: Vec<Named>,
    /// All combinations of two or more parameters that the efforts determine.
    pub combinations: Vec<Combined>,
    /// Number of parameter combinations that the efforts can determine, and the gap between the
    /// singular values that decides this number.
    pub rank: (usize, f64),
    /// Pairs of parameters that the data cannot distinguish. The third text is advice on data that
    /// would distinguish them.
    pub confounded: Vec<(String, String, String)>,
    /// Asymmetry of the measured efforts of each actuator: their difference between the directions of motion.
    pub asymmetries: Vec<Asymmetry>,
    /// Delays of the efforts relative to the positions, estimated or specified in the options.
    pub delays: Vec<Delay>,
    /// Effects that the residuals show and the model or its options lack.
    pub missing: Vec<Missing>,
    /// Errors of the predicted efforts on each log.
    pub predictions: Vec<Prediction>,
    /// Mechanism with the identified values.
    pub mechanism: Mechanism,
    /// Name of the estimator, as in the options.
    pub estimator: &'static str,
    /// Motions of the closed loop, simulated with nearly the identified values; `None` unless the estimator is the output-error
    /// method.
    pub simulated: Option<Simulated>,
    /// Strength of the prior on the inertias, as a number of equivalent samples.
    pub strength: f64,
    /// Mean squared residual of left-out blocks of the logs, divided by the mean squared residual
    /// of the fit.
    pub left_out: f64,
    /// Ratio as in `left_out`, but for least squares without a prior.
    pub left_out_plain: f64,
    /// Cut-off frequency of the filter of each log, Hz; `None` for tables of steady motions.
    pub cutoffs: Vec<Option<f64>>,
    /// Standard deviation of the residuals of each actuator, N or N m.
    pub residuals: Vec<f64>,
}

impl Identified {
    /// Returns the delay that was removed from each effort, s, in the order of the actuators.
    pub(super) fn taken_back(&self) -> Vec<f64> {
        let names = self.mechanism.actuators();
        let names = names.map(|(j, dof)| self.mechanism.joints()[j.0].actuator_name(dof));
        let delay = |name: String| {
            let own = self.delays.iter().find(|delay| delay.actuator == name);
            own.map_or(0.0, |delay| delay.value)
        };
        names.map(delay).collect()
    }
}
