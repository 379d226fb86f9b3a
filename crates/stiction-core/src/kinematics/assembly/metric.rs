//! Distances between configurations, as root-mean-square displacements of the bodies.

use super::super::bodies::Bodies;
use super::search::SAME_MODE;
use crate::spatial::{Mat3, Pose, Quaternion, Vec3};

/// Metric on configurations; it ignores motions in local (passive) degrees of freedom.
pub(super) struct Metric<'a> {
    /// Characteristic length, m.
    pub(super) length: f64,
    /// Centres of mass of the bodies, in the body frames, m.
    pub(super) com: &'a [Vec3<f64>],
    /// Axis of each body's local degree of freedom, which passes through the centre of mass, in the
    /// body frame; `None` for a body without a local degree of freedom.
    pub(super) spin_axes: Vec<Option<Vec3<f64>>>,
}

/// Computes the displacement of a body between two poses, divided by the characteristic length. The
/// distance between the origins and the rotation angle times the characteristic length are combined
/// as orthogonal components.
pub(super) fn displacement(a: &Pose<f64>, b: &Pose<f64>, length: f64) -> f64 {
    let apart = a.inverse() * *b;
    (apart.position.norm() / length).hypot(apart.rotation.rotation_vector().norm())
}

/// Computes the root mean square of the numbers; `None` for an empty iterator.
pub(super) fn rms(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = numbers.fold((0.0, 0), |(sum, count), x| (sum + x * x, count + 1));
    (count > 0).then(|| (sum / f64::from(count)).sqrt())
}

impl Metric<'_> {
    /// Computes the displacement of a body between two poses, m and rad. For a body with a local
    /// degree of freedom, these are the displacement of the centre of mass and the angle between
    /// the axes of that degree of freedom.
    pub(super) fn parts(&self, body: usize, a: &Pose<f64>, b: &Pose<f64>) -> (f64, f64) {
        match self.spin_axes[body] {
            None => {
                let apart = a.inverse() * *b;
                (apart.position.norm(), apart.rotation.rotation_vector().norm())
            }
            Some(axis) => {
                let moved = b.apply(self.com[body]) - a.apply(self.com[body]);
                let (from, to) = (a.rotation * axis, b.rotation * axis);
                (moved.norm(), from.cross(to).norm().atan2(from.dot(to)))
            }
        }
    }

    /// Computes the displacement of a body between two poses, divided by the characteristic length.
    pub(super) fn displacement(&self, body: usize, a: &Pose<f64>, b: &Pose<f64>) -> f64 {
        let (moved, turned) = self.parts(body, a, b);
        (moved / self.length).hypot(turned)
    }

    /// Computes the root mean square of [`Self::displacement`] over all bodies between two
    /// configurations.
    pub(super) fn between(&self, a: &Bodies<f64>, b: &Bodies<f64>) -> f64 {
        let pairs = a.pose.iter().zip(&b.pose).enumerate().skip(1);
        rms(pairs.map(|(body, (a, b))| self.displacement(body, a, b))).unwrap_or(0.0)
    }

    /// Returns `true` if the position of a centre of mass or of a joint differs between two
    /// configurations by more than [`SAME_MODE`].
    pub(super) fn is_shape_other(&self, a: &Bodies<f64>, b: &Bodies<f64>) -> bool {
        let centres = |bodies: &Bodies<f64>| -> Vec<Vec3<f64>> {
            let com = bodies.pose.iter().zip(self.com).map(|(pose, com)| pose.apply(*com));
            let joints = bodies.frame_j.iter().chain(&bodies.frame_k).map(|frame| frame.position);
            com.chain(joints).collect()
        };
        let mut pairs = centres(a).into_iter().zip(centres(b));
        pairs.any(|(a, b)| (b - a).norm() > SAME_MODE * self.length)
    }

    /// Rotates the pose `found` about the axis of the body's local degree of freedom, to the angle
    /// at which it is closest to the pose `given`. Returns `None` for a body without a local degree
    /// of freedom.
    pub(super) fn turned(
        &self,
        body: usize,
        given: &Pose<f64>,
        found: &Pose<f64>,
    ) -> Option<Pose<f64>> {
        let axis = self.spin_axes[body]?;
        let apart = Quaternion::from_rotation((found.inverse() * *given).rotation);
        let along = apart.v.dot(axis);
        let angle = 2.0 * along.atan2(apart.w);
        let rotation = found.rotation * Mat3::rotation(axis, angle);
        let com = self.com[body];
        Some(Pose { position: found.apply(com) - rotation * com, rotation })
    }
}
