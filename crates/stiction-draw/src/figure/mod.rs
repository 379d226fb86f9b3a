//! Line plots.

mod inline;
mod trace;

pub use trace::Trace;

use crate::xml::is_of_xml;
use kuva::prelude::*;
use kuva::render::figure::Figure as Sheet;

/// Panels above each other with a common horizontal axis.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Title above all panels.
    pub title: String,
    /// Name and unit of the horizontal axis.
    pub x_label: String,
    /// Panels from top to bottom.
    pub panels: Vec<Panel>,
}

/// Panel with its own vertical axis.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Name and unit of the vertical axis.
    pub y_label: String,
    /// Curves, in the order of the legend.
    pub lines: Vec<Line>,
}

/// Curve.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name in the legend; a line without one is not in it.
    pub label: String,
    /// Points, x and y.
    pub points: Vec<(f64, f64)>,
    /// Index of the colour.
    pub colour: usize,
    /// True for a dashed line.
    pub dashed: bool,
}

/// Medium of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// Separate picture with its title and legends.
    Paper,
    /// Part of a page, which has the title and the legend.
    Page,
}

/// Colours distinguishable on paper, on screen and with most colour vision deficiencies (after
/// Okabe and Ito).
pub const COLOURS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8c6d00", "#2c8fc9", "#666666", "#a0522d"];
/// The same colours for a dark background.
pub const COLOURS_ON_DARK: [&str; 8] =
    ["#5ab4e8", "#f08a5d", "#3fc79d", "#e29ac7", "#c9b458", "#93d0f3", "#b0b0b0", "#b5835a"];

const PANEL_WIDTH: f64 = 860.0;
/// Width of a panel in a page, px: small, so that letters keep their size in a narrow page.
const PAGE_PANEL_WIDTH: f64 = 700.0;
/// Height of a single panel in a page, px.
const PAGE_LONE_HEIGHT: f64 = 280.0;
const PANEL_HEIGHT: f64 = 220.0;
/// Margin left of the axes for tick labels and the name of the axis, px.
const LEFT: f64 = 92.0;
/// Half the width of the marker of a single point, px.
const MARK: f64 = 5.0;
/// Widths of a legend's frame with its line samples, and of one letter, px.
const LEGEND_FRAME: f64 = 48.0;
const LETTER: f64 = 6.6;

impl Figure {
    /// Figure as SVG.
    pub fn svg(&self) -> String {
        SvgBackend.render_scene(&self.sheet(Form::Paper).render())
    }

    /// True if no point can be drawn.
    pub fn is_empty(&self) -> bool {
        let mut points = self.panels.iter().flat_map(|panel| &panel.lines).flat_map(|l| &l.points);
        !points.any(|(x, y)| x.is_finite() && y.is_finite())
    }

    fn sheet(&self, form: Form) -> Sheet {
        let rows: Vec<Vec<Plot>> = self.panels.iter().map(|panel| panel.plots(form)).collect();
        // All panels have the same margins, so that their axes are aligned.
        let labels = self.panels.iter().flat_map(|panel| &panel.lines);
        let longest = labels.map(|line| line.label.chars().count()).max().unwrap_or(0);
        let legend = match form {
            Form::Paper => LEGEND_FRAME + LETTER * longest as f64,
            Form::Page => 0.0,
        };
        let layouts = self.panels.iter().zip(&rows).map(|(panel, plots)| {
            Layout::auto_from_plots(plots)
                .with_legend_width(legend)
                .with_force_margins(LEFT, legend + 24.0)
                .with_y_label(clean(&panel.y_label))
                .with_x_label(clean(&self.x_label))
                .with_font_family("Helvetica, Arial, sans-serif")
        });
        let layouts = layouts.collect();
        let (width, height) = match form {
            Form::Paper => (PANEL_WIDTH, PANEL_HEIGHT),
            Form::Page if self.panels.len() == 1 => (PAGE_PANEL_WIDTH, PAGE_LONE_HEIGHT),
            Form::Page => (PAGE_PANEL_WIDTH, PANEL_HEIGHT),
        };
        let mut sheet = Sheet::new(self.panels.len(), 1)
            .with_plots(rows)
            .with_layouts(layouts)
            .with_cell_size(width, height);
        // In each group only the lowest panel has the numbers and the name of the axis.
        for group in groups(self.panels.len()) {
            sheet = sheet.with_shared_x_slice(0, group.start, group.end - 1);
        }
        match form {
            Form::Paper => sheet.with_title(clean(&self.title)),
            Form::Page => sheet,
        }
    }
}

