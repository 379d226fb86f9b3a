//! HTML form of a report: one self-contained file without scripts.

use super::markup::{html as marked, is_name, plain};
use super::{Block, Cell, Finding, Report, Section, Table};
use std::collections::HashSet;
use stiction_draw::figure::Figure;
use stiction_draw::page::{self, Column};
use stiction_draw::xml::escape;

const STYLE: &str = include_str!("style.css");
/// Text length, in letters, above which a table cell gets a wide style.
const NARROW: usize = 24;

impl Report {
    /// The report as an HTML page that is also well-formed XML. It loads no external resources,
    /// follows the reader's light or dark mode, and is printable.
    pub fn html(&self) -> String {
        let mut page = Page::default();
        let mut inner = format!("<header>\n<h1>{}</h1>\n", escape(&self.title));
        for text in &self.lead {
            inner += &format!("<p class=\"lead\">{}</p>\n", marked(text));
        }
        inner += "</header>\n";
        let mut contents = String::new();
        let mut sections = String::new();
        for (k, section) in self.sections.iter().enumerate() {
            let (entry, inner) = page.section(k + 1, section);
            contents += &entry;
            sections += &inner;
        }
        // The contents appear twice, for wide and for narrow screens: without a script, a list that
        // is open on wide screens cannot be folded on narrow ones.
        if self.sections.len() > 1 {
            inner += &format!("<nav aria-label=\"Contents\"><ol>\n{contents}</ol></nav>\n");
            inner += &format!(
                "<details class=\"contents\"><summary>Contents</summary><ol>\n{contents}</ol>\
                 </details>\n"
            );
        }
        inner += &format!("<main>\n{sections}</main>\n");
        if !self.footer.is_empty() {
            let texts = self.footer.iter().map(|text| format!("<p>{}</p>\n", marked(text)));
            inner += &format!("<footer>\n{}</footer>\n", texts.collect::<String>());
        }
        let inner = format!("<div class=\"page\">\n{inner}</div>\n");
        page::page(&self.title, STYLE, &inner)
    }
}

/// Counters and names used so far.
#[derive(Default)]
struct Page {
    names: HashSet<String>,
    tables: usize,
    figures: usize,
}

impl Page {
    /// Returns the attribute that makes a name a link target, unless the name already is one.
    fn place(&mut self, name: String) -> String {
        if !is_name(&name) || self.names.contains(&name) {
            return String::new();
        }
        let attribute = format!(" id=\"{name}\"");
        self.names.insert(name);
        attribute
    }

    /// Returns the section's entry in the table of contents, and its HTML.
    fn section(&mut self, number: usize, section: &Section) -> (String, String) {
        let title = escape(&section.title);
        let place = self.place(section.id.clone());
        let (mut entry, mut count) = (title.clone(), number.to_string());
        if !place.is_empty() {
            entry = format!("<a href=\"#{}\">{title}</a>", section.id);
            count = format!("<a href=\"#{}\">{number}</a>", section.id);
        }
        let heading = format!("<h2><span class=\"count\">{count}</span> {title}</h2>\n");
        let blocks: String = section.blocks.iter().map(|block| self.block(block)).collect();
        let inner = format!("<section{place}>\n{heading}{blocks}</section>\n");
        (format!("<li>{entry}</li>\n"), inner)
    }

    fn block(&mut self, block: &Block) -> String {
        match block {
            Block::Paragraph(text) => format!("<p>{}</p>\n", marked(text)),
            Block::List(items) if items.is_empty() => String::new(),
            Block::List(items) => {
                let items = items.iter().map(|item| format!("<li>{}</li>\n", marked(item)));
                format!("<ul>\n{}</ul>\n", items.collect::<String>())
            }
            Block::Finding(finding, text) => format!(
                "<p class=\"finding {}\"><strong class=\"verdict\">{}</strong> {}</p>\n",
                class(*finding),
                finding.word(),
                marked(text)
            ),
            Block::Equation { number, formula } => self.equation(number, formula),
            Block::Table(table) => self.table(table),
            Block::Curves { id, figure, caption } => self.curves(id, figure, caption),
            Block::Picture { svg, caption } => {
                self.figures += 1;
                let label = format!("Figure {}", self.figures);
                format!(
                    "<figure class=\"picture\">\n{svg}\n{}</figure>\n",
                    self::caption(&label, caption)
                )
            }
        }
    }

