//! Report that compares controllers with and without friction compensation.

use crate::comparison::Reel;
use crate::in_space::{Followed, Path, SpacePoint, Tracked, errors_of, paths, title_of};
use crate::report::animation::together;
use crate::report::html::{self, Column, card, note, section, text};
use crate::report::{Finding, findings, footer, header, repeat};
use serde_json::Value;
use stiction_draw::figure::meaning::REFERENCE;
use stiction_draw::figure::{Figure, Panel, PathTrace, Trace};
use stiction_draw::numbers::number;
use stiction_format::ModelFile;

/// Tracking result of one controller.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracking {
    /// Name of the controller.
    pub label: String,
    /// True if the report plots the tracking errors of this controller over time.
    pub is_drawn: bool,
    /// Four numbers for each actuator: rms and peak of the tracking error, m or rad; the largest
    /// effort and the largest change of the effort between two samples, N or N m.
    pub figures: Vec<[f64; 4]>,
    /// Sum of the work of all actuators, J.
    pub work: f64,
    /// Number of stick onsets of friction interfaces.
    pub sticks: usize,
    /// Number of velocity reversals of the actuators in addition to the reversals of the reference.
    pub reversals: usize,
    /// Reason why the simulation ended early; `None` if it did not.
    pub ended: Option<String>,
    /// Times, s, each with the tracking errors of all actuators, m or rad.
    pub errors: Vec<(f64, Vec<f64>)>,
    /// Times, s, each with the positions and tracking errors of the tracked bodies in space.
    pub space: Vec<(f64, Vec<SpacePoint>)>,
    /// Moving robot under this controller, if the report shows it.
    pub reel: Option<Reel>,
}

/// Tracking results of several controllers along the same motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Controllers {
    /// Sentence that states the motion, the load and the conditions of the comparison.
    pub about: String,
    /// Headline numbers, each as a text with its value and a text that explains it.
    pub headlines: Vec<(String, String)>,
    /// Name of each actuator with the units of its position and effort.
    pub actuators: Vec<(String, &'static str, &'static str)>,
    /// Bodies whose tracking errors in space are computed.
    pub tracked: Vec<Tracked>,
    /// Tracking result of each controller.
    pub tracking: Vec<Tracking>,
    /// Options of the comparison, as JSON.
    pub options: Value,
}

/// Returns the report as HTML: headline numbers, the robot under the drawn controllers, plots of the
/// tracking errors, tables, and verdicts. `command` is the command line that produced the results,
/// if any.
pub fn draw_report(model: &ModelFile, found: &Controllers, command: Option<&str>) -> String {
    let cards: Vec<String> =
        found.headlines.iter().map(|(big, small)| card(big, small, false)).collect();
    let robots = robots(found);
    let inner = [
        header(model, &found.about),
        html::cards(&cards),
        match robots.as_str() {
            "" => String::new(),
            robots => section("The robots", robots),
        },
        section("Tracking errors", &errors(found)),
        match in_space(found) {
            plots if plots.is_empty() => plots,
            plots => section("In space", &plots),
        },
        section("Figures", &figures(found)),
        findings(&verdicts(found)),
        repeat(command, &found.options),
        footer(model),
    ];
    let title = format!("{}: friction compensation", model.name);
    match robots.is_empty() {
        true => html::page(&title, &inner.concat()),
        false => html::page_with_robot(&title, &inner.concat()),
    }
}

/// The moving robots under the drawn controllers, over each other; empty without one.
fn robots(found: &Controllers) -> String {
    let drawn = found.tracking.iter().filter(|own| own.is_drawn);
    let reels: Vec<_> =
        drawn.filter_map(|own| Some((own.label.clone(), own.reel.clone()?))).collect();
    let caption = "The robot under a second controller is drawn grey and dashed, at the same time, with its own arrows.";
    let caption = if reels.len() > 1 { caption } else { "" };
    together(reels, caption)
}

/// Converts a tracking error to thousandths of its unit, such as mm.
fn thousandths(value: f64) -> f64 {
    1e3 * value
}

