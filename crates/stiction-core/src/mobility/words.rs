//! Descriptions of instantaneous motions in engineering terms.

use crate::linalg::Svd;
use crate::spatial::{Mat3, Twist, Vec3, describe_direction, describe_motion};
use nalgebra::{DMatrix, DVector};

/// Components of unit motions, and singular values of sets of unit motions, count as zero below
/// this value.
const NONE: f64 = 1e-6;

/// Describes the finite motions of one body (the span of `lasting`), and the motions that are only
/// instantaneous (the complement of `lasting` in the span of `all`). Twists are about the reference
/// point. `com` is the centre of mass relative to the reference point, and `origin` is the
/// reference point in the world. `points` are the names and positions of the body's joints; an axis
/// through two joints is described by their names. `length` is the characteristic length, m.
pub(crate) fn describe_dofs(
    lasting: &[Twist<f64>],
    all: &[Twist<f64>],
    points: &[(&str, Vec3<f64>)],
    com: Vec3<f64>,
    origin: Vec3<f64>,
    length: f64,
) -> (Vec<String>, Vec<String>) {
    // Convert the twist to the centre of mass, and divide its velocity by the characteristic
    // length.
    let vector = |twist: &Twist<f64>| {
        let (w, v) = (twist.angular, twist.velocity_at(com) * (1.0 / length));
        DVector::from_column_slice(&[w.x, w.y, w.z, v.x, v.y, v.z])
    };
    let span = |twists: &[Twist<f64>]| basis(&twists.iter().map(vector).collect::<Vec<_>>());
    let lasting = span(lasting);
    let all = span(all);
    let beyond: Vec<DVector<f64>> = all
        .iter()
        .cloned()
        .map(|mut motion| {
            // Orthogonalise twice to remove round-off.
            for _ in 0..2 {
                for known in &lasting {
                    let part = known.dot(&motion);
                    motion.axpy(-part, known, 1.0);
                }
            }
            motion
        })
        .collect();
    let place = com + origin;
    let beyond = basis(&beyond);
    let words = match beyond.as_slice() {
        [one] => about_joints(one, &all, points, |twist| vector(&twist)),
        _ => None,
    };
    let words = words.map_or_else(|| in_words(&beyond, place, length), |words| vec![words]);
    (in_words(&lasting, place, length), words)
}

/// Describes a rotation about the line through two joints that lies in the span of `all`. Of
/// several such rotations, selects the one closest to the motion `beyond`. Returns `None` if there
/// is no such rotation, or if it has little in common with `beyond`.
fn about_joints(
    beyond: &DVector<f64>,
    all: &[DVector<f64>],
    points: &[(&str, Vec3<f64>)],
    vector: impl Fn(Twist<f64>) -> DVector<f64>,
) -> Option<String> {
    let mut best: Option<(f64, String)> = None;
    for (k, (a, from)) in points.iter().enumerate() {
        for (b, to) in &points[k + 1..] {
            let Some(direction) = (*to - *from).direction() else { continue };
            let turn = vector(Twist::rotation(direction, *from));
            let inside = all.iter().fold(turn.clone(), |rest, known| {
                let part = known.dot(&turn);
                rest - known * part
            });
            let like = beyond.dot(&turn).abs() / turn.norm();
            let known = best.as_ref().map_or(0.1, |(like, _)| like * (1.0 + 1e-9));
            if inside.norm() < NONE * turn.norm() && like > known {
                let axis = describe_direction(direction);
                let words = format!("rotation about the line {a} - {b} (along {axis})");
                best = Some((like, words));
            }
        }
    }
    best.map(|(_, words)| words)
}

/// Computes an orthonormal basis of the span of `vectors`.
fn basis(vectors: &[DVector<f64>]) -> Vec<DVector<f64>> {
    if vectors.is_empty() {
        return Vec::new();
    }
    let matrix = DMatrix::from_columns(vectors);
    // The decomposition yields one vector per column, so decompose the matrix with fewer columns.
    let is_wide = matrix.ncols() > matrix.nrows();
    let svd = if is_wide { Svd::new(&matrix.transpose()) } else { Svd::new(&matrix) };
    let basis = if is_wide { &svd.v } else { &svd.u };
    let count = svd.singular_values.iter().filter(|&&value| value > NONE).count();
    (0..count).map(|k| basis.column(k).into_owned()).collect()
}

/// Describes the span of the given motions: translations first, then rotations and screws, along
/// the world axes where possible. Each motion consists of the angular velocity and of the velocity
/// of the centre of mass divided by `length`. `com` is the centre of mass in the world, m.
fn in_words(motions: &[DVector<f64>], com: Vec3<f64>, length: f64) -> Vec<String> {
    if motions.is_empty() {
        return Vec::new();
    }
    let matrix = DMatrix::from_columns(motions);
    let part = |rows: usize| matrix.rows(rows, 3).into_owned();
    let turns = Svd::new(&part(0));
    let turning = turns.singular_values.iter().filter(|&&value| value > NONE).count();
    let translations: Vec<Vec3<f64>> = turns
        .null_space(turning)
        .iter()
        .filter_map(|amounts| vector_of(&(part(3) * amounts)).direction())
        .collect();
    let mut words: Vec<String> = along_axes(&translations)
        .into_iter()
        .map(|direction| format!("translation along {}", describe_direction(direction)))
        .collect();
    let axes: Vec<Vec3<f64>> =
        (0..turning).map(|k| vector_of(&turns.u.column(k).into_owned())).collect();
    for axis in along_axes(&axes) {
        let right = DVector::from_column_slice(&axis.to_array());
        let twist = &matrix * turns.solve(&right, turning);
        let mut velocity = vector_of(&twist.rows(3, 3).into_owned()) * length;
        for &direction in &translations {
            velocity = velocity - direction * velocity.dot(direction);
        }
        // Shifting the rotation axis adds a translation perpendicular to the axis.
        let is_free = |shift: Vec3<f64>| {
            let rest = translations.iter().fold(shift, |rest, t| rest - *t * t.dot(rest));
            rest.norm() < NONE
        };
        let frame = Mat3::between(Vec3::unit(2), axis).columns;
        words.push(if is_free(frame[0]) && is_free(frame[1]) {
            // With these translations the position of the axis is arbitrary.
            format!("rotation about {}", describe_direction(axis))
        } else {
            let linear = velocity + com.cross(axis);
            describe_motion(Twist { angular: axis, linear }, length)
        });
    }
    words
}

fn vector_of(column: &DVector<f64>) -> Vec3<f64> {
    Vec3::new(column[0], column[1], column[2])
}

/// Computes an orthonormal basis of the span of `vectors`, which are orthonormal. The basis
/// contains each world axis that lies in the span.
fn along_axes(vectors: &[Vec3<f64>]) -> Vec<Vec3<f64>> {
    let mut found: Vec<Vec3<f64>> = Vec::new();
    let within =
        |axis: Vec3<f64>| vectors.iter().fold(Vec3::zero(), |sum, v| sum + *v * v.dot(axis));
    found.extend((0..3).map(Vec3::unit).filter(|axis| (within(*axis) - *axis).norm() < NONE));
    for &vector in vectors {
        let rest = found.iter().fold(vector, |rest, known| rest - *known * known.dot(rest));
        if found.len() < vectors.len() && rest.norm() > 1e-3 {
            found.extend(rest.direction());
        }
    }
    found
}
