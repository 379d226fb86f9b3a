//! Elements of SVG as text; lengths in px.

use crate::xml::escape;
use std::fmt::Write;

/// Point in the picture, px.
pub(super) type Point = [f64; 2];

/// Formats a length in px with one decimal; zero has no sign, and a value that is not finite
/// becomes zero.
pub(crate) fn px(x: f64) -> String {
    // Casts of values that are not finite would not give zero for infinities.
    let tenths = if x.is_finite() { (x * 10.0).round() as i64 } else { 0 };
    let (sign, size) = (if tenths < 0 { "-" } else { "" }, tenths.unsigned_abs());
    // Integers are written several times faster than fixed decimals, and pictures consist of lengths.
    match size % 10 {
        0 => format!("{sign}{}", size / 10),
        tenth => format!("{sign}{}.{tenth}", size / 10),
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
        assert_eq!(px(-0.01), "0");
        assert_eq!(px(12.04), "12");
        assert_eq!(px(-3.26), "-3.3");
        assert_eq!(
            (px(-0.26), px(540.0), px(-100.0)),
            ("-0.3".into(), "540".into(), "-100".into())
        );
        assert_eq!(px(f64::NAN), "0");
        assert_eq!(px(f64::INFINITY), "0");
    }
}
