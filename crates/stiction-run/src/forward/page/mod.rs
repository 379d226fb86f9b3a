//! Report of a simulation as a self-contained HTML page that animates the robot.

mod tables;
pub(super) mod verdicts;

use super::animation::Animation;
use super::job::Job;
use super::outcome::{Ending, Outcome};
use super::summary::Summary;
use crate::report::html::{self, card, section};
use crate::report::{findings, footer, header, reactions, repeat};
use stiction_core::forward::EventKind;
use stiction_draw::figure::Figure;
use stiction_draw::numbers::number;

/// Returns the report of a simulation as HTML: headline figures, an animation of the robot, plots,
/// peaks, events, verdicts, and the options to repeat the simulation. `command` is the command line
/// that produced the results, if any.
pub fn draw_report(
    job: &Job<'_>,
    (summary, outcome): (&Summary, &Outcome),
    figures: &[(&'static str, Figure)],
    animation: &Animation,
    command: Option<&str>,
) -> String {
    let plot = |wanted: &[&str]| -> String {
        let chosen = figures.iter().filter(|(name, _)| wanted.contains(name));
        chosen.map(|(_, figure)| html::curves(figure)).collect()
    };
    let of = |title: &str, inner: String| match inner.is_empty() {
        true => inner,
        false => section(title, &inner),
    };
    let length = job.model.mechanism.characteristic_length();
    let inner = [
        header(job.model, &about(job, summary)),
        cards(summary, outcome),
        html::warnings(&summary.cautions(job, outcome)),
        section("The robot", &animation.shared.figure("", None)),
        of("Motion", tables::motion(summary) + &plot(&["motion", "error", "path", "space-error"])),
        of("Actuator efforts", tables::efforts(summary) + &plot(&["drives"])),
        of("Motors", tables::motors(summary)),
        of("Friction", tables::friction(summary, outcome) + &plot(&["friction"])),
        of("Events", tables::events(summary, outcome)),
        reactions(&summary.layout.names.joints, &summary.reactions, length),
        section("Energy", &(tables::energy(summary) + &plot(&["energy"]))),
        findings(&verdicts::of(job, summary, outcome)),
        repeat(command, &summary.json(job, outcome)["options"]),
        footer(job.model),
    ];
    html::page_with_robot(&format!("{}: forward dynamics", job.model.name), &inner.concat())
}

fn about(job: &Job<'_>, summary: &Summary) -> String {
    let follows = match job.motion {
        Some(_) if job.follows() => format!("motion {}, ", job.motion_name),
        _ => String::new(),
    };
    format!(
        "Forward dynamics from t = {} s to {} s: {follows}drives {}, controller {}, load {}, friction {}; {} samples.",
        number(job.from),
        number(summary.last.time),
        job.drives_name,
        job.control_name,
        job.load_name,
        if job.friction { "on" } else { "off" },
        summary.samples,
    )
}

/// Returns cards with the headline figures as HTML.
fn cards(summary: &Summary, outcome: &Outcome) -> String {
    let names = &summary.layout.names;
    let mut all = Vec::new();
    let ended = match &outcome.ending {
        Ending::Reached => "the end time was reached",
        Ending::Stopped(_) => "a stop condition ended the run",
        Ending::Interrupted => "the run was interrupted",
        Ending::Failed(_) => "the run failed",
    };
    let is_bad = matches!(outcome.ending, Ending::Interrupted | Ending::Failed(_));
    all.push(card(&format!("{} s", number(summary.last.time)), ended, is_bad));
    for unit in ["N", "N m"] {
        let of_unit = names.drives.iter().zip(&summary.drives).filter(|((_, own), _)| *own == unit);
        let largest = of_unit.max_by(|a, b| a.1.peak.abs().total_cmp(&b.1.peak.abs()));
        if let Some(((name, _), size)) = largest {
            let what = format!("largest effort: {name} at {} s", number(size.peak_time));
            all.push(card(&format!("{} {unit}", number(size.peak.abs())), &what, false));
        }
    }
    let account = summary.account();
    let rounding = summary.rounding();
    let dissipated = account.dampers + account.interfaces.iter().sum::<f64>();
    let dissipated = if dissipated.abs() < rounding { 0.0 } else { dissipated };
    all.push(card(
        &format!("{} J", number(dissipated)),
        "dissipated by friction and dampers",
        false,
    ));
    let forces = names.joints.iter().zip(&summary.reactions.0);
    let largest = forces.max_by(|a, b| a.1.0.peak.total_cmp(&b.1.0.peak));
    if let Some((name, (force, _))) = largest {
        let what = format!("largest joint reaction: {name} at {} s", number(force.peak_time));
        all.push(card(&format!("{} N", number(force.peak)), &what, false));
    }
    let sticks =
        |event: &&stiction_core::forward::Event| matches!(event.kind, EventKind::Sticks { .. });
    let onsets = outcome.events.iter().filter(sticks).count();
    if !names.interfaces.is_empty() {
        all.push(card(&onsets.to_string(), "stick onsets of friction interfaces", false));
    }
    html::cards(&all)
}
