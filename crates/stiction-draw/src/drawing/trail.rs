//! Traces of a motion: paths of bodies and strokes of slides.

use super::layout::Layout;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::mechanism::JointId;
use stiction_core::spatial::Vec3;

/// Largest number of points of a path.
const KEPT: usize = 600;
/// Largest number of traced bodies.
const TRACED: usize = 4;

/// Paths of the hubs, or of coupler bodies, and strokes of slides.
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
    dof: usize,
    least: f64,
    greatest: f64,
}

impl Trail {
    /// Starts at the solver's current pose; traces the hubs, or without hubs the bodies not
    /// connected to the ground.
    pub fn new(solver: &InverseDynamics) -> Self {
        let layout = Layout::new(solver);
        let bodies = layout.joints.len();
        let hubs: Vec<usize> = (1..bodies).filter(|&body| layout.hubs[body]).collect();
        let off_ground = |body: &usize| {
            layout.joints[*body].iter().all(|joint| !layout.joints[0].contains(joint))
        };
        let traced = if hubs.is_empty() { (1..bodies).filter(off_ground).collect() } else { hubs };
        let path = |body: usize| {
            let pose = solver.bodies().pose[body];
            let middle = layout.middle(body).unwrap_or(pose.position);
            Path { body, point: pose.inverse().apply(middle), points: Vec::new() }
        };
        let bodies = if traced.len() > TRACED { Vec::new() } else { traced };
        let mut trail = Self {
            bodies: bodies.into_iter().map(path).collect(),
            slides: slides(solver),
            samples: 0,
            stride: 1,
        };
        trail.add(solver);
        trail
    }

    /// Adds the solver's current pose.
    pub fn add(&mut self, solver: &InverseDynamics) {
        for slide in &mut self.slides {
            let value = solver.joint_coordinates(JointId(slide.joint))[slide.dof];
            slide.least = slide.least.min(value);
            slide.greatest = slide.greatest.max(value);
        }
        if self.samples.is_multiple_of(self.stride) {
            for path in &mut self.bodies {
                path.points.push(solver.bodies().pose[path.body].apply(path.point));
            }
            // A full path keeps every second point only.
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

    /// Paths relative to the reference point of the kernel, world axes, m.
    pub(super) fn paths(&self) -> impl Iterator<Item = &[Vec3<f64>]> {
        self.bodies.iter().map(|path| path.points.as_slice())
    }

    /// Backward and forward stroke of a slide from its present position, m.
    pub(super) fn stroke(&self, solver: &InverseDynamics, joint: usize) -> Option<(f64, f64)> {
        let slide = self.slides.iter().find(|slide| slide.joint == joint)?;
        let now = *solver.joint_coordinates(JointId(joint)).get(slide.dof)?;
        Some((slide.least - now, slide.greatest - now))
    }
}

fn slides(solver: &InverseDynamics) -> Vec<Slide> {
    let mut slides = Vec::new();
    for (joint, content) in solver.mechanism().joints().iter().enumerate() {
        let dofs = content.joint_type.dofs();
        let along = dofs.iter().position(|f| f.translates() && f.axis == 2);
        let coordinates = solver.joint_coordinates(JointId(joint));
        if let Some(dof) = along
            && let Some(&first) = coordinates.get(dof)
        {
            slides.push(Slide { joint, dof, least: first, greatest: first });
        }
    }
    slides
}
