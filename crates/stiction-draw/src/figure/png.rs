//! Figures as PNG, rendered by the library kuva, which no other module uses.

use super::plane::ranges;
use super::{Figure, Line, colour_name, on_paper};
use crate::xml::is_of_xml;
use kuva::prelude::*;
use kuva::render::figure::Figure as Sheet;

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 220.0;
const LEFT: f64 = 92.0;
const LEGEND: f64 = 160.0;
/// Height of a panel of paths, px.
const TALL: f64 = 440.0;
/// Room above and below a panel of paths, px.
const ABOVE_BELOW: [f64; 2] = [16.0, 56.0];
/// Room right of a panel, px, with the legend.
const RIGHT: f64 = LEGEND + 24.0;

impl Figure {
    /// Draws the figure as a PNG file.
    ///
    /// # Errors
    /// Returns the message of the renderer if it fails.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        let rows: Vec<Vec<Plot>> = self
            .panels
            .iter()
            .map(|panel| {
                let bands = panel.bands.iter().flat_map(|band| {
                    let end = |of: fn(&(f64, f64, f64)) -> f64, label: &str| Line {
                        label: label.to_owned(),
                        points: band.points.iter().map(|p| (p.0, of(p))).collect(),
                        colour: band.colour,
                        dashed: true,
                    };
                    [end(|p| p.1, &band.label), end(|p| p.2, "")]
                });
                let lines = panel.lines.iter().cloned().chain(bands);
                lines.flat_map(|line| plots(&line, panel.leg)).collect()
            })
            .collect();
        let [above, below] = ABOVE_BELOW;
        let room = [WIDTH - LEFT - RIGHT, TALL - above - below];
        let layouts = self.panels.iter().zip(&rows).zip(ranges(self, room));
        let layouts = layouts.map(|((panel, plots), [x, y])| {
            let layout = Layout::auto_from_plots(plots)
                .with_legend_width(LEGEND)
                .with_force_margins(LEFT, RIGHT)
                .with_y_label(clean(&panel.y_label));
            match &panel.plane {
                None => layout.with_x_label(clean(&self.x_label)),
                Some(plane) => layout
                    .with_force_margins_y(above, below)
                    .with_x_axis_min(x.0)
                    .with_x_axis_max(x.1)
                    .with_y_axis_min(y.0)
                    .with_y_axis_max(y.1)
                    .with_x_label(clean(&plane.x_label)),
            }
        });
        let layouts = layouts.collect();
        let height = if self.is_of_paths() { TALL } else { HEIGHT };
        let sheet = Sheet::new(self.panels.len(), 1)
            .with_plots(rows)
            .with_layouts(layouts)
            .with_cell_size(WIDTH, height)
            .with_title(clean(&self.title));
        PngBackend::default().render_scene(&sheet.render()).map_err(|error| error.to_string())
    }
}

/// Removes the characters that XML does not permit.
fn clean(text: &str) -> String {
    text.chars().filter(|c| is_of_xml(*c)).collect()
}

/// Creates a plot for each part of a line between two interruptions. A part with a single point
/// becomes a marker.
fn plots(line: &Line, leg: Option<usize>) -> Vec<Plot> {
    let colour = on_paper(&colour_name(line.colour, leg));
    let runs = line.points.split(|(x, y)| !(x.is_finite() && y.is_finite()));
    let runs = runs.filter(|run| !run.is_empty()).enumerate();
    runs.map(|(k, run)| {
        let named = k == 0 && !line.label.is_empty();
        if run.len() == 1 {
            let mark = ScatterPlot::new().with_data(run.to_vec()).with_color(colour).with_size(5.0);
            return Plot::from(if named { mark.with_legend(clean(&line.label)) } else { mark });
        }
        let plot =
            LinePlot::new().with_data(run.to_vec()).with_color(colour).with_stroke_width(1.6);
        let plot = if named { plot.with_legend(clean(&line.label)) } else { plot };
        Plot::from(if line.dashed { plot.with_dashed() } else { plot })
    })
    .collect()
}
