//! Descriptions of statically indeterminate reaction components.

use crate::names::listed;

/// Largest number of groups of joints, and of joints in each group, that a message lists.
const LISTED: usize = 6;
const COMPONENTS: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

/// Returns the names of the statically indeterminate components of a reaction; `flags` are true for
/// determinate components.
pub(crate) fn open_components(flags: &[bool; 6]) -> Vec<&'static str> {
    let open = COMPONENTS.iter().zip(flags).filter(|(_, determined)| !**determined);
    open.map(|(component, _)| *component).collect()
}

/// Lists the joints for each set of statically indeterminate components, the largest group first,
/// for example `fz mx my of A, B, C`.
pub(crate) fn by_components(undetermined: &[(&str, Vec<&'static str>)]) -> String {
    let mut groups: Vec<(String, Vec<&str>)> = Vec::new();
    for (name, components) in undetermined {
        let components = components.join(" ");
        match groups.iter_mut().find(|(known, _)| *known == components) {
            Some((_, names)) => names.push(name),
            None => groups.push((components, vec![name])),
        }
    }
    groups.sort_by_key(|(_, names)| std::cmp::Reverse(names.len()));
    let in_words = |(components, names): &(String, Vec<&str>)| {
        format!("{components} of {}", listed(names, LISTED))
    };
    let groups_in_words: Vec<String> = groups.iter().take(LISTED).map(in_words).collect();
    groups_in_words.join("; ") + if groups.len() > LISTED { "; ..." } else { "" }
}
