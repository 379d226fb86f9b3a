//! Checks the values in a table of unknown type, such as the table of a joint without the key
//! `type`.

use super::context::Record;
use crate::fields::{Field, Shape};

/// Reports values that are invalid for every type of the table.
pub(crate) fn check_values(record: &Record<'_>, fields: &'static [Field]) {
    for field in fields {
        let Some(value) = record.value(field.key) else { continue };
        match field.shape {
            Shape::Quantity(_) => {
                record.quantity(field.key);
            }
            Shape::LinearOrAngular(linear, angular) => {
                record.context.quantity_of(value, &[linear, angular]);
            }
            Shape::Vector(_) => {
                record.vector(field.key);
            }
            Shape::Axis => {
                record.context.axis(value);
            }
            Shape::Rotation => {
                record.context.rotation(value);
            }
            Shape::Table(inner) => {
                if let Some(table) = record.table(field.key) {
                    let what = format!("`{}`", field.key);
                    check_values(&Record::new(record.context, table, inner, what), inner);
                }
            }
            _ => {}
        }
    }
}
