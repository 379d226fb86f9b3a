//! Directions of view.

use super::hull::{hull, is_within};
use super::layout::Layout;
use super::placed::Placed;
use stiction_core::joint::JointType;
use stiction_core::spatial::Vec3;

/// Direction of view of a picture without perspective: lengths perpendicular to this direction are
/// true.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Direction to the right in the picture, a unit vector in world axes.
    pub right: Vec3<f64>,
    /// Upward direction in the picture, a unit vector in world axes.
    pub up: Vec3<f64>,
    /// Direction out of the picture, towards the viewer, a unit vector in world axes.
    pub toward: Vec3<f64>,
}

impl View {
    /// View from the direction `toward` (not zero), with `up` as far upwards as possible.
    pub fn from(toward: Vec3<f64>, up: Vec3<f64>) -> Self {
        let toward = toward.direction().unwrap_or(Vec3::unit(2));
        let up = up.across(toward);
        // If both are parallel, only the rounding error of `up` remains.
        let upright = up.direction().filter(|_| up.norm() > 1e-6);
        let up = upright.unwrap_or_else(|| toward.any_perpendicular());
        Self { right: up.cross(toward), up, toward }
    }

    /// Front view: x to the right, z upwards.
    pub fn front() -> Self {
        Self::from(-Vec3::unit(1), Vec3::unit(2))
    }

    /// View from the right side: y to the right, z upwards.
    pub fn side() -> Self {
        Self::from(Vec3::unit(0), Vec3::unit(2))
    }

    /// View from above: x to the right, y upwards.
    pub fn top() -> Self {
        Self::from(Vec3::unit(2), Vec3::unit(1))
    }

    /// Returns the words for a view along a world axis; `None` for any other direction.
    pub fn words(&self) -> Option<&'static str> {
        let known = [
            (-Vec3::unit(1), "from the front, along y"),
            (Vec3::unit(1), "from behind, against y"),
            (Vec3::unit(0), "from the right, against x"),
            (-Vec3::unit(0), "from the left, along x"),
            (Vec3::unit(2), "from above, against z"),
            (-Vec3::unit(2), "from below, along z"),
        ];
        let is_along = |direction: &Vec3<f64>| (*direction - self.toward).norm() < NONE;
        known.into_iter().find(|(direction, _)| is_along(direction)).map(|(_, words)| words)
    }

    /// Projects a point; returns its coordinates to the right and downwards, as on a screen, m.
    pub(super) fn project(&self, point: Vec3<f64>) -> [f64; 2] {
        [self.right.dot(point), -self.up.dot(point)]
    }

    /// Returns the depth of a point, m, positive towards the viewer.
    pub(super) fn depth(&self, point: Vec3<f64>) -> f64 {
        self.toward.dot(point)
    }
}

/// Threshold below which components of unit vectors count as zero.
const NONE: f64 = 1e-6;

/// Returns the normal of the plane of motion, a unit vector in world axes, if the joints permit
/// only planar motion: axes of rotation are parallel to the normal, and directions of sliding are
/// perpendicular to it. Universal and spherical joints are accepted if all joints lie in one plane.
pub(super) fn plane_normal(placed: &Placed<'_>, layout: &Layout) -> Option<Vec3<f64>> {
    let joints = placed.mechanism.joints();
    let frames = &placed.frame_j;
    let axis = |joint: usize| frames[joint].rotation.columns[2];
    let turns = |kind| matches!(kind, JointType::Revolute | JointType::Planar);
    let normal = axis(joints.iter().position(|joint| turns(joint.joint_type))?);
    let along = |axis: Vec3<f64>| axis.across(normal).norm() < NONE;
    let across = |axis: Vec3<f64>| axis.dot(normal).abs() < NONE;
    let mut needs_places = false;
    for (index, joint) in joints.iter().enumerate() {
        let fits = match joint.joint_type {
            JointType::Revolute | JointType::Planar => along(axis(index)),
            JointType::Prismatic => across(axis(index)),
            JointType::Cylindrical => along(axis(index)) || across(axis(index)),
            JointType::Helical => false,
            JointType::Universal | JointType::Spherical => {
                needs_places = true;
                true
            }
            JointType::Fixed | JointType::Free => true,
        };
        if !fits {
            return None;
        }
    }
    let heights = || layout.places.iter().map(|place| place.dot(normal));
    let spread = heights().fold(f64::MIN, f64::max) - heights().fold(f64::MAX, f64::min);
    let length = placed.mechanism.characteristic_length();
    (!needs_places || spread < NONE * length).then_some(normal)
}

/// Returns the upward direction of pictures, a unit vector in world axes: against gravity, or along
/// z without gravity.
pub(super) fn upwards(placed: &Placed<'_>) -> Vec3<f64> {
    (-placed.mechanism.gravity()).direction().unwrap_or(Vec3::unit(2))
}

