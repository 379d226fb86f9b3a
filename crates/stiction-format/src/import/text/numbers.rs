//! Formats numbers with units as a person would write them in a model file.

use stiction_core::spatial::{Mat3, Vec3};

/// Relative changes up to this size are attributed to rounding by the program that wrote the file.
const ROUNDING: f64 = 6e-16;
/// Digits after the first significant digit: a number written by a person has at most 12
/// significant digits.
const DIGITS: usize = 11;

/// Returns the nearest number with few digits if its difference from `value` is within rounding
/// error, else `value`. The rounding error is relative to the larger of `|value|` and `scale`.
pub(super) fn rounded(value: f64, scale: f64) -> f64 {
    let tolerance = ROUNDING * value.abs().max(scale);
    if value.abs() <= tolerance {
        return 0.0;
    }
    let short: f64 = format!("{value:.*e}", DIGITS).parse().unwrap_or(value);
    if (short - value).abs() <= tolerance { short } else { value }
}

/// Formats `value` times 10 to the power `power` by shifting the decimal point, without rounding.
pub(super) fn shifted(value: f64, power: i32) -> String {
    let text = format!("{value:e}");
    let Some((digits, exponent)) = text.split_once('e') else { return text };
    let exponent: i32 = exponent.parse::<i32>().unwrap_or(0) + power;
    let (sign, digits) = match digits.strip_prefix('-') {
        Some(rest) => ("-", rest),
        None => ("", digits),
    };
    let plain: String = digits.chars().filter(|c| *c != '.').collect();
    if plain.chars().all(|c| c == '0') {
        return "0".to_owned();
    }
    if !(-5..=15).contains(&exponent) {
        return format!("{sign}{digits}e{exponent}");
    }
    let point = 1 + exponent;
    let (whole, rest) = if point <= 0 {
        ("0".to_owned(), "0".repeat(-point as usize) + &plain)
    } else if (point as usize) < plain.len() {
        (plain[..point as usize].to_owned(), plain[point as usize..].to_owned())
    } else {
        (format!("{plain}{}", "0".repeat(point as usize - plain.len())), String::new())
    };
    let rest = rest.trim_end_matches('0');
    if rest.is_empty() { format!("{sign}{whole}") } else { format!("{sign}{whole}.{rest}") }
}

/// Formats a value with its unit, in quotes; zero is written as a plain number.
pub(super) fn quantity(value: f64, unit: &str) -> String {
    let value = rounded(value, 0.0);
    if value == 0.0 { "0".to_owned() } else { format!("\"{} {unit}\"", shifted(value, 0)) }
}

/// Formats a length in mm, or in m if it is at least 100 m.
pub(super) fn length(value: f64) -> String {
    // In robots of about a metre, lengths below 1e-15 m are rounding errors.
    let value = rounded(value, 1.0);
    match value.abs() {
        0.0 => "0".to_owned(),
        size if size < 100.0 => format!("\"{} mm\"", shifted(value, 3)),
        _ => format!("\"{} m\"", shifted(value, 0)),
    }
}

/// Formats a vector as a list of lengths.
pub(super) fn lengths(v: Vec3<f64>) -> String {
    let [x, y, z] = v.to_array().map(length);
    format!("[{x}, {y}, {z}]")
}

/// Formats an angle, given in rad, in degrees if four decimals suffice, else in rad.
pub(super) fn angle(value: f64) -> String {
    let degrees = rounded_degrees(value);
    match (value, degrees) {
        (0.0, _) => "0".to_owned(),
        (_, Some(0.0)) => "0".to_owned(),
        (_, Some(degrees)) => format!("\"{} deg\"", shifted(degrees, 0)),
        _ => format!("\"{} rad\"", shifted(rounded(value, 1.0), 0)),
    }
}

/// Converts an angle from rad to degrees; returns `None` if the angle in degrees has more than four
/// decimals.
fn rounded_degrees(value: f64) -> Option<f64> {
    let degrees = value.to_degrees();
    let short = (degrees * 1e4).round() / 1e4;
    ((short.to_radians() - value).abs() <= ROUNDING * value.abs().max(1.0)).then_some(short)
}

/// Formats the initial guess of a coordinate, given in rad or m, in degrees or mm with at most
/// eight decimals.
pub(super) fn guess(value: f64, is_angle: bool) -> String {
    match is_angle {
        true => format!("\"{} deg\"", shifted(decimals(value.to_degrees(), 1e8), 0)),
        false => format!("\"{} mm\"", shifted(decimals(value * 1e3, 1e8), 0)),
    }
}

fn decimals(value: f64, ten: f64) -> f64 {
    let rounded = (value * ten).round() / ten;
    if rounded == 0.0 { 0.0 } else { rounded }
}

/// Formats a direction as the name of a coordinate axis, or as a vector.
pub(super) fn axis(v: Vec3<f64>) -> String {
    let v = v.to_array().map(|x| rounded(x, 1.0));
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        let others = (0..3).filter(|other| *other != k).all(|other| v[other] == 0.0);
        if others && v[k] != 0.0 {
            return if v[k] > 0.0 { format!("\"{name}\"") } else { format!("\"-{name}\"") };
        }
    }
    let [x, y, z] = v.map(|x| shifted(x, 0));
    format!("[{x}, {y}, {z}]")
}

