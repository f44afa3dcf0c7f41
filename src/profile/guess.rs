//! First states for stations that have none: fast ones near the least time, that may break limits.
//!
//! The numbers below were chosen by trial, and matter little. Over the first 500 lines of seven paths (butterfly2000,
//! butterfly80, tball-engrave, jsdc, walk, star, zigzag90; tolerance 0.05 mm, `f32`, 16 blocks, 64 nodes: 17,330 servo cycles,
//! planned in 760 Newton steps) one of them changed changes the time by at most two cycles, and the number of steps:
//!
//! | number | from | to | steps |
//! |---|---|---|---|
//! | [`STEADY_ACCELERATION`] | 0.8 | 0.97 | 761, 763 |
//! | [`STEADY_JERK`] | 0.5 | 0.9 | 769, 782 |
//! | [`STEADY_FEED`] | 0.96 | 0.995 | 766, 761 |
//! | [`ACCELERATION`] | 0.5 | 0.9 | 772, 788 |
//! | [`STEEPEST`] | 0.5 | 0.74 | 777, 766 |
//! | [`ROUND_JERK`] | 0.5 | 1.0 | 758, 770 |
//! | [`ROUNDINGS`] | 0 | 15 | 832, 763 |

use super::law::{Law, PathState};
use super::problem::Problem;
use super::problem::Stretch;
use super::rows::{Axis, View};
use crate::machine::AxisLimits;
use crate::number::list::some_mut;
use crate::number::{Scalar, cube_root};
use core::ops::Range;

/// Share of an axis's acceleration that is used at constant speed.
const STEADY_ACCELERATION: f64 = 0.9;
/// Share of an axis's jerk that is used at constant speed.
const STEADY_JERK: f64 = 0.7;
/// Share of the feed.
const STEADY_FEED: f64 = 0.985;
/// Share of the acceleration along the path that is used to change speed.
const ACCELERATION: f64 = 0.7;
/// So many times as long as an acceleration takes to be built up (A / J), a change is felt before the place where it is made.
/// (Once, or twice: a path takes up to 2 % longer if it is cut into more cells.)
pub const FELT: f64 = 3.0;
/// Most relative change of v^2 that a guessed acceleration makes over a cell, by half. Below 0.75 there
/// is a motion between any two guesses ([`Law`]).
const STEEPEST: f64 = 0.7;
/// Passes that round the kinks of the guessed speed off.
const ROUNDINGS: usize = 6;
/// Share of the jerk limit with which they are rounded.
const ROUND_JERK: f64 = 0.7;
/// v^3 where nothing bounds it yet, (mm/s)^3; an `f32` holds it.
const NO_CUBE_LIMIT: f64 = 1.0e30;

/// Greatest v^3 at both ends of a cell that constant speed allows.
fn steady_cubes<S: Scalar, const N: usize>(view: &View<'_, S, N>) -> [S; 2] {
    let feed = view.bounds.goal * S::of(STEADY_FEED);
    let mut cubes = [feed * feed * feed; 2];
    if view.cell.straight {
        return cubes;
    }
    let law = Law::steady(view.cell.length);
    let mut keep = |axis: &Axis<S>, limits: &AxisLimits<S>| {
        let [q0, q1, q2] = axis.jerks(&law);
        let half = S::of(0.5);
        let inner = ((q0 + q1) * half).abs().greatest(((q1 + q2) * half).abs());
        let peak = q0.abs().greatest(q2.abs()).greatest(inner);
        let jerk = limits.jerk * S::of(STEADY_JERK);
        let acceleration = limits.acceleration * S::of(STEADY_ACCELERATION);
        for (cube, per_square) in cubes.iter_mut().zip([axis.e0.abs(), axis.e1.abs()]) {
            if peak * *cube > jerk {
                *cube = jerk / peak;
            }
            let square = acceleration / per_square.greatest(S::of(1.0e-12));
            *cube = cube.least(square * square.sqrt());
        }
    };
    for (i, limits) in view.limits.axes().iter().enumerate() {
        keep(&Axis::new(view, &law, i), limits);
    }
    for motor in view.limits.motors() {
        keep(&Axis::of_motor(view, &law, motor), &motor.limits);
    }
    cubes
}

