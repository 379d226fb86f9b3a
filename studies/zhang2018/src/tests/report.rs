use crate::report::{Block, Report};
use crate::sections::engines;
use crate::study;
use std::sync::OnceLock;

fn report() -> &'static Report {
    static REPORT: OnceLock<Report> = OnceLock::new();
    REPORT.get_or_init(|| study(|_, _, _| true).unwrap())
}

#[test]
fn has_all_parts_and_no_defects() {
    let report = report();
    assert_eq!(report.defects(), Vec::<String>::new());
    let names: Vec<&str> = report.sections.iter().map(|s| s.id.as_str()).collect();
    let expected = [
        "structure",
        "kinematics",
        "ideal-dynamics",
        "reactions",
        "friction",
        "simulation",
        "twin",
        "engines",
        "headline",
        "map",
    ];
    assert_eq!(names, expected);
    for section in &report.sections {
        let is_said = |block: &Block| matches!(block, Block::Finding(..));
        assert!(section.id == "map" || section.blocks.iter().any(is_said), "{}", section.id);
    }
}

/// No displayed value is NaN, and the page is one file of moderate size.
#[test]
fn pages_have_numbers() {
    let report = report();
    let html = report.html();
    assert!(html.len() < 3_000_000, "{}", html.len());
    roxmltree::Document::parse_with_options(
        &html,
        roxmltree::ParsingOptions { allow_dtd: true, ..roxmltree::ParsingOptions::default() },
    )
    .unwrap();
    for text in [&html, &report.markdown(), &report.json().to_string()] {
        for bad in ["NaN", ">inf<", "∞", "{}", "TODO"] {
            assert!(!text.contains(bad), "{bad}");
        }
        for number in ["18.1", "12.6", "16.5", "3.4"] {
            assert!(text.contains(number), "{number}");
        }
    }
    for (name, table) in report.tables() {
        assert!(table.lines().count() > 1, "{name} is empty");
        let is_bad = |cell: &str| ["inf", "-inf", "nan"].contains(&cell.to_lowercase().as_str());
        assert!(!table.split([',', '\n']).any(is_bad), "{name}");
    }
}

/// The study ends as interrupted at every possible stop and makes no further calls.
#[test]
fn can_be_stopped() {
    let mut asked = 0;
    study(|_, _, _| {
        asked += 1;
        true
    })
    .unwrap();
    assert!(asked > 100, "{asked}");
    for stop in [1, 2, asked / 8, asked / 2, asked - 5, asked] {
        let mut calls = 0;
        let outcome = study(|_, _, _| {
            calls += 1;
            calls < stop
        });
        assert!(outcome.is_err_and(|error| error.to_string() == "interrupted"));
        assert_eq!(calls, stop);
    }
}

/// The engine table is not empty and all its values meet the requirement.
#[test]
fn engines_agree() {
    let (header, rows) = engines::measured();
    assert!(header.len() > 5 && rows.len() >= 4, "{header:?}");
    assert!(rows.iter().all(|row| row.len() == header.len()));
    let worst = engines::worst();
    assert!(worst > 0.0 && worst <= 1e-8, "{worst}");
}
