//! Summary of a simulation as text for the terminal.

use super::events::{DescribedEvent, methods};
use super::job::{Job, Start};
use super::outcome::{Ending, Outcome};
use super::summary::Summary;
use crate::gearing_load::write_gearings;
use crate::names::{heading_of, width};
use std::fmt::{self, Write};
use stiction_draw::numbers::{number, order, percent};

/// Largest number of degrees of freedom, of friction interfaces and of non-uniqueness events that
/// the text lists.
const LISTED: usize = 6;
/// Relative error of an integration step near a singular configuration above which summary and
/// report contain a caution.
pub(super) const COARSE: f64 = 1e-8;

/// Writes the summary as text.
///
/// # Errors
/// Fails if the receiver of the text fails.
pub fn write_summary(
    out: &mut impl Write,
    job: &Job<'_>,
    summary: &Summary,
    outcome: &Outcome,
) -> fmt::Result {
    writeln!(out, "{}", heading_of(job.model))?;
    let names = &summary.layout.names;
    let friction = match (job.friction, names.interfaces.is_empty()) {
        (false, _) => "off",
        (true, true) => "not declared",
        (true, false) => "on",
    };
    write!(out, "from t = {} s to {} s, ", number(job.from), number(summary.last.time))?;
    let begins = matches!(job.start, Start::Moving | Start::AtRest);
    if job.motion.is_some() && (begins || job.follows()) {
        write!(out, "motion {}, ", job.motion_name)?;
    }
    writeln!(out, "load {}, friction {friction}", job.load_name)?;
    writeln!(out, "drives {}; controller {}", job.drives_name, job.control_name)?;
    for (actuators, what) in
        [(&job.prescribed, "prescribed by the motion"), (&job.locked, "locked")]
    {
        let dof = |actuator: &usize| summary.layout.dof_of_actuator[*actuator];
        let name = |actuator: &usize| summary.layout.dofs[dof(actuator)].name.as_str();
        let listed: Vec<&str> = actuators.iter().map(name).collect();
        if !listed.is_empty() {
            writeln!(out, "{what}: {}", listed.join(", "))?;
        }
    }
    if let Ending::Stopped(condition) = &outcome.ending {
        writeln!(out, "ended at t = {} s: {condition}", number(outcome.last))?;
    }
    if outcome.rates_changed {
        writeln!(
            out,
            "CAUTION: the initial rates differ from the requested ones, which locked or \
             prescribed joints do not allow"
        )?;
    }
    if let Some(interpolation) = job.motion.and_then(|motion| motion.interpolation.as_ref()) {
        writeln!(out, "motion: {interpolation}")?;
    }
    if let Some(lowered) = job.control.and_then(|control| outcome.tuning.note(control.period)) {
        writeln!(out, "note: {lowered}")?;
    }
    for note in &outcome.assembly_notes {
        writeln!(out, "note: {note}")?;
    }
    writeln!(out)?;
    write_drives(out, summary)?;
    write_motors(out, summary)?;
    if !summary.gearings.is_empty() {
        write_gearings(out, &summary.layout.names.gearings, &summary.gearings)?;
        writeln!(out)?;
    }
    write_friction(out, summary, outcome)?;
    write_energy(out, summary)?;
    if let Some(part) = summary.energy_lost(&job.settings, &outcome.events) {
        writeln!(
            out,
            "CAUTION: the energy balance does not close: relative error {}; do not trust these results",
            number(part)
        )?;
    }
    write_method(out, summary, outcome)?;
    write_verdicts(out, job, summary, outcome)?;
    summary
        .cautions(job, outcome)
        .iter()
        .try_for_each(|caution| writeln!(out, "CAUTION: {caution}"))
}

fn write_motors(out: &mut impl Write, summary: &Summary) -> fmt::Result {
    let trains = || summary.layout.motors.trains();
    if summary.motors.is_empty() {
        return Ok(());
    }
    let wide = width(trains().map(|train| train.name.as_str()), 13);
    writeln!(
        out,
        "{:wide$}  {:>11} {:>11}  {:>13}  {:>13}  {:>12} {:>12}",
        "motor", "peak N m", "rms N m", "peak rad/s", "peak W", "work J", "turns"
    )?;
    for (train, load) in trains().zip(&summary.motors) {
        writeln!(
            out,
            "{:wide$}  {:>11} {:>11}  {:>13}  {:>13}  {:>12} {:>12}",
            train.name,
            number(load.torque.peak),
            number(load.rms()),
            number(load.speed.peak),
            number(load.power.peak),
            number(load.work.value),
            percent(Some(load.duty())),
        )?;
    }
    writeln!(out)
}

