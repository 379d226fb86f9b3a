//! Warnings that a check of a mechanism gives to the user.

use super::{Findings, Kind};
use crate::Job;
use stiction_draw::numbers::number;

/// Singularity index below which a warning is given. At smaller indices, forces can be a hundred or
/// more times as large as the load.
const NEAR: f64 = 0.01;
/// Limit below which a rank decision is doubtful: the ratio of the smallest nonzero singular value
/// of the loop constraints to the largest one.
const DOUBTFUL: f64 = 1e-6;

/// Returns all warnings of a check as sentences.
pub(super) fn warnings(findings: &Findings, job: &Job<'_>) -> Vec<String> {
    let mut warnings = Vec::new();
    let drives = findings.drives;
    let driven = findings.to_be_driven();
    if drives > 0 && drives < driven {
        warnings.push(format!(
            "{} cannot control {}: actuate more joints",
            several(drives, "actuator"),
            several(driven, "degree"),
        ));
    }
    if drives > driven {
        warnings.push(format!(
            "{} for {}: actuator efforts are not unique and follow from the declared weighting",
            several(drives, "actuator"),
            several(driven, "degree"),
        ));
    }
    for (kind, nearness) in findings.singularities() {
        let word = kind.word();
        let everywhere = findings.everywhere(kind) == Some(true);
        match nearness.singular_samples {
            0 if nearness.crossings.is_empty() && nearness.least < NEAR => warnings.push(format!(
                "nearly singular ({word}) at t = {} s: the singularity index is {}",
                number(nearness.time),
                number(nearness.least)
            )),
            0 if nearness.crossings.is_empty() => {}
            0 => warnings.push(format!(
                "the motion passes or touches a singular position ({word}), first at t = {} s",
                number(nearness.crossings[0].0)
            )),
            _ if everywhere && kind == Kind::Actuation && drives < driven => {}
            _ if everywhere => warnings.push(format!(
                "singular ({word}) in every position: no other pose or motion avoids it"
            )),
            n => warnings.push(format!("singular ({word}) at {n} of {} samples", findings.samples)),
        }
    }
    if findings.mobility.finite.greatest < findings.mobility.instantaneous {
        warnings.push(
            "some motion is possible only to first order (the loops block it at second order): \
             even small clearance or compliance permits large displacements"
                .to_owned(),
        );
    }
    let finite = findings.mobility.finite;
    if finite.decided().is_none() {
        let traced = match finite.traced {
            0 => "no motion was traced over a finite distance".to_owned(),
            1 => "one motion was traced over a finite distance within closure tolerance".to_owned(),
            n => format!("{n} motions were traced over a finite distance within closure tolerance"),
        };
        warnings.push(format!(
            "the finite mobility is undecided ({finite}): {traced}, and second-order conditions \
             block {} of {} instantaneous motions",
            findings.mobility.instantaneous.saturating_sub(finite.greatest),
            findings.mobility.instantaneous
        ));
    }
    let (kept, dropped) = findings.mobility.gap;
    if let Some(kept) = kept.filter(|kept| *kept < DOUBTFUL) {
        warnings.push(format!(
            "the instantaneous mobility is uncertain: a singular value of {kept:.1e} counts as \
             nonzero; a change of dimensions by this fraction of the characteristic length \
             changes the mobility"
        ));
    }
    if let Some(dropped) = dropped.filter(|dropped| *dropped > 1e-12) {
        warnings.push(format!(
            "the instantaneous mobility is uncertain: a singular value of {dropped:.1e} \
             counts as zero"
        ));
    }
    for (what, rank) in [
        ("constraints", &findings.architecture.constraints),
        ("constraints and actuators", &findings.architecture.actuated),
    ] {
        if !rank.decided {
            warnings.push(format!(
                "undecided whether {what} are independent in general: for the given dimensions, \
                 singular values are neither clearly zero nor clearly nonzero ({})",
                number(rank.kept.unwrap_or(0.0))
            ));
        }
    }
    let slides = findings.sizes.joints.iter().filter(|range| range.unit == "m");
    for range in slides.filter(|range| range.least < 0.0 && range.greatest > 0.0) {
        let is_leg = findings.sizes.legs.iter().any(|leg| range.name.starts_with(&leg.name));
        if is_leg {
            warnings.push(format!(
                "the sliding joint {} of a leg passes through zero length",
                range.name
            ));
        }
    }
    let no_friction = job.model.mechanism.joints().iter().all(|joint| joint.friction.is_empty());
    if no_friction && drives > 0 {
        warnings.push("no joint declares friction".to_owned());
    }
    warnings
}

/// Returns a count with its noun: `1 actuator`, `3 actuators`, `2 degrees of freedom`.
fn several(count: usize, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    let of = if what == "degree" { " of freedom" } else { "" };
    format!("{count} {what}{plural}{of}")
}
