//! Descriptions of twists in words.

use super::{Twist, Vec3};
use crate::words::brief;

/// Describes the instantaneous motion of a twist, for example
/// `rotation about y through (0.1, 0, 0.3) m`.
///
/// Positions refer to the reference point of `twist`. A screw motion is described by its axis and
/// pitch. A motion counts as a translation if its angular velocity times `length` (m) is negligible
/// compared with its velocity.
pub(crate) fn describe_motion(twist: Twist<f64>, length: f64) -> String {
    let turning = twist.angular.norm() * length;
    let moving = twist.linear.norm();
    let Some(axis) = twist.angular.direction().filter(|_| turning > 1e-9 * moving) else {
        return match twist.linear.direction() {
            Some(direction) => format!("translation along {}", describe_direction(direction)),
            None => "no motion".to_owned(),
        };
    };
    let omega = twist.angular.norm();
    // The point of the screw axis nearest to the reference point, and the pitch, m/rad.
    let point = twist.angular.cross(twist.linear) * (1.0 / (omega * omega));
    let pitch = twist.angular.dot(twist.linear) / (omega * omega);
    let place =
        format!("about {} through {}", describe_direction(axis), describe_point(point, length));
    if pitch.abs() > 1e-9 * length {
        format!("screw {place}, pitch {} mm/rev", round(pitch * core::f64::consts::TAU * 1e3))
    } else {
        format!("rotation {place}")
    }
}

/// Describes a direction by the name of an axis or by components; the sign of the direction is
/// ignored.
pub(crate) fn describe_direction(direction: Vec3<f64>) -> String {
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        if direction.component(k).abs() > 1.0 - 1e-9 {
            return name.to_owned();
        }
    }
    let components = direction.to_array();
    // Choose the sign that makes the first significant component positive.
    let leading = components.iter().find(|c| c.abs() > 1e-6).copied().unwrap_or(1.0);
    let clean = |c: f64| if c.abs() < 1e-6 { 0.0 } else { c * leading.signum() };
    let [x, y, z] = components.map(|c| round(clean(c)));
    format!("({x}, {y}, {z})")
}

fn describe_point(point: Vec3<f64>, length: f64) -> String {
    let clean = |c: f64| if c.abs() < 1e-6 * length { 0.0 } else { c };
    let [x, y, z] = point.to_array().map(|c| round(clean(c)));
    format!("({x}, {y}, {z}) m")
}

/// Formats a number with four significant digits; a value that is not finite is formatted as `?`.
fn round(x: f64) -> String {
    if x.is_finite() { brief(x, 4) } else { "?".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words() {
        let y = Vec3::unit(1);
        let about_y = Twist::rotation(y, Vec3::new(0.1, 5.0, 0.3));
        assert_eq!(describe_motion(about_y, 0.3), "rotation about y through (0.1, 0, 0.3) m");
        let along = Twist::translation(Vec3::new(-0.6, 0.0, 0.8));
        assert_eq!(describe_motion(along, 0.3), "translation along (0.6, 0, -0.8)");
        let screw = Twist::rotation(y, Vec3::zero()) + Twist::translation(y * 0.001);
        assert_eq!(
            describe_motion(screw, 0.3),
            "screw about y through (0, 0, 0) m, pitch 6.283 mm/rev"
        );
        assert_eq!(describe_motion(Twist::zero(), 0.3), "no motion");
    }
}
