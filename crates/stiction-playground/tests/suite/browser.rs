//! The playground in headless Chromium as a person uses it. It needs `cargo xtask playground` first, which
//! needs the standard library for WebAssembly; `cargo xtask audit playground` does both.
#![cfg(unix)]

use crate::chromium::Browser;
use crate::chromium::person::Person;
use base64::prelude::{BASE64_STANDARD, Engine as _};
use serde_json::json;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use stiction_draw::page::source_of;

fn open(name: &str, width: u32) -> Option<Person> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../target/playground/stiction-playground.html");
    let Ok(html) = fs::read_to_string(file) else {
        // Not by `eprintln`, whose output is hidden for tests that pass.
        let _ = writeln!(
            std::io::stderr(),
            "the playground is not tried: `cargo xtask playground` builds it"
        );
        return None;
    };
    Some(Browser::find()?.open(name, &html, width))
}

const DONE: &str = "/: \\d+\\.\\d+ s$/.test(document.getElementById('status').textContent)";

/// Peak effort of an actuator in the summary of `inverse`.
fn peak(person: &mut Person, actuator: &str) -> f64 {
    let text = person.value("document.getElementById('summary').textContent");
    let line =
        text.as_str().unwrap().lines().find(|line| line.starts_with(actuator)).unwrap().to_owned();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

/// Beginnings of the summary lines that contain only rounding errors, and the largest permitted
/// value of each for `3rps`. Positions away from singular ones are solved until the loops close to
/// 1e-14 of the size of the robot, which is below 1 m. Powers of a few joints cancel up to some
/// tens of rounding errors, 1.1e-16 of the sum of their magnitudes each.
const ROUNDING: [(&str, f64); 2] =
    [("loop closure error ", 1e-14), ("relative power residual ", 1e-14)];

/// Removes the values that contain only rounding errors from a summary, because they differ between
/// targets, as sines and cosines do. Panics unless each occurs exactly once and is within its
/// limit.
fn without_rounding(summary: &str) -> String {
    let mut text = summary.to_owned();
    for (label, largest) in ROUNDING {
        assert_eq!(text.matches(label).count(), 1, "{label}: {text}");
        let from = text.find(label).unwrap() + label.len();
        let length = text[from..].find([' ', ';', '\n']).unwrap();
        let figure: f64 = text[from..from + length].parse().unwrap();
        assert!((0.0..=largest).contains(&figure), "{label}{figure:e}");
        text.replace_range(from..from + length, "");
    }
    text
}

/// Columns and values of the moving robot of a report.
fn values(html: &str) -> (Vec<String>, Vec<f64>) {
    let (_, film) = html.split_once("class=\"film\">").unwrap();
    let film: serde_json::Value =
        serde_json::from_str(film.split_once("</script>").unwrap().0).unwrap();
    let bytes = BASE64_STANDARD.decode(film["values"].as_str().unwrap()).unwrap();
    let doubles = bytes.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap()));
    (serde_json::from_value(film["columns"].clone()).unwrap(), doubles.collect())
}

/// Saves a picture of the page with the files of the tests, for inspection.
fn picture(person: &mut Person, name: &str) {
    // The report in the frame is drawn only after it has loaded.
    std::thread::sleep(std::time::Duration::from_millis(500));
    let found = person.call("Page.captureScreenshot", json!({}));
    let bytes = BASE64_STANDARD.decode(found["data"].as_str().unwrap()).unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pages");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join(format!("{name}.png")), bytes).unwrap();
}

