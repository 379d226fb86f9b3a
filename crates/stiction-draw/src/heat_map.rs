//! Heat maps: coloured cells that show a quantity as a function of two other quantities.

use crate::numbers::{number, with_minus};
use crate::xml::escape;
use std::fmt::Write;

/// Map of a quantity on a grid of two other quantities.
#[derive(Clone, Debug)]
pub struct HeatMap {
    /// Name and unit of the quantity.
    pub title: String,
    /// Name and unit of the horizontal axis.
    pub x_label: String,
    /// Name and unit of the vertical axis.
    pub y_label: String,
    /// Values of the horizontal quantity at the columns, from left to right.
    pub x: Vec<f64>,
    /// Values of the vertical quantity at the rows, from bottom to top.
    pub y: Vec<f64>,
    /// Values of the cells: one list for each row, from bottom to top. A cell without a value
    /// (`None`) is hatched.
    pub values: Vec<Vec<Option<f64>>>,
}

/// Width and height of the area of the cells, px.
const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 420.0;
/// Margins around the area of the cells, px.
const LEFT: f64 = 92.0;
const TOP: f64 = 44.0;
const BOTTOM: f64 = 62.0;
const RIGHT: f64 = 132.0;
/// Largest number of tick values along an axis.
const MOST_NAMED: usize = 8;
/// Largest number of columns, and half the largest number of rows, for which the values are written
/// into the cells.
const MOST_WRITTEN: usize = 8;
/// Colour scale with uniformly increasing lightness, which readers with colour vision deficiencies can distinguish:
/// dark blue, blue, green, yellow.
const SCALE: [[f64; 3]; 5] = [
    [68.0, 1.0, 84.0],
    [59.0, 82.0, 139.0],
    [33.0, 145.0, 140.0],
    [94.0, 201.0, 98.0],
    [253.0, 231.0, 37.0],
];

impl HeatMap {
    /// Draws the map as an SVG file, on a white background.
    pub fn svg(&self) -> String {
        self.render("none", "#000000", Some("#ffffff"))
    }

    /// Draws the map for a page, in the colours of the page's text; `index` must be different for
    /// each map of the page.
    pub fn inline(&self, index: usize) -> String {
        self.render(&format!("none-{index}"), "currentColor", None)
    }

    /// Draws the map; `pattern` is the name of the pattern for cells without a value, `ink` the colour of text, and
    /// `paper` the background.
    fn render(&self, pattern: &str, ink: &str, paper: Option<&str>) -> String {
        let (width, height) = (LEFT + WIDTH + RIGHT, TOP + HEIGHT + BOTTOM);
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"{ink}\">\
             <defs><pattern id=\"{pattern}\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\">\
             <rect width=\"6\" height=\"6\" fill=\"#eeeeee\"/>\
             <path d=\"M0 6L6 0\" stroke=\"#999999\"/></pattern></defs>"
        );
        if let Some(paper) = paper {
            let _ = write!(out, "<rect width=\"{width}\" height=\"{height}\" fill=\"{paper}\"/>");
        }
        let middle = LEFT + 0.5 * WIDTH;
        text(&mut out, (middle, 26.0), "middle", "font-size=\"15\"", &self.title);
        self.cells(&mut out, pattern);
        self.axes(&mut out);
        self.legend(&mut out);
        out.push_str("</svg>\n");
        out
    }

    /// Returns the least and the greatest finite value of all cells; `None` if no value is finite.
    fn range(&self) -> Option<(f64, f64)> {
        let values = self.values.iter().flatten().flatten().copied().filter(|v| v.is_finite());
        values.fold(None, |range, value| {
            let (least, greatest) = range.unwrap_or((value, value));
            Some((value.min(least), value.max(greatest)))
        })
    }

    fn cells(&self, out: &mut String, pattern: &str) {
        let range = self.range();
        let (columns, rows) = (self.x.len().max(1), self.y.len().max(1));
        let (w, h) = (WIDTH / columns as f64, HEIGHT / rows as f64);
        let is_written = columns <= MOST_WRITTEN && rows <= 2 * MOST_WRITTEN;
        for (row, values) in self.values.iter().enumerate() {
            for (column, value) in values.iter().enumerate() {
                let (x, y) = (LEFT + column as f64 * w, TOP + HEIGHT - (row + 1) as f64 * h);
                let finite = value.filter(|value| value.is_finite());
                let part = finite.zip(range).map(|(value, range)| fraction(value, range));
                let fill = part.map_or(format!("url(#{pattern})"), colour);
                let words = match value {
                    Some(value) => with_minus(&number(*value)),
                    None => "no value".to_owned(),
                };
                // Cells overlap slightly, so that no light lines remain between them.
                let _ = write!(
                    out,
                    "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{:.2}\" height=\"{:.2}\" fill=\"{fill}\">\
                     <title>{}</title></rect>",
                    w + 0.3,
                    h + 0.3,
                    escape(&words)
                );
                if is_written {
                    let ink =
                        if part.is_none_or(|part| part > 0.55) { "#000000" } else { "#ffffff" };
                    let at = (x + 0.5 * w, y + 0.5 * h + 4.0);
                    text(out, at, "middle", &format!("fill=\"{ink}\""), &words);
                }
            }
        }
        let _ = write!(
            out,
            "<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"currentColor\"/>"
        );
    }

    fn axes(&self, out: &mut String) {
        let bottom = TOP + HEIGHT;
        for k in named(self.x.len()) {
            let x = LEFT + (k as f64 + 0.5) * WIDTH / self.x.len() as f64;
            text(out, (x, bottom + 18.0), "middle", "", &with_minus(&number(self.x[k])));
        }
        for k in named(self.y.len()) {
            let y = bottom - (k as f64 + 0.5) * HEIGHT / self.y.len() as f64;
            text(out, (LEFT - 8.0, y + 4.0), "end", "", &with_minus(&number(self.y[k])));
        }
        let middle = LEFT + 0.5 * WIDTH;
        text(out, (middle, bottom + 44.0), "middle", "font-size=\"14\"", &self.x_label);
        let (x, y) = (20.0, TOP + 0.5 * HEIGHT);
        let turn = format!("font-size=\"14\" transform=\"rotate(-90 {x} {y})\"");
        text(out, (x, y), "middle", &turn, &self.y_label);
    }

    /// Draws the colour scale with its values.
    fn legend(&self, out: &mut String) {
        const STEPS: usize = 60;
        let Some((least, greatest)) = self.range() else { return };
        let x = LEFT + WIDTH + 22.0;
        let h = HEIGHT / STEPS as f64;
        for k in 0..STEPS {
            let y = TOP + HEIGHT - (k + 1) as f64 * h;
            let fill = colour((k as f64 + 0.5) / STEPS as f64);
            let _ = write!(
                out,
                "<rect x=\"{x}\" y=\"{y:.2}\" width=\"18\" height=\"{:.2}\" fill=\"{fill}\"/>",
                h + 0.3
            );
        }
        for k in 0..5 {
            let part = f64::from(k) / 4.0;
            let y = TOP + HEIGHT * (1.0 - part) + 4.0;
            let value = least * (1.0 - part) + greatest * part;
            text(out, (x + 24.0, y), "start", "", &with_minus(&number(value)));
        }
    }
}

