//! Report of a study as an HTML page.

use super::figures::{Picture, Pictures};
use super::findings::{Findings, LISTED, cells};
use crate::comparison::Reel;
use crate::report::animation::together;
use crate::report::html::{self, Column, card, note, section, table};
use crate::report::{findings as verdicts, heading, repeat};
use serde_json::Value;
use stiction_draw::xml::escape;

/// Returns the report of a study as HTML: name and title of the robot, which may be empty, counts,
/// verdicts, extremes of the objectives, the animated robots of `reels` (each with its label) overlaid on each
/// other, pictures, the first designs, and the options for repeating the study.
pub fn draw_report(
    (name, title): (&str, &str),
    (found, pictures): (&Findings, &Pictures),
    reels: Vec<(String, Reel)>,
    command: Option<&str>,
    options: &Value,
) -> String {
    let about =
        "A study: inverse dynamics of each design along its motion, evaluated by the objectives.";
    let caption = match reels.len() {
        0 | 1 => "",
        _ => {
            "Designs with an extreme value of an objective: the first is drawn in colours, a \
             design chosen for comparison grey and dashed, at the same time, with its own arrows."
        }
    };
    let robots = together(reels, caption);
    let inner = [
        heading(name, title, about),
        cards(found),
        verdicts(&found.verdicts()),
        section("Extremes", &extremes(found)),
        match robots.as_str() {
            "" => String::new(),
            robots => section("The robots", robots),
        },
        drawn(pictures),
        designs(found),
        repeat(command, options),
    ];
    let (title, inner) = (format!("{name}: study"), inner.concat());
    match robots.is_empty() {
        true => html::page(&title, &inner),
        false => html::page_with_robot(&title, &inner),
    }
}

fn cards(findings: &Findings) -> String {
    let Findings { rows, failed, doubtful, .. } = findings;
    let plural = if *rows == 1 { "design" } else { "designs" };
    let mut all = vec![
        card(&rows.to_string(), plural, false),
        card(&(rows - failed - doubtful).to_string(), "without cautions", false),
    ];
    for (count, what) in [(doubtful, "with cautions"), (failed, "without results")] {
        if *count > 0 {
            all.push(card(&count.to_string(), what, true));
        }
    }
    html::cards(&all)
}

fn extremes(findings: &Findings) -> String {
    let mut rows = Vec::new();
    for (objective, extremes) in findings.objectives.iter().zip(&findings.extremes) {
        let Some(both) = extremes else {
            let none = ["no value", "", "", ""].map(str::to_owned);
            rows.push(std::iter::once(objective.clone()).chain(none).collect());
            continue;
        };
        for (what, extreme) in ["least", "greatest"].into_iter().zip(both) {
            rows.push(vec![
                objective.clone(),
                what.to_owned(),
                stiction_draw::numbers::number(extreme.value),
                extreme.row.to_string(),
                findings.settings_in_words(extreme),
            ]);
        }
    }
    let head = [
        ("objective", Column::Text),
        ("", Column::Text),
        ("value", Column::Number),
        ("row", Column::Number),
        ("design", Column::Text),
    ];
    table(&head, &rows)
}

fn drawn(pictures: &Pictures) -> String {
    let all = pictures.all();
    if all.is_empty() {
        return String::new();
    }
    let inner = all.iter().enumerate().map(|(k, (_, picture))| match picture {
        Picture::Curves(figure) => html::curves(figure),
        Picture::Map(map) => format!(
            "<figure class=\"plot\">\n<div class=\"wide\" tabindex=\"0\" role=\"group\" \
             aria-label=\"{}\">{}</div>\n</figure>\n",
            escape(&map.title),
            map.inline(k)
        ),
    });
    section("Over the varied keys", &inner.collect::<String>())
}

fn designs(findings: &Findings) -> String {
    let columns = findings.columns();
    let head: Vec<(&str, Column)> =
        columns.iter().map(|name| (name.as_str(), Column::Number)).collect();
    let first = findings.first.iter().take(LISTED);
    let rows: Vec<Vec<String>> =
        first.map(|(row, settings, results)| cells(*row, settings, results)).collect();
    let about = match findings.first.len() > LISTED {
        true => format!("The first {LISTED} designs; sweep.csv has all, with all digits."),
        false => "All designs; sweep.csv has them with all digits.".to_owned(),
    };
    section("Designs", &(note(&about) + &table(&head, &rows)))
}
