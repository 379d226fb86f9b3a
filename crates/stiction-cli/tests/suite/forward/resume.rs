//! Interrupted and killed runs resume exactly.

#[cfg(unix)]
use crate::forward::FILES;
use crate::program::Folder;
#[cfg(unix)]
use crate::program::{Said, json};

/// Starts a run in a folder and waits until it has written some rows.
#[cfg(unix)]
fn begin(folder: &Folder, arguments: &[&str]) -> std::process::Child {
    let written = || {
        let sizes = std::fs::read_dir(&folder.0).unwrap().filter_map(|e| e.ok()?.metadata().ok());
        sizes.map(|m| m.len()).max().unwrap_or(0)
    };
    folder.begin(arguments, || written() >= 100_000)
}

#[cfg(unix)]
fn interrupt(child: &std::process::Child) {
    use std::process::Command;
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
}

/// Ctrl-C keeps complete files up to that instant and sets the exit code.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_finished_rows() {
    let folder = Folder::new("forward-interrupt");
    let child = begin(&folder, &["forward", "--drives", "inverse", "--until", "1000", "-o", "."]);
    interrupt(&child);
    let output = child.wait_with_output().unwrap();
    let said = Said::from(output);
    said.fails(130, &["interrupted; the results up to t = ", "--resume continues"]);
    let mut expected = FILES.to_vec();
    expected.extend(["checkpoint.json"]);
    expected.extend(["drives.svg", "energy.svg", "error.svg", "friction.svg", "motion.svg"]);
    expected.sort_unstable();
    assert_eq!(folder.files(), expected);
    let rows = |name: &str| folder.read(name).lines().count();
    assert!(rows("forward.csv") > 10);
    for name in ["bodies.csv", "energy.csv", "friction.csv", "motion.csv", "reactions.csv"] {
        assert_eq!(rows(name), rows("forward.csv"), "{name}");
    }
    assert_eq!(json(&folder.read("summary.json"))["ended"], "interrupted");
}

/// An interrupted or killed run resumes to the same bytes as an uninterrupted one for all inputs:
/// efforts, controllers with models of their own, prescribed motions, and both methods.
#[cfg(unix)]
#[test]
fn a_resumed_run_has_the_bytes_of_an_uninterrupted_one() {
    let cases: [&[&str]; 5] = [
        &["four-bar", "--drives", "A = 2 N m*sin(9*t)", "--from", "rest", "--step", "0.002"],
        &["--controller", "pd", "--drives", "inverse", "--step", "0.002", "--until", "0.4"],
        &["four-bar", "--controller", "computed-torque+friction", "--step", "0.002"],
        &["five-bar", "--method", "time-stepping", "--step", "0.002"],
        &["--prescribe", "leg1.P", "--controller", "pd", "--step", "0.002", "--until", "0.4"],
    ];
    for (index, case) in cases.into_iter().enumerate() {
        let folder = |name: &str| Folder::new(&format!("forward-resume-{index}-{name}"));
        let until: &[&str] = if case.contains(&"--until") { &[] } else { &["--until", "1"] };
        let all =
            |more: &[&'static str]| [&["forward"][..], case, until, &["-o", "."], more].concat();
        let whole = folder("whole");
        whole.stiction(&all(&[])).succeeds();
        for cause in ["interrupted", "killed"] {
            let parted = folder(cause);
            let mut child = begin(&parted, &all(&["--checkpoint", "0"]));
            if cause == "killed" {
                child.kill().unwrap();
            } else {
                interrupt(&child);
            }
            child.wait().unwrap();
            parted.stiction(&all(&["--resume"])).succeeds();
            assert_eq!(parted.files(), whole.files(), "{case:?} {cause}");
            for name in whole.files() {
                let (a, b) = (whole.read(&name), parted.read(&name));
                let line = a.lines().zip(b.lines()).position(|(a, b)| a != b);
                assert!(a == b, "{case:?} {cause}: {name} differs in line {line:?}");
            }
        }
    }
}

#[test]
fn runs_that_cannot_resume_are_reported() {
    let folder = Folder::new("forward-resume-wrong");
    folder.stiction(&["forward", "--resume"]).fails(2, &["--output"]);
    folder.stiction(&["forward", "--resume", "-o", "."]).fails(2, &["no checkpoint.json"]);
    folder.write("checkpoint.json", "{");
    let resume = ["forward", "--resume", "-o", "."];
    folder.stiction(&resume).fails(2, &["is damaged: line 1 is not valid JSON"]);
    folder.write("checkpoint.json", "{}");
    folder.stiction(&resume).fails(2, &["is damaged: it does not name its simulation"]);
    folder.write("checkpoint.json", "{\"fingerprint\": \"12\"}");
    folder
        .stiction(&["forward", "--resume", "-o", "."])
        .fails(2, &["belongs to another simulation"]);
    folder
        .stiction(&["forward", "--checkpoint", "-1", "-o", "."])
        .fails(2, &["--checkpoint is -1 s"]);
}
