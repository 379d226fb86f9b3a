//! Springs between points of two bodies, drawn as zigzag lines.

use super::placed::Placed;
use super::sheet::Sheet;
use super::svg::{Point, circle, corners};
use crate::xml::escape;
use stiction_core::spatial::Vec3;

/// Number of corners of the zigzag line of a spring.
const CORNERS: usize = 10;
/// Part of the length of a spring that is straight at each end.
const STRAIGHT: f64 = 0.2;

/// Returns the ends of all springs in world axes, relative to the common origin of the poses, m.
pub(super) fn spring_ends(placed: &Placed<'_>) -> Vec<[Vec3<f64>; 2]> {
    let springs = placed.mechanism.springs().iter();
    springs.map(|s| [0, 1].map(|end| placed.pose[s.ends[end].0].apply(s.points[end]))).collect()
}

/// Draws a zigzag line between two points of the picture; `half` is its half width, px.
pub(super) fn zigzag(a: Point, b: Point, half: f64) -> String {
    let (x, y) = (b[0] - a[0], b[1] - a[1]);
    let length = x.hypot(y).max(1e-9);
    let at = |along: f64, across: f64| {
        let across = across * half / length;
        [a[0] + along * x - across * y, a[1] + along * y + across * x]
    };
    let mut points = vec![a, at(STRAIGHT, 0.0)];
    for k in 0..CORNERS {
        let along = STRAIGHT + (1.0 - 2.0 * STRAIGHT) * (k as f64 + 0.5) / CORNERS as f64;
        points.push(at(along, if k % 2 == 0 { 1.0 } else { -1.0 }));
    }
    points.extend([at(1.0 - STRAIGHT, 0.0), b]);
    corners("spring bar", &points, false)
}

impl Sheet<'_> {
    pub(super) fn draw_springs(&mut self) {
        let placed = &self.drawing.placed;
        let bodies = placed.mechanism.bodies();
        for (spring, [from, to]) in placed.mechanism.springs().iter().zip(spring_ends(placed)) {
            let (a, b) = (self.at(from), self.at(to));
            self.obstacles.add_line(a, b);
            let [from_body, to_body] = spring.ends.map(|body| bodies[body.0].name.as_str());
            let title = format!("{}: spring, {from_body} to {to_body}", spring.name);
            let ends = circle("com", a, 2.0) + &circle("com", b, 2.0);
            let part = format!(
                r#"<g class="elastic" data-name="{}"><title>{}</title>{}{ends}</g>"#,
                escape(&spring.name),
                escape(&title),
                zigzag(a, b, 0.8 * self.pen.size),
            );
            self.add(self.depth(from).max(self.depth(to)), part);
        }
    }
}
