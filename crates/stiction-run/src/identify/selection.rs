//! Selection of the parameters to estimate: their scales, which of them are fixed, bounded or tied
//! to each other, and a check that the logs contain enough independent samples.

mod body_bounds;

use super::IdentifyError;
use super::chosen::{chosen_efforts, refuse};
use super::options::IdentifySettings;
use super::prepare::{MeasuredLog, Prepared};
use super::torque_constants;
pub(super) use body_bounds::BodyBound;
use body_bounds::{body_bounds, centres};
use stiction_core::mechanism::Mechanism;
use stiction_format::fits;
use stiction_identify::{Choice, Kind, Options, Parameter};

/// Chooses the parameters that the logs may determine. The efforts must be measured either at the
/// joints in all logs or at the motors in all logs.
///
/// # Errors
/// Fails if the efforts in a log cannot be assigned uniquely to the actuators of the model. Also
/// fails if the logs contain the current of a motor whose torque constant is unknown and could only
/// be determined from the motor friction of the model.
pub(super) fn choice(
    mechanism: &Mechanism,
    logs: &[MeasuredLog],
    settings: &IdentifySettings,
    terms: usize,
) -> Result<Choice, IdentifyError> {
    let at_motors = match logs.first() {
        Some(log) => chosen_efforts(mechanism, log)?.1,
        None => false,
    };
    let torque_constants = torque_constants::unknown(mechanism, logs)?;
    Ok(Choice {
        at_motors,
        offsets: settings.offsets,
        terms,
        static_excess: true,
        torque_constants,
        ..Choice::ALL
    })
}

/// Sets the scale of each parameter that is zero in the model and does not belong to a body, such
/// as a friction coefficient. The scale is the smallest parameter value that explains a tenth (root
/// mean square) of the measured effort of an actuator.
pub(super) fn scale_by_data(parameters: &mut [Parameter], all: &[Prepared]) {
    for (k, parameter) in parameters.iter_mut().enumerate() {
        // The excess of static friction is a fraction, whose magnitude does not depend on the efforts.
        let is_fraction = matches!(parameter.kind, Kind::StaticExcess(_));
        if parameter.prior != 0.0 || parameter.body().is_some() || is_fraction {
            continue;
        }
        let mut scale = f64::INFINITY;
        for channel in 0..all[0].block.channels.len() {
            let rows: Vec<_> = all.iter().map(|log| &log.block.channels[channel]).collect();
            let column: f64 = rows.iter().map(|rows| rows.matrix.column(k).norm_squared()).sum();
            let effort: f64 = rows.iter().map(|rows| rows.measured.norm_squared()).sum();
            if column > 0.0 {
                scale = scale.min(0.1 * (effort / column).sqrt());
            }
        }
        if scale.is_finite() && scale > 0.0 {
            parameter.scale = scale;
        }
    }
}

fn held_of(parameters: &[Parameter], settings: &IdentifySettings) -> Vec<bool> {
    let is_held = |p: &Parameter| {
        let is_inertia = p.body().is_some() || matches!(p.kind, Kind::Rotor(_));
        let is_friction = p.kind.is_friction();
        // A torque constant cannot be fixed, because the model has no value for it.
        let is_unknown = matches!(p.kind, Kind::TorqueConstant(_));
        !is_unknown
            && ((settings.hold_inertia && is_inertia)
                || (settings.hold_friction && is_friction)
                || settings.hold.iter().any(|pattern| fits(pattern, &p.name)))
    };
    parameters.iter().map(is_held).collect()
}

