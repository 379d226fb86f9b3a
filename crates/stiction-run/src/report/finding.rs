//! Verdicts in a report: a statement, its meaning, and advice.

use super::html::{prose, section};
use serde_json::{Value, json};

/// Verdict with an explanation of its meaning. Each run has its own line in the statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Finding {
    pub(crate) class: &'static str,
    pub(crate) statement: String,
    pub(crate) meaning: String,
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

    /// Returns true if the verdict requires a change.
    pub(crate) fn is_bad(&self) -> bool {
        self.class == "bad"
    }

    /// Returns the word for the class of the verdict.
    fn word(&self) -> &'static str {
        match self.class {
            "good" => "good",
            "open" => "note",
            _ => "caution",
        }
    }

    /// Returns the statement in one line; the statements of several runs are separated by semicolons.
    pub(crate) fn in_one_line(&self) -> String {
        self.statement.replace('\n', "; ")
    }

    fn markup(&self) -> String {
        format!(
            "<li class=\"{}\"><span class=\"badge\">{}</span><div><b>{}</b><p>{}</p></div></li>\n",
            self.class,
            self.word(),
            prose(&self.statement).replace('\n', "<br/>"),
            prose(&self.meaning)
        )
    }
}

/// Returns the verdicts in the order of a report: those that require a change come first.
fn ordered(findings: &[Finding]) -> impl Iterator<Item = &Finding> {
    let of = |class| findings.iter().filter(move |one| one.class == class);
    ["bad", "open", "good"].into_iter().flat_map(of)
}

/// Returns the verdicts as a JSON array, in the order of a report.
pub(crate) fn findings_json(findings: &[Finding]) -> Value {
    let value = |one: &Finding| json!({ "class": one.word(), "statement": one.in_one_line(), "meaning": one.meaning });
    ordered(findings).map(value).collect()
}

/// Returns the section with all verdicts. Verdicts that require a change come first.
pub(crate) fn findings(findings: &[Finding]) -> String {
    let items: String = ordered(findings).map(Finding::markup).collect();
    if items.is_empty() {
        return String::new();
    }
    section("Verdicts", &format!("<ul class=\"findings\">\n{items}</ul>\n"))
}