impl<S: Scalar, const N: usize, const NODES: usize> Problem<'_, S, N, NODES> {
    /// Gives the stations from index `new` on, and those before on which the motion brakes towards
    /// it, states near those of least time: the speed that the path's shape allows, held down
    /// where it could not be reached or left. Limits may be broken, but between any two states there
    /// is a motion.
    ///
    /// It works with y = v^1.5, of which leaving a slow place at constant jerk J makes a straight
    /// line: v' = sqrt(J v) is dy / ds = 1.5 sqrt(J), and for a start from rest it is exact
    /// within a factor of 2 in J. Where two such lines meet the speed has a kink, which is rounded off.
    ///
    /// Stations long before those, which have the states of a plan of least time, are left out of the problem: they
    /// would hardly move.
    pub fn guess(&mut self, new: usize) {
        let Stretch { first, last, .. } = self.task.stretch;
        // At most back to the first station.
        let brakes =
            |i: &usize| self.window.get(*i).is_some_and(|station| station.state.a < S::ZERO);
        let braking = (first + 1..new.min(last)).rev().take_while(brakes).count();
        let start = new.min(last).saturating_sub(1 + braking).max(first);
        self.task.stretch.first = self.settled_before(start);
        let mut y = [S::of(NO_CUBE_LIMIT); NODES];
        self.steady(start..last, &mut y);
        for i in start..last {
            self.rise(i, (i, i + 1), &mut y);
        }
        for i in (start + 1..last).rev() {
            self.rise(i, (i + 1, i), &mut y);
        }
        for i in start + 1..last {
            if self.is_free(i)
                && let Some(&y) = y.get(i)
            {
                self.window.set_state(i, PathState { b: y * cube_root(y), a: S::ZERO });
            }
        }
        for _ in 0..ROUNDINGS {
            self.round(start, last);
        }
        let mut before = self.window.get(start).map_or(S::ZERO, |station| station.state.b);
        for i in start + 1..last {
            let b = self.window.get(i).map_or(S::ZERO, |station| station.state.b);
            let after = self.window.get(i + 1).filter(|_| i + 1 < last);
            let rise = after.map_or(S::ZERO, |station| station.state.b) - before;
            if self.is_free(i) {
                self.set_between(i, b, rise);
            }
            before = b;
        }
    }

    /// Rounds the kinks of v^2 off, where the motion would change from one acceleration to another at once: of three
    /// stations the one in the middle, or those beside it, are lowered to what jerk allows, for with b = v^2 the jerk along the
    /// path is v b'' / 2. One pass; what it does to a station is seen by the next ones.
    fn round(&mut self, start: usize, last: usize) {
        for i in start + 1..last {
            let (Some((from, here)), Some(to)) = (self.window.pair(i - 1), self.window.get(i + 1))
            else {
                return;
            };
            let (before, behind) = (from.cell.length, here.cell.length);
            if !(self.is_free(i) && before > S::ZERO && behind > S::ZERO) {
                continue;
            }
            let b = here.state.b;
            let beside = [from.state.b, if i + 1 == last { S::ZERO } else { to.state.b }];
            let straight = (beside[0] * behind + beside[1] * before) / (before + behind);
            let jerk = here.bounds.jerk.least(from.bounds.jerk) * S::of(ROUND_JERK);
            let most = jerk * before * behind / b.sqrt().greatest(S::of(1.0e-3));
            if b > straight + most {
                self.window.set_state(i, PathState { b: straight + most, a: S::ZERO });
                continue;
            }
            let excess = straight - most - b;
            for (k, beside) in [(i - 1, beside[0]), (i + 1, beside[1])] {
                if excess > S::ZERO && beside > b && k > start && self.is_free(k) {
                    let b = (beside - excess).greatest(b);
                    self.window.set_state(k, PathState { b, a: S::ZERO });
                }
            }
        }
    }

    /// Gives a station v^2, and about the acceleration that leads from the one before to the one behind it, whose v^2 is
    /// greater by `rise`.
    pub(super) fn set_between(&mut self, i: usize, b: S, rise: S) {
        let Some((arriving, here)) = self.window.pair(i - 1) else { return };
        let (before, behind) = (arriving.cell.length, here.cell.length);
        let most = S::of(STEEPEST) * b / before.greatest(behind);
        let a = rise * S::of(0.5) / (before + behind);
        self.window.set_state(i, PathState { b, a: a.least(most).greatest(-most) });
    }

    /// The station before which nothing changes when those from `start` on do: the states there are of least time
    /// already, and what comes later is felt no further back than some times what the acceleration takes to be built up.
    fn settled_before(&self, start: usize) -> usize {
        let mut time = self.limits.time_scale() * S::of(FELT);
        let mut station = start;
        while station > self.task.stretch.first && time > S::ZERO {
            station -= 1;
            let Some((from, to)) = self.window.pair(station) else { break };
            let twice_the_mean = from.state.b.sqrt() + to.state.b.sqrt();
            time = time - S::of(2.0) * from.cell.length / twice_the_mean.greatest(S::EPSILON);
        }
        station
    }

    /// Lowers y = v^1.5 of one end of cell `i` to what can be reached from its other end.
    fn rise(&self, i: usize, (from, to): (usize, usize), all: &mut [S; NODES]) {
        let (Some(station), Some(&y)) = (self.window.get(i), all.get(from)) else { return };
        // The root of the speed is the cube root of y.
        let root = cube_root(y).greatest(S::of(1.0e-3));
        let by_acceleration = S::of(ACCELERATION) * station.bounds.acceleration / root;
        let slope = station.bounds.jerk.sqrt().least(by_acceleration);
        let most = y + S::of(1.5) * slope * station.cell.length;
        if let Some(y) = all.get_mut(to) {
            *y = y.least(most);
        }
    }

    /// v^1.5 of the stations of a range, of which nothing is known: that of the first as it is, 0 at rests,
    /// elsewhere what constant speed over the cells on both sides allows.
    fn steady(&self, cells: Range<usize>, y: &mut [S; NODES]) {
        let Range { start, end: last } = cells.clone();
        for i in cells {
            let Some((station, after)) = self.window.pair(i) else { return };
            if station.cell.length > S::ZERO {
                // A rest has the direction in which the motion goes on from there: the shape of a cell that
                // ends in one is not that of a motion which does not stop.
                let end = station.arrival(after);
                let cubes = steady_cubes(&View { to: &end, ..station.view(after, self.limits) });
                for (y, cube) in some_mut::<_, 2>(y, i).into_iter().flatten().zip(cubes) {
                    *y = y.least(cube);
                }
            }
        }
        for i in start..=last {
            let (Some(station), Some(y)) = (self.window.get(i), y.get_mut(i)) else { return };
            let cube = if i == start {
                station.state.b * station.state.b.sqrt()
            } else if station.rest || i == last {
                S::ZERO
            } else {
                *y
            };
            *y = cube.sqrt();
        }
    }
}
