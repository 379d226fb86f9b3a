//! Conversion of computation errors to errors with suggestions.

use crate::error::Error;
use serde_json::json;
use stiction_core::dynamics::InverseError;
use stiction_core::forward::ForwardError;
use stiction_core::kinematics::AssemblyError;
use stiction_core::words::significant;
use stiction_format::Diagnostics;
use stiction_run::breakaway::BreakawayError;
use stiction_run::forward::Error as SimulationError;
use stiction_run::inverse::{Error as MotionError, Missing};

/// Converts an error of inverse dynamics or of a motion.
pub fn inverse(error: MotionError) -> Error {
    let without_friction = |error: Error| {
        error.with_help("switch friction off to see the efforts without it").with_option("friction")
    };
    match error {
        MotionError::NotFinite(diagnostic) => Error::from(Diagnostics::from(*diagnostic)),
        MotionError::CannotCarry(missing) => cannot_carry(&missing),
        MotionError::Interrupted => Error::interrupted("interrupted; nothing was written"),
        MotionError::Instants(_) => Error::input(error.to_string())
            .with_help("give another time between samples")
            .with_option("step"),
        MotionError::Forces {
            time,
            error: ref cause @ InverseError::Locked { ref joint, percent },
        } => without_friction(Error::no_answer(format!("at t = {time} s: {cause}")))
            .with_details(json!({ "time": time, "joint": joint, "percent": percent })),
        MotionError::Forces { error: InverseError::Unsettled, .. } => {
            without_friction(Error::no_answer(error.to_string()))
        }
        // Assembled from zero coordinates, a mechanism may be in another assembly mode.
        MotionError::Assembly { error: AssemblyError::Open { .. }, .. } => Error::input(
            error.to_string(),
        )
        .with_help(
            "if this motion should not be free, a joint is missing, or the mechanism is in another \
                 assembly mode than intended: give its joints `start` values near their positions",
        ),
        error if error.is_bad_input() => Error::input(error.to_string()),
        error => Error::no_answer(error.to_string()),
    }
}

fn cannot_carry(missing: &Missing) -> Error {
    let InverseError::CannotCarry { body, motion, .. } = &missing.first else {
        return Error::no_answer(missing.first.to_string());
    };
    let Missing { time, range: (least, greatest), unit, samples, of, .. } = missing;
    let amount = if (greatest - least).abs() < 5e-3 * greatest {
        format!("{} {unit}", significant(*greatest, 6))
    } else {
        format!("{} to {} {unit}", significant(*least, 6), significant(*greatest, 6))
    };
    let when = if *of == 1 {
        format!("at t = {time} s")
    } else if samples == of {
        format!("at every one of {of} samples")
    } else {
        format!("at {samples} of {of} samples, first at t = {time} s")
    };
    let what = if *unit == "N m" { "a moment" } else { "a force" };
    Error::no_answer(format!(
        "no finite driving force carries this load {when}: the position is singular.\n  With all \
         actuators locked, body `{body}` can still move: {motion}.\n  Nothing resists that motion: \
         {what} of {amount} is missing there."
    ))
    .with_help(
        "change the motion or the load, or add an actuator or a constraint that resists this motion",
    )
    .with_details(json!({
        "first_time": time,
        "samples": samples,
        "of": of,
        "body": body,
        "motion": motion,
        "missing": { "least": least, "greatest": greatest, "unit": unit },
    }))
}

/// Converts an error of a breakaway computation.
pub fn breakaway(error: BreakawayError) -> Error {
    match error {
        BreakawayError::Job(MotionError::Forces { time, error: InverseError::Unsettled }) => {
            Error::no_answer(format!(
                "at t = {time} s the mechanism is singular, or both its constraints and its actuators are \
                 redundant: static friction is not computed there"
            ))
            .with_help("choose another position")
            .with_option("at")
        }
        BreakawayError::Job(error) => inverse(error),
        error => Error::input(error.to_string()).with_help("choose another time")
            .with_option("at"),
    }
}

