//! Reads directions, rotations, poses and inertia tensors.

use super::context::{Context, Record};
use crate::diagnostic::{Diagnostic, did_you_mean, number, quoted};
use crate::document::{Table, Value};
use crate::expression::Measure;
use crate::fields::tables::{AXES, ORDERS, POSE, TENSOR};
use stiction_core::kinematics::AngleOrder;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Tolerance for directions that must be perpendicular, rad; deviations within the tolerance are
/// corrected.
const SQUARE: f64 = 1e-6;

impl Context<'_> {
    /// Reads a unit vector: the name of a coordinate axis, or three numbers.
    pub(crate) fn axis(&self, value: &Value) -> Option<Vec3<f64>> {
        if let Some(name) = value.as_text() {
            let bare = name.strip_prefix(['-', '+']).unwrap_or(name);
            let sign = if name.starts_with('-') { -1.0 } else { 1.0 };
            let axis = match bare {
                "x" => Vec3::new(sign, 0.0, 0.0),
                "y" => Vec3::new(0.0, sign, 0.0),
                "z" => Vec3::new(0.0, 0.0, sign),
                _ => {
                    self.push(
                        Diagnostic::error(
                            "unknown-name",
                            format!("{} is not an axis", quoted(name)),
                        )
                        .at(self.place(&value.span), "not an axis")
                        .maybe_help(did_you_mean(
                            name,
                            "give a vector such as [1, 0, 1], or one of these axes",
                            AXES.iter().copied(),
                        )),
                    );
                    return None;
                }
            };
            return Some(axis);
        }
        if value.as_list().is_none() {
            self.wrong(value, "an axis such as \"z\" or a vector such as [0, 0, 1]");
            return None;
        }
        // Only the direction matters, so the vector may have any length. It is scaled first to
        // avoid overflow.
        let v = self.vector(value, Measure::Number)?;
        let largest = v.to_array().into_iter().map(f64::abs).fold(0.0, f64::max);
        let direction = (v * (1.0 / largest)).direction();
        if direction.is_none() {
            self.push(
                Diagnostic::error("axis", "an axis must not be zero")
                    .at(self.place(&value.span), "a vector of length 0")
                    .help("write the axis as \"z\", or as a vector such as [0, 0, 1]"),
            );
        }
        direction
    }

    /// Reads a rotation: `{ axis, angle }`, or three intrinsic angles under the name of their
    /// order.
    pub(crate) fn rotation(&self, value: &Value) -> Option<Mat3<f64>> {
        const FORMS: &str = "write { axis = \"z\", angle = \"30 deg\" }, or three intrinsic angles with \
                             their order as the key, such as { xyz = [0, \"30 deg\", 0] }";
        let Some(table) = value.as_table() else {
            self.wrong(value, "a rotation such as { axis = \"z\", angle = \"30 deg\" }");
            return None;
        };
        let mut keys = table.entries.iter().map(|(key, _)| key.name.as_str());
        for (key, _) in &table.entries {
            let known = ["axis", "angle"].iter().chain(ORDERS);
            if !known.clone().any(|known| *known == key.name) {
                let message = format!("a rotation has no key {}", quoted(&key.name));
                self.push(
                    Diagnostic::error("unknown-key", message)
                        .at(self.place(&key.span), "unknown key")
                        .help(FORMS),
                );
                return None;
            }
        }
        let (order, axis, angle) =
            (keys.find(|key| ORDERS.contains(key)), table.get("axis"), table.get("angle"));
        match (order, axis, angle) {
            (None, Some(axis), Some(angle)) => {
                let (axis, angle) = (self.axis(axis), self.quantity(angle, Measure::Angle));
                Some(about(axis?, angle?))
            }
            (Some(order), None, None) if table.entries.len() == 1 => {
                let angles = self.vector(table.get(order)?, Measure::Angle)?.to_array();
                let axes = AngleOrder::from_name(order)?.axes();
                let turns = axes.into_iter().zip(angles);
                Some(turns.fold(Mat3::identity(), |all, (axis, angle)| {
                    all * Mat3::about_axis(axis, angle.sin_cos())
                }))
            }
            _ => {
                let message = match (axis, angle) {
                    (Some(_), None) => "a rotation about an axis needs an `angle`",
                    (None, Some(_)) => "a rotation by an angle needs an `axis`",
                    (None, None) if order.is_none() => "the rotation is empty",
                    _ => "the rotation is given in several ways",
                };
                self.push(
                    Diagnostic::error("rotation", message)
                        .at(self.place(&value.span), "not a unique rotation")
                        .help(FORMS),
                );
                None
            }
        }
    }

    /// Reads a pose from the keys `position` and `rotation` of a table; both are optional. `what`
    /// describes the table in messages.
    pub(crate) fn pose(&self, table: &Table, what: &str) -> Option<Pose<f64>> {
        let record = Record::new(self, table, POSE, what);
        let position = record.value("position").map(|_| record.vector("position"));
        let rotation = record.value("rotation").map(|value| self.rotation(value));
        Some(Pose {
            position: position.unwrap_or(Some(Vec3::zero()))?,
            rotation: rotation.unwrap_or(Some(Mat3::identity()))?,
        })
    }

    /// Reads an inertia tensor, kg m², from three moments of inertia or a table of its entries.
    pub(crate) fn inertia(&self, value: &Value) -> Option<Mat3<f64>> {
        let Some(table) = value.as_table() else {
            if value.as_list().is_none() {
                self.wrong(
                    value,
                    "three moments of inertia [xx, yy, zz] or a table { xx, yy, zz, xy, xz, yz }",
                );
                return None;
            }
            if value.as_list().is_some_and(|rows| rows.iter().all(|row| row.as_list().is_some())) {
                self.push(
                    Diagnostic::error(
                        "wrong-type",
                        "an inertia cannot be given as the rows of a matrix",
                    )
                    .at(self.place(&value.span), "a list of lists")
                    .help("write the diagonal [xx, yy, zz], or { xx = 1, yy = 1, zz = 1, xy = 0 }"),
                );
                return None;
            }
            return self.vector(value, Measure::Inertia).map(Mat3::diagonal);
        };
        let mut rows = [[0.0; 3]; 3];
        let mut sound = true;
        for (key, value) in &table.entries {
            let Some(&(_, i, k)) = TENSOR.iter().find(|(name, _, _)| *name == key.name) else {
                let message = format!("an inertia has no entry {}", quoted(&key.name));
                let known = TENSOR.iter().map(|(name, _, _)| *name);
                self.push(
                    Diagnostic::error("unknown-key", message)
                        .at(self.place(&key.span), "unknown entry")
                        .maybe_help(did_you_mean(&key.name, "entries", known)),
                );
                sound = false;
                continue;
            };
            match self.quantity(value, Measure::Inertia) {
                Some(entry) => (rows[i][k], rows[k][i]) = (entry, entry),
                None => sound = false,
            }
        }
        let diagonal = ["xx", "yy", "zz"];
        if sound && !diagonal.iter().any(|key| table.get(key).is_some()) {
            self.push_missing(
                Diagnostic::error("missing-key", "an inertia needs at least one diagonal entry")
                    .at(self.place(&value.span), "none of `xx`, `yy`, `zz`")
                    .help("{ zz = \"1e-3 kg m^2\" } is enough for a planar mechanism"),
            );
            return None;
        }
        let [x, y, z] = rows.map(Vec3::from);
        sound.then_some(Mat3::from_columns(x, y, z))
    }

    /// Returns the unit vector perpendicular to `axis` that is closest to `direction`. Reports a
    /// direction that is not perpendicular to the axis within [`SQUARE`]; `value` locates the
    /// direction in the text.
    pub(crate) fn square_to(
        &self,
        axis: Vec3<f64>,
        direction: Vec3<f64>,
        value: &Value,
        key: &str,
    ) -> Option<Vec3<f64>> {
        let cosine = axis.dot(direction).clamp(-1.0, 1.0);
        if cosine.abs() > SQUARE {
            let angle = number((cosine.acos().to_degrees() * 1e4).round() / 1e4);
            let message = format!("`{key}` must be perpendicular to `axis`");
            self.push(
                Diagnostic::error("axis", message)
                    .at(self.place(&value.span), format!("the angle between them is {angle} deg")),
            );
            return None;
        }
        direction.across(axis).direction()
    }
}

