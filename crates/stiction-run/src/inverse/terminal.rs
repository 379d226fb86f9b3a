//! Summary of a run as text for the terminal.

use super::certainty::{MOST_MARGIN, Margin};
use super::summary::{Summary, weighting_words};
use super::uniqueness::Singular;
use super::verdict::Verdict;
use crate::gearing_load::write_gearings;
use crate::job::{Job, friction_word};
use crate::names::{heading_of, listed, width};
use crate::statistics::Integral;
use crate::undetermined::by_components;
use std::fmt::{self, Write};
use stiction_core::dynamics::FrictionMode;
use stiction_draw::numbers::{number, order, percent};

/// Singularity index below which the text summary calls a pose singular. If the mechanism moves,
/// the index at a singular pose is accurate only to the square root of the rounding error.
pub(super) const ROOT_OF_ROUNDING: f64 = 1e-6;
/// Actuation singularity index below which the text summary contains a caution.
pub(super) const NEAR_SINGULAR: f64 = 1e-3;
/// Largest number of joints, and of friction interfaces, that the text summary lists.
const LISTED: usize = 6;

/// Writes the summary as text.
///
/// # Errors
/// Fails if the receiver of the text fails.
pub fn write_summary(
    out: &mut impl Write,
    job: &Job<'_>,
    summary: &Summary,
    verdict: &Verdict,
) -> fmt::Result {
    writeln!(out, "{}", heading_of(job.model))?;
    let count = verdict.samples;
    writeln!(
        out,
        "motion {} ({} s, {count} sample{}), load {}, friction {}",
        job.motion_name,
        number(job.motion.duration),
        if count == 1 { "" } else { "s" },
        job.load_name,
        if job.friction != FrictionMode::Off && summary.names.interfaces.is_empty() {
            "not declared"
        } else {
            friction_word(job.friction)
        },
    )?;
    if let Some(interpolation) = &job.motion.interpolation {
        writeln!(out, "{interpolation}")?;
    }
    job.motion.notes.iter().try_for_each(|note| writeln!(out, "{note}"))?;
    writeln!(out)?;
    write_drives(out, job, summary)?;
    write_rest(out, summary)?;
    summary.motors.write(out)?;
    write_reactions(out, summary, job.model.mechanism.characteristic_length())?;
    write_friction(out, job, summary, verdict)?;
    write_verdicts(out, job, summary, verdict)?;
    write_certainty(out, summary, verdict)?;
    summary.cautions(job).iter().try_for_each(|caution| writeln!(out, "CAUTION: {caution}"))
}

fn write_drives(out: &mut impl Write, job: &Job<'_>, summary: &Summary) -> fmt::Result {
    if summary.drives.is_empty() {
        return writeln!(out, "no joint is actuated: there are no efforts\n");
    }
    let wide = width(summary.names.drives.iter().map(|(name, _)| name.as_str()), 13);
    let has_friction = job.friction != FrictionMode::Off && !summary.names.interfaces.is_empty();
    if has_friction {
        writeln!(
            out,
            "{:wide$}  {:>23}  {:>23}  {:>19}",
            "", "with friction", "frictionless", "friction changes by"
        )?;
        writeln!(
            out,
            "{:wide$}  {:>11} {:>11}  {:>11} {:>11}  {:>9} {:>9}",
            "effort", "peak", "rms", "peak", "rms", "max/max", "rms/rms"
        )?;
    } else {
        writeln!(out, "{:wide$}  {:>11} {:>11}  {:>11}", "effort", "peak", "rms", "peak at")?;
    }
    for ((name, unit), comparison) in summary.names.drives.iter().zip(&summary.drives) {
        let (with, without) = (&comparison.with, &comparison.without);
        write!(out, "{name:wide$}  {:>11} {:>11}", number(with.peak), number(with.rms()))?;
        if has_friction {
            let metrics = comparison.metrics();
            writeln!(
                out,
                "  {:>11} {:>11}  {:>9} {:>9}  {unit}",
                number(without.peak),
                number(without.rms()),
                percent(metrics.max_over_max),
                percent(metrics.rms_over_rms),
            )?;
        } else {
            writeln!(out, "  {:>9} s  {unit}", number(with.peak_time))?;
        }
    }
    writeln!(out)
}

