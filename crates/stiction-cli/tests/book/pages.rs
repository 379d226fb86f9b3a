//! Execution of pages: writes their files, runs their commands, compares the output.

use crate::program::{Folder, Said};
use crate::{pictures, renewed};
use std::fs;
use std::path::Path;

/// A fenced block: its info string, its lines, and its line number.
struct Block {
    info: String,
    lines: Vec<String>,
    line: usize,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut open = false;
    for (index, line) in page.lines().enumerate() {
        match line.trim_start().strip_prefix("```") {
            Some(_) if open => open = false,
            Some(info) => {
                open = true;
                blocks.push(Block { info: info.into(), lines: Vec::new(), line: index + 1 });
            }
            None if open => blocks.last_mut().unwrap().lines.push(line.into()),
            None => {}
        }
    }
    assert!(!open, "a block is not closed");
    blocks
}

/// Runs one command of a page. `COMMAND > FILE` redirects its standard output.
fn run(folder: &Folder, command: &str) -> Said {
    let words = split(command);
    if let [command @ .., mark, file] = &words[..]
        && mark == ">"
    {
        let said = run_words(folder, command);
        folder.write(file, &said.out);
        return Said { out: String::new(), ..said };
    }
    run_words(folder, &words)
}

fn run_words(folder: &Folder, words: &[String]) -> Said {
    let ok = |out: String| Said { code: 0, out, err: String::new() };
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["stiction", ..] => folder.stiction(&words[1..]),
        ["cat", file] => ok(folder.read(file)),
        ["head", "-n", count, file] => {
            let count = count.parse().unwrap();
            ok(folder.read(file).split_inclusive('\n').take(count).collect())
        }
        ["sed", script, file] => ok(replace(script, &folder.read(file))),
        ["ls"] => ok(folder.files().join("\n")),
        ["ls", inner] => ok(Folder(folder.0.join(inner)).files().join("\n")),
        _ => panic!("a page may not run `{}`", words.join(" ")),
    }
}

/// Applies `s/OLD/NEW/` to the first match in every line, like `sed`; `; ` separates several rules.
fn replace(script: &str, text: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for rule in script.split("; ") {
        let parts: Vec<&str> = rule.split('/').collect();
        let ["s", old, new, ""] = parts[..] else { panic!("a page may not run `sed {script}`") };
        // A point matches any character, including a point.
        assert!(!old.contains(['*', '[', '^', '$', '\\']) && !new.contains(['&', '\\']), "{rule}");
        assert!(text.contains(old), "`{old}` is not there to be replaced");
        lines.iter_mut().for_each(|line| *line = line.replacen(old, new, 1));
    }
    lines.join("\n") + "\n"
}

