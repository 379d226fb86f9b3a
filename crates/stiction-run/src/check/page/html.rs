//! HTML elements of the page. Plain text is escaped; arguments named `inner` are markup.

use stiction_draw::page;
use stiction_draw::xml::escape;

pub(super) use stiction_draw::page::Column;

const STYLE: &str = include_str!("style.css");

/// Section with its heading.
pub(super) fn section(title: &str, inner: &str) -> String {
    format!("<section>\n<h2>{}</h2>\n{inner}</section>\n", escape(title))
}

/// Paragraph.
pub(super) fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escape(text))
}

/// Paragraph of explanation.
pub(super) fn note(text: &str) -> String {
    format!("<p class=\"note\">{}</p>\n", escape(text))
}

/// Table; empty without rows.
pub(super) fn table(head: &[(&str, Column)], rows: &[Vec<String>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let head: Vec<_> = head.iter().map(|(name, column)| (escape(name), *column)).collect();
    let rows: Vec<Vec<_>> =
        rows.iter().map(|row| row.iter().map(|text| escape(text)).collect()).collect();
    format!("<div class=\"wide\">{}</div>\n", page::table(&head, &rows))
}

/// Collapsible section for long tables.
pub(super) fn folded(summary: &str, inner: &str) -> String {
    if inner.is_empty() {
        return String::new();
    }
    format!("<details>\n<summary>{}</summary>\n{inner}</details>\n", escape(summary))
}

/// Verdict in large letters.
pub(super) fn card(big: &str, small: &str, is_bad: bool) -> String {
    let class = if is_bad { "card bad" } else { "card" };
    format!("<div class=\"{class}\"><b>{}</b><span>{}</span></div>\n", escape(big), escape(small))
}

/// Whole page.
pub(super) fn page(title: &str, inner: &str) -> String {
    page::page(title, STYLE, inner)
}
