//! Phrases shared by many messages.

/// Maximum length, in characters, of a name that a message shows in full. No similar names are
/// searched for a longer name.
const LONGEST_NAME: usize = 60;

/// Quotes a name from the input with backticks. Long names are shortened, and control characters
/// are escaped.
pub(crate) fn quoted(name: &str) -> String {
    let mut shown: String = name.chars().take(LONGEST_NAME).flat_map(char::escape_debug).collect();
    // `escape_debug` would also escape quotes.
    shown = shown.replace("\\'", "'").replace("\\\"", "\"");
    if name.chars().count() > LONGEST_NAME {
        shown.push('…');
    }
    format!("`{shown}`")
}

/// Returns the candidates most similar to `name`, all at the same edit distance; empty if no
/// candidate is similar.
fn similar<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    if name.chars().count() > LONGEST_NAME {
        return Vec::new();
    }
    let plain = |s: &str| s.to_lowercase().replace('-', "_");
    let plain_name = plain(name);
    // Up to a third of the letters may differ: `platfrom` matches `platform`, `q` has no match.
    let tolerance = (plain_name.chars().count() / 3).clamp(1, 4);
    let candidates = candidates.into_iter().filter(|candidate| candidate.len() <= 4 * LONGEST_NAME);
    let mut near: Vec<(usize, &str)> = candidates
        .filter_map(|candidate| {
            let known = plain(candidate);
            let distance = strsim::damerau_levenshtein(&plain_name, &known);
            // The beginning of a name matches, too: `collar` is short for `collar_radius`, `mu_s`
            // for `mu_static`.
            let begins = known.starts_with(&plain_name) && plain_name.len() >= 3;
            let is_near = distance <= tolerance && distance < candidate.len();
            (is_near || begins).then_some((if is_near { distance } else { tolerance }, candidate))
        })
        .collect();
    near.sort_by_key(|&(distance, _)| distance);
    let least = near.first().map_or(0, |&(distance, _)| distance);
    near.into_iter().take_while(|&(distance, _)| distance == least).map(|(_, name)| name).collect()
}

/// Returns the candidate most similar to `name`; `None` if no candidate is similar.
pub(crate) fn nearest<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    similar(name, candidates).first().copied()
}

/// Returns the phrase `did you mean ...?` with the candidates most similar to `name`, at most four.
/// If no candidate is similar, returns `what` followed by a list of the candidates, at most twelve.
/// Returns `None` if there are no candidates.
pub fn did_you_mean<'a>(
    name: &str,
    what: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    let candidates: Vec<_> = candidates.into_iter().collect();
    let near: Vec<String> =
        similar(name, candidates.iter().copied()).into_iter().take(4).map(quoted).collect();
    if !near.is_empty() {
        return Some(format!("did you mean {}?", or(&near)));
    }
    const MOST: usize = 12;
    let shown = candidates.iter().take(MOST).map(|c| quoted(c)).collect::<Vec<_>>();
    match candidates.len() {
        0 => None,
        n if n > MOST => Some(format!("{what}: {}, … ({n} in all)", shown.join(", "))),
        _ => Some(format!("{what}: {}", shown.join(", "))),
    }
}

/// Joins words as in `a, b or c`.
pub(crate) fn or(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., end] => format!("{} or {end}", first.join(", ")),
    }
}

/// Formats a number in the shortest form that parses back to the same number.
pub(crate) fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || (1e-4..1e7).contains(&size) { format!("{x}") } else { format!("{x:e}") }
}

/// Formats a positive least value with four significant digits, rounded up, so that the number shown
/// is sufficient.
pub(crate) fn least(x: f64) -> String {
    if !(x.is_finite() && x > 0.0) {
        return number(x);
    }
    let digit = 10f64.powi(x.log10().floor() as i32 - 3);
    // Values that round-off raises above four digits are not rounded up.
    let up = (x / digit * (1.0 - 1e-9)).ceil() * digit;
    format!("{up:.3e}").parse().map_or_else(|_| number(x), number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typing_errors_get_suggestions() {
        let keys = ["mass", "com", "inertia", "home"];
        for (typed, meant) in [
            ("masss", Some("mass")),
            ("Mass", Some("mass")),
            ("cmo", Some("com")),
            ("intertia", Some("inertia")),
            ("q", None),
            ("colour", None),
            ("ine", Some("inertia")),
        ] {
            assert_eq!(nearest(typed, keys), meant, "{typed}");
        }
    }

    #[test]
    fn names_are_shown_safely() {
        assert_eq!(quoted("a\u{1b}[31m"), "`a\\u{1b}[31m`");
        assert_eq!(quoted("it's"), "`it's`");
        assert!(quoted(&"x".repeat(1000)).chars().count() < 70);
    }

    #[test]
    fn numbers_are_shown_as_written() {
        assert_eq!(number(0.12), "0.12");
        assert_eq!(number(-9.81), "-9.81");
        assert_eq!(number(1e300), "1e300");
        assert_eq!(number(2e-5), "2e-5");
        assert_eq!(least(0.981_747_704_246_810_5), "0.9818");
        assert_eq!(
            (least(1.875), least(1.875 + 1e-15), least(9999.5)),
            ("1.875".into(), "1.875".into(), "10000".into())
        );
    }
}
