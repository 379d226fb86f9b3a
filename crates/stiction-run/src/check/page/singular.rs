//! Section of the report on the closest approaches of the motion to singular poses.

use crate::Job;
use crate::check::{Findings, Kind, Nearness, words};
use crate::report::html::{Column, note, paragraph, section, table};
use stiction_draw::numbers::number;

/// Largest number of passages through singular poses that the page lists for each kind of
/// singularity.
const LISTED: usize = 24;

pub(super) fn singularities(job: &Job<'_>, findings: &Findings) -> String {
    let rows: Vec<Vec<String>> = findings
        .singularities()
        .map(|(kind, nearness)| row(kind, nearness, findings.samples))
        .collect();
    let head = [
        ("kind", Column::Text),
        ("least distance", Column::Number),
        ("at t [s]", Column::Number),
        ("singular samples", Column::Number),
        ("least constrained", Column::Prose),
        ("meaning", Column::Text),
    ];
    let mut inner = table(&head, &rows);
    for (kind, nearness) in findings.singularities() {
        for (time, weakness) in nearness.crossings.iter().take(LISTED) {
            let gained = words::gained(kind, weakness);
            inner +=
                &paragraph(&format!("Singular ({}) at t = {time:.7} s: {gained}.", kind.word()));
        }
        if nearness.crossings.len() > LISTED {
            inner +=
                &paragraph(&format!("And at {} more times.", nearness.crossings.len() - LISTED));
        }
        if let (true, true, Some(weakness)) =
            (nearness.singular_samples > 0, nearness.crossings.is_empty(), &nearness.weakness)
        {
            let gained = words::gained(kind, weakness);
            inner += &paragraph(&format!("Singular ({}): {gained}.", kind.word()));
        }
    }
    for sentence in words::in_general(findings).iter().chain(&words::actuation_of_motion(findings))
    {
        inner += &paragraph(&capitalised(sentence));
    }
    inner += &note(&format!(
        "A singularity index is the smallest singular value of the dimensionless equilibrium \
         matrix of all bodies, with lengths in units of {:.1} mm. Zero is singular; there is no \
         upper limit. Compare it along a motion, or between variants of one robot.",
        job.model.mechanism.characteristic_length() * 1e3
    ));
    section("Nearest singular positions", &inner)
}

fn row(kind: Kind, nearness: &Nearness, samples: usize) -> Vec<String> {
    let meaning = match kind {
        Kind::Actuation => "something can move although all actuators are locked",
        Kind::Constraint => {
            "the constraints instantaneously permit more motions than the finite ones"
        }
        Kind::Leg => "bodies of a leg can move although the bodies at its ends are fixed",
    };
    let Nearness { least, time, singular_samples, weakness, crossings, .. } = nearness;
    let is_singular = *singular_samples > 0 || !crossings.is_empty();
    let distance = if is_singular { "0".to_owned() } else { number(*least) };
    let singular = match (*singular_samples, crossings.len()) {
        (0, 0) => "none".to_owned(),
        (0, n) => format!("none, {n} between"),
        (n, _) => format!("{n} of {samples}"),
    };
    let when = if *singular_samples == samples { "always".to_owned() } else { number(*time) };
    let held = weakness.as_ref().map_or(String::new(), |w| format!("{}, {}", w.body, w.motion));
    vec![kind.word().into(), distance, when, singular, held, meaning.into()]
}

/// Returns a sentence with a capital letter at the beginning and a full stop at the end.
pub(super) fn capitalised(sentence: &str) -> String {
    let mut letters = sentence.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}