/// Formats an inertia tensor as three moments of inertia if all products of inertia are 0, else as
/// a table of entries.
pub(super) fn inertia(tensor: Mat3<f64>) -> String {
    let scale = (0..3).map(|k| tensor.at(k, k).abs()).fold(0.0, f64::max);
    let entry = |i: usize, j: usize| {
        let value = rounded(tensor.at(i, j), scale);
        if value == 0.0 { "0".to_owned() } else { format!("\"{} kg m^2\"", shifted(value, 0)) }
    };
    let diagonal = [entry(0, 0), entry(1, 1), entry(2, 2)];
    let products = [("xy", entry(0, 1)), ("xz", entry(0, 2)), ("yz", entry(1, 2))];
    if products.iter().all(|(_, product)| product == "0") {
        return format!("[{}]", diagonal.join(", "));
    }
    let [xx, yy, zz] = diagonal;
    let products: Vec<String> = products
        .iter()
        .filter(|(_, product)| product != "0")
        .map(|(key, product)| format!("{key} = {product}"))
        .collect();
    format!("{{ xx = {xx}, yy = {yy}, zz = {zz}, {} }}", products.join(", "))
}

/// Tests if a rotation is the identity up to rounding.
pub(super) fn is_none(rotation: Mat3<f64>) -> bool {
    distance(rotation, Mat3::identity()) <= ROUNDING
}

fn distance(a: Mat3<f64>, b: Mat3<f64>) -> f64 {
    (0..9).map(|k| (a.at(k / 3, k % 3) - b.at(k / 3, k % 3)).abs()).fold(0.0, f64::max)
}

/// Formats a rotation as an axis with an angle, or as three angles in whole degrees about z, y and
/// x.
pub(super) fn rotation(rotation: Mat3<f64>) -> String {
    let vector = rotation.rotation_vector();
    let turn = vector.norm();
    let direction = vector.direction().unwrap_or(Vec3::unit(2));
    let axis_angle = |direction: Vec3<f64>| {
        // The written angle is positive, except about a negative coordinate axis: a turn about -z is written as a
        // negative turn about z.
        let flip = [0, 1, 2].into_iter().any(|k| direction == -Vec3::unit(k));
        let (direction, turn) = if flip { (-direction, -turn) } else { (direction, turn) };
        format!("{{ axis = {}, angle = {} }}", axis(direction), angle(turn))
    };
    for k in 0..3 {
        for unit in [Vec3::unit(k), -Vec3::unit(k)] {
            if distance(Mat3::rotation(unit, turn), rotation) <= 2.0 * ROUNDING {
                return axis_angle(unit);
            }
        }
    }
    if let Some(angles) = short_angles(rotation) {
        let [z, y, x] = angles.map(|degrees| angle(degrees.to_radians()));
        return format!("{{ zyx = [{z}, {y}, {x}] }}");
    }
    axis_angle(direction)
}

/// Returns the intrinsic angles about z, the new y and the new x, in degrees, if all three are
/// whole numbers; else `None`.
fn short_angles(rotation: Mat3<f64>) -> Option<[f64; 3]> {
    let pitch = (-rotation.at(2, 0)).atan2(rotation.at(0, 0).hypot(rotation.at(1, 0)));
    let (yaw, roll) = if pitch.cos() > 1e-6 {
        (rotation.at(1, 0).atan2(rotation.at(0, 0)), rotation.at(2, 1).atan2(rotation.at(2, 2)))
    } else {
        ((-rotation.at(0, 1)).atan2(rotation.at(1, 1)), 0.0)
    };
    let angles = [yaw, pitch, roll].map(|angle| angle.to_degrees().round());
    let [z, y, x] = angles.map(f64::to_radians);
    let turn = |k: usize, angle: f64| Mat3::about_axis(k, angle.sin_cos());
    let again = turn(2, z) * turn(1, y) * turn(0, x);
    (distance(again, rotation) <= 2.0 * ROUNDING).then_some(angles)
}

#[cfg(test)]
#[expect(clippy::excessive_precision, clippy::approx_constant, reason = "digits of exporters")]
mod tests {
    use super::*;

    #[test]
    fn points_are_shifted_exactly() {
        for (value, power, text) in [
            (0.041, 3, "41"),
            (-0.5, 0, "-0.5"),
            (1.25e-5, 3, "0.0125"),
            (123.0, 3, "123000"),
            (0.0, 3, "0"),
            (-0.0, 0, "0"),
            (6e-9, 0, "6e-9"),
            (0.042018709005587948, 3, "42.01870900558795"),
        ] {
            assert_eq!(shifted(value, power), text);
        }
    }

    #[test]
    fn rounding_of_exporters_is_removed_and_nothing_else() {
        assert_eq!(length(0.050000000000000009714), "\"50 mm\"");
        assert_eq!(length(2.7755575615628913511e-17), "0");
        assert_eq!(length(0.042018709005587948), "\"42.01870900558795 mm\"");
        assert_eq!(angle(1.570796326794896558), "\"90 deg\"");
        assert_eq!(angle(0.872664), "\"0.872664 rad\"");
        assert_eq!(rounded(-8.65005e-9, 1.0), -8.65005e-9);
    }

    #[test]
    fn rotations_read_back() {
        let turn = |k: usize, angle: f64| Mat3::about_axis(k, angle.sin_cos());
        assert_eq!(
            rotation(turn(2, -0.5 * std::f64::consts::PI)),
            r#"{ axis = "z", angle = "-90 deg" }"#
        );
        let quarter = 0.5 * std::f64::consts::PI;
        assert_eq!(
            rotation(turn(2, quarter) * turn(0, quarter)),
            r#"{ zyx = ["90 deg", 0, "90 deg"] }"#
        );
        assert!(rotation(turn(2, 0.3) * turn(0, 0.2)).starts_with("{ axis = ["));
    }
}
