//! Aids for the shell, and the width of texts on a terminal.

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
