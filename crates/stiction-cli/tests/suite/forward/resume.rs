//! Interrupted and killed runs resume exactly.

#[cfg(unix)]
use crate::forward::FILES;
use crate::program::{Folder, column};
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
    assert!(signal(child, "-INT"));
}

/// Sends a signal; returns `false` if the program has already ended.
#[cfg(unix)]
fn signal(child: &std::process::Child, signal: &str) -> bool {
    use std::process::{Command, Stdio};
    let mut kill = Command::new("kill");
    kill.args([signal, &child.id().to_string()]).stderr(Stdio::null());
    kill.status().unwrap().success()
}

/// After Ctrl-C, files are complete up to that instant, and the exit code reports the interruption.
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
    expected.extend(["path.svg", "report.html", "space-error.svg"]);
    expected.sort_unstable();
    assert_eq!(folder.files(), expected);
    let rows = |name: &str| folder.read(name).lines().count();
    assert!(rows("forward.csv") > 10);
    for name in ["bodies.csv", "energy.csv", "friction.csv", "motion.csv", "reactions.csv"] {
        assert_eq!(rows(name), rows("forward.csv"), "{name}");
    }
    assert_eq!(json(&folder.read("summary.json"))["ended"], "interrupted");
}

/// The five-bar of the gallery, whose tool picks up its part at 0.3 s and places it at 0.62 s.
fn five_bar_with_a_part() -> String {
    let text = stiction_format::gallery::get("five-bar").unwrap();
    let (before, part) = text.split_once("[[loads.payload.payload]]").unwrap();
    format!("{before}[[loads.payload.payload]]\nfrom = \"0.3 s\"\nuntil = \"0.62 s\"\n{part}")
}

/// Twelve parallelograms in a row: redundant constraints, and enough degrees of freedom for sparse
/// solutions.
#[cfg(unix)]
fn row_of_parallelograms() -> String {
    const COUNT: usize = 12;
    let friction = "friction = { mu = 0.05, radius = 0.005 }";
    let mut text = String::from("gravity = [0, 0, -9.81]\n");
    for k in 0..=COUNT {
        text +=
            &format!("[bodies.c{k}]\nmass = 1\ncom = [0, 0, 0.1]\ninertia = [1e-3, 1e-3, 1e-3]\n");
        text += &format!("[joints.g{k}]\ntype = 'R'\nfrom = 'ground'\nto = 'c{k}'\n");
        text += &format!("at = [{k}, 0, 0]\naxis = 'y'\nactuated = {}\n{friction}\n", k == 0);
    }
    for k in 0..COUNT {
        let next = k + 1;
        text +=
            &format!("[bodies.k{k}]\nmass = 1\ncom = [0.5, 0, 0]\ninertia = [1e-2, 1e-2, 1e-2]\n");
        text += &format!("[joints.p{k}]\ntype = 'R'\nfrom = 'c{k}'\nto = 'k{k}'\n");
        text += &format!("at = [0, 0, 0.2]\naxis = 'y'\n{friction}\n");
        text += &format!("[joints.q{k}]\ntype = 'R'\nfrom = 'k{k}'\nto = 'c{next}'\n");
        text += &format!("at = [1, 0, 0]\nto_at = [0, 0, 0.2]\naxis = 'y'\n{friction}\n");
    }
    text
}

/// A part is picked up and placed: the energy balance closes, and the impact is reported as an
/// event.
#[test]
fn a_part_is_picked_up_and_placed() {
    let folder = Folder::new("forward-payload");
    folder.write("pick.toml", &five_bar_with_a_part());
    let run = ["forward", "pick.toml", "--controller", "pd", "--until", "1", "-o", "."];
    folder.stiction(&run).succeeds();
    let events = folder.read("events.csv");
    assert!(events.contains("0.3,picks-up,tool,") && events.contains("0.62,places,tool,"));
    let energy = folder.read("energy.csv");
    let largest = column(&energy, "turnover [J]").into_iter().fold(0.0, f64::max);
    let lost = column(&energy, "impacts.lost [J]");
    assert!(lost.last().is_some_and(|lost| *lost > 0.1), "{lost:?}");
    assert!(column(&energy, "error [J]").iter().all(|error| error.abs() < 1e-9 * largest));
}

