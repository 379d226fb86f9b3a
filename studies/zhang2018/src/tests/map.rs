use crate::sections::map::rows;

/// The test of every row exists; the compiler checks the function.
#[test]
fn every_row_has_its_target() {
    let sources = [
        ("structure", include_str!("structure.rs")),
        ("kinematics", include_str!("kinematics.rs")),
        ("ideal", include_str!("ideal.rs")),
        ("reactions", include_str!("reactions.rs")),
        ("friction", include_str!("friction.rs")),
        ("simulation", include_str!("simulation.rs")),
    ];
    let rows = rows();
    for row in &rows {
        let (file, test) = row.test;
        let source = sources.iter().find(|(name, _)| *name == file).map(|(_, source)| *source);
        let source = source.unwrap_or_else(|| panic!("{file} of {} is gone", row.equation));
        let lines: Vec<&str> = source.lines().collect();
        let at = lines.iter().position(|line| *line == format!("fn {test}() {{"));
        let at = at.unwrap_or_else(|| panic!("{test} of {} is gone", row.equation));
        assert_eq!(lines[at - 1], "#[test]", "{test} is no test");
    }
    // Paths are relative to this crate's sources.
    let here = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for row in &rows {
        let parts: Vec<&str> = row.function.split("::").collect();
        let (name, modules) = parts.split_last().unwrap();
        let modules: Vec<&str> =
            modules.iter().copied().filter(|part| part.starts_with(char::is_lowercase)).collect();
        let file = here.join(modules.join("/")).with_extension("rs");
        let source = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{file:?}: {e}"));
        assert!(source.contains(&format!("fn {name}")), "{} is not in {file:?}", row.function);
    }
}

/// The table covers all numbered equations of the paper.
#[test]
fn no_equation_is_missing() {
    let mut numbers = std::collections::BTreeSet::new();
    for row in rows() {
        // Numbers in brackets denote equations; 5.1 is a section.
        let mut found = Vec::new();
        for word in row.equation.split(|c: char| !c.is_ascii_digit()) {
            found.extend(word.parse::<u32>().ok().filter(|_| row.equation.contains('(')));
        }
        match (row.equation.contains('–'), found.as_slice()) {
            (true, [first, last]) => numbers.extend(*first..=*last),
            _ => numbers.extend(found),
        }
    }
    let missing: Vec<u32> = (1..=29).filter(|number| !numbers.contains(number)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}
