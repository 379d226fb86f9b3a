//! Interrupted runs resume at the instant of the interruption.

#[cfg(unix)]
use crate::forward::FILES;
use crate::program::Folder;
#[cfg(unix)]
use crate::program::{Said, column, json};

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
fn ctrl_c_keeps_what_is_done() {
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

/// A resumed run equals an uninterrupted one: digit by digit with given efforts, and to rounding
/// with controllers, whose internal model is assembled anew.
#[cfg(unix)]
#[test]
fn an_interrupted_run_goes_on_as_if_it_had_not_been() {
    let cases: [(&[&str], f64); 2] = [
        (&["four-bar", "--drives", "A = 2 N m*sin(9*t)", "--from", "rest", "--step", "0.002"], 0.0),
        // Effort divided by stiffness, 1e-13 of 100 N by 1e4 N/m, and its effect on the integrator.
        (&["--controller", "pd", "--drives", "inverse", "--step", "0.002"], 1e-9),
    ];
    for (index, (case, tolerance)) in cases.into_iter().enumerate() {
        let until = ["--until", if index == 0 { "2" } else { "0.4" }, "-o", "."];
        let folder = |name: &str| Folder::new(&format!("forward-resume-{index}-{name}"));
        let all = |more: &[&'static str]| [&["forward"][..], case, &until, more].concat();
        let whole = folder("whole");
        whole.stiction(&all(&[])).succeeds();
        for way in ["interrupted", "killed"] {
            let parted = folder(way);
            let mut child = begin(&parted, &all(&["--checkpoint", "0"]));
            if way == "killed" {
                child.kill().unwrap();
            } else {
                interrupt(&child);
            }
            child.wait().unwrap();
            let said = parted.stiction(&all(&["--resume"]));
            said.succeeds();
            assert_eq!(parted.files(), whole.files(), "{way}");
            for name in FILES.iter().filter(|name| name.ends_with(".csv")) {
                let (a, b) = (whole.read(name), parted.read(name));
                assert_eq!(a.lines().count(), b.lines().count(), "{way} {name}");
                if tolerance == 0.0 {
                    assert!(a == b, "{way} {name}");
                } else if *name == "forward.csv" {
                    for column_name in a.lines().next().unwrap().split(',') {
                        if !column_name.contains(".position") && !column_name.contains(".wanted") {
                            continue;
                        }
                        let (a, b) = (column(&a, column_name), column(&b, column_name));
                        let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                        assert!(apart < tolerance, "{way} {column_name}: {apart:e}");
                    }
                }
            }
            let part =
                |folder: &Folder, name: &str| json(&folder.read("summary.json"))[name].clone();
            assert_eq!(part(&parted, "events"), part(&whole, "events"), "{way}");
        }
    }
}

#[test]
fn what_cannot_go_on_is_told() {
    let folder = Folder::new("forward-resume-wrong");
    folder.stiction(&["forward", "--resume"]).fails(2, &["--output"]);
    folder.stiction(&["forward", "--resume", "-o", "."]).fails(2, &["no checkpoint.json"]);
    folder.write("checkpoint.json", "{");
    let resume = ["forward", "--resume", "-o", "."];
    folder.stiction(&resume).fails(2, &["is damaged: it is no JSON any more (line 1)"]);
    folder.write("checkpoint.json", "{}");
    folder.stiction(&resume).fails(2, &["is damaged: it does not say of which simulation it is"]);
    folder.write("checkpoint.json", "{\"fingerprint\": \"12\"}");
    folder.stiction(&["forward", "--resume", "-o", "."]).fails(2, &["of another simulation"]);
    folder
        .stiction(&["forward", "--checkpoint", "-1", "-o", "."])
        .fails(2, &["--checkpoint is -1 s"]);
}
