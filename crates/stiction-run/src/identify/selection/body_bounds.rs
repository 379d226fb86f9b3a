//! Bounds of masses, first moments, inertias and centres of mass of bodies.

use super::{IdentifyError, class};
use crate::identify::chosen::refuse;
use crate::identify::options::IdentifySettings;
use stiction_format::fits;
use stiction_identify::{Inequality, Kind, Parameter};

/// Parameter of a body, or coordinate of its centre of mass, with its least and greatest value.
#[derive(Clone, Debug)]
pub(in crate::identify) struct BodyBound {
    pub(in crate::identify) name: String,
    pub(in crate::identify) unit: &'static str,
    /// Index of the parameter.
    parameter: usize,
    /// Index of the mass by which the parameter, a first moment, is divided; `None` for the
    /// parameter itself.
    mass: Option<usize>,
    /// Typical magnitude, SI units.
    pub(in crate::identify) scale: f64,
    /// Least and greatest value, SI units.
    pub(in crate::identify) range: [f64; 2],
}

/// Returns the coordinates of the centres of mass of all bodies, without bounds.
pub(super) fn centres(parameters: &[Parameter]) -> impl Iterator<Item = BodyBound> + '_ {
    parameters.iter().enumerate().filter_map(|(k, p)| {
        let Kind::Moment(body, axis) = p.kind else { return None };
        let mass = parameters.iter().position(|own| own.kind == Kind::Mass(body))?;
        let name = parameters[mass].name.strip_suffix(".mass")?;
        let name = format!("{name}.com.{}", ["x", "y", "z"][axis]);
        let range = [f64::NEG_INFINITY, f64::INFINITY];
        let scale = p.scale / parameters[mass].scale;
        Some(BodyBound { name, unit: "m", parameter: k, mass: Some(mass), scale, range })
    })
}

/// Returns the bounds of the options that apply to bodies.
///
/// # Errors
/// Fails if one bound applies to quantities of different kinds, or leaves a held parameter no value.
pub(super) fn body_bounds(
    parameters: &[Parameter],
    settings: &IdentifySettings,
    held: &[bool],
) -> Result<Vec<BodyBound>, IdentifyError> {
    let mut all: Vec<BodyBound> = Vec::new();
    let prior: Vec<f64> = parameters.iter().map(|p| p.prior).collect();
    for (pattern, range) in &settings.bounds {
        let own = (0..parameters.len()).filter(|&k| parameters[k].body().is_some()).map(|k| {
            let (name, unit) = (parameters[k].name.clone(), parameters[k].unit);
            BodyBound {
                name,
                unit,
                parameter: k,
                mass: None,
                scale: parameters[k].scale,
                range: *range,
            }
        });
        let found: Vec<BodyBound> = own
            .chain(centres(parameters).map(|own| BodyBound { range: *range, ..own }))
            .filter(|own| fits(pattern, &own.name))
            .collect();
        let Some(first) = found.first() else { continue };
        let kind = |own: &BodyBound| (class(parameters[own.parameter].kind), own.mass.is_some());
        let joint = parameters.iter().find(|p| p.body().is_none() && fits(pattern, &p.name));
        let other = found.iter().find(|own| kind(own) != kind(first)).map(|own| &own.name);
        if let Some(other) = other.or(joint.map(|p| &p.name)) {
            return Err(refuse(
                format!(
                    "options: `{pattern}` of `bounds` names `{}` and `{other}`, which are of different kinds",
                    first.name
                ),
                "give bounds for each kind, such as `\"*.mass\"`",
            ));
        }
        for own in found {
            let is_held = held[own.parameter] && own.mass.is_none_or(|mass| held[mass]);
            if is_held && !own.contains(&prior) {
                return Err(refuse(
                    format!(
                        "options: `{}` is held at {} {}, outside of its bounds",
                        own.name,
                        own.value(&prior),
                        own.unit
                    ),
                    "change the value of the model, or do not hold the parameter",
                ));
            }
            if !is_held && own.range[0] == own.range[1] {
                return Err(refuse(
                    format!("options: `bounds` leave only one value for `{}`", own.name),
                    "give this value in the model and hold it with `hold`",
                ));
            }
            all.push(own);
        }
    }
    Ok(all)
}

impl BodyBound {
    /// Returns the index of the parameter whose verdict depends on the bound.
    pub(in crate::identify) fn leader(&self) -> usize {
        self.parameter
    }

    /// Computes the bounded quantity from the values of all parameters, SI units.
    pub(in crate::identify) fn value(&self, values: &[f64]) -> f64 {
        values[self.parameter] / self.mass.map_or(1.0, |mass| values[mass])
    }

    fn contains(&self, values: &[f64]) -> bool {
        let value = self.value(values);
        let rounding = 1e-12 * value.abs().max(self.scale);
        self.range[0] - rounding <= value && value <= self.range[1] + rounding
    }

    /// Returns the inequalities `sign * (parameter - bound * mass) >= 0` for both bounds, without
    /// the mass for the parameter itself.
    pub(super) fn inequalities(&self) -> impl Iterator<Item = Inequality> + '_ {
        let both = self.range.into_iter().zip([1.0, -1.0]).filter(|(bound, _)| bound.is_finite());
        both.map(|(bound, sign)| match self.mass {
            None => Inequality { terms: vec![(self.parameter, sign)], least: sign * bound },
            Some(mass) => {
                let terms = vec![(self.parameter, sign), (mass, -sign * bound)];
                Inequality { terms, least: 0.0 }
            }
        })
    }

    /// Checks that the values with which the fit begins lie within `bounds`.
    ///
    /// # Errors
    /// Names the first quantity outside its bounds.
    pub(in crate::identify) fn check(
        bounds: &[Self],
        initial: &[f64],
    ) -> Result<(), IdentifyError> {
        let Some(own) = bounds.iter().find(|own| !own.contains(initial)) else { return Ok(()) };
        let ([low, high], value) = (own.range, own.value(initial));
        let thickness = match own.unit {
            "kg m^2" => "; a thin body counts with some thickness, which raises its inertia",
            _ => "",
        };
        Err(refuse(
            format!(
                "options: the bounds of `{}` are {low} to {high} {unit}, but the fit begins at the value of the model, \
                 {value} {unit}",
                own.name,
                unit = own.unit
            ),
            format!(
                "change the bounds, or give a value between them in the model (`--set`){thickness}"
            ),
        ))
    }
}
