//! Default characteristic length of a mechanism.

use crate::mechanism::{Body, BodyId, Joint};
use crate::spatial::Vec3;

/// Computes the default of [`crate::mechanism::Mechanism::characteristic_length`], m. Returns 1 m
/// if no body has two distinct points (joint origins or centre of mass).
pub(super) fn own_length(bodies: &[Body], joints: &[Joint]) -> f64 {
    let mut squares = Vec::new();
    let mut points_of: Vec<Vec<Vec3<f64>>> = vec![Vec::new(); bodies.len()];
    for joint in joints {
        points_of[joint.predecessor.0].push(joint.frame_j.position);
        points_of[joint.successor.0].push(joint.frame_k.position);
    }
    for ((id, body), mut points) in bodies.iter().enumerate().zip(points_of) {
        points.extend((id != BodyId::GROUND.0).then_some(body.com));
        for (i, &a) in points.iter().enumerate() {
            squares.extend(points[..i].iter().map(|&b| (a - b).norm_squared()));
        }
    }
    // Skip distances that are zero up to the rounding of coordinates, such as that of two joints
    // with the same origin.
    let largest = squares.iter().copied().fold(0.0, f64::max);
    squares.retain(|&square| square > 1e-18 * largest);
    if squares.is_empty() {
        return 1.0;
    }
    // Sort, so that round-off does not depend on the order of bodies and joints.
    squares.sort_by(f64::total_cmp);
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}
