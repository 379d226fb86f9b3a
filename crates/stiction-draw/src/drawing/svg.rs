//! Elements of SVG as text; lengths in px.

use crate::xml::escape;
use std::fmt::{self, Write};

/// Point in the picture, px.
pub(super) type Point = [f64; 2];

/// Length in a picture, rounded to a tenth of a px. As text it has at most one decimal; zero has no sign.
///
/// Pictures consist of such lengths, and integers are written several times faster than fixed decimals.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Px {
    tenths: i64,
}

/// Rounds a length in px; a value that is not finite becomes zero.
pub(crate) fn px(x: f64) -> Px {
    // Casts of values that are not finite would not give zero for infinities.
    Px { tenths: if x.is_finite() { (x * 10.0).round() as i64 } else { 0 } }
}

impl Px {
    /// Writes the length as text.
    pub(crate) fn write_to(self, out: &mut impl Write) -> fmt::Result {
        let mut digits = itoa::Buffer::new();
        if self.tenths < 0 {
            out.write_char('-')?;
        }
        let size = self.tenths.unsigned_abs();
        out.write_str(digits.format(size / 10))?;
        if !size.is_multiple_of(10) {
            out.write_char('.')?;
            out.write_str(digits.format(size % 10))?;
        }
        Ok(())
    }
}

impl fmt::Display for Px {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_to(f)
    }
}

/// Draws a straight line.
pub(super) fn line(class: &str, a: Point, b: Point) -> String {
    format!(
        r#"<line class="{class}" x1="{}" y1="{}" x2="{}" y2="{}"/>"#,
        px(a[0]),
        px(a[1]),
        px(b[0]),
        px(b[1])
    )
}

/// Draws a circle.
pub(super) fn circle(class: &str, centre: Point, radius: f64) -> String {
    format!(
        r#"<circle class="{class}" cx="{}" cy="{}" r="{}"/>"#,
        px(centre[0]),
        px(centre[1]),
        px(radius)
    )
}

/// Draws a polyline through corners, closed or open.
pub(super) fn corners(class: &str, points: &[Point], closed: bool) -> String {
    let mut list = String::new();
    for (k, point) in points.iter().enumerate() {
        let gap = if k == 0 { "" } else { " " };
        // Writing to a string does not fail.
        let _ = write!(list, "{gap}{},{}", px(point[0]), px(point[1]));
    }
    let element = if closed { "polygon" } else { "polyline" };
    format!(r#"<{element} class="{class}" points="{list}"/>"#)
}

/// Draws a path, given by its SVG path data.
pub(super) fn path(class: &str, outline: &str) -> String {
    format!(r#"<path class="{class}" d="{outline}"/>"#)
}

/// Alignment of a text relative to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
}

/// Draws a single line of text.
pub(super) fn text(class: &str, at: Point, anchor: Anchor, content: &str) -> String {
    let anchor = match anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
    };
    format!(
        r#"<text class="{class}" x="{}" y="{}" text-anchor="{anchor}">{}</text>"#,
        px(at[0]),
        px(at[1]),
        escape(content)
    )
}

/// Estimates the width of a text with the font size `size`; both are in px.
pub(super) fn width_of(content: &str, size: f64) -> f64 {
    let letter = |c: char| match c {
        'i' | 'j' | 'l' | 'I' | '.' | ',' | ':' | '\'' | '|' | ' ' => 0.32,
        'm' | 'w' | 'M' | 'W' => 0.86,
        c if u32::from(c) < 0x300 => 0.62,
        _ => 1.0,
    };
    content.chars().map(letter).sum::<f64>() * size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_short_numbers() {
        let known = [
            (-0.01, "0"),
            (12.04, "12"),
            (-3.26, "-3.3"),
            (-0.26, "-0.3"),
            (540.0, "540"),
            (-100.0, "-100"),
            (f64::NAN, "0"),
            (f64::INFINITY, "0"),
        ];
        for (length, text) in known {
            assert_eq!(px(length).to_string(), text);
        }
    }
}
