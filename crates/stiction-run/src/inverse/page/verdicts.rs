//! Verdicts on a run, with their meaning and advice.

use crate::inverse::certainty::{MOST_MARGIN, Margin};
use crate::inverse::summary::{Summary, weighting_words};
use crate::inverse::terminal::{NEAR_SINGULAR, ROOT_OF_ROUNDING};
use crate::inverse::verdict::Verdict;
use crate::job::Job;
use crate::names::listed;
use crate::report::Finding;
use crate::undetermined::by_components;
use stiction_draw::numbers::{number, order};

/// Relative residual of the power balance above which the verdict is a warning. Rounding errors
/// cause about 1e-12.
const CLOSED: f64 = 1e-6;
/// Largest number of names that one sentence of a verdict lists.
const NAMED: usize = 6;

pub(in crate::inverse) fn of(job: &Job<'_>, summary: &Summary, verdict: &Verdict) -> Vec<Finding> {
    let mut all = Vec::new();
    singular(summary, verdict, &mut all);
    uniqueness(job, summary, verdict, &mut all);
    friction(job, summary, verdict, &mut all);
    if !verdict.idle_spins.is_empty() {
        all.push(Finding::good(
            format!(
                "Passive rotation of {} about its own axis",
                listed(&verdict.idle_spins, NAMED)
            ),
            "A rod between two ball joints can turn without moving anything else. The rate of this \
             rotation is set to zero; no action is needed.",
        ));
    }
    let residual = summary.power_residual_relative.peak.abs();
    let statement = format!(
        "Loops close to {} m, the power balance to {} of the power exchanged",
        order(summary.closure.peak),
        order(residual)
    );
    all.push(match residual < CLOSED {
        true => Finding::good(
            statement,
            "Each sample is checked by its own power balance, which the computation does not use: these results \
             satisfy the laws of mechanics up to rounding.",
        ),
        false => Finding::bad(
            statement,
            "The power balance of a sample should hold up to rounding. Near a singular position \
             rounding grows; avoid the position, or report the model as a bug.",
        ),
    });
    all
}

fn singular(summary: &Summary, verdict: &Verdict, all: &mut Vec<Finding>) {
    for (from, to) in verdict.passed_singularities.iter().take(NAMED) {
        all.push(Finding::bad(
            format!("A singular position is passed between t = {} s and t = {} s", number(*from), number(*to)),
            "Without friction no finite effort exists there, and the efforts nearby grow without bound. Choose \
             another motion, or another working mode.",
        ));
    }
    let index = summary.actuation.value;
    let at = number(summary.actuation.time);
    if let Some(singular) = &verdict.singular {
        all.push(Finding::bad(
            format!(
                "The position is singular at {} of {} samples, first at t = {} s",
                singular.samples,
                verdict.samples,
                number(singular.time)
            ),
            format!(
                "With all actuators locked, {} can move ({}), and {} could not be balanced. The present load \
                 happens to be balanced, so forces are finite but not unique. Choose another motion or other \
                 actuators.",
                singular.body, singular.motion, singular.load
            ),
        ));
    } else if index < ROOT_OF_ROUNDING {
        all.push(Finding::bad(
            format!("At t = {at} s the position is singular to rounding"),
            "Forces there consist of rounding errors. Avoid the position.",
        ));
    } else if index < NEAR_SINGULAR {
        all.push(Finding::bad(
            format!("Near a singular position at t = {at} s: singularity index {}", number(index)),
            "Frictionless efforts and the effects of model errors are inversely proportional to the index. Keep \
             the motion far enough from the singular position for the accuracy that you need.",
        ));
    } else if index.is_finite() {
        all.push(Finding::good(
            format!(
                "No singular position: least singularity index {} at t = {at} s",
                number(index)
            ),
            "The smallest singular value of the dimensionless equilibrium matrix of all bodies; \
             zero is singular. Compare it along a motion, or between variants of one robot.",
        ));
    }
}

