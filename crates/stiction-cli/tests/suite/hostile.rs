//! Hostile environments: wrong encodings, folders in place of files, full disks, signals, closed
//! pipes. Files are either complete or absent, and every failure has a message.

use crate::program::{Folder, Said, json};
use std::process::{Command, Stdio};

#[test]
fn wrong_encodings_are_reported_with_a_suggestion() {
    let folder = Folder::new("hostile-encodings");
    let said = |bytes: &[u8]| {
        std::fs::write(folder.0.join("m.toml"), bytes).unwrap();
        folder.stiction(&["check", "m.toml"])
    };
    said(b"title = \"G\xfcte\"").fails(2, &["line 1 byte 11 is 0xfc", "Latin-1", "UTF-8"]);
    said(b"\xff\xfet\0i\0").fails(2, &["UTF-16", "save it as UTF-8"]);
    said(b"\x7fELF\x02\x01\0\0\xff\xff").fails(2, &["not a text file"]);
    said(b"").fails(2, &["the file is empty"]);
}

#[test]
fn a_model_may_come_through_a_pipe() {
    let folder = Folder::new("hostile-pipe");
    let text = folder.stiction(&["models", "slider-crank"]).succeeds().to_owned();
    let give = |text: &str| folder.stiction_given(&["convert", "-", "--to", "json"], text);
    let through = give(&text).succeeds().to_owned();
    let named = folder.stiction(&["convert", "slider-crank", "--to", "json"]).succeeds().to_owned();
    assert_eq!(through.replace("standard input", "slider-crank"), named);
    give(&text.replace("mass =", "masss =")).fails(2, &["--> standard input:", "unknown-key"]);
}

/// A device that accepts no data does not cause a panic in any command.
#[cfg(target_os = "linux")]
#[test]
fn closed_outputs_do_not_panic() {
    let folder = Folder::new("hostile-full");
    folder.write("wrong.toml", "masss = 1");
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for arguments in [&["check", "wrong.toml"][..], &["check", "missing.toml"], &["check", "--odd"]]
    {
        let status = folder.command(arguments).stderr(full()).status().unwrap();
        assert_eq!(status.code(), Some(2), "{arguments:?}");
    }
    let status = folder.command(&["inverse", "slider-crank"]).stderr(full()).output().unwrap();
    assert_eq!(status.status.code(), Some(0));
    for arguments in [&["models"][..], &["schema"], &["inverse", "slider-crank", "-o", "out"]] {
        let output = folder.command(arguments).stdout(full()).stderr(Stdio::piped()).output();
        let said = Said::from(output.unwrap());
        said.fails(2, &["cannot write to standard output"]);
    }
    assert_eq!(folder.files(), ["wrong.toml"], "nothing was begun that is not complete");
}

#[test]
fn failed_runs_leave_no_files() {
    let folder = Folder::new("hostile-nothing");
    folder.stiction(&["inverse", "zhang2018", "-o", "new/deeper/deepest"]).fails(1, &["singular"]);
    assert_eq!(folder.files(), Vec::<String>::new());
    folder.write("file", "hello");
    folder.stiction(&["check", "-o", "file"]).fails(2, &["-o needs a folder, but file is a file"]);
    folder
        .stiction(&["check", "-o", "file/in"])
        .fails(2, &["-o needs a folder, but file is a file"]);
    assert_eq!(folder.read("file"), "hello");
}

/// An unwritable folder is reported before a long computation.
#[test]
fn a_study_checks_its_folder_first() {
    let folder = Folder::new("hostile-study");
    std::fs::create_dir(folder.0.join("report.html")).unwrap();
    let said = folder.stiction(&["study", "zhang2018", "-o", "."]);
    said.fails(2, &["report.html", "a folder has that name"]);
    assert_eq!(said.out, "");
}

/// With `--json`, standard output is one object, even if a file cannot be written after the result
/// is known.
#[test]
fn a_result_and_an_error_are_one_object() {
    let folder = Folder::new("hostile-json");
    for (arguments, file, key) in [
        (&["inverse", "four-bar", "--report", "off"][..], "summary.json", "verdicts"),
        (&["forward", "four-bar", "--until", "0.1", "--report", "off"], "summary.json", "energy"),
        (&["breakaway", "four-bar", "--report", "off"], "breakaway.json", "drives"),
    ] {
        let results = folder.0.join(arguments[0]).join(file);
        std::fs::create_dir_all(results).unwrap();
        let said = folder.stiction(&[arguments, &["--json", "-o", arguments[0]]].concat());
        assert_eq!(said.code, 2, "{arguments:?}");
        let found = json(&said.out);
        let message = found["error"]["message"].as_str().unwrap();
        assert!(message.contains("a folder has that name"), "{message}");
        assert!(!found[key].is_null(), "{arguments:?}: {found:#}");
    }
}

