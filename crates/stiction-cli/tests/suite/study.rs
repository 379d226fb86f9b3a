//! The command `stiction study`.

use crate::program::Folder;
use serde_json::Value;

/// The report is complete, and standard output and files agree.
#[test]
fn the_report_is_written() {
    let folder = Folder::new("study-report");
    let said = folder.stiction(&["study", "zhang2018"]);
    let out = said.succeeds();
    assert!(out.contains("Wrong   “42 independent equations”"), "{out}");
    assert!(said.err.contains("wrote study-zhang2018/report.html"), "{}", said.err);
    assert_eq!(folder.files(), ["study-zhang2018"]);
    let inner = Folder(folder.0.join("study-zhang2018"));
    let files = inner.files();
    for ending in ["html", "md", "json", "csv", "svg"] {
        assert!(files.iter().any(|file| file.ends_with(&format!(".{ending}"))), "{files:?}");
    }
    // Files of an earlier report are removed; other files stay.
    let mut json: Value = serde_json::from_str(&inner.read("report.json")).unwrap();
    let listed = json["files"].as_array_mut().unwrap();
    listed.push("of-an-earlier-version.csv".into());
    listed.push("../mine.csv".into());
    inner.write("report.json", &json.to_string());
    inner.write("of-an-earlier-version.csv", "old");
    inner.write("mine.csv", "mine");
    folder.write("mine.csv", "mine");
    folder.stiction(&["study", "zhang2018"]).succeeds();
    let mut expected = files.clone();
    expected.push("mine.csv".into());
    expected.sort();
    assert_eq!(inner.files(), expected);
    assert_eq!(folder.files(), ["mine.csv", "study-zhang2018"]);
    // There are no partial files, and all pictures of the Markdown report exist.
    assert!(files.iter().all(|file| !file.starts_with('.')), "{files:?}");
    let markdown = inner.read("report.md");
    let shown: Vec<&str> =
        markdown.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    let shown: Vec<&str> = shown.into_iter().filter(|link| link.ends_with(".svg")).collect();
    assert!(shown.len() > 5, "{shown:?}");
    for link in shown {
        assert!(files.iter().any(|file| file == link), "{link}");
    }
    let program: Value = serde_json::from_str(&inner.read("report.json")).unwrap();
    let work = &program["tables"]["friction-work"]["rows"][0][1];
    assert!((work.as_f64().unwrap() - 2.021).abs() < 1e-3, "{work}");
}

/// With `--json`, the report is printed, and files are written only on request.
#[test]
fn programs_read_it() {
    let folder = Folder::new("study-json");
    let said = folder.stiction(&["study", "zhang2018", "--json"]);
    let value: Value = serde_json::from_str(said.succeeds()).unwrap();
    assert!(value["findings"].as_array().unwrap().len() > 10);
    // A slow machine prints progress.
    assert!(!said.err.contains("wrote") && folder.files().is_empty(), "{}", said.err);
}

#[test]
fn studies_are_listed() {
    let folder = Folder::new("study-list");
    let said = folder.stiction(&["study"]);
    assert!(said.succeeds().contains("zhang2018  a paper"), "{}", said.out);
    let said = folder.stiction(&["study", "--json"]);
    let list: Value = serde_json::from_str(said.succeeds()).unwrap();
    assert_eq!(list[0]["name"], "zhang2018");
}

#[test]
fn bad_options_are_reported() {
    let folder = Folder::new("study-bad");
    folder.write("taken", "a file");
    folder.write("mine.toml", "");
    folder
        .stiction(&["study", "zhang2081"])
        .fails(2, &["there is no study `zhang2081`", "did you mean `zhang2018`?"]);
    folder
        .stiction(&["study", "gough"])
        .fails(2, &["no study `gough`", "known studies: zhang2018"]);
    folder
        .stiction(&["study", "mine.toml"])
        .fails(2, &["not a model", "stiction inverse mine.toml"]);
    folder
        .stiction(&["study", "zhang2018", "-o", "taken"])
        .fails(2, &["-o needs a folder, but taken is a file"]);
    folder.stiction(&["study", "zhang2018", "--step", "1"]).fails(2, &["--step"]);
    folder.stiction(&["study", "-o", "x"]).fails(2, &["<NAME>"]);
    let said = folder.stiction(&["study", "nothing", "--json"]);
    assert_eq!(said.code, 2);
    let value: Value = serde_json::from_str(&said.out).unwrap();
    assert!(value["error"].to_string().contains("nothing"), "{value}");
    assert_eq!(folder.files(), ["mine.toml", "taken"]);
}
