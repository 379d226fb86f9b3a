//! Why a simulation cannot go on.

use super::affine_friction::InterfaceMode;
use crate::dynamics::NO_PART;
use crate::kinematics::AssemblyError;
use thiserror::Error;

/// One of several motions that satisfy all laws, or what is left when none does.
#[derive(Clone, Debug, PartialEq)]
pub struct Competitor {
    /// The loads of all contacts, N.
    pub loads: Vec<f64>,
    /// Accelerations of the tree.
    pub accelerations: Vec<f64>,
    /// What each contact does.
    pub interfaces: Vec<InterfaceMode>,
}

/// Why a simulation cannot go on.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ForwardError {
    /// The mechanism cannot be assembled as it should start.
    #[error("{0}")]
    Assembly(#[from] AssemblyError),
    /// Rigid bodies with Coulomb friction have no acceleration here (Painleve's paradox).
    #[error(
        "at t = {time} s the rigid model with this friction has no acceleration: {at} \
         the loads grow without bound, first in joint `{joint}` ({kind}",
        at = if *percent < NO_PART { "with a small part of the given coefficients".to_owned() }
            else { format!("at {percent:.1} % of the given coefficients") },
        kind = if *percent < NO_PART { "the position is singular, or as good as: its joints bear \
            next to any load there, and hold by friction what comes along; or the coefficients are immense); \
            start elsewhere, hold what is loose, or look at the coefficients" }
            else { "jamming, Painleve's paradox); give its guide a longer span, less friction, or some \
            compliance" }
    )]
    NoAcceleration {
        /// s.
        time: f64,
        /// The joint whose load grows most.
        joint: String,
        /// The part of the coefficients at which the solution is lost, percent.
        percent: f64,
    },
    /// No choice of which contacts stick and which slide satisfies all laws.
    #[error(
        "at t = {time} s no choice of sticking and sliding joints satisfies all friction laws; joint \
         `{joint}` is the one that neither holds nor slides (Painleve's paradox at rest); less friction \
         or a regularised law there lets it go on"
    )]
    NoChoice {
        /// s.
        time: f64,
        /// The joint.
        joint: String,
    },
    /// Something can move that weighs nothing.
    #[error(
        "at t = {time} s body `{body}` can move without any inertia, so its acceleration is not defined; \
         give it mass and moments of inertia, or hold that motion"
    )]
    Massless {
        /// s.
        time: f64,
        /// The body.
        body: String,
    },
    /// The loops cannot be closed again.
    #[error(
        "at t = {time} s the loops cannot be closed: joint `{joint}` stays open by {gap:.2e} (m or rad); \
         the position is singular, or what is prescribed is out of reach"
    )]
    Open {
        /// s.
        time: f64,
        /// The joint.
        joint: String,
        /// By how much, m or rad.
        gap: f64,
    },
    /// The steps have become too small.
    #[error(
        "at t = {time} s steps of {step:.1e} s are still too long for the tolerance {tolerance:.0e}: \
         something changes infinitely fast there{around}; allow a larger tolerance, or look at the forces \
         at that time"
    )]
    Stiff {
        /// s.
        time: f64,
        /// s.
        step: f64,
        /// The relative tolerance.
        tolerance: f64,
        /// Where, in words.
        around: String,
    },
    /// What is given for the start contradicts itself, or the loops.
    #[error(
        "the start is contradictory: {what} {is} missed by {by:.3e} ({units}); give less, or other numbers",
        is = if what.starts_with("joint") { "and is" } else { "is" },
        units = if *rates { "m/s or rad/s" } else { "m or rad" }
    )]
    Contradiction {
        /// What is missed, in words.
        what: String,
        /// By how much: m or rad, or m/s or rad/s of rates.
        by: f64,
        /// Whether it is about rates.
        rates: bool,
    },
    /// The rates at the start leave what is locked, prescribed or closed at once: at a dead centre, or where
    /// two ways of moving meet. Or they are none but the forces push that way, and no finite force holds.
    #[error(
        "the start is contradictory: {}; start {}elsewhere, or let it move",
        blocked(*time, what, *by, *translates, *at_rest),
        if *at_rest { "" } else { "at rest or " }
    )]
    Blocked {
        /// s.
        time: f64,
        /// What, in words.
        what: String,
        /// m/s^2 or rad/s^2.
        by: f64,
        /// Which of the two.
        translates: bool,
        /// Whether it is at rest and the forces alone would set it going: then `by` is what they lead to after
        /// a second.
        at_rest: bool,
    },
    /// Loops, locks and what is prescribed would have to stop a motion at once.
    #[error(
        "at t = {time} s velocities would have to jump by {percent:.2} % of the fastest so that {what} \
         holds: an impact, which rigid bodies do not describe; let it move, prescribe another motion, or \
         keep away from dead centres and singular positions"
    )]
    Impact {
        /// s.
        time: f64,
        /// What, in words.
        what: String,
        /// The change of the velocities, percent of the fastest.
        percent: f64,
    },
    /// A checkpoint is not one of this mechanism.
    #[error(
        "the checkpoint is not one of a simulation of this mechanism by this version; start anew"
    )]
    Checkpoint,
    /// Something drives the mechanism beyond where its equations hold.
    #[error(
        "at t = {time} s body `{body}` is faster than light ({speed:.1e} m/s): what acts on it grows without bound"
    )]
    Runaway {
        /// s.
        time: f64,
        /// The fastest body.
        body: String,
        /// Of its centre of mass, or of what turns with it at the characteristic length, m/s.
        speed: f64,
    },
    /// Numbers have become infinite.
    #[error("at t = {time} s {what} is not a finite number; check the inputs at that time")]
    NotFinite {
        /// s.
        time: f64,
        /// Of what.
        what: &'static str,
    },
}

fn blocked(time: f64, what: &str, by: f64, translates: bool, at_rest: bool) -> String {
    if at_rest {
        return format!(
            "at t = {time} s the forces push in a direction in which {what} gives way at first but not \
             beyond (a dead centre, or a position where two ways of moving meet): no finite force holds that"
        );
    }
    let units = if translates { "m/s^2" } else { "rad/s^2" };
    format!(
        "{what} allows these rates at t = {time} s but not beyond: they would accelerate it by {by:.3e} \
         {units} that nothing can undo (a dead centre, or a position where two ways of moving meet)"
    )
}