/// Groups of panels that are visible at once; each names its horizontal axis once, below.
fn groups(panels: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
    const SEEN: usize = 4;
    let count = panels.div_ceil(SEEN);
    (0..count).map(move |k| k * panels / count..(k + 1) * panels / count)
}

/// Removes characters that SVG does not allow; the renderer escapes special ones only.
fn clean(text: &str) -> String {
    text.chars().filter(|c| is_of_xml(*c)).collect()
}

#[cfg(feature = "png")]
impl Figure {
    /// Figure as PNG.
    ///
    /// # Errors
    /// The renderer fails.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        PngBackend::default()
            .render_scene(&self.sheet(Form::Paper).render())
            .map_err(|e| e.to_string())
    }
}

impl Panel {
    fn plots(&self, form: Form) -> Vec<Plot> {
        self.lines.iter().map(|line| line.plot(form)).collect()
    }
}

impl Line {
    fn plot(&self, form: Form) -> Plot {
        // Values that are not finite cannot be drawn.
        let points = self.points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite());
        let points: Vec<_> = points.collect();
        let colour = COLOURS[self.colour % COLOURS.len()];
        if points.len() == 1 {
            // A single point needs a marker. A cross stays visible on top of another curve's
            // circle.
            let shape = if self.dashed { MarkerShape::Cross } else { MarkerShape::Circle };
            let mark = ScatterPlot::new().with_data(points).with_color(colour).with_size(MARK);
            let mark = mark.with_marker(shape);
            return Plot::from(match form {
                Form::Paper if !self.label.is_empty() => mark.with_legend(clean(&self.label)),
                _ => mark,
            });
        }
        let line = LinePlot::new().with_data(points).with_color(colour).with_stroke_width(1.6);
        let line = match form {
            Form::Paper if !self.label.is_empty() => line.with_legend(clean(&self.label)),
            _ => line,
        };
        Plot::from(if self.dashed { line.with_dashed() } else { line })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(lines: Vec<Vec<(f64, f64)>>) -> Figure {
        let line =
            |(k, points)| Line { label: format!("line {k}"), points, colour: k, dashed: k == 1 };
        let lines = lines.into_iter().enumerate().map(line).collect();
        Figure {
            title: "title & <more>".into(),
            x_label: "time [s]".into(),
            panels: vec![Panel { y_label: "force [N]".into(), lines }],
        }
    }

    /// Figures of unusual data are complete and well formed.
    #[test]
    fn odd_data_are_drawn() {
        let cases = [
            vec![],
            vec![vec![]],
            vec![vec![(0.0, 1.0)]],
            vec![vec![(0.0, 0.0), (1.0, 0.0)]],
            vec![vec![(0.0, 1e300), (1.0, -1e300)]],
            vec![vec![(0.0, 1e-300), (1.0, 2e-300)]],
            vec![vec![(0.0, f64::NAN), (1.0, 2.0), (2.0, f64::INFINITY)]],
            vec![vec![(5.0, 1.0); 3], vec![(5.0, 2.0)]],
        ];
        for case in cases {
            let svg = figure(case.clone()).svg();
            assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{case:?}");
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{case:?}");
            assert!(!svg.contains("<more>"));
        }
    }

    /// A line through a single point would be invisible.
    #[test]
    fn a_single_point_is_marked() {
        let svg = figure(vec![vec![(0.0, 1.0)], vec![(0.0, 2.0)]]).svg();
        let marks = svg.matches("#0072b2").count() + svg.matches("#d55e00").count();
        // Each point has a marker in the plot and in the legend.
        assert!(marks >= 4, "{svg}");
        assert!(svg.contains("<circle"));
    }

    /// Every panel has its axis in view without scrolling to the last panel.
    #[test]
    fn tall_figures_name_their_axis_more_than_once() {
        for (panels, names) in [(1, 1), (4, 1), (5, 2), (9, 3)] {
            let mut tall = figure(vec![vec![(0.0, 0.0), (1.0, 1.0)]]);
            tall.panels = vec![tall.panels[0].clone(); panels];
            let svg = tall.svg();
            assert_eq!(svg.matches("time [s]").count(), names, "{panels}");
        }
    }
}
