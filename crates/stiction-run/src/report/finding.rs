//! Verdicts in a report: a statement, its meaning, and advice.

use super::html::{prose, section};

/// Verdict with an explanation of its meaning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Finding {
    class: &'static str,
    statement: String,
    meaning: String,
}

impl Finding {
    /// Creates a verdict that requires no action.
    pub(crate) fn good(statement: impl Into<String>, meaning: impl Into<String>) -> Self {
        Self { class: "good", statement: statement.into(), meaning: meaning.into() }
    }

    /// Creates a verdict that the user should consider when using the results.
    pub(crate) fn open(statement: impl Into<String>, meaning: impl Into<String>) -> Self {
        Self { class: "open", statement: statement.into(), meaning: meaning.into() }
    }

    /// Creates a verdict that requires a change.
    pub(crate) fn bad(statement: impl Into<String>, meaning: impl Into<String>) -> Self {
        Self { class: "bad", statement: statement.into(), meaning: meaning.into() }
    }

    fn markup(&self) -> String {
        let word = match self.class {
            "good" => "good",
            "open" => "note",
            _ => "caution",
        };
        format!(
            "<li class=\"{}\"><span class=\"badge\">{word}</span><div><b>{}</b><p>{}</p></div></li>\n",
            self.class,
            prose(&self.statement),
            prose(&self.meaning)
        )
    }
}

/// Returns the section with all verdicts. Verdicts that require a change come first.
pub(crate) fn findings(findings: &[Finding]) -> String {
    let of = |class: &str| -> String {
        findings.iter().filter(|one| one.class == class).map(Finding::markup).collect()
    };
    let items = ["bad", "open", "good"].map(of).concat();
    if items.is_empty() {
        return String::new();
    }
    section("Verdicts", &format!("<ul class=\"findings\">\n{items}</ul>\n"))
}
