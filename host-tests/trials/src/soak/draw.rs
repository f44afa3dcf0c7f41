//! What a soak draws: blocks of every kind, and above all those that have led to trouble.

use crate::moves::between;
use fastrand::Rng;
use splineway_simulator::program::{AXES, Code, Course, Move, Point, Speed};

/// Something that the machine does at rest; which, the core does not know.
const CODE: Code = Code { letter: 'M', tenths: 0 };

fn event(pause: bool) -> Course {
    Course::Event { code: CODE, value: None, pause }
}

/// 10 to a power in a range.
pub(super) fn log(rng: &mut Rng, least: f64, greatest: f64) -> f64 {
    10f64.powf(between(rng, least, greatest))
}

/// What a program is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Theme {
    Mixed,
    Lines,
    Arcs,
    Curves,
    Dense,
    Tiny,
    Stops,
    Lone,
}

const THEMES: [Theme; 10] = [
    Theme::Mixed,
    Theme::Mixed,
    Theme::Mixed,
    Theme::Lines,
    Theme::Arcs,
    Theme::Curves,
    Theme::Dense,
    Theme::Tiny,
    Theme::Stops,
    Theme::Lone,
];

/// Draws the blocks of a program over so many axes.
pub struct Pen<'a> {
    rng: &'a mut Rng,
    axes: usize,
    here: Point,
    heading: Point,
    /// Step of the coordinates, mm, or 0.
    grid: f64,
    /// Size of a usual block, mm; usual feed, mm/s.
    size: f64,
    feed: f64,
    steps: Vec<Move>,
}

/// The blocks of a program from a place, at usual sizes (mm) and feeds (mm/s).
pub fn steps(rng: &mut Rng, axes: usize, start: Point, size: f64, feed: f64) -> Vec<Move> {
    let theme = THEMES[rng.usize(..THEMES.len())];
    // Programs are written with three decimals, some with four.
    let grid = [0.0, 0.001, 0.001, 0.0001][rng.usize(..4)];
    let mut pen =
        Pen { rng, axes, here: start, heading: [0.0; AXES], grid, size, feed, steps: Vec::new() };
    pen.turn_to_any();
    if theme == Theme::Stops || pen.rng.u8(..8) == 0 {
        pen.stand();
    }
    let count = match theme {
        Theme::Lone => 1,
        Theme::Dense => pen.rng.usize(1..6),
        _ => pen.rng.usize(1..14),
    };
    for _ in 0..count {
        pen.draw(theme);
    }
    // Last lines of nanometres.
    if pen.rng.u8(..12) == 0 {
        pen.tiny();
    }
    pen.steps
}