#[test]
fn a_model_is_computed_changed_and_linked() {
    let Some(mut person) = open("playground", 1200) else { return };
    person.wait_for(DONE);
    let before = peak(&mut person, "leg1.P");
    // Enters a larger platform mass beside its slider, as a person would.
    person.value(
        "(() => { const row = document.querySelector('[data-key=\"bodies.platform.mass\"]'); \
         const number = row.querySelector('input[type=number]'); number.value = '11.66'; \
         number.dispatchEvent(new Event('input')); document.getElementById('status').textContent = ''; })()",
    );
    person.wait_for(DONE);
    let after = peak(&mut person, "leg1.P");
    assert!(after > before + 1.0, "{before} {after}");
    let robot =
        stiction::Robot::builtin("3rps").unwrap().with("bodies.platform.mass = 11.66 kg").unwrap();
    let expected = robot.inverse().tabulate(|_, _, _| true).unwrap();
    let shown = person.value("document.getElementById('summary').textContent");
    // Compares the numbers of the module with those of this program, as printed; only rounding may
    // differ.
    assert_eq!(without_rounding(shown.as_str().unwrap()), without_rounding(&expected.text));

    // Compares all values of the moving robot between the page and this program: sines and cosines
    // are rounded differently.
    let page = person.value("document.getElementById('page').srcdoc");
    let native = robot.inverse().report(|_, _, _| true).unwrap().page;
    let (found, wanted) = (values(page.as_str().unwrap()), values(&native));
    assert_eq!(found.0, wanted.0);
    let width = wanted.0.len();
    for (k, column) in wanted.0.iter().enumerate() {
        let of = |all: &[f64]| all.iter().skip(k).step_by(width).copied().collect::<Vec<f64>>();
        let (found, wanted) = (of(&found.1), of(&wanted.1));
        assert_eq!(found.len(), wanted.len());
        let largest = wanted.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        for (a, b) in found.iter().zip(&wanted).filter(|_| column.contains(".drive")) {
            assert!((a - b).abs() <= 1e-9 * largest, "{column}: {a} {b}");
        }
    }

    picture(&mut person, "playground");

    // An error in the text is underlined.
    person.value(
        "(() => { const t = document.getElementById('text'); t.value = t.value.replace('mass =', 'masss ='); \
         t.dispatchEvent(new Event('input')); })()",
    );
    person.wait_for("document.querySelector('#marks mark')?.textContent === 'masss'");
    picture(&mut person, "playground-mistake");
    person.value(
        "(() => { const t = document.getElementById('text'); t.value = t.value.replace('masss', 'mass'); \
         t.dispatchEvent(new Event('input')); document.getElementById('status').textContent = ''; })()",
    );
    person.wait_for(DONE);

    // The link carries the model and the changed value.
    person.value("document.getElementById('link').click()");
    person.wait_for("location.hash.startsWith('#m=')");
    let link = person.value("location.href");
    person.go_to(link.as_str().unwrap());
    person.wait_for(DONE);
    let linked = peak(&mut person, "leg1.P");
    assert!((linked - after).abs() < 1e-12, "{linked} {after}");
    let noise = std::mem::take(&mut person.noise);
    assert!(noise.iter().all(|line| line.starts_with("request: blob:")), "{noise:?}");
}

#[test]
fn every_command_answers_on_a_phone() {
    let Some(mut person) = open("playground-phone", 360) else { return };
    person.wait_for(DONE);
    for command in ["check", "forward"] {
        person.value(&format!(
            "(() => {{ const c = document.getElementById('command'); document.getElementById('until').value = '0.1'; \
             c.value = '{command}'; document.getElementById('status').textContent = ''; \
             c.dispatchEvent(new Event('change')); }})()"
        ));
        person.wait_for(&format!(
            "{DONE} && document.getElementById('status').textContent.startsWith('{command}')"
        ));
        assert_eq!(
            person.value("document.getElementById('failure').hidden"),
            json!(true),
            "{command}"
        );
        assert_eq!(
            person.value("document.getElementById('page').srcdoc.length > 1000"),
            json!(true),
            "{command}"
        );
    }
    picture(&mut person, "playground-phone");
    let wide = person.value("document.documentElement.scrollWidth > innerWidth");
    assert_eq!(wide, json!(false), "the page is wider than a phone");
}