/// Face-on view of a planar mechanism, with as many world axes as possible pointing to the right
/// and upwards.
pub(super) fn face_on(placed: &Placed<'_>, normal: Vec3<f64>) -> View {
    let up = upwards(placed).across(normal);
    let up = up.direction().filter(|_| up.norm() > NONE).unwrap_or_else(|| {
        let lying = Vec3::unit(1).across(normal);
        if lying.norm() > 0.5 { lying } else { Vec3::unit(2) }
    });
    let (one, other) = (View::from(normal, up), View::from(-normal, up));
    let rightwards = |view: &View| view.right.x + view.right.y + view.right.z;
    if rightwards(&one) >= rightwards(&other) { one } else { other }
}

/// View from the upper right front, rotated so that joints hide each other as little as possible.
pub(super) fn axonometric(placed: &Placed<'_>, layout: &Layout) -> View {
    let up = upwards(placed);
    let ahead = Vec3::unit(0).across(up);
    let ahead = ahead.direction().filter(|_| ahead.norm() > 0.1);
    let ahead = ahead.unwrap_or_else(|| up.any_perpendicular());
    let left = up.cross(ahead);
    let mut best: Option<(f64, View)> = None;
    for elevation in [20.0_f64, 26.0, 32.0] {
        for azimuth in (-72..=-18).step_by(3).map(f64::from) {
            let (s, c) = azimuth.to_radians().sin_cos();
            let (rise, flat) = elevation.to_radians().sin_cos();
            let view = View::from((ahead * c + left * s) * flat + up * rise, up);
            let clear = clearance(&view, &layout.places) / (1.0 + 0.2 * hidden(&view, layout));
            // The default direction is kept unless another one is clearly better.
            let usual = (azimuth + 52.0).abs() / 60.0 + (elevation - 26.0).abs() / 40.0;
            let score = clear * (1.0 - 0.25 * usual);
            if best.as_ref().is_none_or(|(known, _)| score > *known) {
                best = Some((score, view));
            }
        }
    }
    best.map_or_else(View::front, |(_, view)| view)
}

/// Counts the joints that lie behind or in front of a platform to which they do not belong.
fn hidden(view: &View, layout: &Layout) -> f64 {
    // Coordinates are scaled so that the hull distinguishes neighbouring corners.
    let seen: Vec<[f64; 2]> = layout.places.iter().map(|place| view.project(*place)).collect();
    let size = seen.iter().flatten().map(|c| c.abs()).fold(0.0, f64::max);
    if size == 0.0 {
        return 0.0;
    }
    let seen: Vec<[f64; 2]> = seen.iter().map(|p| p.map(|c| 1e3 * c / size)).collect();
    let platforms = (1..layout.joints.len()).filter(|&body| layout.hubs[body]);
    let count = |body: usize| {
        let own = &layout.joints[body];
        let outline = hull(own.iter().map(|&joint| seen[joint]).collect());
        let others = (0..seen.len()).filter(|joint| !own.contains(joint));
        others.filter(|&joint| is_within(&outline, seen[joint])).count()
    };
    platforms.map(count).sum::<usize>() as f64
}

/// Returns the apparent thickness of the mechanism, relative to its apparent length: zero if all
/// joints lie on a line in the picture.
pub(super) fn thickness(view: &View, layout: &Layout) -> f64 {
    let points: Vec<[f64; 2]> = layout.places.iter().map(|place| view.project(*place)).collect();
    let count = points.len().max(1) as f64;
    let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / count;
    let middle = [mean(0), mean(1)];
    let moment = |i: usize, j: usize| {
        points.iter().map(|p| (p[i] - middle[i]) * (p[j] - middle[j])).sum::<f64>()
    };
    let (xx, yy, xy) = (moment(0, 0), moment(1, 1), moment(0, 1));
    let spread = (0.5 * (xx - yy)).hypot(xy);
    let (large, small) = (0.5 * (xx + yy) + spread, 0.5 * (xx + yy) - spread);
    if large > 0.0 { (small.max(0.0) / large).sqrt() } else { 0.0 }
}

/// Measures the separation of joints in the picture, relative to the size of the mechanism; the
/// closest pairs have the greatest weight.
fn clearance(view: &View, places: &[Vec3<f64>]) -> f64 {
    let mut sum = 0.0;
    let mut count = 0.0;
    let mut size = 0.0_f64;
    // If there are hundreds of joints, only a subset is compared.
    let stride = places.len().div_ceil(60).max(1);
    let some: Vec<Vec3<f64>> = places.iter().step_by(stride).copied().collect();
    for (k, a) in some.iter().enumerate() {
        for b in &some[..k] {
            size = size.max((*a - *b).norm());
        }
    }
    for (k, a) in some.iter().enumerate() {
        for b in &some[..k] {
            let apart = *a - *b;
            if apart.norm() > 1e-3 * size {
                let [x, y] = view.project(apart);
                // Joints above each other are penalised as well, because most legs are upright.
                sum += (x.hypot(y) / size + 0.02).powi(-2) + 0.1 * (x.abs() / size + 0.03).powi(-2);
                count += 1.0;
            }
        }
    }
    if sum > 0.0 { (count / sum).sqrt() } else { 1.0 }
}
