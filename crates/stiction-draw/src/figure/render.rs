//! Rendering of figures as SVG, for files and for pages.

use super::axis::Axis;
use super::meaning::OF_LEG;
use super::{Band, Figure, Form, Line, Panel, colour_name, on_paper};
use crate::drawing::{Px, px};
use crate::xml::escape;
use std::fmt::Write;

/// Widths of a figure in a file and in a page, px. They are small, so that letters remain legible
/// on a narrow page.
const WIDTHS: [f64; 2] = [860.0, 700.0];
/// Mean width of a letter, px.
pub(super) const LETTER: f64 = 6.6;
/// Height of the name of a panel, px.
pub(super) const NAME: f64 = 26.0;
/// Height of tick labels together with the name of the axis, px.
pub(super) const TICKS: f64 = 44.0;
/// Height of tick labels alone, px.
const NUMBERS: f64 = 18.0;
/// Largest number of panels for which the tick labels below the last panel suffice.
const SHARING: usize = 4;
/// Height of a row of a legend, px.
const ROW: f64 = 22.0;
/// Largest number of single points for which a line has large markers; more points have small
/// markers.
const MANY: usize = 40;
/// Largest number of letters of a label at the end of a line.
const LONGEST: usize = 24;
/// Least distance between labels at the ends of lines, px.
const APART: f64 = 14.0;

impl Figure {
    /// Draws the figure as one `svg` element.
    pub(super) fn render(&self, form: Form) -> String {
        match self.is_of_paths() {
            true => Renderer::new(self, form).planes(),
            false => Renderer::new(self, form).finish(),
        }
    }
}

pub(super) struct Renderer<'a> {
    pub(super) figure: &'a Figure,
    pub(super) form: Form,
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) x: Axis,
    pub(super) drawn: String,
}

impl<'a> Renderer<'a> {
    fn new(figure: &'a Figure, form: Form) -> Self {
        let width = WIDTHS[usize::from(form == Form::Page)];
        let panels = &figure.panels;
        let lines = panels.iter().flat_map(|panel| &panel.lines);
        let bands = panels.iter().flat_map(|panel| &panel.bands);
        let xs = lines.flat_map(|line| line.points.iter().filter(|p| p.1.is_finite()).map(|p| p.0));
        let xs = xs.chain(bands.flat_map(|band| band.points.iter().map(|point| point.0)));
        let x = Axis::exact(xs, 8);
        let height = match (panels.len(), form) {
            (1, _) => 230.0,
            (2..=3, _) => 160.0,
            _ => 128.0,
        };
        let mut renderer =
            Self { figure, form, left: 0.0, right: 0.0, width, height, x, drawn: String::new() };
        let letters = panels.iter().flat_map(|panel| renderer.y_of(panel).ticks());
        let letters = letters.map(|(_, label)| label.chars().count()).max().unwrap_or(1);
        renderer.left = 16.0 + LETTER * letters.max(3) as f64;
        let labels = match figure.labels_lines() {
            true => panels
                .iter()
                .flat_map(Panel::labels)
                .map(|(label, ..)| short(label).chars().count())
                .max(),
            false => None,
        };
        renderer.right = width - labels.map_or(18.0, |letters| 38.0 + LETTER * letters as f64);
        renderer
    }

    fn y_of(&self, panel: &Panel) -> Axis {
        let lines = panel.lines.iter().flat_map(|line| line.points.iter().map(|point| point.1));
        let bands = panel.bands.iter().flat_map(|band| &band.points);
        let bands = bands.flat_map(|(_, low, high)| [*low, *high]);
        let axis = Axis::padded(lines.chain(bands), (self.height / 30.0) as usize);
        if panel.is_count { axis.of_counts() } else { axis }
    }

    pub(super) fn colour(&self, name: &str) -> String {
        if self.form == Form::Page {
            return format!("var(--{name})");
        }
        on_paper(name).to_owned()
    }

    pub(super) fn text(
        &mut self,
        (x, y): (f64, f64),
        anchor: &str,
        more: &str,
        colour: &str,
        content: &str,
    ) {
        let fill = self.colour(colour);
        let (x, y, content) = (px(x), px(y), escape(content));
        let _ = write!(
            self.drawn,
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" fill=\"{fill}\"{more}>{content}</text>"
        );
    }

    pub(super) fn stroke(&mut self, path: &str, colour: &str, more: &str) {
        let colour = self.colour(colour);
        let _ = write!(self.drawn, "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\"{more}/>");
    }