fn uniqueness(job: &Job<'_>, summary: &Summary, verdict: &Verdict, all: &mut Vec<Finding>) {
    let undetermined = summary.undetermined();
    if undetermined.is_empty() {
        all.push(Finding::good(
            "Statics determines all reactions and efforts",
            "Reactions and efforts follow from the model alone; the stiffness and the tolerances \
             of the parts do not matter.",
        ));
        return;
    }
    let rule = weighting_words(job, verdict)
        .map_or(String::new(), |words| format!(" The reported values follow from {words}."));
    all.push(Finding::open(
        format!("Statics does not determine {}", by_components(&undetermined)),
        format!(
            "Constraints or actuators are redundant, so these depend on stiffness and tolerances. \
             Declare compliances before you size bearings from these values.{rule}"
        ),
    ));
    if summary.drives_are_unique(job.friction) {
        all.push(Finding::good(
            "The actuator efforts are unique nevertheless",
            "The undetermined reactions do no work, and no friction depends on them.",
        ));
        return;
    }
    let open: Vec<&str> = summary.frictions_that_are_not_unique().collect();
    let (why, advice) = if verdict.singular.is_some() {
        ("the position is singular".to_owned(), "Avoid the position.")
    } else if open.is_empty() {
        ("actuators are redundant".to_owned(), "Their efforts have the least sum of squares.")
    } else {
        (
            format!(
                "friction at {} depends on reactions that are not unique",
                listed(&open, NAMED)
            ),
            "Declare the compliances of these joints; they then determine the reactions.",
        )
    };
    all.push(Finding::bad(format!("The actuator efforts are not unique: {why}"), advice));
}

fn friction(job: &Job<'_>, summary: &Summary, verdict: &Verdict, all: &mut Vec<Finding>) {
    if !summary.has_friction(job) {
        return;
    }
    match verdict.coupling {
        Some(coupling) if coupling < 1.0 => {
            let more = match coupling > 1e-9 {
                true => format!(
                    ", even with up to {} times this friction",
                    number((100.0 / coupling * (1.0 + 1e-12)).floor() / 100.0)
                ),
                false => String::new(),
            };
            all.push(Finding::good(
                format!("The solution with friction is unique{more}"),
                "Friction depends on reactions, and reactions on friction. A coupling below 1 \
                 proves that no other solution exists.",
            ));
        }
        Some(coupling) => all.push(Finding::open(
            format!("With friction there may be other solutions: coupling {}", number(coupling)),
            "Only a coupling below 1 proves uniqueness. The reported solution is continued from \
             zero friction. Less friction or longer guides make it unique.",
        )),
        None => all.push(Finding::open(
            "With friction there may be other solutions; it is not known whether they exist",
            "The reported solution is continued from zero friction.",
        )),
    }
    if let Some(others) = &verdict.other_solutions {
        let drives = others.drives.first().into_iter().flatten().zip(&summary.names.drives);
        let drives: Vec<String> =
            drives.map(|(x, (name, unit))| format!("{name} {} {unit}", number(*x))).collect();
        all.push(Finding::bad(
            format!(
                "Friction has other solutions at {} of {} samples",
                others.samples, verdict.samples
            ),
            format!(
                "At t = {} s another one is {}. The mechanism may take either, depending on its history: reduce \
                 the friction, or shorten the lever arm of the force on its guide.",
                number(others.time),
                listed(&drives, NAMED)
            ),
        ));
    }
    match &verdict.friction_margin {
        None => {}
        Some(Margin { factor: Some(factor), time, joint }) => all.push(Finding::open(
            format!("Friction margin to jamming: {}", number(*factor)),
            format!(
                "If all friction coefficients grow by this factor, friction locks {} at t = {} s.",
                joint.as_deref().unwrap_or("the mechanism"),
                number(*time)
            ),
        )),
        Some(Margin { factor: None, .. }) => all.push(Finding::good(
            format!("Nothing locks with up to {MOST_MARGIN} times this friction"),
            "The friction margin to jamming is at least that large.",
        )),
    }
    let steady = &summary.names.steady;
    if !steady.is_empty() {
        all.push(Finding::open(
            format!("Friction at {} is that of steady sliding", listed(steady, NAMED)),
            "Its law has an internal state, which inverse dynamics does not integrate; `stiction \
             forward` does.",
        ));
    }
}
