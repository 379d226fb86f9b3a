//! Section of the report on degrees of freedom: three counts of degrees of freedom, the singular
//! values that decide the counts, and the motions of each body.

use crate::Job;
use crate::check::{Findings, words};
use crate::report::html::{Column, note, paragraph, section, table};

pub(super) fn mobility(job: &Job<'_>, findings: &Findings) -> String {
    let mobility = &findings.mobility;
    let row = |name: &str, count: String, meaning: &str| vec![name.into(), count, meaning.into()];
    let counts = [
        row(
            "Grübler's count",
            mobility.gruebler.to_string(),
            "six per body, less the constraints of the joints; valid if all constraints are \
             independent",
        ),
        row(
            "instantaneous",
            mobility.instantaneous.to_string(),
            "from the rank of the loop equations at this position, to first order",
        ),
        row(
            "finite",
            format!("{}{}", mobility.finite, words::undecided(findings)),
            "traced from this position; the loops are closed after each step",
        ),
    ];
    let head = [("count", Column::Text), ("dofs", Column::Number), ("method", Column::Text)];
    let mut inner = table(&head, &counts);
    inner += &gap(findings);
    if mobility.finite.traced < mobility.instantaneous {
        inner += &note(
            "Motions that are possible to first order only are blocked by the second derivatives \
             of the loop equations. No constraint force resists them to first order, so clearance \
             and compliance make them large.",
        );
    }
    if !findings.idle_spins.is_empty() {
        inner += &paragraph(&format!(
            "Local degrees of freedom: {}. {} can spin about {} without moving anything else.",
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

/// Returns a note on the two singular values that decide the rank: the smallest one that counts as
/// nonzero and the largest one that counts as zero.
fn gap(findings: &Findings) -> String {
    let (Some(kept), dropped) = findings.mobility.gap else {
        return note(
            "There are no loops: every degree of freedom of a joint is one of the \
                     mechanism.",
        );
    };
    let dropped = match dropped {
        Some(dropped) => {
            format!("the largest that counts as zero is {}", words::power_of_ten(dropped))
        }
        None => "all count as nonzero".to_owned(),
    };
    note(&format!(
        "The instantaneous mobility follows from a gap between the singular values of the loop \
         equations, relative to the largest: the smallest value that counts as nonzero is \
         {kept:.1e}; {dropped}. The wider the gap, the more certain the mobility."
    ))
}

fn bodies(findings: &Findings) -> String {
    // The bodies with the most independent motions come first, because the tool is usually on one
    // of them.
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
    let mut head = vec![("body", Column::Text), ("independent motions", Column::Prose)];
    head.extend(blocked.then_some(("to first order only", Column::Prose)));
    table(&head, &rows)
}