    /// Draws the title and the legend if the figure is a file, not a part of a page. Returns the
    /// vertical position below both, px.
    pub(super) fn heading(&mut self) -> f64 {
        let mut top = 4.0;
        if self.form == Form::Paper {
            if !self.figure.title.is_empty() {
                top += 20.0;
                let more = " font-size=\"16\" font-weight=\"600\"";
                self.text((self.left, top), "start", more, "ink", &self.figure.title);
                top += 6.0;
            }
            if !self.figure.labels_lines() {
                top = self.legend(top);
            }
        }
        top
    }

    fn finish(mut self) -> String {
        let figure = self.figure;
        let mut top = self.heading();
        let mut bottom = top + NAME;
        let count = figure.panels.len();
        for (index, panel) in figure.panels.iter().enumerate() {
            let is_last = index + 1 == count;
            self.panel(panel, top + NAME, (is_last || count > SHARING, is_last));
            bottom = top + NAME + self.height;
            top = bottom
                + match () {
                    () if is_last => TICKS,
                    () if count > SHARING => NUMBERS,
                    () => 4.0,
                };
        }
        let over_time = figure.x_label.starts_with("time [s]");
        let cursor = match self.form == Form::Page && over_time {
            true => format!(
                " data-left=\"{}\" data-right=\"{}\" data-first=\"{:?}\" data-end=\"{:?}\"",
                px(self.left),
                px(self.right),
                self.x.low,
                self.x.high
            ),
            false => String::new(),
        };
        self.sheet(top.max(bottom + 4.0), &cursor)
    }

