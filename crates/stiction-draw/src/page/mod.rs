//! Frame of all HTML pages. A page is self-contained, light or dark according to the reader's
//! preference, and black on white in print.
//!
//! The content security policy of a page permits only its own styles and, if it shows an animated
//! robot, the scripts of [`crate::viewer`], identified by their digests. Markup that is injected
//! through a name or a title therefore cannot run.

use crate::drawing::{BRANCHES, BRANCHES_ON_DARK, tones};
use crate::figure::{COLOURS, COLOURS_ON_DARK};
use crate::numbers::with_minus;
use crate::viewer;
use crate::xml::{escape, sentence};
use base64::prelude::{BASE64_STANDARD, Engine};
use sha2::{Digest, Sha256};

const STYLE: &str = include_str!("style.css");

/// Names of colours with their values on light and dark backgrounds.
const PALETTE: [(&str, &str, &str); 13] = [
    ("paper", "#ffffff", "#1c1f24"),
    ("ink", "#222222", "#e8e8e8"),
    ("soft", "#5c5c5c", "#a9a9a9"),
    ("edge", "#d5d9de", "#3d444d"),
    ("tint", "#f3f5f8", "#272b32"),
    ("link", "#0b5cad", "#7cb9f2"),
    ("bad", "#a33100", "#ffab80"),
    ("badtint", "#fdf0e8", "#3a2a22"),
    ("good", "#1d6b34", "#86d79b"),
    ("goodtint", "#ecf7ef", "#1f3226"),
    ("open", "#755400", "#e6c35c"),
    ("opentint", "#fdf6e0", "#35301d"),
    ("grid", "#cccccc", "#4a525c"),
];

/// Returns the CSS declarations of all colours: of the palette, of lines, of legs and of parts of
/// pictures.
fn variables(is_dark: bool) -> String {
    let colours = PALETTE.iter().map(|(name, light, dark)| {
        let value = if is_dark { dark } else { light };
        format!("--{name}:{value}")
    });
    let lines = if is_dark { COLOURS_ON_DARK } else { COLOURS };
    let lines = lines.iter().enumerate().map(|(k, value)| format!("--line{k}:{value}"));
    let branches = if is_dark { BRANCHES_ON_DARK } else { BRANCHES };
    let branches = branches.iter().enumerate().map(|(k, value)| format!("--leg{k}:{value}"));
    let tones = tones(is_dark).map(|(name, value)| format!("--{name}:{value}"));
    colours.chain(lines).chain(branches).chain(tones).collect::<Vec<_>>().join(";")
}

/// Returns the CSS rule with the colours of a light page.
pub fn light() -> String {
    format!(":root{{{}}}", variables(false))
}

/// Returns a complete HTML page that runs no script. `inner` is the markup of the content; `style`
/// is CSS that follows the common style sheet.
pub fn page(title: &str, style: &str, inner: &str) -> String {
    frame(title, style, inner, &[])
}

/// Returns a complete HTML page with the script of [`crate::viewer`] and, if the robot has meshes,
/// the script of the shaded view. The page may run no other script. For the parameters, see
/// [`page`].
pub fn page_with_viewer(title: &str, style: &str, inner: &str) -> String {
    let scripts = [viewer::SCRIPT, viewer::SHADED];
    let count = if viewer::has_meshes(inner) { 2 } else { 1 };
    frame(title, style, inner, &scripts[..count])
}

/// Returns the source expression that permits `script` in a content security policy.
pub fn source_of(script: &str) -> String {
    format!("'sha256-{}'", BASE64_STANDARD.encode(Sha256::digest(script)))
}

fn frame(title: &str, style: &str, inner: &str, scripts: &[&str]) -> String {
    let sources: Vec<String> = scripts.iter().map(|script| source_of(script)).collect();
    let sources = if scripts.is_empty() { "'none'".to_owned() } else { sources.join(" ") };
    let script: String =
        scripts.iter().map(|script| format!("<script>{script}</script>\n")).collect();
    let policy = format!("style-src 'unsafe-inline'; script-src {sources}");
    document(
        title,
        &policy,
        &format!("{STYLE}{style}"),
        &format!("<main>\n{inner}</main>\n{script}"),
    )
}

/// Returns the complete HTML page of an application. `policy` contains the directives of the
/// content security policy in addition to `default-src 'none'`. `style` is the style sheet of the
/// application, which follows the declarations of all colours. `inner` is the markup of the
/// content, including scripts.
pub fn application(title: &str, policy: &str, style: &str, inner: &str) -> String {
    document(title, policy, style, inner)
}

fn document(title: &str, policy: &str, style: &str, inner: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         {policy}; base-uri 'none'; form-action 'none'\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"color-scheme\" content=\"light dark\"/>\n\
         <title>{}</title>\n<style>\n{}\n@media screen and (prefers-color-scheme:dark){{:root{{{}}}}}\n\
         {style}</style>\n</head>\n<body>\n{inner}</body>\n</html>\n",
        escape(title),
        light(),
        variables(true),
    )
}

