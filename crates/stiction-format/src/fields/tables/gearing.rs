//! Keys of rigid gearings.

use crate::expression::Measure::Any;
use crate::fields::Shape::{Coefficients, Quantity};
use crate::fields::{Field, field, required};

/// Keys of a rigid gearing.
pub(crate) const GEARING: &[Field] = &[
    required(
        "joints",
        Coefficients,
        "Joints that it connects, each with its coefficient, not 0; of joints with several degrees of freedom \
         \"joint.dof\". With { a = 1, b = -2 }, a - 2*b is constant. If one of them translates, the coefficients of \
         rotations are lengths per angle: { nut = \"5 mm/rev\", slide = -1 }.",
    ),
    field(
        "offset",
        Quantity(Any),
        "Value of the sum: an angle, or a length if one of the joints translates; by default 0.",
    ),
];
