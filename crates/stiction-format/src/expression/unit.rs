//! Units of measurement.

use super::dimension::Dimension;
use std::f64::consts::PI;

/// A unit: its scale relative to the SI unit, and its dimension.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unit {
    pub(crate) name: &'static str,
    pub(crate) scale: Scale,
    pub(crate) dimension: Dimension,
}

/// Size of a unit in SI units, `factor * 10^ten`. The power of ten is separate so that it can be added to the decimal
/// exponent of a number: `"128.48 mm"` is then exactly `0.12848`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    pub(crate) factor: f64,
    pub(crate) ten: i32,
}

impl Scale {
    pub(crate) const ONE: Self = Self { factor: 1.0, ten: 0 };

    /// Converts `x` to SI units.
    pub(crate) fn apply(self, x: f64) -> f64 {
        let tens = 10f64.powi(self.ten.abs());
        self.factor * if self.ten < 0 { x / tens } else { x * tens }
    }

    /// Converts a number, given by its decimal digits, to SI units. If the unit is a power of ten
    /// of the SI unit, the result is rounded only once.
    pub(crate) fn apply_to_digits(self, digits: &str) -> f64 {
        let (mantissa, exponent) = digits.split_once(['e', 'E']).unwrap_or((digits, "0"));
        let exponent = exponent.parse::<i32>().ok().and_then(|e| e.checked_add(self.ten));
        let shifted = exponent.and_then(|e| format!("{mantissa}e{e}").parse::<f64>().ok());
        match (self.ten, shifted) {
            (0, _) | (_, None) => self.apply(digits.parse().unwrap_or(f64::NAN)),
            (_, Some(shifted)) => self.factor * shifted,
        }
    }

    /// Scale of the product of this unit and the unit `other` raised to `power`; `None` if the
    /// scale is too large or too small.
    pub(crate) fn times(self, other: Self, power: f64) -> Option<Self> {
        let ten = f64::from(other.ten) * power;
        // A fractional power of ten cannot be kept as an integer exponent.
        let (ten, rest) = if ten.fract() == 0.0 { (ten, 1.0) } else { (0.0, 10f64.powf(ten)) };
        let own = if other.factor == 1.0 { 1.0 } else { other.factor.powf(power) };
        let factor = self.factor * own * rest;
        let ten = f64::from(self.ten) + ten;
        let sound = ten.abs() <= 300.0 && factor.is_finite() && factor > 0.0;
        sound.then_some(Self { factor, ten: ten as i32 })
    }
}

const fn unit(name: &'static str, factor: f64, ten: i32, dimension: Dimension) -> Unit {
    Unit { name, scale: Scale { factor, ten }, dimension }
}

const LENGTH: Dimension = Dimension::LENGTH;
const MASS: Dimension = Dimension::MASS;
const TIME: Dimension = Dimension::TIME;
const ANGLE: Dimension = Dimension::ANGLE;
const RATE: Dimension = Dimension::of(0, 0, -1);
const FORCE: Dimension = Dimension::of(1, 1, -2);
const ENERGY: Dimension = Dimension::of(2, 1, -2);
const POWER: Dimension = Dimension::of(2, 1, -3);
const PRESSURE: Dimension = Dimension::of(-1, 1, -2);
const CURRENT: Dimension = Dimension::NONE.with_current(1);

/// All units that expressions can use.
pub(crate) const UNITS: &[Unit] = &[
    unit("m", 1.0, 0, LENGTH),
    unit("km", 1.0, 3, LENGTH),
    unit("cm", 1.0, -2, LENGTH),
    unit("mm", 1.0, -3, LENGTH),
    unit("um", 1.0, -6, LENGTH),
    unit("nm", 1.0, -9, LENGTH),
    unit("in", 254.0, -4, LENGTH),
    unit("ft", 3048.0, -4, LENGTH),
    unit("kg", 1.0, 0, MASS),
    unit("g", 1.0, -3, MASS),
    unit("lb", 45_359_237.0, -8, MASS),
    unit("s", 1.0, 0, TIME),
    unit("ms", 1.0, -3, TIME),
    unit("us", 1.0, -6, TIME),
    unit("ns", 1.0, -9, TIME),
    unit("min", 60.0, 0, TIME),
    unit("h", 3600.0, 0, TIME),
    unit("rad", 1.0, 0, ANGLE),
    unit("mrad", 1.0, -3, ANGLE),
    unit("deg", PI / 180.0, 0, ANGLE),
    unit("rev", 2.0 * PI, 0, ANGLE),
    unit("N", 1.0, 0, FORCE),
    unit("mN", 1.0, -3, FORCE),
    unit("kN", 1.0, 3, FORCE),
    unit("lbf", 4.448_221_615_260_5, 0, FORCE),
    unit("J", 1.0, 0, ENERGY),
    unit("mJ", 1.0, -3, ENERGY),
    unit("kJ", 1.0, 3, ENERGY),
    unit("W", 1.0, 0, POWER),
    unit("kW", 1.0, 3, POWER),
    unit("Hz", 1.0, 0, RATE),
    unit("kHz", 1.0, 3, RATE),
    unit("rpm", PI / 30.0, 0, RATE.with_angle(1)),
    unit("Pa", 1.0, 0, PRESSURE),
    unit("kPa", 1.0, 3, PRESSURE),
    unit("MPa", 1.0, 6, PRESSURE),
    unit("GPa", 1.0, 9, PRESSURE),
    unit("bar", 1.0, 5, PRESSURE),
    unit("%", 1.0, -2, Dimension::PERCENT),
    unit("A", 1.0, 0, CURRENT),
    unit("mA", 1.0, -3, CURRENT),
];

