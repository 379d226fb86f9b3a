//! Identification of torque constants of motors whose currents are logged, but whose torque
//! constants are not declared in the model.

use super::IdentifyError;
use super::chosen::{chosen_efforts, refuse};
use super::identified::Named;
use super::options::IdentifySettings;
use super::prepare::{MeasuredLog, Prepared};
use super::run::differences;
use super::structure::Structure;
use nalgebra::DVector;
use stiction_core::mechanism::Mechanism;
use stiction_identify::{Kind, Parameter, Verdict};

/// Threshold of the cosine between two vectors over all samples: the measured currents and the
/// efforts that the model predicts. Above this threshold, the initial value of a torque constant is
/// computed from the scalar product of both vectors, otherwise from the ratio of their norms.
const AGREES: f64 = 0.5;
/// Largest number of parameters in combination with a torque constant that a message names.
const NAMED: usize = 4;
/// Relative standard deviation below which an identified value is still useful, although it is
/// proportional to the masses that the model assumes.
const USEFUL: f64 = 0.5;

/// Finds the drive trains whose motor currents are logged and whose torque constants are unknown.
/// Returns their indices in increasing order.
///
/// # Errors
/// Fails if such a motor and the joint that it drives both have friction. In this case, the
/// identification does not estimate the motor friction, so that the motor friction assumed in the
/// model would determine the torque constant.
pub(super) fn unknown(
    mechanism: &Mechanism,
    logs: &[MeasuredLog],
) -> Result<Vec<usize>, IdentifyError> {
    let mut all = Vec::new();
    for log in logs {
        all.extend(chosen_efforts(mechanism, log)?.0.iter().filter_map(|own| own.unknown));
    }
    all.sort_unstable();
    all.dedup();
    for &index in &all {
        let train = &mechanism.drive_trains()[index];
        let joint = train.only_dof().map(|(joint, _)| &mechanism.joints()[joint.0]);
        let Some(joint) = joint.filter(|joint| !joint.friction.is_empty()) else { continue };
        if train.has_motor_friction() {
            return Err(refuse(
                format!(
                    "the current of {} needs a known torque constant: both the motor and joint {} \
                     have friction, and the friction of the motor, which is not identified there, \
                     would fix the ratio of torque to current",
                    train.name, joint.name
                ),
                format!(
                    "add `torque_constant` to [actuators.{}] of the model, or declare friction \
                     only at the motor or only at the joint",
                    train.name
                ),
            ));
        }
    }
    Ok(all)
}

/// Chooses initial values of the torque constants such that the efforts computed from the measured
/// currents are as large as the efforts that the model predicts. The values become the priors and
/// the scales of the parameters.
pub(super) fn start(parameters: &mut [Parameter], all: &mut [Prepared]) {
    let priors: Vec<f64> = parameters.iter().map(|p| p.prior).collect();
    let at = differences(parameters, &priors);
    for (k, parameter) in parameters.iter_mut().enumerate() {
        if !matches!(parameter.kind, Kind::TorqueConstant(_)) {
            continue;
        }
        let (mut mm, mut pp, mut mp) = (0.0, 0.0, 0.0);
        for log in all.iter().filter(|log| !log.predict) {
            for (rows, own) in log.block.channels.iter().zip(log.constants()) {
                if own.is_some_and(|(parameter, _)| parameter == k) {
                    let predicted = rows.predicted(&at);
                    mm += rows.measured.norm_squared();
                    pp += predicted.norm_squared();
                    mp += rows.measured.dot(&predicted);
                }
            }
        }
        let by_product = mp > AGREES * (mm * pp).sqrt();
        let value = if by_product { mp / mm } else { (pp / mm).sqrt() };
        if value.is_finite() && value > 0.0 {
            (parameter.prior, parameter.scale) = (value, value);
        }
    }
    let values: Vec<f64> = parameters.iter().map(|p| p.prior).collect();
    all.iter_mut().for_each(|log| log.start_constants(&values));
}