/// Returns plots of the errors of the drawn controllers by `figure`, which draws the controllers with
/// `true` under a title. Controllers whose errors are too small to be legible beside the largest
/// errors are also plotted separately. `peaks` contains the name of each drawn controller, and its
/// largest error in each panel.
fn by_size(
    title: &str,
    peaks: &[(&str, Vec<f64>)],
    figure: impl Fn(&str, &[bool]) -> Option<Figure>,
) -> String {
    // Fraction of the largest value in a plot below which a curve is not legible.
    const LEGIBLE: f64 = 0.1;
    let largest = |panel: usize| peaks.iter().map(|(_, own)| own[panel]).fold(0.0, f64::max);
    // A panel in which all errors are zero makes no controller large.
    let is_small = |(_, own): &(&str, Vec<f64>)| {
        let fits = |(panel, peak): (usize, &f64)| *peak == 0.0 || *peak < LEGIBLE * largest(panel);
        own.iter().any(|peak| *peak > 0.0) && own.iter().enumerate().all(fits)
    };
    let small: Vec<bool> = peaks.iter().map(is_small).collect();
    let all = figure(title, &vec![true; peaks.len()]);
    let second = small.contains(&true).then(|| {
        let names: Vec<&str> =
            peaks.iter().zip(&small).filter(|(_, small)| **small).map(|(own, _)| own.0).collect();
        // A plot of one controller has no legend.
        let title = match names[..] {
            [name] => format!("{title}: {name}"),
            _ => format!("{title}: controllers with small errors"),
        };
        figure(&title, &small)
    });
    all.iter().chain(second.iter().flatten()).map(html::curves).collect()
}

/// Colour of the curves of a drawn controller, and true if they are dashed.
fn looks(run: usize) -> (usize, bool) {
    (run, run % 2 == 1)
}

/// Plots of the errors of the actuators under the drawn controllers.
fn errors(found: &Controllers) -> String {
    let drawn = || found.tracking.iter().filter(|own| own.is_drawn);
    let figure = |title: &str, shown: &[bool]| {
        let panel = |(k, (name, unit, _)): (usize, &(String, &str, &str))| {
            let line = |((run, own), _): ((usize, &Tracking), _)| {
                let mut trace = Trace::new(own.errors.len());
                let errors = own.errors.iter();
                errors.for_each(|(time, errors)| trace.push(*time, thousandths(errors[k])));
                let (colour, dashed) = looks(run);
                trace.line(&own.label, colour, dashed)
            };
            let lines = drawn().enumerate().zip(shown).filter(|(_, shown)| **shown).map(line);
            let y_label = format!("{name} [m{unit}]");
            Panel { y_label, lines: lines.collect(), ..Panel::default() }
        };
        let panels: Vec<Panel> = found.actuators.iter().enumerate().map(panel).collect();
        Some(Figure { title: title.to_owned(), x_label: "time [s]".to_owned(), panels })
    };
    let peak = |own: &Tracking, k: usize| {
        own.errors.iter().map(|(_, errors)| errors[k].abs()).fold(0.0, f64::max)
    };
    let peaks = |own| (0..found.actuators.len()).map(|k| peak(own, k)).collect();
    let peaks: Vec<(&str, Vec<f64>)> =
        drawn().map(|own| (own.label.as_str(), peaks(own))).collect();
    let plots = by_size("Reference minus position of each actuator", &peaks, figure);
    let more = match drawn().count() < found.tracking.len() {
        true => note(
            "Only the first transition of each controller is drawn; the others are in \
            compensate.csv.",
        ),
        false => String::new(),
    };
    more + &plots
}

