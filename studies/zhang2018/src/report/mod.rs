//! A report: sections of text, equations, tables and figures, written once and given as a page for a
//! browser, as Markdown and as CSV files.
//!
//! A report is data: its author does not choose how it looks. Text is inline CommonMark: `**strong**`,
//! `*emphasis*`, `` `code` `` and `[words](#section)`, with `<sub>` and `<sup>` for indices and powers;
//! other HTML is plain text. Links lead to the name of a section, to `table-` or `figure-` and the name
//! of a file of numbers, or to `eq-` and the number of an equation in lower case.

mod defects;
mod files;
mod html;
mod json;
mod markdown;
mod markup;
mod terminal;

use stiction_draw::figure::Figure;
use stiction_draw::numbers::{fixed, not_finite, significant};

/// Text with marks, see the module.
pub type Text = String;

/// A whole report.
#[derive(Clone, Debug)]
pub struct Report {
    /// Its title; plain.
    pub title: String,
    /// What it is and for whom, under the title.
    pub lead: Vec<Text>,
    /// Its sections, in reading order.
    pub sections: Vec<Section>,
    /// Sources and version, at the end.
    pub footer: Vec<Text>,
}

/// One section.
#[derive(Clone, Debug)]
pub struct Section {
    /// Where links point to: lower-case letters, digits and hyphens.
    pub id: String,
    /// Its title; plain.
    pub title: String,
    /// What it says, in reading order.
    pub blocks: Vec<Block>,
}

/// A piece of a section.
#[derive(Clone, Debug)]
pub enum Block {
    /// A paragraph.
    Paragraph(Text),
    /// A list without order.
    List(Vec<Text>),
    /// A sentence that the section comes down to.
    Finding(Finding, Text),
    /// A formula on a line of its own, with the number that its source gave it, if any.
    Equation {
        /// The source's number, without brackets.
        number: String,
        /// The formula.
        formula: Text,
    },
    /// A table.
    Table(Table),
    /// Curves.
    Curves {
        /// Name of its file of numbers, without ending.
        id: String,
        /// What is drawn.
        figure: Figure,
        /// What it shows.
        caption: Text,
    },
    /// A picture.
    Picture {
        /// A complete `<svg>` element that follows the page's colours.
        svg: String,
        /// What it shows.
        caption: Text,
    },
}

/// How a [`Block::Finding`] ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// What was claimed holds.
    Right,
    /// What was claimed does not hold.
    Wrong,
    /// It cannot be decided from what was published.
    Open,
    /// A statement that answers no claim.
    Note,
}

/// Rows under named columns.
#[derive(Clone, Debug)]
pub struct Table {
    /// Name of its file of numbers, without ending.
    pub id: String,
    /// What it shows.
    pub caption: Text,
    /// Its columns.
    pub columns: Vec<Column>,
    /// Its rows, each with one cell for each column.
    pub rows: Vec<Vec<Cell>>,
}

/// A column of a [`Table`].
#[derive(Clone, Debug)]
pub struct Column {
    /// Its name.
    pub name: Text,
    /// The unit of its numbers; empty if they have none.
    pub unit: String,
}

/// A cell of a [`Table`].
#[derive(Clone, Debug)]
pub enum Cell {
    /// Words.
    Text(Text),
    /// A number, shown with so many significant digits; files have all of them.
    Number(f64, usize),
    /// A number shown with so many digits after the point; files have all of them.
    Fixed(f64, usize),
    /// Nothing.
    Empty,
}

impl Finding {
    /// It in a word.
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
    /// A column.
    pub fn new(name: impl Into<Text>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }
}

impl Table {
    /// A table without rows.
    pub fn new<const N: usize>(id: &str, caption: &str, columns: [(&str, &str); N]) -> Self {
        let columns = columns.map(|(name, unit)| Column::new(name, unit));
        Self { id: id.into(), caption: caption.into(), columns: columns.into(), rows: Vec::new() }
    }
}

impl Table {
    /// Whether most of what the k-th column has are numbers.
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

    /// Its number as it is shown, with plain signs; nothing if there is none.
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