/// Splits a command line into words; quotes of both kinds keep spaces.
fn split(command: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quote = None;
    for c in command.chars() {
        match quote {
            Some(mark) if c == mark => quote = None,
            None if c == '"' || c == '\'' => quote = Some(c),
            None if c == ' ' => words.push(String::new()),
            _ => words.last_mut().unwrap().push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// True for a line with the progress of a command, which only slow machines print.
fn is_progress(line: &str) -> bool {
    let count = line
        .rsplit_once(": ")
        .and_then(|(_, count)| count.strip_suffix(" samples").or(count.strip_suffix(" designs")));
    count
        .and_then(|count| count.split_once(" of "))
        .is_some_and(|(done, all)| [done, all].iter().all(|number| number.parse::<usize>().is_ok()))
}

/// True if the lines match the pattern.
fn matches(pattern: &[&str], found: &[&str]) -> bool {
    match pattern.split_first() {
        None => found.is_empty(),
        Some((&"...", rest)) => (0..=found.len()).any(|skip| matches(rest, &found[skip..])),
        Some((line, rest)) => found
            .split_first()
            .is_some_and(|(first, others)| line_matches(line, first) && matches(rest, others)),
    }
}

fn line_matches(pattern: &str, found: &str) -> bool {
    let (pattern, found) = (pattern.trim_end(), found.trim_end());
    match pattern.split_once("[..]") {
        None => pattern == found,
        Some((head, tail)) => found.strip_prefix(head).is_some_and(|rest| {
            let ends = rest.char_indices().map(|(k, _)| k).chain([rest.len()]);
            ends.into_iter().any(|k| line_matches(tail, &rest[k..]))
        }),
    }
}

/// Runs a page in an empty folder; returns the number of commands.
pub(crate) fn carry_out(path: &Path) -> usize {
    let name = path.file_name().unwrap().to_str().unwrap();
    let folder = Folder::new(&format!("book-{name}"));
    let mut commands = 0;
    let page = fs::read_to_string(path).unwrap();
    for block in blocks(&page) {
        let place = format!("{name}:{}", block.line);
        let (kind, rest) = block.info.split_once(' ').unwrap_or((&block.info, ""));
        match kind {
            "toml" => {
                let file = block.lines[0].strip_prefix("# ");
                let file = file.unwrap_or_else(|| panic!("{place}: the first line names the file"));
                folder.write(file, &(block.lines.join("\n") + "\n"));
            }
            "xml" => {
                let file = block.lines[0].strip_prefix("<!-- ");
                let file = file.and_then(|file| file.strip_suffix(" -->"));
                let file = file.unwrap_or_else(|| panic!("{place}: the first line names the file"));
                folder.write(file, &(block.lines.join("\n") + "\n"));
            }
            "console" => {
                let exit = rest.strip_prefix("exit=").map_or(0, |code| code.parse().unwrap());
                let mut parts: Vec<(&str, Vec<&str>)> = Vec::new();
                for line in &block.lines {
                    match line.strip_prefix("$ ") {
                        Some(command) => parts.push((command, Vec::new())),
                        None => parts.last_mut().expect("a command").1.push(line),
                    }
                }
                let last = parts.len() - 1;
                for (k, (command, expected)) in parts.iter().enumerate() {
                    let said = run(&folder, command);
                    let all = said.out.clone() + &said.err;
                    let found: Vec<&str> =
                        all.trim_end().lines().filter(|line| !is_progress(line)).collect();
                    let is_exact = !expected.iter().any(|line| line.contains("..."))
                        && !expected.iter().any(|line| line.contains("[..]"));
                    if renewed() && is_exact && !matches(expected, &found) {
                        let shown = |lines: &[&str]| format!("$ {command}\n{}\n", lines.join("\n"));
                        let text = fs::read_to_string(path).unwrap();
                        fs::write(path, text.replace(&shown(expected), &shown(&found))).unwrap();
                    } else {
                        assert!(
                            matches(expected, &found),
                            "{place}: `{command}` says\n{all}\nwhere the page has\n{}",
                            expected.join("\n")
                        );
                    }
                    assert_eq!(said.code, if k == last { exit } else { 0 }, "{place}: {all}");
                    commands += 1;
                }
            }
            _ => {}
        }
    }
    for line in page.lines() {
        if let Some(wish) = line.strip_prefix("<!-- picture ") {
            pictures::check(&folder, wish.trim_end_matches("-->").trim(), name);
        }
    }
    commands
}

/// The reader accepts every complete model on a page.
pub(crate) fn accepted(path: &Path) {
    let name = path.file_name().unwrap().to_str().unwrap();
    for block in blocks(&fs::read_to_string(path).unwrap()) {
        let text = block.lines.join("\n");
        // Other TOML files, such as controllers, are read by the commands.
        if block.info == "toml" && text.contains("gravity") {
            let model = block.lines[0].trim_start_matches("# ");
            let source = stiction_format::Source::new(model, text);
            if let Err(diagnostics) = stiction_format::read(&source, &|_| Err("no files".into())) {
                // A page may show a mistake if a command runs it.
                assert!(name == "first-robot.md", "{name}:{}: {diagnostics}", block.line);
            }
        }
    }
}

#[test]
fn patterns_match_lines() {
    assert!(matches(&["a", "...", "d"], &["a", "b", "c", "d"]));
    assert!(!matches(&["a", "...", "d"], &["a", "b"]));
    assert!(line_matches("to [..] m; to [..] of", "to 3e-16 m; to 0 of"));
    assert!(!line_matches("to [..] m", "to 3e-16 N"));
    assert!(is_progress("simulating: 46 of 1001 samples"));
    assert!(!is_progress("at 3 of 7 samples") && !is_progress("error: 3 of all samples"));
    assert_eq!(replace("s/a/b/; s/c/d/", "aac\n"), "bad\n");
    assert_eq!(split("a 'b c' \"d\""), ["a", "b c", "d"]);
}
