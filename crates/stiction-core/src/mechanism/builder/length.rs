//! Default characteristic length of a mechanism.

use crate::mechanism::{Body, BodyId, Joint};
use crate::spatial::Vec3;

/// Largest number of distances counted from one point. Otherwise the distances between far joints
/// on the ground would outweigh all others in a long row of mechanisms.
const NEAREST: usize = 6;

/// Computes the default of [`crate::mechanism::Mechanism::characteristic_length`], m. Returns 1 m
/// if no body has two distinct points (joint origins or centre of mass).
pub(super) fn own_length(bodies: &[Body], joints: &[Joint]) -> f64 {
    let mut points_of: Vec<Vec<Vec3<f64>>> = vec![Vec::new(); bodies.len()];
    for joint in joints {
        points_of[joint.predecessor.0].push(joint.frame_j.position);
        points_of[joint.successor.0].push(joint.frame_k.position);
    }
    for ((id, body), points) in bodies.iter().enumerate().zip(&mut points_of) {
        points.extend((id != BodyId::GROUND.0).then_some(body.com));
    }
    let from = |points: &[Vec3<f64>], a: Vec3<f64>, squares: &mut Vec<f64>| {
        squares.clear();
        squares.extend(points.iter().map(|&b| (a - b).norm_squared()));
    };
    let mut squares = Vec::new();
    let mut largest = 0.0_f64;
    for points in &points_of {
        for &point in points {
            from(points, point, &mut squares);
            largest = squares.iter().copied().fold(largest, f64::max);
        }
    }
    // Squared distances, each from one point: distances between near points occur twice.
    let mut counted = Vec::new();
    for points in &points_of {
        for &point in points {
            from(points, point, &mut squares);
            // Skip distances that are zero up to the rounding of coordinates, such as that of two
            // joints with the same origin.
            squares.retain(|&square| square > 1e-18 * largest);
            if squares.len() > NEAREST {
                squares.select_nth_unstable_by(NEAREST, f64::total_cmp);
                squares.truncate(NEAREST);
            }
            counted.append(&mut squares);
        }
    }
    if counted.is_empty() {
        return 1.0;
    }
    // Sort, so that round-off does not depend on the order of bodies and joints.
    counted.sort_by(f64::total_cmp);
    // Equal distances are neighbours after sorting, so that the sum of halves has the digits of the
    // sum over all pairs if all of them count.
    let halves = counted.chunks(2).map(|both| 0.5 * both.iter().sum::<f64>());
    (halves.sum::<f64>() / (0.5 * counted.len() as f64)).sqrt()
}
