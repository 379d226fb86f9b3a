//! Sentences that describe the results of a check, for the terminal and the HTML report.

use super::json::CLEARANCE;
use super::{Findings, Kind, Weakness};
use crate::Job;
use stiction_core::mobility::{Architecture, FiniteMotion, GenericRank};
use stiction_draw::numbers::number;

/// Describes the motion that a mechanism gains at a singular pose, and the load that it cannot
/// carry there.
pub(super) fn gained(kind: Kind, weakness: &Weakness) -> String {
    let Weakness { body, motion, load, left } = weakness;
    let can_move = match kind {
        Kind::Actuation => format!("{body} can move with locked actuators"),
        Kind::Constraint => format!("no constraint resists a motion of {body}"),
        Kind::Leg => {
            format!("{body} can move although the bodies at the ends of its leg are fixed")
        }
    };
    let left = left.as_ref().map_or(String::new(), |left| format!("; {left}"));
    format!("{can_move}: {motion}; nothing balances {load}{left}")
}

/// Returns sentences that state whether every pose is singular, judged by random poses.
pub(super) fn in_general(findings: &Findings) -> Vec<String> {
    let Architecture { positions, constraints, actuated, .. } = &findings.architecture;
    let values = |rank: &GenericRank| {
        let kept = rank.kept.map_or("none counts".to_owned(), |kept| {
            format!("nonzero singular values are at least {}", power_of_ten(kept))
        });
        match rank.dropped {
            Some(dropped) => format!("{kept}, zero ones at most {}", power_of_ten(dropped)),
            None => format!("all {kept}"),
        }
    };
    let kinds = [(Kind::Actuation, actuated), (Kind::Constraint, constraints)];
    let sentence = |(kind, rank): (Kind, &GenericRank)| {
        let word = kind.word();
        match findings.everywhere(kind)? {
            true => Some(format!(
                "singular ({word}) in every position: {positions} random positions are singular \
                 too ({})",
                values(rank)
            )),
            false => findings.is_singular(kind).then(|| {
                format!(
                    "not singular ({word}) in every position: {positions} random positions are not \
                     singular ({})",
                    values(rank)
                )
            }),
        }
    };
    kinds.into_iter().filter_map(sentence).collect()
}

/// Returns a note if the finite mobility is decided to second order only, and an empty text
/// otherwise.
pub(super) fn undecided(findings: &Findings) -> &'static str {
    match findings.mobility.finite.decided() {
        Some(_) => "",
        None => "; decided to second order only",
    }
}

/// Describes a finite motion of the mechanism: the distance and the angle by which a body moves,
/// and the closure error of the loops.
pub(super) fn finite_motion(motion: &FiniteMotion) -> String {
    let FiniteMotion { body, moved, turned, closure } = motion;
    format!(
        "{body} moves by {} mm and {} deg within closure tolerance (loops open by {closure:.0e} of the \
         characteristic length)",
        number(moved * 1e3),
        number(turned.to_degrees()),
    )
}

/// Returns words for the axes about which bodies rotate passively: `its own axis` for one body,
/// `their own axes` for several.
pub(super) fn own_axes(count: usize) -> &'static str {
    if count == 1 { "its own axis" } else { "their own axes" }
}

/// Returns a statement on how well the actuators control the finite motions. `None` if this was not
/// computed, for example because all instantaneous motions are finite.
pub(super) fn actuation_of_motion(findings: &Findings) -> Option<String> {
    let (least, greatest, time) = findings.actuation_of_motion?;
    let zero = |x: f64| number(if x < 1e-9 { 0.0 } else { x });
    let here = format!(
        "if only finite motions count, the singularity index of actuation is {} (t = {} s) to {} along \
         this motion",
        zero(least),
        number(time),
        zero(greatest),
    );
    Some(match findings.architecture.actuation_of_motion {
        Some(elsewhere) => format!(
            "{here}, and up to {} in other positions (0: the mechanism can move with locked \
             actuators)",
            number(elsewhere)
        ),
        None => here,
    })
}

/// Describes the play that joint clearance causes, in one sentence for each motion that is blocked
/// at second order.
pub(super) fn play(job: &Job<'_>, findings: &Findings) -> Vec<String> {
    let mechanism = &job.model.mechanism;
    let each = findings.play().iter().map(|play| {
        let body = &mechanism.bodies()[play.motion.body].name;
        let joint = &mechanism.joints()[play.joint.0].name;
        let (amount, verb) = match play.motion.turns {
            true => (format!("{:.2} deg", play.with(CLEARANCE).to_degrees()), "turn"),
            false => (format!("{:.3} mm", play.with(CLEARANCE) * 1e3), "move"),
        };
        format!(
            "{:.0} um of clearance in {joint} lets {body} {verb} by {amount} to either side",
            CLEARANCE * 1e6
        )
    });
    each.collect()
}

/// Formats the order of magnitude of a number, such as `3e-5`; zero becomes `0`.
pub(super) fn power_of_ten(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.0e}") }
}
