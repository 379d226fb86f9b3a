//! The command `stiction check`.

use crate::program::Folder;
use serde_json::Value;

#[test]
fn the_report_is_written() {
    let folder = Folder::new("check-report");
    let said = folder.stiction(&["check", "zhang2018", "-o", "new/deep"]);
    let out = said.succeeds();
    assert!(out.contains("degrees of freedom: 3"), "{out}");
    assert!(said.err.contains("wrote") && said.err.contains("report.html"), "{}", said.err);
    let inner = Folder(folder.0.join("new/deep"));
    assert_eq!(inner.files(), ["check.json", "mechanism.svg", "report.html"]);
    let page = inner.read("report.html");
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    assert!(page.contains("<svg") && page.contains("singular (actuation) in every position"));
    assert!(inner.read("mechanism.svg").starts_with("<svg xmlns="));
}

/// A body on a hinge.
const ARM: &str = "gravity = [0, 0, 0]\n[bodies.b]\nmass = 1\ncom = [0, 0, 0]\ninertia = [1, 1, 1]\n\
                   [joints.j]\ntype = \"R\"\nfrom = \"ground\"\nto = \"b\"\naxis = \"z\"\nactuated = true\n";

#[test]
fn the_json_has_all_verdicts() {
    let folder = Folder::new("check-json");
    let said = folder.stiction(&["check", "3rps", "--json", "-o", "."]);
    // The error stream may show progress on a slow machine.
    assert_eq!(said.succeeds(), folder.read("check.json"));
    assert!(!said.err.contains("CAUTION"), "{}", said.err);
    let value: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(value["mobility"]["finite"], 3);
    // The travel of all scalar coordinates, and the ranges that the model declares, of which it has none.
    let names: Vec<_> =
        value["travel"].as_array().unwrap().iter().map(|one| &one["name"]).collect();
    assert_eq!(names.len(), 6, "{names:?}");
    assert_eq!(value["ranges"], Value::Array(Vec::new()));
    let mode = &value["assembly"];
    let length = mode["coordinates"]["leg1.P"].as_f64().unwrap();
    assert!((length - 0.6427).abs() < 1e-4, "{length}");
    assert!(mode["distance"].as_f64().unwrap() > 0.01, "{mode}");
    let text = folder.stiction(&["check", "3rps"]).out;
    assert!(text.contains("assembly mode: the nearest to `home`, `start`"), "{text}");
    // An open chain has only one mode.
    folder.write("arm.toml", ARM);
    let text = folder.stiction(&["check", "arm.toml"]).succeeds().to_owned();
    assert!(!text.contains("assembly mode"), "{text}");
}

#[test]
fn impossible_folders_are_reported() {
    let folder = Folder::new("check-file");
    folder.write("taken", "a file");
    let said = folder.stiction(&["check", "four-bar", "-o", "taken"]);
    said.fails(
        2,
        &["-o needs a folder, but taken is a file", "it is created if it does not exist"],
    );
    assert_eq!(said.out, "");
    assert_eq!((folder.read("taken").as_str(), folder.files().len()), ("a file", 1));

    let inner = folder.stiction(&["check", "four-bar", "-o", "taken/inner"]);
    inner.fails(2, &["taken is a file"]);
}

#[test]
fn a_failed_run_keeps_existing_files() {
    let folder = Folder::new("check-kept");
    folder.write("report.html", "mine");
    let motion = "A = 60 deg + 100*t; duration = 1 s; step = 0 s";
    let said = folder.stiction(&["check", "four-bar", "--motion", motion, "-o", "."]);
    assert_eq!(said.code, 2, "{}", said.err);
    let said = folder.stiction(&["check", "slider-crank", "--motion", "guide = 1 m", "-o", "."]);
    assert_eq!(said.code, 1, "{}", said.err);
    assert_eq!(
        (folder.files(), folder.read("report.html").as_str()),
        (vec!["report.html".into()], "mine")
    );
}

#[test]
fn a_folder_in_place_of_a_file_is_reported() {
    let folder = Folder::new("check-in-the-way");
    std::fs::create_dir(folder.0.join("report.html")).unwrap();
    let said = folder.stiction(&["check", "four-bar", "-o", "."]);
    said.fails(2, &["cannot write", "report.html", "a folder has that name"]);
    assert_eq!((said.out.as_str(), folder.files().len()), ("", 1));
}
