//! Modal state and moves.

use super::super::{AXES, Course, LETTERS, Move, Point, Program, ReadOptions, Speed};
use super::words::{Word, split};
use crate::machine::is_rotary;
use anyhow::{Context, Result, anyhow, bail};
use splineway::Turn;
use splineway::block::centre_from_radius;
use splineway::number::Coord;
use std::collections::BTreeSet;

/// Reads a G-code program. Moves before any F word run at `feed` mm/s.
///
/// # Errors
/// Names line, column and reason.
pub fn parse(text: &str, feed: f64) -> Result<Program> {
    parse_with(text, ReadOptions { feed, ..ReadOptions::DEFAULT })
}

/// Reads a G-code program for a machine that stands at `options.start`.
///
/// # Errors
/// Names line, column and reason.
pub fn parse_with(text: &str, options: ReadOptions) -> Result<Program> {
    let mut reader = Reader::new(options.feed);
    reader.position = options.start;
    reader.program.start = options.start;
    for (index, line) in text.lines().enumerate() {
        let number = u32::try_from(index + 1)?;
        let words = split(line).with_context(|| format!("line {number}"))?;
        reader.line(number, &words).with_context(|| format!("line {number}"))?;
        if reader.ended {
            break;
        }
    }
    Ok(reader.program)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    None,
    Rapid,
    Feed,
    Clockwise,
    CounterClockwise,
    /// G5.
    Cubic,
    /// G5.1.
    Quadratic,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plane {
    Xy,
    Zx,
    Yz,
}

impl Plane {
    /// First and second axis, and the letters of their centre offsets.
    const fn axes(self) -> ((usize, usize), (char, char)) {
        match self {
            Self::Xy => ((0, 1), ('I', 'J')),
            Self::Zx => ((2, 0), ('K', 'I')),
            Self::Yz => ((1, 2), ('J', 'K')),
        }
    }
}

struct Reader {
    program: Program,
    mode: Mode,
    plane: Plane,
    inches: bool,
    relative: bool,
    absolute_centre: bool,
    inverse_time: bool,
    exact_stop: bool,
    tolerance: Option<f64>,
    /// F word as written.
    feed: Option<f64>,
    default_feed: f64,
    /// Machine position, mm or degrees.
    position: Point,
    /// Machine position of the program's zero (G92).
    zero: Point,
    /// From the last point of the G5 before to its second control point (its P and Q).
    last_control: Option<[f64; 2]>,
    warned: BTreeSet<String>,
    ended: bool,
}

/// What one line asks for besides modal changes.
#[derive(Default)]
struct Line<'a> {
    words: &'a [Word],
    dwell: bool,
    exact_stop: bool,
    home: bool,
    set_zero: bool,
    machine_coordinates: bool,
    blend: bool,
}

impl Line<'_> {
    fn get(&self, letter: char) -> Option<f64> {
        self.words.iter().find(|word| word.letter == letter).map(|word| word.value)
    }
}

impl Reader {
    fn new(default_feed: f64) -> Self {
        Self {
            program: Program::default(),
            mode: Mode::None,
            plane: Plane::Xy,
            inches: false,
            relative: false,
            absolute_centre: false,
            inverse_time: false,
            exact_stop: false,
            tolerance: None,
            feed: None,
            default_feed,
            position: [0.0; AXES],
            last_control: None,
            zero: [0.0; AXES],
            warned: BTreeSet::new(),
            ended: false,
        }
    }

    fn warn(&mut self, number: u32, message: &str) {
        if self.warned.insert(message.to_owned()) {
            self.program.warnings.push(format!("line {number}: {message}"));
        }
    }

    fn line(&mut self, number: u32, words: &[Word]) -> Result<()> {
        let mut line = Line { words, ..Line::default() };
        check_repeats(words)?;
        for word in words {
            match word.letter {
                'G' => self.g_word(number, word, &mut line)?,
                'F' => {
                    if !(word.value > 0.0) {
                        bail!(
                            "column {}: feed F{} must be greater than 0",
                            word.column,
                            word.value
                        );
                    }
                    self.feed = Some(word.value);
                }
                'M' => self.m_word(number, word),
                'E' => self.warn(number, "E words (extruder) are ignored"),
                'N' | 'O' | 'S' | 'T' | 'D' | 'H' | 'P' | 'Q' | 'I' | 'J' | 'K' | 'R' => {}
                letter if LETTERS.contains(&letter) => {}
                letter => self.warn(number, &format!("unknown word {letter} is ignored")),
            }
        }
        if line.blend {
            self.tolerance = line.get('P').map(|p| p * self.scale());
        }
        if line.dwell {
            return self.dwell(number, &line);
        }
        if line.set_zero {
            self.set_zero(&line);
            return Ok(());
        }
        if line.home {
            return self.home(number, &line);
        }
        self.motion(number, &line)
    }

