//! Results of a check as text for the terminal.

use super::{Findings, Kind, Nearness, Range, words};
use crate::Job;
use crate::names::heading_of;
use crate::undetermined::by_components;
use std::fmt::{self, Write};
use stiction_core::spatial::Vec3;
use stiction_core::statics::JointLoad;
use stiction_draw::numbers::number;

/// Largest number of bodies, joints and ranges that the text lists.
const LISTED: usize = 12;

/// Writes the results of a check as plain text.
///
/// # Errors
/// Returns an error if writing to `out` fails.
pub fn write_report(out: &mut impl Write, job: &Job<'_>, findings: &Findings) -> fmt::Result {
    writeln!(out, "{}", heading_of(job.model))?;
    writeln!(
        out,
        "motion {} ({} sample{}), mobility and redundancy at t = {} s\n",
        job.motion_name,
        findings.samples,
        if findings.samples == 1 { "" } else { "s" },
        number(findings.start),
    )?;
    if let Some(interpolation) = &job.motion.interpolation {
        writeln!(out, "{interpolation}\n")?;
    }
    if let Some(sentence) = findings.assembly.sentence() {
        writeln!(out, "{sentence}\n")?;
    }
    write_mobility(out, job, findings)?;
    write_redundancy(out, job, findings)?;
    write_singularities(out, job, findings)?;
    write_sizes(out, findings)?;
    if !findings.warnings.is_empty() || !findings.cautions.is_empty() {
        writeln!(out)?;
    }
    findings.warnings.iter().try_for_each(|warning| writeln!(out, "warning: {warning}"))?;
    findings.cautions.iter().try_for_each(|caution| writeln!(out, "CAUTION: {caution}"))
}

fn write_mobility(out: &mut impl Write, job: &Job<'_>, findings: &Findings) -> fmt::Result {
    let mobility = &findings.mobility;
    writeln!(
        out,
        "degrees of freedom: {} by Gruebler's count, {} instantaneous, {} finite{}",
        mobility.gruebler,
        mobility.instantaneous,
        mobility.finite,
        words::undecided(findings),
    )?;
    if let (Some(kept), dropped) = mobility.gap {
        let dropped = dropped.map_or("none".to_owned(), words::power_of_ten);
        writeln!(
            out,
            "  decided by the gap of singular values: smallest nonzero {kept:.1e}, largest zero \
             {dropped} (relative to the largest)"
        )?;
    }
    if let Some(motion) = &mobility.finite_motion {
        writeln!(out, "  {}", words::finite_motion(motion))?;
    }
    if !findings.idle_spins.is_empty() {
        writeln!(
            out,
            "  local degrees of freedom: {}; {} can spin about {}",
            findings.idle_spins.len(),
            findings.idle_spins.join(", "),
            words::own_axes(findings.idle_spins.len()),
        )?;
    }
    if findings.mobility.branches_meet {
        writeln!(
            out,
            "  the degrees of freedom are not all available at once: branches of motion meet at \
             this position"
        )?;
    }
    // The bodies with the most independent motions come first, because the tool is usually on one
    // of them.
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
        writeln!(out, "  and {} more", bodies.len() - LISTED)?;
    }
    for sentence in words::play(job, findings).iter().take(LISTED) {
        writeln!(out, "  {sentence}")?;
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
    if findings.drives == 0 {
        return writeln!(out, "no joint is actuated\n");
    }
    let unique = if findings.drives_unique { "are" } else { "are not" };
    writeln!(out, "actuator efforts {unique} unique (without friction)\n")
}

fn write_singularities(out: &mut impl Write, job: &Job<'_>, findings: &Findings) -> fmt::Result {
    let length = job.model.mechanism.characteristic_length();
    writeln!(
        out,
        "nearest singular positions: least singularity index (0 is singular; lengths in units of \
         {:.1} mm)",
        length * 1e3
    )?;
    for (kind, nearness) in findings.singularities() {
        write_nearness(out, findings, kind, nearness)?;
    }
    for sentence in words::in_general(findings).iter().chain(&words::actuation_of_motion(findings))
    {
        writeln!(out, "  {sentence}")?;
    }
    writeln!(out)
}