    fn equation(&mut self, number: &str, formula: &str) -> String {
        let (mut place, mut count) = (String::new(), String::new());
        if !number.is_empty() {
            place = self.place(format!("eq-{}", number.to_lowercase()));
            // Replace hyphens between numbers by en dashes.
            let number = escape(number).replace('-', "–");
            count = format!("<span class=\"count\">({number})</span>");
        }
        let formula = marked(formula);
        format!(
            "<div class=\"equation\"{place}><span class=\"formula\">{formula}</span> {count}</div>\n"
        )
    }

    fn table(&mut self, table: &Table) -> String {
        self.tables += 1;
        let label = format!("Table {}", self.tables);
        let place = self.place(format!("table-{}", table.id));
        let head: Vec<(String, Column)> = (0..table.columns.len())
            .map(|k| {
                let column = &table.columns[k];
                let unit = match column.unit.as_str() {
                    "" => String::new(),
                    unit => format!(" <span class=\"unit\">[{}]</span>", escape(unit)),
                };
                let stance = if table.is_numeric(k) { Column::Number } else { Column::Text };
                (marked(&column.name) + &unit, stance)
            })
            .collect();
        let row = |row: &Vec<Cell>| {
            (0..head.len()).map(|k| row.get(k).map_or(String::new(), cell)).collect()
        };
        let rows: Vec<Vec<String>> = table.rows.iter().map(row).collect();
        let mut inner = format!(
            "<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"{label}\">{}</div>\n",
            page::table(&head, &rows)
        );
        if rows.is_empty() {
            inner += "<p class=\"nothing\">This table has no rows.</p>\n";
        }
        format!(
            "<figure class=\"table\"{place}>\n{}{inner}</figure>\n",
            caption(&label, &table.caption)
        )
    }

    fn curves(&mut self, id: &str, figure: &Figure, text: &str) -> String {
        self.figures += 1;
        let label = format!("Figure {}", self.figures);
        let place = self.place(format!("figure-{id}"));
        let inner = if figure.is_empty() {
            "<p class=\"nothing\">There is nothing to draw.</p>\n".to_owned()
        } else {
            // Names of link targets contain no underscores, so this one is unique.
            figure.inline(&label)
        };
        format!("<figure class=\"plot\"{place}>\n{inner}{}</figure>\n", caption(&label, text))
    }
}

fn class(finding: Finding) -> &'static str {
    match finding {
        Finding::Right => "right",
        Finding::Wrong => "wrong",
        Finding::Open => "open",
        Finding::Note => "note",
    }
}

fn caption(label: &str, text: &str) -> String {
    format!("<figcaption><b>{label}.</b> {}</figcaption>\n", marked(text))
}

fn cell(cell: &Cell) -> String {
    match cell {
        // Avoid tall, narrow columns of long texts.
        Cell::Text(text) if plain(text).chars().count() > NARROW => {
            format!("<div class=\"long\">{}</div>", marked(text))
        }
        Cell::Text(text) => marked(text),
        Cell::Empty => String::new(),
        Cell::Number(x, _) | Cell::Fixed(x, _) if x.is_nan() => cell.shown(),
        Cell::Number(..) | Cell::Fixed(..) => typeset(&cell.shown()),
    }
}

/// Typesets the signs of a number: `-1.5e-7` becomes −1.5 × 10 to the −7.
fn typeset(number: &str) -> String {
    let number = number.replace('-', "−");
    match number.split_once('e') {
        Some((digits, power)) => format!("{digits}\u{202f}×\u{202f}10<sup>{power}</sup>"),
        None => number,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_typeset() {
        assert_eq!(cell(&Cell::Number(-1.5e-7, 2)), "−1.5\u{202f}×\u{202f}10<sup>−7</sup>");
        assert_eq!(cell(&Cell::Fixed(-2.25, 1)), "−2.2");
        assert_eq!(cell(&Cell::Fixed(f64::NEG_INFINITY, 1)), "−∞");
        assert_eq!(cell(&Cell::Number(f64::NAN, 1)), "none");
    }

    #[test]
    fn a_place_is_named_once() {
        let mut page = Page::default();
        assert_eq!(page.place("a-1".into()), " id=\"a-1\"");
        assert_eq!(page.place("a-1".into()), "");
        assert_eq!(page.place("a\"b".into()), "");
        assert_eq!(page.place(String::new()), "");
    }
}
