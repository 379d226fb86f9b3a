//! Section of the report on redundant constraints and statically indeterminate reactions.

use crate::Job;
use crate::check::Findings;
use crate::report::html::{Column, folded, note, paragraph, section, table};
use stiction_core::statics::JointLoad;
use stiction_draw::numbers::number;

/// Largest number of self-stresses that the page lists.
const LISTED: usize = 24;

pub(super) fn redundancy(job: &Job<'_>, findings: &Findings) -> String {
    let mut inner = match findings.mobility.redundant_constraints {
        0 => paragraph("No constraint is redundant."),
        1 => paragraph("One constraint is redundant."),
        count => paragraph(&format!("{count} constraints are redundant.")),
    };
    if !findings.self_stresses.is_empty() {
        inner += &note(
            "In a self-stress, joints load each other without an external load; manufacturing \
             errors and thermal expansion cause self-stresses. Each wrench acts from the \
             predecessor on the successor, in world axes; moments are about the joint's origin. \
             Only their ratios are meaningful.",
        );
    }
    for (k, stress) in findings.self_stresses.iter().take(LISTED).enumerate() {
        let title = format!("self-stress {}: {}", k + 1, joints_of(job, stress));
        inner += &folded(&title, &self_stress(job, stress));
    }
    if findings.self_stresses.len() > LISTED {
        let more = findings.self_stresses.len() - LISTED;
        inner += &note(&format!("And {more} more, which check.json lists."));
    }
    inner += &undetermined(findings);
    inner += &paragraph(if findings.drives_unique {
        "Actuator efforts are unique (without friction)."
    } else {
        "Actuator efforts are not unique (without friction)."
    });
    section("Redundancy and uniqueness", &inner)
}

/// Returns the names of the first six joints in a self-stress, and the number of its further
/// joints.
fn joints_of(job: &Job<'_>, stress: &[JointLoad]) -> String {
    let name = |load: &JointLoad| job.model.mechanism.joints()[load.joint.0].name.as_str();
    let few: Vec<&str> = stress.iter().take(6).map(name).collect();
    match stress.len() - few.len() {
        0 => few.join(", "),
        1 => format!("{} and one more joint", few.join(", ")),
        more => format!("{} and {more} more joints", few.join(", ")),
    }
}

fn self_stress(job: &Job<'_>, stress: &[JointLoad]) -> String {
    let largest = |part: fn(&JointLoad) -> f64| stress.iter().map(part).fold(0.0, f64::max);
    let (force, moment) = (largest(|load| load.force.norm()), largest(|load| load.moment.norm()));
    // Values below the rounding error of the largest value become zero.
    let clean = |x: f64, largest: f64| {
        if x.abs() < 1e-9 * largest { "0".to_owned() } else { number(x) }
    };
    let rows: Vec<Vec<String>> = stress
        .iter()
        .map(|load| {
            let mut row = vec![job.model.mechanism.joints()[load.joint.0].name.clone()];
            row.extend(load.force.to_array().map(|x| clean(x, force)));
            row.extend(load.moment.to_array().map(|x| clean(x, moment)));
            row
        })
        .collect();
    let mut head = vec![("joint", Column::Text)];
    let components = ["fx [N]", "fy [N]", "fz [N]", "mx [N m]", "my [N m]", "mz [N m]"];
    head.extend(components.map(|name| (name, Column::Number)));
    table(&head, &rows)
}

fn undetermined(findings: &Findings) -> String {
    if findings.undetermined.is_empty() {
        return paragraph("Statics determines all reactions along the motion.");
    }
    let rows: Vec<Vec<String>> = findings
        .undetermined
        .iter()
        .map(|(joint, components)| vec![joint.clone(), components.join(" ")])
        .collect();
    let head = [("joint", Column::Text), ("not determined by statics", Column::Text)];
    table(&head, &rows)
        + &note(
            "These components of reactions depend on the stiffness of parts and on manufacturing \
             errors, not on loads alone. Where such a reaction presses a sliding surface, its \
             friction is not determined either.",
        )
}