pub(super) fn options(
    mechanism: &Mechanism,
    parameters: &[Parameter],
    settings: &IdentifySettings,
) -> Result<(Options, Vec<BodyBound>), IdentifyError> {
    let unknown = |key: &str, pattern: &str| {
        let near = stiction_format::did_you_mean(
            pattern,
            "parameters",
            parameters.iter().map(|p| p.name.as_str()),
        );
        refuse(
            format!("options: no parameter matches `{pattern}` of `{key}`"),
            near.unwrap_or_else(|| format!("the first parameter is {}", parameters[0].name)),
        )
    };
    for pattern in &settings.hold {
        if !parameters.iter().any(|p| fits(pattern, &p.name)) {
            return Err(unknown("hold", pattern));
        }
        let mut own = parameters.iter().filter(|p| fits(pattern, &p.name));
        if own.all(|p| matches!(p.kind, Kind::TorqueConstant(_))) {
            return Err(refuse(
                format!("options: `hold` names `{pattern}`, for which the model has no value"),
                "give `torque_constant` below [actuators.NAME] of the model",
            ));
        }
    }
    for (pattern, _) in &settings.bounds {
        let is_centre = centres(parameters).any(|own| fits(pattern, &own.name));
        if !is_centre && !parameters.iter().any(|p| fits(pattern, &p.name)) {
            return Err(unknown("bounds", pattern));
        }
    }
    let mut tied = Vec::new();
    for group in &settings.tie {
        let mut members = Vec::new();
        for pattern in group {
            let found: Vec<usize> =
                (0..parameters.len()).filter(|&k| fits(pattern, &parameters[k].name)).collect();
            if found.is_empty() {
                return Err(unknown("tie", pattern));
            }
            members.extend(found);
        }
        if members.is_empty() {
            return Err(refuse(
                "options: `tie` has an empty group".to_owned(),
                "name at least two parameters in each group",
            ));
        }
        members.sort_unstable();
        members.dedup();
        let kind = |k: usize| (class(parameters[k].kind), parameters[k].unit);
        if let Some(&other) = members.iter().find(|&&k| kind(k) != kind(members[0])) {
            return Err(refuse(
                format!(
                    "options: `tie` joins `{}` and `{}`, which are of different kinds",
                    parameters[members[0]].name, parameters[other].name
                ),
                "tie only parameters of one kind",
            ));
        }
        if members.iter().any(|&k| parameters[k].body().is_some()) {
            return Err(refuse(
                format!(
                    "options: `tie` cannot join inertias such as `{}` yet",
                    parameters[members[0]].name
                ),
                "tie friction only",
            ));
        }
        tied.push(members);
    }
    let held = held_of(parameters, settings);
    let bodies = body_bounds(parameters, settings, &held)?;
    let options = Options {
        strength: settings.strength,
        prior_error: settings.prior_error,
        radius: 0.02 * mechanism.characteristic_length(),
        bounds: bounds_of(parameters, settings, &held)?,
        inequalities: bodies.iter().flat_map(BodyBound::inequalities).collect(),
        held,
        tied,
    };
    Ok((options, bodies))
}

/// Returns the index of each bounded parameter with its lower and upper bound, in the unit of the
/// parameter. If a parameter or a group of tied parameters has several bounds, all of them apply.
fn bounds_of(
    parameters: &[Parameter],
    settings: &IdentifySettings,
    held: &[bool],
) -> Result<Vec<(usize, [f64; 2])>, IdentifyError> {
    let mut all: Vec<(usize, [f64; 2])> = Vec::new();
    for (pattern, own) in &settings.bounds {
        for k in (0..parameters.len()).filter(|&k| fits(pattern, &parameters[k].name)) {
            let p = &parameters[k];
            if p.body().is_some() {
                continue;
            }
            if held[k] && !(own[0]..=own[1]).contains(&p.prior) {
                return Err(refuse(
                    format!(
                        "options: `{}` is held at {}, outside of its bounds",
                        p.name,
                        format!("{} {}", p.prior, p.unit).trim_end()
                    ),
                    "change the value of the model, or do not hold the parameter",
                ));
            }
            let least = if p.is_nonnegative() { own[0].max(0.0) } else { own[0] };
            let both = all.iter().filter(|(other, _)| *other == k).map(|(_, bounds)| *bounds);
            let [low, high] = both.fold([least, own[1]], |[low, high], other| {
                [low.max(other[0]), high.min(other[1])]
            });
            if low > high {
                return Err(refuse(
                    format!("options: `bounds` leave no value for `{}`", p.name),
                    "all ranges given for one parameter must have a value in common, and the upper bound of friction must not be negative",
                ));
            }
            all.push((k, [low, high]));
        }
    }
    Ok(all)
}

