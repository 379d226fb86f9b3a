//! Points at which the arrows of external loads start in the animation of a report.

use stiction_core::spatial::{Pose, Vec3};
use stiction_format::LoadCase;

/// Largest distance of a point of application from the line of action of the load on its body,
/// relative to the distances between the points, at which the arrow starts at this point.
const ON_LINE: f64 = 1e-6;

/// Points of application of the external loads, for each body.
#[derive(Clone, Debug, Default)]
pub(crate) struct LoadPoints {
    /// Distinct points of application on each body, in its frame, m; the ground first.
    points: Vec<Vec<Vec3<f64>>>,
}

impl LoadPoints {
    /// Collects the points of application of a load case, including the centres of mass of its
    /// payloads. `bodies` is the number of bodies with the ground.
    pub(crate) fn new(load: &LoadCase, bodies: usize) -> Self {
        let mut points: Vec<Vec<Vec3<f64>>> = vec![Vec::new(); bodies];
        let wrenches = load.wrenches.iter().map(|load| (load.body, load.point));
        let laws = load.laws.iter().map(|load| (load.body, load.point));
        let payloads = load.payloads.iter().map(|load| (load.body, load.part.com));
        for (body, point) in wrenches.chain(laws).chain(payloads) {
            if let Some(own) = points.get_mut(body.0)
                && !own.contains(&point)
            {
                own.push(point);
            }
        }
        Self { points }
    }

    /// Returns the point, in the frame of the body, at which the arrow of the load on the body
    /// starts, m. `force` and `moment` are the resultant of all external loads on the body, the
    /// moment about the origin of its frame, both in world axes.
    ///
    /// If the loads have a common point of application, the arrow starts there. Otherwise, it
    /// starts on the line of action of the resultant: at the point of application on this line,
    /// or at the point of the line that is nearest to the mean of the points of application. If
    /// the line passes far from these points, because moments act on the body, the arrow starts at
    /// their mean.
    pub(crate) fn start(
        &self,
        body: usize,
        pose: &Pose<f64>,
        [force, moment]: [Vec3<f64>; 2],
    ) -> Vec3<f64> {
        let points = self.points.get(body).map_or(&[][..], Vec::as_slice);
        let (first, several) = match points {
            [] => return Vec3::zero(),
            [only] => return *only,
            [first, ..] => (*first, points),
        };
        let sum = several[1..].iter().fold(first, |sum, point| sum + *point);
        let mean = sum * (1.0 / several.len() as f64);
        let spread = several.iter().map(|point| (*point - mean).norm()).fold(0.0, f64::max);
        let squared = force.dot(force);
        if !(squared > 0.0 && squared.is_finite()) {
            return mean;
        }
        let force = pose.rotation.transpose_mul(force);
        let moment = pose.rotation.transpose_mul(moment);
        // Point of the central axis of the wrench nearest to the origin of the body's frame.
        let foot = force.cross(moment) * (1.0 / squared);
        let offset = |point: Vec3<f64>| {
            let from_foot = point - foot;
            from_foot - force * (from_foot.dot(force) / squared)
        };
        if let Some(on_line) = several.iter().find(|p| offset(**p).norm() <= ON_LINE * spread) {
            return *on_line;
        }
        let nearest = mean - offset(mean);
        if (nearest - mean).norm() <= spread { nearest } else { mean }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_core::spatial::Mat3;

    fn start(points: &[[f64; 3]], loads: &[([f64; 3], [f64; 3])]) -> [f64; 3] {
        let vector = |[x, y, z]: [f64; 3]| Vec3::new(x, y, z);
        let points = points.iter().map(|point| vector(*point)).collect();
        let pose = Pose { position: Vec3::new(5.0, 6.0, 7.0), rotation: Mat3::identity() };
        let (mut force, mut moment) = (Vec3::zero(), Vec3::zero());
        for (at, own) in loads {
            force += vector(*own);
            moment += vector(*at).cross(vector(*own));
        }
        LoadPoints { points: vec![points] }.start(0, &pose, [force, moment]).to_array()
    }

    #[test]
    fn an_arrow_starts_on_the_line_of_action_of_the_resultant() {
        let (left, right) = ([0.0, 1.0, 0.0], [2.0, 1.0, 0.0]);
        let down = [0.0, -4.0, 0.0];
        assert_eq!(start(&[right], &[(right, down)]), right);
        // Of two loads, only one acts.
        assert_eq!(start(&[left, right], &[(right, down)]), right);
        assert_eq!(start(&[left, right], &[(left, down)]), left);
        // The resultant of parallel forces divides the distance by their ratio.
        let both = start(&[left, right], &[(left, down), (right, [0.0, -12.0, 0.0])]);
        assert!((both[0] - 1.5).abs() < 1e-12 && (both[1] - 1.0).abs() < 1e-12, "{both:?}");
        // A moment moves the line of action far away.
        let far = start(&[left, right], &[([90.0, 0.0, 0.0], down)]);
        assert_eq!(far, [1.0, 1.0, 0.0]);
    }
}
