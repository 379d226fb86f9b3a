//! Paths in space, projected on planes with the same scale on all axes.

use super::axis::{Axis, extremes};
use super::render::{LETTER, NAME, Renderer, TICKS};
use super::{Figure, Form, Panel, Plane, colour_name};
use crate::drawing::px;
use crate::xml::escape;
use std::fmt::Write;

/// Largest number of panels beside each other.
const BESIDE: usize = 2;
/// Largest height of a panel, px.
const HIGHEST: f64 = 320.0;
/// Least length of an axis as a fraction of the greatest extent of all paths, so that a flat path
/// has room for its tick labels.
const LEAST: f64 = 0.4;
/// Ratio of the length of an axis to the extent of the paths along this axis.
const MARGIN: f64 = 1.16;
/// Horizontal gap after each panel, px.
const GAP: f64 = 22.0;

/// Iterates over the coordinates of a panel's finite points along the horizontal (0) or the
/// vertical (1) axis.
fn along(panel: &Panel, axis: usize) -> impl Iterator<Item = f64> {
    let points = panel.lines.iter().flat_map(|line| &line.points);
    points
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .map(move |p| if axis == 0 { p.0 } else { p.1 })
}

/// Returns the extents of a panel's paths along the horizontal and the vertical axis.
fn extents(panel: &Panel) -> [f64; 2] {
    [0, 1].map(|axis| {
        let (low, high) = extremes(along(panel, axis));
        high - low
    })
}

/// Returns the lengths of the axes of each panel, which leave margins about its paths.
fn lengths(figure: &Figure) -> Vec<[f64; 2]> {
    let greatest = figure.panels.iter().flat_map(extents).fold(0.0, f64::max);
    let greatest = if greatest > 0.0 { greatest } else { 1.0 };
    let of = |panel| extents(panel).map(|x| (MARGIN * x).max(LEAST * greatest));
    figure.panels.iter().map(of).collect()
}

/// Returns the low and high end of both axes of each panel of paths, so that all axes have the same
/// scale if every panel has the width and the height of `room`.
#[cfg(any(test, feature = "png"))]
pub(super) fn ranges(figure: &Figure, room: [f64; 2]) -> Vec<[(f64, f64); 2]> {
    let scales = lengths(figure).into_iter().flat_map(|own| [room[0] / own[0], room[1] / own[1]]);
    let scale = scales.fold(f64::INFINITY, f64::min);
    let range = |panel: &Panel| {
        [0, 1].map(|axis| {
            let axis = Axis::about(along(panel, axis), room[axis] / scale, 1);
            (axis.low, axis.high)
        })
    };
    figure.panels.iter().map(range).collect()
}

/// Panels beside each other, with the lengths of their axes.
type Row<'a> = Vec<(&'a Panel, [f64; 2])>;

/// Returns the greatest length of the vertical axes of a row.
fn height(row: &[(&Panel, [f64; 2])]) -> f64 {
    row.iter().map(|(_, lengths)| lengths[1]).fold(0.0, f64::max)
}

/// Arranges the panels, each with the lengths of its axes, in rows; panels of different bodies are
/// in different rows.
fn rows(figure: &Figure) -> Vec<Row<'_>> {
    let body = |panel: &Panel| panel.plane.as_ref().map(|plane| plane.body);
    let mut rows: Vec<Row<'_>> = Vec::new();
    for panel in figure.panels.iter().zip(lengths(figure)) {
        match rows.last_mut() {
            Some(row) if row.len() < BESIDE && body(row[0].0) == body(panel.0) => row.push(panel),
            _ => rows.push(vec![panel]),
        }
    }
    rows
}

