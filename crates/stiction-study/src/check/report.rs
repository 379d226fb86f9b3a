//! Findings that a person reads.

use super::{Findings, Nearness};
use crate::inverse::Job;
use crate::inverse::terminal::{by_components, number};
use std::fmt::{self, Write};
use stiction::mobility::JointLoad;

/// Bodies, joints and ranges listed at most.
const LISTED: usize = 12;

/// Writes the findings as plain text.
///
/// # Errors
/// What the receiver says.
pub fn write_report(out: &mut impl Write, job: &Job<'_>, findings: &Findings) -> fmt::Result {
    match job.model.title.as_str() {
        "" => writeln!(out, "{}", job.model.name)?,
        title => writeln!(out, "{}: {title}", job.model.name)?,
    }
    writeln!(
        out,
        "motion {} ({} sample{}), counts at t = {} s\n",
        job.motion_name,
        findings.samples,
        if findings.samples == 1 { "" } else { "s" },
        number(findings.start),
    )?;
    write_mobility(out, findings)?;
    write_redundancy(out, job, findings)?;
    write_singularities(out, job, findings)?;
    write_sizes(out, findings)?;
    if !findings.warnings.is_empty() {
        writeln!(out)?;
    }
    findings.warnings.iter().try_for_each(|warning| writeln!(out, "warning: {warning}"))
}

fn write_mobility(out: &mut impl Write, findings: &Findings) -> fmt::Result {
    let mobility = &findings.mobility;
    writeln!(
        out,
        "degrees of freedom: {} by Gruebler's count, {} to first order, {} in motions of finite size",
        mobility.gruebler, mobility.instantaneous, mobility.finite,
    )?;
    if let (Some(kept), dropped) = mobility.gap {
        let dropped = dropped.map_or("none".to_owned(), |dropped| format!("{dropped:.0e}"));
        writeln!(
            out,
            "  decided by a gap: smallest singular value that counts {kept:.1e}, largest that does not \
             {dropped} (of the largest)"
        )?;
    }
    if !findings.idle_spins.is_empty() {
        writeln!(
            out,
            "  {} of them idle: {} free to spin about an axis of its own",
            findings.idle_spins.len(),
            findings.idle_spins.join(", ")
        )?;
    }
    // Hubs first: what a robot carries its tool with has the most freedoms.
    let mut bodies: Vec<_> = mobility.bodies.iter().collect();
    bodies.sort_by_key(|body| std::cmp::Reverse(body.motions.len() + body.first_order_only.len()));
    for body in bodies.iter().take(LISTED) {
        write!(out, "  {}: ", body.body)?;
        match body.motions.is_empty() {
            true => write!(out, "does not move")?,
            false => write!(out, "{}", body.motions.join("; "))?,
        }
        match body.first_order_only.is_empty() {
            true => writeln!(out)?,
            false => {
                writeln!(out, "; and, to first order only, {}", body.first_order_only.join("; "))?;
            }
        }
    }
    if bodies.len() > LISTED {
        writeln!(out, "  and {} more bodies", bodies.len() - LISTED)?;
    }
    writeln!(out)
}

fn write_redundancy(out: &mut impl Write, job: &Job<'_>, findings: &Findings) -> fmt::Result {
    let count = findings.mobility.redundant_constraints;
    match count {
        0 => writeln!(out, "no constraint is redundant")?,
        1 => writeln!(out, "1 redundant constraint")?,
        _ => writeln!(out, "{count} redundant constraints")?,
    }
    for (k, stress) in findings.self_stresses.iter().take(LISTED).enumerate() {
        let joint = |load: &JointLoad| job.model.mechanism.joints()[load.joint.0].name.as_str();
        let joints: Vec<&str> = stress.iter().map(joint).collect();
        writeln!(out, "  self-stress {}: {}", k + 1, joints.join(", "))?;
    }
    if findings.undetermined.is_empty() {
        writeln!(out, "statics determines all reactions")?;
    } else {
        let undetermined: Vec<(&str, Vec<&'static str>)> = findings
            .undetermined
            .iter()
            .map(|(joint, components)| (joint.as_str(), components.clone()))
            .collect();
        writeln!(out, "statics does not determine {}", by_components(&undetermined))?;
    }
    let unique = if findings.drives_unique { "are" } else { "are not" };
    writeln!(out, "driving forces {unique} unique (friction apart)\n")
}

fn write_singularities(out: &mut impl Write, job: &Job<'_>, findings: &Findings) -> fmt::Result {
    let length = job.model.mechanism.characteristic_length();
    writeln!(
        out,
        "nearest singular positions (0 is singular; lengths in units of {:.1} mm)",
        length * 1e3
    )?;
    let mut line = |kind: &str, nearness: &Nearness| {
        let Nearness { least, time, singular_samples } = *nearness;
        match singular_samples {
            0 => writeln!(out, "  {kind:11} {:>9} at t = {} s", number(least), number(time)),
            n if n == findings.samples => writeln!(out, "  {kind:11}  singular at every sample"),
            n => writeln!(
                out,
                "  {kind:11}  singular at {n} of {} samples, first of all at t = {} s",
                findings.samples,
                number(time)
            ),
        }
    };
    line("actuation", &findings.actuation)?;
    line("constraint", &findings.constraint)?;
    if let Some(leg) = &findings.leg {
        line("leg", leg)?;
    }
    for (from, to) in findings.passed.iter().take(LISTED) {
        writeln!(
            out,
            "  a singularity of actuation is passed between t = {} s and t = {} s",
            number(*from),
            number(*to)
        )?;
    }
    writeln!(out)
}

fn write_sizes(out: &mut impl Write, findings: &Findings) -> fmt::Result {
    let [x, y, z] = findings.com.to_array().map(|c| number(if c.abs() < 1e-12 { 0.0 } else { c }));
    writeln!(out, "mass {} kg, centred at ({x}, {y}, {z}) m", number(findings.mass))?;
    for (name, unit, least, greatest) in findings.ranges.iter().take(LISTED) {
        let (scale, unit) = if *unit == "rad" { (1f64.to_degrees(), "deg") } else { (1e3, "mm") };
        writeln!(
            out,
            "  {name}: {:.3} to {:.3} {unit} (by {:.3})",
            least * scale,
            greatest * scale,
            (greatest - least) * scale
        )?;
    }
    if findings.ranges.len() > LISTED {
        writeln!(out, "  and {} more", findings.ranges.len() - LISTED)?;
    }
    Ok(())
}
