//! Limits on the designed motion that the options set. An option selects quantities by a name or a
//! pattern.

use super::ExciteError;
use super::coordinates::{Chosen, dof_value};
use super::limits::{Limit, Moving, Of};
use super::settings::{LimitSetting, Quantity};
use crate::names::{Names, listed};
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_format::{Amount, did_you_mean, fits};

/// Returns all moving quantities with their names: first the coordinates of the motion, then the
/// other degrees of freedom of joints. The flag is true if the quantity is an angle.
fn moving(mechanism: &Mechanism, chosen: &Chosen) -> Vec<(String, Moving, bool)> {
    let mut all: Vec<(String, Moving, bool)> = (0..chosen.names.len())
        .map(|k| (chosen.names[k].clone(), Moving::Coordinate(k), chosen.is_angle[k]))
        .collect();
    for (index, joint) in mechanism.joints().iter().enumerate() {
        if !joint.joint_type.has_scalar_coordinates() {
            continue;
        }
        for (dof, content) in joint.joint_type.dofs().iter().enumerate() {
            let name = joint.dof_name(dof);
            if all.iter().all(|(known, ..)| *known != name) {
                all.push((name, Moving::Dof(JointId(index), dof), !content.translates()));
            }
        }
    }
    all
}

/// Adds the limits that an option sets to `all`. Adds none if no name matches the pattern of the
/// option.
pub(super) fn add_setting(
    mechanism: &Mechanism,
    chosen: &Chosen,
    setting: &LimitSetting,
    all: &mut Vec<Limit>,
) -> Result<(), ExciteError> {
    let number = |amount: &Amount, unit: &str| match amount.unit.as_str() {
        "" => Ok(amount.number),
        _ => amount.to_unit(unit).map_err(|why| {
            let Amount { number, unit: given } = amount;
            ExciteError::input(
                format!(
                    "--limit of {} is {number} {given}, but is measured in {unit}: {why}",
                    setting.name
                ),
                format!("give it in {unit} or a unit of the same kind"),
            )
        }),
    };
    if setting.of == Quantity::Effort {
        for (index, (name, unit)) in Names::new(mechanism).drives.into_iter().enumerate() {
            if fits(&setting.name, &name) {
                let bound = number(&setting.most, unit)?;
                all.push(Limit {
                    name: format!("{name}.effort"),
                    unit,
                    bound,
                    of: Of::Effort(index),
                });
            }
        }
        return Ok(());
    }
    // A pattern such as `leg*` may match both angles and lengths. The limit applies only to the
    // quantities that fit its unit.
    let candidates = moving(mechanism, chosen);
    let named = candidates.iter().filter(|(name, ..)| fits(&setting.name, name));
    let mut misfit = None;
    let before = all.len();
    for (name, moving, is_angle) in named {
        let unit = match (is_angle, setting.of) {
            (true, Quantity::Travel) => "rad",
            (true, Quantity::Speed) => "rad/s",
            (true, _) => "rad/s^2",
            (false, Quantity::Travel) => "m",
            (false, Quantity::Speed) => "m/s",
            (false, _) => "m/s^2",
        };
        let most = match number(&setting.most, unit) {
            Ok(most) => most,
            Err(error) => {
                misfit.get_or_insert(error);
                continue;
            }
        };
        all.push(match setting.of {
            Quantity::Travel => {
                let start = match *moving {
                    Moving::Coordinate(k) => chosen.centre[k],
                    Moving::Dof(joint, dof) => {
                        dof_value(mechanism, chosen.solver.bodies(), joint, dof)
                    }
                };
                let (low, high) = match &setting.from {
                    Some(from) => (number(from, unit)?, most),
                    None => (start - most, start + most),
                };
                if low >= high {
                    return Err(ExciteError::input(
                        format!("the range of {name} is empty: {low} to {high} {unit}"),
                        "give the smaller number first, as in `J1 = -20 deg..30 deg`",
                    ));
                }
                let of = Of::Travel(*moving, 0.5 * (low + high));
                Limit { name: name.clone(), unit, bound: 0.5 * (high - low), of }
            }
            Quantity::Speed => {
                let of = Of::Speed(*moving);
                Limit { name: format!("{name}.speed"), unit, bound: most, of }
            }
            _ => {
                let of = Of::Acceleration(*moving);
                Limit { name: format!("{name}.acceleration"), unit, bound: most, of }
            }
        });
    }
    if let Some(error) = misfit.filter(|_| all.len() == before) {
        return Err(error);
    }
    Ok(())
}

/// Returns the error for an option whose pattern matches no name, with a suggestion.
pub(super) fn unknown(
    mechanism: &Mechanism,
    chosen: &Chosen,
    setting: &LimitSetting,
) -> ExciteError {
    let (what, names): (&str, Vec<String>) = match setting.of {
        Quantity::Effort => {
            ("actuator", Names::new(mechanism).drives.into_iter().map(|(name, _)| name).collect())
        }
        _ => (
            "coordinate or joint",
            moving(mechanism, chosen).into_iter().map(|(name, ..)| name).collect(),
        ),
    };
    let near = did_you_mean(&setting.name, what, names.iter().map(String::as_str));
    ExciteError::input(
        format!("no {what} matches `{}` of --limit", setting.name),
        near.unwrap_or_else(|| format!("choose from {}", listed(&names, 8))),
    )
}
