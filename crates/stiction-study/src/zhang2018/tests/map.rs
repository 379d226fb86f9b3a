use crate::zhang2018::sections::map::rows;

/// Every row's test is there; that its function is there the compiler knows.
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
    // Paths are those of the source.
    for row in &rows {
        let last = row.function.rsplit("::").next().unwrap();
        assert!(last.chars().all(|c| c.is_ascii_lowercase() || c == '_'), "{}", row.function);
    }
}

/// All numbered equations of the paper are there.
#[test]
fn no_equation_is_missing() {
    let mut numbers = std::collections::BTreeSet::new();
    for row in rows() {
        let mut found = Vec::new();
        for word in row.equation.split(|c: char| !c.is_ascii_digit()) {
            found.extend(word.parse::<u32>());
        }
        match (row.equation.contains('–'), found.as_slice()) {
            (true, [first, last]) => numbers.extend(*first..=*last),
            _ => numbers.extend(found),
        }
    }
    let missing: Vec<u32> = (1..=29).filter(|number| !numbers.contains(number)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}
