//! Degrees of freedom: three counts, the singular values that decide them, and the motions of each
//! body.

use super::html::{Column, note, paragraph, section, table};
use crate::Job;
use crate::check::{Findings, words};

pub(super) fn mobility(job: &Job<'_>, findings: &Findings) -> String {
    let mobility = &findings.mobility;
    let row = |name: &str, count: String, meaning: &str| vec![name.into(), count, meaning.into()];
    let counts = [
        row(
            "Grübler's count",
            mobility.gruebler.to_string(),
            "six for each body less what the joints hold: right if all constraints are independent",
        ),
        row(
            "instantaneous",
            mobility.instantaneous.to_string(),
            "left by the rank of the loop equations at this position: to first order",
        ),
        row(
            "finite",
            format!("{}{}", mobility.finite, words::undecided(findings)),
            "traced from this position, the loops closed again after each step",
        ),
    ];
    let head = [
        ("count", Column::Text),
        ("freedoms", Column::Number),
        ("how it is counted", Column::Text),
    ];
    let mut inner = table(&head, &counts);
    inner += &gap(findings);
    if mobility.finite.traced < mobility.instantaneous {
        inner += &note(
            "What is free to first order only is blocked by the second derivatives of the loops' \
             equations: no force of first order holds it, and clearance and compliance make it large.",
        );
    }
    if !findings.idle_spins.is_empty() {
        inner += &paragraph(&format!(
            "{} of them idle: {} free to spin about {}, which nothing else feels.",
            findings.idle_spins.len(),
            findings.idle_spins.join(", "),
            words::own_axes(findings.idle_spins.len()),
        ));
    }
    for sentence in words::play(job, findings) {
        inner += &paragraph(&format!("{sentence}."));
    }
    inner += &bodies(findings);
    section("Degrees of freedom", &inner)
}

/// The two singular values that decide the rank.
fn gap(findings: &Findings) -> String {
    let (Some(kept), dropped) = findings.mobility.gap else {
        return note("There are no loops: every freedom of a joint is one of the mechanism.");
    };
    let dropped = match dropped {
        Some(dropped) => format!("the largest that does not is {}", words::power_of_ten(dropped)),
        None => "none does not".to_owned(),
    };
    note(&format!(
        "The count to first order is decided by a gap among the singular values of the loops' \
         equations, in units of the largest: the smallest that counts is {kept:.1e}, {dropped}. The \
         wider the gap, the surer the count."
    ))
}

fn bodies(findings: &Findings) -> String {
    // Bodies with most joints come first, because the tool is usually on one of them.
    let mut bodies: Vec<_> = findings.mobility.bodies.iter().collect();
    bodies.sort_by_key(|body| std::cmp::Reverse(body.motions.len() + body.first_order_only.len()));
    let blocked = bodies.iter().any(|body| !body.first_order_only.is_empty());
    let rows: Vec<Vec<String>> = bodies
        .iter()
        .map(|body| {
            let motions = match body.motions.is_empty() {
                true => "does not move".to_owned(),
                false => body.motions.join("; "),
            };
            let mut row = vec![body.body.clone(), motions];
            row.extend(blocked.then(|| body.first_order_only.join("; ")));
            row
        })
        .collect();
    let mut head = vec![("body", Column::Text), ("can do, independently", Column::Text)];
    head.extend(blocked.then_some(("to first order only", Column::Text)));
    table(&head, &rows)
}
