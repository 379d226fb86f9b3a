//! Results for a mechanism at rest, as text for the terminal.

use super::Findings;
use crate::names::{Names, heading_of, listed, width};
use crate::{Job, power_off};
use std::fmt::{self, Write};
use stiction_core::dynamics::{Bounds, Holding, Verdict};
use stiction_core::mechanism::DriveTrain;
use stiction_draw::numbers::number;

/// Largest number of friction interfaces that the text lists.
const LISTED: usize = 6;
/// Relative difference below which the two bounds of a factor are printed as one number.
const SAME: f64 = 1e-6;
/// Largest factor on the static friction coefficients that is printed. Larger factors are dominated
/// by rounding errors.
const BEYOND: f64 = 1e6;

/// Writes the static-friction results as plain text.
///
/// # Errors
/// Returns an error if writing to `out` fails.
pub fn write_report(out: &mut impl Write, job: &Job<'_>, found: &Findings) -> fmt::Result {
    let names = Names::new(&job.model.mechanism);
    writeln!(out, "{}", heading_of(job.model))?;
    let time = number(found.time);
    writeln!(
        out,
        "at rest at t = {time} s of motion {}, load {}\n",
        job.motion_name, job.load_name
    )?;
    if names.drives.is_empty() {
        return writeln!(out, "no joint is actuated: there are no efforts");
    }
    write_drives(out, &names, found)?;
    write_certainty(out, &names, found)?;
    let trains = job.model.mechanism.drive_trains();
    if !trains.is_empty() {
        write!(out, "with motors and gears disconnected from the joints: ")?;
    }
    write_unpowered(out, &found.rest.unpowered)?;
    write_motors(out, trains, found)
}

/// Writes the motor torques that hold the pose, and the cause that holds each motor at rest with
/// power off.
fn write_motors(out: &mut impl Write, trains: &[DriveTrain], found: &Findings) -> fmt::Result {
    if trains.is_empty() {
        return Ok(());
    }
    let wide = width(trains.iter().map(|train| train.name.as_str()), 13);
    writeln!(out, "\n{:wide$}  {:>11}  {:>23}", "", "", "torques that hold")?;
    writeln!(out, "{:wide$}  {:>11}  {:>11} {:>11}", "motor", "no friction", "from", "to")?;
    for (train, (motor, _)) in trains.iter().zip(&found.motors) {
        let (low, high) = motor.torque_bounds;
        let ideal = number(motor.torque);
        writeln!(
            out,
            "{:wide$}  {ideal:>11}  {:>11} {:>11}  N m",
            train.name,
            number(low),
            number(high),
        )?;
    }
    writeln!(out, "with power off:")?;
    let power_off: Vec<_> = found.motors.iter().map(|(_, power_off)| *power_off).collect();
    power_off::write(out, trains, &power_off)
}

/// Returns text that states how certain the effort intervals are, with one line for each statement.
pub(super) fn certainty_text(names: &Names, found: &Findings) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_certainty(&mut text, names, found);
    text
}

/// Returns text that states whether the mechanism keeps its pose without actuator efforts.
pub(super) fn unpowered_text(holding: &Holding) -> String {
    let mut text = String::new();
    let _ = write_unpowered(&mut text, holding);
    text.trim_end().to_owned()
}

fn write_drives(out: &mut impl Write, names: &Names, found: &Findings) -> fmt::Result {
    let wide = names.drives.iter().map(|(name, _)| name.len()).fold(13, usize::max);
    writeln!(
        out,
        "{:wide$}  {:>11}  {:>23}  {:>23}  unpowered,",
        "", "", "static friction allows", "more to move",
    )?;
    writeln!(
        out,
        "{:wide$}  {:>11}  {:>11} {:>11}  {:>11} {:>11}  others held",
        "effort", "no friction", "from", "to", "backward", "forward",
    )?;
    for (k, (name, unit)) in names.drives.iter().enumerate() {
        let without = found.forces.efforts_frictionless[k];
        let (low, high) = found.forces.effort_bounds[k];
        let more = |effort: f64| match effort.is_finite() {
            true => number((effort - without).abs()),
            false => "locked".to_owned(),
        };
        let (backward, forward) = match &found.rest.breakaway[k] {
            Some(breakaway) => (more(breakaway.backward.1), more(breakaway.forward.1)),
            None => ("-".to_owned(), "-".to_owned()),
        };
        writeln!(
            out,
            "{name:wide$}  {:>11}  {:>11} {:>11}  {backward:>11} {forward:>11}  {:11}  {unit}",
            number(without),
            number(low),
            number(high),
            verdict_word(found.rest.alone[k].verdict),
        )?;
    }
    writeln!(out)
}

