//! Findings that a person reads.

use super::json::CLEARANCE;
use super::{Findings, Kind, Nearness, Range, Weakness};
use crate::inverse::Job;
use crate::inverse::terminal::{by_components, number};
use std::fmt::{self, Write};
use stiction::mobility::{Architecture, GenericRank, JointLoad};
use stiction::spatial::Vec3;

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
    write_mobility(out, job, findings)?;
    write_redundancy(out, job, findings)?;
    write_singularities(out, job, findings)?;
    write_sizes(out, findings)?;
    if !findings.warnings.is_empty() {
        writeln!(out)?;
    }
    findings.warnings.iter().try_for_each(|warning| writeln!(out, "warning: {warning}"))
}

fn write_mobility(out: &mut impl Write, job: &Job<'_>, findings: &Findings) -> fmt::Result {
    let mobility = &findings.mobility;
    writeln!(
        out,
        "degrees of freedom: {} by Gruebler's count, {} to first order, {} in motions of finite size",
        mobility.gruebler, mobility.instantaneous, mobility.finite,
    )?;
    if let (Some(kept), dropped) = mobility.gap {
        let dropped = dropped.map_or("none".to_owned(), power_of_ten);
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
    for play in findings.play().iter().take(LISTED) {
        let body = &job.model.mechanism.bodies()[play.motion.body].name;
        let joint = &job.model.mechanism.joints()[play.joint.0].name;
        let (amount, verb) = match play.motion.turns {
            true => (format!("{:.2} deg", play.with(CLEARANCE).to_degrees()), "turn"),
            false => (format!("{:.3} mm", play.with(CLEARANCE) * 1e3), "move"),
        };
        writeln!(
            out,
            "  {:.0} um of clearance in {joint} let {body} {verb} by {amount} to either side",
            CLEARANCE * 1e6
        )?;
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
    for (kind, nearness) in findings.singularities() {
        write_nearness(out, findings, kind, nearness)?;
    }
    write_in_general(out, findings)?;
    if let Some((least, greatest, time)) = findings.governance {
        let zero = |x: f64| if x < 1e-9 { 0.0 } else { x };
        write!(
            out,
            "  motions of finite size alone are governed by the actuators to {} (t = {} s) to {} along \
             this motion",
            number(zero(least)),
            number(time),
            number(zero(greatest)),
        )?;
        match findings.architecture.governance {
            Some(elsewhere) => writeln!(
                out,
                ", in other positions up to {} (0: one of them not at all)",
                number(elsewhere)
            )?,
            None => writeln!(out)?,
        }
    }
    writeln!(out)
}

fn write_nearness(
    out: &mut impl Write,
    findings: &Findings,
    kind: Kind,
    nearness: &Nearness,
) -> fmt::Result {
    let Nearness { least, time, singular_samples, weakness, crossings } = nearness;
    let word = kind.word();
    match *singular_samples {
        0 if crossings.is_empty() => {
            writeln!(out, "  {word:11} {:>9} at t = {} s", number(*least), number(*time))?;
        }
        0 => writeln!(out, "  {word:11}  singular between samples")?,
        n if n == findings.samples => writeln!(out, "  {word:11}  singular at every sample")?,
        n => writeln!(
            out,
            "  {word:11}  singular at {n} of {} samples, first of all at t = {} s",
            findings.samples,
            number(*time)
        )?,
    }
    for (time, gained) in crossings.iter().take(LISTED) {
        writeln!(out, "    at t = {time:.7} s {}", gain(kind, gained))?;
    }
    if crossings.len() > LISTED {
        writeln!(out, "    and {} times more", crossings.len() - LISTED)?;
    }
    match weakness {
        Some(gained) if *singular_samples > 0 && crossings.is_empty() => {
            writeln!(out, "    there {}", gain(kind, gained))
        }
        Some(weakest) if crossings.is_empty() => {
            writeln!(out, "    held least: {}, {}", weakest.body, weakest.motion)
        }
        _ => Ok(()),
    }
}

/// What a singular position brings.
fn gain(kind: Kind, weakness: &Weakness) -> String {
    let Weakness { body, motion, load, left } = weakness;
    let but = match kind {
        Kind::Actuation => "while the actuators stand",
        Kind::Constraint => "against the constraints",
        Kind::Leg => "while the bodies where legs end stand",
    };
    let left = left.as_ref().map_or(String::new(), |left| format!("; {left}"));
    format!("{body} gains, {but}, {motion}; nothing carries {load} there{left}")
}

/// Whether what is singular is so in every position.
fn write_in_general(out: &mut impl Write, findings: &Findings) -> fmt::Result {
    let Architecture { positions, constraints, actuated, .. } = &findings.architecture;
    let values = |rank: &GenericRank| {
        let value = |v: Option<f64>| v.map_or("none".to_owned(), power_of_ten);
        format!(
            "singular values that count are at least {}, the others at most {}",
            value(rank.kept),
            value(rank.dropped)
        )
    };
    for (kind, rank) in [(Kind::Actuation, actuated), (Kind::Constraint, constraints)] {
        let word = kind.word();
        match findings.everywhere(kind) {
            Some(true) => writeln!(
                out,
                "  in every position: at {positions} positions taken at random it is singular in {word}, \
                 too ({})",
                values(rank)
            )?,
            Some(false) if findings.is_singular(kind) => writeln!(
                out,
                "  not in every position: at {positions} positions taken at random it is not singular in \
                 {word} ({})",
                values(rank)
            )?,
            _ => {}
        }
    }
    Ok(())
}

fn write_sizes(out: &mut impl Write, findings: &Findings) -> fmt::Result {
    let sizes = &findings.sizes;
    writeln!(out, "mass {} kg, centred at {} m", number(sizes.mass), point(sizes.centre))?;
    for (body, least, greatest) in sizes.reach.iter().take(LISTED) {
        let (least, greatest) = (point(*least), point(*greatest));
        writeln!(out, "  the centre of {body} stays between {least} and {greatest} m")?;
    }
    if sizes.reach.len() > LISTED {
        writeln!(out, "  and {} more bodies", sizes.reach.len() - LISTED)?;
    }
    for leg in sizes.legs.iter().take(LISTED) {
        writeln!(out, "  {} is {} long", leg.name, range(leg))?;
    }
    if sizes.legs.len() > LISTED {
        writeln!(out, "  and {} more legs", sizes.legs.len() - LISTED)?;
    }
    for joint in sizes.joints.iter().take(LISTED) {
        writeln!(out, "  {}: {}", joint.name, range(joint))?;
    }
    if sizes.joints.len() > LISTED {
        writeln!(out, "  and {} more freedoms of joints", sizes.joints.len() - LISTED)?;
    }
    Ok(())
}

fn power_of_ten(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.0e}") }
}

fn point(point: Vec3<f64>) -> String {
    let [x, y, z] = point.to_array().map(|c| number(if c.abs() < 1e-12 { 0.0 } else { c }));
    format!("({x}, {y}, {z})")
}

fn range(range: &Range) -> String {
    let (scale, unit) = if range.unit == "rad" { (1f64.to_degrees(), "deg") } else { (1e3, "mm") };
    let Range { least, greatest, .. } = range;
    format!(
        "{:.3} to {:.3} {unit} (by {:.3})",
        least * scale,
        greatest * scale,
        (greatest - least) * scale
    )
}
