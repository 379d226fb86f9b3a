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

/// Arranges the panels in rows; panels of different bodies are in different rows.
fn rows(figure: &Figure) -> Vec<Vec<&Panel>> {
    let body = |panel: &Panel| panel.plane.as_ref().map(|plane| plane.body);
    let mut rows: Vec<Vec<&Panel>> = Vec::new();
    for panel in &figure.panels {
        match rows.last_mut() {
            Some(row) if row.len() < BESIDE && body(row[0]) == body(panel) => row.push(panel),
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
        let greatest = figure.panels.iter().flat_map(extents).fold(0.0, f64::max);
        let greatest = if greatest > 0.0 { greatest } else { 1.0 };
        let lengths = |panel: &Panel| extents(panel).map(|x| (MARGIN * x).max(LEAST * greatest));
        // The tick labels of a vertical axis have at most seven letters.
        let left = 16.0 + 7.0 * LETTER;
        let scale_of = |row: &Vec<&Panel>| {
            let across: f64 = row.iter().map(|panel| lengths(panel)[0]).sum();
            let room = self.width - (left + GAP) * row.len() as f64;
            let up = row.iter().map(|panel| lengths(panel)[1]).fold(0.0, f64::max);
            (room / across).min(HIGHEST / up)
        };
        let scale = rows.iter().map(scale_of).fold(f64::INFINITY, f64::min);
        self.left = left;
        let mut top = self.heading();
        for row in rows {
            let up = row.iter().map(|panel| lengths(panel)[1]).fold(0.0, f64::max);
            let bottom = top + NAME + scale * up;
            let mut x = 0.0;
            for panel in row {
                let [across, up] = lengths(panel);
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
