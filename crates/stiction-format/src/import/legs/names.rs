//! Names of the parts of legs: all names of a leg contain the name of the leg, such as `leg1_hip` and `leg1_knee`.

/// Names of the parts of a leg, with `{}` in place of the leg's name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pattern {
    pub(super) leg: String,
    pub(super) names: Vec<String>,
}

/// Byte positions at which the words of a name begin and end, in order. Characters other than
/// letters and digits separate words. Words also end between letters and digits, and before
/// capitals.
fn words(name: &str) -> (Vec<usize>, Vec<usize>) {
    let letters: Vec<(usize, char)> = name.char_indices().collect();
    let (mut begins, mut ends) = (Vec::new(), Vec::new());
    for (index, &(at, letter)) in letters.iter().enumerate() {
        let before = index.checked_sub(1).map(|index| letters[index].1);
        let is_edge = |one: char, other: char| {
            !one.is_alphanumeric()
                || one.is_numeric() != other.is_numeric()
                || (one.is_lowercase() && other.is_uppercase())
        };
        if letter.is_alphanumeric() && before.is_none_or(|before| is_edge(before, letter)) {
            begins.push(at);
        }
        let after = letters.get(index + 1).map(|after| after.1);
        let is_last = |after: char| !after.is_alphanumeric() || is_edge(letter, after);
        if letter.is_alphanumeric() && after.is_none_or(is_last) {
            ends.push(at + letter.len_utf8());
        }
    }
    (begins, ends)
}

/// Finds the sequences of words that occur in all names. Returns, for each sequence, the names with
/// `{}` in place of this sequence. If a name contains the sequence several times, there are two
/// patterns: `{}` replaces the first occurrence in one pattern and the last in the other.
pub(super) fn patterns(names: &[&str]) -> Vec<Pattern> {
    let Some(first) = names.first() else { return Vec::new() };
    let all: Vec<(Vec<usize>, Vec<usize>)> = names.iter().map(|name| words(name)).collect();
    let mut patterns: Vec<Pattern> = Vec::new();
    let (begins, ends) = &all[0];
    for &begin in begins {
        for &end in ends.iter().filter(|end| **end > begin) {
            let leg = &first[begin..end];
            let places = |(name, (begins, ends)): (&&str, &(Vec<usize>, Vec<usize>))| {
                let is_whole = |at: usize| begins.contains(&at) && ends.contains(&(at + leg.len()));
                let mut found =
                    name.match_indices(leg).map(|(at, _)| at).filter(|at| is_whole(*at));
                let first = found.next()?;
                Some((first, found.last().unwrap_or(first)))
            };
            let Some(places) = names.iter().zip(&all).map(places).collect::<Option<Vec<_>>>()
            else {
                continue;
            };
            for of_last in [false, true] {
                let with = |(name, &(first, last)): (&&str, &(usize, usize))| {
                    let at = if of_last { last } else { first };
                    format!("{}{{}}{}", &name[..at], &name[at + leg.len()..])
                };
                let names = names.iter().zip(&places).map(with).collect();
                let pattern = Pattern { leg: leg.to_owned(), names };
                if !patterns.contains(&pattern) {
                    patterns.push(pattern);
                }
            }
        }
    }
    patterns
}

/// Removes the leg's name and adjacent separators from a pattern.
pub(super) fn bare(pattern: &str) -> String {
    let (before, after) = pattern.split_once("{}").unwrap_or((pattern, ""));
    let is_separator = |c: char| !c.is_alphanumeric();
    let (before, after) =
        (before.trim_end_matches(is_separator), after.trim_start_matches(is_separator));
    match (before, after) {
        ("", one) | (one, "") => one.to_owned(),
        _ => format!("{before}_{after}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn legs(names: &[&str]) -> Vec<String> {
        patterns(names).into_iter().map(|pattern| pattern.leg).collect()
    }

    #[test]
    fn legs_are_whole_words_in_all_names() {
        assert_eq!(legs(&["leg1_hip", "leg1_knee"]), ["leg", "leg1", "1"]);
        assert_eq!(legs(&["hip1", "knee1"]), ["1"]);
        assert_eq!(legs(&["hipLeft", "kneeLeft"]), ["Left"]);
        assert_eq!(legs(&["hip_11", "knee_1"]), [""; 0]);
        assert_eq!(legs(&["größe", "weite"]), [""; 0]);
    }

    #[test]
    fn names_with_the_word_twice_have_two_patterns() {
        let found: Vec<Vec<String>> =
            patterns(&["a1_1", "b1"]).into_iter().map(|pattern| pattern.names).collect();
        assert_eq!(found, [["a{}_1", "b{}"], ["a1_{}", "b{}"]]);
        assert_eq!(bare("a{}_1"), "a_1");
        assert_eq!(bare("{}.rod"), "rod");
    }
}
