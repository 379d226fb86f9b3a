//! Warnings on consistent, but suspicious mechanisms.

use super::Mechanism;
use thiserror::Error;

/// A suspicious property of a mechanism. Warnings never change results.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Warning {
    /// A principal moment greater than the sum of the other two.
    #[error(
        "no distribution of mass has the inertia of body `{body}`: its largest principal moment, \
         {largest} kg m^2, exceeds the sum of the other two, {sum} kg m^2"
    )]
    ImpossibleInertia {
        /// The body.
        body: String,
        /// The largest principal moment, kg m^2.
        largest: f64,
        /// The sum of the other two, kg m^2.
        sum: f64,
    },
    /// Inertia without mass.
    #[error("body `{body}` has inertia but no mass")]
    InertiaWithoutMass {
        /// The body.
        body: String,
    },
    /// No body has mass.
    #[error("no body has mass: only loads and friction require actuator efforts")]
    NoMass,
    /// No joint is actuated.
    #[error("no joint is actuated: there are no actuator efforts to compute")]
    NoActuator,
}

impl Mechanism {
    /// All warnings on the mechanism.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let moving = &self.bodies()[1..];
        for body in moving {
            let [smallest, middle, largest] = body.principal_moments();
            let sum = smallest + middle;
            // Planar models commonly define a single moment.
            if middle > 0.0 && largest > sum * (1.0 + 1e-6) {
                warnings.push(Warning::ImpossibleInertia { body: body.name.clone(), largest, sum });
            }
            if body.mass == 0.0 && largest > 0.0 {
                warnings.push(Warning::InertiaWithoutMass { body: body.name.clone() });
            }
        }
        if moving.iter().all(|body| body.mass == 0.0) {
            warnings.push(Warning::NoMass);
        }
        if self.actuators().next().is_none() {
            warnings.push(Warning::NoActuator);
        }
        warnings
    }
}
