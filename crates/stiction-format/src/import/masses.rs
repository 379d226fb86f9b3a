//! Checks of masses and inertias before the model file is written, so that messages name the place in the robot file.

use super::context::Context;
use super::description::{Body, Description};
use super::meaning::size_of;
use crate::diagnostic::quoted;
use nalgebra::Matrix3;

/// Largest mass of a body that is not reported as unrealistic, kg.
const HEAVY: f64 = 1e5;

/// A negative principal moment of inertia is negligible if its magnitude is at most this fraction
/// of the typical moment of inertia of the robot.
const NEGLIGIBLE: f64 = 1e-8;
/// A negative principal moment of inertia is attributed to rounding by an exporter if its magnitude
/// is at most this fraction of the body's largest moment; files often have six digits.
const ROUNDING: f64 = 1e-5;

/// Reports masses that are unrealistically large, since exporters sometimes confuse units. Replaces
/// negative principal moments of inertia by zero if they are negligible for the robot, and reports
/// an error otherwise.
pub(super) fn check(context: &Context<'_>, robot: &mut Description) {
    let slack = NEGLIGIBLE * moment_of(robot);
    for body in &mut robot.bodies {
        if body.mass > HEAVY {
            let message = format!(
                "body {} has a mass of {:.3e} kg; if this is a unit error, correct the file",
                quoted(&body.name),
                body.mass
            );
            context.note(message, body.place.clone());
        }
        raise_moments(context, body, slack);
    }
}

/// Typical moment of inertia of the whole robot, kg m²: its mass times the square of its greatest
/// length, or the greatest moment of a body if that is larger.
fn moment_of(robot: &Description) -> f64 {
    let bodies = || robot.bodies.iter();
    let length = bodies().map(|body| body.com.norm()).fold(size_of(robot), f64::max);
    let mass: f64 = bodies().map(|body| body.mass.max(0.0)).sum();
    let moments = bodies().map(|body| Matrix3::from(body.inertia).amax());
    moments.filter(|moment| moment.is_finite()).fold(mass * length * length, f64::max)
}

/// Sets negative principal moments to zero if their magnitude is at most `slack`, kg m²; otherwise
/// reports an error.
fn raise_moments(context: &Context<'_>, body: &mut Body, slack: f64) {
    let tensor = Matrix3::from(body.inertia);
    if !tensor.iter().all(|entry| entry.is_finite()) {
        return;
    }
    let eigen = tensor.symmetric_eigen();
    let least = eigen.eigenvalues.min();
    // The model file allows such a rounding error.
    if least >= -1e-9 * tensor.amax() {
        return;
    }
    if least >= -slack {
        let reason = match least >= -ROUNDING * tensor.amax() {
            true => "a rounding error of the file",
            false => "which is negligible for this robot",
        };
        let message = format!(
            "the inertia of body {} has the negative principal moment {:.2e} kg m², {reason}; this moment is set to 0",
            quoted(&body.name),
            least
        );
        context.note(message, body.place.clone());
        let moments = Matrix3::from_diagonal(&eigen.eigenvalues.map(|moment| moment.max(0.0)));
        let raised = eigen.eigenvectors * moments * eigen.eigenvectors.transpose();
        body.inertia = ((raised + raised.transpose()) * 0.5).into();
    } else if let Some(place) = &body.place {
        let message = format!(
            "the inertia of body {} has the negative principal moment {:.2e} kg m², which is physically impossible",
            quoted(&body.name),
            least
        );
        let help = "correct the inertia; often the products of inertia have the wrong sign or unit";
        context.error("inertia", message, place, help);
    }
}
