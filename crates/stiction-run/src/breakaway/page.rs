//! Report on a mechanism at rest as a self-contained HTML page.

use super::Findings;
use super::terminal::{certainty_text, unpowered_text, verdict_word};
use crate::Job;
use crate::names::{Names, legs_of_actuators};
use crate::report::animation::Animation;
use crate::report::html::{self, Column, card, note, section, text};
use crate::report::{Finding, findings, footer, header, repeat};
use stiction_core::dynamics::Verdict;
use stiction_draw::figure::meaning::{LIMIT, OF_LEG};
use stiction_draw::figure::{Bar, Bars};
use stiction_draw::numbers::number;

/// Returns the report on a mechanism at rest as HTML: the efforts that hold the mechanism, the
/// efforts that move it, and whether it holds its pose without actuators. `command` is the command
/// line that produced the results, if any.
pub fn draw_report(job: &Job<'_>, found: &Findings, command: Option<&str>) -> String {
    let names = Names::new(&job.model.mechanism);
    let legs = legs_of_actuators(&job.model.mechanism);
    let about = format!(
        "At rest at t = {} s of the motion {}; load {}.",
        number(found.time),
        job.motion_name,
        job.load_name
    );
    let mut still = Animation::of_motion(job.model, 1);
    still.push_pose(found.time, &found.poses);
    let inner = [
        header(job.model, &about),
        cards(&names, found),
        section("The mechanism", &still.figure("", None)),
        section(
            "Efforts that hold the mechanism, and efforts that move it",
            &efforts(&names, &legs, found),
        ),
        findings(&verdicts(&names, found)),
        repeat(command, &found.json(job)["options"]),
        footer(job.model),
    ];
    html::page_with_robot(&format!("{}: at rest", job.model.name), &inner.concat())
}

fn cards(names: &Names, found: &Findings) -> String {
    let word = match found.rest.unpowered.verdict {
        Verdict::Holds => "holds",
        Verdict::Slips => "slips",
        Verdict::Undecided => "undecided",
    };
    let mut all = vec![card(word, "without actuator efforts", false)];
    for unit in ["N", "N m"] {
        let own = names.drives.iter().zip(&found.forces.effort_bounds);
        let widths = own
            .filter(|((_, own), _)| *own == unit)
            .map(|((name, _), (low, high))| (name, high - low));
        if let Some((name, width)) = widths.max_by(|a, b| a.1.total_cmp(&b.1)) {
            let what = format!("widest interval of an effort: {name}");
            let width = if width.is_finite() {
                format!("{} {unit}", number(width))
            } else {
                "∞".to_owned()
            };
            all.push(card(&width, &what, false));
        }
    }
    html::cards(&all)
}

fn efforts(names: &Names, legs: &[Option<usize>], found: &Findings) -> String {
    let mut inner = note(
        "Static friction allows any effort within the bar; the mark is the effort without \
         friction. Beyond the bar the joint begins to move.",
    );
    for unit in ["N", "N m"] {
        let own = (0..names.drives.len()).filter(|&k| names.drives[k].1 == unit);
        let bars = own.map(|k| Bar {
            label: names.drives[k].0.clone(),
            ends: found.forces.effort_bounds[k],
            mark: Some(found.forces.efforts_frictionless[k]),
            colour: if found.forces.effort_bounds[k].0.is_finite() { OF_LEG } else { LIMIT },
            leg: legs[k],
        });
        let (title, unit) = ("Efforts at rest".to_owned(), unit.to_owned());
        let axis = "effort".to_owned();
        inner += &html::bars(&Bars { title, axis, unit, bars: bars.collect() });
    }
    let row = |k: usize| {
        let (name, unit) = &names.drives[k];
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
        let alone = verdict_word(found.rest.alone[k].verdict).to_owned();
        let cells = [number(without), number(low), number(high), backward, forward, alone];
        [name, *unit].into_iter().chain(cells.iter().map(String::as_str)).map(text).collect()
    };
    let rows: Vec<Vec<String>> = (0..names.drives.len()).map(row).collect();
    let head = [
        ("actuator", Column::Text),
        ("unit", Column::Text),
        ("no friction", Column::Number),
        ("holds from", Column::Number),
        ("to", Column::Number),
        ("more to move backward", Column::Number),
        ("forward", Column::Number),
        ("unpowered, others held", Column::Text),
    ];
    inner + &html::table_of(&head, &rows)
}

fn verdicts(names: &Names, found: &Findings) -> Vec<Finding> {
    let unpowered = unpowered_text(&found.rest.unpowered);
    let meaning = "Equilibrium of static friction, gravity and loads alone: no actuator exerts an \
        effort. Where the mechanism slips, it needs a brake or a self-locking gear.";
    let mut all = vec![match found.rest.unpowered.verdict {
        Verdict::Holds => Finding::good(unpowered, meaning),
        Verdict::Slips | Verdict::Undecided => Finding::open(unpowered, meaning),
    }];
    for line in certainty_text(names, found).lines() {
        all.push(Finding::open(
            line,
            "Each interval is either exact or an inner bound; guaranteed bounds, if they are \
             known, are wider. For each effort in an interval, the other actuators exert \
             matching efforts.",
        ));
    }
    all
}