/// Writes the entry of an unknown torque constant into the regression row of an actuator's effort,
/// in units of the parameter's scale. The entry is computed from the effort that the model predicts
/// with the prior values `at`. Does nothing if `constant`, the index of the torque constant, is
/// `None`.
pub(super) fn complete(
    row: &mut nalgebra::RowDVector<f64>,
    (known, constant): (f64, Option<usize>),
    (parameters, at): (&[Parameter], &DVector<f64>),
) {
    let Some(k) = constant else { return };
    row[k] = 0.0;
    let predicted = known + (&*row * at)[0];
    row[k] = -predicted / parameters[k].scale;
}

/// Finds the indices of the torque constants that the logs alone do not determine, so that their
/// estimates depend on the prior.
///
/// # Errors
/// Fails if there are such torque constants and the options do not specify the strength of the
/// prior.
pub(super) fn by_prior(
    parameters: &[Parameter],
    structure: &Structure,
    settings: &IdentifySettings,
) -> Result<Vec<usize>, IdentifyError> {
    let constants =
        (0..parameters.len()).filter(|&k| matches!(parameters[k].kind, Kind::TorqueConstant(_)));
    let open: Vec<usize> = constants.filter(|&k| !structure.free.is_alone(k)).collect();
    let (Some(&first), None) = (open.first(), settings.strength) else { return Ok(open) };
    let name = &parameters[first].name;
    let names: Vec<&str> = open.iter().map(|&k| parameters[k].name.as_str()).collect();
    let partners = partners(structure, first);
    let shown: Vec<&str> =
        partners.iter().take(NAMED).map(|&k| parameters[k].name.as_str()).collect();
    let more = match partners.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let train = name.strip_suffix(".torque_constant").unwrap_or(name);
    Err(refuse(
        format!(
            "{} cannot be determined: the currents determine only the ratio to {}{more}; if all of \
             these are multiplied by one factor, the currents remain the same",
            names.join(", "),
            if shown.is_empty() { "all other parameters".to_owned() } else { shown.join(", ") },
        ),
        format!(
            "log a second time with a payload of known mass (`payload` below [[logs]]), keep a \
             known inertia or first moment of mass fixed (`hold = [\"BODY.mx\"]`), add \
             `torque_constant` to [actuators.{train}] of the model, or set how strongly the fit \
             trusts its inertias, such as `prior = 100`"
        ),
    ))
}

/// Returns the indices of the parameters that occur in a combination with the given torque
/// constant.
fn partners(structure: &Structure, constant: usize) -> Vec<usize> {
    let mut all = Vec::new();
    for c in &structure.free.combinations {
        let members = || std::iter::once(c.leader).chain(c.others.iter().map(|(k, _)| *k));
        if members().any(|k| k == constant) {
            all.extend(members().filter(|&k| k != constant));
        }
    }
    all.sort_unstable();
    all.dedup();
    all
}

/// Sets the verdict to `FitsOnly` for the torque constants with the indices `open`, which are
/// proportional to the inertias of the model. Other parameters except inertias change from
/// `NotExcited` to `FitsOnly` if their relative standard deviation is below [`USEFUL`]. Returns a
/// caution that names the torque constants, or `None` if `open` is empty.
pub(super) fn judge(named: &mut [Named], open: &[usize], strength: f64) -> Option<String> {
    if open.is_empty() {
        return None;
    }
    for p in named.iter_mut() {
        let is_useful = p.sigma < USEFUL * p.value.abs();
        if p.verdict == Verdict::NotExcited && is_useful && !p.is_inertia {
            p.verdict = Verdict::FitsOnly;
        }
    }
    let each = open.iter().map(|&k| {
        let p = &mut named[k];
        p.verdict = Verdict::FitsOnly;
        format!("{} ({:.4} +- {:.4} {})", p.name, p.value, p.sigma, p.unit)
    });
    let names: Vec<String> = each.collect();
    Some(format!(
        "{} follows from the inertias of the model, to which `prior` gives the weight of \
         {strength} samples; if these inertias are wrong by a common factor, so are all values: \
         log a payload of known mass",
        names.join(", ")
    ))
}
