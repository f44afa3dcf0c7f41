//! Files: the kind is told by the ending.

use super::finding::{Finding, refuse};
use super::tape::{Reel, Tape};
use super::tool_path::{Program, ReadOptions};
use super::{curve, gcode, poly};
use crate::input::{bytes, is_stdin};
use crate::spline::{self, SplineFile};
use anyhow::{Context, Result, bail};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// What a tool path is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// G-code.
    Gcode,
    /// Points, or a spline by items, one a line.
    Text,
    /// A spline.
    Toml,
    /// A spline or a NURBS curve.
    Json,
}

/// Kinds of tool paths by the endings of their files, in small letters, and what is in them. G-code needs no ending.
pub const KINDS: [(Kind, &[&str], &str); 4] = [
    (Kind::Gcode, &["ngc", "nc", "gcode", "gco", "g", "gc", "tap", "cnc", "mpf", "eia"], "G-code"),
    (Kind::Text, &["txt"], "poly-line, or spline of lines `point X Y [Z]`"),
    (Kind::Toml, &["toml"], "spline"),
    (Kind::Json, &["json"], "spline, or NURBS curve with weights"),
];

impl Kind {
    /// By the ending of a file's name; `None` of one that is not known.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("");
        let ending = ending.to_lowercase();
        if ending.is_empty() {
            return Some(Self::Gcode);
        }
        let mut kinds = KINDS.iter().filter(|(_, endings, _)| endings.contains(&&*ending));
        kinds.next().map(|(kind, ..)| *kind)
    }

    /// By what is in it, where there is no name: no line of G-code begins with a number, a brace or a bracket, `point` or
    /// an equation.
    pub fn guessed(bytes: &[u8]) -> Self {
        let text = String::from_utf8_lossy(&bytes[..bytes.len().min(GUESSED)]);
        let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
        let first = lines.clone().find(|line| !line.starts_with('#')).unwrap_or("");
        let number =
            |line: &str| line.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        let key = first.split('=').next().unwrap_or("").trim();
        let is_key = key.len() > 1 && key.chars().all(|c| c.is_ascii_lowercase() || c == '_');
        if first.starts_with('{') {
            Self::Json
        } else if first.contains('=') && is_key {
            Self::Toml
        } else if number(first) || lines.any(|line| line.starts_with("point ")) {
            Self::Text
        } else {
            Self::Gcode
        }
    }
}

/// So many bytes are looked at to guess what they are.
const GUESSED: usize = 4096;

/// Reads a tool path; the kind of file is told by its ending, and of standard input (`-`) by what is in it.
///
/// # Errors
/// Names the file, and the places in it that are refused ([`refuse`]).
pub fn read(path: &Path, options: ReadOptions<'_>) -> Result<Program> {
    let (program, findings) = inspect(path, options)?;
    refuse(&findings).with_context(|| path.display().to_string())?;
    Ok(program)
}

/// The same with everything there is to say of the file, errors and warnings. If there is an error among that, the
/// program must not be run: it is what is left without what was refused.
///
/// # Errors
/// The file cannot be read, or not at all be understood; only G-code is read on behind an error.
pub fn inspect(path: &Path, options: ReadOptions<'_>) -> Result<(Program, Vec<Finding>)> {
    inspect_bytes(path, &bytes(path)?, options)
}

/// The same of a file that has been read; `path` tells the kind.
///
/// # Errors
/// As [`inspect`].
pub fn inspect_bytes(
    path: &Path,
    bytes: &[u8],
    options: ReadOptions<'_>,
) -> Result<(Program, Vec<Finding>)> {
    let name = path.display();
    let text = || String::from_utf8_lossy(bytes);
    let program = match kind(path, bytes) {
        Some(Kind::Gcode) => {
            options.check_no_chords().with_context(|| format!("{name}"))?;
            return Ok(gcode::examine(bytes, options));
        }
        Some(Kind::Text) if spline::is_spline(&text()) => of_spline(&text(), "txt", options),
        Some(Kind::Text) => options.check_no_chords().and_then(|()| poly::parse(&text())),
        Some(Kind::Toml) => of_spline(&text(), "toml", options),
        Some(Kind::Json) => curve::parse_json(&text(), options),
        None => {
            let known = KINDS.map(|(_, endings, what)| format!(".{} ({what})", endings.join(" .")));
            bail!("{name}: unknown kind of file; known are {}", known.join(", "))
        }
    };
    let program = program.with_context(|| format!("{name}"))?;
    let findings = program.warnings.iter().map(|text| Finding::warning(0, text)).collect();
    Ok((program, findings))
}