/// Returns plots of the paths of the tracked bodies, with each drawn controller and in the
/// reference motion, and plots of their tracking errors over time.
fn in_space(found: &Controllers) -> String {
    let drawn = || found.tracking.iter().filter(|own| own.is_drawn).enumerate();
    let (mut bodies, mut followed) = (Vec::new(), Vec::new());
    for (k, tracked) in found.tracked.iter().enumerate() {
        let path = |label: &str,
                    (colour, dashed),
                    own: &Tracking,
                    of: fn(&SpacePoint) -> [f64; 3]| {
            let mut trace = PathTrace::new(own.space.len());
            own.space.iter().filter_map(|(_, all)| all.get(k)).for_each(|at| trace.push(of(at)));
            Path { label: label.to_owned(), points: trace.into_points(), colour, dashed }
        };
        let mut paths: Vec<Path> =
            drawn().map(|(run, own)| path(&own.label, looks(run), own, |at| at.position)).collect();
        let longest = drawn().map(|(_, own)| own).max_by_key(|own| own.space.len());
        let reference = |own| path("reference", (REFERENCE, true), own, |at| at.reference);
        paths.extend(longest.map(reference));
        bodies.push((tracked, paths));
        let errors = |(run, own): (usize, &Tracking)| {
            let mut followed = Followed::new(&own.label, looks(run), own.space.len());
            let each = own.space.iter().filter_map(|(time, all)| Some((*time, all.get(k)?)));
            each.for_each(|(time, at)| followed.push(time, at.errors));
            followed
        };
        followed.push((tracked, drawn().map(errors).collect()));
    }
    let peaks = |run: usize| -> Vec<f64> {
        let of = |(tracked, runs): &(&Tracked, Vec<Followed>)| runs[run].shown_peaks(tracked);
        followed.iter().flat_map(of).collect()
    };
    let peaks: Vec<(&str, Vec<f64>)> =
        drawn().map(|(run, own)| (own.label.as_str(), peaks(run))).collect();
    let errors = by_size("Tracking error in space", &peaks, |title, shown| {
        let of = |runs: &[Followed]| {
            runs.iter()
                .zip(shown)
                .filter(|(_, shown)| **shown)
                .map(|(run, _)| run.clone())
                .collect()
        };
        errors_of(title, followed.iter().map(|(tracked, runs)| (*tracked, of(runs))).collect())
    });
    let paths = paths(&title_of(found.tracked.iter()), &bodies);
    paths.iter().map(html::curves).collect::<String>() + &errors
}

fn figures(found: &Controllers) -> String {
    let mut rows = Vec::new();
    for own in &found.tracking {
        for (k, (name, unit, effort)) in found.actuators.iter().enumerate() {
            let label = if k == 0 { own.label.clone() } else { String::new() };
            let mut cells = vec![label, name.clone()];
            match own.figures.get(k) {
                Some([rms, peak, most, change]) => cells.extend([
                    format!("{} m{unit}", number(thousandths(*rms))),
                    format!("{} m{unit}", number(thousandths(*peak))),
                    format!("{} {effort}", number(*most)),
                    format!("{} {effort}", number(*change)),
                ]),
                None => cells.extend([const { String::new() }; 4]),
            }
            rows.push(cells.iter().map(|cell| text(cell)).collect());
        }
    }
    let head = [
        ("controller", Column::Text),
        ("actuator", Column::Text),
        ("rms error", Column::Number),
        ("peak error", Column::Number),
        ("largest effort", Column::Number),
        ("change per sample", Column::Number),
    ];
    html::table_of(&head, &rows) + &totals(found)
}

/// Returns an HTML table with the work of all actuators, the stick onsets and the extra reversals
/// of each controller.
fn totals(found: &Controllers) -> String {
    let row = |own: &Tracking| {
        let cells = [
            own.label.clone(),
            format!("{} J", number(own.work)),
            own.sticks.to_string(),
            own.reversals.to_string(),
        ];
        cells.iter().map(|cell| text(cell)).collect()
    };
    let rows: Vec<_> = found.tracking.iter().map(row).collect();
    let head = [
        ("controller", Column::Text),
        ("work of all actuators", Column::Number),
        ("stick onsets", Column::Number),
        ("extra reversals", Column::Number),
    ];
    let about =
        "Reversals beyond those of the reference come from limit cycles, chatter and noise.";
    html::table_of(&head, &rows) + &note(about)
}

fn reversals(count: usize) -> String {
    format!("{count} reversal{}", if count == 1 { "" } else { "s" })
}

fn verdicts(found: &Controllers) -> Vec<Finding> {
    let mut all = Vec::new();
    for own in &found.tracking {
        if let Some(why) = &own.ended {
            all.push(Finding::bad(
                format!("{} ended early: {why}", own.label),
                "The figures of this controller cover only the time until then; comparisons omit \
                 this controller.",
            ));
        } else if own.reversals > 0 {
            all.push(Finding::open(
                format!("{}: {} beyond those of the reference", own.label, reversals(own.reversals)),
                "A limit cycle or chatter. Try a smoother transition, a lower bandwidth, or better sensors.",
            ));
        }
    }
    if all.is_empty() {
        all.push(Finding::good(
            "No limit cycles and no chatter",
            "No actuator reverses more often than its reference.",
        ));
    }
    all
}
