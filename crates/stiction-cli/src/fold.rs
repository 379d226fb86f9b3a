//! Line breaks in text for the terminal.

/// Maximum width of a line, columns.
const WIDTH: usize = 100;

/// Breaks long lines between words, but not between a number and its unit. Continuation lines are
/// indented by two more columns. A line that contains two adjacent blanks is taken for a row of a
/// table and stays unbroken.
pub(crate) fn folded(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let (line, end) = line.strip_suffix('\n').map_or((line, ""), |line| (line, "\n"));
        let content = line.trim_start();
        let indent = " ".repeat(line.len() - content.len() + 2);
        if content.contains("  ") {
            out.push_str(line);
        } else {
            let options =
                textwrap::Options::new(WIDTH).subsequent_indent(&indent).break_words(false);
            out.push_str(&untied(&textwrap::fill(&joined(line), options)));
        }
        out.push_str(end);
    }
    out
}

/// Breaks a text between words into lines. The first line begins with `first`, all other lines with
/// `indent`.
pub(crate) fn folded_as(text: &str, first: &str, indent: &str) -> String {
    let options = textwrap::Options::new(WIDTH).initial_indent(first).subsequent_indent(indent);
    textwrap::fill(text, options)
}

/// Breaks long messages of diagnostics and their help texts; quoted lines of the model file stay
/// unbroken.
pub(crate) fn folded_diagnostics(text: &str) -> String {
    let plain = |line: &str| -> String {
        // Escape sequences of colours end with `m`.
        let mut pieces = line.split('\u{1b}');
        let first = pieces.next().unwrap_or_default().to_owned();
        pieces.fold(first, |all, piece| all + piece.split_once('m').map_or("", |(_, rest)| rest))
    };
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let content = line.trim_end_matches('\n');
        let bare = plain(content);
        let indent = match (bare.find("= help: "), bare.find("]: ")) {
            (Some(at), _) if bare[..at].trim().is_empty() => at + "= help: ".len(),
            (_, Some(_)) if bare.starts_with("error[") || bare.starts_with("warning[") => 2,
            _ => 0,
        };
        if indent == 0 || bare.chars().count() <= WIDTH {
            out.push_str(line);
            continue;
        }
        let blanks = " ".repeat(indent);
        let options = textwrap::Options::new(WIDTH).subsequent_indent(&blanks).break_words(false);
        out.push_str(&untied(&textwrap::fill(&joined(content), options)));
        out.push_str(&line[content.len()..]);
    }
    out
}

/// No-break space; it temporarily replaces each blank at which a line must not be broken.
const TIE: &str = "\u{a0}";
/// No-break hyphen; it replaces the hyphens of a path.
const HYPHEN: &str = "\u{2011}";

/// Replaces no-break spaces and hyphens by plain ones.
fn untied(text: &str) -> String {
    text.replace(TIE, " ").replace(HYPHEN, "-")
}

/// Joins a number by no-break spaces to the following one or two words of up to three letters, such
/// as `N m` or `%`, and the parts of a path at its hyphens.
fn joined(line: &str) -> String {
    let mut out = String::with_capacity(line.len());
    let mut tied = 0;
    for (k, word) in line.split(' ').enumerate() {
        tied = if word.len() <= 3 { tied } else { 0 };
        if k > 0 {
            out.push_str(if tied > 0 { TIE } else { " " });
        }
        match word.contains('/') {
            true => out.push_str(&word.replace('-', HYPHEN)),
            false => out.push_str(word),
        }
        let is_number = word.ends_with(|c: char| c.is_ascii_digit());
        tied = if is_number { 2 } else { usize::saturating_sub(tied, 1) };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{folded, folded_diagnostics};

    #[test]
    fn help_of_diagnostics_is_broken_and_shown_text_is_not() {
        let long = "word ".repeat(30);
        let text = format!("error[x]: {long}\n  --> a.toml:1:1\n12 | {long}\n   = help: {long}\n");
        let folded = folded_diagnostics(&text);
        let shown = format!("12 | {long}");
        for line in folded.lines().filter(|line| *line != shown) {
            assert!(line.chars().count() <= 100, "{line}");
        }
        assert!(folded.contains(&shown));
        assert!(folded.contains("\n           word"), "{folded}");
    }

    #[test]
    fn long_lines_are_broken_between_words() {
        let sentence = "  12 words of seven".to_owned() + &" letters".repeat(20) + "\nshort\n";
        let lines: Vec<String> = folded(&sentence).lines().map(str::to_owned).collect();
        assert_eq!(lines.len(), 3, "{lines:?}");
        assert!(lines.iter().all(|line| line.len() <= 100), "{lines:?}");
        assert!(lines[1].starts_with("    letters"), "{lines:?}");
        assert_eq!(folded(&sentence).replace("\n    ", " "), sentence);
        let number = "x".repeat(90) + " of 12.5 N m in all";
        assert_eq!(folded(&number), "x".repeat(90) + " of\n  12.5 N m in all");
        let path = "x".repeat(90) + " out/space-error.svg";
        assert_eq!(folded(&path), "x".repeat(90) + "\n  out/space-error.svg");
        let row = "leg1.P  ".repeat(20);
        assert_eq!(folded(&row), row);
    }
}
