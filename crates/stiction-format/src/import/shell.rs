//! Mass properties of thin shells of simple shape with 1 kg/m², centred at the origin, as MuJoCo
//! computes them for geoms with `shellinertia`.

use super::inertia::Mass;
use super::solid::with_moments;
use std::f64::consts::PI;

/// Computes the mass properties of a spherical shell of 1 kg/m² with this radius, m.
pub(super) fn sphere(radius: f64) -> Mass {
    let mass = 4.0 * PI * radius * radius;
    with_moments(mass, [2.0 / 3.0 * mass * radius * radius; 3])
}

/// Computes the mass properties of an ellipsoidal shell of 1 kg/m² with these half axes, m, by
/// MuJoCo's rules. The area follows Thomsen's approximation (accurate to 1.1 %). The mass
/// distribution is that of a thin solid layer between the ellipsoid and an ellipsoid whose half
/// axes are all longer by the same length.
pub(super) fn ellipsoid([a, b, c]: [f64; 3]) -> Mass {
    const EXPONENT: f64 = 1.6075;
    /// Difference between the half axes of the two ellipsoids, m. MuJoCo's value is used because
    /// the moments of inertia depend on it to first order.
    const LAYER: f64 = 1e-6;
    let sum = (a * b).powf(EXPONENT) + (b * c).powf(EXPONENT) + (c * a).powf(EXPONENT);
    let mass = 4.0 * PI * (sum / 3.0).powf(EXPONENT.recip());
    let inner = super::solid::ellipsoid([a, b, c]);
    let outer = super::solid::ellipsoid([a, b, c].map(|axis| axis + LAYER));
    let density = mass / (outer.mass - inner.mass);
    let moment = |k: usize| density * (outer.inertia.at(k, k) - inner.inertia.at(k, k));
    with_moments(mass, [moment(0), moment(1), moment(2)])
}

/// Computes the mass properties of the shell of a box, 1 kg/m², with half edges `half`, m, along x,
/// y and z.
pub(super) fn cuboid(half: [f64; 3]) -> Mass {
    let (mut mass, mut moments) = (0.0, [0.0; 3]);
    for across in 0..3 {
        let (u, v) = ((across + 1) % 3, (across + 2) % 3);
        let squares = half.map(|edge| edge * edge);
        // Mass of the two faces perpendicular to this axis.
        let faces = 8.0 * half[u] * half[v];
        mass += faces;
        moments[across] += faces * (squares[u] + squares[v]) / 3.0;
        moments[u] += faces * (squares[v] / 3.0 + squares[across]);
        moments[v] += faces * (squares[u] / 3.0 + squares[across]);
    }
    with_moments(mass, moments)
}

/// Computes the mass properties of the lateral surface of a cylinder about the z axis, 1 kg/m²,
/// without its end discs. The radius and the half length are in m.
fn wall(radius: f64, half: f64) -> Mass {
    let mass = 4.0 * PI * radius * half;
    let side = mass * (radius * radius / 2.0 + half * half / 3.0);
    with_moments(mass, [side, side, mass * radius * radius])
}

/// Computes the mass properties of a closed cylindrical shell about the z axis, for a mass per area
/// of 1 kg/m². The radius and the half length are in m.
pub(super) fn cylinder(radius: f64, half: f64) -> Mass {
    let ends = 2.0 * PI * radius * radius;
    let side = ends * (radius * radius / 4.0 + half * half);
    let ends = with_moments(ends, [side, side, ends * radius * radius / 2.0]);
    wall(radius, half).with(ends)
}

/// Computes the mass properties of the shell of a capsule, 1 kg/m²: a cylinder about the z axis
/// with a hemisphere at each end. `half` is the half length of the cylinder, m, without the
/// hemispheres.
pub(super) fn capsule(radius: f64, half: f64) -> Mass {
    let ball = sphere(radius);
    let axial = ball.inertia.at(2, 2);
    // The centre of mass of a hemispherical shell is half a radius away from its flat side.
    let side = axial + ball.mass * half * (half + radius);
    wall(radius, half).with(with_moments(ball.mass, [side, side, axial]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks masses and moments of inertia against the values that MuJoCo 4.0.0 computes for geoms
    /// with `shellinertia` and 1000 kg/m².
    #[test]
    fn shells_are_those_of_mujoco() {
        let cases = [
            (sphere(0.1), [125.663_706_143_591_74, 0.837_758_040_957_278, 0.837_758_040_957_278]),
            (cuboid([0.1, 0.2, 0.3]), [880.0, 54.133_333_333_333_34, 24.266_666_666_666_673]),
            (
                cylinder(0.1, 0.2),
                [314.159_265_358_979_3, 7.278_022_980_816_355, 2.827_433_388_230_814],
            ),
            (
                capsule(0.1, 0.2),
                [376.991_118_430_775_2, 12.985_249_634_837_814, 3.351_032_163_829_113],
            ),
            (
                ellipsoid([0.1, 0.2, 0.3]),
                [489.719_333_337_173_1, 18.075_174_882_542_342, 8.102_680_936_804_973],
            ),
        ];
        for (shell, expected) in cases {
            let found = [shell.mass, shell.inertia.at(0, 0), shell.inertia.at(2, 2)];
            for (found, expected) in found.into_iter().zip(expected) {
                // The tolerance allows for cancellation: the moments of the ellipsoidal layer are
                // differences of nearly equal numbers.
                let error = (1000.0 * found - expected).abs() / expected;
                assert!(error < 1e-9, "{found} {expected}");
            }
        }
    }
}
