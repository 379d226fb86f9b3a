//! Figure inside a page, in the page's colours, with a legend that fits narrow screens.

use super::{COLOURS, Figure, Form, Line};
use crate::xml::escape;
use kuva::prelude::*;
use std::collections::HashSet;

impl Figure {
    /// Markup of the title, the legend and the plot. `name` makes element identifiers unique in the
    /// page, `label` is the accessible description.
    pub fn inline(&self, name: &str, label: &str) -> String {
        let mut inner = String::new();
        if !self.title.is_empty() {
            inner += &format!("<p class=\"plot-title\">{}</p>\n", escape(&self.title));
        }
        if self.has_one_legend() {
            let lines = self.panels.iter().flat_map(|panel| &panel.lines);
            inner += &legend("", lines);
        } else {
            let legends = self.panels.iter().map(|panel| legend(&panel.y_label, &panel.lines));
            inner += &legends.collect::<String>();
        }
        inner
            + &format!(
                "<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"{}\">{}</div>\n",
                escape(label),
                self.inline_svg(name)
            )
    }

    /// True if each colour, solid or dashed, has the same meaning in all panels.
    fn has_one_legend(&self) -> bool {
        let all = || self.panels.iter().flat_map(|panel| &panel.lines);
        let looks: HashSet<_> = all().map(Line::look).collect();
        let entries: HashSet<_> = all().map(|line| (line.look(), &line.label)).collect();
        looks.len() == entries.len() || self.panels.len() == 1
    }

    fn inline_svg(&self, name: &str) -> String {
        // Quotation marks in text and attributes are escaped, so the replacements affect markup
        // only.
        let mut svg = SvgBackend
            .render_scene(&self.sheet(Form::Page).render())
            .replace("id=\"kuva-clip-", &format!("id=\"{name}_clip"))
            .replace("clip-path=\"url(#kuva-clip-", &format!("clip-path=\"url(#{name}_clip"))
            // Numbers at the axes use the minus sign of those in tables.
            .replace("\">-", "\">−")
            .replacen("\" height=\"", " ", 1)
            .replacen(" width=\"", " class=\"curves\" viewBox=\"0 0 ", 1);
        let mut paint = |part: &str, from: &str, to: &str| {
            svg = svg.replace(&format!("{part}=\"{from}\""), &format!("{part}=\"var(--{to})\""));
        };
        for white in ["white", "#ffffff"] {
            paint("fill", white, "paper");
        }
        for part in ["fill", "stroke"] {
            paint(part, "black", "ink");
            paint(part, "#000000", "ink");
            paint(part, "#cccccc", "grid");
            for (k, colour) in COLOURS.iter().enumerate() {
                paint(part, colour, &format!("line{k}"));
            }
        }
        svg
    }
}

impl Line {
    fn look(&self) -> (usize, bool) {
        (self.colour % COLOURS.len(), self.dashed)
    }
}

/// Legend of the lines without duplicates of style and name; `title` may name the panel.
fn legend<'a>(title: &str, lines: impl IntoIterator<Item = &'a Line>) -> String {
    let mut seen = HashSet::new();
    let mut items = String::new();
    for line in lines {
        if !line.label.is_empty() && seen.insert((line.look(), &line.label)) {
            let dashes = if line.dashed { " stroke-dasharray=\"8 4\"" } else { "" };
            items += &format!(
                "<li><svg viewBox=\"0 0 32 12\" aria-hidden=\"true\"><path d=\"M0 6H32\" \
                 stroke=\"var(--line{})\" stroke-width=\"2.5\"{dashes}/></svg>{}</li>\n",
                line.look().0,
                escape(&line.label)
            );
        }
    }
    if items.is_empty() {
        return items;
    }
    if !title.is_empty() {
        items = format!("<li class=\"panel\">{}:</li>\n{items}", escape(title));
    }
    format!("<ul class=\"legend\">\n{items}</ul>\n")
}
