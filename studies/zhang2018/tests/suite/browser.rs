//! Checks of reports in a browser: nothing is fetched or executed, and everything is visible, wide
//! or narrow, light or dark. Screenshots are written to `target/browser`.

use crate::chromium::look_at;

#[test]
fn a_report() {
    look_at("report", &crate::sample::report().html());
}

#[test]
fn the_study_of_the_paper() {
    let report = stiction_zhang2018::study(|_, _, _| true).unwrap();
    look_at("study-zhang2018", &report.html());
}
