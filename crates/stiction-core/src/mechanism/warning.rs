//! Warnings about consistent but suspicious mechanisms.

use super::Mechanism;
use crate::spatial::Vec3;
use thiserror::Error;

/// Warning about a suspicious property of a mechanism. Warnings never change results.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Warning {
    /// A principal moment of inertia of a body exceeds the sum of the other two.
    #[error(
        "no distribution of mass has the inertia of body `{body}`: its largest principal moment, \
         {largest} kg m^2, exceeds the sum of the other two, {sum} kg m^2"
    )]
    ImpossibleInertia {
        /// Name of the body.
        body: String,
        /// Largest principal moment of inertia of the body, kg m^2.
        largest: f64,
        /// Sum of the two smaller principal moments of inertia of the body, kg m^2.
        sum: f64,
    },
    /// The inertia of a body does not fit its mass and the distances between its joints.
    #[error(
        "the inertia of body `{body}` is that of a ring of radius {radius:.3e} m, but {what} \
         {extent:.3e} m: are the units of the inertia right?",
        what = match coincide {
            true => "the characteristic length of the mechanism is",
            false => "the greatest distance between the body's joints and centre of mass is",
        }
    )]
    UnlikelyInertia {
        /// Name of the body.
        body: String,
        /// Largest radius of gyration, m.
        radius: f64,
        /// Greatest distance between joints and centre of mass of the body, m; the characteristic
        /// length if all these points coincide.
        extent: f64,
        /// True if all these points coincide.
        coincide: bool,
    },
    /// The mass of a body exceeds that of a gold cube of the body's size.
    #[error(
        "body `{body}` has {mass} kg, more than a cube of gold with edges of {extent:.3e} m: \
         is its mass in g?"
    )]
    UnlikelyMass {
        /// Name of the body.
        body: String,
        /// Mass of the body, kg.
        mass: f64,
        /// Size of the body, m: the greatest distance between its joints and centre of mass, the
        /// characteristic length, or twice the largest radius of gyration, whichever is greatest.
        extent: f64,
    },
    /// A friction coefficient exceeds that of any dry pair of materials.
    #[error("the friction coefficient {mu} of joint `{joint}` is unusual: is it in percent?")]
    UnlikelyFriction {
        /// Name of the joint.
        joint: String,
        /// The friction coefficient.
        mu: f64,
    },
    /// The magnitude of gravity is far from its value on Earth.
    #[error("gravity is {size} m/s^2, but 9.81 m/s^2 on the Earth: are its units right?")]
    UnlikelyGravity {
        /// Magnitude of gravity, m/s^2.
        size: f64,
    },
    /// Gravity acts upwards or sideways.
    #[error("gravity acts along {axis}: are its axis and its sign right?")]
    OddGravity {
        /// Direction of gravity: `+x`, `-x`, `+y` or `+z`.
        axis: &'static str,
    },
    /// A body has inertia but no mass.
    #[error("body `{body}` has inertia but no mass")]
    InertiaWithoutMass {
        /// Name of the body.
        body: String,
    },
    /// No body has mass.
    #[error("no body has mass: only loads and friction require actuator efforts")]
    NoMass,
    /// No joint is actuated.
    #[error("no joint is actuated: there are no actuator efforts to compute")]
    NoActuator,
}

/// Density of gold, kg/m^3. A body of greater density causes [`Warning::UnlikelyMass`].
const DENSEST: f64 = 19_300.0;
/// Smallest and greatest usual ratio of a body's radius of gyration to its extent, the greatest
/// distance between its joints and centre of mass. In the comparison with the greatest ratio, the
/// characteristic length replaces the extent if it is larger. A slender rod has a ratio of 0.29;
/// the links of all built-in robots have ratios between 0.19 and 0.47. An inertia that is ten times
/// too large increases the ratio by a factor of 3.2; a confusion of units (kg mm^2, or g for kg)
/// changes it by a factor of at least 30.
const LINKS: [f64; 2] = [0.05, 0.8];
/// Smallest and greatest usual ratio, as in [`LINKS`], for a body with at most one joint. Such a
/// body may extend far beyond its joint, like a table on a pin, or be small, like a bob.
const ENDS: [f64; 2] = [0.02, 5.0];
/// Greatest usual friction coefficient. Rubber on concrete has a coefficient of about 1.
const ROUGHEST: f64 = 2.0;

