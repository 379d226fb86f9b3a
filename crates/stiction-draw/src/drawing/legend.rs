//! Legend under a picture: meaning of the symbols, scale, and world axes.

use super::labels::Area;
use super::svg::{Anchor, Point, line, px, text, width_of};
use super::view::View;
use stiction_core::spatial::Vec3;

/// Font size of the legend, px.
const LETTERS: f64 = 13.0;
/// Height of a row of the legend, px.
const ROW: f64 = 34.0;
/// Length of the drawn world axes, px.
const AXIS: f64 = 26.0;

/// Entry of a legend: a symbol and its meaning.
pub(super) struct Entry {
    /// Function that draws the symbol at a given point.
    pub(super) symbol: Box<dyn Fn(Point) -> String>,
    /// Half the width of the symbol, px.
    pub(super) half: f64,
    pub(super) meaning: String,
}

/// Draws entries of the legend in rows below `area`, from the left edge of `area`, and extends
/// `area` by these rows.
pub(super) fn entries(entries: &[Entry], area: &mut Area) -> String {
    let left = area.least[0] + 8.0;
    let right = area.greatest[0].max(left + 420.0);
    let (mut x, mut y) = (left, area.greatest[1] + 0.75 * ROW);
    let mut drawn = String::new();
    for entry in entries {
        let wide = 2.0 * entry.half + 8.0 + width_of(&entry.meaning, LETTERS);
        if x > left && x + wide > right {
            (x, y) = (left, y + ROW);
        }
        drawn += &(entry.symbol)([x + entry.half, y]);
        let at = [x + 2.0 * entry.half + 8.0, y + 0.34 * LETTERS];
        drawn += &text("quiet", at, Anchor::Start, &entry.meaning);
        area.include(&Area { least: [left - 8.0, y], greatest: [x + wide, y + 0.6 * ROW] });
        x += wide + 20.0;
    }
    drawn
}

/// Draws the world axes and a scale bar of round length below `area`, and extends `area` by both.
/// `scale` is the scale of the picture, px per m.
pub(super) fn scale_and_axes(view: &View, scale: f64, area: &mut Area) -> String {
    // Leaves space above the origin for axes that point upwards in this view.
    let highest = (0..3).map(|k| -view.project(Vec3::unit(k))[1]).fold(0.0, f64::max);
    let middle = [area.least[0] + AXIS + 18.0, area.greatest[1] + highest * AXIS + 22.0];
    let mut drawn = String::from(r#"<g class="axes">"#);
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        drawn += &world_axis(view, middle, Vec3::unit(k), name);
    }
    drawn += "</g>";
    let (length, name) = round_length(150.0 / scale);
    let from = [middle[0] + AXIS + 44.0, middle[1]];
    let to = [from[0] + length * scale, from[1]];
    let tick = |at: Point| line("bar", [at[0], at[1] - 5.0], [at[0], at[1] + 5.0]);
    drawn += &format!(r#"<g class="scale">{}{}{}"#, line("bar", from, to), tick(from), tick(to));
    let over = [0.5 * (from[0] + to[0]), from[1] - 9.0];
    drawn += &text("length", over, Anchor::Middle, &name);
    drawn += "</g>";
    let lowest = (0..3).map(|k| view.project(Vec3::unit(k))[1]).fold(0.0, f64::max);
    let bottom = middle[1] + lowest * AXIS + 16.0;
    area.include(&Area { least: middle, greatest: [middle[0] + AXIS, bottom] });
    area.include(&Area { least: from, greatest: [to[0] + 12.0, to[1] + 8.0] });
    drawn
}

fn world_axis(view: &View, middle: Point, axis: Vec3<f64>, name: &str) -> String {
    let [x, y] = view.project(axis);
    let across = x.hypot(y);
    if across < 0.05 {
        // The axis points towards the viewer or away.
        let mark = if view.depth(axis) > 0.0 {
            format!(
                r#"<circle class="free" style="stroke-dasharray:none" cx="{0}" cy="{1}" r="5"/><circle class="com" cx="{0}" cy="{1}" r="1.8"/>"#,
                px(middle[0]),
                px(middle[1])
            )
        } else {
            let arm = |dx: f64, dy: f64| {
                line("bar", [middle[0] - dx, middle[1] - dy], [middle[0] + dx, middle[1] + dy])
            };
            arm(4.0, 4.0) + &arm(4.0, -4.0)
        };
        let beside = [middle[0] - 13.0, middle[1] + 15.0];
        return mark + &text("axis-name", beside, Anchor::Middle, name);
    }
    let tip = [middle[0] + AXIS * x, middle[1] + AXIS * y];
    let (u, v) = (x / across, y / across);
    let barb = |side: f64| {
        let end = [tip[0] - 7.0 * u - side * 3.5 * v, tip[1] - 7.0 * v + side * 3.5 * u];
        line("detail", tip, end)
    };
    let head = if across > 0.3 { barb(1.0) + &barb(-1.0) } else { String::new() };
    let over = [tip[0] + 10.0 * u, tip[1] + 10.0 * v + 0.34 * LETTERS];
    line("detail", middle, tip) + &head + &text("axis-name", over, Anchor::Middle, name)
}

/// Returns the greatest length of 1, 2 or 5 times a power of ten that does not exceed `most`, and
/// its text with the unit. Both lengths are in m; `most` is positive.
fn round_length(most: f64) -> (f64, String) {
    let power = 10f64.powf(most.log10().floor());
    let digit = [5.0, 2.0].into_iter().find(|digit| digit * power <= most).unwrap_or(1.0);
    let length = digit * power;
    let (factor, unit) = match length {
        length if length >= 1e6 => return (length, format!("{length:.0e} m")),
        length if length >= 0.999 => (1.0, "m"),
        length if length >= 0.999e-3 => (1e3, "mm"),
        length if length >= 0.999e-6 => (1e6, "µm"),
        length => return (length, format!("{length:.0e} m")),
    };
    (length, format!("{:.0} {unit}", length * factor))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_have_round_lengths() {
        let cases = [
            (0.43, 0.2, "200 mm"),
            (0.05, 0.05, "50 mm"),
            (1.9, 1.0, "1 m"),
            (7e-6, 5e-6, "5 µm"),
            (3e9, 2e9, "2e9 m"),
            (1e-8, 1e-8, "1e-8 m"),
        ];
        for (most, length, name) in cases {
            let found = round_length(most);
            // The powers of ten are rounded.
            assert!((found.0 - length).abs() < 1e-12 * length, "{most} {found:?}");
            assert_eq!(found.1, name);
        }
    }
}
