//! Reports: sections of text, equations, tables and figures, exported as an HTML page, as Markdown
//! and as CSV files.
//!
//! A report is pure data and contains no layout. Text is inline CommonMark: `**strong**`,
//! `*emphasis*`, `` `code` `` and `[words](#section)`, with `<sub>` and `<sup>` for indices and
//! powers; other HTML is plain text. A link leads to a section id, to `table-` or `figure-` and the
//! file name of the numbers, or to `eq-` and an equation number in lower case.

mod defects;
mod files;
mod html;
mod json;
mod markdown;
mod markup;
mod terminal;

use stiction_draw::figure::Figure;
use stiction_draw::numbers::{fixed, not_finite, significant};

/// Marked-up text in the syntax of the [module](self).
pub type Text = String;

/// A complete report.
#[derive(Clone, Debug)]
pub struct Report {
    /// Title, plain text.
    pub title: String,
    /// Introduction under the title.
    pub lead: Vec<Text>,
    /// Sections in reading order.
    pub sections: Vec<Section>,
    /// Sources and version, at the end.
    pub footer: Vec<Text>,
}

/// One section.
#[derive(Clone, Debug)]
pub struct Section {
    /// Link target: lower-case letters, digits and hyphens.
    pub id: String,
    /// Title, plain text.
    pub title: String,
    /// Contents in reading order.
    pub blocks: Vec<Block>,
}

/// One block of a section.
#[derive(Clone, Debug)]
pub enum Block {
    /// A paragraph.
    Paragraph(Text),
    /// An unordered list.
    List(Vec<Text>),
    /// A concluding statement of the section.
    Finding(Finding, Text),
    /// A display formula, with the equation number of its source, if any.
    Equation {
        /// Equation number in the source, without parentheses.
        number: String,
        /// The formula.
        formula: Text,
    },
    /// A table.
    Table(Table),
    /// A figure of curves.
    Curves {
        /// Name of the data file, without extension.
        id: String,
        /// Curves of the figure.
        figure: Figure,
        /// Caption of the figure.
        caption: Text,
    },
    /// A picture.
    Picture {
        /// A complete `<svg>` element that follows the page's colours.
        svg: String,
        /// Caption of the picture.
        caption: Text,
    },
}

/// Verdict of a [`Block::Finding`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// The claim holds.
    Right,
    /// The claim does not hold.
    Wrong,
    /// The published data do not decide the claim.
    Open,
    /// A statement without a claim.
    Note,
}

/// Rows under named columns.
#[derive(Clone, Debug)]
pub struct Table {
    /// Name of the data file, without extension.
    pub id: String,
    /// Caption of the table.
    pub caption: Text,
    /// Columns of the table.
    pub columns: Vec<Column>,
    /// Rows, each with one cell per column.
    pub rows: Vec<Vec<Cell>>,
}

/// A column of a [`Table`].
#[derive(Clone, Debug)]
pub struct Column {
    /// Column name.
    pub name: Text,
    /// Unit of the numbers; empty if dimensionless.
    pub unit: String,
}

/// A cell of a [`Table`].
#[derive(Clone, Debug)]
pub enum Cell {
    /// A text.
    Text(Text),
    /// A number and its displayed significant digits; files keep full precision.
    Number(f64, usize),
    /// A number and its displayed decimals; files keep full precision.
    Fixed(f64, usize),
    /// An empty cell.
    Empty,
}

impl Finding {
    /// One-word name of the verdict.
    pub fn word(self) -> &'static str {
        match self {
            Self::Right => "Right",
            Self::Wrong => "Wrong",
            Self::Open => "Open",
            Self::Note => "Note",
        }
    }
}

impl Column {
    /// Creates a column.
    pub fn new(name: impl Into<Text>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }
}

impl Table {
    /// Creates a table without rows.
    pub fn new<const N: usize>(id: &str, caption: &str, columns: [(&str, &str); N]) -> Self {
        let columns = columns.map(|(name, unit)| Column::new(name, unit));
        Self { id: id.into(), caption: caption.into(), columns: columns.into(), rows: Vec::new() }
    }
}

impl Table {
    /// Tests for a majority of numbers in the k-th column.
    fn is_numeric(&self, k: usize) -> bool {
        let cells = || self.rows.iter().filter_map(move |row| row.get(k));
        let numbers = cells().filter(|c| matches!(c, Cell::Number(..) | Cell::Fixed(..))).count();
        let words = cells().filter_map(Cell::text).filter(|text| !text.is_empty()).count();
        numbers > 0 && numbers >= words
    }
}

impl Cell {
    fn text(&self) -> Option<&Text> {
        match self {
            Self::Text(text) => Some(text),
            Self::Number(..) | Self::Fixed(..) | Self::Empty => None,
        }
    }

    /// Displayed number with plain signs; empty for other cells.
    fn shown(&self) -> String {
        let (x, text) = match *self {
            Self::Number(x, digits) => (x, significant(x, digits)),
            Self::Fixed(x, decimals) => (x, fixed(x, decimals)),
            Self::Text(_) | Self::Empty => return String::new(),
        };
        not_finite(x).map_or(text, str::to_owned)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}
