//! Pieces of the page. Text goes in as it is and comes out escaped; only what is named `inner` is
//! markup already.

use stiction_draw::page;
use stiction_draw::xml::escape;

pub(super) use stiction_draw::page::Column;

const STYLE: &str = include_str!("style.css");

/// A heading with what belongs to it.
pub(super) fn section(title: &str, inner: &str) -> String {
    format!("<section>\n<h2>{}</h2>\n{inner}</section>\n", escape(title))
}

/// A paragraph.
pub(super) fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escape(text))
}

/// A paragraph of explanation.
pub(super) fn note(text: &str) -> String {
    format!("<p class=\"note\">{}</p>\n", escape(text))
}

/// A table; nothing without rows.
pub(super) fn table(head: &[(&str, Column)], rows: &[Vec<String>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let head: Vec<_> = head.iter().map(|(name, column)| (escape(name), *column)).collect();
    let rows: Vec<Vec<_>> =
        rows.iter().map(|row| row.iter().map(|text| escape(text)).collect()).collect();
    format!("<div class=\"wide\">{}</div>\n", page::table(&head, &rows))
}

/// Long tables are folded.
pub(super) fn folded(summary: &str, inner: &str) -> String {
    if inner.is_empty() {
        return String::new();
    }
    format!("<details>\n<summary>{}</summary>\n{inner}</details>\n", escape(summary))
}

/// A verdict in large letters.
pub(super) fn card(big: &str, small: &str, is_bad: bool) -> String {
    let class = if is_bad { "card bad" } else { "card" };
    format!("<div class=\"{class}\"><b>{}</b><span>{}</span></div>\n", escape(big), escape(small))
}

/// The whole page.
pub(super) fn page(title: &str, inner: &str) -> String {
    page::page(title, STYLE, inner)
}