    fn g_word(&mut self, number: u32, word: &Word, line: &mut Line<'_>) -> Result<()> {
        // One decimal is all that G codes have.
        match (word.value * 10.0).round() as i64 {
            0 => self.mode = Mode::Rapid,
            10 => self.mode = Mode::Feed,
            20 => self.mode = Mode::Clockwise,
            30 => self.mode = Mode::CounterClockwise,
            40 => line.dwell = true,
            50 => self.mode = Mode::Cubic,
            51 => self.mode = Mode::Quadratic,
            90 => line.exact_stop = true,
            170 => self.plane = Plane::Xy,
            180 => self.plane = Plane::Zx,
            190 => self.plane = Plane::Yz,
            200 => self.inches = true,
            210 => self.inches = false,
            280 => line.home = true,
            400 | 490 | 540 => {}
            530 => line.machine_coordinates = true,
            610 | 611 => self.exact_stop = true,
            640 => {
                self.exact_stop = false;
                line.blend = true;
            }
            800 => self.mode = Mode::None,
            900 => self.relative = false,
            910 => self.relative = true,
            901 => self.absolute_centre = true,
            911 => self.absolute_centre = false,
            920 => line.set_zero = true,
            921 => self.zero = [0.0; AXES],
            930 => self.inverse_time = true,
            940 => self.inverse_time = false,
            410 | 420 => {
                self.warn(
                    number,
                    &format!("G{} (tool radius compensation) is ignored", word.value),
                );
            }
            550..=599 => {
                self.warn(number, &format!("G{} (work offset) is taken as G54", word.value));
            }
            810..=899 | 730 => {
                bail!("column {}: canned cycle G{} is not supported", word.column, word.value)
            }
            950 => bail!("column {}: G95 (feed per revolution) needs a spindle", word.column),
            _ => self.warn(number, &format!("unknown word G{} is ignored", word.value)),
        }
        Ok(())
    }

    fn m_word(&mut self, number: u32, word: &Word) {
        match word.value.round() as i64 {
            2 | 30 => self.ended = true,
            // Stops, spindle, tool, coolant, heaters and extruder mode: nothing to do with the path.
            0 | 1 | 3..=9 | 82..=84 | 104..=109 | 140 | 190 => {}
            code => self.warn(number, &format!("unknown word M{code} is ignored")),
        }
    }

    fn scale(&self) -> f64 {
        if self.inches { 25.4 } else { 1.0 }
    }

    fn axis_scale(&self, axis: usize) -> f64 {
        if is_rotary(axis) { 1.0 } else { self.scale() }
    }

    fn push(&mut self, number: u32, path: Course, speed: Speed, exact_stop: bool) {
        self.program.moves.push(Move {
            path,
            speed,
            tolerance: self.tolerance,
            exact_stop: exact_stop || self.exact_stop,
            line: number,
        });
    }

    fn dwell(&mut self, number: u32, line: &Line<'_>) -> Result<()> {
        let seconds = line
            .get('P')
            .or_else(|| line.get('X'))
            .ok_or_else(|| anyhow!("G4 needs a P word (seconds)"))?;
        if !(seconds >= 0.0) {
            bail!("G4 P{seconds}: a dwell cannot be negative");
        }
        self.push(number, Course::Dwell { seconds }, Speed::Rapid, true);
        Ok(())
    }

    fn set_zero(&mut self, line: &Line<'_>) {
        for (axis, letter) in LETTERS.into_iter().enumerate() {
            if let Some(value) = line.get(letter) {
                self.zero[axis] = self.position[axis] - value * self.axis_scale(axis);
            }
        }
    }

    /// G28: over the point given to the machine's zero, in the axes named (all if none is).
    fn home(&mut self, number: u32, line: &Line<'_>) -> Result<()> {
        let named: Vec<usize> =
            (0..AXES).filter(|&axis| line.get(LETTERS[axis]).is_some()).collect();
        let mut to = self.position;
        if named.is_empty() {
            to = [0.0; AXES];
        } else {
            let over = self.target(line);
            self.go(number, over)?;
            to.copy_from_slice(&self.position);
            for axis in named {
                to[axis] = 0.0;
            }
        }
        self.go(number, to)
    }