/// Returns a number for the physical quantity of a parameter, independent of its body, joint or
/// actuator. Only parameters with the same number can be tied to each other.
fn class(kind: Kind) -> u8 {
    match kind {
        Kind::Mass(_) => 0,
        Kind::Moment(..) => 1,
        Kind::Inertia(..) => 2,
        Kind::Rotor(_) => 3,
        Kind::Mu(_) => 4,
        Kind::Coulomb(_) | Kind::DriveCoulomb(_) => 5,
        Kind::Viscous(_) | Kind::DriveViscous(_) => 6,
        Kind::Offset(_) => 7,
        Kind::Term(_) => 8,
        Kind::TorqueConstant(_) => 9,
        Kind::StaticExcess(_) => 10,
    }
}

/// Returns the indices of the estimated parameters in groups. The parameters of a group are tied
/// and have a common value; an untied parameter forms a group of its own.
pub(super) fn free_groups(parameters: &[Parameter], options: &Options) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for group in &options.tied {
        let is_free = |k: &usize| !options.held[*k] && !groups.iter().any(|g| g.contains(k));
        let own: Vec<usize> = group.iter().copied().filter(is_free).collect();
        if !own.is_empty() {
            groups.push(own);
        }
    }
    let singles: Vec<Vec<usize>> = (0..parameters.len())
        .filter(|k| !options.held[*k] && !groups.iter().any(|group| group.contains(k)))
        .map(|k| vec![k])
        .collect();
    groups.extend(singles);
    groups
}

/// Checks that the logs suffice for the estimation. Fails if they contain fewer independent samples
/// of efforts than there are parameters to estimate, or no usable sample of one of the efforts.
pub(super) fn enough(
    all: &[Prepared],
    parameters: &[Parameter],
    options: &Options,
) -> Result<(), IdentifyError> {
    let fits = || all.iter().filter(|log| !log.predict);
    let samples = |log: &Prepared| {
        let rows: usize = log.block.channels.iter().map(stiction_identify::Rows::len).sum();
        rows as f64 * log.block.independence
    };
    let samples = fits().map(samples).sum::<f64>() as usize;
    let free = free_groups(parameters, options).len();
    if samples < free {
        let (at_rest, rows) = fits().fold((0, 0), |(at_rest, rows), log| {
            (at_rest + log.at_rest, rows + log.times.len() * log.block.channels.len())
        });
        if 2 * at_rest > rows {
            return Err(refuse(
                format!(
                    "{at_rest} of {rows} rows of the filtered logs are left out, because a joint is at rest there and \
                     its friction is known only within limits; {samples} independent samples of efforts remain, too \
                     few for {free} parameters"
                ),
                "log a motion in which all joints with friction move; if they move in this log, check the columns \
                 and units of the positions",
            ));
        }
        return Err(refuse(
            format!(
                "the filtered logs have only {samples} independent samples of efforts, too few for {free} parameters"
            ),
            "give longer logs or a higher cut-off frequency (--filter), or hold or tie parameters in the options",
        ));
    }
    if let Some(channel) = (0..all[0].block.channels.len()).find(|&c| {
        all.iter().filter(|log| !log.predict).all(|log| log.block.channels[c].is_empty())
    }) {
        return Err(refuse(
            format!(
                "effort {} has no usable row: friction of a joint at rest acts on it all the time",
                channel + 1
            ),
            "log a motion in which all joints with friction move",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that tied parameters count as one unknown, and that fixed parameters do not count.
    #[test]
    fn tied_parameters_are_one_unknown() {
        let parameter = |name: &str| Parameter {
            name: name.to_owned(),
            unit: "",
            kind: Kind::Mu(0),
            prior: 0.1,
            scale: 0.1,
        };
        let parameters: Vec<Parameter> = ["a", "b", "c", "d"].map(parameter).into();
        let options = Options {
            strength: None,
            prior_error: 0.3,
            radius: 0.1,
            held: vec![false, false, true, false],
            tied: vec![vec![0, 2, 3]],
            bounds: Vec::new(),
            inequalities: Vec::new(),
        };
        assert_eq!(free_groups(&parameters, &options), [vec![0, 3], vec![1]]);
        assert_ne!(class(Kind::Mu(0)), class(Kind::Term(0)));
    }
}