fn write_drives(out: &mut impl Write, summary: &Summary) -> fmt::Result {
    let layout = &summary.layout;
    if layout.names.drives.is_empty() {
        return write_dofs(out, summary);
    }
    let names = &layout.names.drives;
    let wide = width(names.iter().map(|(name, _)| name.as_str()), 14);
    writeln!(out, "{:wide$}  {:>23}  {:>15}  {:>17}", "", "effort", "position", "rate")?;
    writeln!(
        out,
        "{:wide$}  {:>11} {:>11}  {:>15}  {:>17}",
        "actuator", "peak", "rms", "at the end", "at the end"
    )?;
    for (k, (name, unit)) in names.iter().enumerate() {
        let dof = layout.dof_of_actuator[k];
        let motion = layout.motion_in(&summary.last.forward, dof);
        let [place, speed, _] = layout.dofs[dof].units();
        let size = &summary.drives[k];
        writeln!(
            out,
            "{name:wide$}  {:>11} {:>11}  {:>15}  {:>17}  {unit}",
            number(size.peak),
            number(size.rms()),
            format!("{} {place}", settled(motion[0])),
            format!("{} {speed}", settled(motion[1])),
        )?;
    }
    writeln!(out)?;
    write_errors(out, summary, wide)
}

/// Writes the tracking errors of the actuators that follow the motion.
fn write_errors(out: &mut impl Write, summary: &Summary, wide: usize) -> fmt::Result {
    let layout = &summary.layout;
    if !layout.reference.contains(&true) {
        return Ok(());
    }
    writeln!(out, "{:wide$}  {:>11} {:>11}", "tracking error", "peak", "rms")?;
    let names = layout.names.drives.iter().zip(&layout.reference).zip(&summary.errors);
    for (k, (((name, _), _), error)) in names.enumerate().filter(|(_, ((_, follows), _))| **follows)
    {
        let translates = layout.dofs[layout.dof_of_actuator[k]].translates;
        let unit = if translates { "mm" } else { "mrad" };
        let [peak, rms] = [error.peak, error.rms()].map(|x| number(1e3 * x));
        writeln!(out, "{name:wide$}  {peak:>11} {rms:>11}  {unit}")?;
    }
    writeln!(out)
}

/// Formats a position or a rate in SI units. Values that are rounding errors compared with 1 m or 1
/// rad become zero.
fn settled(x: f64) -> String {
    if x.abs() < 1e-14 { "0".to_owned() } else { number(x) }
}

fn write_dofs(out: &mut impl Write, summary: &Summary) -> fmt::Result {
    let layout = &summary.layout;
    let wide = width(layout.dofs.iter().map(|f| f.name.as_str()), 13);
    writeln!(out, "{:wide$}  {:>13}  {:>13}", "at the end", "position", "rate")?;
    for (k, dof) in layout.dofs.iter().enumerate().take(LISTED) {
        let motion = layout.motion_in(&summary.last.forward, k);
        let [place, speed, _] = dof.units();
        writeln!(
            out,
            "{:wide$}  {:>13}  {:>13}",
            dof.name,
            format!("{} {place}", settled(motion[0])),
            format!("{} {speed}", settled(motion[1])),
        )?;
    }
    writeln!(out)
}

fn write_friction(out: &mut impl Write, summary: &Summary, outcome: &Outcome) -> fmt::Result {
    let names = &summary.layout.names.interfaces;
    if names.is_empty() {
        return Ok(());
    }
    let account = summary.account();
    let sticking = summary.sticking(&outcome.events);
    let total: f64 = account.interfaces.iter().sum();
    let mut order: Vec<usize> = (0..names.len()).collect();
    let rounding = summary.rounding();
    let settle = |x: f64| if x.abs() < rounding { 0.0 } else { x };
    let dissipated = |k: usize| settle(account.interfaces.get(k).copied().unwrap_or(0.0));
    let total = settle(total);
    order.sort_by(|&a, &b| dissipated(b).total_cmp(&dissipated(a)));
    let listed = &order[..order.len().min(LISTED)];
    let wide = width(listed.iter().map(|&k| names[k].0.as_str()), 13);
    writeln!(
        out,
        "{:wide$}  {:>13} {:>9}  {:>11}  {:>7}  {:>14}",
        "friction", "dissipated", "part", "sticks", "stops", "greatest load"
    )?;
    for &k in listed {
        let part = (total > 0.0).then(|| dissipated(k) / total);
        let Some(sticking) = sticking.get(k) else { continue };
        writeln!(
            out,
            "{:wide$}  {:>11} J {:>9}  {:>9} s  {:>7}  {:>12} {}",
            names[k].0,
            number(dissipated(k)),
            percent(part),
            number(sticking.time),
            sticking.stops,
            number(summary.loads[k].peak),
            summary.layout.names.friction_unit(k),
        )?;
    }
    let more = names.len() - listed.len();
    if more > 0 {
        let rest: f64 = order[listed.len()..].iter().map(|&k| dissipated(k)).sum();
        writeln!(
            out,
            "{more} more{:>w$} J",
            number(rest),
            w = wide + 13 - 5 - more.to_string().len()
        )?;
    }
    let at_rest = summary.last.friction.chunks_exact(6).filter(|row| row[5] == 1.0).count();
    match at_rest {
        0 => writeln!(out, "at the end all slide"),
        n if n == names.len() => writeln!(out, "at the end all stick"),
        n => writeln!(out, "at the end {n} of {} stick", names.len()),
    }?;
    writeln!(out)
}

