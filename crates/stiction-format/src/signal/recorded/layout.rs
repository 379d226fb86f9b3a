//! Assignment of the columns of a recording file to curves.

use super::lines::{Cells, Delimiter, lines, parse_number, unify_line_ends};
use crate::expression::unit::Scale;
use crate::signal::Interpolation;
use crate::source::{Begin, Source};

/// Selection of the values that the curves need from each row: the time, then the values of each
/// curve.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// Separator of the columns.
    pub(crate) delimiter: Delimiter,
    /// For each column of the file, the index of its value among the selected values (`None` if no
    /// curve needs it), and its unit.
    pub(crate) columns: Vec<(Option<usize>, Scale)>,
    /// Interpolation of each curve between samples.
    pub(crate) interpolations: Vec<Interpolation>,
}

impl Layout {
    /// Number of values that the curves need from each row, including the time.
    pub(crate) fn width(&self) -> usize {
        1 + self.interpolations.iter().map(|interpolation| interpolation.columns()).sum::<usize>()
    }

    /// Returns the interpolation of each curve, and the range of the curve's values among the
    /// selected values.
    pub(crate) fn curves(
        &self,
    ) -> impl Iterator<Item = (Interpolation, std::ops::Range<usize>)> + '_ {
        let mut next = 1;
        self.interpolations.iter().map(move |&interpolation| {
            let first = next;
            next += interpolation.columns();
            (interpolation, first..next)
        })
    }

    /// Copies the values that the curves need from a row of the file to `kept`.
    pub(crate) fn pick(&self, row: &[f64], kept: &mut [f64]) {
        for ((place, _), value) in self.columns.iter().zip(row) {
            if let Some(kept) = place.and_then(|place| kept.get_mut(place)) {
                *kept = *value;
            }
        }
    }

    /// Reads the columns that the curves need, in SI units, from a part of the file that was read
    /// before. `begin` is the byte offset of this part. Returns `None` if a row can no longer be
    /// read.
    pub(crate) fn read(&self, text: String, begin: u64) -> Option<Vec<Vec<f64>>> {
        let source = Source::piece("", unify_line_ends(text), Begin { bytes: begin, lines: 0 });
        let mut columns = vec![Vec::new(); self.width()];
        let mut cells = Cells::new(self.delimiter);
        for line in lines(&source) {
            let mut known = self.columns.iter();
            for cell in cells.split(&source.text, line, self.columns.len()) {
                let (place, scale) = known.next()?;
                let Some(column) = place.and_then(|place| columns.get_mut(place)) else { continue };
                column.push(scale.apply(parse_number(source.text.get(cell.clone())?)?));
            }
            if known.next().is_some() {
                return None;
            }
        }
        Some(columns)
    }
}
