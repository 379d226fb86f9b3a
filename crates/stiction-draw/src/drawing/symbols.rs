//! Symbols of joints, drawn as solids seen in the direction of view.

use super::svg::{Point, circle, corners, line, path, px};
use super::view::View;
use stiction_core::joint::JointType;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Drawing tool for symbols of joints in one direction of view; sizes in px.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pen {
    pub(super) view: View,
    /// Radius of a pin, px; all other sizes of the symbols are proportional to this radius.
    pub(super) size: f64,
}

/// CSS classes of the faces of a joint symbol: `bright` for the end of a cylinder and for the face
/// of a box that is turned most towards the viewer, `dim` for all other faces.
struct Faces {
    bright: &'static str,
    dim: &'static str,
}

const PLAIN: Faces = Faces { bright: "joint-face", dim: "joint-side" };
const DRIVEN: Faces = Faces { bright: "drive-face", dim: "drive-side" };

impl Pen {
    /// Returns the end of a projected line in the picture. The line begins at `from` and has the
    /// length `length`, px, before projection, along `direction`, a unit vector in world axes.
    pub(super) fn go(&self, from: Point, direction: Vec3<f64>, length: f64) -> Point {
        let [x, y] = self.view.project(direction);
        [from[0] + x * length, from[1] + y * length]
    }

    /// Largest distance from the centre to a part of a symbol, including its axes, px.
    pub(super) fn reach(&self, kind: JointType) -> f64 {
        let radii = match kind {
            JointType::Cylindrical | JointType::Helical => 5.2,
            JointType::Prismatic => 4.8,
            _ => 3.6,
        };
        radii * self.size
    }

    /// Half the width of a symbol in a legend, px.
    pub(super) fn sample_half(&self, kind: JointType, planar: bool) -> f64 {
        let radii = match kind {
            JointType::Prismatic => 4.6,
            JointType::Cylindrical | JointType::Helical => 4.8,
            JointType::Revolute if planar => 1.3,
            JointType::Revolute | JointType::Universal => 3.3,
            JointType::Planar => 2.8,
            _ => 1.3,
        };
        radii * self.size
    }

    /// Draws the symbol of a joint at the point `at`; `frame_j` and `frame_k` are the joint's
    /// frames in world axes.
    pub(super) fn joint(
        &self,
        kind: JointType,
        driven: bool,
        at: Point,
        frame_j: &Pose<f64>,
        frame_k: &Pose<f64>,
    ) -> String {
        let r = self.size;
        let axes = frame_j.rotation;
        let axis = axes.columns[2];
        let faces = if driven { DRIVEN } else { PLAIN };
        match kind {
            JointType::Revolute => {
                self.dashed(at, axis, 3.4 * r) + &self.cylinder(&faces, at, axis, 1.9 * r, r)
            }
            JointType::Prismatic => {
                let length = 4.2 * r;
                self.dashed(at, axis, 1.1 * length) + &self.slide_box(&faces, at, axis, length, r)
            }
            JointType::Cylindrical => {
                // Rod that protrudes from a sleeve.
                let (a, b) = (self.go(at, axis, -3.4 * r), self.go(at, axis, 3.4 * r));
                self.dashed(at, axis, 5.0 * r)
                    + &line("rod", a, b)
                    + &self.cylinder(&faces, at, axis, 3.2 * r, 0.9 * r)
            }
            JointType::Helical => {
                self.dashed(at, axis, 5.0 * r)
                    + &self.cylinder(&faces, at, axis, 3.6 * r, 0.9 * r)
                    + &self.thread(at, axis, 3.6 * r, 0.9 * r)
            }
            JointType::Universal => self.cross(&faces, at, axis, frame_k.rotation.columns[0]),
            JointType::Spherical => {
                let glint = [at[0] - 0.35 * r, at[1] - 0.35 * r];
                circle(faces.bright, at, 1.05 * r) + &circle("glint", glint, 0.28 * r)
            }
            JointType::Planar => self.plate(&faces, at, axes),
            JointType::Fixed => {
                let h = 0.55 * r;
                let square = [[-h, -h], [h, -h], [h, h], [-h, h]];
                corners("weld", &square.map(|[x, y]| [at[0] + x, at[1] + y]), true)
            }
            JointType::Free => circle("free", at, 1.2 * r),
        }
    }

