//! The pace of a controller without a machine: so many servo cycles as the clock asks for, and a line that is served all the time.

use super::line::{Heard, Line};
use std::time::{Duration, Instant};

/// Most servo cycles that are made up for in one go, and most time that takes.
const MOST_CYCLES: u64 = 1000;
const MOST_TIME: Duration = Duration::from_millis(20);
/// Waits between looks at the clock: while something runs or is heard, and else.
const BUSY: Duration = Duration::from_micros(500);
const IDLE: Duration = Duration::from_millis(10);
/// Silence after which it waits longer, and after which a controller that is done with leaves.
const SILENCE: Duration = Duration::from_millis(500);

/// A clock, and how far the machine has got by it.
#[derive(Debug)]
pub struct Pace {
    began: Instant,
    heard: Instant,
    now: Duration,
    /// Servo cycles in a second.
    rate: f64,
    cycles: u64,
}

impl Pace {
    /// From now on, `speed` times as fast as the clock, in servo cycles of so many seconds.
    pub fn new(speed: f64, cycle: f64) -> Self {
        let began = Instant::now();
        Self { began, heard: began, now: Duration::ZERO, rate: speed / cycle, cycles: 0 }
    }

    /// Passes on what comes, and waits a little if nothing does: that stands for the time the processor has nothing to do. A byte ends
    /// it.
    pub fn hear(&mut self, line: &Line, idle: bool, mut take: impl FnMut(Heard)) {
        let wait = if idle && self.is_silent() { IDLE } else { BUSY };
        let first = line.heard().recv_timeout(wait).ok();
        for heard in first.into_iter().chain(line.heard().try_iter()) {
            self.heard = Instant::now();
            take(heard);
        }
        self.now = self.began.elapsed();
    }

    /// Time since it began, when the line was heard last.
    pub const fn now(&self) -> Duration {
        self.now
    }

    /// Whether nothing has come for a while.
    pub fn is_silent(&self) -> bool {
        self.heard.elapsed() > SILENCE
    }

    /// The servo cycles that are due.
    pub fn run(&mut self, mut cycle: impl FnMut()) {
        let target = (self.now.as_secs_f64() * self.rate) as u64;
        for _ in 0..target.saturating_sub(self.cycles).min(MOST_CYCLES) {
            // The line is served whatever planning costs: what is not made up for now is lost time.
            if self.began.elapsed() > self.now + MOST_TIME {
                break;
            }
            cycle();
        }
        self.cycles = target;
    }
}
