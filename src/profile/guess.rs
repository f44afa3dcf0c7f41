//! First states for stations that have none: fast ones near the least time that may break limits,
//! and slow ones that keep them.

use super::law::{Law, State};
use super::rows::{Axis, View};
use super::solver::{Solver, Stretch};
use super::window::Window;
use crate::machine::Limits;
use crate::number::{Scalar, cube_root};

/// Share of an axis's acceleration that is used at constant speed.
const STEADY_ACCELERATION: f64 = 0.9;
/// Share of an axis's jerk that is used at constant speed.
const STEADY_JERK: f64 = 0.7;
/// Share of the feed.
const STEADY_FEED: f64 = 0.985;
/// Share of the acceleration along the path that is used to change speed.
const ACCELERATION: f64 = 0.7;
/// Most relative change of v^2 that a guessed acceleration makes over a cell, by half. Below 0.75 there
/// is a motion between any two guesses ([`Law`]).
const STEEPEST: f64 = 0.7;
/// Most halvings of the speeds of a slow seed.
const SEED_TRIES: usize = 40;

/// Greatest v^3 at both ends of a cell that constant speed allows.
fn steady_cubes<S: Scalar, const N: usize>(view: &View<'_, S, N>) -> [S; 2] {
    let feed = view.bounds.goal * S::of(STEADY_FEED);
    let mut cubes = [feed * feed * feed; 2];
    if view.cell.straight {
        return cubes;
    }
    let law = Law::steady(view.cell.length);
    for (i, limits) in view.limits.axes().iter().enumerate() {
        let axis = Axis::new(view, &law, i);
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
    }
    cubes
}

impl<S: Scalar, const NODES: usize> Solver<S, NODES> {
    /// Gives the stations from index `new` on, and those before on which the motion brakes towards
    /// it, states near those of least time: the speed that the path's shape allows, held down
    /// where it could not be reached or left. Limits may be broken, but between any two states there
    /// is a motion.
    ///
    /// It works with y = v^1.5, of which leaving a slow place at constant jerk J makes a straight
    /// line: v' = sqrt(J v) is dy / ds = 1.5 sqrt(J), and for a start from rest it is exact
    /// within a factor of 2 in J.
    pub fn guess<const N: usize>(
        &mut self,
        window: &mut Window<S, N, NODES>,
        stretch: Stretch,
        new: usize,
        limits: &Limits<S, N>,
    ) {
        let Stretch { first, last, .. } = stretch;
        // At most back to the first station.
        let brakes = |i: &usize| window.get(*i).is_some_and(|station| station.state.a < S::ZERO);
        let braking = (first + 1..new.min(last)).rev().take_while(brakes).count();
        let start = new.min(last).saturating_sub(1 + braking).max(first);
        self.steady(window, (start, last), limits);
        let rise = |i: usize, y: S| -> S {
            let Some(station) = window.get(i) else { return S::ZERO };
            // The root of the speed is the cube root of y.
            let root = cube_root(y).greatest(S::of(1.0e-3));
            let by_acceleration = S::of(ACCELERATION) * station.bounds.acceleration / root;
            let slope = station.bounds.jerk.sqrt().least(by_acceleration);
            S::of(1.5) * slope * station.cell.length
        };
        for i in start..last {
            let Some([here, next]) = self.two(i) else { return };
            let y = here.step[0];
            next.step[0] = next.step[0].least(y + rise(i, y));
        }
        for i in (start + 1..last).rev() {
            let Some([here, next]) = self.two(i) else { return };
            let y = next.step[0];
            here.step[0] = here.step[0].least(y + rise(i, y));
        }
        for (i, work) in (start..last).zip(self.works(start, last)).skip(1) {
            if Self::is_free(window, stretch, i) {
                let y = work.step[0];
                window.set_state(i, State { b: y * cube_root(y), a: S::ZERO });
            }
        }
        let mut before = window.get(start).map_or(S::ZERO, |station| station.state.b);
        for i in start + 1..last {
            let Some((arriving, here)) = window.pair(i - 1) else { return };
            let b = here.state.b;
            let after = window.get(i + 1).filter(|_| i + 1 < last);
            let rise = after.map_or(S::ZERO, |station| station.state.b) - before;
            let lengths = (arriving.cell.length, here.cell.length);
            if Self::is_free(window, stretch, i) {
                let most = S::of(STEEPEST) * b / lengths.0.greatest(lengths.1);
                let a = rise * S::of(0.5) / (lengths.0 + lengths.1);
                window.set_state(i, State { b, a: a.least(most).greatest(-most) });
            }
            before = b;
        }
    }

