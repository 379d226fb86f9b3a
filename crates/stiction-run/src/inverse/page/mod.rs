//! Report of a run of inverse dynamics as a self-contained HTML page with a moving robot.

mod ghost;
mod tables;
pub(super) mod verdicts;

use super::animation::Animation;
use super::summary::Summary;
use super::verdict::Verdict;
use crate::job::{Job, friction_word};
use crate::report::html::{self, card, section};
use crate::report::{findings, footer, header, reactions, repeat};
use stiction_core::dynamics::FrictionMode;
use stiction_draw::figure::Figure;
use stiction_draw::numbers::number;

/// Returns the report of a run as HTML: headline figures, the moving robot, plots, peaks, verdicts,
/// and the options to repeat the run. `command` is the command line that produced the results, if
/// any.
pub fn draw_report(
    job: &Job<'_>,
    (summary, verdict): (&Summary, &Verdict),
    figures: &[(&'static str, Figure)],
    animation: &Animation,
    command: Option<&str>,
) -> String {
    let plot = |wanted: &[&str]| -> String {
        let chosen = figures.iter().filter(|(name, _)| wanted.contains(name));
        chosen.map(|(_, figure)| html::curves(figure)).collect()
    };
    let length = job.model.mechanism.characteristic_length();
    let efforts = tables::efforts(job, summary) + &plot(&["drives"]) + &tables::rest(summary);
    let motors = tables::motors(summary) + &plot(&["motors"]);
    let friction = tables::friction(job, summary, verdict) + &plot(&["friction", "contributions"]);
    let along = plot(&["path", "singularity"]);
    let of = |title: &str, inner: String| match inner.is_empty() {
        true => inner,
        false => section(title, &inner),
    };
    let ghost = animation.nearest.as_ref().and_then(|nearest| {
        ghost::least_constrained(&job.model.mechanism, &verdict.idle_axes, nearest)
    });
    let inner = [
        header(job.model, &about(job, summary, verdict)),
        cards(job, summary, verdict),
        html::warnings(&summary.cautions(job)),
        section("The robot", &animation.shared.figure(caption(job), ghost)),
        of("Actuator efforts", efforts),
        of("Motors", motors),
        of("Friction", friction),
        reactions(&summary.names.joints, &summary.reactions, length),
        of("Along the motion", along),
        section("Power", &plot(&["power"])),
        findings(&verdicts::of(job, summary, verdict)),
        repeat(command, &summary.json(job, verdict)["options"]),
        footer(job.model),
    ];
    html::page_with_robot(&format!("{}: inverse dynamics", job.model.name), &inner.concat())
}

fn about(job: &Job<'_>, summary: &Summary, verdict: &Verdict) -> String {
    let count = verdict.samples;
    let plural = if count == 1 { "" } else { "s" };
    let title = match job.motion.title.as_str() {
        "" => String::new(),
        title => format!(" ({title})"),
    };
    let friction = match job.friction != FrictionMode::Off && summary.names.interfaces.is_empty() {
        true => "not declared",
        false => friction_word(job.friction),
    };
    format!(
        "Inverse dynamics along the motion {}{title}, {} s, {count} sample{plural}; load {}; friction {friction}.",
        job.motion_name,
        number(job.motion.duration),
        job.load_name,
    )
}

fn caption<'a>(job: &'a Job<'_>) -> &'a str {
    match job.motion.title.as_str() {
        "" => &job.motion_name,
        title => title,
    }
}

/// Returns cards with the headline figures as HTML.
fn cards(job: &Job<'_>, summary: &Summary, verdict: &Verdict) -> String {
    let mut all = Vec::new();
    for unit in ["N", "N m"] {
        let drives = summary.names.drives.iter().zip(&summary.drives);
        let of_unit = drives.filter(|((_, own), _)| *own == unit);
        let largest = of_unit.max_by(|a, b| a.1.with.peak.abs().total_cmp(&b.1.with.peak.abs()));
        if let Some(((name, _), comparison)) = largest {
            let what = format!("largest effort: {name} at {} s", number(comparison.with.peak_time));
            all.push(card(&format!("{} {unit}", number(comparison.with.peak.abs())), &what, false));
        }
    }
    if summary.has_friction(job) && verdict.samples > 1 {
        let total = summary.work.dissipated.value;
        let driven = summary.work.drives.value;
        let what = match driven > 0.0 && total <= driven {
            true => format!(
                "dissipated by friction, {:.0} % of the actuators' work",
                100.0 * total / driven
            ),
            false => "dissipated by friction".to_owned(),
        };
        all.push(card(&format!("{} J", number(total)), &what, false));
    }
    let forces = summary.names.joints.iter().zip(&summary.reactions.0);
    let largest = forces.max_by(|a, b| a.1.0.peak.total_cmp(&b.1.0.peak));
    if let Some((name, (force, _))) = largest {
        let what = format!("largest joint reaction: {name} at {} s", number(force.peak_time));
        all.push(card(&format!("{} N", number(force.peak)), &what, false));
    }
    if summary.actuation.value.is_finite() {
        let is_bad = verdict.singular.is_some() || !verdict.passed_singularities.is_empty();
        let what =
            format!("least singularity index, actuation, at {} s", number(summary.actuation.time));
        all.push(card(&number(summary.actuation.value), &what, is_bad));
    }
    if !summary.drives.is_empty() {
        let unique = summary.drives_are_unique(job.friction);
        let several = verdict.other_solutions.is_some();
        let word = if unique && !several { "unique" } else { "not unique" };
        all.push(card(word, "actuator efforts", !unique || several));
    }
    html::cards(&all)
}