impl Pen<'_> {
    fn draw(&mut self, theme: Theme) {
        let kind = self.rng.u8(..16);
        match theme {
            Theme::Lines | Theme::Lone => self.line(),
            Theme::Arcs if kind < 13 => self.arc(),
            Theme::Curves if kind < 13 => self.cubic(),
            Theme::Dense => self.dense(),
            Theme::Tiny if kind < 10 => self.tiny(),
            Theme::Stops if kind < 8 => self.stand(),
            _ => match kind {
                0..=5 => self.line(),
                6..=8 => self.arc(),
                9..=10 => self.cubic(),
                11 => self.stand(),
                12 => self.dense(),
                13 => self.tiny(),
                14 => self.back(),
                _ => self.straight_on(),
            },
        }
    }

    fn snap(&self, mm: f64) -> f64 {
        if self.grid > 0.0 { (mm / self.grid).round() * self.grid } else { mm }
    }

    fn turn_to_any(&mut self) {
        let mut heading = [0.0; AXES];
        for slot in &mut heading[..self.axes] {
            *slot = match self.rng.u8(..6) {
                0 => 0.0,
                // Axes that hardly take part.
                1 => 1.0e-4 * between(self.rng, -1.0, 1.0),
                _ => between(self.rng, -1.0, 1.0),
            };
        }
        let norm = heading.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm < 1.0e-3 {
            heading = [0.0; AXES];
            heading[self.rng.usize(..self.axes)] = 1.0;
        } else {
            for x in &mut heading {
                *x /= norm;
            }
        }
        self.heading = heading;
    }

    fn ahead(&self, size: f64) -> Point {
        let mut to = self.here;
        for axis in 0..self.axes {
            to[axis] = self.snap(to[axis] + self.heading[axis] * size);
        }
        to
    }

    fn pace(&mut self, length: f64) -> Speed {
        // No block takes longer than a third of a second at its feed, or soaks would.
        let feed = (self.feed * log(self.rng, -1.5, 0.7)).max(length * 3.0).min(1.0e6);
        match self.rng.u8(..16) {
            0 | 1 => Speed::Rapid,
            2 => Speed::Duration((length / feed).clamp(1.0e-6, 0.5)),
            _ => Speed::PerSecond(feed),
        }
    }

    fn push(&mut self, path: Course, length: f64) {
        let speed = self.pace(length);
        let tolerance = match self.rng.u8(..20) {
            0 => Some(0.0),
            1 => Some(log(self.rng, -4.0, 0.0)),
            _ => None,
        };
        let exact_stop = self.rng.u8(..20) == 0;
        let step = Move { path, speed, tolerance, exact_stop, line: 0 };
        if let Some(to) = step.path.end() {
            self.here = *to;
        }
        self.steps.push(step);
    }

    fn length(&mut self) -> f64 {
        self.size * log(self.rng, -2.0, 0.7)
    }

    fn line(&mut self) {
        self.turn_to_any();
        let size = self.length();
        let to = self.ahead(size);
        self.push(Course::Line { to }, size);
    }

    fn straight_on(&mut self) {
        let size = self.length();
        for slot in &mut self.heading[..self.axes] {
            *slot += [0.0, 0.02][self.rng.usize(..2)] * between(self.rng, -1.0, 1.0);
        }
        let to = self.ahead(size);
        self.push(Course::Line { to }, size);
    }

    /// Back on itself.
    fn back(&mut self) {
        self.heading.iter_mut().for_each(|x| *x = -*x);
        let size = self.length();
        let to = self.ahead(size);
        self.push(Course::Line { to }, size);
    }

    /// Lines of nanometres, and of nothing.
    fn tiny(&mut self) {
        for _ in 0..self.rng.usize(1..5) {
            if self.rng.bool() {
                self.turn_to_any();
            }
            let size = if self.rng.u8(..8) == 0 { 0.0 } else { log(self.rng, -7.0, -2.0) };
            let mut to = self.here;
            for axis in 0..self.axes {
                to[axis] += self.heading[axis] * size;
            }
            self.push(Course::Line { to }, size);
        }
    }

    /// Dwells and events.
    fn stand(&mut self) {
        for _ in 0..self.rng.usize(1..4) {
            let shape = match self.rng.u8(..6) {
                0 => event(false),
                1 => event(true),
                2 => Course::Dwell { seconds: log(self.rng, -5.0, -2.0) },
                _ => Course::Dwell { seconds: log(self.rng, -3.0, -0.7) },
            };
            self.push(shape, 0.0);
        }
    }

    fn plane(&mut self) -> (usize, usize) {
        let p = self.rng.usize(..self.axes);
        let q = (p + 1 + self.rng.usize(..self.axes - 1)) % self.axes;
        (p, q)
    }

    fn arc(&mut self) {
        if self.axes < 2 {
            return self.line();
        }
        let (p, q) = self.plane();
        let clockwise = self.rng.bool();
        let radius = self.size * log(self.rng, -1.7, 0.8);
        let from = between(self.rng, 0.0, std::f64::consts::TAU);
        let start = (self.here[p], self.here[q]);
        let centre =
            (self.snap(start.0 - radius * from.cos()), self.snap(start.1 - radius * from.sin()));
        let kind = self.rng.u8(..12);
        let turn = match kind {
            // Nearly full, nearly nothing, full.
            0 | 1 => std::f64::consts::TAU - 10f64.powf(between(self.rng, -4.0, -1.0)),
            2 => 10f64.powf(between(self.rng, -4.0, -1.0)),
            3 => std::f64::consts::TAU,
            _ => between(self.rng, 0.05, std::f64::consts::TAU),
        };
        let extra_turns = match kind {
            4 => self.rng.u16(1..60),
            5 => self.rng.u16(1..4),
            _ => 0,
        };
        let angle = from + if clockwise { -turn } else { turn };
        let mut to = self.here;
        if kind != 3 {
            to[p] = self.snap(centre.0 + radius * angle.cos());
            to[q] = self.snap(centre.1 + radius * angle.sin());
        }
        if kind % 3 == 2 {
            // A helix.
            for axis in (0..self.axes).filter(|axis| *axis != p && *axis != q) {
                let rise = self.size * between(self.rng, -1.0, 1.0);
                to[axis] = self.snap(to[axis] + rise);
            }
        }
        let length = radius * (turn + std::f64::consts::TAU * f64::from(extra_turns));
        self.heading = [0.0; AXES];
        let sign = if clockwise { -1.0 } else { 1.0 };
        (self.heading[p], self.heading[q]) = (-sign * angle.sin(), sign * angle.cos());
        self.push(Course::Arc { to, plane: (p, q), centre, clockwise, extra_turns }, length);
    }

    fn cubic(&mut self) {
        let size = self.length();
        let here = self.here;
        let before = self.heading;
        if self.rng.bool() {
            self.turn_to_any();
        }
        let to = self.ahead(size);
        let mix = |a: &Point, b: &Point, u: f64| -> Point {
            std::array::from_fn(|i| a[i] + (b[i] - a[i]) * u)
        };
        let along = |from: &Point, heading: &Point, by: f64| -> Point {
            std::array::from_fn(|i| from[i] + heading[i] * by)
        };
        let mut controls = match self.rng.u8(..10) {
            // A straight line as a curve; evenly, or with its points on the ends.
            0 => [mix(&here, &to, 1.0 / 3.0), mix(&here, &to, 2.0 / 3.0)],
            1 => [here, to],
            2 => [here, mix(&here, &to, 0.5)],
            3 => [to, here],
            // Turns back on itself, on a straight line.
            4 => [mix(&here, &to, 1.0 + self.rng.f64()), mix(&here, &to, -self.rng.f64())],
            5 => [mix(&here, &to, 1.7), mix(&here, &to, 0.3)],
            // A cusp, a loop.
            6 => {
                self.turn_to_any();
                let across = self.heading;
                let up = along(&here, &across, size);
                [mix(&up, &along(&to, &across, size), 1.0), up]
            }
            // On with the direction that was.
            7 | 8 => {
                self.turn_to_any();
                let by = size * between(self.rng, 0.1, 0.6);
                [along(&here, &before, by), along(&to, &self.heading, -by)]
            }
            _ => {
                self.turn_to_any();
                let first = along(&here, &self.heading, size * between(self.rng, 0.0, 2.0));
                self.turn_to_any();
                [first, along(&to, &self.heading, size * between(self.rng, 0.0, 2.0))]
            }
        };
        let grid = self.grid;
        if grid > 0.0 {
            let snap = |mm: &mut f64| *mm = (*mm / grid).round() * grid;
            for point in &mut controls {
                point[..self.axes].iter_mut().for_each(snap);
            }
        }
        // The direction in which it ends.
        let last: f64 =
            (0..self.axes).map(|i| (to[i] - controls[1][i]).powi(2)).sum::<f64>().sqrt();
        if last > 1.0e-9 {
            self.heading = std::array::from_fn(|i| (to[i] - controls[1][i]) / last);
        }
        self.push(Course::Cubic { controls, to }, size * 2.0);
    }

    /// Short lines as dense programs have them.
    fn dense(&mut self) {
        let count = self.rng.usize(3..40);
        let size = self.size * log(self.rng, -3.0, -0.7);
        let (p, q) = if self.axes > 1 { self.plane() } else { (0, 0) };
        let mut angle = between(self.rng, 0.0, std::f64::consts::TAU);
        let turn = between(self.rng, -0.6, 0.6);
        let kind = self.rng.u8(..5);
        let noise = log(self.rng, -3.0, 0.0);
        let speed = self.pace(size);
        for k in 0..count {
            angle += match kind {
                // A curve; a straight line cut up; with noise; a zigzag; a walk.
                0 => turn,
                1 => 0.0,
                2 => between(self.rng, -noise, noise),
                3 => {
                    if k % 2 == 0 {
                        1.5
                    } else {
                        -1.5
                    }
                }
                _ => between(self.rng, -0.6, 0.6),
            };
            self.heading = [0.0; AXES];
            self.heading[p] = angle.cos();
            if q != p {
                self.heading[q] = angle.sin();
            }
            let to = self.ahead(size);
            self.push(Course::Line { to }, size);
            if let Some(last) = self.steps.last_mut()
                && kind != 4
            {
                last.speed = speed;
            }
        }
    }
}
