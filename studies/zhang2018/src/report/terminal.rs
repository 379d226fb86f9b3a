//! Findings of a report for a terminal.

use super::markup::plain;
use super::{Block, Report};
use std::fmt;

/// Line width in columns.
const WIDTH: usize = 100;
/// Indentation of the text after the verdict.
const INDENT: &str = "          ";

impl Report {
    /// Writes the title and the findings of each section.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn write_findings(&self, out: &mut impl fmt::Write) -> fmt::Result {
        writeln!(out, "{}", self.title)?;
        for (k, section) in self.sections.iter().enumerate() {
            let findings = section.blocks.iter().filter_map(|block| match block {
                Block::Finding(finding, text) => Some((finding, text)),
                _ => None,
            });
            let mut has_title = false;
            for (finding, text) in findings {
                if !has_title {
                    writeln!(out, "\n{}. {}", k + 1, section.title)?;
                    has_title = true;
                }
                let label = format!("  {:<8}", finding.word());
                let options =
                    textwrap::Options::new(WIDTH).initial_indent(&label).subsequent_indent(INDENT);
                writeln!(out, "{}", textwrap::fill(&plain(text), options))?;
            }
        }
        Ok(())
    }
}
