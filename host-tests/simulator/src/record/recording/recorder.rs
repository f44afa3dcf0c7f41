//! Records a run in bounded memory.

use super::columns::Column;
use super::fit::{Fit, State};
use super::grain::Grain;
use super::tape::Tape;
use crate::judge::Judge;
use crate::machine::Axis;
use crate::run::{Observer, Sample};
use anyhow::Result;
use splineway::Activity;

/// Behind this level nothing gets less.
const COARSEST: usize = 24;

/// Least and greatest position, velocity, acceleration and jerk of an axis, mm and s, as they were run.
pub type Peaks = [[f64; 2]; 4];

/// What was run, servo cycle by servo cycle, within a part of the tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Axes.
    pub tape: Tape,
    /// Where another line of the file begins: cycles since the last such, and the difference of their numbers. The lines before the
    /// first are 0.
    pub lines: Column,
    /// Where activity or override change: cycles since the last such, the activity ([`activity_code`]), the override, per cent.
    pub modes: Column,
    /// Of each axis.
    pub peaks: Vec<Peaks>,
}

/// Activities by number.
pub const fn activity_code(activity: Activity) -> u8 {
    match activity {
        Activity::Running => 1,
        Activity::Dwelling => 2,
        Activity::Event => 3,
        Activity::Set => 4,
        Activity::Jogging => 5,
        // Idle, and what is to come.
        _ => 0,
    }
}

/// Records every cycle.
///
/// What is kept takes a few bytes for a change of jerk. If it takes more room than it has, it is recorded anew from what was recorded,
/// a third as fine, as often as it must.
#[derive(Debug)]
pub struct Recorder {
    room: usize,
    fit: Option<Fit>,
    /// Before the first cycle.
    grain: Grain,
    recording: Recording,
    states: Vec<State>,
    before: Vec<f64>,
    line: (u64, u32),
    mode: (u64, Option<(u8, u8)>),
    cycles: u64,
}

impl Recorder {
    /// Of runs at a servo cycle, s, which may be recorded `off` by this much, mm, as long as the `room`, bytes, does.
    pub fn new(cycle: f64, off: f64, limits: &[Axis], room: usize) -> Self {
        let grain = Grain::new(cycle, off, limits);
        let recording = Recording {
            tape: Tape::new(grain.clone(), vec![[0; 3]; limits.len()]),
            lines: Column::default(),
            modes: Column::default(),
            peaks: vec![[[f64::INFINITY, f64::NEG_INFINITY]; 4]; limits.len()],
        };
        Self {
            room,
            fit: None,
            grain,
            recording,
            states: vec![State::default(); limits.len()],
            before: vec![0.0; limits.len()],
            line: (0, 0),
            mode: (0, None),
            cycles: 0,
        }
    }

    /// What was recorded.
    pub fn finish(mut self) -> Recording {
        if let Some(fit) = &mut self.fit {
            fit.finish(&mut |_, from, span| self.recording.tape.add(from, span));
        }
        self.recording
    }

    fn peaks(&mut self, sample: &Sample<'_>, cycle: f64) {
        for (n, peaks) in self.recording.peaks.iter_mut().enumerate() {
            let acceleration = sample.acceleration[n];
            let jerk = (acceleration - self.before[n]) / cycle;
            self.before[n] = acceleration;
            let values = [sample.position[n], sample.velocity[n], acceleration, jerk];
            for (peak, value) in peaks.iter_mut().zip(values) {
                *peak = [peak[0].min(value), peak[1].max(value)];
            }
        }
    }

    fn changes(&mut self, sample: &Sample<'_>) {
        if sample.tag != self.line.1 {
            self.recording.lines.count(self.cycles - self.line.0);
            self.recording.lines.number(i64::from(sample.tag) - i64::from(self.line.1));
            self.line = (self.cycles, sample.tag);
        }
        let percent = (sample.pace.share * 100.0).round().clamp(0.0, 255.0) as u8;
        let mode = (activity_code(sample.activity), percent);
        if self.mode.1 != Some(mode) {
            self.recording.modes.count(self.cycles - self.mode.0);
            self.recording.modes.count(u64::from(mode.0));
            self.recording.modes.count(u64::from(mode.1));
            self.mode = (self.cycles, Some(mode));
        }
    }

    /// The same, a third as fine.
    fn thin(&mut self) {
        let Some(old) = self.fit.take() else { return };
        let coarse = old.grain().coarser();
        let played =
            std::mem::replace(&mut self.recording.tape, Tape::new(coarse.clone(), Vec::new()));
        let tape = &mut self.recording.tape;
        let mut fit: Option<Fit> = None;
        played.play(&mut |states, deviation| match &mut fit {
            None => {
                let first = Fit::new(coarse.clone(), states);
                *tape = Tape::new(coarse.clone(), first.from().to_vec());
                fit = Some(first);
            }
            Some(fit) => fit.push(states, deviation, &mut |_, from, span| tape.add(from, span)),
        });
        old.rest(&mut |states, deviation| {
            if let Some(fit) = &mut fit {
                fit.push(states, deviation, &mut |_, from, span| tape.add(from, span));
            }
        });
        self.fit = fit;
    }

    /// One servo cycle, with its deviation from the programmed path, mm.
    pub fn take(&mut self, sample: &Sample<'_>, deviation: f64) {
        for (n, state) in self.states.iter_mut().enumerate() {
            *state = [sample.position[n], sample.velocity[n], sample.acceleration[n]];
        }
        let tape = &mut self.recording.tape;
        match &mut self.fit {
            None => {
                let fit = Fit::new(self.grain.clone(), &self.states);
                *tape = Tape::new(self.grain.clone(), fit.from().to_vec());
                self.fit = Some(fit);
            }
            Some(fit) => {
                fit.push(&self.states, deviation, &mut |_, from, span| tape.add(from, span));
            }
        }
        self.peaks(sample, self.grain.cycle);
        self.changes(sample);
        self.cycles += 1;
        while self.recording.tape.weight() > self.room && self.recording.tape.grain.level < COARSEST
        {
            self.thin();
        }
    }
}

/// A judge, and a recorder that is told what the judge sees.
pub struct Watched<'a> {
    /// The judge.
    pub judge: Judge<'a>,
    /// The recorder, if there is to be one.
    pub recorder: Option<Recorder>,
}

impl Observer for Watched<'_> {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        self.judge.setpoint(sample)?;
        if let Some(recorder) = &mut self.recorder {
            recorder.take(sample, self.judge.deviation());
        }
        Ok(())
    }
}