/// Finds a unit by name.
pub(crate) fn find(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.name == name)
}

/// Tests if a parameter may have the name of this unit, so that the name then means the parameter.
/// This is true for the units of current, whose short names (`A`) are common for amplitudes and
/// areas.
pub(crate) fn yields_to_parameters(name: &str) -> bool {
    find(name).is_some_and(|unit| unit.dimension == CURRENT)
}

/// Advice for common misspellings of units, such as `sec` or `Nm`; `None` for any other name.
pub(crate) fn advice(name: &str) -> Option<String> {
    const MEANT: &[(&str, &str)] = &[
        ("degree", "deg"),
        ("degrees", "deg"),
        ("Deg", "deg"),
        ("°", "deg"),
        ("radian", "rad"),
        ("radians", "rad"),
        ("sec", "s"),
        ("second", "s"),
        ("seconds", "s"),
        ("meter", "m"),
        ("metre", "m"),
        ("meters", "m"),
        ("millimeter", "mm"),
        ("millimetre", "mm"),
        ("centimeter", "cm"),
        ("centimetre", "cm"),
        ("micrometer", "um"),
        ("micrometre", "um"),
        ("micron", "um"),
        ("inch", "in"),
        ("inches", "in"),
        ("foot", "ft"),
        ("kilogram", "kg"),
        ("kilogramme", "kg"),
        ("gram", "g"),
        ("pound", "lb"),
        ("minute", "min"),
        ("hour", "h"),
        ("millisecond", "ms"),
        ("joule", "J"),
        ("watt", "W"),
        ("pascal", "Pa"),
        ("hertz", "Hz"),
        ("newton", "N"),
        ("Newton", "N"),
        ("µm", "um"),
        ("μm", "um"),
        ("tau", "2*pi"),
        ("RPM", "rpm"),
        ("hz", "Hz"),
    ];
    let singular = name.strip_suffix('s').unwrap_or(name);
    if let Some((_, meant)) = MEANT.iter().find(|(typed, _)| *typed == name || *typed == singular) {
        return Some(format!("write `{meant}`"));
    }
    // `Nm` is two units written as one; `kgm2` also lacks the sign of a power.
    let bare = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let power = name.get(bare.len()..).filter(|digits| !digits.is_empty());
    let power = power.map_or(String::new(), |digits| format!("^{digits}"));
    if find(bare).is_some() && !power.is_empty() {
        return Some(format!("write `{bare}{power}`"));
    }
    bare.char_indices().skip(1).find_map(|(at, _)| {
        let (first, second) = bare.split_at_checked(at)?;
        (find(first).is_some() && find(second).is_some())
            .then(|| format!("write `{first} {second}{power}`"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_known_in_si() {
        // Definitions (NIST SP 811, appendix B), computed here in a different way.
        for (name, value) in [
            ("in", 0.0254),
            ("ft", 12.0 * 0.0254),
            ("lb", 0.453_592_37),
            ("lbf", 0.453_592_37 * 9.806_65),
            ("deg", std::f64::consts::TAU / 360.0),
            ("rpm", std::f64::consts::TAU / 60.0),
            ("bar", 1e5),
        ] {
            let si = find(name).unwrap().scale.apply(1.0);
            // Each computation rounds once.
            assert!((si / value - 1.0).abs() < 4.0 * f64::EPSILON, "{name}: {si}");
        }
        let mm = find("mm").unwrap().scale;
        assert_eq!(mm.apply_to_digits("128.48"), 0.12848);
        assert_eq!(mm.apply_to_digits("1.2848e2"), 0.12848);
        assert_eq!(mm.times(mm, 1.0).unwrap().apply_to_digits("1.42e4"), 0.0142);
        assert_eq!(find("deg").unwrap().scale.apply_to_digits("180"), PI);
    }

    #[test]
    fn names_are_unique() {
        for (i, unit) in UNITS.iter().enumerate() {
            assert!(UNITS[..i].iter().all(|other| other.name != unit.name), "{}", unit.name);
        }
    }

    #[test]
    fn common_misspellings_get_advice() {
        assert_eq!(advice("Nm").as_deref(), Some("write `N m`"));
        assert_eq!(advice("kgm2").as_deref(), Some("write `kg m^2`"));
        assert_eq!(advice("m2").as_deref(), Some("write `m^2`"));
        assert_eq!(advice("xyz"), None);
    }
}