    /// Draws a dashed line along an axis to both sides of a point; empty if the axis points towards
    /// the viewer.
    fn dashed(&self, at: Point, axis: Vec3<f64>, reach: f64) -> String {
        let (a, b) = (self.go(at, axis, -reach), self.go(at, axis, reach));
        if (a[0] - b[0]).hypot(a[1] - b[1]) < 2.4 * self.size {
            return String::new();
        }
        line("axis", a, b)
    }

    /// Returns the axis, reversed if it points away from the viewer.
    fn facing(&self, axis: Vec3<f64>) -> Vec3<f64> {
        if self.view.depth(axis) < 0.0 { -axis } else { axis }
    }

    fn cylinder(&self, faces: &Faces, at: Point, axis: Vec3<f64>, length: f64, r: f64) -> String {
        let axis = self.facing(axis);
        let [x, y] = self.view.project(axis);
        let across = x.hypot(y);
        let flat = self.view.depth(axis).clamp(0.0, 1.0);
        if across < 0.02 {
            // Seen along its axis, the cylinder is a pin.
            return circle(faces.bright, at, r) + &circle("pin", at, 0.28 * r);
        }
        let side = [-y / across * r, x / across * r];
        let (far, near) = (self.go(at, axis, -0.5 * length), self.go(at, axis, 0.5 * length));
        let tilt = y.atan2(x).to_degrees() + 90.0;
        let arc = |to: Point, sweep: u8| {
            // Seen from the side, the ends are lines; some programs reject such flat arcs.
            if flat * r < 0.3 {
                return format!("L{} {}", px(to[0]), px(to[1]));
            }
            let (wide, high, tilt) = (px(r), px(r * flat), px(tilt));
            format!("A{wide} {high} {tilt} 0 {sweep} {} {}", px(to[0]), px(to[1]))
        };
        let edge = |end: Point, sign: f64| [end[0] + sign * side[0], end[1] + sign * side[1]];
        let point = |p: Point| format!("{} {}", px(p[0]), px(p[1]));
        let (near_a, near_b) = (edge(near, 1.0), edge(near, -1.0));
        let (far_a, far_b) = (edge(far, 1.0), edge(far, -1.0));
        let barrel = format!(
            "M{}L{}{}L{}{}Z",
            point(near_a),
            point(far_a),
            arc(far_b, 1),
            point(near_b),
            arc(near_a, 1)
        );
        let end = format!("M{}{}{}Z", point(near_a), arc(near_b, 1), arc(near_a, 1));
        path(faces.dim, &barrel) + &path(faces.bright, &end)
    }

    /// Draws the turns of a screw thread on a cylinder.
    fn thread(&self, at: Point, axis: Vec3<f64>, length: f64, r: f64) -> String {
        let [x, y] = self.view.project(axis);
        let across = x.hypot(y);
        if across < 0.02 {
            return String::new();
        }
        let side = [-y / across * r, x / across * r];
        let turn = |k: i32| {
            let (a, b) = (f64::from(k) / 6.0 - 0.07, f64::from(k) / 6.0 + 0.07);
            let (a, b) = (self.go(at, axis, a * length), self.go(at, axis, b * length));
            line("detail", [a[0] - side[0], a[1] - side[1]], [b[0] + side[0], b[1] + side[1]])
        };
        (-2..=2).map(turn).collect()
    }

    /// Draws a box with its length along an axis, rotated so that one of its faces looks towards
    /// the viewer.
    fn slide_box(&self, faces: &Faces, at: Point, axis: Vec3<f64>, length: f64, r: f64) -> String {
        let level = axis.cross(self.view.toward).direction();
        let level = level.unwrap_or_else(|| axis.any_perpendicular());
        let axes = Mat3::from_columns(axis, level, axis.cross(level));
        self.block(faces, at, axes, [0.5 * length, 1.15 * r, 1.15 * r])
    }

