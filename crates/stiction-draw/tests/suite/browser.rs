//! Tests of the page frame in a browser, and of the browser checks themselves.

use crate::chromium::{Browser, look_at};
use stiction_draw::figure::{Figure, Line, Panel};
use stiction_draw::page::{Column, page, table};

#[test]
fn a_page_with_a_table_and_a_plot() {
    let line = |label: &str, colour| Line {
        label: label.into(),
        points: (0..=50).map(f64::from).map(|t| (t, (0.1 * t + colour as f64).sin())).collect(),
        colour,
        dashed: colour == 1,
    };
    let lines = vec![line("leg 1", 0), line("leg 2", 1)];
    let figure = Figure {
        title: "Forces".into(),
        x_label: "time [s]".into(),
        panels: vec![Panel { y_label: "force [N]".into(), lines, ..Panel::default() }],
    };
    let head = [("joint".to_owned(), Column::Text), ("force [N]".to_owned(), Column::Number)];
    let rows = [["leg1.P", "310"], ["leg2.P", "-12.5"]].map(|row| row.map(str::to_owned).to_vec());
    let inner =
        format!("<h1>A page</h1><p>Text</p>{}{}", table(&head, &rows), figure.inline("Forces"));
    let style = "figure,.wide{overflow-x:auto}.curves{min-width:34rem}.legend{list-style:none}.legend svg{width:2rem}";
    look_at("frame", &page("A page", style, &inner));
}

/// The browser checks detect every kind of defect.
#[test]
fn defects_of_a_page_are_detected() {
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
    let defects = browser.defects("bad", html, None).join("\n");
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
