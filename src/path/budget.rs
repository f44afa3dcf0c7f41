//! The tolerance budget: who may leave the programmed path by which share of the tolerance.
//!
//! A block's tolerance is the greatest distance between the executed motion and the programmed path. Several things
//! use it up, and at one place they add up. They are of two kinds.
//!
//! *Taken off first.* What is known as a length when a line or curve is taken in is subtracted, and what comes after
//! shares the rest: what follows the setpoints ([`Config::reserve`]), the chords of a curve ([`Chords`]), the vertices of lines that became one ([`Straightened`],
//! [`THINNED`], [`SPIKE`]). These cannot exceed the tolerance together, whatever they are.
//!
//! *Shares of the rest*, which is called the band. Every place of the path is of one of these kinds:
//!
//! | place | geometry | rest within a cell | rounding |
//! |---|---|---|---|
//! | corner of lines | [`CORNER`] x [`SWING`] | [`CORNER_REST`] | [`ROUNDING`] |
//! | joint that is passed | [`PASSED`], by either side | within it | [`PASSED_ROUNDING`] |
//! | blend | [`BLEND`] with what it keeps free for rests ([`REST`]); between samples [`BLEND_GAPS`] | | [`ROUNDING`] |
//! | body of an arc | | [`ARC`] | [`ARC_ROUNDING`] |
//! | run | [`RUN`] with what it keeps free for rests ([`REST`]) | | [`ROUNDING`] |
//!
//! A rest is where the motion starts or stops within a cell, by an operator's command or because no block has come:
//! there it follows the cell less closely than where it passes. The corner of the paper ([`super::corner`]) uses the
//! whole band, as printed.
//!
//! Shares of the tolerance by which something is only decided, and which use up none of it, stand where that is done:
//! in `super::joint` when a stop is shorter than passing, in `super::run` where knots are laid.

use crate::block::Block;
use crate::machine::Config;
use crate::number::Scalar;

/// Corner between lines: the rest is for rounding.
pub const CORNER: f64 = 0.998;
/// Of that, what the shapes of [`super::swing`] use.
pub const SWING: f64 = 0.95;
/// By how much a motion that rests or starts within a cell leaves the shape of a corner (`profile::compile` tests it).
pub const CORNER_REST: f64 = 0.04;

/// Joint that is simply passed: the motions over the cells on either side of it, each (`profile::compile` tests it).
pub const PASSED: f64 = 0.48;
/// What is left there.
pub const PASSED_ROUNDING: f64 = 0.04;

/// Blend: the greatest distance at the places where it is measured. What a rest takes ([`REST`]) is counted with it.
pub const BLEND: f64 = 0.95;
/// What the distance may grow by between two such places.
pub const BLEND_GAPS: f64 = 0.04;

/// Body of an arc: what a motion over a cell leaves it by, whatever it is (`super::segment`).
pub const ARC: f64 = 0.97;
/// What is left there: the ends of the cells are exact, so it is for the rounding of the radius, of the angle of a cell
/// and of the quintic at steady speed, which is least fine at `FINEST_BAND`.
pub const ARC_ROUNDING: f64 = 0.03;

/// Run: the bound of the distance between spline and poly-line.
pub const RUN: f64 = 0.99;
/// A motion that comes to rest within a cell of a run or blend, or starts there, leaves the curve by up to this share of
/// curvature times length squared (`profile::compile` tests it): the bound counts it with the distance.
pub const REST: f64 = 1.0 / 96.0;

/// Rounding in `f32`: coordinates are exact, but offsets of some tolerances are rounded to a few millionths of
/// themselves, and lengths of a path, of which directions and tolerances are shares, more coarsely.
pub const ROUNDING: f64 = 0.01;

/// The shares of the band that can add up at one place, for every kind of place.
const PLACES: [(&str, &[f64]); 5] = [
    ("corner", &[CORNER * SWING, CORNER_REST, ROUNDING]),
    ("joint that is passed", &[PASSED, PASSED, PASSED_ROUNDING]),
    ("blend", &[BLEND, BLEND_GAPS, ROUNDING]),
    ("arc", &[ARC, ARC_ROUNDING]),
    ("run", &[RUN, ROUNDING]),
];

const fn sum(shares: &[f64]) -> f64 {
    match shares {
        [] => 0.0,
        [first, rest @ ..] => *first + sum(rest),
    }
}

// A budget that is overdrawn does not compile.
const _: () = {
    let mut place = 0;
    while place < PLACES.len() {
        assert!(
            sum(PLACES[place].1) <= 1.0 + f64::EPSILON,
            "shares of the band add up to more than 1"
        );
        place += 1;
    }
};

