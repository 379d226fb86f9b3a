//! Line plots and bar charts.
//!
//! Each colour has the same meaning in all plots of runs: see [`meaning`].

mod axis;
mod bars;
mod inline;
pub mod meaning;
mod path;
mod plane;
#[cfg(feature = "png")]
mod png;
mod render;
mod trace;

pub use bars::{Bar, Bars};
pub use path::PathTrace;
pub use trace::{BandTrace, JumpTrace, Trace, reversal};

use crate::drawing::BRANCHES;
use meaning::{LEGS, MEASURED, OF_LEG, REFERENCE, RESULT};
use std::collections::HashSet;

/// Figure of several panels above each other with a common horizontal axis.
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
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Name and unit of the vertical axis.
    pub y_label: String,
    /// Curves, in the order of the legend.
    pub lines: Vec<Line>,
    /// Bands of intervals, drawn behind the curves.
    pub bands: Vec<Band>,
    /// True if the values are counts, so that ticks are whole numbers.
    pub is_count: bool,
    /// Index of the leg whose quantities the panel shows. Curves with the colour index
    /// [`meaning::OF_LEG`] have the colour of this leg.
    pub leg: Option<usize>,
    /// Plane of the panel if its curves are paths in space, else `None`. Either all panels of a
    /// figure have a plane or none has one.
    pub plane: Option<Plane>,
}

/// Plane on which a panel projects the path of a body. All panels of the figure have the same scale on both axes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plane {
    /// Name and unit of the horizontal axis.
    pub x_label: String,
    /// Index of the body whose path is shown.
    pub body: usize,
    /// Coordinates shown on the horizontal and the vertical axis: 0, 1, 2 for x, y, z.
    pub axes: [usize; 2],
}

/// Interval of a quantity as a function of the value on the horizontal axis.
#[derive(Clone, Debug)]
pub struct Band {
    /// Name in the legend.
    pub label: String,
    /// Points: x, low end and high end, which may be infinite. A NaN interrupts the band.
    pub points: Vec<(f64, f64, f64)>,
    /// Index of the band's colour in [`COLOURS`].
    pub colour: usize,
}

/// Curve in a panel.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name in the legend; a line without a name is omitted from the legend.
    pub label: String,
    /// Points, x and y. A point with a value that is not finite interrupts the curve.
    pub points: Vec<(f64, f64)>,
    /// Index of the curve's colour in [`COLOURS`], or one of [`meaning`].
    pub colour: usize,
    /// True for a dashed line.
    pub dashed: bool,
}

impl Line {
    /// Creates a curve of single points without a line between them.
    pub fn of_marks(points: impl IntoIterator<Item = (f64, f64)>, colour: usize) -> Self {
        let apart = |point: (f64, f64)| [point, (point.0, f64::NAN)];
        let points = points.into_iter().flat_map(apart).collect();
        Self { label: String::new(), points, colour, dashed: false }
    }
}

/// Medium for which a figure is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// Separate picture, with its title and legends.
    Paper,
    /// Part of a page. The page contains the title and the legend outside the figure.
    Page,
}

/// Colours of curves, bands and bars on a light background. They are distinguishable on paper, on
/// screen and with most colour vision deficiencies (after Okabe and Ito).
pub const COLOURS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8c6d00", "#2c8fc9", "#666666", "#a0522d"];
/// Colours of curves, bands and bars on a dark background, in the order of [`COLOURS`].
pub const COLOURS_ON_DARK: [&str; 8] =
    ["#5ab4e8", "#f08a5d", "#3fc79d", "#e29ac7", "#c9b458", "#93d0f3", "#b0b0b0", "#b5835a"];

/// Maps all colour indices that look the same to one common index.
fn distinct(colour: usize) -> usize {
    match colour {
        LEGS.. => colour,
        colour => colour % COLOURS.len(),
    }
}

/// Returns the name of a colour in the style sheet of a page. `leg` is the leg of the panel or bar,
/// whose colour [`OF_LEG`] selects.
fn colour_name(colour: usize, leg: Option<usize>) -> String {
    match (colour, leg) {
        (REFERENCE, _) => "soft".to_owned(),
        (MEASURED, _) => "ink".to_owned(),
        (OF_LEG, Some(leg)) => format!("leg{}", leg % BRANCHES.len()),
        (OF_LEG, None) => format!("line{RESULT}"),
        (LEGS.., _) => format!("leg{}", colour - LEGS),
        (colour, _) => format!("line{}", colour % COLOURS.len()),
    }
}

/// Returns the colour value on white paper for a name from [`colour_name`] or for `paper`, `soft`,
/// `grid` or `ink`, the colours of the figure's background, axes, grid and text.
fn on_paper(name: &str) -> &'static str {
    let index = |prefix: &str| name.strip_prefix(prefix).and_then(|k| k.parse::<usize>().ok());
    if let Some(k) = index("line") {
        return COLOURS[k % COLOURS.len()];
    }
    if let Some(k) = index("leg") {
        return BRANCHES[k % BRANCHES.len()];
    }
    match name {
        "paper" => "#ffffff",
        "soft" => "#5c5c5c",
        "grid" => "#d5d9de",
        _ => "#222222",
    }
}

