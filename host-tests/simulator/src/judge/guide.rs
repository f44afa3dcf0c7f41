//! The path as a judge follows it: all of it, or the stretch around the motion, of a program that is gone through.

use super::track::{Follower, Off, Track};
use crate::program::{Move, Tape};

/// So much is kept behind what is looked at, mm, and as a multiple of how far that is.
const BEHIND: (f64, f64) = (10.0, 4.0);

/// A path to be followed.
pub enum Guide<'a> {
    /// All of it.
    Whole(&'a Track),
    /// The stretch around the motion.
    Passing(Box<Passing<'a>>),
}

/// The stretch of a path around the motion.
pub struct Passing<'a> {
    track: Track,
    steps: Box<dyn Iterator<Item = Move> + 'a>,
    tape: &'a dyn Tape,
    count: usize,
    widest: f64,
}

impl<'a> Passing<'a> {
    /// The beginning of a path.
    pub fn new(tape: &'a dyn Tape) -> Self {
        let widest = tape.summary().widest;
        Self { track: Track::begin(tape), steps: tape.steps(), tape, count: 0, widest }
    }

    /// A further move, if there is one.
    fn step(&mut self) -> bool {
        let Some(step) = self.steps.next() else { return false };
        self.track.extend(&step, self.tape.exact().get(self.count));
        self.count += 1;
        true
    }

    /// All that is left of it.
    fn pass(&mut self) {
        while self.step() {
            self.track.forget(self.track.length());
        }
    }
}

impl Guide<'_> {
    /// As [`Follower::look`].
    pub fn look(&mut self, follower: &mut Follower, x: &[f64], reach: f64, default: f64) -> Off {
        match self {
            Self::Whole(track) => follower.look(track, x, reach, default),
            Self::Passing(passing) => {
                // Two vertices beyond, whose bands count at a corner.
                let end = follower.far() + reach;
                while passing.track.beyond(end) < 3 && passing.step() {}
                let off = follower.look(&passing.track, x, reach, default);
                passing.track.forget(follower.way() - BEHIND.0 - BEHIND.1 * reach);
                off
            }
        }
    }

    /// As [`Track::widest`], of all moves.
    pub fn widest(&self, default: f64) -> f64 {
        match self {
            Self::Whole(track) => track.widest(default),
            Self::Passing(passing) => passing.widest.max(default),
        }
    }

    /// The end of the path; what is left of it is gone through.
    pub fn end(&mut self) -> &[f64] {
        match self {
            Self::Whole(track) => track.end(),
            Self::Passing(passing) => {
                passing.pass();
                passing.track.end()
            }
        }
    }

    /// The length of the path, mm; what is left of it is gone through.
    pub fn length(&mut self) -> f64 {
        match self {
            Self::Whole(track) => track.length(),
            Self::Passing(passing) => {
                passing.pass();
                passing.track.length()
            }
        }
    }
}