/// Writes the widest intervals of possible efforts while joints are at rest, and how certain these
/// intervals are.
fn write_rest(out: &mut impl Write, summary: &Summary) -> fmt::Result {
    if summary.resting_samples == 0 {
        return Ok(());
    }
    let names = &summary.names.drives;
    let wide = width(names.iter().map(|(name, _)| name.as_str()), 13);
    writeln!(
        out,
        "joints at rest at {} sample{}; widest intervals of the efforts under static friction:",
        summary.resting_samples,
        if summary.resting_samples == 1 { "" } else { "s" },
    )?;
    for (k, (name, unit)) in names.iter().enumerate() {
        let (size, (low, high)) = (&summary.widest[k], summary.widest_bounds[k]);
        let time = number(size.peak_time);
        if size.peak.is_infinite() {
            writeln!(out, "{name:wide$}  without limit where friction locks, at t = {time} s")?;
        } else if size.peak > 0.0 {
            let (low, high) = (number(low), number(high));
            writeln!(out, "{name:wide$}  {low:>11} to {high:>11} {unit} at t = {time} s")?;
        }
    }
    let certainty = &summary.certainty;
    if certainty.attained > 0 {
        writeln!(
            out,
            "at {} of these samples the interval is an inner bound; friction and reactions are \
             coupled too strongly for a guaranteed bound",
            certainty.attained,
        )?;
    }
    if certainty.certified > 0 {
        let beyond = summary.certified_within.iter().zip(&summary.names.drives);
        let beyond = beyond.max_by(|a, b| a.0.total_cmp(b.0));
        if let Some((beyond, (name, unit))) = beyond {
            writeln!(
                out,
                "at {} of these samples the interval is an inner bound; guaranteed bounds lie at most {} {unit} \
                 beyond ({name})",
                certainty.certified,
                number(*beyond),
            )?;
        }
    }
    if summary.unbounded_samples > 0 {
        writeln!(
            out,
            "at {} of these samples the interval is not known, and drive_low and drive_high \
             equal drive: the position is singular, or constraints and actuators are both \
             redundant",
            summary.unbounded_samples,
        )?;
    }
    writeln!(out)
}

fn write_reactions(out: &mut impl Write, summary: &Summary, length: f64) -> fmt::Result {
    let reactions = &summary.reactions.0;
    let mut joints: Vec<usize> = (0..reactions.len()).collect();
    joints.sort_by(|&a, &b| reactions[b].0.peak.total_cmp(&reactions[a].0.peak));
    let listed = &joints[..joints.len().min(LISTED)];
    let wide = width(listed.iter().map(|&k| summary.names.joints[k].as_str()), 13);
    writeln!(
        out,
        "{:wide$}  {:>11} {:>11}  {:>13} {:>9}",
        "most loaded", "force", "at", "moment", "at"
    )?;
    for &k in listed {
        let (force, moment) = &reactions[k];
        // Values as small as rounding errors become zero.
        let noise = 1e-12 * force.peak * length;
        write!(
            out,
            "{:wide$}  {:>9} N {:>9} s  ",
            summary.names.joints[k],
            number(force.peak),
            number(force.peak_time),
        )?;
        if moment.peak < noise {
            writeln!(out, "{:>9} N m", number(0.0))?;
        } else {
            writeln!(out, "{:>9} N m {:>9} s", number(moment.peak), number(moment.peak_time))?;
        }
    }
    if !summary.gearings.is_empty() {
        writeln!(out)?;
        write_gearings(out, &summary.names.gearings, &summary.gearings)?;
    }
    writeln!(out)
}