    fn go(&mut self, number: u32, to: Point) -> Result<()> {
        Self::check(&to)?;
        self.position = to;
        self.push(number, Course::Line { to }, Speed::Rapid, false);
        Ok(())
    }

    fn check(to: &Point) -> Result<()> {
        for (axis, value) in to.iter().enumerate() {
            if Coord::from_mm(*value).is_none() {
                bail!("{} would go to {value} mm; coordinates must be within +-1e6", LETTERS[axis]);
            }
        }
        Ok(())
    }

    /// Machine position that the axis words ask for.
    fn target(&mut self, line: &Line<'_>) -> Point {
        let mut to = self.position;
        for (axis, letter) in LETTERS.into_iter().enumerate() {
            if let Some(value) = line.get(letter) {
                let value = value * self.axis_scale(axis);
                to[axis] = match (line.machine_coordinates, self.relative) {
                    (true, _) => value,
                    (_, true) => self.position[axis] + value,
                    _ => self.zero[axis] + value,
                };
                self.program.uses[axis] = true;
            }
        }
        to
    }

    fn motion(&mut self, number: u32, line: &Line<'_>) -> Result<()> {
        let axis_words = LETTERS.into_iter().any(|letter| line.get(letter).is_some());
        let centre_words =
            ['I', 'J', 'K', 'R'].into_iter().any(|letter| line.get(letter).is_some());
        let arc = matches!(self.mode, Mode::Clockwise | Mode::CounterClockwise);
        if !(axis_words || arc && centre_words) {
            return Ok(());
        }
        if self.mode == Mode::None {
            self.warn(number, "axis words before any of G0 to G3 are taken as G1");
            self.mode = Mode::Feed;
        }
        let from = self.position;
        let to = self.target(line);
        Self::check(&to)?;
        let control = self.last_control.take();
        let curve = match self.mode {
            Mode::Clockwise | Mode::CounterClockwise => self.arc(line, &from, to)?,
            Mode::Cubic => Some(self.cubic(line, &from, to, control)?),
            Mode::Quadratic => Some(self.quadratic(line, &from, to)?),
            Mode::None | Mode::Rapid | Mode::Feed => None,
        };
        if arc && curve.is_none() {
            self.warn(number, "an arc without centre (I J K) or radius (R) is taken as a line");
        }
        let path = curve.unwrap_or(Course::Line { to });
        let linear =
            arc || (0..AXES).any(|axis| !is_rotary(axis) && (to[axis] - from[axis]).abs() > 0.0);
        let speed = self.speed(number, line, linear)?;
        self.position = to;
        self.push(number, path, speed, line.exact_stop);
        Ok(())
    }

    fn speed(&mut self, number: u32, line: &Line<'_>, linear: bool) -> Result<Speed> {
        if self.mode == Mode::Rapid {
            return Ok(Speed::Rapid);
        }
        if self.inverse_time {
            let per_minute =
                line.get('F').ok_or_else(|| anyhow!("under G93 every move needs an F word"))?;
            return Ok(Speed::Duration(60.0 / per_minute));
        }
        let Some(feed) = self.feed else {
            let feed = self.default_feed;
            self.warn(number, &format!("no F word yet; moves run at {feed} mm/s"));
            return Ok(Speed::PerSecond(feed));
        };
        let scale = if linear { self.scale() } else { 1.0 };
        Ok(Speed::PerSecond(feed * scale / 60.0))
    }

    /// Two words of a curve in the XY plane, mm; `None` if neither is there.
    fn pair(&self, line: &Line<'_>, letters: [char; 2]) -> Result<Option<[f64; 2]>> {
        if self.plane != Plane::Xy {
            bail!("G5 and G5.1 need the XY plane (G17)");
        }
        match letters.map(|letter| line.get(letter)) {
            [None, None] => Ok(None),
            [Some(x), Some(y)] => Ok(Some([x * self.scale(), y * self.scale()])),
            _ => bail!("{} and {} come together", letters[0], letters[1]),
        }
    }

