//! Mass properties of simple solids with a density of 1 kg/m³, centred at the origin.

use super::inertia::Mass;
use std::f64::consts::PI;
use stiction_core::spatial::{Mat3, Vec3};

pub(super) fn with_moments(mass: f64, moments: [f64; 3]) -> Mass {
    Mass { mass, com: Vec3::zero(), inertia: Mat3::diagonal(Vec3::from(moments)) }
}

/// Computes the mass properties of a solid ellipsoid of 1 kg/m³ with these half axes, m, along x, y
/// and z.
pub(super) fn ellipsoid([a, b, c]: [f64; 3]) -> Mass {
    let mass = 4.0 / 3.0 * PI * a * b * c;
    let moment = |u: f64, v: f64| mass / 5.0 * (u * u + v * v);
    with_moments(mass, [moment(b, c), moment(a, c), moment(a, b)])
}

/// Computes the mass properties of a solid box of 1 kg/m³ with these half edges, m, along x, y and
/// z.
pub(super) fn cuboid([a, b, c]: [f64; 3]) -> Mass {
    let mass = 8.0 * a * b * c;
    let moment = |u: f64, v: f64| mass / 3.0 * (u * u + v * v);
    with_moments(mass, [moment(b, c), moment(a, c), moment(a, b)])
}

/// Computes the mass properties of a solid cylinder of 1 kg/m³ about the z axis with this radius
/// and half length, m.
pub(super) fn cylinder(radius: f64, half: f64) -> Mass {
    let square = radius * radius;
    let mass = PI * square * 2.0 * half;
    let side = mass * (square / 4.0 + half * half / 3.0);
    with_moments(mass, [side, side, mass * square / 2.0])
}

/// Computes the mass properties of a solid capsule of 1 kg/m³: a cylinder about the z axis with a
/// hemisphere at each end. `half` is the half length of the cylinder, m, without the hemispheres.
pub(super) fn capsule(radius: f64, half: f64) -> Mass {
    let cylinder = cylinder(radius, half);
    let ball = 4.0 / 3.0 * PI * radius.powi(3);
    let moment = 0.4 * ball * radius * radius;
    let side = moment + ball * half * (half + 0.75 * radius);
    cylinder.with(with_moments(ball, [side, side, moment]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrates a solid of revolution about z, with radius `radius_at(z)` for `|z| <= half`, over
    /// thin slices. Returns the mass and the moments of inertia about x and about z.
    fn sliced(radius_at: impl Fn(f64) -> f64, half: f64) -> (f64, f64, f64) {
        let count = 200_000;
        let step = 2.0 * half / f64::from(count);
        (0..count).fold((0.0, 0.0, 0.0), |(mass, side, axial), k| {
            let z = -half + (f64::from(k) + 0.5) * step;
            let square = radius_at(z).powi(2);
            let slice = PI * square * step;
            (mass + slice, side + slice * (square / 4.0 + z * z), axial + slice * square / 2.0)
        })
    }

    #[test]
    fn solids_of_revolution_agree_with_their_slices() {
        let (r, h): (f64, f64) = (0.3, 0.7);
        let cap = |z: f64| (r * r - (z.abs() - h).max(0.0).powi(2)).max(0.0).sqrt();
        let round = |z: f64| r * (1.0 - (z / h).powi(2)).max(0.0).sqrt();
        let cases = [
            (capsule(r, h), sliced(cap, h + r)),
            (cylinder(r, h), sliced(|_| r, h)),
            (ellipsoid([r, r, h]), sliced(round, h)),
        ];
        for (solid, (mass, side, axial)) in cases {
            let found = [solid.mass, solid.inertia.at(0, 0), solid.inertia.at(2, 2)];
            for (found, expected) in found.into_iter().zip([mass, side, axial]) {
                // A slice is 5e-6 of the length thick; the relative error is of the order of this
                // ratio squared.
                assert!((found - expected).abs() < 1e-8 * expected, "{found} {expected}");
            }
        }
        let cube = cuboid([0.5; 3]);
        assert!(
            (cube.mass - 1.0).abs() < 1e-15 && (cube.inertia.at(1, 1) - 1.0 / 6.0).abs() < 1e-15
        );
    }
}
