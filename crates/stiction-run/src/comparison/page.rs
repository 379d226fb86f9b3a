//! HTML report that compares several runs.

use super::{Comparison, Reel};
use crate::report::animation::{MOST_RUNS, together};
use crate::report::html::{self, Column, note, section, text};
use crate::report::{findings, version};
use stiction_draw::figure::Figure;
use stiction_draw::numbers::{number, percent};
use stiction_draw::xml::escape;

impl Comparison {
    /// Returns the HTML report that compares two runs, or that shows the worst values of several
    /// runs. The report contains the cautions and the headline figures of all runs, the moving robots of
    /// `reels` drawn over each other, the efforts of all runs in one plot, verdicts, and links to the
    /// reports of the runs. The report of a run is in a folder with the label of the run.
    pub fn report(
        &self,
        (title, about): (&str, &str),
        figure: &Figure,
        reels: Vec<(String, Reel)>,
        command: Option<&str>,
    ) -> String {
        let caption = match reels.len() {
            0..=MOST_RUNS => String::new(),
            _ => format!("Only the first {MOST_RUNS} runs are shown. "),
        };
        let caption = format!(
            "{caption}A run chosen for comparison is drawn grey and dashed, at the same instant, with its own arrows."
        );
        let robots = together(reels, &caption);
        let links: Vec<String> = self
            .labels
            .iter()
            .map(|label| format!("<a href=\"{0}/report.html\">{0}</a>", escape(label)))
            .collect();
        let command = command.map_or(String::new(), |command| {
            format!("<pre class=\"wide\" tabindex=\"0\">{}</pre>\n", escape(command))
        });
        let about: String =
            about.lines().filter(|line| !line.trim().is_empty()).map(note).collect();
        let each = self.labels.iter().zip(&self.runs);
        let cautions: Vec<String> = each
            .flat_map(|(label, run)| run.cautions.iter().map(move |one| format!("{label}: {one}")))
            .collect();
        let inner = [
            format!("<h1>{}</h1>\n", escape(title)),
            about,
            html::warnings(&cautions),
            section("Figures side by side", &self.table()),
            match robots.as_str() {
                "" => String::new(),
                robots => section("The robots", robots),
            },
            section("Actuator efforts", &html::curves(figure)),
            findings(&self.findings()),
            section("Reports of the runs", &format!("<p>{}</p>\n", links.join(" · "))),
            section("To repeat this run", &(command + &version())),
        ];
        match robots.is_empty() {
            true => html::page(title, &inner.concat()),
            false => html::page_with_robot(title, &inner.concat()),
        }
    }

    fn table(&self) -> String {
        let pair = self.labels.len() == 2;
        let mut head = vec![("figure", Column::Text), ("unit", Column::Text)];
        head.extend(self.labels.iter().map(|label| (label.as_str(), Column::Number)));
        head.extend(match pair {
            true => vec![("difference", Column::Number), ("relative", Column::Number)],
            false => vec![("worst", Column::Text)],
        });
        let rows: Vec<Vec<String>> = self
            .rows
            .iter()
            .map(|row| {
                let mut cells = vec![text(&row.headline.name), text(row.headline.unit)];
                let values: Vec<Option<f64>> = row.shown_values().collect();
                cells.extend(values.iter().map(|v| text(&v.map_or("-".to_owned(), number))));
                if pair {
                    // The difference is computed from the shown values, because exact values may
                    // differ by rounding errors.
                    let (difference, relative) = match (&values[..], row.difference()) {
                        ([Some(a), Some(b)], Some((_, relative))) => {
                            (number(b - a), percent(relative))
                        }
                        _ => ("-".to_owned(), "-".to_owned()),
                    };
                    cells.extend([text(&difference), text(&relative)]);
                } else {
                    let worst = row.worst().map_or("", |(run, _)| self.labels[run].as_str());
                    cells.push(text(worst));
                }
                cells
            })
            .collect();
        html::table_of(&head, &rows)
    }
}