fn write_certainty(out: &mut impl Write, names: &Names, found: &Findings) -> fmt::Result {
    let forces = &found.forces;
    match forces.bounds {
        Bounds::Exact => writeln!(out, "the intervals are exact")?,
        Bounds::Certified => {
            let each = forces.effort_bounds.iter().zip(&forces.effort_outer_bounds);
            let beyond = each.map(|(inner, outer)| (inner.0 - outer.0).max(outer.1 - inner.1));
            let beyond = beyond.zip(&names.drives).max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((beyond, (name, unit))) = beyond {
                writeln!(
                    out,
                    "the intervals are inner bounds; guaranteed bounds lie at most {} {unit} beyond \
                     ({name})",
                    number(beyond),
                )?;
            }
        }
        Bounds::Attained | Bounds::Unknown => writeln!(
            out,
            "the intervals are inner bounds; friction and reactions are coupled too strongly for \
             guaranteed bounds"
        )?,
    }
    if found.redundant_actuators {
        writeln!(
            out,
            "actuators are redundant: the efforts shown have the least sum of squares, and no \
             actuator can move alone"
        )?;
    }
    if !found.undetermined_loads.is_empty() {
        let interfaces = found.undetermined_loads.iter().map(|&k| &names.interfaces[k].0);
        writeln!(
            out,
            "friction at {} depends on statically indeterminate reactions: the results are those for \
             the reactions that `stiction inverse` selects",
            listed(interfaces, LISTED),
        )?;
    }
    Ok(())
}

fn write_unpowered(out: &mut impl Write, holding: &Holding) -> fmt::Result {
    let (not_enough, enough) = holding.needed;
    match holding.verdict {
        Verdict::Holds if enough == 0.0 => {
            writeln!(out, "in equilibrium without actuators and friction")
        }
        Verdict::Holds => {
            let factor = 1.0 / enough;
            writeln!(
                out,
                "self-locking under this load: it holds without actuator efforts, even with all \
                 static coefficients divided by {}{}",
                number(factor),
                if enough - not_enough <= SAME * enough {
                    String::new()
                } else if not_enough > 0.0 {
                    format!(
                        " (divided by more than {}, they certainly would not hold it)",
                        number(1.0 / not_enough)
                    )
                } else {
                    " (perhaps by more)".to_owned()
                },
            )
        }
        Verdict::Slips if enough.is_infinite() => writeln!(
            out,
            "not self-locking under this load: without actuator efforts it slips{}",
            if not_enough.is_infinite() {
                ", whatever the coefficients".to_owned()
            } else {
                format!(
                    "; static coefficients up to {} times as large would not hold it",
                    number(not_enough.min(BEYOND))
                )
            },
        ),
        Verdict::Slips => writeln!(
            out,
            "not self-locking under this load: without actuator efforts it slips; static \
             coefficients {} times as large would hold it{}",
            number(enough),
            if enough - not_enough <= SAME * enough {
                String::new()
            } else {
                format!(" (less than {} times as large certainly would not)", number(not_enough))
            },
        ),
        Verdict::Undecided => writeln!(
            out,
            "undecided whether the mechanism holds without actuator efforts: with less than \
             {} times the static coefficients it certainly slips{}",
            number(not_enough),
            if enough.is_finite() {
                format!(", and with {} times or more it holds", number(enough))
            } else {
                String::new()
            },
        ),
    }
}

pub(super) fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "holds",
        Verdict::Slips => "slips",
        Verdict::Undecided => "not decided",
    }
}
