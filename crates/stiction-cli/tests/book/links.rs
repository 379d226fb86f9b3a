//! Checks that links between pages lead to existing pages and headings, and that the table of
//! contents lists every page.

use crate::{book, pages, renewed};
use std::collections::BTreeSet;
use std::fs;

/// Text of a page without its fenced blocks.
fn prose(text: &str) -> String {
    let mut fenced = false;
    let mut prose = String::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            prose.push_str(line);
            prose.push('\n');
        }
    }
    prose
}

/// Anchor of a heading.
fn anchor(heading: &str) -> String {
    let heading = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// Headings of a page, as anchors.
fn anchors(text: &str) -> BTreeSet<String> {
    prose(text).lines().filter(|line| line.starts_with('#')).map(anchor).collect()
}

/// Targets of links and pictures.
fn targets(text: &str) -> Vec<String> {
    let prose = prose(text);
    let ends = prose.match_indices("](").map(|(at, mark)| &prose[at + mark.len()..]);
    ends.filter_map(|rest| rest.split_once(')')).map(|(target, _)| target.to_owned()).collect()
}

#[test]
fn links_have_targets() {
    let mut broken = Vec::new();
    let readme = book().join("../../README.md");
    for page in pages().into_iter().chain([readme]) {
        let text = fs::read_to_string(&page).unwrap();
        for target in targets(&text) {
            // Pictures may not be written yet.
            if target.starts_with("http") || renewed() && target.starts_with("pictures/") {
                continue;
            }
            let (file, heading) = target.split_once('#').unwrap_or((&target, ""));
            let path = if file.is_empty() { page.clone() } else { page.with_file_name(file) };
            let found = fs::read(&path).is_ok_and(|bytes| {
                heading.is_empty() || anchors(&String::from_utf8_lossy(&bytes)).contains(heading)
            }) || path.is_dir() && heading.is_empty();
            if !found {
                broken.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn every_page_is_in_the_contents() {
    let contents = targets(&fs::read_to_string(book().join("SUMMARY.md")).unwrap());
    let names = pages().into_iter().map(|page| page.file_name().unwrap().to_owned());
    let lost: Vec<_> = names
        .filter(|name| name != "SUMMARY.md" && !contents.iter().any(|entry| **entry == **name))
        .collect();
    assert!(lost.is_empty(), "{lost:?}");
}

#[test]
fn anchors_are_those_of_the_renderer() {
    assert_eq!(anchor("## What `check` says, and why"), "what-check-says-and-why");
    assert_eq!(targets("[a](b.md#c) and ![d](e.svg)\n```\n[f](g)\n```\n"), ["b.md#c", "e.svg"]);
}
