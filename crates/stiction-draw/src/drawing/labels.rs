//! Placement of labels one after the other, each at the position where it hides the least of the
//! drawing.

use super::svg::{Anchor, Point, line, px, text, width_of};

/// Font size of labels, px.
pub(super) const LETTERS: f64 = 14.0;
/// Largest number of characters in a label; longer names are shortened, and the title of the symbol
/// contains the complete name.
const LONGEST: usize = 26;

/// Axis-aligned box in the picture, px.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub(super) least: Point,
    pub(super) greatest: Point,
}

impl Area {
    pub(super) fn empty() -> Self {
        Self { least: [f64::INFINITY; 2], greatest: [f64::NEG_INFINITY; 2] }
    }

    pub(super) fn around(centre: Point, half: Point) -> Self {
        Self {
            least: [centre[0] - half[0], centre[1] - half[1]],
            greatest: [centre[0] + half[0], centre[1] + half[1]],
        }
    }

    pub(super) fn include(&mut self, other: &Self) {
        for k in 0..2 {
            self.least[k] = self.least[k].min(other.least[k]);
            self.greatest[k] = self.greatest[k].max(other.greatest[k]);
        }
    }

    fn overlap(&self, other: &Self) -> f64 {
        let along = |k: usize| {
            (self.greatest[k].min(other.greatest[k]) - self.least[k].max(other.least[k])).max(0.0)
        };
        along(0) * along(1)
    }

    /// Returns true if a point is in the box or within a margin around it.
    fn holds(&self, point: Point, margin: f64) -> bool {
        (0..2).all(|k| self.least[k] - margin <= point[k] && point[k] <= self.greatest[k] + margin)
    }
}

/// Text to be placed near a point of the picture.
#[derive(Clone, Debug)]
pub(super) struct Label {
    /// Labelled point, px.
    pub(super) at: Point,
    /// Radius around the point that the label must not cover, px.
    pub(super) radius: f64,
    pub(super) class: String,
    pub(super) content: String,
    /// True if the label may cover the labelled point.
    pub(super) inside: bool,
}

/// Parts of the picture that labels should not cover. Coordinates are in px.
#[derive(Clone, Debug, Default)]
pub(super) struct Obstacles {
    /// Boxes of the symbols and of the labels that are already placed.
    pub(super) areas: Vec<Area>,
    /// Points along all lines that labels should not cover.
    pub(super) points: Vec<Point>,
}

impl Obstacles {
    /// Adds a line segment from `a` to `b` as an obstacle.
    pub(super) fn add_line(&mut self, a: Point, b: Point) {
        let count = ((a[0] - b[0]).hypot(a[1] - b[1]) / 6.0).ceil().clamp(1.0, 400.0);
        for k in 0..=count as usize {
            let t = k as f64 / count;
            self.points.push([a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]);
        }
    }
}

/// Places labels in the given order; returns their SVG markup and the area that they cover.
/// Positions away from `middle`, the centre of the picture, are preferred.
pub(super) fn place(labels: &[Label], obstacles: &mut Obstacles, middle: Point) -> (String, Area) {
    let (mut drawn, mut area) = (String::new(), Area::empty());
    for label in labels {
        let content = shortened(&label.content);
        let bold = if label.class.contains("name") { 1.1 } else { 1.0 };
        let half = [0.5 * bold * width_of(&content, LETTERS) + 2.0, 0.5 * LETTERS + 1.0];
        let best = candidates(label, half)
            .map(|centre| (cost(label, centre, half, obstacles, middle), centre))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, centre)) = best else { continue };
        let own = Area::around(centre, half);
        let gap = [centre[0] - label.at[0], centre[1] - label.at[1]];
        let reach = gap[0].hypot(gap[1]);
        // A leader line connects a distant label to its point.
        let edge =
            (half[0] / gap[0].abs().max(1e-9)).min(half[1] / gap[1].abs().max(1e-9)).min(1.0);
        if reach * (1.0 - edge) > label.radius + 19.0 {
            let end = [label.at[0] + gap[0] * (1.0 - edge), label.at[1] + gap[1] * (1.0 - edge)];
            let t = label.radius / reach;
            let begin = [label.at[0] + gap[0] * t, label.at[1] + gap[1] * t];
            drawn += &line("leader", begin, end);
        }
        // The baseline lies about a third of the font size below the centre.
        let base = [centre[0], centre[1] + 0.34 * LETTERS];
        drawn += &text(&label.class, base, Anchor::Middle, &content);
        // The margin prevents two neighbouring labels from being read as one.
        obstacles.areas.push(Area::around(centre, [half[0] + 5.0, half[1]]));
        area.include(&own);
    }
    (drawn, area)
}

fn shortened(content: &str) -> String {
    if content.chars().count() <= LONGEST {
        return content.to_owned();
    }
    content.chars().take(LONGEST - 1).chain(['…']).collect()
}

/// Iterates over candidate positions for the centre of a label: rings of different radii around the
/// labelled point. `half` is half the width and height of the label, px.
fn candidates(label: &Label, half: Point) -> impl Iterator<Item = Point> + use<> {
    let (at, radius, inside) = (label.at, label.radius, label.inside);
    let around = (0..3).flat_map(move |ring| {
        (0..16).map(move |k| {
            let (s, c) = (f64::from(k) * core::f64::consts::TAU / 16.0).sin_cos();
            let reach = radius + 3.0 + 15.0 * f64::from(ring);
            // The reach is measured to the box of the label, not to its centre.
            let x = c * reach + half[0] * (1.6 * c).clamp(-1.0, 1.0);
            let y = s * reach + half[1] * (1.6 * s).clamp(-1.0, 1.0);
            [at[0] + x, at[1] + y]
        })
    });
    inside.then_some(at).into_iter().chain(around)
}

fn cost(label: &Label, centre: Point, half: Point, obstacles: &Obstacles, middle: Point) -> f64 {
    let own = Area::around(centre, half);
    let covered: f64 = obstacles.areas.iter().map(|area| area.overlap(&own)).sum();
    let crossed = obstacles.points.iter().filter(|point| own.holds(**point, 4.0)).count() as f64;
    let gap = [centre[0] - label.at[0], centre[1] - label.at[1]];
    let far = gap[0].hypot(gap[1]);
    // Positions away from the centre of the picture are preferred.
    let out = [label.at[0] - middle[0], label.at[1] - middle[1]];
    let outward = (gap[0] * out[0] + gap[1] * out[1]) / (far * out[0].hypot(out[1])).max(1e-9);
    4.0 * covered + 12.0 * crossed + 1.2 * far - 6.0 * outward
}

/// Returns the smallest box around points, extended by `margin` on all sides, px.
pub(super) fn area_of(points: impl Iterator<Item = Point>, margin: f64) -> Area {
    let mut area = Area::empty();
    for point in points {
        area.include(&Area::around(point, [margin; 2]));
    }
    area
}

/// Formats an area as the value of a `viewBox` attribute.
pub(super) fn view_box(area: &Area) -> String {
    let [x, y] = area.least;
    format!("{} {} {} {}", px(x), px(y), px(area.greatest[0] - x), px(area.greatest[1] - y))
}
