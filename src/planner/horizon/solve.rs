//! States for a stretch of the horizon.

use super::Horizon;
use crate::machine::LimitSets;
use crate::number::Scalar;
use crate::profile::law::{Law, PathState};
use crate::profile::seeding::Seeding;
use crate::profile::solver::{Aim, Stretch};
use crate::profile::solving::Solving;
use crate::servo::link::Room;
#[cfg(test)]
use crate::servo::piece::Slot;
use core::ops::Range;

/// Share by which a bound lies above a speed that exceeds what is asked for; the limits of the axes
/// have as much in reserve.
pub const EXCESS: f64 = 1.0001;

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Whether the states of a stretch keep all limits, with a rest at its end, and the rows that lead the solver, and no cell is over too soon.
    pub fn holds(&mut self, stretch: Stretch) -> bool {
        self.holds_until(stretch, stretch.last)
    }

    /// Whether they keep all limits.
    pub fn keeps_limits(&mut self, stretch: Stretch) -> bool {
        self.solver
            .on(&mut self.window, LimitSets::new(&self.config, &self.older), stretch)
            .keeps_limits()
    }

    /// The same up to station `until`.
    pub fn holds_until(&mut self, stretch: Stretch, until: usize) -> bool {
        self.lasts(Stretch { last: until, ..stretch })
            && self
                .solver
                .on(&mut self.window, LimitSets::new(&self.config, &self.older), stretch)
                .until(until)
                .holds()
    }

    /// To improve the states of a stretch for an aim.
    #[inline(never)]
    pub fn begin_improving(&mut self, stretch: Stretch, aim: Aim) -> Solving<S> {
        let iterations = self.config.iterations;
        self.solver
            .on(&mut self.window, LimitSets::new(&self.config, &self.older), stretch)
            .improve(iterations, aim)
    }

    /// To find states for a stretch, from a guess at the stations from index `new` on, which need not lead to a motion.
    pub fn begin_finding(&mut self, stretch: Stretch, new: usize) -> Solving<S> {
        let iterations = self.config.iterations;
        let mut problem =
            self.solver.on(&mut self.window, LimitSets::new(&self.config, &self.older), stretch);
        problem.guess(new);
        problem.find(iterations)
    }

    /// To improve the states of a stretch for an aim, in a few steps, but for those from station `until` on, which
    /// stay as they are.
    pub fn begin_improving_until(
        &mut self,
        stretch: Stretch,
        until: usize,
        (steps, aim): (u16, Aim),
    ) -> Solving<S> {
        self.solver
            .on(&mut self.window, LimitSets::new(&self.config, &self.older), stretch)
            .until(until)
            .improve(steps, aim)
    }

    /// A part of a Newton step, if one is left, in the room for the plan. Whether there was.
    // Once in the image, however often it is called.
    #[inline(never)]
    pub fn go_on(&mut self, solving: &mut Solving<S>, room: Room<'_, S, N>) -> bool {
        solving.go_on(
            (&mut self.solver, room),
            &mut self.window,
            LimitSets::new(&self.config, &self.older),
            &mut self.steps,
        )
    }

    /// All parts of all steps of a problem.
    #[cfg(test)]
    pub fn solve(&mut self, mut solving: Solving<S>) {
        let slots = [const { Slot::EMPTY }; NODES];
        let room = Room { slots: &slots, number: self.solver.problems() };
        // Bounded by the iterations that are set, and the parts of one.
        while self.go_on(&mut solving, room) {}
    }

    /// Improves the states of a stretch for an aim.
    #[cfg(test)]
    pub fn improve(&mut self, stretch: Stretch, aim: Aim) {
        let solving = self.begin_improving(stretch, aim);
        self.solve(solving);
    }

    /// To look for slow states of a stretch from index `new` on.
    pub fn begin_seeding(&self, stretch: Stretch, new: usize) -> Seeding<S> {
        Seeding::new(LimitSets::new(&self.config, &self.older), stretch, new)
    }

    /// A try for slow states; see [`crate::profile::seeding`].
    pub fn seed(&mut self, stretch: Stretch, seeding: &mut Seeding<S>) -> Option<bool> {
        self.solver
            .on(&mut self.window, LimitSets::new(&self.config, &self.older), stretch)
            .seed(seeding)
    }

    /// Gives stations the states of the plan that is being executed.
    #[inline(never)]
    pub fn take_agreed(&mut self, stations: Range<usize>) {
        for i in stations {
            if let Some(station) = self.window.get_mut(i) {
                station.state = station.agreed;
            }
        }
    }

    /// Lets the speed bounds of planned cells be no less than the speeds of the plan: an override
    /// may have been lowered since.
    ///
    /// Where only one end of a cell has a new state, what lies between is neither the agreed motion nor a new one, and may
    /// be faster than both: nothing is let go beyond what the axes allow, but for a motion that is agreed.
    pub fn loosen(&mut self, first: usize, last: usize) {
        for i in first..last {
            let Some((station, after)) = self.window.pair(i) else { return };
            let length = station.cell.length;
            let Some(most) = most_speed(length, station.state, after.state) else { continue };
            let goal = station.bounds.goal;
            let speed = if most < goal {
                goal
            } else {
                let agreed = self.greatest_speed(i).unwrap_or(S::ZERO);
                let (most, agreed) = (most * S::of(EXCESS), agreed * S::of(EXCESS));
                // What the axes allow is much to ask for, and counts only where it would be faster than agreed.
                if most > agreed {
                    most.least(self.speed_of_axes(i).greatest(agreed))
                } else {
                    most
                }
            };
            if let Some(station) = self.window.get_mut(i) {
                station.bounds.speed = speed.greatest(goal);
            }
        }
    }

    /// The greatest speed, mm/s, of the agreed motion over the cell of station `i`.
    pub fn greatest_speed(&self, i: usize) -> Option<S> {
        let (station, after) = self.window.pair(i)?;
        most_speed(station.cell.length, station.agreed, after.agreed)
    }
}

/// The greatest of the Bernstein coefficients of the speed over a cell, mm/s.
fn most_speed<S: Scalar>(length: S, from: PathState<S>, to: PathState<S>) -> Option<S> {
    let law = Law::new(length, from, to)?;
    let [early, late] = law.inner_speeds();
    Some(law.v0.greatest(law.v1).greatest(early.greatest(late)))
}
