//! Pieces of a page. Text goes in as it is and comes out escaped; only what is named `inner` is
//! markup already.

use crate::drawing::svg::escape;

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

/// How a column stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Column {
    Text,
    Number,
}

/// A table; nothing without rows.
pub(super) fn table(head: &[(&str, Column)], rows: &[Vec<String>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let cell = |element: &str, column: Column, text: &str| {
        let class = if column == Column::Number { " class=\"number\"" } else { "" };
        format!("<{element}{class}>{}</{element}>", escape(text))
    };
    let mut inner = String::from("<div class=\"wide\"><table>\n<thead><tr>");
    for (name, column) in head {
        inner += &cell("th", *column, name);
    }
    inner += "</tr></thead>\n<tbody>\n";
    for row in rows {
        inner += "<tr>";
        for ((_, column), text) in head.iter().zip(row) {
            inner += &cell("td", *column, text);
        }
        inner += "</tr>\n";
    }
    inner + "</tbody>\n</table></div>\n"
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

/// A whole page.
pub(super) fn page(title: &str, inner: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"color-scheme\" content=\"light dark\"/>\n\
         <title>{}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{inner}</body>\n</html>\n",
        escape(title)
    )
}

const STYLE: &str = "
:root{--ink:#222;--soft:#5c5c5c;--paper:#fff;--edge:#d5d9de;--tint:#f3f5f8;--bad:#a33100;--badtint:#fdf0e8}
@media (prefers-color-scheme:dark){:root{--ink:#e8e8e8;--soft:#a9a9a9;--paper:#1c1f24;--edge:#3d444d;\
--tint:#272b32;--bad:#ffab80;--badtint:#3a2a22}}
*{box-sizing:border-box}
body{margin:0 auto;padding:1rem;max-width:62rem;background:var(--paper);color:var(--ink);\
font:1rem/1.5 system-ui,Helvetica,Arial,sans-serif}
h1{margin:.2rem 0;font-size:1.6rem;line-height:1.25}
h2{margin:2rem 0 .5rem;font-size:1.2rem;border-bottom:1px solid var(--edge)}
h3{margin:1.2rem 0 .3rem;font-size:1rem}
p{margin:.4rem 0}
.note{color:var(--soft);font-size:.9rem}
.source{white-space:pre-line}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(9.5rem,1fr));gap:.6rem;margin:1rem 0}
.card{padding:.6rem .8rem;border:1px solid var(--edge);border-radius:.4rem;background:var(--tint)}
.card b{display:block;font-size:1.35rem;line-height:1.3}
.card span{color:var(--soft);font-size:.85rem}
.card.bad{border-color:var(--bad);background:var(--badtint)}
.card.bad b{color:var(--bad)}
.warnings{margin:1rem 0;padding:.6rem 1rem .6rem 2rem;border-left:.3rem solid var(--bad);\
background:var(--badtint)}
figure{margin:1rem 0}
figure svg{display:block;width:100%;height:auto;max-height:40rem}
figcaption{color:var(--soft);font-size:.9rem;text-align:center}
.views{display:grid;grid-template-columns:repeat(auto-fit,minmax(13rem,1fr));gap:.6rem}
.views figure{margin:0}
.views svg{max-height:none}
.wide{overflow-x:auto}
table{border-collapse:collapse;margin:.5rem 0;font-size:.92rem}
th,td{padding:.15rem .9rem .15rem 0;text-align:left;vertical-align:top}
th{border-bottom:1px solid var(--edge);font-weight:600}
td:last-child:not(.number){min-width:13rem}
tbody tr:nth-child(even){background:var(--tint)}
.number{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
summary{cursor:pointer}
footer{margin-top:2rem;color:var(--soft);font-size:.85rem}
@media print{body{max-width:none;padding:0}section{break-inside:avoid}}
";
