//! Verdicts on the results of a simulation for the report. Each verdict comes with an explanation
//! or advice.

use crate::forward::events::methods;
use crate::forward::job::Job;
use crate::forward::outcome::{Ending, Outcome};
use crate::forward::summary::Summary;
use crate::forward::terminal::COARSE;
use crate::report::Finding;
use stiction_draw::numbers::{number, order};

pub(in crate::forward) fn of(job: &Job<'_>, summary: &Summary, outcome: &Outcome) -> Vec<Finding> {
    let mut all = Vec::new();
    ending(job, summary, outcome, &mut all);
    energy(job, summary, outcome, &mut all);
    events(summary, outcome, &mut all);
    if outcome.open_drives > 0 {
        all.push(Finding::bad(
            "The efforts are not unique",
            "More joints are prescribed or locked than necessary; the efforts with the least sum of squares are \
             reported. Release one of them.",
        ));
    }
    if outcome.coarsest > COARSE {
        all.push(Finding::bad(
            format!("Near a singular position the relative error of a step is {:.0e}", outcome.coarsest),
            "Rounding allows no smaller error there; the motion after that position is at least as uncertain.",
        ));
    }
    let statement = match methods(&outcome.events, summary.span()) {
        [_, 0.0] => "Integrated event by event".to_owned(),
        [0.0, _] => "Integrated by time stepping".to_owned(),
        [events, steps] => format!(
            "Integrated event by event for {} s, by time stepping for {} s",
            number(events),
            number(steps)
        ),
    };
    all.push(Finding::good(
        statement,
        "Event by event, each stick and slip onset is located; with time stepping, reactions are averages over \
         steps, and it is not examined whether the motion and the static frictions are unique.",
    ));
    all
}

fn ending(job: &Job<'_>, summary: &Summary, outcome: &Outcome, all: &mut Vec<Finding>) {
    let last = number(summary.last.time);
    match &outcome.ending {
        Ending::Reached => {}
        Ending::Stopped(condition) => all.push(Finding::good(
            format!("Ended at t = {last} s: {condition}"),
            "The given stop condition was met.",
        )),
        Ending::Interrupted => all.push(Finding::bad(
            format!("Interrupted at t = {last} s, before t = {} s", number(job.until)),
            "The same command with --resume continues from there.",
        )),
        Ending::Failed(error) => all.push(Finding::bad(
            format!("Failed at t = {last} s, before t = {} s", number(job.until)),
            error.to_string(),
        )),
    }
    if outcome.rates_changed {
        all.push(Finding::bad(
            "The initial rates differ from the requested ones",
            "Locked or prescribed joints do not allow the requested rates. Give rates that these \
             joints allow, or release one of them.",
        ));
    }
}

fn energy(job: &Job<'_>, summary: &Summary, outcome: &Outcome, all: &mut Vec<Finding>) {
    let closes = format!("loops close to {} m", order(summary.closure.peak));
    if let Some(part) = summary.energy_lost(&job.settings, &outcome.events) {
        all.push(Finding::bad(
            format!("The energy balance does not close: relative error {}", number(part)),
            "Do not trust these results. Give another --tolerance or --method; the column `error` of energy.csv \
             shows when the error arises.",
        ));
    } else if let Some(relative) = summary.energy_error_relative() {
        all.push(Finding::good(
            format!("The energy balance closes to {} of the energy exchanged; {closes}", order(relative)),
            "Work, energy and dissipation are integrated along with the motion and compared: an independent check.",
        ));
    } else {
        all.push(Finding::good(
            format!("No energy is exchanged; {closes}"),
            "The mechanism stays at rest.",
        ));
    }
}

fn events(summary: &Summary, outcome: &Outcome, all: &mut Vec<Finding>) {
    let described = summary.described(&outcome.events);
    let of = |what: &str| {
        let mut own = described.iter().filter(|event| event.what == what);
        let first = own.next()?;
        Some((1 + own.count(), number(first.time), first.at.clone(), first.detail.clone()))
    };
    if let Some((count, time, at, _)) = of("jump") {
        all.push(Finding::bad(
            format!("Jamming: {count} times, first at t = {time} s, no acceleration satisfies the friction laws"),
            format!(
                "The largest normal load is in {at}. At such an instant velocities jump to values that satisfy all \
                 laws; a real mechanism takes an impact. Reduce the friction, or the lever arm of the force on this \
                 joint."
            ),
        ));
    }
    if let Some((_, time, at, detail)) = of("not-unique") {
        all.push(Finding::bad(
            format!("From t = {time} s on, other motions also satisfy all friction laws"),
            format!(
                "{detail}; the normal load of {at} differs most. The reported motion is the \
                solution continued from zero friction."
            ),
        ));
    }
    if let Some((count, time, ..)) = of("singular") {
        all.push(Finding::open(
            format!("Singular positions are passed {count} times, first at t = {time} s"),
            "Branches of motion meet there, and the motion continues smoothly; a real mechanism may take another.",
        ));
    }
    if let Some((_, time, ..)) = of("shares-not-unique") {
        all.push(Finding::open(
            format!("The distribution of static friction is not unique from t = {time} s on"),
            "More friction interfaces stick than necessary, so a rule determines the share of each. Normal loads and \
             the next slip onset can depend on this rule.",
        ));
    }
}