fn write_friction(
    out: &mut impl Write,
    job: &Job<'_>,
    summary: &Summary,
    verdict: &Verdict,
) -> fmt::Result {
    if !summary.has_friction(job) {
        return Ok(());
    }
    // A single instant has power but no work.
    let is_pose = verdict.samples == 1;
    let amount = |integral: &Integral| if is_pose { integral.last() } else { integral.value };
    let total = amount(&summary.work.dissipated);
    let mut interfaces: Vec<(f64, &str)> = summary
        .dissipated
        .iter()
        .zip(&summary.names.interfaces)
        .map(|(integral, (name, _))| (amount(integral), name.as_str()))
        .collect();
    interfaces.sort_by(|a, b| b.0.total_cmp(&a.0));
    let unit = if is_pose { "W" } else { "J" };
    write!(out, "friction dissipates {} {unit}", number(total))?;
    // Fractions of a zero total do not exist.
    if total != 0.0 {
        let share = |(part, name): &(f64, &str)| format!("{name} {}", percent(Some(part / total)));
        write!(out, ": {}", listed(interfaces.iter().map(share), LISTED))?;
    }
    writeln!(out)?;
    let changes = summary.drives.iter().map(|drive| (drive.difference.rms(), drive.with.rms()));
    let changes: Vec<(f64, f64)> = changes.collect();
    summary.shares.write(out, &summary.names, &changes)?;
    summary.efficiency.write(out, &summary.names)?;
    let steady = &summary.names.steady;
    if !steady.is_empty() {
        writeln!(
            out,
            "friction at {} is that of steady sliding, because its law has an internal state",
            listed(steady, LISTED),
        )?;
    }
    writeln!(out)
}

fn write_verdicts(
    out: &mut impl Write,
    job: &Job<'_>,
    summary: &Summary,
    verdict: &Verdict,
) -> fmt::Result {
    writeln!(
        out,
        "loop closure error {} m; relative power residual {}",
        order(summary.closure.peak),
        order(summary.power_residual_relative.peak.abs()),
    )?;
    let length = job.model.mechanism.characteristic_length();
    writeln!(
        out,
        "least singularity index (0 is singular): actuation {} at t = {} s, constraint {} at t = \
         {} s (lengths in units of {:.1} mm)",
        number(summary.actuation.value),
        number(summary.actuation.time),
        number(summary.constraint.value),
        number(summary.constraint.time),
        length * 1e3,
    )?;
    for (from, to) in verdict.passed_singularities.iter().take(LISTED) {
        writeln!(
            out,
            "CAUTION: between t = {} s and t = {} s the mechanism passes a singular position, \
             where without friction no finite effort exists",
            number(*from),
            number(*to),
        )?;
    }
    if let Some(singular) = &verdict.singular {
        write_singular(out, summary, verdict, singular)?;
    } else if summary.actuation.value < ROOT_OF_ROUNDING {
        writeln!(
            out,
            "CAUTION: at t = {} s the position is singular to rounding: forces there consist of rounding errors",
            number(summary.actuation.time),
        )?;
    } else if summary.actuation.value < NEAR_SINGULAR {
        writeln!(
            out,
            "CAUTION: near a singular position, frictionless efforts and the effects of model \
             errors are inversely proportional to the singularity index",
        )?;
    }
    if !verdict.idle_spins.is_empty() {
        writeln!(
            out,
            "passive rotation about {} own ax{}: {}; rate set to zero",
            if verdict.idle_spins.len() == 1 { "its" } else { "their" },
            if verdict.idle_spins.len() == 1 { "is" } else { "es" },
            verdict.idle_spins.join(", "),
        )?;
    }
    let undetermined = summary.undetermined();
    if undetermined.is_empty() {
        return write_unique(out, "all reactions and actuator efforts", verdict);
    }
    let unique = summary.drives_are_unique(job.friction);
    writeln!(
        out,
        "{} redundan{}: statics does not determine {}",
        verdict.redundancy,
        if verdict.redundancy == 1 { "cy" } else { "cies" },
        by_components(&undetermined),
    )?;
    if let Some(words) = weighting_words(job, verdict) {
        writeln!(out, "the reported values follow from {words}")?;
    }
    if unique {
        return write_unique(out, "actuator efforts", verdict);
    }
    let open: Vec<&str> = summary.frictions_that_are_not_unique().collect();
    if verdict.singular.is_some() {
        writeln!(out, "actuator efforts are not unique where the position is singular")
    } else if open.is_empty() {
        writeln!(out, "actuator efforts are not unique: actuators are redundant")
    } else {
        writeln!(
            out,
            "actuator efforts are not unique: friction at {} depends on reactions that are not \
             unique",
            open.join(", ")
        )
    }
}

