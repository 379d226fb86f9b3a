//! Specification of bodies.

use super::check_finite;
use crate::mechanism::{Body, Defect};
use crate::spatial::{Mat3, Vec3};

/// Specification of a body: name, mass, centre of mass and inertia tensor.
#[must_use = "a specification has no effect until it is passed to a `MechanismBuilder`"]
#[derive(Clone, Debug, PartialEq)]
pub struct BodySpec {
    pub(super) body: Body,
}

impl BodySpec {
    /// Creates a body without mass.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            body: Body { name: name.into(), mass: 0.0, com: Vec3::zero(), inertia: Mat3::zero() },
        }
    }

    /// Sets the mass, kg.
    pub fn mass(mut self, mass: f64) -> Self {
        self.body.mass = mass;
        self
    }

    /// Sets the centre of mass in the body's frame, m.
    pub fn com(mut self, com: Vec3<f64>) -> Self {
        self.body.com = com;
        self
    }

    /// Sets the inertia tensor about the centre of mass, in the body's axes, kg m^2.
    pub fn inertia(mut self, inertia: Mat3<f64>) -> Self {
        self.body.inertia = inertia;
        self
    }

    /// Checks mass, centre of mass and inertia tensor, and appends the defects found to `defects`.
    pub(super) fn check(&self, defects: &mut Vec<Defect>) {
        let body = &self.body;
        let name = || body.name.clone();
        let tensor = nalgebra::Matrix3::from(body.inertia);
        let before = defects.len();
        for (what, numbers) in [
            ("the mass", vec![body.mass]),
            ("the centre of mass", body.com.to_array().to_vec()),
            ("the inertia", tensor.as_slice().to_vec()),
        ] {
            check_finite(defects, &format!("{what} of body `{}`", body.name), &numbers);
        }
        if defects.len() > before {
            return;
        }
        if body.mass < 0.0 {
            defects.push(Defect::NegativeMass { body: name(), mass: body.mass });
        }
        // Tensors from files are rounded, but a relative asymmetry of more than 1e-9 is an error.
        let slack = 1e-9 * tensor.amax();
        if (tensor - tensor.transpose()).amax() > slack {
            defects.push(Defect::AsymmetricInertia { body: name() });
            return;
        }
        let [smallest, ..] = body.principal_moments();
        if smallest < -slack {
            defects.push(Defect::NegativeInertia { body: name(), moment: smallest });
        }
    }
}
