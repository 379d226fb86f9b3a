//! Dimensions: powers of metre, kilogram, second and ampere.

use std::fmt::Write;

/// The number that represents the exponent 1. Exponents are stored in twelfths, so that square,
/// cube and fourth roots are exact.
const ONE: i16 = 12;

/// Dimension of a quantity. Angles and percentages are dimensionless; the powers of their units are
/// stored only to distinguish them from plain numbers, so that `30 deg` and `50 %` given as a length
/// are errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct Dimension {
    metre: i16,
    kilogram: i16,
    second: i16,
    ampere: i16,
    radian: i16,
    percent: i16,
}

impl Dimension {
    pub(crate) const NONE: Self =
        Self { metre: 0, kilogram: 0, second: 0, ampere: 0, radian: 0, percent: 0 };
    pub(crate) const LENGTH: Self = Self::of(1, 0, 0);
    pub(crate) const MASS: Self = Self::of(0, 1, 0);
    pub(crate) const TIME: Self = Self::of(0, 0, 1);
    pub(crate) const ANGLE: Self = Self { radian: ONE, ..Self::NONE };
    pub(crate) const PERCENT: Self = Self { percent: ONE, ..Self::NONE };

    /// Dimension with these integer powers of m, kg, s.
    pub(crate) const fn of(metre: i16, kilogram: i16, second: i16) -> Self {
        let (metre, kilogram, second) = (metre * ONE, kilogram * ONE, second * ONE);
        Self { metre, kilogram, second, ..Self::NONE }
    }

    /// Returns this dimension with the power of the ampere set to `power`.
    pub(crate) const fn with_current(self, power: i16) -> Self {
        Self { ampere: power * ONE, ..self }
    }

    /// Returns this dimension with the power of the angle unit set to `power`.
    pub(crate) const fn with_angle(self, power: i16) -> Self {
        Self { radian: power * ONE, ..self }
    }

    /// Tests if the dimension is that of a plain number or an angle.
    pub(crate) fn is_none(self) -> bool {
        self.same(Self::NONE)
    }

    /// Tests if the dimension is a nonzero power of the angle unit and contains no other unit.
    pub(crate) fn is_angle(self) -> bool {
        self.is_none() && self.radian != 0
    }

    /// Tests if the dimension is that of a number in percent and contains no other unit.
    pub(crate) fn is_ratio(self) -> bool {
        self.is_none() && self.radian == 0 && self.percent != 0
    }

    /// Tests if the dimension is that of a number without any unit, also without `deg` and `%`.
    pub(crate) fn is_bare(self) -> bool {
        self.is_none() && !self.is_angle() && !self.is_ratio()
    }

    /// Tests if the power of the angle unit is not 0.
    pub(crate) fn has_angle(self) -> bool {
        self.radian != 0
    }

    /// Tests if quantities of the two dimensions can be added; powers of the angle unit and of
    /// percent are ignored.
    pub(crate) fn same(self, other: Self) -> bool {
        Self { radian: 0, percent: 0, ..self } == Self { radian: 0, percent: 0, ..other }
    }

    /// Dimension of a sum of quantities of dimensions that are [`same`](Self::same).
    pub(crate) fn sum(self, other: Self) -> Self {
        // An angle plus a plain number remains an angle. In other arithmetic, percentages are plain
        // numbers.
        let is_self = self.is_angle() || (self.is_bare() && other.is_ratio());
        if is_self { self } else { other }
    }

    /// Tests if the power of time is not 0.
    pub(crate) fn has_time(self) -> bool {
        self.second != 0
    }

    /// Dimension of a product or quotient of numbers: in arithmetic, percentages are plain numbers.
    pub(crate) fn of_arithmetic(self) -> Self {
        Self { percent: 0, ..self }
    }

    /// Dimension of a product; `None` if a power overflows.
    pub(crate) fn times(self, other: Self) -> Option<Self> {
        self.combine(other, i16::checked_add)
    }

    /// Dimension of a quotient; `None` if a power overflows.
    pub(crate) fn over(self, other: Self) -> Option<Self> {
        self.combine(other, i16::checked_sub)
    }

    /// Dimension of a quantity of this dimension raised to the power `exponent`. `None` if a power
    /// of a base unit in the result is not a multiple of 1/12 or is greater than 100.
    pub(crate) fn power(self, exponent: f64) -> Option<Self> {
        let scale = |power: i16| {
            let scaled = f64::from(power) * exponent;
            let whole = scaled.round();
            // Exponents such as 1/3 contain rounding errors.
            let representable = (scaled - whole).abs() < 1e-6 && whole.abs() <= 1200.0;
            representable.then_some(whole as i16)
        };
        Some(Self {
            metre: scale(self.metre)?,
            kilogram: scale(self.kilogram)?,
            second: scale(self.second)?,
            ampere: scale(self.ampere)?,
            // The angle and percent are informative and never cause an error.
            radian: scale(self.radian).unwrap_or(0),
            percent: scale(self.percent).unwrap_or(0),
        })
    }

