//! What `simulate` keeps of a run for a page, and the page of it.

use crate::lint::{Blame, Ledger, Listing, slow_places};
use crate::view::page::{Command, Feeds, Overlay, Page, part, room};
use anyhow::{Context, Result};
use splineway_simulator::judge::Track;
use splineway_simulator::machine::{Axis, Machine};
use splineway_simulator::program::Tape;
use splineway_simulator::record::Report;
use splineway_simulator::record::recording::Recorder;
use splineway_simulator::run::{Action, Events, Observer, Sample};
use std::path::Path;

/// Slow places that a page lists.
const PLACES: usize = 100;

/// Whether a plot is a page.
pub fn is_page(plot: &Path) -> bool {
    plot.extension().is_some_and(|ending| ending == "html")
}

/// A recorder for a page.
pub fn recorder(program: &dyn Tape, machine: &Machine, track: &Track, limits: &[Axis]) -> Recorder {
    Recorder::new(machine.cycle, part(track, machine), limits, room(program))
}

/// Finds the feeds and the slow places of a run.
pub struct Places<'a> {
    feeds: Feeds,
    blame: Blame<'a>,
}

impl<'a> Places<'a> {
    /// Of a program.
    ///
    /// # Errors
    /// The machine lacks an axis.
    pub fn new(program: &'a dyn Tape, machine: &Machine, limits: &[Axis]) -> Result<Self> {
        // Only what is said of useless lines needs their text.
        let ledger = Ledger::new(program, machine, PLACES, Listing::new(&[]))?;
        let blame = Blame::new(program, limits, machine.cycle, ledger);
        Ok(Self { feeds: Feeds::default(), blame })
    }
}

impl Observer for Places<'_> {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        self.blame.setpoint(sample)?;
        self.feeds.add(self.blame.asked());
        Ok(())
    }
}

/// A run that is over.
pub struct Recorded<'a> {
    pub file: &'a Path,
    pub source: &'a [u8],
    pub program: &'a dyn Tape,
    pub machine: &'a Machine,
    pub track: &'a Track,
    pub events: &'a Events,
    pub report: &'a Report,
    pub broken: &'a [String],
    pub overlays: &'a [Overlay],
}

impl Recorded<'_> {
    /// Writes the page.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, path: &Path, recorder: Recorder, places: Places<'_>) -> Result<()> {
        let name = self.file.file_name().unwrap_or_default().to_string_lossy();
        let slow = slow_places(places.blame);
        let recording = recorder.finish();
        let command = |(time, action): (f64, &Action)| Command { time, text: in_words(action) };
        let list = self.events.list().iter();
        let commands: Vec<Command> =
            list.map(|event| command((event.time, &event.action))).collect();
        let page = Page {
            name: if name == "-" { "standard input" } else { &name },
            program: self.program,
            machine: self.machine,
            track: self.track,
            recording: &recording,
            report: self.report,
            broken: self.broken,
            source: self.source,
            feeds: &places.feeds,
            slow: &slow,
            commands: &commands,
            overlays: self.overlays,
        };
        std::fs::write(path, page.html()?)
            .with_context(|| format!("cannot write {}", path.display()))
    }
}

/// What an operator did, as it is written in files of events as far as it has a word there.
fn in_words(action: &Action) -> String {
    use splineway::wire::Command as Wire;
    match action {
        Action::Command(Wire::FeedOverride(percent)) => format!("feed {percent} %"),
        Action::Command(Wire::RapidOverride(percent)) => format!("rapid {percent} %"),
        Action::Command(Wire::SingleBlock(on)) => {
            format!("single {}", if *on { "on" } else { "off" })
        }
        Action::Command(Wire::QuickHold) => "quick-hold".to_owned(),
        Action::Command(Wire::QuickAbort) => "quick-abort".to_owned(),
        Action::Command(Wire::CancelJog) => "jog-cancel".to_owned(),
        Action::Command(Wire::Jog(_)) => "jog".to_owned(),
        Action::Command(other) => format!("{other:?}").to_lowercase(),
        Action::Starve(seconds) => format!("starve {seconds} s"),
        Action::Seek(seek) => {
            let text = format!("{seek:?}");
            text.split([' ', '(', '{']).next().unwrap_or("").to_lowercase()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operators_are_quoted() {
        let events =
            Events::parse("0,hold\n1,resume\n2,feed,50\n3,single,on\n4,starve,1\n5,jog-cancel\n");
        let events = events.unwrap();
        let words: Vec<String> =
            events.list().iter().map(|event| in_words(&event.action)).collect();
        assert_eq!(words, ["hold", "resume", "feed 50 %", "single on", "starve 1 s", "jog-cancel"]);
    }
}
