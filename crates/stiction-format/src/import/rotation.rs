//! Rotations in the notations of robot files.

use stiction_core::spatial::{Mat3, Pose, Quaternion, Vec3};

/// Tolerance, rad, within which an angle counts as an exact multiple of a quarter turn. It covers
/// rounding errors of pi/2 written with all digits.
const EXACT: f64 = 4e-16;

/// Sine and cosine of an angle, rad; exact at multiples of a quarter turn.
fn sin_cos(angle: f64) -> (f64, f64) {
    let quarters = (angle / std::f64::consts::FRAC_PI_2).round();
    if quarters.abs() <= 8.0 && (angle - quarters * std::f64::consts::FRAC_PI_2).abs() <= EXACT {
        return match (quarters as i64).rem_euclid(4) {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            2 => (0.0, -1.0),
            _ => (-1.0, 0.0),
        };
    }
    angle.sin_cos()
}

/// Rotation by `angle`, rad, about the coordinate axis with index `axis` (0 to 2).
pub(super) fn about(axis: usize, angle: f64) -> Mat3<f64> {
    Mat3::about_axis(axis, sin_cos(angle))
}

/// Rotation by roll, pitch and yaw, rad, about the fixed axes x, y and z.
pub(super) fn roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> Mat3<f64> {
    about(2, yaw) * about(1, pitch) * about(0, roll)
}

/// Rotation by three angles, rad, in the sequence `order`: small letters mean rotation about moving
/// axes, capital letters about fixed axes. `None` unless `order` consists of three letters x, y or
/// z.
pub(super) fn euler(angles: [f64; 3], order: &str) -> Option<Mat3<f64>> {
    let mut rotation = Mat3::identity();
    let mut letters = order.chars();
    for angle in angles {
        let letter = letters.next()?;
        let axis = match letter.to_ascii_lowercase() {
            'x' => 0,
            'y' => 1,
            'z' => 2,
            _ => return None,
        };
        let step = about(axis, angle);
        rotation = if letter.is_ascii_lowercase() { rotation * step } else { step * rotation };
    }
    letters.next().is_none().then_some(rotation)
}

/// Rotation of a quaternion `w x y z` of any length; `None` for zero.
pub(super) fn quaternion(q: [f64; 4]) -> Option<Mat3<f64>> {
    let largest = q.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if largest == 0.0 {
        return None;
    }
    let scaled = q.map(|x| x / largest);
    Some(Quaternion::from_coordinates(&scaled).normalised().rotation())
}

/// Pose with the position `x`, `y`, `z` and the angles roll, pitch and yaw, rad.
pub(super) fn pose([x, y, z]: [f64; 3], angles: [f64; 3]) -> Pose<f64> {
    Pose { position: Vec3::new(x, y, z), rotation: roll_pitch_yaw(angles) }
}

/// Smallest rotation that maps the z axis to `axis`; exact if `axis` is a coordinate axis.
pub(super) fn z_to(axis: Vec3<f64>) -> Mat3<f64> {
    let x = Vec3::unit(0);
    let y = Vec3::unit(1);
    let z = Vec3::unit(2);
    let exact = [
        (z, Mat3::identity()),
        (-z, Mat3::from_columns(-x, y, -z)),
        (x, Mat3::from_columns(-z, y, x)),
        (-x, Mat3::from_columns(z, y, -x)),
        (y, Mat3::from_columns(x, -z, y)),
        (-y, Mat3::from_columns(x, z, -y)),
    ];
    match exact.into_iter().find(|(known, _)| *known == axis) {
        Some((_, rotation)) => rotation,
        None => Mat3::between(z, axis),
    }
}

/// Rotation whose z axis is `axis` and whose x axis is the component of `x` perpendicular to
/// `axis`. `None` if this component or `axis` is zero.
pub(super) fn z_and_x(axis: Vec3<f64>, x: Vec3<f64>) -> Option<Mat3<f64>> {
    let z = axis.direction()?;
    let x = (x + z * -z.dot(x)).direction()?;
    Some(Mat3::from_columns(x, z.cross(x), z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conventions_agree() {
        let angles = [0.3, -0.7, 1.1];
        let [a, b, c] = angles;
        let fixed = roll_pitch_yaw(angles);
        // Rotations about fixed axes x, y, z equal rotations about moving axes z, y, x.
        let same = [euler([c, b, a], "zyx").unwrap(), euler(angles, "XYZ").unwrap()];
        for other in same {
            for k in 0..9 {
                assert!((fixed.at(k / 3, k % 3) - other.at(k / 3, k % 3)).abs() < 1e-15);
            }
        }
        assert!(euler(angles, "xyw").is_none() && euler(angles, "xyzx").is_none());
        let half = quaternion([0.0, 0.0, 0.0, 3e200]).unwrap();
        assert_eq!(half.columns[0], Vec3::new(-1.0, 0.0, 0.0));
        for axis in [0, 1, 2] {
            for sign in [1.0, -1.0] {
                let axis = Vec3::unit(axis) * sign;
                let frame = z_to(axis);
                assert_eq!(frame.columns[2], axis);
                assert_eq!(frame.columns[0].cross(frame.columns[1]), axis);
            }
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        let turn = about(2, std::f64::consts::FRAC_PI_2);
        assert_eq!(turn.columns[0], Vec3::new(0.0, 1.0, 0.0));
    }
}
