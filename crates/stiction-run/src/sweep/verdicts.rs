//! Verdicts on a study: failed designs, cautions, and where the objectives have their extremes.

use super::findings::{Extreme, Findings};
use crate::names::listed;
use crate::report::Finding;
use stiction_draw::numbers::number;
use stiction_format::Setting;

/// Relative difference below which the values of an objective are equal up to rounding errors.
const ROUNDING: f64 = 1e-9;
/// Largest number of names that one sentence lists.
const NAMED: usize = 6;

impl Findings {
    /// Returns the verdicts on the study, with their meaning.
    pub(super) fn verdicts(&self) -> Vec<Finding> {
        let mut all = self.remarks.findings(self.rows);
        if self.rows > 0 && self.failed + self.doubtful == 0 {
            let what = if self.rows == 1 { "The design has" } else { "All designs have" };
            all.push(Finding::good(
                format!("{what} results without cautions"),
                "Along the motion of each design the efforts are unique, no singular position is passed, and no declared \
                 range and no limit of a motor is exceeded.",
            ));
        }
        for (index, objective) in self.objectives.iter().enumerate() {
            self.missing(index, objective, &mut all);
            self.extremes(index, objective, &mut all);
        }
        all
    }

    fn missing(&self, index: usize, objective: &str, all: &mut Vec<Finding>) {
        let missing = self.missing[index];
        if missing > 0 {
            let (designs, have) =
                if missing == 1 { ("design", "has") } else { ("designs", "have") };
            all.push(Finding::open(
                format!("{objective}: {missing} {designs} with results {have} no value"),
                "The column is not a number along the motion, for example an interval without limit at rest. Choose a \
                 column that every design has.",
            ));
        }
    }

    fn extremes(&self, index: usize, objective: &str, all: &mut Vec<Finding>) {
        let Some([least, greatest]) = &self.extremes[index] else { return };
        let computed = self.rows - self.failed;
        if computed < 2 {
            return;
        }
        if greatest.value - least.value <= ROUNDING * greatest.value.abs().max(least.value.abs()) {
            all.push(Finding::open(
                format!("{objective} is {} in all designs", number(least.value)),
                "The varied keys have no effect on it. Check that the motion and the load use them, and that friction is \
                 on if they describe friction (`--friction on`).",
            ));
            return;
        }
        let sound = self.sound[index].as_ref();
        for (place, (what, extreme)) in
            ["least", "greatest"].into_iter().zip([least, greatest]).enumerate()
        {
            let best = sound.map(|both| &both[place]);
            if best.is_none_or(|best| best.row != extreme.row && best.value != extreme.value) {
                let without = match best {
                    None => "No design is without cautions.".to_owned(),
                    Some(best) => format!(
                        "Without them, the {what} value is {} in row {} ({}).",
                        number(best.value),
                        best.row,
                        self.settings_in_words(best)
                    ),
                };
                all.push(Finding::open(
                    format!("{objective} is {what} in row {}, which has cautions", extreme.row),
                    format!(
                        "Do not choose this design before its cautions are resolved. {without}"
                    ),
                ));
            }
        }
        let [low, high] = [least, greatest].map(|extreme| self.ends(extreme));
        let each = [("least", least, low), ("greatest", greatest, high)];
        let statements = each.iter().map(|(what, extreme, ends)| {
            let at = match ends.is_empty() {
                true => String::new(),
                false => format!(", at an end of {}", listed(ends, NAMED)),
            };
            format!("{what} {} in row {}{at}", number(extreme.value), extreme.row)
        });
        let statement = format!("{objective}: {}", statements.collect::<Vec<_>>().join("; "));
        let at_ends = each.iter().filter(|(_, _, ends)| !ends.is_empty()).count();
        all.push(match at_ends {
            0 => Finding::good(statement, "Both lie between the ends of the varied values."),
            1 => Finding::good(
                statement,
                "One lies between the ends of the varied values; the other one may continue beyond the end.",
            ),
            _ => Finding::open(
                statement,
                "The study has not found where the objective turns: a value beyond the end may be better. Extend the range \
                 of these keys if such designs can be built.",
            ),
        });
    }

    /// Returns the names of the varied keys that have their least or greatest number of the study in a design.
    fn ends(&self, extreme: &Extreme) -> Vec<String> {
        let keys = self.keys.iter().zip(&extreme.settings).zip(&self.spans);
        keys.filter_map(|((key, setting), span)| {
            let (Setting::Number(value), Some((low, high))) = (setting, *span) else { return None };
            (low < high && (*value == low || *value == high)).then(|| format!("`{}`", key.path))
        })
        .collect()
    }
}