fn write_nearness(
    out: &mut impl Write,
    findings: &Findings,
    kind: Kind,
    nearness: &Nearness,
) -> fmt::Result {
    let Nearness { least, time, singular_samples, weakness, crossings, not_searched } = nearness;
    let word = kind.word();
    match *singular_samples {
        0 if crossings.is_empty() => {
            writeln!(out, "  {word:11} {:>9} at t = {} s", number(*least), number(*time))?;
        }
        0 => writeln!(out, "  {word:11}  singular between samples")?,
        n if n == findings.samples => writeln!(out, "  {word:11}  singular at every sample")?,
        n => writeln!(
            out,
            "  {word:11}  singular at {n} of {} samples, first at t = {} s",
            findings.samples,
            number(*time)
        )?,
    }
    for (time, gained) in crossings.iter().take(LISTED) {
        writeln!(out, "    at t = {time:.7} s: {}", words::gained(kind, gained))?;
    }
    if crossings.len() > LISTED {
        writeln!(out, "    and at {} more times", crossings.len() - LISTED)?;
    }
    if *not_searched > 0 {
        writeln!(
            out,
            "    {not_searched} further approaches to singular positions were not examined"
        )?;
    }
    match weakness {
        Some(gained) if *singular_samples > 0 && crossings.is_empty() => {
            writeln!(out, "    {}", words::gained(kind, gained))
        }
        Some(weakest) if crossings.is_empty() => {
            writeln!(out, "    least constrained: {}, {}", weakest.body, weakest.motion)
        }
        _ => Ok(()),
    }
}

fn write_sizes(out: &mut impl Write, findings: &Findings) -> fmt::Result {
    let sizes = &findings.sizes;
    writeln!(out, "mass {} kg, centred at {} m", number(sizes.mass), point(sizes.centre))?;
    for body in sizes.bodies.iter().take(LISTED) {
        let [a, b, c] = body.moments.map(|moment| number(moment.max(0.0)));
        writeln!(
            out,
            "  {}: {} kg at {} m, principal inertias {a}, {b}, {c} kg m^2",
            body.name,
            number(body.mass),
            point(body.centre),
        )?;
    }
    if sizes.bodies.len() > LISTED {
        writeln!(out, "  and {} more", sizes.bodies.len() - LISTED)?;
    }
    for (body, least, greatest) in sizes.reach.iter().take(LISTED) {
        let (least, greatest) = (point(*least), point(*greatest));
        writeln!(out, "  the centre of mass of {body} stays between {least} and {greatest} m")?;
    }
    if sizes.reach.len() > LISTED {
        writeln!(out, "  and {} more", sizes.reach.len() - LISTED)?;
    }
    for leg in sizes.legs.iter().take(LISTED) {
        writeln!(out, "  {}: length {}", leg.name, range(leg))?;
    }
    if sizes.legs.len() > LISTED {
        writeln!(out, "  and {} more legs", sizes.legs.len() - LISTED)?;
    }
    for joint in sizes.joints.iter().take(LISTED) {
        writeln!(out, "  {}: {}", joint.name, range(joint))?;
    }
    if sizes.joints.len() > LISTED {
        writeln!(out, "  and {} more joint coordinates", sizes.joints.len() - LISTED)?;
    }
    Ok(())
}

fn point(point: Vec3<f64>) -> String {
    let [x, y, z] = point.to_array().map(|c| number(if c.abs() < 1e-12 { 0.0 } else { c }));
    format!("({x}, {y}, {z})")
}

fn range(range: &Range) -> String {
    let ([least, greatest, by], unit) = range.in_words();
    format!("{least} to {greatest} {unit} (range {by} {unit})")
}