/// Returns the rotation about a unit vector by an angle, rad. For a coordinate axis, the row and
/// the column of this axis have no rounding errors.
pub(crate) fn about(axis: Vec3<f64>, angle: f64) -> Mat3<f64> {
    for (k, component) in axis.to_array().into_iter().enumerate() {
        if component.abs() == 1.0 {
            return Mat3::about_axis(k, (component * angle).sin_cos());
        }
    }
    Mat3::rotation(axis, angle)
}

/// Returns the axes of a joint frame, with z along `axis` and x along `x`, perpendicular unit
/// vectors. By default, x is rotated by the smallest rotation that maps z to the axis; for the axis
/// -z, this is the half turn about y.
pub(crate) fn frame(axis: Vec3<f64>, x: Option<Vec3<f64>>) -> Mat3<f64> {
    let x = x.unwrap_or_else(|| {
        let Vec3 { x, y, z } = axis;
        let across = x * x + y * y;
        // 1/(1 + z), written without cancellation near z = -1.
        let factor = match z {
            z if z >= 0.0 => 1.0 / (1.0 + z),
            _ if across > 0.0 => (1.0 - z) / across,
            _ => return Vec3::new(-1.0, 0.0, 0.0),
        };
        let column = Vec3::new(1.0 - x * x * factor, -x * y * factor, -x);
        column.across(axis).direction().unwrap_or_else(|| axis.any_perpendicular())
    });
    Mat3::from_columns(x, axis.cross(x), axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn frames_on_coordinate_axes_are_exact() {
        let e = |k| Vec3::unit(k);
        assert_eq!(frame(e(2), None), Mat3::identity());
        assert_eq!(frame(e(1), None), Mat3::from_columns(e(0), -e(2), e(1)));
        assert_eq!(frame(e(0), None), Mat3::from_columns(-e(2), e(1), e(0)));
        assert_eq!(frame(-e(2), None), Mat3::from_columns(-e(0), e(1), -e(2)));
    }

    proptest! {
        /// Checks that the frame is a rotation, and that x is rotated by the smallest rotation from
        /// z to the axis.
        #[test]
        fn frames_are_smallest_turns(v in prop::array::uniform3(-1.0..1.0f64), squeeze in 0.0..1.0f64) {
            let v = Vec3::new(v[0] * squeeze, v[1] * squeeze, v[2]);
            prop_assume!(v.norm() > 1e-3);
            let axis = v.direction().unwrap();
            let found = frame(axis, None);
            let error = found.transpose() * found;
            for i in 0..3 {
                for k in 0..3 {
                    let expected = if i == k { 1.0 } else { 0.0 };
                    prop_assert!((error.at(i, k) - expected).abs() < 1e-15 * 4.0);
                }
            }
            // Near -z the smallest rotation is ill-conditioned: a rounding of 1e-16 is divided by
            // the distance from -z.
            prop_assume!(1.0 + axis.z > 1e-6);
            let expected = Mat3::between(Vec3::unit(2), axis);
            for k in 0..3 {
                prop_assert!((found.columns[k] - expected.columns[k]).norm() < 1e-9);
            }
        }
    }
}