    /// Returns the `svg` element with all drawn parts. `height` is its height, px; `attributes` are
    /// further attributes of a figure in a page.
    pub(super) fn sheet(&self, height: f64, attributes: &str) -> String {
        let (width, height) = (px(self.width), px(height));
        let frame = match self.form {
            Form::Page => {
                format!("<svg class=\"curves\" viewBox=\"0 0 {width} {height}\"{attributes}")
            }
            Form::Paper => format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\""
            ),
        };
        let sheet = match self.form {
            Form::Page => String::new(),
            Form::Paper => "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>".to_owned(),
        };
        format!(
            "{frame} font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\">{sheet}{}</svg>",
            self.drawn
        )
    }

    /// Draws the common legend of a file; returns the vertical position below the legend, px.
    fn legend(&mut self, top: f64) -> f64 {
        let mut entries: Vec<(&str, usize, bool, bool)> = Vec::new();
        for entry in self.figure.panels.iter().flat_map(Panel::labels) {
            if !entry.0.is_empty() && !entries.contains(&entry) {
                entries.push(entry);
            }
        }
        if entries.len() < 2 {
            return top;
        }
        let (mut x, mut y) = (self.left, top + 0.7 * ROW);
        for (label, colour, dashed, is_band) in entries {
            let wide = 52.0 + LETTER * label.chars().count() as f64;
            if x > self.left && x + wide > self.width {
                (x, y) = (self.left, y + ROW);
            }
            self.sample((x, y), colour, dashed, is_band);
            self.text((x + 36.0, y + 4.0), "start", "", "ink", label);
            x += wide;
        }
        y + 0.4 * ROW
    }

    /// Draws a sample of a line or a band, 28 px wide.
    fn sample(&mut self, (x, y): (f64, f64), colour: usize, dashed: bool, is_band: bool) {
        if is_band {
            let fill = self.colour(&colour_name(colour, None));
            let _ = write!(
                self.drawn,
                "<rect x=\"{}\" y=\"{}\" width=\"28\" height=\"10\" fill=\"{fill}\" fill-opacity=\"0.35\"/>",
                px(x),
                px(y - 5.0)
            );
        } else {
            let pieces = self.figure.sample(colour, dashed);
            let more = dashes(dashed && pieces.len() == 1);
            for (start, end, name) in pieces {
                let path = format!("M{} {}H{}", px(x + 28.0 * start), px(y), px(x + 28.0 * end));
                self.stroke(&path, &name, more);
            }
        }
    }

    /// Draws a panel; `top` is the position of its upper edge, px. The tick labels and the name of
    /// its horizontal axis are optional.
    fn panel(&mut self, panel: &Panel, top: f64, (has_numbers, has_name): (bool, bool)) {
        let (left, right, bottom) = (self.left, self.right, top + self.height);
        let y = self.y_of(panel);
        let at_y = |value: f64| bottom - self.height * y.place(value);
        let ticks_y: Vec<(f64, String)> =
            y.ticks().into_iter().map(|(value, label)| (at_y(value), label)).collect();
        let span = right - left;
        let ticks_x: Vec<(f64, String)> = self
            .x
            .ticks()
            .into_iter()
            .map(|(v, label)| (left + span * self.x.place(v), label))
            .collect();
        let mut grid = String::new();
        for (height, _) in &ticks_y {
            let _ = write!(grid, "M{} {}H{}", px(left), px(*height), px(right));
        }
        for (place, _) in &ticks_x {
            let _ = write!(grid, "M{} {}V{}", px(*place), px(top), px(bottom));
        }
        let grid_colour = self.colour("grid");
        let _ = write!(
            self.drawn,
            "<g stroke=\"{grid_colour}\"><path d=\"{grid}\" fill=\"none\"/></g>"
        );
        let mut frame = format!("M{} {}V{}H{}", px(left), px(top), px(bottom), px(right));
        if y.low < 0.0 && 0.0 < y.high {
            let _ = write!(frame, "M{} {}H{}", px(left), px(at_y(0.0)), px(right));
        }
        let soft = self.colour("soft");
        let _ = write!(
            self.drawn,
            "<g stroke=\"{soft}\" stroke-width=\"0.8\"><path d=\"{frame}\" fill=\"none\"/></g>"
        );
        for (height, label) in &ticks_y {
            self.text((left - 7.0, height + 4.0), "end", "", "ink", label);
        }
        // A square shows the leg of the panel, in the colour of this leg in pictures of the
        // mechanism.
        let mut name_at = left;
        if panel.leg.is_some() {
            let fill = self.colour(&colour_name(OF_LEG, panel.leg));
            let _ = write!(
                self.drawn,
                "<rect x=\"{}\" y=\"{}\" width=\"10\" height=\"10\" rx=\"2\" fill=\"{fill}\"/>",
                px(left),
                px(top - 17.5)
            );
            name_at += 16.0;
        }
        self.text(
            (name_at, top - 8.0),
            "start",
            " font-size=\"13\" font-weight=\"600\"",
            "ink",
            &panel.y_label,
        );
        if has_numbers {
            for (place, label) in &ticks_x {
                self.text((*place, bottom + 17.0), "middle", "", "ink", label);
            }
        }
        if has_name {
            let (middle, name) = (0.5 * (left + right), &self.figure.x_label);
            self.text((middle, bottom + 36.0), "middle", " font-size=\"13\"", "soft", name);
        }
        for band in &panel.bands {
            self.band(band, &y, bottom);
        }
        // Data attributes from which the script of a page computes the values at the pointer.
        let is_page = self.form == Form::Page;
        if is_page {
            let _ = write!(
                self.drawn,
                "<g class=\"panel\" data-top=\"{}\" data-bottom=\"{}\" data-low=\"{:?}\" \
                 data-high=\"{:?}\" data-name=\"{}\">",
                px(top),
                px(bottom),
                y.low,
                y.high,
                escape(&panel.y_label)
            );
        }
        for line in &panel.lines {
            self.line(line, panel.leg, &y, bottom);
        }
        if is_page {
            self.drawn += "</g>";
        }
        if self.figure.labels_lines() {
            self.labels(panel, &y, top);
        }
    }

    fn x_at(&self, value: f64) -> f64 {
        self.left + (self.right - self.left) * self.x.place(value)
    }

    pub(super) fn line(&mut self, line: &Line, leg: Option<usize>, y: &Axis, bottom: f64) {
        let name = colour_name(line.colour, leg);
        let mut path = String::new();
        let mut runs: Vec<Vec<(Px, Px)>> = vec![Vec::new()];
        for &(x, value) in &line.points {
            if !(x.is_finite() && value.is_finite()) {
                runs.push(Vec::new());
                continue;
            }
            let point = (px(self.x_at(x)), px(bottom - self.height * y.place(value)));
            if let Some(run) = runs.last_mut()
                && run.last() != Some(&point)
            {
                run.push(point);
            }
        }
        let single = runs.iter().filter(|run| run.len() == 1).count();
        if single > MANY {
            let points = runs.iter().filter(|run| run.len() == 1).flatten();
            let marks: String = points.map(|(x, y)| format!("M{x} {y}h0")).collect();
            self.stroke(&marks, &name, " stroke-width=\"4.5\" stroke-linecap=\"round\"");
            runs.retain(|run| run.len() > 1);
        }
        for run in runs.iter().filter(|run| !run.is_empty()) {
            if let [(x, y)] = &run[..] {
                // A single point needs a marker; a cross remains visible on top of the circle of another line.
                if line.dashed {
                    let _ = write!(path, "M{x} {y}m-5-5l10 10m0-10l-10 10");
                } else {
                    let fill = self.colour(&name);
                    let _ = write!(
                        self.drawn,
                        "<circle cx=\"{x}\" cy=\"{y}\" r=\"4\" fill=\"{fill}\"/>"
                    );
                }
                continue;
            }
            for (k, (x, y)) in run.iter().enumerate() {
                path.push(if k == 0 { 'M' } else { 'L' });
                // Formatting through `write!` takes longer than the digits.
                let _ = x.write_to(&mut path);
                path.push(' ');
                let _ = y.write_to(&mut path);
            }
        }
        if !path.is_empty() {
            let label = match self.form {
                Form::Page => format!(" data-label=\"{}\"", escape(&line.label)),
                Form::Paper => String::new(),
            };
            let more = format!("{} stroke-linejoin=\"round\"{label}", dashes(line.dashed));
            self.stroke(&path, &name, &more);
        }
    }

    /// Draws the intervals of a band as areas, and isolated samples as bars.
    fn band(&mut self, band: &Band, y: &Axis, bottom: f64) {
        let name = colour_name(band.colour, None);
        let fill = self.colour(&name);
        let at = |value: f64| bottom - self.height * y.place(value);
        let mut drawn = String::new();
        let runs = band.points.split(|(_, low, high)| low.is_nan() || high.is_nan());
        for run in runs.filter(|run| !run.is_empty()) {
            let ends: Vec<[Px; 3]> = run
                .iter()
                .map(|(x, low, high)| [px(self.x_at(*x)), px(at(*low)), px(at(*high))])
                .collect();
            if let [[x, low, high]] = &ends[..] {
                let _ = write!(
                    drawn,
                    "<path d=\"M{x} {low}V{high}\" stroke=\"{fill}\" stroke-width=\"3\" stroke-opacity=\"0.55\"/>"
                );
                continue;
            }
            let there = ends.iter().map(|[x, _, high]| format!("{x} {high}"));
            let back = ends.iter().rev().map(|[x, low, _]| format!("{x} {low}"));
            let outline = there.chain(back).collect::<Vec<_>>().join("L");
            let _ =
                write!(drawn, "<path d=\"M{outline}Z\" fill=\"{fill}\" fill-opacity=\"0.35\"/>");
        }
        self.drawn += &drawn;
    }

    /// Writes the name of each line of a panel at the end of the line, and the names of bands
    /// below.
    fn labels(&mut self, panel: &Panel, y: &Axis, top: f64) {
        let bottom = top + self.height;
        let end_of = |line: &Line| {
            let last = line.points.iter().rev().find(|(x, y)| x.is_finite() && y.is_finite());
            last.map(|(_, value)| bottom - self.height * y.place(*value))
        };
        let mut all: Vec<(f64, f64, &str, usize, bool, bool)> = Vec::new();
        for line in panel.lines.iter().filter(|line| !line.label.is_empty()) {
            if let Some(end) = end_of(line) {
                all.push((end, end, &line.label, line.colour, line.dashed, false));
            }
        }
        for band in panel.bands.iter().filter(|band| !band.points.is_empty()) {
            all.push((bottom, bottom, &band.label, band.colour, false, true));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let apart = APART.min(self.height / all.len().max(1) as f64);
        let mut least = top + 4.0;
        for label in &mut all {
            label.1 = label.0.max(least);
            least = label.1 + apart;
        }
        let mut most = bottom;
        for label in all.iter_mut().rev() {
            label.1 = label.1.min(most);
            most = label.1 - apart;
        }
        for (end, place, label, colour, dashed, is_band) in all {
            let name = colour_name(colour, panel.leg);
            let x = self.right + 3.0;
            if is_band {
                let fill = self.colour(&name);
                let _ = write!(
                    self.drawn,
                    "<rect x=\"{}\" y=\"{}\" width=\"20\" height=\"8\" fill=\"{fill}\" fill-opacity=\"0.35\"/>",
                    px(x + 5.0),
                    px(place - 4.0)
                );
            } else {
                let path = format!("M{} {}L{} {}h19", px(x), px(end), px(x + 6.0), px(place));
                self.stroke(&path, &name, dashes(dashed));
            }
            self.text((x + 30.0, place + 4.0), "start", "", "ink", &short(label));
        }
    }
}

fn dashes(dashed: bool) -> &'static str {
    if dashed { " stroke-width=\"1.6\" stroke-dasharray=\"7 4\"" } else { " stroke-width=\"1.8\"" }
}

/// Shortens a label that is too long.
fn short(label: &str) -> String {
    match label.chars().count() > LONGEST {
        true => label.chars().take(LONGEST - 1).chain(['…']).collect(),
        false => label.to_owned(),
    }
}
