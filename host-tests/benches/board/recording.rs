//! What an oscilloscope at the pins would have seen: steps of every axis in time, and whether the edges are as the drives ask.

use super::machine::{self, AXES};
use anyhow::{Result, ensure};
use splineway::output::StepTiming;
use splineway_mps2::pins::{self, Levels, News, Reader};

/// A place of all axes, in steps.
pub type Place = [i64; AXES];

/// Steps between the beginnings of two servo cycles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cycle {
    /// Where the axes are at its end.
    pub end: Place,
    /// The tick and the place of every tick with a step.
    pub steps: Vec<(u32, Place)>,
}

/// When the edges of an axis came, in ticks since the start.
#[derive(Clone, Copy, Debug, Default)]
struct Edges {
    /// The last rise, fall and turn; `None`: there was none.
    rise: Option<u64>,
    fall: Option<u64>,
    turn: Option<u64>,
}

/// Follows the record of the pins.
#[derive(Debug)]
pub struct Recording {
    reader: Reader,
    timing: StepTiming,
    levels: Levels,
    place: Place,
    edges: [Edges; AXES],
    /// Whole servo cycles.
    pub cycles: Vec<Cycle>,
    under_way: Option<Cycle>,
    /// Steps of all axes.
    pub steps: u64,
    /// Where and when inputs have changed.
    pub edges_of_inputs: Vec<InputEdge>,
}

/// A change of inputs.
#[derive(Clone, Copy, Debug)]
pub struct InputEdge {
    /// Servo cycles since the start, to the step timer's tick.
    pub time: f64,
    /// Where the axes were, in steps.
    pub place: Place,
}

impl Recording {
    /// Of a machine whose axes stand at zero.
    pub fn new() -> Self {
        let timing =
            StepTiming::from_ns(machine::STEP_HZ, 1_000_000 / machine::SERVO_HZ, machine::DRIVE);
        Self {
            reader: Reader::new(),
            timing,
            levels: 0,
            place: [0; AXES],
            edges: [Edges::default(); AXES],
            cycles: Vec::new(),
            under_way: None,
            steps: 0,
            edges_of_inputs: Vec::new(),
        }
    }

    /// Goes on with more of the record.
    ///
    /// # Errors
    /// A byte of it is lost, or an edge comes sooner than the drives allow.
    pub fn read(&mut self, bytes: &[u8]) -> Result<()> {
        for &byte in bytes {
            match self.reader.push(byte)? {
                None => {}
                Some(News::Cycle(_)) => {
                    let next = Cycle { end: self.place, steps: Vec::new() };
                    if let Some(mut cycle) = self.under_way.replace(next) {
                        cycle.end = self.place;
                        self.cycles.push(cycle);
                    }
                }
                Some(News::Change(change)) => {
                    let now = change.cycle * u64::from(machine::TICKS) + u64::from(change.tick);
                    self.change(now, change.tick, change.levels)?;
                }
                Some(News::Edge { cycle, tick }) => {
                    let time = cycle as f64 + f64::from(tick + 1) / f64::from(machine::TICKS);
                    self.edges_of_inputs.push(InputEdge { time, place: self.place });
                }
            }
        }
        Ok(())
    }

    fn change(&mut self, now: u64, tick: u32, levels: Levels) -> Result<()> {
        let before = self.place;
        for axis in 0..AXES {
            self.edge(axis, now, levels)?;
        }
        self.levels = levels;
        if self.place != before
            && let Some(cycle) = &mut self.under_way
        {
            cycle.steps.push((tick, self.place));
        }
        Ok(())
    }

    fn edge(&mut self, axis: usize, now: u64, levels: Levels) -> Result<()> {
        let StepTiming { pulse, pause, setup, hold, .. } = self.timing;
        let changed = self.levels ^ levels;
        let (step, direction) = (pins::step(axis), pins::direction(axis));
        let edges = &mut self.edges[axis];
        let seconds = now as f64 / f64::from(machine::STEP_HZ);
        let keeps = |what: &str, since: Option<u64>, least: u32| {
            let since = since.map_or(u64::MAX, |then| now - then);
            ensure!(
                since >= u64::from(least),
                "axis {axis} at {seconds:.5} s: {what} of {since} ticks of the step timer, and the drive needs {least}"
            );
            Ok(())
        };
        if changed & direction != 0 {
            ensure!(self.levels & step == 0, "axis {axis} at {seconds:.5} s turns within a pulse");
            keeps("a hold time", edges.fall, hold)?;
            edges.turn = Some(now);
        }
        if changed & step == 0 {
            return Ok(());
        }
        if levels & step == 0 {
            keeps("a pulse", edges.rise, pulse)?;
            edges.fall = Some(now);
        } else {
            keeps("a pause", edges.fall, pause)?;
            keeps("a set-up time", edges.turn, setup)?;
            edges.rise = Some(now);
            self.place[axis] += if levels & direction == 0 { 1 } else { -1 };
            self.steps += 1;
        }
        Ok(())
    }

    /// Where the axes are, in steps.
    pub const fn place(&self) -> Place {
        self.place
    }

    /// Whether the drives are enabled.
    pub const fn is_enabled(&self) -> bool {
        self.levels & pins::ENABLE != 0
    }
}

/// A place in mm.
pub fn mm(place: &Place) -> [f64; AXES] {
    place.map(|steps| steps as f64 / f64::from(machine::steps_per_mm()))
}