/// Vertices of a run that are left out lie within this share of the tolerance of the line past them.
pub const THINNED: f64 = 0.05;
/// The same where the path turns back: a spike, which is ironed out.
pub const SPIKE: f64 = 0.4;
/// How far back is no spike but rounding.
pub const BACKWARDS: f64 = 1.0e-3;

/// The tolerance of a block, mm: its own, or the machine's.
pub fn tolerance<S: Scalar, const N: usize>(block: &Block<S, N>, config: &Config<S, N>) -> S {
    block.tolerance.unwrap_or(config.tolerance)
}

/// What is left of a tolerance for the setpoints, mm; none for a line of a tolerance that what follows them needs whole, which is
/// run by itself.
pub fn of_setpoints<S: Scalar, const N: usize>(tolerance: S, config: &Config<S, N>) -> S {
    (tolerance - config.reserve()).greatest(S::ZERO)
}

/// What the chords of a curve take of its tolerance.
pub struct Chords<S> {
    /// Greatest distance between curve and chords, mm.
    pub sag: f64,
    /// The tolerance of the chords, mm.
    pub rest: S,
}

impl<S: Scalar> Chords<S> {
    /// Share of the tolerance.
    const SHARE: f64 = 1.0 / 16.0;

    /// Of a curve with a tolerance, mm.
    pub fn new(tolerance: S) -> Self {
        let sag = tolerance.to_f64() * Self::SHARE;
        Self { sag, rest: tolerance - S::of(sag) }
    }
}

/// How far the ends of the pieces of a straight line may lie off the line that they become, mm.
#[derive(Clone, Copy, Debug)]
pub struct Straightened {
    /// Where that is the rounding of coordinates here, with a reserve: it takes nothing of the band.
    pub exact: f64,
    /// Where it may be the rounding of the program.
    pub rounded: f64,
}

impl Straightened {
    /// What coordinates are rounded to, with a reserve, mm.
    pub const EXACT: f64 = 1.0e-10;
    /// Share of the tolerance.
    const SHARE: f64 = 0.001;
    /// The same between pieces that are so much longer than the tolerance that an end off the line can only come from
    /// the rounding of the program.
    const LONG_SHARE: f64 = 0.1;
    /// How many times as long as the tolerance such a piece is.
    const LONG: f64 = 16.0;
    /// Least of it, mm, also where there is no tolerance: the nanometre of the finest input.
    const LEAST: f64 = 1.0e-6;

    /// What a line whose ends of pieces lie `off` mm off it takes of its tolerance, mm: where that is next to nothing the
    /// least counts as nothing.
    pub fn taken<S: Scalar>(tolerance: S, off: S) -> S {
        off.least(tolerance * S::of(Self::LONG_SHARE))
    }

    /// For lines of which the shorter is `shorter` mm long.
    pub fn new<S: Scalar>(tolerance: S, shorter: S) -> Self {
        let long = shorter > tolerance * S::of(Self::LONG);
        let share = if long { Self::LONG_SHARE } else { Self::SHARE };
        Self { exact: Self::EXACT, rounded: (tolerance.to_f64() * share).max(Self::LEAST) }
    }
}

/// The distance that a run may keep from its poly-line, mm, of which the vertices left out take `error` mm.
pub fn run_radius<S: Scalar>(tolerance: S, error: S) -> S {
    tolerance * S::of(RUN) - error
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No reserve that nobody has named: a share that is raised by so much is found.
    const UNNAMED: f64 = 0.002;

    #[test]
    fn shares_add_up_to_the_band_and_no_more() {
        for (place, shares) in PLACES {
            let sum = sum(shares);
            assert!(sum <= 1.0 + f64::EPSILON, "{place}: {sum}");
            assert!(sum + UNNAMED >= 1.0, "{place}: {} is nobody's", 1.0 - sum);
        }
    }

    /// What is taken off first leaves a band, at its worst too: the chords of a curve that make spikes.
    #[test]
    fn a_band_is_left_of_what_is_taken_off_first() {
        let tolerance = 0.01f64;
        let chords = Chords::new(tolerance);
        assert!(chords.sag + chords.rest <= tolerance);
        let straightened = Straightened::new(tolerance, 1.0).rounded;
        let radius = run_radius(chords.rest, chords.rest * SPIKE + straightened);
        assert!(radius > tolerance * 0.4, "{radius}");
        // Where there is no tolerance a line is still one line.
        assert!(Straightened::new(0.0f64, 1.0).rounded > Straightened::EXACT);
    }
}
