//! Functions available in expressions.

use super::jet::Jet;

/// Function that expressions can call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Log,
    Sqrt,
    Abs,
    Min,
    Max,
    Smooth,
    /// Sign of a number. It is allowed only in formulas of measured coordinates, because
    /// simulations locate the jumps of only these formulas.
    Sign,
}

/// Rule for the dimensions of a function's arguments and result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// Dimensionless argument (or angle), dimensionless result.
    Plain,
    /// Arguments of the same dimension; the result has this dimension.
    Keep,
    /// Arguments of the same dimension, dimensionless result.
    Ratio,
    /// The result has the square root of the argument's dimension.
    Root,
}

impl Function {
    /// All functions with their names.
    pub(crate) const ALL: &[(&str, Self)] = &[
        ("sin", Self::Sin),
        ("cos", Self::Cos),
        ("tan", Self::Tan),
        ("asin", Self::Asin),
        ("acos", Self::Acos),
        ("atan", Self::Atan),
        ("atan2", Self::Atan2),
        ("sinh", Self::Sinh),
        ("cosh", Self::Cosh),
        ("tanh", Self::Tanh),
        ("exp", Self::Exp),
        ("log", Self::Log),
        ("sqrt", Self::Sqrt),
        ("abs", Self::Abs),
        ("min", Self::Min),
        ("max", Self::Max),
        ("smooth", Self::Smooth),
        ("sign", Self::Sign),
    ];

    /// Returns the function with this name.
    pub(crate) fn find(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|&(_, function)| function)
    }

    /// Name of the function.
    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, f)| *f == self).map_or("", |&(name, _)| name)
    }

    /// Signature of the function for messages.
    pub(crate) fn usage(self) -> String {
        let arguments = match self {
            Self::Atan2 => "y, x",
            Self::Min | Self::Max => "a, b, …",
            Self::Smooth => "t, t0, t1",
            _ => "x",
        };
        format!("{}({arguments})", self.name())
    }

    /// Minimum and maximum number of arguments.
    pub(crate) fn arity(self) -> (usize, usize) {
        match self {
            Self::Atan2 => (2, 2),
            Self::Min | Self::Max => (2, 1000),
            Self::Smooth => (3, 3),
            _ => (1, 1),
        }
    }

    /// Rule for the dimensions of the function's arguments and result.
    pub(crate) fn rule(self) -> Rule {
        match self {
            Self::Atan2 | Self::Smooth | Self::Sign => Rule::Ratio,
            Self::Abs | Self::Min | Self::Max => Rule::Keep,
            Self::Sqrt => Rule::Root,
            _ => Rule::Plain,
        }
    }

    /// Evaluates the function; missing arguments count as NaN.
    pub(crate) fn apply(self, arguments: &[Jet]) -> Jet {
        let argument = |k: usize| arguments.get(k).copied().unwrap_or(Jet::constant(f64::NAN));
        let fold = |pick: fn(Jet, Jet) -> Jet| {
            arguments.iter().skip(1).fold(argument(0), |a, &b| pick(a, b))
        };
        let x = argument(0);
        match self {
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Atan2 => x.atan2(argument(1)),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Tanh => x.tanh(),
            Self::Exp => x.exp(),
            Self::Log => x.ln(),
            Self::Sqrt => x.sqrt(),
            Self::Abs => x.abs(),
            Self::Min => fold(Jet::min),
            Self::Max => fold(Jet::max),
            Self::Smooth => x.smooth(argument(1), argument(2)),
            Self::Sign => Jet::constant(x.value.signum()),
        }
    }

    /// Phrase that explains why the result for these arguments is not finite; `None` if there is no
    /// specific reason.
    pub(crate) fn complaint(self, arguments: &[Jet]) -> Option<&'static str> {
        let x = arguments.first()?.value;
        match self {
            Self::Sqrt if x < 0.0 => Some("the square root of a negative number"),
            Self::Sqrt if x == 0.0 => Some("the derivative of the root is infinite at 0"),
            Self::Log if x <= 0.0 => Some("the logarithm of a number that is not positive"),
            Self::Asin | Self::Acos if x.abs() > 1.0 => {
                Some("the argument is outside the range from -1 to 1")
            }
            Self::Asin | Self::Acos if x.abs() == 1.0 => {
                Some("the derivative is infinite at -1 and 1")
            }
            Self::Atan2 => Some("`atan2(0, 0)` is undefined"),
            Self::Smooth => Some("t0 and t1 are equal"),
            _ => None,
        }
    }
}
