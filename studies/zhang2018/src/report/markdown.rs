//! GitHub-flavoured Markdown form of a report, with its pictures as separate files.

use super::markup::{Piece, is_name, parse, plain};
use super::{Block, Cell, Report, Table};
use std::collections::HashSet;

impl Report {
    /// The report as Markdown that references the files of [`Report::pictures`].
    pub fn markdown(&self) -> String {
        let mut pieces = vec![format!("# {}", words(&self.title))];
        pieces.extend(self.lead.iter().map(|text| paragraph(text)));
        let mut count = Count::default();
        for (k, section) in self.sections.iter().enumerate() {
            // Explicit anchors, because GitHub derives other names from titles.
            let place = count.place(section.id.clone());
            let heading = format!("## {} {}", k + 1, words(&section.title));
            pieces.push(format!("{place}\n\n{heading}"));
            pieces.extend(section.blocks.iter().map(|block| count.block(block)));
        }
        if !self.footer.is_empty() {
            pieces.push("---".into());
            pieces.extend(self.footer.iter().map(|text| paragraph(text)));
        }
        pieces.retain(|piece| !piece.is_empty());
        pieces.join("\n\n") + "\n"
    }
}

/// Counters and names used so far.
#[derive(Default)]
struct Count {
    names: HashSet<String>,
    tables: usize,
    figures: usize,
    pictures: usize,
}

impl Count {
    /// Returns the anchor of a link target, unless the name is already in use.
    fn place(&mut self, name: String) -> String {
        if !is_name(&name) || self.names.contains(&name) {
            return String::new();
        }
        let place = format!("<a id=\"{name}\"></a>");
        self.names.insert(name);
        place
    }

    fn block(&mut self, block: &Block) -> String {
        match block {
            Block::Paragraph(text) => paragraph(text),
            Block::List(items) => {
                let items = items.iter().map(|item| format!("- {}", paragraph(item)));
                items.collect::<Vec<_>>().join("\n")
            }
            Block::Finding(finding, text) => {
                format!("> **{}:** {}", finding.word(), line(text))
            }
            Block::Equation { number, formula } if number.is_empty() => {
                format!("> {}", line(formula))
            }
            Block::Equation { number, formula } => {
                let place = self.place(format!("eq-{}", number.to_lowercase()));
                format!("> {place}{} &emsp; ({})", line(formula), words(number))
            }
            Block::Table(table) => self.table(table),
            Block::Curves { id, figure, caption } => {
                self.figures += 1;
                let place = self.place(format!("figure-{id}"));
                let caption = format!("{place}**Figure {}.** {}", self.figures, line(caption));
                if figure.is_empty() {
                    return caption + " There is nothing to draw.";
                }
                format!("![{}]({id}.svg)\n\n{caption}", words(&figure.title))
            }
            Block::Picture { caption, .. } => {
                self.figures += 1;
                self.pictures += 1;
                let name = super::files::picture(self.pictures);
                let (alt, caption) = (words(&plain(caption)), line(caption));
                format!("![{alt}]({name})\n\n**Figure {}.** {caption}", self.figures)
            }
        }
    }

    fn table(&mut self, table: &Table) -> String {
        self.tables += 1;
        let place = self.place(format!("table-{}", table.id));
        let caption = format!("{place}**Table {}.** {}", self.tables, line(&table.caption));
        if table.columns.is_empty() {
            return caption;
        }
        let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let head = table.columns.iter().map(|column| match column.unit.as_str() {
            "" => line(&column.name),
            unit => format!("{} \\[{}\\]", line(&column.name), words(unit)),
        });
        let rule = (0..table.columns.len()).map(|k| match table.is_numeric(k) {
            true => "---:".to_owned(),
            false => "---".to_owned(),
        });
        let mut text = row(head.collect()) + &row(rule.collect());
        for cells in &table.rows {
            let cell = |k| cells.get(k).map_or(String::new(), cell);
            text += &row((0..table.columns.len()).map(cell).collect());
        }
        format!("{caption}\n\n{}", text.trim_end())
    }
}

fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => line(text),
        Cell::Empty => String::new(),
        Cell::Number(..) | Cell::Fixed(..) => cell.shown(),
    }
}

/// Text at the start of a line, with a leading list mark escaped.
fn paragraph(text: &str) -> String {
    let text = line(text);
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    match text.as_bytes().get(digits) {
        Some(b'.' | b')') if digits > 0 => format!("{}\\{}", &text[..digits], &text[digits..]),
        Some(b'-' | b'+' | b'=') if digits == 0 => format!("\\{text}"),
        _ => text,
    }
}

/// Marked-up text on one line. Marks become HTML elements, because Markdown marks depend on
/// adjacent characters.
fn line(text: &str) -> String {
    let piece = |piece: Piece| match piece {
        Piece::Text(text) => words(&text),
        Piece::Code(text) => format!("<code>{}</code>", words(&text)),
        Piece::Begin(element) if element.place().is_some() => "[".to_owned(),
        Piece::Begin(element) => element.begin().unwrap_or_default(),
        Piece::End(element) => match element.place() {
            Some(place) => format!("](#{place})"),
            None => element.end().unwrap_or_default(),
        },
    };
    let line: String = parse(text).into_iter().map(piece).collect();
    line.trim().to_owned()
}

/// Plain words with all Markdown characters escaped, table separators included.
fn words(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut signs = text.chars().peekable();
    let mut before = ' ';
    while let Some(sign) = signs.next() {
        let is_within = |after: &char| before.is_alphanumeric() && after.is_alphanumeric();
        match sign {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // Within a word an underscore is literal; addresses need it unescaped.
            '_' if signs.peek().is_some_and(is_within) => out.push(sign),
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '#' | '~' | '^' | '$' | '!' => {
                out.push('\\');
                out.push(sign);
            }
            sign if sign.is_whitespace() && sign.is_control() => out.push(' '),
            sign if sign.is_control() => {}
            sign => out.push(sign),
        }
        before = sign;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_signs() {
        assert_eq!(paragraph("1. a"), "1\\. a");
        assert_eq!(paragraph("12) a"), "12\\) a");
        assert_eq!(paragraph("- a"), "\\- a");
        assert_eq!(paragraph("-3 N"), "\\-3 N");
        assert_eq!(paragraph("3 N\n# b"), "3 N \\# b");
        assert_eq!(paragraph("\\_a\\_ b_c \u{7}d"), "\\_a\\_ b_c d");
        assert_eq!(paragraph("a | <b> & `c|d`"), "a \\| &lt;b&gt; &amp; <code>c\\|d</code>");
    }

    #[test]
    fn marks_are_kept() {
        let text = "**a** *b* *F*<sub>1</sub><sup>2</sup> [c|](#d)";
        let expected =
            "<strong>a</strong> <em>b</em> <em>F</em><sub>1</sub><sup>2</sup> [c\\|](#d)";
        assert_eq!(line(text), expected);
    }
}