    fn plate(&self, faces: &Faces, at: Point, axes: Mat3<f64>) -> String {
        let r = self.size;
        let arm = |axis: Vec3<f64>| {
            line("detail", self.go(at, axis, -1.4 * r), self.go(at, axis, 1.4 * r))
        };
        let plate = self.block(faces, at, axes, [2.1 * r, 2.1 * r, 0.3 * r]);
        plate + &arm(axes.columns[0]) + &arm(axes.columns[1])
    }

    /// Draws the visible faces of a box with the centre `at` and the half lengths `half`, px, along
    /// `axes`.
    fn block(&self, faces: &Faces, at: Point, axes: Mat3<f64>, half: [f64; 3]) -> String {
        let mut drawn = String::new();
        let mut visible: Vec<(f64, usize, f64)> = (0..3)
            .map(|k| {
                let turned = self.view.depth(axes.columns[k]);
                (turned.abs(), k, turned.signum())
            })
            .filter(|(turned, ..)| *turned > 0.02)
            .collect();
        visible.sort_by(|a, b| a.0.total_cmp(&b.0));
        let brightest = visible.len().saturating_sub(1);
        for (order, &(_, k, sign)) in visible.iter().enumerate() {
            let centre = self.go(at, axes.columns[k], sign * half[k]);
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let corner = |a: f64, b: f64| {
                self.go(self.go(centre, axes.columns[i], a * half[i]), axes.columns[j], b * half[j])
            };
            let face = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            let class = if order == brightest { faces.bright } else { faces.dim };
            drawn += &corners(class, &face, true);
        }
        drawn
    }

    /// Draws the cross of a universal joint: two pins along the unit vectors `first` and `second`.
    fn cross(&self, faces: &Faces, at: Point, first: Vec3<f64>, second: Vec3<f64>) -> String {
        let r = self.size;
        let mut drawn = self.dashed(at, first, 3.3 * r) + &self.dashed(at, second, 3.3 * r);
        // The pin that points more towards the viewer is drawn above the other.
        let mut pins = [first, second];
        pins.sort_by(|a, b| self.view.depth(*a).abs().total_cmp(&self.view.depth(*b).abs()));
        for pin in pins {
            drawn += &self.cylinder(faces, at, pin, 3.3 * r, 0.55 * r);
        }
        drawn
    }
}

/// Returns the orientation of a joint's frame in which its symbol is easy to recognise, for
/// legends.
pub(super) fn sample_frame(view: &View, kind: JointType, planar: bool) -> Pose<f64> {
    let View { right, up, toward } = *view;
    let slides = matches!(kind, JointType::Prismatic | JointType::Cylindrical | JointType::Helical);
    let axis = match (planar, slides, kind) {
        (true, false, _) => toward,
        (true, true, _) => right,
        (false, _, JointType::Planar) => up * 0.8 + toward * 0.6,
        (false, ..) => right * 0.9 + up * 0.14 + toward * 0.42,
    };
    let axis = axis.direction().unwrap_or(toward);
    let x = (up * 0.8 + toward * 0.6).across(axis).direction();
    let x = x.unwrap_or_else(|| axis.any_perpendicular());
    Pose { rotation: Mat3::from_columns(x, axis.cross(x), axis), position: Vec3::zero() }
}

/// Returns the name of a joint type in words.
pub(super) fn word(kind: JointType) -> &'static str {
    match kind {
        JointType::Revolute => "revolute",
        JointType::Prismatic => "prismatic",
        JointType::Helical => "helical",
        JointType::Cylindrical => "cylindrical",
        JointType::Universal => "universal",
        JointType::Spherical => "spherical",
        JointType::Planar => "planar",
        JointType::Fixed => "fixed",
        JointType::Free => "free",
    }
}