    fn combine(self, other: Self, op: fn(i16, i16) -> Option<i16>) -> Option<Self> {
        Some(Self {
            metre: op(self.metre, other.metre)?,
            kilogram: op(self.kilogram, other.kilogram)?,
            second: op(self.second, other.second)?,
            ampere: op(self.ampere, other.ampere)?,
            radian: op(self.radian, other.radian).unwrap_or(0),
            percent: op(self.percent, other.percent).unwrap_or(0),
        })
    }

    /// Phrase for a quantity of this dimension, such as `a length`.
    pub(crate) fn describe(self) -> String {
        if self.is_angle() {
            return "an angle".to_owned();
        }
        if self.is_ratio() {
            return "a number in percent".to_owned();
        }
        NAMES.iter().find(|(dimension, _)| dimension.same(self)).map_or_else(
            || format!("a quantity in {}", self.units()),
            |(_, name)| (*name).to_owned(),
        )
    }

    /// SI unit of quantities of this dimension, for example `kg m^2/s^2`. Angle units are omitted.
    pub(crate) fn units(self) -> String {
        let powers =
            [("kg", self.kilogram), ("m", self.metre), ("s", self.second), ("A", self.ampere)];
        let write = |sign: i16| {
            let mut text = String::new();
            for (unit, power) in powers.iter().filter(|(_, power)| power.signum() == sign) {
                let power = f64::from(power.abs()) / f64::from(ONE);
                let space = if text.is_empty() { "" } else { " " };
                // Writing to a string cannot fail.
                let _ = match power {
                    1.0 => write!(text, "{space}{unit}"),
                    _ => write!(text, "{space}{unit}^{power}"),
                };
            }
            text
        };
        let (above, below) = (write(1), write(-1));
        match (above.is_empty(), below.is_empty(), below.contains(' ')) {
            (_, true, _) => above,
            (true, _, false) => format!("1/{below}"),
            (true, _, true) => format!("1/({below})"),
            (false, _, false) => format!("{above}/{below}"),
            (false, _, true) => format!("{above}/({below})"),
        }
    }
}

const NAMES: &[(Dimension, &str)] = &[
    (Dimension::NONE, "a plain number"),
    (Dimension::LENGTH, "a length"),
    (Dimension::MASS, "a mass"),
    (Dimension::TIME, "a time"),
    (Dimension::of(2, 0, 0), "an area"),
    (Dimension::of(3, 0, 0), "a volume"),
    (Dimension::of(1, 0, -1), "a velocity"),
    (Dimension::of(1, 0, -2), "an acceleration"),
    (Dimension::of(0, 0, -1), "a rate (1/s)"),
    (Dimension::of(0, 0, -2), "an angular acceleration (1/s^2)"),
    (Dimension::of(1, 1, -2), "a force"),
    (Dimension::of(2, 1, -2), "a moment (or energy)"),
    (Dimension::of(2, 1, 0), "a moment of inertia"),
    (Dimension::of(1, 1, 0), "a mass times a length"),
    (Dimension::of(0, 1, -1), "a viscous coefficient (N s/m)"),
    (Dimension::of(2, 1, -1), "a viscous coefficient of rotation (N m s)"),
    (Dimension::of(0, 1, -2), "a stiffness (N/m)"),
    (Dimension::of(2, 1, -3), "a power"),
    (Dimension::of(-1, 1, -2), "a pressure"),
    (Dimension::of(-3, 1, 0), "a density"),
    (Dimension::of(0, 0, 0).with_current(1), "a current"),
    (Dimension::of(2, 1, -2).with_current(-1), "a torque per current"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dimensions_are_named_or_written_out() {
        for (dimension, words) in [
            (Dimension::of(0, 0, 0), "a plain number"),
            (Dimension::ANGLE, "an angle"),
            (Dimension::of(1, 1, -2), "a force"),
            (Dimension::of(2, 3, -4), "a quantity in kg^3 m^2/s^4"),
            (Dimension::of(-1, 0, -1), "a quantity in 1/(m s)"),
        ] {
            assert_eq!(dimension.describe(), words);
        }
        let root = Dimension::LENGTH.power(0.5).unwrap();
        assert_eq!(root.describe(), "a quantity in m^0.5");
        assert!(root.times(root).unwrap().same(Dimension::LENGTH));
        assert_eq!(Dimension::LENGTH.power(0.37), None);
        assert_eq!(Dimension::of(2, 0, 0).power(1e9), None);
    }
}
