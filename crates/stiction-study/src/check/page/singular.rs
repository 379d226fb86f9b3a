//! How near the motion comes to singular positions.

use super::html::{Column, note, paragraph, section, table};
use crate::check::{Findings, Nearness};
use crate::inverse::Job;
use crate::inverse::terminal::number;

/// Passages that are listed at most.
const LISTED: usize = 24;

pub(super) fn singularities(job: &Job<'_>, findings: &Findings) -> String {
    let mut rows = vec![
        row(
            "actuation",
            "something can move although all actuators stand still",
            &findings.actuation,
            findings.samples,
        ),
        row(
            "constraint",
            "the constraints leave more than the motions of finite size",
            &findings.constraint,
            findings.samples,
        ),
    ];
    rows.extend(findings.leg.as_ref().map(|leg| {
        let meaning = "a leg's bodies can move although the bodies where legs end stand still";
        row("leg", meaning, leg, findings.samples)
    }));
    let head = [
        ("kind", Column::Text),
        ("least distance", Column::Number),
        ("at t [s]", Column::Number),
        ("singular samples", Column::Number),
        ("what it is", Column::Text),
    ];
    let mut inner = table(&head, &rows);
    for (from, to) in findings.passed.iter().take(LISTED) {
        inner += &paragraph(&format!(
            "A singularity of actuation is passed between t = {} s and t = {} s.",
            number(*from),
            number(*to)
        ));
    }
    if findings.passed.len() > LISTED {
        inner += &paragraph(&format!("And {} more times.", findings.passed.len() - LISTED));
    }
    inner += &note(&format!(
        "A distance is the smallest singular value of the balance of all bodies, without units: \
         lengths count in units of {:.1} mm. Zero is singular; there is no upper limit. Compare it \
         along a motion, or between variants of one robot.",
        job.model.mechanism.characteristic_length() * 1e3
    ));
    section("Nearest singular positions", &inner)
}

fn row(kind: &str, meaning: &str, nearness: &Nearness, samples: usize) -> Vec<String> {
    let Nearness { least, time, singular_samples } = *nearness;
    let distance = if singular_samples > 0 { "0".to_owned() } else { number(least) };
    let singular = match singular_samples {
        0 => "none".to_owned(),
        n => format!("{n} of {samples}"),
    };
    let when = if singular_samples == samples { "always".to_owned() } else { number(time) };
    vec![kind.into(), distance, when, singular, meaning.into()]
}
