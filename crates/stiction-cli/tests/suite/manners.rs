//! Shell completion and suggestions, and the width of texts on a terminal.

use crate::program::Folder;

const COMMANDS: [&str; 9] = [
    "inverse",
    "forward",
    "check",
    "compare",
    "sweep",
    "breakaway",
    "linearize",
    "identify",
    "export",
];

#[test]
fn completions_and_the_manual_page_know_all_commands() {
    let folder = Folder::new("shell");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let said = folder.stiction(&["completions", shell]);
        let script = said.succeeds();
        assert!(COMMANDS.iter().all(|command| script.contains(command)), "{shell}");
    }
    let said = folder.stiction(&["man"]);
    let page = said.succeeds();
    assert!(page.contains(".TH stiction 1"));
    for command in COMMANDS {
        assert!(page.contains(&format!("stiction\\-{command}")), "{command}");
    }
}

#[test]
fn help_has_examples_and_fits_in_a_hundred_columns() {
    let folder = Folder::new("columns");
    let texts = COMMANDS.map(|command| [command, "--help"]);
    for arguments in texts {
        let said = folder.stiction(&arguments);
        for line in said.succeeds().lines() {
            assert!(line.chars().count() <= 100, "{arguments:?}: {line}");
        }
        assert!(said.out.contains("Examples:"), "{arguments:?}");
    }
}

#[test]
fn the_first_run_is_about_the_robot() {
    let said = Folder::new("first-run").stiction(&["inverse"]);
    let first = said.succeeds().lines().chain(said.err.lines()).next().unwrap_or("");
    let both = format!("{}{}", said.err, said.out);
    assert!(both.starts_with("No model given: running `zhang2018-regular`"), "{first}");
    assert!(both.contains("three driven legs lift and tilt a"), "{both}");
}

/// Number of terminal columns of a line; combining characters have no width.
fn columns(line: &str) -> usize {
    line.chars().filter(|letter| !('\u{300}'..='\u{36f}').contains(letter)).count()
}

/// Output of commands for every built-in robot fits in a hundred columns, except the file contents
/// that `models NAME`, `schema` and `man` print.
#[test]
fn results_and_messages_of_all_robots_fit_in_a_hundred_columns() {
    let folder = Folder::new("wide");
    let fits = |arguments: &[&str]| {
        let said = folder.stiction(arguments);
        for line in said.out.lines().chain(said.err.lines()) {
            assert!(columns(line) <= 100, "{arguments:?}: {line}");
        }
    };
    for robot in stiction::gallery::names() {
        for arguments in [
            &["check", robot, "-o", "checked"] as &[&str],
            &["inverse", robot, "--step", "0.1 s", "-o", "results"],
            &["forward", robot, "--until", "10 ms", "-o", "simulated"],
            &["forward", robot, "--until", "10 ms", "--drives", "none", "--from", "rest"],
            &["breakaway", robot],
            &["linearize", robot, "--friction", "off"],
            &["compare", robot, "--step", "0.1 s", "--set-b", "gravity=[0, 0, -9]"],
            &[
                "sweep",
                robot,
                "--vary",
                "gravity.3 = -9.8..-9 in 2",
                "--objective",
                "min(distance.actuation)",
            ],
            &["excite", robot],
            &["export", robot, "--to", "c", "-o", "code", "--vectors", "1"],
            &["convert", robot, "--to", "mjcf", "-o", "robot.xml"],
            &["view", robot, "-o", "seen"],
        ] {
            fits(arguments);
        }
    }
    // For long computations, one small robot each.
    for arguments in [
        &["compensate", "five-bar", "--resolution", "0.01 deg", "--delay", "1 ms"] as &[&str],
        &["equilibrium", "four-bar"],
        &["excite", "four-bar", "--limit", "A = 20 deg"],
        &["models"],
        &["study"],
        &["inverse"],
        &["forward", "--until", "10 ms"],
        &["inverse", "five-bar", "--load", "none", "--load", "payload", "-o", "cases"],
    ] {
        fits(arguments);
    }
}

/// Tables of a robot with names of 19 letters.
#[test]
fn tables_with_long_names_fit_in_a_hundred_columns() {
    let folder = Folder::new("long-names");
    let text = stiction::gallery::get("five-bar").unwrap();
    let text = text
        .replace("left_motor", "motor_of_left_side")
        .replace("right_motor", "motor_of_right_side");
    folder.write("long.toml", &text);
    for arguments in [
        &["inverse", "long.toml"] as &[&str],
        &["forward", "long.toml", "--until", "50 ms"],
        &["breakaway", "long.toml"],
        &["compare", "long.toml", "five-bar"],
    ] {
        let said = folder.stiction(arguments);
        for line in said.succeeds().lines() {
            assert!(columns(line) <= 100, "{arguments:?}: {line}");
        }
    }
}

/// Suggestions for misspelt and abbreviated commands.
#[test]
fn misspelt_and_shortened_commands_are_suggested() {
    let folder = Folder::new("misspelt");
    for (typed, meant) in [
        ("forwrad", "forward"),
        ("equilib", "equilibrium"),
        ("identfy", "identify"),
        ("lin", "linearize"),
    ] {
        let said = folder.stiction(&[typed, "five-bar"]);
        assert!(said.err.contains(&format!("did you mean `stiction {meant}`?")), "{}", said.err);
    }
    let said = folder.stiction(&["frobnicate", "five-bar"]);
    assert!(said.err.contains("there is no command and no model `frobnicate`"), "{}", said.err);
}