/// Largest number of letters of a name that is written at the end of its line. Longer names would
/// leave too little room for the panel on a narrow page.
const LONG: usize = 20;

impl Figure {
    /// Draws the figure as an SVG file.
    pub fn svg(&self) -> String {
        self.render(Form::Paper)
    }

    /// Returns true if the panels show paths in space.
    fn is_of_paths(&self) -> bool {
        self.panels.iter().any(|panel| panel.plane.is_some())
    }

    /// Returns `true` if no line and no band of the figure has a point that can be drawn.
    pub fn is_empty(&self) -> bool {
        let of_lines = |panel: &Panel| {
            let mut points = panel.lines.iter().flat_map(|line| &line.points);
            points.any(|(x, y)| x.is_finite() && y.is_finite())
        };
        let of_bands = |panel: &Panel| {
            let mut points = panel.bands.iter().flat_map(|band| &band.points);
            points.any(|(x, low, high)| x.is_finite() && (low.is_finite() || high.is_finite()))
        };
        !self.panels.iter().any(|panel| of_lines(panel) || of_bands(panel))
    }

    /// Returns the pieces of a line sample in a common legend. Each piece has its start and end, as
    /// fractions of the length of the sample, and the name of its colour. If the colour differs
    /// between panels, the pieces have the colours of up to three legs, with gaps if `dashed`.
    fn sample(&self, colour: usize, dashed: bool) -> Vec<(f64, f64, String)> {
        let mut names: Vec<String> = Vec::new();
        for panel in &self.panels {
            let name = colour_name(colour, panel.leg);
            if !names.contains(&name) && panel.lines.iter().any(|line| line.colour == colour) {
                names.push(name);
            }
        }
        match &names[..] {
            [] => vec![(0.0, 1.0, colour_name(colour, None))],
            [name] => vec![(0.0, 1.0, name.clone())],
            names => (0..3)
                .map(|k| {
                    let (step, length) =
                        if dashed { (0.375, 0.25) } else { (1.0 / 3.0, 1.0 / 3.0) };
                    let start = step * k as f64;
                    (start, start + length, names[k % names.len()].clone())
                })
                .collect(),
        }
    }

    /// Returns true if the names of the lines are written at their ends; false if all panels have a
    /// common legend. A common legend requires that each appearance (colour, and solid or dashed)
    /// has the same meaning in all panels, and that some name is long or occurs in several panels.
    /// Also false if a panel has more than nine names or shows paths in space.
    fn labels_lines(&self) -> bool {
        let all = || self.panels.iter().flat_map(Panel::labels).filter(|entry| !entry.0.is_empty());
        let entries: HashSet<_> = all().collect();
        let appearances: HashSet<_> =
            all().map(|(_, colour, dashed, is_band)| (colour, dashed, is_band)).collect();
        let is_long = all().any(|entry| entry.0.chars().count() > LONG);
        let has_one_meaning = appearances.len() == entries.len();
        let is_common = has_one_meaning && (entries.len() < all().count() || is_long);
        let most = self.panels.iter().map(|panel| panel.labels().count()).max().unwrap_or(0);
        // More names than this do not fit beside a panel.
        !is_common && most <= 9 && !self.is_of_paths()
    }
}

impl Panel {
    /// Removes the lines whose values are all zero, up to rounding errors relative to the greatest
    /// value of all lines. If all lines are zero, none is removed.
    #[must_use]
    pub fn without_zeros(mut self) -> Self {
        // This fraction is far above rounding errors, and a line of this size is invisible in a
        // picture. It equals the fraction below which an axis shows a constant.
        const ROUNDING: f64 = 1e-9;
        let size = |line: &Line| {
            let values = line.points.iter().map(|point| point.1.abs()).filter(|y| y.is_finite());
            values.fold(0.0, f64::max)
        };
        let greatest = self.lines.iter().map(size).fold(0.0, f64::max);
        self.lines.retain(|line| greatest == 0.0 || size(line) > ROUNDING * greatest);
        self
    }

