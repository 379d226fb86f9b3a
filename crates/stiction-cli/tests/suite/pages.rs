//! Pages of all commands in headless Chromium.
#![cfg(unix)]

use crate::chromium::person::Person;
use crate::chromium::{Browser, look_at, look_at_with_script};
use crate::identify_report::{IDENTIFY, logged};
use crate::program::Folder;
use serde_json::{Value, json};
use std::env;
use std::fs;
use std::path::Path;
use stiction_draw::viewer::SCRIPT;

/// Values of a column of a table.
pub(crate) fn column(table: &str, name: &str) -> Vec<f64> {
    let mut lines = table.lines();
    let place = lines.next().unwrap().split(',').position(|own| own == name).expect(name);
    lines.map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
}

fn shown(person: &mut Person, attribute: &str, column: &str) -> f64 {
    let cell = format!("document.querySelector('[{attribute}=\"{column}\"]').dataset.value");
    person.value(&cell).as_str().unwrap().parse().unwrap()
}

/// The report of a comparison shows both robots at the same time, with the values of both tables at
/// that time.
#[test]
fn two_runs_are_laid_over_each_other() {
    let folder = Folder::new("pages-compare");
    let options = ["compare", "3rps", "--set-b", "bodies.platform.mass = 20 kg", "-o", "out"];
    folder.stiction(&options).succeeds();
    let html = folder.read("out/report.html");
    let Some(browser) = Browser::find() else { return };
    let mut person = browser.open("compare", &html, 1000);
    let address = format!("{}#t=0.5&joint=leg2.P", person.address);
    person.go_to(&address);
    person.wait_for("document.getElementById('robot').dataset.time === '0.5'");
    let name = "leg2.P.drive [N]";
    for (side, attribute) in [("A", "data-column"), ("B", "data-other-column")] {
        let table = folder.read(&format!("out/{side}/inverse.csv"));
        let row = column(&table, "time [s]").iter().position(|t| *t == 0.5).unwrap();
        assert_eq!(shown(&mut person, attribute, name), column(&table, name)[row], "{side}");
    }
    let curves = "document.querySelectorAll('.joint-curve .line.other').length";
    assert_ne!(person.value(curves), 0);

    // The picture and the plots follow the same cursor; without the overlay, the picture differs.
    let picture = "document.querySelector('canvas').toDataURL()";
    let cursor = "document.querySelector('svg[data-left] .cursor').getAttribute('d')";
    let (mut both, before) = (person.value(picture), person.value(cursor));
    let overlay = "document.querySelector('select[aria-label=overlay]')";
    let choose = |value: &str| {
        format!(
            "(() => {{ const o = {overlay}; o.value = '{value}'; o.dispatchEvent(new Event('change')); }})()"
        )
    };
    person.value(&choose("-1"));
    assert!(person.value(picture) != both);
    assert_eq!(person.value("document.querySelector('[data-other-column]')"), Value::Null);
    assert_eq!(person.value(curves), 0);
    // The link of the page contains the choice.
    let link = person.value("location.href");
    person.go_to(link.as_str().unwrap());
    person.wait_for("document.getElementById('robot').dataset.time === '0.5'");
    assert_eq!(person.value(&format!("{overlay}.value")), "-1");
    let alone = person.value(picture);
    person.value(&choose("0"));
    both = person.value(picture);
    assert!(alone != both);
    person.value("document.querySelector('#robot input[type=range]').focus()");
    person.press("ArrowRight", 39);
    assert!(person.value(picture) != both);
    assert_ne!(person.value(cursor), before);

    // The values of both runs are downloaded as one table.
    person.value(
        "window.kept = []; URL.createObjectURL = (make => blob => { blob.text().then(text => kept.push(text)); \
         return make.call(URL, blob); })(URL.createObjectURL)",
    );
    person.value("document.querySelector('[aria-label^=\"save values\"]').click()");
    person.wait_for("kept.length === 1");
    let saved = person.value("kept[0]");
    let saved = saved.as_str().unwrap();
    assert!(saved.starts_with("run,time [s],leg2.P.drive [N]"), "{saved}");
    for side in ["A", "B"] {
        let table = folder.read(&format!("out/{side}/inverse.csv"));
        let own = saved.lines().filter(|line| line.starts_with(&format!("{side},")));
        let values: Vec<f64> =
            own.map(|line| line.split(',').nth(2).unwrap().parse().unwrap()).collect();
        assert_eq!(values, column(&table, name), "{side}");
    }
    assert!(person.noise.is_empty(), "{:?}", person.noise);
}

