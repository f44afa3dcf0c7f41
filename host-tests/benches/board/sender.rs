//! A sender of grbl at the host's end of the line: it counts characters, as most do.

use anyhow::{Context, Result, bail, ensure};
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

/// Characters that may be under way: what senders assume of grbl.
const ROOM: usize = 127;
/// What a board says when it begins.
const BANNER: &str = "Grbl 1.1h ['$' for help]";
/// How long nothing may happen that is waited for.
const PATIENCE: Duration = Duration::from_secs(60);
/// How often the status is asked for.
const EVERY: Duration = Duration::from_millis(100);
/// How long a read waits.
const WAIT: Duration = Duration::from_millis(5);

/// The last status report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Status {
    /// As reported, with what follows a colon.
    pub state: String,
    /// Machine position, mm.
    pub place: Vec<f64>,
}

fn numbers(text: &str) -> Result<Vec<f64>> {
    Ok(text.split(',').map(str::parse).collect::<Result<_, _>>()?)
}

/// A sender on a line.
pub struct Sender {
    line: UnixStream,
    heard: Vec<u8>,
    /// Lines that are to be sent.
    lines: VecDeque<String>,
    /// Lengths of the lines that have not been answered.
    under_way: VecDeque<usize>,
    asked: Option<Instant>,
    /// How many reports have come.
    reports: u64,
    /// The last one.
    pub status: Status,
    /// How many banners have come.
    banners: u32,
    /// Alarms, as they are told.
    pub alarms: Vec<String>,
    /// What the last probe said: where it was tripped, mm.
    pub probed: Option<Vec<f64>>,
    /// Answers that were no `ok`.
    pub errors: Vec<String>,
}

impl Sender {
    /// Opens the line, and resets the controller, which may have said something to nobody.
    pub fn open(path: &Path) -> Result<Self> {
        let line = UnixStream::connect(path).context("the line")?;
        line.set_read_timeout(Some(WAIT))?;
        let mut sender = Self {
            line,
            heard: Vec::new(),
            lines: VecDeque::new(),
            under_way: VecDeque::new(),
            asked: None,
            reports: 0,
            status: Status::default(),
            banners: 0,
            alarms: Vec::new(),
            probed: None,
            errors: Vec::new(),
        };
        sender.reset()?;
        Ok(sender)
    }

    /// Keeps the room for lines full, takes what comes, and asks for the status now and then.
    fn listen(&mut self) -> Result<()> {
        while let Some(line) = self.lines.front()
            && self.under_way.iter().sum::<usize>() + line.len() < ROOM
        {
            self.line.write_all(format!("{line}\n").as_bytes())?;
            self.under_way.push_back(line.len() + 1);
            self.lines.pop_front();
        }
        let mut bytes = [0; 4096];
        match self.line.read(&mut bytes) {
            Ok(0) => bail!("the line is cut"),
            Ok(count) => self.heard.extend_from_slice(&bytes[..count]),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(error) => return Err(error.into()),
        }
        while let Some(end) = self.heard.iter().position(|&byte| byte == b'\n') {
            let line: Vec<u8> = self.heard.drain(..=end).collect();
            self.hear(String::from_utf8(line)?.trim())?;
        }
        if self.asked.is_none_or(|then| then.elapsed() >= EVERY) {
            self.command(b'?')?;
            self.asked = Some(Instant::now());
        }
        Ok(())
    }

    fn hear(&mut self, line: &str) -> Result<()> {
        if line == "ok" {
            self.under_way.pop_front().context("an answer to nothing")?;
        } else if line.starts_with("error:") {
            self.under_way.pop_front().context("an answer to nothing")?;
            self.errors.push(line.to_owned());
        } else if line.starts_with("ALARM:") {
            self.alarms.push(line.to_owned());
        } else if line.starts_with("Grbl") {
            // What had not been answered never will be.
            self.under_way.clear();
            self.banners += 1;
        } else if let Some(place) = line.strip_prefix("[PRB:") {
            self.probed = place.strip_suffix(":1]").map(numbers).transpose()?;
        } else if let Some(report) = line.strip_prefix('<') {
            let mut words = report.trim_end_matches('>').split('|');
            let state = words.next().context("a report without a state")?.to_owned();
            let place = words
                .find_map(|word| word.strip_prefix("MPos:"))
                .context("a report without MPos")?;
            self.status = Status { state, place: numbers(place)? };
            self.reports += 1;
        } else if !BANNER.ends_with(line) {
            // The rest of a banner that began before anybody listened says nothing; else there are messages.
            ensure!(line.starts_with('['), "the board says {line}");
        }
        Ok(())
    }

    /// Sends a command of one byte.
    pub fn command(&mut self, byte: u8) -> Result<()> {
        Ok(self.line.write_all(&[byte])?)
    }

    /// Streams lines, until all have been answered or `enough` says so of how many have been; whether all have been.
    pub fn stream(
        &mut self,
        lines: &[impl AsRef<str>],
        mut enough: impl FnMut(&mut Self, usize) -> Result<bool>,
    ) -> Result<bool> {
        self.lines = lines.iter().map(|line| line.as_ref().to_owned()).collect();
        let mut news = (0, Instant::now());
        loop {
            self.listen()?;
            let answered = lines.len() - self.lines.len() - self.under_way.len();
            if self.lines.is_empty() && self.under_way.is_empty() {
                return Ok(true);
            }
            if enough(self, answered)? {
                self.lines.clear();
                return Ok(false);
            }
            if answered != news.0 {
                news = (answered, Instant::now());
            }
            ensure!(
                news.1.elapsed() < PATIENCE,
                "no answer after {answered} lines, in {}",
                self.status.state
            );
        }
    }

    /// Waits for two reports of a state, one after another; `state` is how it begins.
    pub fn wait_for(&mut self, state: &str) -> Result<()> {
        self.wait_until(2, state, |status| status.state.starts_with(state))
    }

    /// Waits for so many reports, one after another, that are `good`.
    pub fn wait_until(
        &mut self,
        count: u32,
        what: &str,
        good: impl Fn(&Status) -> bool,
    ) -> Result<()> {
        let began = Instant::now();
        let (mut seen, mut reports) = (0, self.reports);
        while seen < count {
            self.listen()?;
            if self.reports != reports {
                reports = self.reports;
                seen = if good(&self.status) { seen + 1 } else { 0 };
            }
            // A path that has been taken whole may take a while.
            ensure!(began.elapsed() < PATIENCE, "no {what} but {:?}", self.status);
        }
        Ok(())
    }

    /// Resets the controller, and waits until it rests.
    pub fn reset(&mut self) -> Result<()> {
        // What is sent after it would be taken.
        self.lines.clear();
        self.command(0x18)?;
        let (before, began) = (self.banners, Instant::now());
        while self.banners == before {
            self.listen()?;
            ensure!(began.elapsed() < PATIENCE, "no banner, in {}", self.status.state);
        }
        Ok(())
    }
}
