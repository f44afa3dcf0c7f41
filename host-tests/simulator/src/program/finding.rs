//! What is found in a program before it is run.

use anyhow::{Result, bail};
use serde::Serialize;
use std::fmt;

/// How much a finding weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The program can be run; where the tool goes is not touched by it.
    Warning,
    /// The program is refused.
    Error,
}

/// Something that was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Line of the file, from 1; 0 if it is about the whole.
    pub line: u32,
    /// Column in it, from 1, if one is to blame.
    pub column: Option<u32>,
    /// Its weight.
    pub severity: Severity,
    /// What it is, with the code, the value and the limit.
    pub message: String,
}

impl Finding {
    /// An error in a line.
    pub fn error(line: u32, message: impl Into<String>) -> Self {
        Self { line, column: None, severity: Severity::Error, message: message.into() }
    }

    /// A warning about a line.
    pub fn warning(line: u32, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(line, message) }
    }

    /// Whether it refuses the program.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

impl fmt::Display for Finding {
    /// `line 3, column 7: ...`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.line, self.column) {
            (0, _) => {}
            (line, None) => write!(f, "line {line}: ")?,
            (line, Some(column)) => write!(f, "line {line}, column {column}: ")?,
        }
        f.write_str(&self.message)
    }
}

/// So many findings are printed; of the others, how many there are.
pub const SHOWN: usize = 20;

/// The errors among findings as one, with the first [`SHOWN`] of them, one a line.
///
/// # Errors
/// If there are any.
pub fn refuse(findings: &[Finding]) -> Result<()> {
    let errors: Vec<&Finding> = findings.iter().filter(|finding| finding.is_error()).collect();
    let Some(first) = errors.first() else { return Ok(()) };
    if errors.len() == 1 {
        bail!("{first}");
    }
    let shown: Vec<String> =
        errors.iter().take(SHOWN).map(|finding| format!("\n  {finding}")).collect();
    let more = match errors.len() - shown.len() {
        0 => String::new(),
        more => format!("\n  and {more} more"),
    };
    bail!("{} places are refused:{}{more}", errors.len(), shown.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_list_is_cut() {
        let findings: Vec<Finding> = (1..=30).map(|line| Finding::error(line, "no")).collect();
        let text = refuse(&findings).unwrap_err().to_string();
        assert_eq!(text.lines().count(), SHOWN + 2);
        assert!(text.ends_with("and 10 more"));
    }
}