/// A run that was interrupted or killed resumes to files identical to those of an uninterrupted
/// run, for all inputs: efforts, controllers with their own models, prescribed motions, and both
/// methods.
#[cfg(unix)]
#[test]
fn a_resumed_run_has_the_bytes_of_an_uninterrupted_one() {
    let pid = "type = pid; period = 0; ki = 60 N m/(rad s); limit = 1.2 N m";
    let torque = "g0 = 3 N m*sin(9*t)";
    let cases: [&[&str]; 9] = [
        &["row.toml", "--drives", torque, "--from", "rest", "--step", "0.001", "--until", "0.4"],
        // A part is picked up and placed.
        &["pick.toml", "--controller", "pd", "--step", "0.002"],
        // A continuous controller with integral term and saturation, and a stop condition.
        &["four-bar", "--controller", pid, "--step", "0.0002", "--stop", "t > 0.97 s"],
        &["four-bar", "--drives", "A = 2 N m*abs(cos(3*A))", "--step", "0.0002"],
        &["four-bar", "--drives", "A = 2 N m*sin(9*t)", "--from", "rest", "--step", "0.002"],
        &["--controller", "pd", "--drives", "inverse", "--step", "0.002", "--until", "0.4"],
        &["four-bar", "--controller", "computed-torque+friction", "--step", "0.002"],
        &["five-bar", "--method", "time-stepping", "--step", "0.002"],
        &["--prescribe", "leg1.P", "--controller", "pd", "--step", "0.002", "--until", "0.4"],
    ];
    for (index, case) in cases.into_iter().enumerate() {
        let folder = |name: &str| {
            let folder = Folder::new(&format!("forward-resume-{index}-{name}"));
            folder.write("pick.toml", &five_bar_with_a_part());
            folder.write("row.toml", &row_of_parallelograms());
            folder
        };
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

/// Two hundred interruptions at random instants, also of resumed runs, by SIGINT, SIGTERM and
/// SIGKILL. Run by `cargo test -p stiction-cli -- --ignored two_hundred`.
#[cfg(unix)]
#[test]
#[ignore = "takes minutes"]
fn two_hundred_random_interruptions_change_no_byte() {
    use std::time::{Duration, Instant};
    let cases: [&[&str]; 8] = [
        &["four-bar", "--drives", "A = 2 N m*sin(9*t)", "--from", "rest", "--step", "0.0007"],
        &["--controller", "pd", "--drives", "inverse", "--step", "0.0013", "--until", "0.5"],
        &["four-bar", "--controller", "computed-torque+friction", "--step", "0.002"],
        &["five-bar", "--method", "time-stepping", "--step", "0.002"],
        &["--prescribe", "leg1.P", "--controller", "pd", "--step", "0.002", "--until", "0.5"],
        &["gough", "--controller", "computed-torque", "--step", "0.003", "--friction", "on"],
        &["slider-crank", "--drives", "none", "--from", "rest", "--friction", "on"],
        &["3rps", "--drives", "none", "--from", "rest", "--friction", "off", "--step", "0.001"],
    ];
    let mut seed = 1_u64;
    let mut random = |below: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % below
    };
    let mut interruptions = 0;
    for (index, case) in cases.into_iter().enumerate() {
        let until: &[&str] = if case.contains(&"--until") { &[] } else { &["--until", "1"] };
        let all = |more: &[&'static str]| {
            [&["forward"][..], case, until, &["-o", ".", "--checkpoint", "0"], more].concat()
        };
        let whole = Folder::new(&format!("forward-random-{index}"));
        let start = Instant::now();
        whole.stiction(&all(&[])).succeeds();
        let takes = start.elapsed().as_millis() as u64;
        let mut own = 0;
        while own < 25 {
            let parted = Folder::new(&format!("forward-random-{index}-parted"));
            loop {
                let resumes = parted.files().contains(&"checkpoint.json".to_owned());
                let run = all(if resumes { &["--resume"] } else { &[] });
                let mut child = parted.begin(&run, || true);
                std::thread::sleep(Duration::from_millis(random(takes.max(1))));
                signal(&child, ["-INT", "-TERM", "-KILL"][random(3) as usize]);
                if child.wait().unwrap().success() {
                    break;
                }
                own += 1;
            }
            for name in whole.files() {
                assert!(whole.read(&name) == parted.read(&name), "{case:?}: {name}");
            }
        }
        interruptions += own;
    }
    assert!(interruptions >= 200);
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
    folder
        .stiction(&resume)
        .fails(2, &["is damaged: it does not say which simulation it belongs to"]);
    folder.write("checkpoint.json", "{\"fingerprint\": \"12\"}");
    folder
        .stiction(&["forward", "--resume", "-o", "."])
        .fails(2, &["belongs to another simulation"]);
    folder
        .stiction(&["forward", "--checkpoint", "-1", "-o", "."])
        .fails(2, &["--checkpoint is -1 s"]);
}

#[test]
fn a_complete_run_has_nothing_to_resume() {
    let folder = Folder::new("forward-resume-complete");
    let run = ["forward", "slider-crank", "--until", "10 ms", "--report", "off", "-o", "done"];
    folder.stiction(&run).succeeds();
    let again = [&run[..], &["--resume"]].concat();
    folder.stiction(&again).fails(2, &["no checkpoint.json in", "done", "is complete"]);
}
