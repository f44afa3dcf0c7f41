//! A run, thinned out for plotting.

use crate::run::{Observer, Sample};
use anyhow::Result;

/// One point of a trace: the state at a cycle, and the peaks since the point before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Point {
    /// Time, s.
    pub time: f64,
    /// Positions, mm.
    pub position: Vec<f64>,
    /// Arc length, mm.
    pub way: f64,
    /// Speed along the path, mm/s.
    pub speed: f64,
    /// Acceleration per axis of largest magnitude, mm/s2.
    pub acceleration: Vec<f64>,
    /// Jerk per axis of largest magnitude, mm/s3.
    pub jerk: Vec<f64>,
    /// Line of the file.
    pub line: u32,
}

/// Most points kept; when there are more, every other one is dropped.
const MOST: usize = 40_000;

/// Collects the points.
#[derive(Clone, Debug)]
pub struct Trace {
    /// The points.
    pub points: Vec<Point>,
    cycle: f64,
    every: u32,
    count: u32,
    current: Point,
    before: Option<Vec<f64>>,
}

impl Trace {
    /// An empty trace of a run with this servo cycle, s.
    pub fn new(cycle: f64) -> Self {
        Self {
            points: Vec::new(),
            cycle,
            every: 1,
            count: 0,
            current: Point::default(),
            before: None,
        }
    }

    fn thin(&mut self) {
        let mut kept: Vec<Point> = Vec::with_capacity(MOST / 2 + 1);
        for pair in self.points.chunks(2) {
            let mut point = pair[pair.len() - 1].clone();
            if let [first, _] = pair {
                for (largest, value) in point.acceleration.iter_mut().zip(&first.acceleration) {
                    keep_larger(largest, *value);
                }
                for (largest, value) in point.jerk.iter_mut().zip(&first.jerk) {
                    keep_larger(largest, *value);
                }
            }
            kept.push(point);
        }
        self.points = kept;
        self.every *= 2;
    }
}

fn keep_larger(slot: &mut f64, value: f64) {
    if value.abs() > slot.abs() {
        *slot = value;
    }
}

impl Observer for Trace {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        let n = sample.position.len();
        if self.count == 0 {
            self.current.acceleration = vec![0.0; n];
            self.current.jerk = vec![0.0; n];
        }
        let before = self.before.get_or_insert_with(|| vec![0.0; n]);
        for axis in 0..n {
            let a = sample.acceleration[axis];
            keep_larger(&mut self.current.acceleration[axis], a);
            keep_larger(&mut self.current.jerk[axis], (a - before[axis]) / self.cycle);
            before[axis] = a;
        }
        self.count += 1;
        if self.count < self.every {
            return Ok(());
        }
        self.count = 0;
        let mut point = std::mem::take(&mut self.current);
        point.time = sample.time;
        point.position = sample.position.to_vec();
        point.way = sample.path;
        point.speed = sample.speed;
        point.line = sample.tag;
        self.points.push(point);
        if self.points.len() >= MOST {
            self.thin();
        }
        Ok(())
    }
}
