//! Report and table of efforts of `stiction identify`.

use crate::excite::{ARM, columns, normal};
use crate::program::{Folder, json};
use std::fmt::Write as _;
use stiction_draw::viewer::SCRIPT;

const MOTION: &str = "shoulder = 40 deg*sin(2.1*t) + 20 deg*sin(4.7*t + 1); \
                      elbow = 30 deg*sin(3.3*t) + 25 deg*sin(5.9*t + 2); duration = 6 s";

/// Log of the arm with noise of 0.2 N m in its efforts.
pub(crate) fn logged(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("arm.toml", ARM);
    let run = ["inverse", "arm.toml", "--motion", MOTION, "--load", "none", "--report", "off"];
    folder.stiction(&[&run[..], &["-o", "run"]].concat()).succeeds();
    let names =
        ["time", "shoulder.position", "elbow.position", "shoulder.drive [", "elbow.drive ["];
    let table = columns(&folder.read("run/inverse.csv"), &names);
    let mut normal = normal(3);
    let mut text = "time [s],shoulder,elbow,shoulder.effort [N m],elbow.effort [N m]\n".to_owned();
    for k in 0..table[0].len() {
        let [t, q1, q2, e1, e2] = [0, 1, 2, 3, 4].map(|column| table[column][k]);
        writeln!(text, "{t},{q1},{q2},{},{}", e1 + 0.2 * normal(), e2 + 0.2 * normal()).unwrap();
    }
    folder.write("log.csv", &text);
    folder.write("options.toml", "estimate = \"friction\"\nfilter = \"10 Hz\"\n");
    folder
}

pub(crate) const IDENTIFY: [&str; 5] =
    ["identify", "arm.toml", "log.csv", "--options", "options.toml"];

/// The table of efforts agrees with the errors in the JSON, and the page shows the content of both.
#[test]
fn the_report_shows_the_data_of_the_results() {
    let folder = logged("identify-report");
    let wrong = ["--set", "joints.elbow.friction.viscous=100 N s/m", "-o", "found"];
    folder.stiction(&[&IDENTIFY[..], &wrong].concat()).succeeds();
    let result = json(&folder.read("found/identify.json"));
    let efforts = folder.read("found/efforts.csv");
    let errors = &result["predictions"][0];
    for (name, error) in errors["error_percent"].as_object().unwrap() {
        let before = errors["error_percent_of_model"][name].as_f64().unwrap();
        let parts = ["measured", "residual", "predicted_by_model"].map(|p| format!("{name}.{p}"));
        let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
        // Cells of left-out rows are empty.
        let full: Vec<&str> = efforts.lines().filter(|line| !line.contains(",,")).collect();
        let table = columns(&full.join("\n"), &parts);
        let norm =
            |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
        let size = norm(&mut table[0].iter().copied());
        let own = 100.0 * norm(&mut table[1].iter().copied()) / size;
        let prior = 100.0 * norm(&mut table[0].iter().zip(&table[2]).map(|(a, b)| a - b)) / size;
        // Rows in which either effort is empty are excluded here: at most a few percent.
        assert!((own - error.as_f64().unwrap()).abs() < 0.05 * own, "{name}: {own} {error}");
        assert!((prior - before).abs() < 0.05 * prior, "{name}: {prior} {before}");
    }
    let page = folder.read("found/report.html");
    for part in [
        "identification</title>",
        "verdict on the fit",
        "Efforts: log.csv, fitted",
        "Residuals: log.csv",
        "shoulder [N m]",
        "identified law",
        "standard deviation",
        "held at the values of the model",
        "elbow.viscous",
        "stiction identify arm.toml",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // The page shows the robot at about a hundred instants of the log.
    let film =
        page.split_once("class=\"film\">").and_then(|(_, rest)| rest.split_once("</script>"));
    let film = json(film.expect("the robot").0);
    assert_eq!(
        (&film["label"], &film["scene"]["bodies"][1]["name"]),
        (&"log.csv".into(), &"upper".into())
    );
    let rows = efforts.lines().count() - 1;
    assert!(
        (rows / 2..=600).contains(&(film["of"].as_u64().unwrap() as usize)),
        "{rows} {}",
        film["of"]
    );
    let data = page.replace(SCRIPT, "");
    assert!(!data.contains("NaN") && !efforts.contains("NaN"));
}

#[test]
fn the_report_can_be_left_out() {
    let folder = logged("identify-no-report");
    folder.stiction(&[&IDENTIFY[..], &["-o", "found", "--report", "off"]].concat()).succeeds();
    let files = Folder(folder.0.join("found")).files();
    assert_eq!(files, ["efforts.csv", "identified.toml", "identify.json"]);
    folder
        .stiction(&[&IDENTIFY[..], &["--open", "--report", "off"]].concat())
        .fails(2, &["--open opens the report"]);
}
