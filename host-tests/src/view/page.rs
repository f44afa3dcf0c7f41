//! A run as one page that needs nothing else: what was run, to be looked at in space and time.
//!
//! The page is put together from the files in `page/`, in the order of `SCRIPTS`: the first ones know numbers alone and are
//! tested by themselves, the last ones the page. It has no chart library: what a chart shows here is worked out from polynomials for
//! the stretch that is seen, and a library would want all of it as points.

mod head;

pub use head::{Command, Feeds, Overlay};

use self::head::Head;
use crate::lint::Place;
use anyhow::Result;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compression, write::ZlibEncoder};
use splineway_simulator::judge::Track;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{Tape, gcode};
use splineway_simulator::record::Report;
use splineway_simulator::record::recording::{Column, FINEST, Outline, Recording, SHARE};
use std::io::Write;

const FRAME: &str = include_str!("page/frame.html");
const STYLE: &str = include_str!("page/style.css");

/// The page's scripts in their order.
const SCRIPTS: [&str; 15] = [
    include_str!("page/text.js"),
    include_str!("page/decode.js"),
    include_str!("page/run.js"),
    include_str!("page/kinematics.js"),
    include_str!("page/envelope.js"),
    include_str!("page/outline.js"),
    include_str!("page/colour.js"),
    include_str!("page/camera.js"),
    include_str!("page/overlay.js"),
    include_str!("page/gesture.js"),
    include_str!("page/view.js"),
    include_str!("page/chart.js"),
    include_str!("page/lists.js"),
    include_str!("page/player.js"),
    include_str!("page/main.js"),
];

/// G-code of more bytes than this is not shown.
const MOST_SOURCE: usize = 4 << 20;
/// A line of it has so many characters at most.
const MOST_LINE: usize = 120;

/// Room for a recording, bytes: what a page may have, and what a move of a long program may have.
const ROOM: (usize, usize) = (3_000_000, 75);
/// No page has more, however long its program.
const MOST_ROOM: usize = 16 << 20;

/// Room for the recording of a program, bytes.
pub fn room(program: &dyn Tape) -> usize {
    (ROOM.1 * program.steps().count()).clamp(ROOM.0, MOST_ROOM)
}

/// What a page shows.
#[derive(Clone, Copy)]
pub struct Page<'a> {
    /// The file's name.
    pub name: &'a str,
    /// What was run, on what.
    pub program: &'a dyn Tape,
    /// Its machine.
    pub machine: &'a Machine,
    /// The programmed path.
    pub track: &'a Track,
    /// What was run.
    pub recording: &'a Recording,
    /// Figures.
    pub report: &'a Report,
    /// What the run broke.
    pub broken: &'a [String],
    /// The text of the file; none of a curve.
    pub source: &'a [u8],
    /// Feeds, cycle by cycle.
    pub feeds: &'a Feeds,
    /// Slow places.
    pub slow: &'a [Place],
    /// What the operator did.
    pub commands: &'a [Command],
    /// Other speed laws on the same path.
    pub overlays: &'a [Overlay],
}

/// Tells a page's part of the tolerance, mm: what is drawn is so near to what was run.
pub fn part(track: &Track, machine: &Machine) -> f64 {
    (SHARE * track.finest(machine.tolerance)).max(FINEST)
}

impl Page<'_> {
    /// The page.
    ///
    /// # Errors
    /// It cannot be put together.
    pub fn html(&self) -> Result<String> {
        let outline =
            Outline::new(self.track, self.machine.tolerance, part(self.track, self.machine));
        let mut columns: Vec<(String, Vec<u8>)> = Vec::new();
        let mut add = |name: String, column: &Column| columns.push((name, column.bytes().to_vec()));
        for (n, column) in self.recording.tape.columns().iter().enumerate() {
            add(format!("tape{n}"), column);
        }
        add("lines".to_owned(), &self.recording.lines);
        add("modes".to_owned(), &self.recording.modes);
        for (n, column) in outline.columns.iter().enumerate() {
            add(format!("outline{n}"), column);
        }
        add("tolerances".to_owned(), &outline.tolerances);
        add("feeds".to_owned(), self.feeds.column());
        for (n, overlay) in self.overlays.iter().enumerate() {
            add(format!("overlay{n}"), &overlay.column());
        }
        let source = self.source();
        let mut head = Head::new(self, &outline);
        head.source = source.is_some();
        head.columns = columns.iter().map(|(name, bytes)| (name.clone(), bytes.len())).collect();
        let body: Vec<u8> = columns.into_iter().flat_map(|(_, bytes)| bytes).collect();
        // A "<" could end the script, or begin a comment.
        let head = serde_json::to_string(&head)?.replace('<', "\\u003c");
        let title = self.name.replace('&', "&amp;").replace('<', "&lt;");
        let parts = [
            ("{{TITLE}}", title.as_str()),
            ("{{NAME}}", &title),
            ("{{STYLE}}", STYLE),
            ("{{HEAD}}", &head),
            ("{{BODY}}", &packed(&body)?),
            ("{{SOURCE}}", &packed(source.unwrap_or_default().as_bytes())?),
            ("{{SCRIPT}}", &SCRIPTS.concat()),
        ];
        Ok(filled(FRAME, &parts))
    }

    /// The lines of the file, if they are not too many.
    fn source(&self) -> Option<String> {
        if self.source.is_empty() || self.source.len() > MOST_SOURCE {
            return None;
        }
        let short = |line: &[u8]| {
            String::from_utf8_lossy(line).trim_end().chars().take(MOST_LINE).collect::<String>()
        };
        Some(gcode::lines(self.source).map(short).collect::<Vec<_>>().join("\n"))
    }
}

/// Compressed, as text.
fn packed(bytes: &[u8]) -> Result<String> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    Ok(STANDARD.encode(encoder.finish()?))
}

/// A text with something in the place of each name, once each: what is put in is not looked at again.
fn filled(text: &str, parts: &[(&str, &str)]) -> String {
    let first =
        parts.iter().filter_map(|(name, value)| text.find(name).map(|at| (at, *name, *value)));
    match first.min_by_key(|(at, _, _)| *at) {
        Some((at, name, value)) => {
            let rest = filled(&text[at + name.len()..], parts);
            [&text[..at], value, &rest].concat()
        }
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_in_is_not_looked_at_again() {
        let parts = [("{{A}}", "{{B}}"), ("{{B}}", "x")];
        assert_eq!(filled("-{{A}}-{{B}}-", &parts), "-{{B}}-x-");
    }

    /// Another page in the scripts or the frame would be loaded from somewhere.
    #[test]
    fn nothing_is_fetched() {
        for text in SCRIPTS.into_iter().chain([FRAME, STYLE]) {
            for word in ["http", "//cdn", "import ", "fetch(", "@import", "url("] {
                assert!(!text.contains(word), "{word} in {}", &text[..60.min(text.len())]);
            }
        }
    }
}