/// Alignment of the cells of a table column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// Names and texts that a reader may copy, aligned to the left.
    Text,
    /// Sentences, aligned to the left.
    Prose,
    /// Numbers, aligned to the right.
    Number,
}

/// Applies `change` to the texts of a markup, not to its tags.
fn in_texts(markup: &str, change: impl Fn(&str) -> String) -> String {
    let parts = markup.split_inclusive('>').map(|part| {
        let (text, tag) = part.split_at(part.find('<').unwrap_or(part.len()));
        change(text) + tag
    });
    parts.collect()
}

/// Creates an HTML table; column names and cells are inserted as HTML, without escaping. Columns of numbers and
/// sentences have true minus signs, and those of sentences the parts between backticks as code.
pub fn table(head: &[(String, Column)], rows: &[Vec<String>]) -> String {
    let cell = |element: &str, column: Column, inner: &str| {
        let class = if column == Column::Number { " class=\"number\"" } else { "" };
        format!("<{element}{class}>{inner}</{element}>")
    };
    let mut inner = String::from("<table>\n<thead><tr>");
    for (name, column) in head {
        // A column without a name has no heading.
        inner += &cell(if name.is_empty() { "td" } else { "th" }, *column, name);
    }
    inner += "</tr></thead>\n<tbody>\n";
    for row in rows {
        inner += "<tr>";
        for ((_, column), text) in head.iter().zip(row) {
            match column {
                Column::Number => inner += &cell("td", *column, &in_texts(text, with_minus)),
                Column::Prose => inner += &cell("td", *column, &in_texts(text, sentence)),
                Column::Text => inner += &cell("td", *column, text),
            }
        }
        inner += "</tr>\n";
    }
    inner + "</tbody>\n</table>"
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of `#rrggbb` as WCAG 2 defines it.
    fn luminance(colour: &str) -> f64 {
        let part = |at: usize| {
            let c = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5)
    }

    fn contrast(a: &str, b: &str) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    fn colour(name: &str, is_dark: bool) -> &'static str {
        let (_, light, dark) = PALETTE.iter().find(|(own, _, _)| *own == name).unwrap();
        if is_dark { dark } else { light }
    }

    /// Checks that texts have a contrast of at least 4.5, as WCAG 2.2 requires.
    #[test]
    fn text_is_legible() {
        let grounds = [
            ("paper", vec!["ink", "soft", "link", "bad", "good", "open"]),
            ("tint", vec!["ink", "soft", "link"]),
            ("badtint", vec!["ink", "link", "bad"]),
            ("goodtint", vec!["ink", "link", "good"]),
            ("opentint", vec!["ink", "link", "open"]),
        ];
        for is_dark in [false, true] {
            for (ground, texts) in &grounds {
                for text in texts {
                    let found = contrast(colour(ground, is_dark), colour(text, is_dark));
                    assert!(found >= 4.5, "{text} on {ground}, dark: {is_dark}: {found}");
                }
            }
        }
    }

    /// Checks that lines have a contrast of at least 3, as WCAG 2.2 requires for graphics.
    #[test]
    fn lines_are_legible() {
        let all = [
            (false, COLOURS.iter().chain(&BRANCHES)),
            (true, COLOURS_ON_DARK.iter().chain(&BRANCHES_ON_DARK)),
        ];
        for (is_dark, colours) in all {
            for line in colours {
                let found = contrast(colour("paper", is_dark), line);
                assert!(found >= 3.0, "{line}, dark: {is_dark}: {found}");
            }
        }
    }

    /// Checks that numbers in tables have true minus signs, but not the addresses of links.
    #[test]
    fn tables_have_minus_signs() {
        let head = [("name".to_owned(), Column::Text), ("time [s]".to_owned(), Column::Number)];
        let row = ["x -1", "<a href=\"#t=-0.5\">-0.5</a> to -1e-3"].map(str::to_owned).to_vec();
        let found = table(&head, &[row]);
        assert!(found.contains("<td>x -1</td>"), "{found}");
        assert!(found.contains("<a href=\"#t=-0.5\">−0.5</a> to −1e−3</td>"), "{found}");
    }

    /// Checks that backticks mark code in sentences, not in names.
    #[test]
    fn backticks_mark_code_in_sentences() {
        let head = [("what".to_owned(), Column::Prose), ("name".to_owned(), Column::Text)];
        let found = table(&head, &[["joint `a`", "`a`"].map(str::to_owned).to_vec()]);
        assert!(found.contains("<td>joint <code>a</code></td><td>`a`</td>"), "{found}");
    }

    #[test]
    fn contrast_is_that_of_the_definition() {
        assert!((contrast("#000000", "#ffffff") - 21.0).abs() < 1e-12);
        // This pair is often quoted as the lightest legible grey on white.
        assert!((contrast("#767676", "#ffffff") - 4.54).abs() < 0.005);
    }
}