    /// G5: I and J from the start to the first control point, P and Q from the end to the second.
    /// Without I and J the curve goes on from the G5 before.
    fn cubic(
        &mut self,
        line: &Line<'_>,
        from: &Point,
        to: Point,
        before: Option<[f64; 2]>,
    ) -> Result<Course> {
        let first = self.pair(line, ['I', 'J'])?.or(before.map(|control| control.map(|x| -x)));
        let first = first.ok_or_else(|| anyhow!("the first G5 needs I and J"))?;
        let second = self.pair(line, ['P', 'Q'])?.ok_or_else(|| anyhow!("G5 needs P and Q"))?;
        self.last_control = Some(second);
        let mut controls = [*from, to];
        for i in 0..2 {
            controls[0][i] += first[i];
            controls[1][i] += second[i];
        }
        Ok(Course::Cubic { controls: thirds(from, controls, &to), to })
    }

    /// G5.1: I and J from the start to the only control point.
    fn quadratic(&self, line: &Line<'_>, from: &Point, to: Point) -> Result<Course> {
        let control = self.pair(line, ['I', 'J'])?.ok_or_else(|| anyhow!("G5.1 needs I and J"))?;
        let mut controls = [*from, to];
        for i in 0..2 {
            let middle = from[i] + control[i];
            controls[0][i] += (middle - from[i]) * 2.0 / 3.0;
            controls[1][i] += (middle - to[i]) * 2.0 / 3.0;
        }
        Ok(Course::Cubic { controls: thirds(from, controls, &to), to })
    }

    /// The arc to `to`, or `None` if neither centre nor radius is given.
    fn arc(&self, line: &Line<'_>, from: &Point, to: Point) -> Result<Option<Course>> {
        let (plane, (first, second)) = self.plane.axes();
        let (p, q) = plane;
        let clockwise = self.mode == Mode::Clockwise;
        let scale = self.scale();
        let centre = if let Some(radius) = line.get('R') {
            let point = |at: &Point| -> Result<(Coord, Coord)> {
                let coord = |mm: f64| {
                    Coord::from_mm(mm).ok_or_else(|| anyhow!("coordinate {mm} mm is out of range"))
                };
                Ok((coord(at[p])?, coord(at[q])?))
            };
            let turn = if clockwise { Turn::Clockwise } else { Turn::CounterClockwise };
            let centre = centre_from_radius(point(from)?, point(&to)?, radius * scale, turn)?;
            (centre.0.to_mm(), centre.1.to_mm())
        } else {
            let (i, j) = (line.get(first), line.get(second));
            if i.is_none() && j.is_none() {
                return Ok(None);
            }
            let place = |word: Option<f64>, axis: usize| match (word, self.absolute_centre) {
                (Some(value), true) => value * scale + self.zero[axis],
                (Some(value), false) => from[axis] + value * scale,
                (None, _) => from[axis],
            };
            (place(i, p), place(j, q))
        };
        let turns = line.get('P').unwrap_or(1.0);
        if !(1.0..=1000.0).contains(&turns) {
            bail!("P{turns}: an arc has 1 to 1000 turns");
        }
        Ok(Some(Course::Arc { to, plane, centre, clockwise, extra_turns: turns as u16 - 1 }))
    }
}

/// Control points of a plane curve; the other axes move evenly.
fn thirds(from: &Point, mut controls: [Point; 2], to: &Point) -> [Point; 2] {
    for i in 2..AXES {
        controls[0][i] = from[i] + (to[i] - from[i]) / 3.0;
        controls[1][i] = to[i] - (to[i] - from[i]) / 3.0;
    }
    controls
}