impl Renderer<'_> {
    /// Draws the panels of a figure with paths in space in rows, all with the same scale. Returns
    /// the `svg` element.
    pub(super) fn planes(mut self) -> String {
        let figure = self.figure;
        let rows = rows(figure);
        // The tick labels of a vertical axis have at most seven letters.
        let left = 16.0 + 7.0 * LETTER;
        let scale_of = |row: &Row<'_>| {
            let across: f64 = row.iter().map(|(_, own)| own[0]).sum();
            let room = self.width - (left + GAP) * row.len() as f64;
            (room / across).min(HIGHEST / height(row))
        };
        let scale = rows.iter().map(scale_of).fold(f64::INFINITY, f64::min);
        self.left = left;
        let mut top = self.heading();
        for row in rows {
            let bottom = top + NAME + scale * height(&row);
            let mut x = 0.0;
            for (panel, [across, up]) in row {
                self.left = x + left;
                self.right = self.left + scale * across;
                self.height = scale * up;
                self.x = Axis::about(along(panel, 0), across, (scale * across / 45.0) as usize);
                let y = Axis::about(along(panel, 1), up, (scale * up / 40.0) as usize);
                if let Some(plane) = &panel.plane {
                    self.plane(panel, plane, &y, bottom);
                }
                x = self.right + GAP;
            }
            top = bottom + TICKS;
        }
        self.sheet(top, " data-plan=\"\"")
    }

    /// Draws one panel with its axes; `bottom` is the position of its lower edge, px.
    fn plane(&mut self, panel: &Panel, plane: &Plane, y: &Axis, bottom: f64) {
        let (left, right, top) = (self.left, self.right, bottom - self.height);
        let at = |x: &Axis, (u, v): (f64, f64), height: f64| {
            (left + (right - left) * x.place(u), bottom - height * y.place(v))
        };
        let mut grid = String::new();
        for (value, label) in y.ticks() {
            let (_, height) = at(&self.x, (0.0, value), self.height);
            let _ = write!(grid, "M{} {}H{}", px(left), px(height), px(right));
            self.text((left - 7.0, height + 4.0), "end", "", "ink", &label);
        }
        for (value, label) in self.x.ticks() {
            let (place, _) = at(&self.x, (value, 0.0), self.height);
            let _ = write!(grid, "M{} {}V{}", px(place), px(top), px(bottom));
            self.text((place, bottom + 17.0), "middle", "", "ink", &label);
        }
        let colour = self.colour("grid");
        let _ = write!(self.drawn, "<g stroke=\"{colour}\"><path d=\"{grid}\" fill=\"none\"/></g>");
        let frame = format!("M{} {}V{}H{}", px(left), px(top), px(bottom), px(right));
        self.stroke(&frame, "soft", " stroke-width=\"0.8\"");
        let more = " font-size=\"13\" font-weight=\"600\"";
        self.text((left, top - 8.0), "start", more, "ink", &panel.y_label);
        let middle = 0.5 * (left + right);
        self.text((middle, bottom + 36.0), "middle", " font-size=\"13\"", "soft", &plane.x_label);
        if self.form == Form::Page {
            let (places, [across, up]) = ([left, right, top, bottom].map(px), plane.axes);
            let _ = write!(
                self.drawn,
                "<g class=\"panel\" data-left=\"{}\" data-right=\"{}\" data-top=\"{}\" data-bottom=\"{}\" \
                 data-first=\"{:?}\" data-end=\"{:?}\" data-low=\"{:?}\" data-high=\"{:?}\" data-body=\"{}\" \
                 data-across=\"{across}\" data-up=\"{up}\" data-name=\"{}\" data-across-name=\"{}\">",
                places[0],
                places[1],
                places[2],
                places[3],
                self.x.low,
                self.x.high,
                y.low,
                y.high,
                plane.body,
                escape(&panel.y_label),
                escape(&plane.x_label),
            );
        }
        for line in &panel.lines {
            self.line(line, panel.leg, y, bottom);
        }
        if self.form == Form::Page {
            self.drawn += "</g>";
        }
        // Marks the start of the first path. Together with the time cursor, the mark shows the
        // direction of the path.
        let finite = |(x, y): &&(f64, f64)| x.is_finite() && y.is_finite();
        if let Some(line) = panel.lines.first()
            && let Some(first) = line.points.iter().find(finite)
        {
            let (x, height) = at(&self.x, *first, self.height);
            let fill = self.colour(&colour_name(line.colour, panel.leg));
            let (is_right, paper) = (x > middle, self.colour("paper"));
            let _ = write!(
                self.drawn,
                "<circle cx=\"{}\" cy=\"{}\" r=\"3.5\" fill=\"{fill}\"/>",
                px(x),
                px(height)
            );
            let halo = format!(" stroke=\"{paper}\" stroke-width=\"4\" paint-order=\"stroke\"");
            let (anchor, beside) = if is_right { ("end", -7.0) } else { ("start", 7.0) };
            let above = if height - top < 16.0 { 14.0 } else { -6.0 };
            self.text((x + beside, height + above), anchor, &halo, "ink", "start");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Line;

    /// Checks that panels of one size show all projections with the same scale on both axes, and the whole paths.
    #[test]
    fn ranges_have_the_same_scale() {
        let panel = |axes: [usize; 2], size: (f64, f64)| Panel {
            lines: vec![Line {
                label: String::new(),
                points: vec![(5.0, -2.0), (5.0 + size.0, -2.0 + size.1)],
                colour: 0,
                dashed: false,
            }],
            plane: Some(Plane { x_label: "x [m]".into(), body: 1, axes }),
            ..Panel::default()
        };
        let panels =
            vec![panel([0, 2], (0.3, 0.02)), panel([1, 2], (0.1, 0.02)), panel([0, 1], (0.3, 0.1))];
        let figure = Figure { title: String::new(), x_label: String::new(), panels };
        let room = [600.0, 400.0];
        let ranges = ranges(&figure, room);
        let scale = |axis: usize, (low, high): (f64, f64)| room[axis] / (high - low);
        let first = scale(0, ranges[0][0]);
        for (panel, own) in figure.panels.iter().zip(&ranges) {
            for axis in [0, 1] {
                assert!((scale(axis, own[axis]) / first - 1.0).abs() < 1e-12, "{ranges:?}");
                assert!(
                    along(panel, axis).all(|x| own[axis].0 < x && x < own[axis].1),
                    "{ranges:?}"
                );
            }
        }
    }
}
