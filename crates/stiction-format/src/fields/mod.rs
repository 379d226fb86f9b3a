//! Schema of the model file: one list of fields for every kind of table.
//!
//! The lists in [`tables`] are the single source for the reader of model files (unknown and missing
//! keys, units), for the JSON schema, and for the reference in the handbook.

mod schema;
pub(crate) mod tables;

pub use schema::json_schema;

use crate::expression::Measure;

/// A key of a table of the model file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field {
    /// Name of the key in the file.
    pub(crate) key: &'static str,
    /// Form of the value.
    pub(crate) shape: Shape,
    /// True if the key is required. Conditional requirements ("required with mass") are checked by
    /// the reader.
    pub(crate) required: bool,
    /// Description, in a sentence or two.
    pub(crate) doc: &'static str,
}

/// Form of a value.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape {
    /// A string.
    Text,
    /// Name of a part of the model, such as a body or a joint.
    Name,
    /// List of names of parts.
    Names,
    /// One of the given words.
    Choice(&'static [&'static str]),
    /// A number or an expression.
    Quantity(Measure),
    /// A number or an expression for a quantity that is of the first kind for a translation and of
    /// the second kind for a rotation.
    LinearOrAngular(Measure, Measure),
    /// A 6 x 6 matrix: its six diagonal entries, or six rows of six quantities.
    SixBySix(Measure),
    /// List of three quantities of the same kind.
    Vector(Measure),
    /// List of quantities of the same kind.
    Quantities(Measure),
    /// A list of pairs of quantities.
    Pairs(Measure, Measure),
    /// A direction: the name of a coordinate axis, or three numbers.
    Axis,
    /// A rotation: `{ axis, angle }` or three intrinsic angles.
    Rotation,
    /// Inertia: three principal moments or the entries of a tensor.
    Inertia,
    /// Actuation of a joint: `true`, `false`, or the names of the actuated degrees of freedom.
    Actuated,
    /// Initial guess of the coordinates of a joint, for the assembly of the mechanism.
    Start,
    /// Range of a joint: a pair of quantities, or a table of pairs by the name of a degree of
    /// freedom.
    Range,
    /// A table with these keys.
    Table(&'static [Field]),
    /// One table with these keys or a list of such tables.
    OneOrMore(&'static [Field]),
    /// A list of tables with these keys.
    List(&'static [Field]),
    /// A table of named tables, each with these keys.
    Named(&'static [Field]),
    /// A table of named texts.
    Texts,
    /// A table of named quantities of arbitrary kinds.
    Parameters,
    /// A table of coefficients, each under the name of a joint.
    Coefficients,
    /// Motions by name: tables with these keys, and with names of coordinates as further keys.
    Motions(&'static [Field]),
    /// A list of tables with these keys, and with names of coordinates as further keys.
    Waypoints(&'static [Field]),
    /// Limits of motion by the names of coordinates and bodies; a dot in a name leads to a nested
    /// table.
    Limits,
    /// Loads by name: tables with these keys, and with names of bodies as further keys.
    Loads(&'static [Field]),
}

const fn field(key: &'static str, shape: Shape, doc: &'static str) -> Field {
    Field { key, shape, required: false, doc }
}

const fn required(key: &'static str, shape: Shape, doc: &'static str) -> Field {
    Field { key, shape, required: true, doc }
}

/// Concatenates two field lists; `N` is the total length.
const fn joined<const N: usize>(first: &[Field], then: &[Field]) -> [Field; N] {
    assert!(first.len() + then.len() == N);
    let mut all = [first[0]; N];
    let mut at = 0;
    while at < N {
        all[at] = if at < first.len() { first[at] } else { then[at - first.len()] };
        at += 1;
    }
    all
}

impl Field {
    /// The first sentence of the description, without its full stop.
    pub(crate) fn summary(&self) -> &'static str {
        self.doc.split_once(". ").map_or(self.doc, |(first, _)| first).trim_end_matches('.')
    }
}

/// Returns the field with this key; `None` if the list does not contain the key.
pub(crate) fn find(fields: &'static [Field], key: &str) -> Option<&'static Field> {
    fields.iter().find(|field| field.key == key)
}