/// The report of a study shows the robots of its extreme designs, with the efforts that `inverse` computes for them.
#[test]
fn a_study_shows_its_extreme_designs() {
    let folder = Folder::new("pages-extremes");
    let vary = ["--vary", "crank = 180 mm..220 mm in 3", "--objective", "peak(left_motor.effort)"];
    folder.stiction(&[&["sweep", "five-bar", "-o", "out"][..], &vary].concat()).succeeds();
    for size in ["180", "220"] {
        let set = format!("crank = {size} mm");
        folder.stiction(&["inverse", "five-bar", "--set", &set, "-o", size]).succeeds();
    }
    let Some(browser) = Browser::find() else { return };
    let mut person = browser.open("extremes", &folder.read("out/report.html"), 1000);
    let texts = person.value(
        "[...document.querySelectorAll('select[aria-label=overlay] option')].map(one => one.textContent)",
    );
    assert_eq!(texts[1], "overlay: row 3: greatest peak(left_motor.effort) [N m]");
    assert_eq!(texts.as_array().unwrap().len(), 2);
    person.value(
        "(() => { const joints = document.querySelector('select[aria-label=joint]'); \
         joints.value = [...joints.options].find(one => one.textContent === 'left_motor').value; \
         joints.dispatchEvent(new Event('change')); })()",
    );
    let column_name = "left_motor.drive [N m]";
    for (attribute, size) in [("data-column", "180"), ("data-other-column", "220")] {
        let table = folder.read(&format!("{size}/inverse.csv"));
        assert_eq!(shown(&mut person, attribute, column_name), column(&table, column_name)[0]);
    }
    assert!(person.noise.is_empty(), "{:?}", person.noise);
}

/// Writes all kinds of pages into a folder with this name; returns each page with its name.
fn pages(folder: &str) -> Vec<(&'static str, String)> {
    let folder = Folder::new(folder);
    let commands: [(&str, &[&str]); 9] = [
        ("inverse", &["inverse", "3rps"]),
        ("envelope", &["inverse", "five-bar", "--load", "none", "--load", "left_crank.fz = 1 N"]),
        ("forward", &["forward", "four-bar", "--until", "0.2"]),
        ("breakaway", &["breakaway", "3rps"]),
        ("check", &["check", "zhang2018"]),
        ("compare", &["compare", "five-bar", "--set-b", "gravity = [0, 0, 0]"]),
        (
            "sweep",
            &[
                "sweep",
                "slider-crank",
                "--vary",
                "bodies.slider.mass = 1 kg..3 kg",
                "--design",
                "lhs",
                "--samples",
                "8",
                "--objective",
                "peak(A.effort)",
            ],
        ),
        ("compensate", &["compensate", "five-bar", "--controller", "pd,computed-torque"]),
        ("view", &["view", "gough"]),
    ];
    let mut pages = Vec::new();
    for (name, command) in commands {
        folder.stiction(&[command, &["-o", name]].concat()).succeeds();
        pages.push((name, folder.read(&format!("{name}/report.html"))));
    }
    let identified = logged(&format!("{}-identify", folder.0.file_name().unwrap().display()));
    identified.stiction(&[&IDENTIFY[..], &["-o", "found"]].concat()).succeeds();
    pages.push(("identify", identified.read("found/report.html")));
    pages
}

/// Every page is complete and legible on wide and narrow, light and dark screens, and in print. The
/// pages of `inverse` and `check` have their own tests.
#[test]
fn pages_of_all_commands_are_legible() {
    for (name, html) in pages("pages-legible") {
        match html.contains("class=\"film\"") {
            _ if matches!(name, "inverse" | "check") => {}
            true => look_at_with_script(name, &html, SCRIPT),
            false => look_at(name, &html),
        }
    }
}

