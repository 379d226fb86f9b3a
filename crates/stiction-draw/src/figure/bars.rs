//! Horizontal bar charts: bars of amounts begin at zero, bars of intervals at any value.

use super::axis::Axis;
use super::colour_name;
use crate::drawing::px;
use crate::numbers::{number, with_minus};
use crate::xml::escape;

/// Horizontal bar chart; all bars have a common axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Bars {
    /// Title above the bars.
    pub title: String,
    /// Name of the axis, without the unit. The axis is labelled only if a bar shows an interval.
    pub axis: String,
    /// Unit of the values.
    pub unit: String,
    /// Bars from top to bottom.
    pub bars: Vec<Bar>,
}

/// Bar that shows an amount or an interval of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// Name left of the bar.
    pub label: String,
    /// Low and high end; if the bar shows an amount, one of them is zero. Infinite ends are drawn at the end of
    /// the axis.
    pub ends: (f64, f64),
    /// Marked value within the interval, if any.
    pub mark: Option<f64>,
    /// Index of the bar's colour in [`super::COLOURS`], or one of [`super::meaning`].
    pub colour: usize,
    /// Index of the leg to which the quantity belongs; `None` for a quantity of no leg.
    pub leg: Option<usize>,
}

const WIDTH: f64 = 700.0;
const ROW: f64 = 24.0;
const LETTER: f64 = 6.8;
const LONGEST: usize = 28;
/// Approximate number of steps between the ticks of the axis.
const TICKS: usize = 8;

impl Bars {
    /// Returns the HTML markup of the title and the bars for a page; empty without bars. `label` is
    /// the accessible description.
    pub fn inline(&self, label: &str) -> String {
        if self.bars.is_empty() {
            return String::new();
        }
        format!(
            "<p class=\"plot-title\">{}</p>\n<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"{}\">{}</div>\n",
            escape(&self.title),
            escape(label),
            self.svg()
        )
    }