fn write_energy(out: &mut impl Write, summary: &Summary) -> fmt::Result {
    let account = summary.account();
    let dissipated = account.dampers + account.interfaces.iter().sum::<f64>();
    let rounding = summary.rounding();
    let amount = |x: f64| number(if x.abs() < rounding { 0.0 } else { x });
    writeln!(
        out,
        "energy: work of actuators {} J, of loads {} J; change of kinetic energy {} J, of potential energy {} J; \
         dissipated {} J",
        amount(account.drives.iter().sum()),
        amount(account.loads),
        amount(account.kinetic.1 - account.kinetic.0),
        amount(account.potential.1 - account.potential.0),
        amount(dissipated),
    )?;
    if let Some((brought, lost)) = account.payloads {
        writeln!(
            out,
            "energy of payloads when they were picked up {} J; {} J lost in these impacts",
            amount(brought),
            amount(lost)
        )?;
    }
    write!(out, "loop closure error {} m; ", order(summary.closure.peak))?;
    match summary.energy_error_relative() {
        Some(relative) => writeln!(out, "relative energy error {}", order(relative)),
        None => writeln!(out, "no energy is exchanged"),
    }
}

/// Writes the integration schemes that the simulation used, with their durations.
fn write_method(out: &mut impl Write, summary: &Summary, outcome: &Outcome) -> fmt::Result {
    match methods(&outcome.events, summary.span()) {
        [_, 0.0] => writeln!(out, "method: event-driven"),
        [0.0, _] => writeln!(
            out,
            "method: time-stepping; reactions are averages over steps, uniqueness is not examined"
        ),
        [by_events, in_steps] => writeln!(
            out,
            "method: event-driven for {} s, time-stepping for {} s, where reactions are averages over steps and uniqueness is not examined",
            number(by_events),
            number(in_steps)
        ),
    }
}

fn times(count: usize) -> String {
    match count {
        0 => "never".to_owned(),
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        n => format!("{n} times"),
    }
}

fn write_verdicts(
    out: &mut impl Write,
    job: &Job<'_>,
    summary: &Summary,
    outcome: &Outcome,
) -> fmt::Result {
    let described = summary.described(&outcome.events);
    let count = |what: &str| described.iter().filter(|event| event.what == what).count();
    let (stops, slides, reversals) = (count("sticks"), count("slides"), count("reverses"));
    if stops + slides + reversals > 0 {
        writeln!(
            out,
            "friction interfaces: stick onset {}, slip onset {}, reversal without sticking {}",
            times(stops),
            times(slides),
            times(reversals),
        )?;
    }
    if let Some(event) = described.iter().find(|event| event.what == "shares-not-unique") {
        writeln!(
            out,
            "the distribution of static friction is not unique from t = {} s on: more friction \
             interfaces stick than necessary, so a rule determines the share of each; normal \
             loads and the next slip onset can depend on this rule",
            number(event.time)
        )?;
    }
    if outcome.open_drives > 0 {
        writeln!(
            out,
            "CAUTION: efforts are not unique: {} prescribed or locked than necessary; the efforts with the \
             least sum of squares are reported",
            match outcome.open_drives {
                1 => "one joint more is".to_owned(),
                n => format!("{n} joints more are"),
            }
        )?;
    }
    let singular = count("singular");
    if let Some(event) = described.iter().find(|event| event.what == "singular") {
        writeln!(
            out,
            "the motion passes singular positions {}, first at t = {} s: branches of motion meet there, and the motion \
             continues smoothly",
            times(singular),
            number(event.time)
        )?;
    }
    if outcome.coarsest > COARSE {
        writeln!(
            out,
            "CAUTION: near a singular position rounding leaves a relative error of {:.0e} in each step; the \
             motion after it is at least as uncertain",
            outcome.coarsest
        )?;
    }
    let jumps = count("jump");
    if let Some(DescribedEvent { time, at, .. }) =
        described.iter().find(|event| event.what == "jump")
    {
        writeln!(
            out,
            "CAUTION: no acceleration satisfies the friction laws (jamming) {}, first at t = {} \
             s, with the largest normal load in {at}; velocities jump there to values that \
             satisfy all laws, and the motion after a jump can depend on the steps: compare a run with \
             --tolerance {:.0e}",
            times(jumps),
            number(*time),
            0.1 * job.settings.relative
        )?;
    }
    let others = described.iter().filter(|event| event.what == "not-unique");
    for DescribedEvent { time, at, detail, .. } in others.take(LISTED) {
        writeln!(
            out,
            "CAUTION: from t = {} s on, other motions also satisfy all friction laws ({detail}; \
             the normal load of {at} differs most); the reported one is continued from zero \
             friction",
            number(*time)
        )?;
    }
    match &outcome.ending {
        Ending::Reached | Ending::Stopped(_) => Ok(()),
        Ending::Interrupted | Ending::Failed(_) => {
            writeln!(out, "CAUTION: the simulation ended before t = {} s", number(job.until))
        }
    }
}