    /// v^1.5 of the stations of a range into the workspace: that of the first as it is, 0 at rests,
    /// elsewhere what constant speed over the cells on both sides allows.
    fn steady<const N: usize>(
        &mut self,
        window: &Window<S, N, NODES>,
        (start, last): (usize, usize),
        limits: &Limits<S, N>,
    ) {
        for work in self.works(start, last) {
            work.step = [S::of(1.0e30); 2];
        }
        for i in start..last {
            let Some((station, after)) = window.pair(i) else { return };
            if station.cell.length > S::ZERO {
                // A rest has the direction in which the motion goes on from there: the shape of a cell that
                // ends in one is not that of a motion which does not stop.
                let end = station.arrival(after);
                let cubes = steady_cubes(&View { to: &end, ..station.view(after, limits) });
                for (work, cube) in self.two(i).into_iter().flatten().zip(cubes) {
                    work.step[0] = work.step[0].least(cube);
                }
            }
        }
        for (i, work) in (start..).zip(self.works(start, last)) {
            let Some(station) = window.get(i) else { return };
            let cube = if i == start {
                station.state.b * station.state.b.sqrt()
            } else if station.rest || i == last {
                S::ZERO
            } else {
                work.step[0]
            };
            work.step[0] = cube.sqrt();
        }
    }

    /// Gives the free stations from index `new` on slow speeds at which all limits hold: every cell
    /// takes about the same time, long enough. Those before keep theirs. Returns whether such a
    /// time was found.
    pub fn seed<const N: usize>(
        &mut self,
        window: &mut Window<S, N, NODES>,
        stretch: Stretch,
        new: usize,
        limits: &Limits<S, N>,
    ) -> bool {
        let new = new.max(stretch.first + 1);
        let cells = (new - 1, stretch.last);
        for work in self.works(cells.0, cells.1) {
            work.step = [S::ZERO; 2];
        }
        let mut rate = S::ONE / (limits.time_scale() * S::of(0.125));
        // The first new station was the stop of the plan before: what it may have is little if
        // that plan brakes hard, and should not hold back the others.
        let mut entry = S::of(1.0e-3);
        let mut found = false;
        for _ in 0..SEED_TRIES {
            Self::seed_speeds(window, stretch, new, rate, entry);
            found = self.value(window, stretch, limits, (S::ZERO, S::ZERO), cells).is_some();
            if found {
                break;
            }
            rate = rate * S::of(0.5);
        }
        if !found {
            return false;
        }
        let best = [S::of(0.004), S::of(0.016), S::of(0.06), S::of(0.25), S::ONE];
        for wider in best {
            Self::seed_speeds(window, stretch, new, rate, wider);
            if self.value(window, stretch, limits, (S::ZERO, S::ZERO), cells).is_none() {
                break;
            }
            entry = wider;
        }
        Self::seed_speeds(window, stretch, new, rate, entry);
        true
    }

    /// Gives every new station the speed at which the shorter of its cells takes 1 / `rate`; the
    /// first one only the share `entry` of it.
    fn seed_speeds<const N: usize>(
        window: &mut Window<S, N, NODES>,
        stretch: Stretch,
        new: usize,
        rate: S,
        entry: S,
    ) {
        let mut before = S::of(1.0e6);
        for i in new - 1..stretch.last {
            let Some(station) = window.get(i) else { return };
            let here = if station.cell.length > S::ZERO {
                (station.cell.length * rate).least(station.bounds.goal * S::of(0.7))
            } else {
                S::ZERO
            };
            let mut speed = before.least(here);
            before = here;
            if i >= new {
                if i == new {
                    speed = speed * entry;
                }
                let b = if Self::is_free(window, stretch, i) { speed * speed } else { S::ZERO };
                window.set_state(i, State { b, a: S::ZERO });
            }
        }
    }
}