/// Writes the singular poses at which the mechanism can carry the load, because the load does no
/// work on the motion that the mechanism gains.
fn write_singular(
    out: &mut impl Write,
    summary: &Summary,
    verdict: &Verdict,
    singular: &Singular,
) -> fmt::Result {
    let Singular { samples, time, body, motion, load, null_directions } = singular;
    writeln!(
        out,
        "CAUTION: the position is singular at {samples} of {} samples, first at t = {} s: with \
         all actuators locked, {body} can move ({motion}), and {load} could not be balanced. The \
         present load happens to be balanced: forces are finite, but not unique",
        verdict.samples,
        number(*time),
    )?;
    for (k, direction) in null_directions.iter().take(LISTED).enumerate() {
        let drives = summary.names.drives.iter().zip(&direction.drives);
        let drives: Vec<String> = drives
            .filter(|(_, part)| **part != 0.0)
            .map(|((name, unit), part)| format!("{name} {} {unit}", number(*part)))
            .collect();
        let joints: Vec<&str> = direction
            .joints
            .iter()
            .map(|load| summary.names.joints[load.joint.0].as_str())
            .collect();
        writeln!(
            out,
            "  null direction {} (any multiple of it): {}; reactions of {}",
            k + 1,
            if drives.is_empty() { "no effort".to_owned() } else { drives.join(", ") },
            joints.join(", "),
        )?;
    }
    Ok(())
}

/// Writes whether the solution with friction is unique; `what` names the results concerned.
fn write_unique(out: &mut impl Write, what: &str, verdict: &Verdict) -> fmt::Result {
    if let Some(coupling) = verdict.coupling.filter(|coupling| *coupling < 1.0) {
        return match coupling > 1e-9 {
            // Rounded down, because the factor is a guaranteed bound. The factor
            // 1 + 1e-12 prevents the loss of a digit by round-off.
            true => writeln!(
                out,
                "{what} are unique, even with up to {} times this friction",
                number((100.0 / coupling * (1.0 + 1e-12)).floor() / 100.0)
            ),
            false => writeln!(out, "{what} are unique"),
        };
    }
    writeln!(out, "without friction {what} are unique")?;
    match verdict.coupling {
        Some(coupling) => writeln!(
            out,
            "with friction there may be other solutions (coupling {}, unique below 1); the \
             reported solution is continued from zero friction",
            number(coupling),
        ),
        None => writeln!(
            out,
            "with friction there may be other solutions; it is not known whether they exist"
        ),
    }
}

/// Writes other solutions with friction, if any were found, and the friction margin to jamming, if
/// it was computed.
fn write_certainty(out: &mut impl Write, summary: &Summary, verdict: &Verdict) -> fmt::Result {
    if let Some(others) = &verdict.other_solutions {
        let count = others.drives.len();
        writeln!(
            out,
            "CAUTION: friction has other solutions at {} of {} samples, found by Newton's method \
             from many starts; the reported one is continued from zero friction. At t = {} s {}:",
            others.samples,
            verdict.samples,
            number(others.time),
            if count == 1 { "it is".to_owned() } else { format!("there are {count}") },
        )?;
        for drives in others.drives.iter().take(LISTED) {
            let named = summary.names.drives.iter().zip(drives);
            let each = named.map(|((name, unit), x)| format!("{name} {} {unit}", number(*x)));
            writeln!(out, "  {}", each.collect::<Vec<_>>().join(", "))?;
        }
    }
    match &verdict.friction_margin {
        None => Ok(()),
        Some(Margin { factor: Some(factor), time, joint }) => writeln!(
            out,
            "all friction coefficients can grow by a factor of {}; then friction locks {} at t = \
             {} s",
            number(*factor),
            joint.as_deref().unwrap_or("the mechanism"),
            number(*time),
        ),
        Some(Margin { factor: None, .. }) => writeln!(
            out,
            "all friction coefficients can grow by a factor of {MOST_MARGIN}, and nothing locks"
        ),
    }
}