    /// Returns for each line and band its name, its colour index from [`distinct`], true if it is
    /// dashed, and true if it is a band.
    fn labels(&self) -> impl Iterator<Item = (&str, usize, bool, bool)> {
        let lines = self.lines.iter();
        let lines =
            lines.map(|line| (line.label.as_str(), distinct(line.colour), line.dashed, false));
        let bands = self.bands.iter().filter(|band| !band.points.is_empty());
        lines.chain(bands.map(|band| (band.label.as_str(), distinct(band.colour), false, true)))
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
            panels: vec![Panel { y_label: "force [N]".into(), lines, ..Panel::default() }],
        }
    }

    /// Checks that figures of unusual data are complete and well-formed.
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
            assert!(!svg.contains("<more>") && svg.contains("&lt;more&gt;"));
        }
    }

    /// Checks that a curve of an actuator has the colour of its leg, in a page and on paper, and that a common legend
    /// shows the colours of all panels.
    #[test]
    fn actuators_have_the_colours_of_their_legs() {
        let mut pair = figure(vec![vec![(0.0, 0.0), (1.0, 1.0)], vec![(0.0, 1.0), (1.0, 0.0)]]);
        pair.panels[0].lines[0].colour = OF_LEG;
        pair.panels[0].lines[1].colour = REFERENCE;
        pair.panels.push(pair.panels[0].clone());
        for (panel, leg) in pair.panels.iter_mut().zip([2, 10]) {
            panel.leg = Some(leg);
        }
        let page = pair.inline("forces");
        for expected in ["stroke=\"var(--leg2)\"", "stroke=\"var(--leg3)\"", "fill=\"var(--leg3)\""]
        {
            assert!(page.contains(expected), "{expected} in {page}");
        }
        let (legend, _) = page.split_once("</ul>").unwrap();
        for expected in
            ["stroke=\"var(--leg2)\"", "stroke=\"var(--leg3)\"", "stroke=\"var(--soft)\""]
        {
            assert!(legend.contains(expected), "{expected} in {legend}");
        }
        assert!(pair.svg().contains(BRANCHES[2]) && pair.svg().contains(BRANCHES[3]));
        pair.panels.truncate(1);
        pair.panels[0].leg = None;
        assert!(pair.inline("forces").contains("var(--line0)"));
    }

    /// Checks that a single point is drawn as a marker, because a line through it would be
    /// invisible.
    #[test]
    fn a_single_point_is_marked() {
        let svg = figure(vec![vec![(0.0, 1.0)], vec![(0.0, 2.0)]]).svg();
        // The point of the dashed line is drawn as a cross.
        assert!(svg.contains("<circle") && svg.contains("m-5-5l10 10"), "{svg}");
    }

    /// Checks that each of many single points is drawn, with a small marker.
    #[test]
    fn many_points_are_marked() {
        let mut scattered = figure(vec![vec![]]);
        let points = (0..100).map(|k| (f64::from(k), f64::from(k * k % 17)));
        scattered.panels[0].lines = vec![Line::of_marks(points, 0)];
        let svg = scattered.svg();
        assert_eq!(svg.matches("h0").count(), 100, "{svg}");
        assert!(!scattered.is_empty() && svg.contains("stroke-linecap=\"round\""));
    }

    /// Checks that the name of the horizontal axis is written once and, in tall figures, the
    /// numbers below each panel, so that readers need not scroll to the last panel.
    #[test]
    fn tall_figures_number_the_axis_of_each_panel() {
        for (panels, numbered) in [(1, 1), (4, 1), (5, 5), (9, 9)] {
            let mut tall = figure(vec![vec![(0.0, 0.0), (1.0, 900.0)]]);
            tall.panels = vec![tall.panels[0].clone(); panels];
            let svg = tall.svg();
            assert_eq!(svg.matches("time [s]").count(), 1, "{panels}");
            // No tick of a vertical axis has this value.
            assert_eq!(svg.matches(">0.8</text>").count(), numbered, "{panels}");
        }
    }

    /// Checks that panels have a common legend only if they share a name or a name is long.
    #[test]
    fn names_stand_at_their_lines_unless_panels_share_them() {
        let mut pair = figure(vec![vec![(0.0, 0.0), (1.0, 1.0)], vec![(0.0, 1.0), (1.0, 0.0)]]);
        assert!(pair.labels_lines(), "one panel");
        let mut long = pair.clone();
        long.panels[0].lines[1].label += ", with a name that is long";
        assert!(!long.labels_lines(), "a long name");
        pair.panels.push(pair.panels[0].clone());
        assert!(!pair.labels_lines(), "the same names in both");
        for (k, line) in pair.panels[1].lines.iter_mut().enumerate() {
            line.label += " elsewhere";
            line.colour = 4 + k;
        }
        assert!(pair.labels_lines(), "other names in each");
    }

    #[test]
    fn counts_have_whole_ticks() {
        let mut counts = figure(vec![vec![(0.0, 0.0), (1.0, 1.0)]]);
        assert!(counts.svg().contains(">0.4</text>"));
        counts.panels[0].is_count = true;
        counts.x_label = "row".into();
        counts.panels[0].lines[0].points = vec![(0.0, 0.0), (10.0, 1.0)];
        let svg = counts.svg();
        assert!(!svg.contains(">0.4</text>") && svg.contains(">1</text>"), "{svg}");
    }

    /// Checks that lines are removed if they are zero, or a rounding error compared with another
    /// line.
    #[test]
    fn lines_of_zeros_are_left_out() {
        let line = |size: f64| vec![(0.0, -size), (1.0, size)];
        let panel = |lines| figure(lines).panels.remove(0).without_zeros().lines.len();
        assert_eq!(panel(vec![line(100.0), line(0.0), line(1e-14), line(0.1)]), 2);
        assert_eq!(panel(vec![line(0.0), line(0.0)]), 2);
    }
}
