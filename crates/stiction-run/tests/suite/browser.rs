//! Pages in a browser: nothing is fetched or run, all is there, wide or narrow, light or dark. Pictures
//! for people lie in `target/browser`.

use crate::chromium::Browser;
use crate::common::{default_job, model};
use stiction_core::dynamics::FrictionMode;
use stiction_run::check::{draw_page, examine};

/// Everything about a page that a browser can tell; `name` is that of its pictures.
#[track_caller]
fn look_at(name: &str, html: &str) {
    let Some(browser) = Browser::find() else { return };
    let defects = browser.defects(name, html);
    assert!(defects.is_empty(), "{name}:\n{}", defects.join("\n"));
}

fn check_page(name: &str) -> String {
    let model = model(name);
    let job = default_job(&model, FrictionMode::Off);
    let findings = examine(&job, |_, _, _| true).unwrap();
    draw_page(&job, &findings).unwrap().html
}

#[test]
fn a_report() {
    look_at("report", &crate::sample::report().html());
}

#[test]
fn the_study_of_the_paper() {
    let report = stiction_run::zhang2018::study(|_, _, _| true).unwrap();
    look_at("study-zhang2018", &report.html());
}

#[test]
fn pages_of_checks() {
    for name in ["zhang2018", "3rps"] {
        look_at(&format!("check-{name}"), &check_page(name));
    }
}

/// All that could be wrong is found.
#[test]
fn a_bad_page_is_found_out() {
    let Some(browser) = Browser::find() else { return };
    let html = "<!DOCTYPE html><html><head><title>bad</title><style>p{margin:0}\
         @media (prefers-color-scheme:dark){:root{background:#444;color:#666}}</style></head><body>\
         <p>some text</p><p>more text</p><p style=\"color:#999;background:#fff\">pale</p>\
         <p style=\"font-size:5px\">small</p>\
         <div style=\"width:500px\">wide</div><div style=\"height:5px;overflow:hidden\">hidden</div>\
         <figure><svg viewBox=\"0 0 9 9\" width=\"200\" height=\"200\"></svg></figure>\
         <figure><svg viewBox=\"0 0 9 9\" width=\"200\" height=\"200\"><path d=\"M0 0L9 9\" stroke=\"#ddd\"/>\
         </svg></figure><img src=\"not-there.png\" alt=\"\"/><script>console.warn('careful')</script>\
         </body></html>";
    let defects = browser.defects("bad", html).join("\n");
    for expected in [
        "360 px, light: the page is 5",
        "360 px, light: text that can hardly be read: {\"words\":\"pale\"",
        "360 px, dark: text that can hardly be read: {\"words\":\"some text\"",
        "1200 px, light: text that is too small: {\"words\":\"small\"",
        "360 px, light: cut: [\"hidden\"]",
        "1200 px, light: picture 0 is not there",
        "1200 px, light: picture 1 has lines that can hardly be seen",
        "Loading the image",
        "\"careful\"",
    ] {
        assert!(defects.contains(expected), "no `{expected}` in:\n{defects}");
    }
    assert!(!defects.contains("1200 px, light: the page is"), "{defects}");
}
