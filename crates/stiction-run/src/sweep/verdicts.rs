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
        let valueless = self.failed + self.missing[index];
        if self.rows - valueless < 2 {
            return;
        }
        let size = greatest.value.abs().max(least.value.abs());
        // An infinite value equals only itself.
        let is_constant = greatest.value == least.value
            || size.is_finite() && greatest.value - least.value <= ROUNDING * size;
        if is_constant {
            let which = if valueless > 0 { "all designs that have it" } else { "all designs" };
            all.push(Finding::open(
                format!("{objective} is {} in {which}", number(least.value)),
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
                    None => "No design without cautions has a value of it.".to_owned(),
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
        let has_ends = self.spans.iter().flatten().any(|(low, high)| low < high);
        all.push(match at_ends {
            0 if !has_ends => Finding::good(
                statement,
                "No key is varied over plain numbers, so the study has no ends beyond which a value may be better.",
            ),
            0 => Finding::good(
                statement,
                format!("Both lie between the ends of the varied values.{}", self.beside_failures()),
            ),
            1 => Finding::good(
                statement,
                format!(
                    "One lies between the ends of the varied values; the other one may continue beyond the end.{}",
                    self.beside_failures()
                ),
            ),
            _ => Finding::open(
                statement,
                "The study has not found where the objective turns: a value beyond the end may be better. Extend the range \
                 of these keys if such designs can be built.",
            ),
        });
    }

    /// Returns the reservation that an extreme may lie where designs begin to fail; empty without failures.
    fn beside_failures(&self) -> &'static str {
        match self.failed {
            0 => "",
            _ => {
                " Some designs have no results: an extreme next to them may lie at the edge of what is possible."
            }
        }
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

#[cfg(test)]
mod tests {
    use crate::sweep::{Findings, Row, Status};
    use stiction_format::Setting;

    /// Returns statements and meanings for designs whose variant is a text.
    fn verdicts(values: &[Option<f64>]) -> Vec<(String, String)> {
        let mut findings = Findings::new(&[], &["peak(J.effort) [N]".to_owned()]);
        for (k, value) in values.iter().enumerate() {
            let status = Status::parse("ok").unwrap();
            let row = Row { values: vec![*value], status };
            findings.add(k as u64 + 1, &[Setting::Text("light".to_owned())], &row);
        }
        findings.verdicts().into_iter().map(|one| (one.statement, one.meaning)).collect()
    }

    /// A single value, and a finite beside an infinite one, are not the value of all designs.
    #[test]
    fn few_or_infinite_values_are_not_constant() {
        for values in [[Some(5.0), None, None], [Some(5.0), Some(f64::INFINITY), Some(5.0)]] {
            let found = verdicts(&values);
            assert!(!found.iter().any(|(own, _)| own.contains("is 5.000 in")), "{found:?}");
        }
        let found = verdicts(&[Some(5.0), Some(5.0), None]);
        let stated = "peak(J.effort) [N] is 5.000 in all designs that have it";
        assert!(found.iter().any(|(own, _)| own == stated), "{found:?}");
    }

    /// Values that are not numbers have no ends.
    #[test]
    fn texts_have_no_ends() {
        let found = verdicts(&[Some(5.0), Some(6.0)]);
        let (_, meaning) = found.last().unwrap();
        assert!(meaning.contains("has no ends"), "{found:?}");
    }
}
