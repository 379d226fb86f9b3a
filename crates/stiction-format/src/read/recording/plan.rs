//! Assignment of the columns of a recording to the curves through its samples.

use super::header::{Header, Role};
use crate::expression::unit::Scale;
use crate::signal::recorded::Layout;
use crate::signal::{Given, Interpolation};

/// Columns and interpolation of each curve of a recording.
pub(super) struct Plan {
    pub(super) layout: Layout,
    /// For each curve, the index in the header of the column with its values.
    pub(super) columns: Vec<usize>,
}

impl Plan {
    /// Assigns the columns of a valid header to curves.
    pub(super) fn of(header: &Header) -> Self {
        let place = |role: Role| header.columns.iter().position(|column| column.role == role);
        let (mut interpolations, mut columns) = (Vec::new(), Vec::new());
        // Indices of the columns that the curves need, in the order in which the layout stores
        // their values.
        let mut kept: Vec<usize> = header.time.into_iter().collect();
        for (index, column) in header.columns.iter().enumerate() {
            let (interpolation, derivatives) = match column.role {
                Role::Coordinate { coordinate, order: 0 } => {
                    let part = |order| place(Role::Coordinate { coordinate, order });
                    let parts: Vec<usize> = [1, 2].into_iter().map_while(part).collect();
                    let given = match parts.as_slice() {
                        [] => Given::Values,
                        [_] => Given::Rates,
                        _ => Given::Accelerations,
                    };
                    (Interpolation::Spline(given), parts)
                }
                Role::Effort(_) => (Interpolation::Monotone, Vec::new()),
                _ => continue,
            };
            interpolations.push(interpolation);
            columns.push(index);
            kept.push(index);
            kept.extend(derivatives);
        }
        let scaled = |(index, column): (usize, &super::header::Column)| -> (Option<usize>, Scale) {
            (kept.iter().position(|&known| known == index), column.scale)
        };
        let layout = Layout {
            delimiter: header.delimiter,
            columns: header.columns.iter().enumerate().map(scaled).collect(),
            interpolations,
        };
        Self { layout, columns }
    }
}
