//! Conversion of computation errors to errors with suggestions.

use crate::error::{Error, ErrorKind};
use serde_json::json;
use stiction_core::dynamics::InverseError;
use stiction_core::forward::ForwardError;
use stiction_core::kinematics::{AssemblyError, Gap};
use stiction_core::words::significant;
use stiction_format::Diagnostics;
use stiction_run::{Error as RunError, InstantsError, Missing};

impl From<InstantsError> for Error {
    fn from(error: InstantsError) -> Self {
        RunError::Instants(error).into()
    }
}

impl From<RunError> for Error {
    fn from(error: RunError) -> Self {
        let (bad_input, message) = (error.is_bad_input(), error.to_string());
        let plain = |message| match bad_input {
            true => Self::input(message),
            false => Self::no_answer(message),
        };
        let without_friction = |error: Self| {
            error
                .with_help("switch friction off to see the efforts without it")
                .with_option("friction")
        };
        match error {
            RunError::NotFinite(diagnostic) => Self::from(Diagnostics::from(*diagnostic)),
            RunError::CannotCarry(missing) => cannot_carry(&missing),
            RunError::Interrupted => Self::interrupted("interrupted; nothing was written"),
            RunError::Receiver(error) => match error.downcast::<Self>() {
                Ok(own) => *own,
                Err(other) => Self::new(ErrorKind::Output, other.to_string()),
            },
            RunError::Instants(_) => plain(message)
                .with_help("give another sampling interval, or another end time")
                .with_option("step"),
            RunError::Forces { time, error: ref cause @ InverseError::Locked { ref joint, percent } } => {
                without_friction(plain(format!("at t = {time} s: {cause}")))
                    .with_details(json!({ "time": time, "joint": joint, "percent": percent }))
            }
            RunError::Forces { error: InverseError::Unsettled, .. } => {
                without_friction(plain(message))
            }
            // A mechanism that is assembled from zero coordinates may be in another assembly mode
            // than the intended one.
            RunError::Assembly { error: AssemblyError::Open { .. }, .. }
            | RunError::Reference { error: AssemblyError::Open { .. }, .. } => plain(message).with_help(
                "if this motion should not be free, a joint is missing, or the mechanism is in another \
                 assembly mode than intended: give its joints `start` values near their positions",
            ),
            RunError::Assembly { error: AssemblyError::Gap(gap), .. } => {
                plain(message).with_help(open_loops(&gap))
            }
            RunError::Reference { error: AssemblyError::Gap(gap), .. } => plain(message).with_help(format!(
                "this is the motion that the controller follows, not the simulated one; {}",
                open_loops(&gap)
            )),
            RunError::NoStaticFriction { .. } => {
                plain(message).with_help("choose another position").with_option("at")
            }
            RunError::NoSuchTime { .. } => {
                plain(message).with_help("choose another time").with_option("at")
            }
            RunError::Controller(error @ (AssemblyError::Open { .. } | AssemblyError::Gap(_))) => {
                plain(format!(
                    "the controller needs actuators that determine the motion, one for each degree of freedom: {error}"
                ))
                .with_help("use a controller with `type = pd`, and kp and kd for each actuator, or give efforts instead")
                .with_option("controller")
            }
            RunError::Controller(_) | RunError::ControllerForces(_) => {
                plain(format!("the controller cannot start: {message}"))
                    .with_help("start from another state, or use another controller")
                    .with_option("from")
            }
            RunError::ControllerLocked { .. } => locked(plain(message)),
            RunError::ControllerAt { time, ref error }
                if matches!(**error, RunError::ControllerLocked { .. }) =>
            {
                locked(plain(message)).with_details(json!({ "time": time }))
            }
            RunError::ControllerAt { time, .. } => plain(message)
                .with_help("reduce the bandwidth, set an effort `limit`, or use a PD controller; the results up to this time show the cause")
                .with_details(json!({ "time": time })),
            RunError::NoEquilibrium(_) => plain(message)
                .with_help("lock joints, give efforts, or start the search from another state")
                .with_option("hold"),
            RunError::NoLinearModel(_) => plain(message)
                .with_help("choose another operating point, or switch friction off")
                .with_option("friction"),
            RunError::Checkpoint => plain(format!("the checkpoint is damaged: {message}"))
                .with_help("start again without it")
                .with_option("resume"),
            RunError::SpinningPayload { body } => plain(format!(
                "{message}: the part's inertia force depends on the spin, which no motion prescribes"
            ))
            .with_help(format!(
                "add the part to the mass of [bodies.\"{body}\"], or prevent the spin: make one of the link's S joints a U joint"
            ))
            .with_option("load"),
            RunError::Payload { .. } => plain(message)
                .with_help("use a payload that is carried all the time, without `from` and `until`")
                .with_option("load"),
            RunError::Forward(error) => simulation(&error, plain(message)),
            _ => plain(message),
        }
    }
}