/// Converts an error of a simulation.
pub fn forward(error: SimulationError) -> Error {
    let bad_input = error.is_bad_input();
    let message = error.to_string();
    match error {
        SimulationError::Motion(error) => inverse(error),
        SimulationError::NotFinite(diagnostic) => inverse(MotionError::NotFinite(diagnostic)),
        SimulationError::Instants(_) => Error::input(message)
            .with_help("give another time between samples, or another end")
            .with_option("step"),
        SimulationError::Controller(error @ (AssemblyError::Open { .. } | AssemblyError::Gap(_))) => {
            Error::input(format!(
                "the controller needs actuators that determine the motion, one for each degree of freedom: {error}"
            ))
            .with_help("use a controller with `type = pd`, and kp and kd for each actuator, or give efforts instead")
            .with_option("controller")
        }
        SimulationError::Controller(_) | SimulationError::ControllerForces(_) => {
            Error::input(format!("the controller cannot start: {message}"))
                .with_help("start elsewhere, or use another controller")
            .with_option("from")
        }
        SimulationError::ControllerAt { time, .. } => Error::no_answer(message)
            .with_help("reduce the bandwidth, set a limit, or use a PD controller; the results up to this time show the cause")
            .with_details(json!({ "time": time })),
        SimulationError::Forward(error) => simulation(&error, bad_input),
        SimulationError::Interrupted => Error::interrupted("interrupted; nothing was written"),
        _ if bad_input => Error::input(message),
        _ => Error::no_answer(message),
    }
}

fn simulation(error: &ForwardError, bad_input: bool) -> Error {
    let message = error.to_string();
    match error {
        ForwardError::Assembly(_) | ForwardError::Contradiction { .. } if bad_input => {
            Error::input(message)
        }
        ForwardError::GearLoss { .. } => Error::input(message),
        ForwardError::Blocked { .. } => Error::input(message)
            .with_help("give other rates at the start, or lock other joints")
            .with_option("from"),
        ForwardError::Impact { time, percent, .. } => Error::no_answer(message)
            .with_help("prescribe motions without kinks, and keep locks away from dead centres; a check finds singular positions")
            .with_details(json!({ "time": time, "percent": percent })),
        ForwardError::NoAcceleration { time, joint, percent } => Error::no_answer(message)
            .with_help("reduce the friction, lengthen the `bending_span` of a guide, or smooth the law with `regularisation_velocity`; at a singular position change drives, locks or the start; see the chapter on forward dynamics")
            .with_details(json!({ "time": time, "joint": joint, "percent": percent })),
        ForwardError::NoChoice { time, joint } => Error::no_answer(message)
            .with_help("reduce the friction there, or smooth its law with `regularisation_velocity`")
            .with_details(json!({ "time": time, "joint": joint })),
        ForwardError::Massless { time, body } => Error::no_answer(message)
            .with_help("give the body a mass and moments of inertia, or lock that motion")
            .with_option("hold")
            .with_details(json!({ "time": time, "body": body })),
        ForwardError::Open { time, joint, gap } => Error::no_answer(message)
            .with_help("keep the prescribed motion within reach and away from singular positions; a check finds these")
            .with_details(json!({ "time": time, "joint": joint, "gap": gap })),
        ForwardError::Stiff { time, step, tolerance, .. } => Error::no_answer(message)
            .with_help("allow a larger tolerance, or use a smoother friction law")
            .with_option("tolerance")
            .with_details(json!({ "time": time, "step": step, "tolerance": tolerance })),
        ForwardError::Runaway { time, body, speed } => Error::no_answer(message)
            .with_help("reduce the gains or the period of an unstable controller; otherwise check efforts and loads at that time")
            .with_details(json!({ "time": time, "body": body, "speed": speed })),
        ForwardError::NotFinite { time, .. } => Error::no_answer(message)
            .with_help("check the efforts and loads at that time")
            .with_details(json!({ "time": time })),
        _ => Error::no_answer(message),
    }
}