    fn svg(&self) -> String {
        let finite =
            || self.bars.iter().flat_map(|bar| [bar.ends.0, bar.ends.1]).filter(|x| x.is_finite());
        let (low, high) = finite().fold((0.0_f64, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
        let span = 0.5 * high - 0.5 * low;
        let (low, high) = if span > 0.0 { (low, high) } else { (0.0, 1.0) };
        let short = |text: &str| -> String {
            match text.chars().count() > LONGEST {
                true => text.chars().take(LONGEST - 1).chain(['…']).collect(),
                false => text.to_owned(),
            }
        };
        let letters = self.bars.iter().map(|bar| short(&bar.label).chars().count()).max();
        let left = 14.0 + LETTER * letters.unwrap_or(0) as f64;
        let values: Vec<String> = self.bars.iter().map(|bar| self.value(bar)).collect();
        let letters = values.iter().map(|text| text.chars().count()).max().unwrap_or(0);
        let right = WIDTH - 12.0 - LETTER * letters as f64;
        let at = |x: f64| left + (right - left) * ((x - low) / (high - low)).clamp(0.0, 1.0);
        let foot = ROW * self.bars.len() as f64 + 8.0;
        // Intervals need an axis, because they do not begin at zero.
        let are_intervals = self.bars.iter().any(|bar| bar.ends.0 != 0.0 && bar.ends.1 != 0.0);
        let height = if are_intervals { foot + 36.0 } else { foot };
        let mut drawn = format!(
            "<svg class=\"curves\" viewBox=\"0 0 {WIDTH} {}\" font-family=\"Helvetica, Arial, sans-serif\" \
             font-size=\"12.5\">",
            px(height)
        );
        if are_intervals {
            let ticks = Axis::exact([low, high].into_iter(), TICKS).ticks();
            for (value, label) in ticks {
                let x = px(at(value));
                drawn += &format!(
                    "<g stroke=\"var(--grid)\"><path d=\"M{x} 0V{}\"/></g>\
                     <text x=\"{x}\" y=\"{}\" text-anchor=\"middle\" fill=\"var(--ink)\">{label}</text>",
                    px(foot),
                    px(foot + 14.0)
                );
            }
            drawn += &format!(
                "<path d=\"M{} {foot}H{}\" stroke=\"var(--soft)\"/>\
                 <text x=\"{}\" y=\"{}\" text-anchor=\"middle\" fill=\"var(--soft)\">{}</text>",
                px(left),
                px(right),
                px(0.5 * (left + right)),
                px(foot + 31.0),
                escape(&format!("{} [{}]", self.axis, self.unit)),
                foot = px(foot),
            );
        }
        for (k, (bar, value)) in self.bars.iter().zip(&values).enumerate() {
            let middle = 4.0 + ROW * (k as f64 + 0.5);
            let (from, to) = (at(bar.ends.0), at(bar.ends.1));
            drawn += &format!(
                "<text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"var(--ink)\">{}</text>\
                 <rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"14\" fill=\"var(--{})\"/>\
                 <text x=\"{}\" y=\"{}\" fill=\"var(--soft)\" stroke=\"var(--paper)\" stroke-width=\"4\" \
                 paint-order=\"stroke\">{}</text>",
                px(left - 8.0),
                px(middle + 4.5),
                escape(&short(&bar.label)),
                px(from),
                px(middle - 7.0),
                px((to - from).max(1.0)),
                colour_name(bar.colour, bar.leg),
                px(to.max(at(0.0)) + 6.0),
                px(middle + 4.5),
                escape(value),
            );
            if let Some(mark) = bar.mark.filter(|mark| mark.is_finite()) {
                drawn += &format!(
                    "<path d=\"M{} {}v20\" stroke=\"var(--ink)\" stroke-width=\"2\"/>",
                    px(at(mark)),
                    px(middle - 10.0)
                );
            }
        }
        let zero = px(at(0.0));
        drawn
            + &format!(
                "<path d=\"M{zero} 0V{}\" stroke=\"var(--soft)\" stroke-width=\"1\"/></svg>",
                px(foot)
            )
    }

    fn value(&self, bar: &Bar) -> String {
        let end = |x: f64| match x {
            f64::INFINITY => "∞".to_owned(),
            f64::NEG_INFINITY => "−∞".to_owned(),
            x => with_minus(&number(x)),
        };
        match bar.ends {
            (0.0, high) => format!("{} {}", end(high), self.unit),
            (low, high) => format!("{} to {} {}", end(low), end(high), self.unit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that intervals have an axis with ticks and its unit. Bars of amounts begin at zero
    /// and state their values, so they need no axis.
    #[test]
    fn intervals_have_an_axis() {
        let with = |ends| {
            let bar = Bar { label: "a".into(), ends, mark: None, colour: 0, leg: None };
            Bars { title: "t".into(), axis: "x".into(), unit: "N".into(), bars: vec![bar] }
                .inline("l")
        };
        let markup = with((3.0, 5.0));
        for text in [">0</text>", ">1</text>", ">5</text>", ">x [N]</text>"] {
            assert!(markup.contains(text), "{text} in {markup}");
        }
        assert!(!with((0.0, 5.0)).contains(">0</text>"));
    }

    #[test]
    fn odd_bars_are_drawn() {
        let bar = |ends| Bar {
            label: "<b> & a name that is far too long for its column".into(),
            ends,
            mark: Some(0.0),
            colour: 9,
            leg: None,
        };
        for ends in
            [(0.0, 0.0), (-1.0, f64::INFINITY), (f64::NEG_INFINITY, f64::INFINITY), (-1e300, 1e300)]
        {
            let bars = Bars {
                title: "t".into(),
                axis: "x".into(),
                unit: "N".into(),
                bars: vec![bar(ends)],
            };
            let markup = bars.inline("l");
            assert!(
                !markup.contains("NaN") && !markup.contains("inf") && !markup.contains("<b>"),
                "{markup}"
            );
        }
        assert!(
            Bars { title: "t".into(), axis: "x".into(), unit: "N".into(), bars: vec![] }
                .inline("l")
                .is_empty()
        );
    }
}
