//! Traces of a motion: paths of bodies and strokes of sliding joints.

use super::layout::{Layout, is_off_ground, traced_of};
use super::placed::Placed;
use stiction_core::mechanism::Mechanism;
use stiction_core::spatial::{Pose, Vec3};

/// Largest number of stored points of a path.
const KEPT: usize = 600;

/// Trace of a motion: paths of the hubs, such as platforms, or, without hubs, of the bodies that
/// are not connected to the ground; and strokes of the sliding joints.
#[derive(Clone, Debug)]
pub struct Trail {
    bodies: Vec<Path>,
    slides: Vec<Slide>,
    samples: usize,
    stride: usize,
}

#[derive(Clone, Debug)]
struct Path {
    body: usize,
    /// Traced point in the body's frame, m.
    point: Vec3<f64>,
    points: Vec<Vec3<f64>>,
}

#[derive(Clone, Debug)]
struct Slide {
    joint: usize,
    least: f64,
    greatest: f64,
}

impl Trail {
    /// Starts the paths at the given poses of all bodies, the ground first. Traces the hubs or, if
    /// there are none, the bodies that are not connected to the ground.
    pub fn new(mechanism: &Mechanism, poses: &[Pose<f64>]) -> Self {
        let placed = Placed::new(mechanism, poses);
        let layout = Layout::new(&placed);
        let path = |(body, point)| Path { body, point, points: Vec::new() };
        let mut trail = Self {
            bodies: traced(&placed, &layout).into_iter().map(path).collect(),
            slides: slides(&placed),
            samples: 0,
            stride: 1,
        };
        trail.add(mechanism, poses);
        trail
    }

    /// Adds the next poses of all bodies to the paths.
    pub fn add(&mut self, mechanism: &Mechanism, poses: &[Pose<f64>]) {
        for slide in &mut self.slides {
            let value = slid(mechanism, poses, slide.joint);
            slide.least = slide.least.min(value);
            slide.greatest = slide.greatest.max(value);
        }
        if self.samples.is_multiple_of(self.stride) {
            for path in &mut self.bodies {
                path.points.push(poses[path.body].apply(path.point));
            }
            // If a path is full, only every second point is kept.
            if self.samples / self.stride >= KEPT {
                self.stride *= 2;
                for path in &mut self.bodies {
                    let mut keep = false;
                    path.points.retain(|_| {
                        keep = !keep;
                        keep
                    });
                }
            }
        }
        self.samples += 1;
    }

    /// Iterates over the paths of the traced bodies. A path is a list of points in world axes,
    /// relative to the common origin of the poses, m.
    pub(super) fn paths(&self) -> impl Iterator<Item = &[Vec3<f64>]> {
        self.bodies.iter().map(|path| path.points.as_slice())
    }

    /// Returns the least and the greatest displacement of a sliding joint in the motion, relative
    /// to its present position, m. `None` for other joints.
    pub(super) fn stroke(&self, placed: &Placed<'_>, joint: usize) -> Option<(f64, f64)> {
        let slide = self.slides.iter().find(|slide| slide.joint == joint)?;
        let now = slid(placed.mechanism, &placed.pose, joint);
        Some((slide.least - now, slide.greatest - now))
    }
}

/// Returns the indices of the traced bodies, each with its traced point in the frame of the body,
/// m. The traced bodies are the hubs or, without hubs, the bodies that are not connected to the
/// ground; if these are too many, see [`traced_of`], the list is empty.
pub(super) fn traced(placed: &Placed<'_>, layout: &Layout) -> Vec<(usize, Vec3<f64>)> {
    let off_ground = |body: &usize| is_off_ground(&layout.joints, *body);
    let traced = traced_of(layout.joints.len(), &[&|body| layout.hubs[*body], &off_ground]);
    let point = |body: usize| {
        let pose = placed.pose[body];
        let middle = layout.middle(body).unwrap_or(pose.position);
        (body, pose.inverse().apply(middle))
    };
    traced.into_iter().map(point).collect()
}

/// Returns the displacement between the two frames of a joint along the joint axis, m. For a
/// sliding joint, it equals the coordinate up to a constant.
fn slid(mechanism: &Mechanism, poses: &[Pose<f64>], joint: usize) -> f64 {
    let joint = &mechanism.joints()[joint];
    let frame_j = poses[joint.predecessor.0] * joint.frame_j;
    let frame_k = poses[joint.successor.0] * joint.frame_k;
    (frame_k.position - frame_j.position).dot(frame_j.rotation.columns[2])
}

fn slides(placed: &Placed<'_>) -> Vec<Slide> {
    let joints = placed.mechanism.joints().iter().enumerate();
    let slides = joints.filter(|(_, content)| {
        content.joint_type.dofs().iter().any(|dof| dof.translates() && dof.axis == 2)
    });
    let slide = |joint: usize| {
        let first = slid(placed.mechanism, &placed.pose, joint);
        Slide { joint, least: first, greatest: first }
    };
    slides.map(|(joint, _)| slide(joint)).collect()
}