/// A letter other than G and M may stand once in a line.
fn check_repeats(words: &[Word]) -> Result<()> {
    for (i, word) in words.iter().enumerate() {
        let twice = words[..i].iter().any(|before| before.letter == word.letter);
        if twice && !matches!(word.letter, 'G' | 'M') {
            bail!("column {}: a second {} word", word.column, word.letter);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(text: &str) -> Vec<(f64, f64, f64)> {
        parse(text, 10.0)
            .unwrap()
            .moves
            .iter()
            .map(|step| match &step.path {
                Course::Line { to } | Course::Arc { to, .. } | Course::Cubic { to, .. } => {
                    (to[0], to[1], to[2])
                }
                Course::Dwell { .. } | Course::Event { .. } => (f64::NAN, 0.0, 0.0),
            })
            .collect()
    }

    #[test]
    fn modal_motion_units_and_offsets() {
        assert_eq!(
            ends("G20 G0 X1\nY1\nG21 G91 G1 X1 F60\nG90 X0 Y0"),
            [(25.4, 0.0, 0.0), (25.4, 25.4, 0.0), (26.4, 25.4, 0.0), (0.0, 0.0, 0.0)]
        );
        assert_eq!(
            ends("G1 X5 F1\nG92 X0\nX1\nG92.1\nX1"),
            [(5.0, 0.0, 0.0), (6.0, 0.0, 0.0), (1.0, 0.0, 0.0)]
        );
        assert_eq!(
            ends("G1 X5 Y5 F1\nG28 X6"),
            [(5.0, 5.0, 0.0), (6.0, 5.0, 0.0), (0.0, 5.0, 0.0)]
        );
    }

    #[test]
    fn cubic_and_quadratic_curves() {
        let program =
            parse("G1 X1 F60\nG5 X4 Y0 I1 J2 P-1 Q2\nX7 Y0 P-1 Q-2\nG5.1 X10 Y3 Z3 I3 J0", 10.0)
                .unwrap();
        let controls: Vec<[(f64, f64); 2]> = program.moves[1..]
            .iter()
            .map(|step| match &step.path {
                Course::Cubic { controls, .. } => controls.map(|point| (point[0], point[1])),
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!(controls[0], [(2.0, 2.0), (3.0, 2.0)]);
        assert_eq!(controls[1], [(5.0, -2.0), (6.0, -2.0)]);
        assert_eq!(controls[2], [(9.0, 0.0), (10.0, 1.0)]);
        for (text, part) in [
            ("G5 X1 P1 Q1 F60", "line 1: the first G5 needs I and J"),
            ("G5 X1 I1 J1 F60", "line 1: G5 needs P and Q"),
            ("G5.1 X1 I1 F60", "line 1: I and J come together"),
            ("G18 G5.1 X1 I1 J1 F60", "line 1: G5 and G5.1 need the XY plane"),
        ] {
            let error = format!("{:#}", parse(text, 10.0).unwrap_err());
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn arcs_in_three_planes() {
        let program =
            parse("G17 G2 X1 Y1 I1 F60\nG18 G3 X2 Z1 I1 K0\nG19 G2 Y2 Z2 R1\nG2 J1 P3", 10.0)
                .unwrap();
        let planes: Vec<(usize, usize)> = program
            .moves
            .iter()
            .map(|step| match step.path {
                Course::Arc { plane, .. } => plane,
                _ => panic!("all are arcs"),
            })
            .collect();
        assert_eq!(planes, [(0, 1), (2, 0), (1, 2), (1, 2)]);
        assert!(matches!(program.moves[3].path, Course::Arc { extra_turns: 2, .. }));
    }

    #[test]
    fn feeds_and_stops() {
        let program =
            parse("G1 X1\nF120 X2\nG93 X3 F2\nG94 G61 X4 F60\nG64 P0.02 X5\nG9 X6\nG4 P1.5", 7.0)
                .unwrap();
        let speeds: Vec<Speed> = program.moves.iter().map(|step| step.speed).collect();
        assert_eq!(
            speeds[..4],
            [
                Speed::PerSecond(7.0),
                Speed::PerSecond(2.0),
                Speed::Duration(30.0),
                Speed::PerSecond(1.0)
            ]
        );
        let stops: Vec<bool> = program.moves.iter().map(|step| step.exact_stop).collect();
        assert_eq!(stops, [false, false, false, true, false, true, true]);
        assert_eq!(program.moves[4].tolerance, Some(0.02));
        assert_eq!(program.warnings.len(), 1);
    }

    #[test]
    fn unknown_words_are_warned_of_once() {
        let program = parse("G1 X1 E1 F60\nX2 E2 M117\nM117 G123\nL1 X3\nG2 X4", 7.0).unwrap();
        assert_eq!(program.warnings.len(), 5, "{:?}", program.warnings);
    }

    #[test]
    fn errors_name_line_and_column() {
        for (text, message) in [
            ("G1 X1 F60\nG1 Xa", "line 2: column 4: no number behind \"X\""),
            ("G1 X1 X2 F1", "line 1: column 7: a second X word"),
            ("G1 X1 F0", "line 1: column 7: feed F0 must be greater than 0"),
            ("G2 X9 R1 F60", "line 1: no arc of radius 1 mm joins points 9.000000 mm apart"),
            ("G93 G1 X1", "line 1: under G93 every move needs an F word"),
            ("G81 X1", "line 1: column 1: canned cycle G81 is not supported"),
            ("G1 X1000001 F1", "line 1: X would go to 1000001 mm"),
        ] {
            let error = format!("{:#}", parse(text, 1.0).unwrap_err());
            assert!(error.starts_with(message), "{error}");
        }
    }
}
