//! Keys of rigid gearings.

use crate::expression::Measure::Any;
use crate::fields::Shape::{Coefficients, Quantity};
use crate::fields::{Field, field, required};

/// Keys of a rigid gearing.
pub(crate) const GEARING: &[Field] = &[
    required(
        "joints",
        Coefficients,
        "Joints that the gearing connects, each with a coefficient other than 0; for a joint with \
         several degrees of freedom, the name of one, \"joint.dof\". With { a = 1, b = -2 }, the \
         sum a - 2*b is constant. If one of the joints translates, the coefficients of rotations \
         are lengths per angle: { nut = \"5 mm/rev\", slide = -1 }.",
    ),
    field(
        "offset",
        Quantity(Any),
        "Constant value of the sum: an angle, or a length if one of the joints translates; by \
         default 0.",
    ),
];
