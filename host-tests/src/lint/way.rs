//! Which move of a program is under way. A setpoint names its line alone, and a line has several moves where it drills, and wherever it is
//! run more than once.

use super::feeds::Asked;
use splineway::Activity;
use splineway_simulator::run::Sample;
use std::collections::VecDeque;

/// So many moves behind the one that is under way are kept.
const BEHIND: usize = 16;

/// A move by its place on the programmed way.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    /// Line of the file.
    pub line: u32,
    /// Its length, mm.
    pub length: f64,
    /// What it asks for.
    pub asked: Asked,
}

/// A move where it lies: the way up to its beginning and its end, mm.
#[derive(Clone, Copy, Debug)]
struct Laid {
    from: f64,
    to: f64,
    stretch: Stretch,
}

impl Laid {
    /// How far a place on the way is off it, mm.
    fn off(&self, way: f64) -> f64 {
        (self.from - way).max(way - self.to).max(0.0)
    }
}

/// Follows a run along the moves of its program.
///
/// The way that was run tells them apart. It is not quite as long as the moves are, as corners are cut: wherever another line begins, the two
/// are brought together.
#[derive(Clone, Debug, Default)]
pub struct Way {
    moves: VecDeque<Laid>,
    /// Of them, the one that is under way.
    now: usize,
    /// Length of all moves so far, mm.
    length: f64,
    /// The way that was run, mm.
    run: f64,
    /// What the way along the moves is ahead of it, mm.
    ahead: f64,
    /// The line under way.
    line: Option<u32>,
}

impl Way {
    /// A further move of the program.
    pub fn add(&mut self, stretch: Stretch) {
        let from = self.length;
        self.length += stretch.length;
        self.moves.push_back(Laid { from, to: self.length, stretch });
    }

    /// Whether moves that are still to be added could be under way.
    pub fn wants(&self, sample: &Sample<'_>) -> bool {
        let here = sample.path + self.ahead;
        self.leaves(sample, here)
            && self.nearest(sample.tag, here).is_none_or(|(off, _)| self.length - here <= off)
    }

    /// What the move asks for that is under way. Every cycle is to be told.
    pub fn follow(&mut self, sample: &Sample<'_>) -> Asked {
        let (before, here) = (self.run + self.ahead, sample.path + self.ahead);
        self.run = sample.path;
        if sample.activity == Activity::Jogging {
            self.ahead -= here - before;
        } else if self.leaves(sample, here) {
            let Some((_, found)) = self.nearest(sample.tag, here) else { return Asked::NOTHING };
            if self.line.replace(sample.tag) != Some(sample.tag) {
                // It began between the two cycles.
                let from = self.moves[self.first(found)].from;
                self.ahead += from - from.clamp(before, here.max(before));
            }
            let passed = found.saturating_sub(BEHIND);
            self.moves.drain(..passed);
            self.now = found - passed;
        }
        self.moves.get(self.now).map_or(Asked::NOTHING, |laid| laid.stretch.asked)
    }

    /// Whether the move that was under way is over.
    fn leaves(&self, sample: &Sample<'_>, here: f64) -> bool {
        sample.activity != Activity::Jogging
            && (self.line != Some(sample.tag)
                || self.moves.get(self.now).is_none_or(|laid| here > laid.to))
    }

    /// Of the moves of a line, the one that is nearest to a place on the way, and how far it is off.
    fn nearest(&self, line: u32, way: f64) -> Option<(f64, usize)> {
        let mut best: Option<(f64, usize)> = None;
        for (k, laid) in self.moves.iter().enumerate() {
            if best.is_some_and(|(off, _)| laid.from - way > off) {
                break;
            }
            let off = laid.off(way);
            if laid.stretch.line == line && best.is_none_or(|(least, _)| off <= least) {
                best = Some((off, k));
            }
        }
        best
    }

    /// The first of the moves of the same line that lie one behind the other up to this one.
    fn first(&self, found: usize) -> usize {
        let line = self.moves[found].stretch.line;
        let before = self.moves.range(..found).rev();
        found - before.take_while(|laid| laid.stretch.line == line).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splineway_simulator::run::Pace;

    fn asked(wanted: f64) -> Asked {
        Asked { wanted, most: 200.0, rapid: false, turns: false }
    }

    fn sample(tag: u32, path: f64) -> Sample<'static> {
        Sample {
            time: 1.0,
            position: &[],
            velocity: &[],
            acceleration: &[],
            path,
            speed: 1.0,
            tag,
            activity: Activity::Running,
            began: false,
            unit: f64::EPSILON,
            pace: Pace::FULL,
        }
    }

    /// Runs moves (line, length, feed) with so much cut off at the end of each, and counts cycles at the feed of another.
    fn strangers(moves: &[(u32, f64, f64)], step: f64, cut: f64) -> usize {
        let mut way = Way::default();
        let mut left = moves.iter();
        let (mut run, mut end, mut strangers) = (0.0, 0.0, 0);
        for &(line, length, feed) in moves {
            end += length - cut;
            while run < end {
                while way.wants(&sample(line, run))
                    && let Some(&(line, length, feed)) = left.next()
                {
                    way.add(Stretch { line, length, asked: asked(feed) });
                }
                let found = way.follow(&sample(line, run));
                strangers += usize::from(found.wanted.to_bits() != feed.to_bits());
                run += step;
            }
        }
        strangers
    }

    /// A line that is run again and again, one with several moves, and lines that no cycle sees.
    #[test]
    fn moves_of_one_line_are_told_apart() {
        let again: Vec<_> = (0..9).map(|k| (6, 10.0, 5.0 + f64::from(k))).collect();
        assert_eq!(strangers(&again, 0.011, 0.0), 0);
        let drill = [(3, 0.0, 200.0), (3, 10.0, 200.0), (3, 22.0, 1.0), (3, 22.0, 200.0)];
        let holes: Vec<_> = (0..50).flat_map(|_| drill).chain([(4, 5.0, 9.0)]).collect();
        assert!(strangers(&holes, 0.013, 0.0) <= 1);
        let called = (0..200).flat_map(|k| [(7, 1.0, f64::from(k)), (8, 0.01, 0.5), (9, 2.0, 3.0)]);
        let called: Vec<_> = called.collect();
        // A cycle or two at each seam.
        assert!(strangers(&called, 0.05, 0.0) <= 400);
        assert!(strangers(&called, 0.05, 0.005) <= 600);
    }

    #[test]
    fn a_line_that_the_program_lacks_asks_for_nothing() {
        let mut way = Way::default();
        assert_eq!(way.follow(&sample(5, 0.0)), Asked::NOTHING);
    }
}
