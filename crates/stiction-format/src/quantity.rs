//! Parses single quantities with units, for options of programs.

use crate::expression::unit::Scale;
use crate::expression::{Dimension, Measure, constant, parse, unit_of};
use crate::parameters::Parameters;

/// Parses a time, returned in s: a plain number (`0.01`), or an expression with units (`10 ms`,
/// `1 min + 30 s`).
///
/// ```
/// use stiction_format::seconds;
///
/// assert_eq!(seconds("0.25"), Ok(0.25));
/// assert_eq!(seconds("250 ms"), Ok(0.25));
/// assert_eq!(seconds("3 mm").unwrap_err(), "expected a time, found a length");
/// assert_eq!(seconds("2 deg").unwrap_err(), "expected a time, found an angle");
/// assert_eq!(seconds("20 %").unwrap_err(), "expected a time, found a number in percent");
/// ```
///
/// # Errors
/// If the text is not a time, returns the reason in one line.
pub fn seconds(text: &str) -> Result<f64, String> {
    quantity(text, Measure::Time)
}

/// Parses a frequency, returned in Hz: a plain number (`20`), or an expression with units (`20 Hz`,
/// `1/(50 ms)`).
///
/// ```
/// use stiction_format::hertz;
///
/// assert_eq!(hertz("20 Hz"), Ok(20.0));
/// assert_eq!(hertz("0.2 kHz"), Ok(200.0));
/// assert_eq!(hertz("3 mm").unwrap_err(), "expected a frequency, found a length");
/// assert!(hertz("20 rad/s").unwrap_err().contains("2*pi"));
/// ```
///
/// # Errors
/// If the text is not a frequency, returns the reason in one line.
pub fn hertz(text: &str) -> Result<f64, String> {
    quantity(text, Measure::Frequency)
}

/// Parses a length, returned in m, or an angle, returned in rad: a plain number, or an expression
/// with units.
///
/// ```
/// use stiction_format::length_or_angle;
///
/// assert_eq!(length_or_angle("2 mm"), Ok(0.002));
/// assert_eq!(length_or_angle("2 mrad"), Ok(0.002));
/// assert!(length_or_angle("3 s").unwrap_err().contains("a length or an angle"));
/// ```
///
/// # Errors
/// If the text is neither a length nor an angle, returns the reason in one line.
pub fn length_or_angle(text: &str) -> Result<f64, String> {
    let length = quantity(text, Measure::Length);
    let other = |why: String| why.replace("expected a length", "expected a length or an angle");
    length.or_else(|why| quantity(text, Measure::Angle).map_err(|_| other(why)))
}

/// Parses the rate of a length, returned in m/s, or of an angle, returned in rad/s: a plain number,
/// or an expression with units.
///
/// ```
/// use stiction_format::speed;
///
/// assert_eq!(speed("50 mm/s", false), Ok(0.05));
/// assert_eq!(speed("1 rev/s", true), Ok(std::f64::consts::TAU));
/// assert_eq!(speed("5 m/s", true).unwrap_err(), "expected an angular speed, found a velocity");
/// ```
///
/// # Errors
/// If the text is not a rate of this kind, returns the reason in one line.
pub fn speed(text: &str, is_of_angle: bool) -> Result<f64, String> {
    quantity(text, if is_of_angle { Measure::AngularSpeed } else { Measure::Speed })
}

fn quantity(text: &str, measure: Measure) -> Result<f64, String> {
    if let Ok(number) = text.trim().parse() {
        return Ok(number);
    }
    let scope = Parameters::default();
    let quantity = parse(text, &scope, false)
        .and_then(|program| constant(&program, &scope))
        .map_err(|fault| fault.message)?;
    let dimension = quantity.dimension;
    if measure == Measure::Frequency && dimension.has_angle() {
        return Err("a frequency is in cycles per second: divide an angular frequency by 2*pi rad"
            .to_owned());
    }
    match measure.complaint(dimension) {
        None => Ok(quantity.value),
        Some(_) => {
            Err(format!("expected {}, found {}", measure.words().noun, dimension.describe()))
        }
    }
}

/// A number with a unit, as in `20 mm`; without a unit it is in SI units.
///
/// ```
/// use stiction_format::Amount;
///
/// let stroke = Amount::parse("0.3 m").unwrap();
/// assert_eq!((stroke.number, stroke.unit.as_str()), (0.3, "m"));
/// assert_eq!(stroke.to_unit("mm"), Ok(300.0));
/// assert_eq!(stroke.to_unit("kg").unwrap_err(), "a length cannot be in kg");
/// assert!(Amount::parse("2*l1").is_err());
/// assert!(Amount::parse("50 %").unwrap().to_unit("rad").is_err());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Amount {
    /// The number as written.
    pub number: f64,
    /// The unit as written; empty for none.
    pub unit: String,
}

impl Amount {
    /// Parses a finite number with an optional unit.
    ///
    /// # Errors
    /// If the text is not a finite number with an optional unit, returns the reason in one line.
    pub fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let is_of_number = |(at, c): &(usize, char)| match c {
            '0'..='9' | '.' => true,
            '+' | '-' => *at == 0 || text[..*at].ends_with(['e', 'E']),
            // The letter belongs to an exponent only if a digit or a sign follows; else it begins a
            // unit.
            'e' | 'E' => {
                text[at + 1..].starts_with(|c: char| c.is_ascii_digit() || "+-".contains(c))
            }
            _ => false,
        };
        let end = text.char_indices().find(|at| !is_of_number(at)).map_or(text.len(), |(at, _)| at);
        let (digits, unit) = text.split_at(end);
        let number = digits.parse::<f64>().ok().filter(|number| number.is_finite());
        let number = number.ok_or_else(|| format!("`{text}` does not begin with a number"))?;
        let unit = unit.trim();
        if !unit.is_empty() {
            unit_of(unit).map_err(|fault| format!("`{unit}` is not a unit: {}", fault.message))?;
        }
        Ok(Self { number, unit: unit.to_owned() })
    }

    /// Converts the number to another unit of the same dimension, rounded to 15 digits; the number
    /// is returned unchanged if the unit is the same.
    ///
    /// # Errors
    /// If the number cannot be converted to the unit, returns the reason in one line.
    pub fn to_unit(&self, unit: &str) -> Result<f64, String> {
        // Zero needs no unit.
        if unit == self.unit || (self.unit.is_empty() && self.number == 0.0) {
            return Ok(self.number);
        }
        let read = |unit: &str| match unit {
            "" => Ok((Scale::ONE, Dimension::NONE)),
            unit => unit_of(unit).map_err(|fault| format!("`{unit}`: {}", fault.message)),
        };
        let ((own, dimension), (other, expected)) = (read(&self.unit)?, read(unit)?);
        let is_alike = dimension.same(expected)
            && dimension.is_angle() == expected.is_angle()
            && dimension.is_ratio() == expected.is_ratio();
        if !is_alike || self.unit.is_empty() || unit.is_empty() {
            return Err(match self.unit.as_str() {
                "" => format!("{} has no unit, but {unit} is expected", self.number),
                _ if unit.is_empty() => {
                    format!("{} {} has a unit, but the others have none", self.number, self.unit)
                }
                _ => format!("{} cannot be in {unit}", dimension.describe()),
            });
        }
        let ten = Scale { factor: own.factor / other.factor, ten: own.ten - other.ten };
        Ok(decimal(ten.apply(self.number)))
    }
}

/// Rounds `x` to 15 significant digits, to remove rounding errors in the last bits.
pub(crate) fn decimal(x: f64) -> f64 {
    format!("{x:.14e}").parse().unwrap_or(x)
}