/// Returns advice for a mechanism whose loops do not close. Loops that are open by about the size of
/// the mechanism usually have a length in a wrong unit.
fn open_loops(gap: &Gap) -> &'static str {
    /// Part of the characteristic length beyond which a gap is as large as the mechanism.
    const LARGE: f64 = 0.3;
    match gap.length.max(gap.missed_length) > LARGE * gap.scale {
        true => {
            "check the lengths and their units: a number without a unit is in m, so write \
             `\"400 mm\"` instead of `400`"
        }
        false => {
            "keep the motion within reach, and check the axes and lengths of this loop; an angle without a \
             unit is in rad, a length in m"
        }
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
        "no finite actuator effort balances this load {when}: the position is singular.\n  With \
         all actuators locked, body `{body}` can still move: {motion}.\n  Nothing resists that \
         motion: {what} of {amount} remains unbalanced."
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

/// Adds suggestions to the plain message of an error about locks that do not allow the motion of a
/// controller.
fn locked(plain: Error) -> Error {
    plain
        .with_help(
            "give efforts instead of the controller, for example `--drives none`, which also simulates a \
             mechanism that cannot move; or lock other joints",
        )
        .with_option("hold")
}

/// Adds suggestions to the plain message of a simulation error.
fn simulation(error: &ForwardError, plain: Error) -> Error {
    match error {
        ForwardError::Blocked { .. } => plain
            .with_help("give other rates at the start, or lock other joints")
            .with_option("from"),
        ForwardError::Impact { time, percent, .. } => plain
            .with_help("prescribe motions without kinks, and do not lock joints near dead \
                        centres; `stiction check` finds singular positions")
            .with_details(json!({ "time": time, "percent": percent })),
        ForwardError::NoAcceleration { time, joint, percent } => plain
            .with_help("reduce the friction, lengthen the `bending_span` of a guide, or smooth \
                        the law with `regularisation_velocity`; at a singular position, change the actuation, the \
                        locked joints or the start; see the chapter on forward dynamics")
            .with_details(json!({ "time": time, "joint": joint, "percent": percent })),
        ForwardError::NoChoice { time, joint } => plain
            .with_help("reduce the friction there, or smooth its law with `regularisation_velocity`")
            .with_details(json!({ "time": time, "joint": joint })),
        ForwardError::Massless { time, body } => plain
            .with_help("give the body a mass and moments of inertia, or lock that motion")
            .with_option("hold")
            .with_details(json!({ "time": time, "body": body })),
        ForwardError::Open { time, joint, gap } => plain
            .with_help("keep the prescribed motion within reach and away from singular \
                        positions, which `stiction check` finds")
            .with_details(json!({ "time": time, "joint": joint, "gap": gap })),
        ForwardError::Stiff { time, step, tolerance, .. } => plain
            .with_help("allow a larger tolerance, or use a smoother friction law")
            .with_option("tolerance")
            .with_details(json!({ "time": time, "step": step, "tolerance": tolerance })),
        ForwardError::Runaway { time, body, speed } => plain
            .with_help("reduce the gains or the period of an unstable controller; otherwise check efforts and loads at that time")
            .with_details(json!({ "time": time, "body": body, "speed": speed })),
        ForwardError::NotFinite { time, .. } => plain
            .with_help("check the efforts and loads at that time")
            .with_details(json!({ "time": time })),
        _ => plain,
    }
}