/// Iterates over the indices of the columns or rows whose values are written along an axis.
fn named(count: usize) -> impl Iterator<Item = usize> {
    let step = count.div_ceil(MOST_NAMED).max(1);
    (0..count).step_by(step)
}

/// Returns the position of a value in a range, from 0 at the least to 1 at the greatest value; 0.5
/// if both are equal. The computation does not overflow.
fn fraction(value: f64, (least, greatest): (f64, f64)) -> f64 {
    let part = (0.5 * value - 0.5 * least) / (0.5 * greatest - 0.5 * least);
    if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.5 }
}

fn colour(part: f64) -> String {
    let place = part * (SCALE.len() - 1) as f64;
    let below = (place as usize).min(SCALE.len() - 2);
    let rest = place - below as f64;
    let mixed = |k: usize| {
        let [from, to] = [SCALE[below][k], SCALE[below + 1][k]];
        (from + rest * (to - from)).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", mixed(0), mixed(1), mixed(2))
}

fn text(out: &mut String, (x, y): (f64, f64), anchor: &str, more: &str, words: &str) {
    let words = escape(words);
    let _ = write!(
        out,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" {more}>{words}</text>"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(values: Vec<Vec<Option<f64>>>) -> HeatMap {
        HeatMap {
            title: "<peak> & more".to_owned(),
            x_label: "x".to_owned(),
            y_label: "y".to_owned(),
            x: (0..values.first().map_or(0, Vec::len)).map(|k| k as f64).collect(),
            y: (0..values.len()).map(|k| k as f64).collect(),
            values,
        }
    }

    #[test]
    fn least_and_greatest_values_have_the_ends_of_the_scale() {
        let svg = map(vec![vec![Some(1.0), Some(2.0)], vec![Some(3.0), None]]).svg();
        assert!(svg.contains("fill=\"#440154\"><title>1.000</title>"), "{svg}");
        assert!(svg.contains("fill=\"#fde725\"><title>3.000</title>"), "{svg}");
        assert!(svg.contains("fill=\"url(#none)\"><title>no value</title>"), "{svg}");
        // The first row is at the bottom.
        let place = |words: &str| svg.find(words).unwrap();
        assert!(place("<title>1.000") < place("<title>3.000"));
    }

    #[test]
    fn odd_values_are_drawn() {
        let extreme = vec![vec![Some(f64::MAX), Some(-f64::MAX)], vec![Some(f64::INFINITY), None]];
        for values in [vec![], vec![vec![]], vec![vec![Some(1.0); 3]; 2], vec![vec![None]], extreme]
        {
            let svg = map(values.clone()).svg();
            assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"), "{values:?}");
            assert!(!svg.contains("NaN") && !svg.contains("<peak>"), "{values:?}");
        }
    }
}