#[test]
fn a_long_run_is_cancelled() {
    let Some(mut person) = open("playground-cancel", 1200) else { return };
    person.wait_for(DONE);
    person.value(
        "(() => { document.getElementById('live').checked = false; const c = document.getElementById('command'); \
         document.getElementById('until').value = '1000'; c.value = 'forward'; c.dispatchEvent(new Event('change')); })()",
    );
    person.wait_for("/^forward runs: \\d/.test(document.getElementById('status').textContent)");
    person.value("document.getElementById('cancel').click()");
    person.wait_for("document.getElementById('status').textContent === 'cancelled'");
    // The engine answers again.
    person.value(
        "(() => { const c = document.getElementById('command'); c.value = 'inverse'; \
         c.dispatchEvent(new Event('change')); })()",
    );
    person.wait_for(DONE);
}

/// Mesh files that a reader selects appear in the report. The page states which files are provided,
/// and which selected file the model does not name.
#[test]
fn picked_mesh_files_are_shown() {
    let Some(mut person) = open("playground-meshes", 1200) else { return };
    person.wait_for(DONE);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("picked");
    fs::create_dir_all(&folder).unwrap();
    let pyramid = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";
    let files = ["plate.obj", "other.obj"].map(|name| folder.join(name));
    files.iter().for_each(|file| fs::write(file, pyramid).unwrap());
    person.value(
        "(() => { const t = document.getElementById('text'); \
         t.value = t.value.replace('[bodies.platform]', '[bodies.platform]\\nvisual = [{ mesh = \"parts/plate.obj\", \
         scale = [0.2, 0.2, 0.2] }]'); \
         document.getElementById('status').textContent = ''; t.dispatchEvent(new Event('input')); })()",
    );
    person.wait_for(DONE);
    let told = "document.getElementById('meshed').textContent";
    assert_eq!(person.value(told), json!("0 of 1 meshes of the model are given"));
    let messages = person.value("document.getElementById('messages').textContent");
    assert!(messages.as_str().unwrap().contains("its file is not given"), "{messages}");

    person.value("document.getElementById('status').textContent = ''");
    let root = person.call("DOM.getDocument", json!({}))["root"]["nodeId"].clone();
    let field = person.call("DOM.querySelector", json!({ "nodeId": root, "selector": "#meshes" }));
    person.call(
        "DOM.setFileInputFiles",
        json!({ "nodeId": field["nodeId"], "files": files.map(|file| file.display().to_string()) }),
    );
    person.wait_for(DONE);
    assert_eq!(
        person.value(told),
        json!("1 of 1 meshes of the model are given; the model does not name other.obj")
    );
    assert_eq!(person.value("document.getElementById('messages').textContent"), json!(""));
    let page = person.value("document.getElementById('page').srcdoc");
    let page = page.as_str().unwrap();
    if page.contains("without the shaded view") {
        return;
    }
    assert!(page.contains("This page contains one mesh file, 1 kB."));
    // The policy of the page, which applies in the frame of the report, allows all scripts of the report.
    let policy = person.value("document.querySelector('meta[http-equiv]').content");
    let scripts =
        page.split("<script>").skip(1).map(|rest| rest.split("</script>").next().unwrap());
    let sources: Vec<String> = scripts.map(source_of).collect();
    assert_eq!(sources.len(), 2);
    assert!(sources.iter().all(|source| policy.as_str().unwrap().contains(source)), "{policy}");
    picture(&mut person, "playground-meshes");
    let noise = std::mem::take(&mut person.noise);
    assert!(noise.iter().all(|line| line.starts_with("request: blob:")), "{noise:?}");

    // The frame is in a separate process; when the report is opened alone, it draws the mesh.
    let mut report = Browser::find().unwrap().open("playground-meshes-report", page, 1000);
    report.wait_for("document.querySelector('canvas.shaded') !== null");
    // Without a graphics card, the WebGL driver prints a message about its speed.
    report.noise.retain(|line| !line.contains("GL Driver Message"));
    assert!(report.noise.is_empty(), "{:?}", report.noise);
}
