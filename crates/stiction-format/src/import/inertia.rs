//! Masses and inertias: checks, sums and changes of axes.

use crate::diagnostic::{number, quoted};
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Mass, centre of mass, and inertia about the centre of mass, all in the same frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mass {
    pub(super) mass: f64,
    pub(super) com: Vec3<f64>,
    pub(super) inertia: Mat3<f64>,
}

/// Message for a negative mass, kg, of a body or link.
pub(super) fn negative_mass(kind: &str, name: &str, mass: f64) -> String {
    format!("the mass of {kind} {} is negative: {} kg", quoted(name), number(mass))
}

/// Creates a symmetric tensor from its six entries.
pub(super) fn symmetric([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Mat3<f64> {
    let column = |a, b, c| Vec3::new(a, b, c);
    Mat3::from_columns(column(xx, xy, xz), column(xy, yy, yz), column(xz, yz, zz))
}

/// Expresses a tensor in the axes of another frame. The columns of `rotation` are the present axes,
/// expressed in the other frame.
pub(super) fn turned(tensor: Mat3<f64>, rotation: Mat3<f64>) -> Mat3<f64> {
    if rotation == Mat3::identity() {
        return tensor;
    }
    let turned = rotation * tensor * rotation.transpose();
    // Rounding errors make the product slightly unsymmetric.
    (turned + turned.transpose()) * 0.5
}

/// Steiner's term (parallel axis theorem): inertia about a point minus inertia about the centre of
/// mass. `arm` is the vector between this point and the centre of mass.
pub(super) fn steiner(mass: f64, arm: Vec3<f64>) -> Mat3<f64> {
    let square = arm.norm_squared();
    let column = |k: usize| (Vec3::unit(k) * square + arm * -arm.component(k)) * mass;
    Mat3::from_columns(column(0), column(1), column(2))
}

impl Mass {
    /// Mass properties of a massless part.
    pub(super) const fn none() -> Self {
        let zero = Vec3 { x: 0.0, y: 0.0, z: 0.0 };
        Self { mass: 0.0, com: zero, inertia: Mat3 { columns: [zero; 3] } }
    }

    /// Transforms the mass properties to another frame; `pose` is the pose of the present frame in
    /// the other frame.
    pub(super) fn placed(self, pose: Pose<f64>) -> Self {
        Self {
            mass: self.mass,
            com: pose.apply(self.com),
            inertia: turned(self.inertia, pose.rotation),
        }
    }

    /// Mass properties of this part and `other` together, expressed in the same frame.
    pub(super) fn with(self, other: Self) -> Self {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return Self { inertia: self.inertia + other.inertia, ..self };
        }
        let com = (self.com * self.mass + other.com * other.mass) * mass.recip();
        let about = |part: Self| part.inertia + steiner(part.mass, part.com + -com);
        Self { mass, com, inertia: about(self) + about(other) }
    }

    /// Multiplies the mass and inertia by `factor`; the centre of mass does not change.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { mass: self.mass * factor, inertia: self.inertia * factor, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that two halves of a rod give the inertia of the whole rod, m l²/12.
    #[test]
    fn halves_add_up() {
        let half = |x: f64| Mass {
            mass: 1.0,
            com: Vec3::new(x, 0.0, 0.0),
            inertia: Mat3::diagonal(Vec3::new(0.0, 1.0 / 12.0, 1.0 / 12.0)),
        };
        let rod = half(0.5).with(half(1.5));
        assert_eq!((rod.mass, rod.com), (2.0, Vec3::new(1.0, 0.0, 0.0)));
        for k in 1..3 {
            assert!((rod.inertia.at(k, k) - 2.0 * 4.0 / 12.0).abs() < 1e-15);
        }
        assert_eq!(rod.inertia.at(0, 0), 0.0);
    }
}
