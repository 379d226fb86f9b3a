//! Inertia tensors that MuJoCo accepts. MuJoCo rejects tensors that no mass distribution can have.

use nalgebra::{Matrix3, SymmetricEigen};
use stiction_core::mechanism::Body;
use stiction_core::spatial::Mat3;

/// Relative margin by which exported inertias satisfy MuJoCo's conditions, so that MuJoCo does not
/// reject the file because of rounding. Each moment of inertia is at least `SLACK` times the sum of
/// the largest moment and the mass times the squared characteristic length. The sum of the two
/// smaller moments exceeds the largest one by at least `SLACK` times the largest one.
const SLACK: f64 = 1e-9;
/// Least moment of inertia in the file, kg m^2; MuJoCo rejects moments below about 1e-14 kg m^2.
const LEAST: f64 = 1e-13;
/// Change of a moment of inertia, as a fraction of the largest moment, above which the file
/// contains a note on the change.
const NOTED: f64 = 1e-6;

/// Returns an inertia tensor that MuJoCo accepts, kg m^2, and true if it differs noticeably from
/// the tensor of the body. The smallest principal moments are increased until all moments are
/// positive and none exceeds the sum of the other two. `length` is the characteristic length, m,
/// and `parts` the number of parts into which the body is split.
pub(super) fn accepted(body: &Body, length: f64, parts: usize) -> (Mat3<f64>, bool) {
    let eigen = SymmetricEigen::new(Matrix3::from(body.inertia));
    let given = eigen.eigenvalues;
    let largest = given.max();
    let floor = (SLACK * (largest + body.mass * length * length)).max(LEAST * parts as f64);
    let mut moments = given.map(|moment| moment.max(floor));
    let top = moments.imax();
    // `lacks` is the amount by which the sum of the two other moments is too small. Each of the two
    // moments is increased by half of this amount. A planar model, which has a single moment, then
    // gets the inertia of a lamina.
    let lacks = moments[top] * (2.0 + SLACK) - moments.sum();
    if lacks > 0.0 {
        for k in (0..3).filter(|k| *k != top) {
            moments[k] += 0.5 * lacks;
        }
    }
    let more = moments - given;
    if more.amax() == 0.0 {
        return (body.inertia, false);
    }
    let axes = &eigen.eigenvectors;
    let added = axes * Matrix3::from_diagonal(&more) * axes.transpose();
    let inertia = body.inertia + Mat3::from(0.5 * (added + added.transpose()));
    (inertia, more.amax() > NOTED * largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_core::spatial::Vec3;

    fn body(mass: f64, moments: [f64; 3], turn: f64) -> Body {
        let rotation = Mat3::rotation(Vec3::new(1.0, -2.0, 0.5), turn);
        let inertia = rotation * Mat3::diagonal(Vec3::from(moments)) * rotation.transpose();
        Body { name: "b".into(), mass, com: Vec3::zero(), inertia }
    }

    #[test]
    fn only_what_is_missing_is_added() {
        for turn in [0.0, 0.7] {
            // An inertia that is physically possible stays unchanged to the last digit.
            let whole = body(1.0, [1.0, 1.5, 2.0], turn);
            assert_eq!(accepted(&whole, 1.0, 2), (whole.inertia, false));
            // A single moment becomes the inertia of a lamina.
            let (planar, changed) = accepted(&body(1.0, [0.0, 0.0, 2.0], turn), 1.0, 2);
            let expected = body(1.0, [1.0, 1.0, 2.0], turn).inertia;
            assert!(changed && differ(planar, expected) < 1e-8);
            // The zero moment of a thin rod becomes slightly positive.
            let rod = body(1.0, [0.0, 3.0, 3.0], turn);
            let (raised, changed) = accepted(&rod, 1.0, 2);
            assert!(!changed && differ(raised, rod.inertia) < 1e-8);
            // All moments of a point mass become slightly positive.
            let (point, _) = accepted(&body(2.0, [0.0; 3], turn), 0.5, 1);
            assert!(differ(point, Mat3::zero()) < 1e-8);
            for inertia in [planar, raised, point] {
                let mut moments = SymmetricEigen::new(Matrix3::from(inertia)).eigenvalues;
                moments.as_mut_slice().sort_by(f64::total_cmp);
                assert!(moments[0] > 1e-14 && moments[0] + moments[1] > moments[2]);
            }
        }
    }

    fn differ(a: Mat3<f64>, b: Mat3<f64>) -> f64 {
        (0..9).map(|k| (a.at(k / 3, k % 3) - b.at(k / 3, k % 3)).abs()).fold(0.0, f64::max)
    }
}