/// The tab key visits all controls, links and scrollable parts of every kind of page in their
/// order; each of them is visible and marked while it has the focus.
#[test]
fn tab_walks_through_all_pages() {
    let Some(browser) = Browser::find() else { return };
    for (name, html) in pages("pages-tab") {
        let mut person = browser.open(&format!("tab-{name}"), &html, 1000);
        let stops = person.value(
            "(window.stops = [...document.querySelectorAll('a[href],button,input,select,summary,[tabindex=\"0\"]')] \
             .filter(one => one.checkVisibility())).length",
        );
        let stops = stops.as_u64().unwrap();
        assert!(stops > 3, "{name}: {stops}");
        for expected in 0..stops {
            person.press("Tab", 9);
            let found = person.value(
                "(() => { const one = document.activeElement, box = one.getBoundingClientRect(), style = getComputedStyle(one); \
                 return [stops.indexOf(one), box.width > 0 && box.bottom > 0 && box.top < innerHeight, \
                 one.matches(':focus-visible') && style.outlineStyle !== 'none', one.outerHTML.slice(0, 200)]; })()",
            );
            assert_eq!(found[0], json!(expected), "{name}: {}", found[3]);
            assert_eq!(
                (&found[1], &found[2]),
                (&json!(true), &json!(true)),
                "{name}: {}",
                found[3]
            );
        }
        assert!(person.noise.is_empty(), "{name}: {:?}", person.noise);
    }
}

/// The page of the playground, if it is built.
fn playground() -> Option<(&'static str, String)> {
    let playground = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../target/playground/stiction-playground.html");
    match fs::read_to_string(playground) {
        Ok(html) => Some(("playground", html)),
        Err(_) => {
            eprintln!("not examined: the playground, which `cargo xtask playground` builds");
            None
        }
    }
}

/// Serious findings of axe-core in the page.
fn serious(person: &mut Person, axe: &str) -> Vec<String> {
    person.value(&format!("void (() => {{ {axe} }}).call(window)"));
    person.value(
        "window.found = null; axe.run(document, { resultTypes: ['violations'] }).then(all => { window.found = all; }, \
         why => { window.found = { violations: [{ impact: 'critical', id: String(why), nodes: [] }] }; })",
    );
    person.wait_for("window.found !== null");
    let found = person.value(
        "found.violations.map(one => [one.impact, `${one.id}: ${one.nodes.map(n => n.html.slice(0, 160)).join(' | ')}`])",
    );
    let found = found.as_array().unwrap();
    let serious =
        found.iter().filter(|one| matches!(one[0].as_str(), Some("serious" | "critical")));
    serious.map(|one| one[1].as_str().unwrap().to_owned()).collect()
}

/// Checks that axe-core has no serious finding, for light and dark, wide and narrow pages, and with
/// a joint selected. `cargo xtask audit accessibility` installs axe-core and runs this test.
#[test]
#[ignore = "needs axe-core: cargo xtask audit accessibility"]
fn axe_finds_nothing_serious() {
    let axe = env::var("STICTION_AXE").expect("STICTION_AXE is the path of axe.min.js");
    let axe = fs::read_to_string(axe).expect("axe-core");
    let browser = Browser::find().expect("a browser");
    let mut found = Vec::new();
    for (name, html) in pages("pages-axe").into_iter().chain(playground()) {
        for (width, scheme) in [(1200, "light"), (1200, "dark"), (360, "light")] {
            let mut person = browser.open(&format!("axe-{name}-{width}-{scheme}"), &html, width);
            let preferred = json!({ "name": "prefers-color-scheme", "value": scheme });
            person.call("Emulation.setEmulatedMedia", json!({ "features": [preferred] }));
            if name == "playground" {
                person.wait_for(
                    "/: \\d+\\.\\d+ s$/.test(document.getElementById('status').textContent)",
                );
            }
            person.value(
                "(() => { const joints = document.querySelector('select[aria-label=joint]'); if (!joints) return; \
                 joints.value = '0'; joints.dispatchEvent(new Event('change')); })()",
            );
            for one in serious(&mut person, &axe) {
                found.push(format!("{name}, {width} px, {scheme}: {one}"));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