impl Mechanism {
    /// Returns, for each body, its centre of mass followed by the origins of its joints, in the
    /// frame of the body, m.
    fn points(&self) -> Vec<Vec<Vec3<f64>>> {
        let mut points: Vec<Vec<_>> = self.bodies.iter().map(|body| vec![body.com]).collect();
        for joint in &self.joints {
            points[joint.predecessor.0].push(joint.frame_j.position);
            points[joint.successor.0].push(joint.frame_k.position);
        }
        points
    }

    /// Checks the mechanism for suspicious properties and returns all warnings.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let moving = &self.bodies()[1..];
        for (body, points) in moving.iter().zip(&self.points()[1..]) {
            let [smallest, middle, largest] = body.principal_moments();
            let sum = smallest + middle;
            // Planar models commonly define a single moment of inertia.
            if middle > 0.0 && largest > sum * (1.0 + 1e-6) {
                warnings.push(Warning::ImpossibleInertia { body: body.name.clone(), largest, sum });
            }
            let pairs = points.iter().flat_map(|a| points.iter().map(|b| (*a - *b).norm()));
            let own = pairs.fold(0.0, f64::max);
            let length = self.characteristic_length;
            let radius = if body.mass > 0.0 { (largest / body.mass).sqrt() } else { 0.0 };
            let size = own.max(length).max(2.0 * radius);
            if body.mass > DENSEST * size.powi(3) {
                let (body, mass) = (body.name.clone(), body.mass);
                warnings.push(Warning::UnlikelyMass { body, mass, extent: size });
            } else if body.mass > 0.0 && largest > 0.0 {
                let extent = if own > 0.0 { own } else { length };
                // A body with one joint has two points, because its centre of mass also counts as
                // one.
                let [thinnest, widest] = if points.len() > 2 { LINKS } else { ENDS };
                if radius < extent * thinnest || radius > own.max(length) * widest {
                    let body = body.name.clone();
                    let coincide = own == 0.0;
                    warnings.push(Warning::UnlikelyInertia { body, radius, extent, coincide });
                }
            }
            if body.mass == 0.0 && largest > 0.0 {
                warnings.push(Warning::InertiaWithoutMass { body: body.name.clone() });
            }
        }
        for joint in &self.joints {
            let greatest =
                joint.friction.iter().map(|friction| friction.law.mu).fold(0.0, f64::max);
            if greatest > ROUGHEST {
                let joint = joint.name.clone();
                warnings.push(Warning::UnlikelyFriction { joint, mu: greatest });
            }
        }
        let size = self.gravity.norm();
        // Usual values, in m/s^2, range from the gravity of moons to that in a centrifuge of a few
        // g.
        if size > 0.0 && !(0.1..=100.0).contains(&size) {
            warnings.push(Warning::UnlikelyGravity { size });
        }
        // In most models z or y points upwards; gravity oblique to the axes indicates a tilted machine.
        let odd = match self.gravity.to_array() {
            [x, 0.0, 0.0] if x > 0.0 => Some("+x"),
            [x, 0.0, 0.0] if x < 0.0 => Some("-x"),
            [0.0, y, 0.0] if y > 0.0 => Some("+y"),
            [0.0, 0.0, z] if z > 0.0 => Some("+z"),
            _ => None,
        };
        warnings.extend(odd.map(|axis| Warning::OddGravity { axis }));
        if moving.iter().all(|body| body.mass == 0.0) {
            warnings.push(Warning::NoMass);
        }
        if self.actuators().next().is_none() {
            warnings.push(Warning::NoActuator);
        }
        warnings
    }
}