#[cfg(unix)]
#[test]
fn a_link_that_leads_nowhere_is_no_file() {
    let folder = Folder::new("hostile-link");
    std::os::unix::fs::symlink("nowhere", folder.0.join("link")).unwrap();
    folder
        .stiction(&["convert", "slider-crank", "--to", "json", "-o", "link"])
        .fails(2, &["a link to a file that does not exist"]);
    assert!(folder.0.join("link").is_symlink());
}

/// Runs with a file size limit in blocks of 512 bytes; writing a larger file fails as on a full
/// disk.
#[cfg(target_os = "linux")]
fn with_little_room(folder: &Folder, blocks: usize, arguments: &[&str]) -> Said {
    let program = env!("CARGO_BIN_EXE_stiction");
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec {program:?} \"$@\"");
    let mut shell = Command::new("sh");
    shell.current_dir(&folder.0).env("NO_COLOR", "1").args(["-c", &script, "sh"]).args(arguments);
    Said::from(shell.output().unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_old_files() {
    let folder = Folder::new("hostile-disk");
    folder.write("inverse.csv", "of old");
    let run = ["inverse", "slider-crank", "--step", "0.0001", "-o"];
    with_little_room(&folder, 16, &[&run[..], &["."]].concat())
        .fails(2, &["cannot write the tables in .: ", "the folder is unchanged"]);
    with_little_room(&folder, 16, &[&run[..], &["new/deep"]].concat())
        .fails(2, &["cannot write the tables in new/deep"]);
    with_little_room(&folder, 1, &["convert", "gough", "--to", "json", "-o", "x.json"])
        .fails(2, &["cannot write ", "x.json"]);
    assert_eq!(folder.files(), ["inverse.csv"]);
    assert_eq!(folder.read("inverse.csv"), "of old");
}

/// After a failure by a full disk, the simulation resumes from its last checkpoint.
#[cfg(target_os = "linux")]
#[test]
fn a_simulation_resumes_after_a_full_disk() {
    let run = ["forward", "four-bar", "--drives", "A = 2 N m*sin(9*t)", "--from", "rest"];
    let more = ["--step", "0.002", "--until", "1", "--checkpoint", "0", "-o", "."];
    let run = [&run[..], &more].concat();
    let whole = Folder::new("hostile-disk-whole");
    whole.stiction(&run).succeeds();
    let parted = Folder::new("hostile-disk-parted");
    with_little_room(&parted, 200, &run).fails(
        2,
        &["cannot write the tables", "kept; the same command with --resume continues from there"],
    );
    // A checkpoint with a changed digit is refused.
    let kept = parted.read("checkpoint.json");
    // The first number is the format; a change of it is reported as another format.
    let numbers = kept.find("\"simulation\"").unwrap();
    let digit = numbers + kept[numbers..].find(" 0.").unwrap() + 3;
    let other = if kept[digit..].starts_with('1') { '2' } else { '1' };
    let damaged = format!("{}{other}{}", &kept[..digit], &kept[digit + 1..]);
    parted.write("checkpoint.json", &damaged);
    let resume = [&run[..], &["--resume"]].concat();
    parted.stiction(&resume).fails(2, &["checkpoint.json is damaged", "without --resume"]);
    parted.write("checkpoint.json", &kept);
    parted.stiction(&resume).succeeds();
    assert_eq!(parted.files(), whole.files());
    assert_eq!(parted.read("forward.csv"), whole.read("forward.csv"));
}

/// Starts a run and waits until its output appears.
#[cfg(unix)]
fn begin(folder: &Folder, arguments: &[&str]) -> std::process::Child {
    folder.begin(arguments, || folder.files().iter().any(|name| name.ends_with(".partial")))
}

/// A signal ends the program without partial files; the next run removes the temporary files of a
/// killed run.
#[cfg(unix)]
#[test]
fn signals_leave_no_half_files() {
    let folder = Folder::new("hostile-signals");
    let long = ["inverse", "slider-crank", "--step", "1e-7", "-o", "."];
    for signal in ["-INT", "-TERM", "-HUP"] {
        let child = begin(&folder, &long);
        let kill = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        assert!(kill.success());
        Said::from(child.wait_with_output().unwrap())
            .fails(130, &["interrupted; nothing was written"]);
        assert_eq!(folder.files(), Vec::<String>::new(), "{signal}");
    }
    let mut child = begin(&folder, &long);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(folder.files().iter().all(|name| name.ends_with(".partial")), "{:?}", folder.files());
    folder.stiction(&["inverse", "slider-crank", "-o", "."]).succeeds();
    assert!(folder.files().iter().all(|name| !name.ends_with(".partial")), "{:?}", folder.files());
}
