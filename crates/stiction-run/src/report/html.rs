//! HTML elements of reports. The functions escape plain text; arguments named `inner` are HTML
//! markup.

use stiction_draw::figure::{Bars, Figure};
use stiction_draw::numbers::number;
use stiction_draw::page;
use stiction_draw::xml::escape;

pub(crate) use stiction_draw::page::Column;
pub(crate) use stiction_draw::xml::prose;

const STYLE: &str = include_str!("style.css");

/// Returns a section with its heading.
pub(crate) fn section(title: &str, inner: &str) -> String {
    format!("<section>\n<h2>{}</h2>\n{inner}</section>\n", escape(title))
}

/// Returns a paragraph.
pub(crate) fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", prose(text))
}

/// Returns a paragraph that contains an explanation.
pub(crate) fn note(text: &str) -> String {
    format!("<p class=\"note\">{}</p>\n", prose(text))
}

/// Returns a table; empty without rows.
pub(crate) fn table(head: &[(&str, Column)], rows: &[Vec<String>]) -> String {
    let rows: Vec<Vec<_>> =
        rows.iter().map(|row| row.iter().map(|text| escape(text)).collect()).collect();
    table_of(head, &rows)
}

/// Returns a collapsible section, for long tables; empty if `inner` is empty.
pub(crate) fn folded(summary: &str, inner: &str) -> String {
    if inner.is_empty() {
        return String::new();
    }
    format!("<details>\n<summary>{}</summary>\n{inner}</details>\n", escape(summary))
}

/// Returns a card of a report: a short text in large letters above an explanation.
pub(crate) fn card(big: &str, small: &str, is_bad: bool) -> String {
    let class = if is_bad { "card bad" } else { "card" };
    format!("<div class=\"{class}\"><b>{}</b><span>{}</span></div>\n", prose(big), prose(small))
}

/// Returns a figure of curves, drawn in the colours of the page.
pub(crate) fn curves(figure: &Figure) -> String {
    if figure.is_empty() {
        return String::new();
    }
    format!("<figure class=\"plot\">\n{}</figure>\n", figure.inline(&figure.title))
}

/// Returns a figure of bars, drawn in the colours of the page.
pub(crate) fn bars(bars: &Bars) -> String {
    match bars.inline(&bars.title) {
        inner if inner.is_empty() => inner,
        inner => format!("<figure class=\"plot\">\n{inner}</figure>\n"),
    }
}

/// Returns a table whose cells contain markup, as made by [`text`] and [`instant`]; empty without
/// rows. Columns with neither a name nor a cell with content are left out.
pub(crate) fn table_of(head: &[(&str, Column)], rows: &[Vec<String>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let has_text = |row: &Vec<String>, k: usize| row.get(k).is_some_and(|cell| !cell.is_empty());
    let is_used = |k: usize| !head[k].0.is_empty() || rows.iter().any(|row| has_text(row, k));
    let used: Vec<usize> = (0..head.len()).filter(|k| is_used(*k)).collect();
    let cells = |row: &Vec<String>| used.iter().filter_map(|k| row.get(*k).cloned()).collect();
    let rows: Vec<Vec<String>> = rows.iter().map(cells).collect();
    let head: Vec<_> = used.iter().map(|k| (escape(head[*k].0), head[*k].1)).collect();
    // A table that is wider than the page can be scrolled, also by keyboard.
    format!(
        "<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"table\">{}</div>\n",
        page::table(&head, &rows)
    )
}

/// Returns a table that shows at most its first `most` rows; the other rows are collapsed.
pub(crate) fn long_table(head: &[(&str, Column)], rows: &[Vec<String>], most: usize) -> String {
    let (first, more) = rows.split_at(rows.len().min(most));
    let summary = match more.len() {
        1 => "one more".to_owned(),
        count => format!("{count} more"),
    };
    table_of(head, first) + &folded(&summary, &table_of(head, more))
}

/// Returns a table cell with plain text.
pub(crate) fn text(text: &str) -> String {
    escape(text)
}

/// Returns a table cell with a time, s, as a link that shows the robot at this time.
pub(crate) fn instant(time: f64) -> String {
    if !time.is_finite() {
        return text("-");
    }
    let mut exact = String::new();
    stiction_draw::numbers::exact(&mut exact, time);
    format!("<a href=\"#t={exact}\">{}</a>", escape(&number(time)))
}

/// Returns a list of warnings; empty without warnings.
pub(crate) fn warnings<'a>(all: impl IntoIterator<Item = &'a String>) -> String {
    let items: String = all.into_iter().map(|one| format!("<li>{}</li>\n", prose(one))).collect();
    match items.is_empty() {
        true => items,
        false => format!("<ul class=\"warnings\" title=\"warnings\">\n{items}</ul>\n"),
    }
}

/// Returns a row of cards.
pub(crate) fn cards(cards: &[String]) -> String {
    format!("<div class=\"cards\">\n{}</div>\n", cards.concat())
}

/// Returns a whole HTML page without scripts.
pub(crate) fn page(title: &str, inner: &str) -> String {
    page::page(title, STYLE, inner)
}

/// Returns a whole HTML page with an animated robot.
pub(crate) fn page_with_robot(title: &str, inner: &str) -> String {
    page::page_with_viewer(title, &format!("{STYLE}{}", stiction_draw::viewer::STYLE), inner)
}