/// A file in memory.
#[derive(Clone, Debug)]
pub struct Loaded {
    path: PathBuf,
    kind: Option<Kind>,
    bytes: Vec<u8>,
}

impl Loaded {
    /// A file, or standard input.
    ///
    /// # Errors
    /// As [`bytes`].
    pub fn new(path: &Path) -> Result<Self> {
        let mut bytes = bytes(path)?;
        let kind = kind(path, &bytes);
        if kind == Some(Kind::Gcode) {
            let plain = match gcode::plain(&bytes) {
                Cow::Borrowed(plain) if plain.len() == bytes.len() => None,
                plain => Some(plain.into_owned()),
            };
            bytes = plain.unwrap_or(bytes);
        }
        Ok(Self { path: path.to_owned(), kind, bytes })
    }

    /// Its text, if it has lines to speak of: a curve has none.
    pub fn lines(&self) -> &[u8] {
        let has_lines = matches!(self.kind, Some(Kind::Gcode | Kind::Text));
        if has_lines { &self.bytes } else { &[] }
    }

    /// The program in it: G-code is gone through again and again, so that its length takes no room; others are lists. With what there
    /// is to say of it: if there is an error among that, it must not be run.
    ///
    /// # Errors
    /// As [`inspect`].
    pub fn program<'a>(
        &'a self,
        options: ReadOptions<'a>,
    ) -> Result<(Box<dyn Tape + 'a>, Vec<Finding>)> {
        if self.kind == Some(Kind::Gcode) {
            options.check_no_chords().with_context(|| self.path.display().to_string())?;
            let (reel, findings) = Reel::new(&self.bytes, options);
            return Ok((Box::new(reel), findings));
        }
        let (program, findings) = inspect_bytes(&self.path, &self.bytes, options)?;
        Ok((Box::new(program), findings))
    }
}

/// What is in a file by its name, or by what is in it.
fn kind(path: &Path, bytes: &[u8]) -> Option<Kind> {
    if is_stdin(path) { Some(Kind::guessed(bytes)) } else { Kind::of(path) }
}

fn of_spline(text: &str, ending: &str, options: ReadOptions<'_>) -> Result<Program> {
    curve::parse_spline(&SplineFile::parse(text, ending)?, options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standard_input_is_told_by_what_is_in_it() {
        for (text, kind) in [
            ("G21 G90\nG1 X1 F100\n", Kind::Gcode),
            ("%\nO1 (point X)\n", Kind::Gcode),
            ("; x = 3\nG0 X1\n", Kind::Gcode),
            ("X10\n", Kind::Gcode),
            ("#5=3\nG1 X1\n", Kind::Gcode),
            ("", Kind::Gcode),
            ("# 200 2000 50000 0.05 0.001\n0 0 0 100\n", Kind::Text),
            ("-1.5 0 0 100\n", Kind::Text),
            ("# a wave\ntolerance 0.25\npoint 0 0\n", Kind::Text),
            ("# a wave\nname = \"w\"\nknots = [0]\n", Kind::Toml),
            (" {\"knots\": []}", Kind::Json),
        ] {
            assert_eq!(Kind::guessed(text.as_bytes()), kind, "{text}");
        }
        assert_eq!(Kind::of(Path::new("A.NGC")), Some(Kind::Gcode));
        assert_eq!(Kind::of(Path::new("a.xyz")), None);
    }
}
