//! Report on a check as a self-contained HTML page with the moving mechanism.
//!
//! Each section of the page has its own function. The functions of `html` escape names and titles, which come from the
//! user's files.

mod mobility;
mod redundancy;
mod singular;
mod sizes;

use super::{Findings, words};
use crate::portrait::Portrait;
use crate::report::html::{self, card, note, section};
use crate::report::{footer, header, repeat};
use crate::{Error, Job};
use serde_json::{Value, json};
use stiction_draw::drawing::Surface;
use stiction_draw::numbers::number;

/// Result of [`draw_page`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    /// Complete HTML page. The page is well-formed XML if the script of its viewer is removed.
    pub html: String,
    /// SVG image of the mechanism on a white background.
    pub picture: String,
}

/// Writes the results of a check as an HTML page. `command` is the command line that produced them, if any.
///
/// # Errors
/// Returns an error if the mechanism cannot follow its motion, which the image requires.
pub fn draw_page(job: &Job<'_>, findings: &Findings, command: Option<&str>) -> Result<Page, Error> {
    let locked = job.locked_start()?;
    let portrait = match &locked {
        None => Portrait::of(job)?,
        Some((motion, _)) => Portrait::of(&Job { motion, ..job.clone() })?,
    };
    let inner = [
        heading(job, findings),
        cards(findings),
        html::warnings(findings.warnings.iter().chain(&findings.cautions)),
        picture(job, &portrait),
        mobility::mobility(job, findings),
        redundancy::redundancy(job, findings),
        singular::singularities(job, findings),
        sizes::masses(job, findings, &portrait.start),
        sizes::ranges(findings),
        repeat(command, &options(job, findings)),
        footer(job.model),
    ];
    let title = format!("{}: check", job.model.name);
    let html = html::page_with_robot(&title, &inner.concat());
    Ok(Page { html, picture: portrait.svg(Surface::Paper) })
}

fn heading(job: &Job<'_>, findings: &Findings) -> String {
    let plural = if findings.samples == 1 { "" } else { "s" };
    let about = match job.motion.title.as_str() {
        "" => String::new(),
        title => format!(": {title}"),
    };
    let about = format!(
        "Motion {}{about} ({} sample{plural}); mobility and redundancy at t = {} s. Loads and \
         friction play no part.",
        job.motion_name,
        findings.samples,
        number(findings.start),
    );
    let mut inner = header(job.model, &about);
    if let Some(sentence) = findings.assembly.sentence() {
        inner += &note(&singular::capitalised(&sentence));
    }
    inner
}

fn cards(findings: &Findings) -> String {
    let mobility = &findings.mobility;
    let is_all = mobility.finite.decided() == Some(mobility.instantaneous);
    let first_order = match is_all {
        true => "degrees of freedom".to_owned(),
        false => format!(
            "degrees of freedom{}; {} instantaneous",
            words::undecided(findings),
            mobility.instantaneous
        ),
    };
    let redundant = mobility.redundant_constraints;
    let constraints = if redundant == 1 { "redundant constraint" } else { "redundant constraints" };
    let open = findings.undetermined.len();
    let reactions = match open {
        0 => card("all", "reactions determined by statics", false),
        1 => card("1", "joint with reactions that statics does not determine", false),
        _ => {
            card(&open.to_string(), "joints with reactions that statics does not determine", false)
        }
    };
    let drives = if findings.drives_unique { "unique" } else { "not unique" };
    let singular = findings.singularities().map(|(_, n)| n.singular_samples).max().unwrap_or(0);
    let passages: usize = findings.singularities().map(|(_, n)| n.crossings.len()).sum();
    let positions = match (singular, passages) {
        (0, 0) => card("none", "of the positions singular", false),
        (0, 1) => card("1", "singular position is passed", true),
        (0, n) => card(&n.to_string(), "singular positions are passed", true),
        (n, _) => card(&format!("{n} of {}", findings.samples), "samples singular", true),
    };
    let inner = [
        card(&mobility.finite.to_string(), &first_order, !is_all),
        card(&redundant.to_string(), constraints, false),
        reactions,
        card(drives, "actuator efforts (without friction)", !findings.drives_unique),
        positions,
    ];
    html::cards(&inner)
}

fn picture(job: &Job<'_>, portrait: &Portrait) -> String {
    let caption = |text: &str| format!("<figcaption>{}</figcaption>", html::prose(text));
    let mut inner = portrait.moving(&job.motion.title).unwrap_or_else(|| {
        format!(
            "<figure class=\"picture\">{}{}</figure>\n",
            portrait.svg(Surface::Inline),
            caption("Lengths perpendicular to the line of sight are to scale.")
        )
    });
    let views: String = portrait
        .more_views()
        .iter()
        .map(|(name, svg)| format!("<figure>{svg}{}</figure>\n", caption(name)))
        .collect();
    if !views.is_empty() {
        inner += &format!("<div class=\"views\">\n{views}</div>\n");
    }
    section("The mechanism", &inner)
}

/// Options with which the check can be repeated.
fn options(job: &Job<'_>, findings: &Findings) -> Value {
    json!({
        "motion": job.motion_name,
        "start": findings.start,
        "duration": job.motion.duration,
        "samples": findings.samples,
    })
}
