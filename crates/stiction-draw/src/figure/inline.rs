//! Figure within a page, in the page's colours, with a legend that fits narrow screens.

use super::{Figure, Form, Panel, colour_name};
use crate::drawing::px;
use crate::xml::escape;

impl Figure {
    /// Returns the HTML markup of the title, the legend and the plot for a page; `label` is the
    /// accessible description.
    pub fn inline(&self, label: &str) -> String {
        let mut inner = String::new();
        if !self.title.is_empty() {
            inner += &format!("<p class=\"plot-title\">{}</p>\n", escape(&self.title));
        }
        if !self.labels_lines() {
            inner += &self.legend();
        }
        inner
            + &format!(
                "<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"{}\">{}</div>\n",
                escape(label),
                self.render(Form::Page)
            )
    }

    /// Returns the HTML markup of the legend. Lines or bands with the same label and appearance
    /// share one entry. The legend is empty if it has fewer than two entries.
    fn legend(&self) -> String {
        let mut seen = Vec::new();
        let mut items = String::new();
        for entry in self.panels.iter().flat_map(Panel::labels) {
            let (label, colour, dashed, is_band) = entry;
            if label.is_empty() || seen.contains(&entry) {
                continue;
            }
            seen.push(entry);
            let sample = if is_band {
                let name = colour_name(colour, None);
                format!("<path d=\"M0 1H32V11H0Z\" fill=\"var(--{name})\" fill-opacity=\"0.35\"/>")
            } else {
                let pieces = self.sample(colour, dashed);
                let dashes = match dashed && pieces.len() == 1 {
                    true => " stroke-dasharray=\"8 4\"",
                    false => "",
                };
                let piece = |(start, end, name): &(f64, f64, String)| {
                    let (start, end) = (px(32.0 * start), px(32.0 * end));
                    format!(
                        "<path d=\"M{start} 6H{end}\" stroke=\"var(--{name})\" stroke-width=\"2.5\"{dashes}/>"
                    )
                };
                pieces.iter().map(piece).collect()
            };
            items += &format!(
                "<li><svg viewBox=\"0 0 32 12\" aria-hidden=\"true\">{sample}</svg>{}</li>\n",
                escape(label)
            );
        }
        if seen.len() < 2 {
            return String::new();
        }
        format!("<ul class=\"legend\">\n{items}</ul>\n")
    }
}
