//! Errors of forward dynamics.

use super::affine_friction::InterfaceMode;
use crate::dynamics::NO_PART;
use crate::kinematics::AssemblyError;
use crate::words::brief;
use thiserror::Error;

/// Competing solution: another solution at the same state that satisfies all friction laws.
#[derive(Clone, Debug, PartialEq)]
pub struct Competitor {
    /// Normal loads of all interfaces, N.
    pub loads: Vec<f64>,
    /// Accelerations of the spanning tree, rad/s^2 or m/s^2.
    pub accelerations: Vec<f64>,
    /// Mode of each interface.
    pub interfaces: Vec<InterfaceMode>,
}

/// Reason why a simulation cannot continue.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ForwardError {
    /// The mechanism cannot be assembled at the start of the simulation.
    #[error("{0}")]
    Assembly(#[from] AssemblyError),
    /// The continuation from the frictionless solution found no accelerations that satisfy the
    /// friction laws; usually none exist (Painleve's paradox).
    #[error(
        "at t = {t} s no acceleration was found that satisfies the friction laws of the rigid \
         model: the solution continued from zero friction ends {at}, where the normal loads grow \
         without bound, first in joint `{joint}` ({kind}",
        at = if *percent < NO_PART { "at a small fraction of the given friction coefficients".to_owned() }
            else { format!("at {percent:.1} % of the given friction coefficients") },
        kind = if *percent < NO_PART { "the position is nearly singular, or the coefficients are too large); \
            start at another position, lock joints that nothing drives or holds, or check the coefficients" }
            else { "jamming, Painleve's paradox); give its guide a longer span, less friction, or some \
            compliance" }, t = brief(*time, 9))]
    NoAcceleration {
        /// Time, s.
        time: f64,
        /// Name of the joint whose normal load grows most.
        joint: String,
        /// Fraction of the given friction coefficients at which the solution branch ends, percent.
        percent: f64,
    },
    /// The search found no combination of sticking and sliding interfaces that satisfies all
    /// friction laws.
    #[error(
        "at t = {t} s no combination of sticking and sliding joints was found that satisfies all friction laws; joint \
         `{joint}` can neither stick nor slide (Painleve's paradox at rest); reduce its friction or \
         regularise its law", t = brief(*time, 9))]
    NoChoice {
        /// Time, s.
        time: f64,
        /// Name of a joint that can neither stick nor slide.
        joint: String,
    },
    /// A motion that the constraints allow moves a body without inertia, so that its acceleration
    /// is undefined.
    #[error(
        "at t = {t} s body `{body}` can move without any inertia, so its acceleration is not \
         defined; give it mass and moments of inertia, or lock that motion", t = brief(*time, 9))]
    Massless {
        /// Time, s.
        time: f64,
        /// Name of the body.
        body: String,
    },
    /// The relative rotation at a spring or bushing is too large for its moment to be defined.
    #[error("at t = {t} s spring `{spring}`: {problem}", t = brief(*time, 9))]
    Spring {
        /// Time, s.
        time: f64,
        /// Name of the spring or bushing.
        spring: String,
        /// Description of the problem.
        problem: String,
    },
    /// The loops cannot be closed after a step.
    #[error(
        "at t = {t} s the loops cannot be closed: joint `{joint}` stays open by {gap:.2e} (m or rad); \
         the position is singular, or the prescribed motion is out of reach", t = brief(*time, 9))]
    Open {
        /// Time, s.
        time: f64,
        /// Name of the joint with the largest closure error.
        joint: String,
        /// Closure error, m or rad.
        gap: f64,
    },
    /// The tolerance requires a step shorter than the shortest allowed step.
    #[error(
        "at t = {t} s steps of {step:.1e} s are still too long for the tolerance {tolerance:.0e}: \
         the motion changes too fast there{around}; allow a larger tolerance, or check the forces \
         at that time", t = brief(*time, 9))]
    Stiff {
        /// Time, s.
        time: f64,
        /// Length of the rejected step, s.
        step: f64,
        /// Relative tolerance of the integration.
        tolerance: f64,
        /// Text for the message that names the joint or position where the motion changes too fast;
        /// may be empty.
        around: String,
    },
    /// A formula of the inputs switches endlessly between its branches (chatter).
    #[error(
        "at t = {t} s {what} changes back and forth {count} times within {span:.1e} s (chatter): \
         on both sides of its jump it drives the mechanism back to the jump; write a continuous \
         formula there, such as `tanh(x/x0)` for `sign(x)` with a small x0, or give the joint \
         friction instead",
        t = brief(*time, 9)
    )]
    Chatter {
        /// Time of the last change, s.
        time: f64,
        /// Description of the formula or limit that switches.
        what: String,
        /// Number of switches between the branches of the formula.
        count: usize,
        /// Time span in which these switches occur, s.
        span: f64,
    },
    /// The simulated time hardly advances over many evaluations.
    #[error(
        "at t = {t} s the simulation stalls: time has hardly advanced over the last {evaluations} \
         evaluations of accelerations or velocities{}; allow a larger tolerance, reduce the friction \
         coefficients, give the joint a regularised friction law, or write a continuous formula for \
         efforts that jump (`tanh` for `sign`)",
        at_joint(joint.as_deref()), t = brief(*time, 9))]
    Stalled {
        /// Time, s.
        time: f64,
        /// Number of evaluations without progress; a time step that has no solution counts as fifty.
        evaluations: usize,
        /// Name of the joint with the largest normal force, if joints have friction.
        joint: Option<String>,
    },
    /// The start values contradict each other or the loop constraints.
    #[error(
        "the start values contradict each other: {what} {is} off by {by:.3e} {unit}; give fewer values, or \
         consistent ones",
        is = if what.starts_with("joint") { "and is" } else { "is" },
    )]
    Contradiction {
        /// Description of the value or rate that cannot be satisfied.
        what: String,
        /// Residual of the value or rate, in `unit`.
        by: f64,
        /// Unit of `by`.
        unit: &'static str,
        /// True if `by` is the residual of a rate, false if it is that of a value.
        rates: bool,
    },
    /// The motion at the start would immediately violate a lock, a prescribed motion or a loop
    /// constraint, because the mechanism is at a dead centre or at a bifurcation of the motion. If
    /// the mechanism is at rest, the forces drive it into such a motion, and no finite reaction
    /// prevents this motion.
    #[error(
        "the start is contradictory: {}; start {}at another position, or release that constraint",
        blocked(*time, what, *by, *translates, *at_rest),
        if *at_rest { "" } else { "at rest or " }
    )]
    Blocked {
        /// Time, s.
        time: f64,
        /// Description of the violated constraint.
        what: String,
        /// Residual acceleration, m/s^2 or rad/s^2.
        by: f64,
        /// True if `by` is in m/s^2, false if it is in rad/s^2.
        translates: bool,
        /// True if the mechanism is at rest and the forces accelerate it; `by` is then the residual
        /// acceleration for the rates that the mechanism would reach after one second.
        at_rest: bool,
    },
    /// Loop constraints, locks or prescribed motions would stop a motion instantly, which is an
    /// impact.
    #[error(
        "at t = {t} s {what} would require velocities to jump by {percent:.2} % of the largest \
         velocity: an impact, which is not modelled; release that constraint, prescribe another \
         motion, or avoid dead centres and singular positions", t = brief(*time, 9))]
    Impact {
        /// Time, s.
        time: f64,
        /// Description of the violated constraint.
        what: String,
        /// Required jump of the velocities, percent of the largest velocity.
        percent: f64,
        /// True if the violated constraint is a loop closure, false if it is a lock or a prescribed
        /// motion.
        by_loop: bool,
    },
    /// The checkpoint was written for another mechanism or by another version of the program.
    #[error(
        "the checkpoint belongs to another mechanism, or was written by another version of this \
         program; start the simulation again without it"
    )]
    Checkpoint,
    /// A body exceeds the speed of light: the forces on it grow without bound.
    #[error(
        "at t = {t} s body `{body}` is faster than light ({speed:.1e} m/s): the forces on it grow without bound", t = brief(*time, 9))]
    Runaway {
        /// Time, s.
        time: f64,
        /// Name of the fastest body.
        body: String,
        /// Larger of the speed of the centre of mass and the angular speed times the characteristic
        /// length, m/s.
        speed: f64,
    },
    /// A quantity is infinite or not a number.
    #[error("at t = {t} s {what} is not a finite number; check the inputs at that time", t = brief(*time, 9))]
    NotFinite {
        /// Time, s.
        time: f64,
        /// Description of the quantity.
        what: &'static str,
    },
}

fn at_joint(joint: Option<&str>) -> String {
    joint.map_or_else(String::new, |joint| {
        format!("; joint `{joint}` bears the largest normal force")
    })
}

fn blocked(time: f64, what: &str, by: f64, translates: bool, at_rest: bool) -> String {
    let time = brief(time, 9);
    if at_rest {
        return format!(
            "at t = {time} s the forces push in a direction that {what} permits instantaneously but not \
             over a finite distance (a dead centre or a bifurcation): no finite reaction balances them"
        );
    }
    let units = if translates { "m/s^2" } else { "rad/s^2" };
    format!(
        "{what} permits these rates at t = {time} s only instantaneously: the motion that follows \
         violates it, at first with an acceleration of {by:.3e} {units} (a dead centre or a \
         bifurcation)"
    )
}
