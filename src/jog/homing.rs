//! How an axis finds its switch: a small state machine, for each axis by itself.
//!
//! | phase | where to | ends |
//! |---|---|---|
//! | [`Leaves`](HomePhase::Leaves) | off a switch that is closed at the start, by the way back | at rest, the switch open |
//! | [`Seeks`](HomePhase::Seeks) | towards the switch, fast | by its edge |
//! | [`BacksOff`](HomePhase::BacksOff) | to the way back before the edge | at rest, the switch open |
//! | [`Latches`](HomePhase::Latches) | towards the switch, slowly | by its edge, which is the one that counts |
//! | [`Parks`](HomePhase::Parks) | to where it shall stand | at rest |

use crate::number::Coord;

/// How one axis is homed: [`Planner::home`](crate::Planner::home) (feature `home`). mm, or degrees on a rotary axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisHome<S> {
    /// Speed of the first approach and of the ways back, mm/s; its sign says on which side the switch is.
    pub fast: S,
    /// Speed of the second approach, mm/s, whatever its sign.
    pub slow: S,
    /// How far away the switch may be, mm: without an edge the axis ends there, with an error.
    pub reach: Coord,
    /// How far it goes back from the switch, mm: more than the switch needs to open. The second approach ends as far behind the first
    /// edge, if there is none.
    pub back: Coord,
    /// The coordinate of the edge.
    pub at: Coord,
    /// Where the axis shall stand in the end, in the new coordinates; `None`: where it comes to rest behind the edge.
    pub park: Option<Coord>,
    /// Axes of a lower number are homed before those of a higher one; those of the same at once.
    pub order: u8,
}

/// What an axis does while it is homed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum HomePhase {
    /// It is done, or has not been asked for.
    #[default]
    Done,
    /// Others come before it.
    Waits,
    /// Away from a switch that was closed at the start.
    Leaves,
    /// To the switch, fast.
    Seeks,
    /// Back from its edge.
    BacksOff,
    /// To the switch, slowly.
    Latches,
    /// To where it shall stand.
    Parks,
}

/// What has gone wrong with an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum HomeFault {
    /// The switch has not closed within the way it was given.
    Missing,
    /// The switch is still closed after the way back.
    Stuck,
    /// A cancel or an abort came.
    Cancelled,
}

/// Why an axis has not been homed: the coordinates are as they were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HomeFailure {
    /// Index of the axis: of the first that had something to do, if all were stopped.
    pub axis: usize,
    /// What it was doing.
    pub phase: HomePhase,
    /// What has gone wrong.
    pub fault: HomeFault,
}

impl core::fmt::Display for HomeFailure {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let phase = match self.phase {
            HomePhase::Done | HomePhase::Waits => "at rest",
            HomePhase::Leaves => "leaving its switch",
            HomePhase::Seeks => "seeking its switch",
            HomePhase::BacksOff => "backing off",
            HomePhase::Latches => "approaching its switch slowly",
            HomePhase::Parks => "on its way from the switch",
        };
        let fault = match self.fault {
            HomeFault::Missing => "the switch does not close",
            HomeFault::Stuck => "the switch does not open",
            HomeFault::Cancelled => "cancelled",
        };
        write!(f, "axis {}, {phase}: {fault}", self.axis)
    }
}

impl core::error::Error for HomeFailure {}

/// What one axis shall do from a servo cycle on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AxisAim {
    /// Go on.
    Keep,
    /// To a place, at a speed in mm per cycle at most.
    Place(Coord, f64),
    /// To rest, as short as can be.
    Halt,
}

/// One axis, on its way.
#[derive(Clone, Copy, Debug)]
pub struct AxisHoming {
    /// Speeds, mm per cycle.
    fast: f64,
    slow: f64,
    /// Towards the switch: 1 or -1.
    side: i64,
    reach: Coord,
    back: Coord,
    at: Coord,
    park: Option<Coord>,
    order: u8,
    phase: HomePhase,
    /// Where the way of the phase ends.
    goal: Coord,
    /// Where the switch closed, on the last approach.
    edge: Option<Coord>,
    /// What it shall do, and whether it does.
    want: AxisAim,
    planned: bool,
}

impl AxisHoming {
    /// An axis that has nothing to do.
    pub const NONE: Self = Self {
        fast: 0.0,
        slow: 0.0,
        side: 0,
        reach: Coord::ZERO,
        back: Coord::ZERO,
        at: Coord::ZERO,
        park: None,
        order: 0,
        phase: HomePhase::Done,
        goal: Coord::ZERO,
        edge: None,
        want: AxisAim::Keep,
        planned: false,
    };

    /// One that is to be homed; `cycle` in s.
    pub fn new(home: &AxisHome<f64>, cycle: f64) -> Self {
        Self {
            fast: home.fast.abs() * cycle,
            slow: home.slow.abs() * cycle,
            side: if home.fast > 0.0 { 1 } else { -1 },
            reach: home.reach,
            back: home.back,
            at: home.at,
            park: home.park,
            order: home.order,
            phase: HomePhase::Waits,
            ..Self::NONE
        }
    }

    pub fn phase(&self) -> HomePhase {
        self.phase
    }

    pub fn order(&self) -> u8 {
        self.order
    }

    /// Whether an edge would end what it does.
    pub fn seeks(&self) -> bool {
        matches!(self.phase, HomePhase::Seeks | HomePhase::Latches) && self.edge.is_none()
    }

    /// Whether the way under way is planned.
    pub fn aim(&self) -> AxisAim {
        if self.planned { AxisAim::Keep } else { self.want }
    }

    /// A plan is under way in which it does what was wanted then.
    pub fn set_planned(&mut self, done: AxisAim) {
        self.planned |= self.want == done;
    }

    fn set_want(&mut self, want: AxisAim) {
        (self.want, self.planned) = (want, false);
    }

    /// To rest, if it does not come there already.
    pub fn halt(&mut self) {
        if self.want != AxisAim::Halt {
            self.set_want(AxisAim::Halt);
        }
    }

    /// To rest, if all are to.
    pub fn halt_if(&mut self, stops: bool) {
        if stops {
            self.halt();
        }
    }

    /// At rest.
    pub fn rest(&mut self) {
        self.planned = true;
    }

    /// Its switch has closed.
    pub fn found(&mut self, edge: Coord) {
        self.edge = Some(edge);
        self.halt();
    }

    fn go(&mut self, phase: HomePhase, goal: Coord) {
        (self.phase, self.goal) = (phase, goal);
        let speed = if phase == HomePhase::Latches { self.slow } else { self.fast };
        self.set_want(AxisAim::Place(goal, speed));
    }

    fn done(&mut self) {
        (self.phase, self.planned) = (HomePhase::Done, true);
    }

    /// A place so far towards the switch.
    fn towards(&self, from: Coord, way: Coord) -> Coord {
        Coord::from_raw(from.raw().saturating_add(self.side * way.raw()))
    }

    fn away(&self, from: Coord) -> Coord {
        Coord::from_raw(from.raw().saturating_sub(self.side * self.back.raw()))
    }

    /// What is added to its coordinate when all are done.
    pub fn shift(&self) -> i64 {
        self.edge.map_or(0, |edge| self.at.raw().saturating_sub(edge.raw()))
    }

    /// At rest: what comes next. `is_turn`: no axis comes before it; `closed`: its switch is. Whether an edge counts from now on.
    pub fn step(&mut self, here: Coord, is_turn: bool, closed: bool) -> Result<bool, HomeFault> {
        let arrived = here == self.goal;
        let seek = |homing: &mut Self, way: Coord| {
            homing.edge = None;
            homing.go(HomePhase::Seeks, homing.towards(here, way));
            Ok(true)
        };
        match (self.phase, self.edge) {
            (HomePhase::Done, _) => {}
            (HomePhase::Waits, _) if !is_turn => {}
            (HomePhase::Waits, _) if closed => self.go(HomePhase::Leaves, self.away(here)),
            (HomePhase::Waits, _) => return seek(self, self.reach),
            (HomePhase::Seeks, Some(edge)) => self.go(HomePhase::BacksOff, self.away(edge)),
            (HomePhase::Latches, Some(edge)) => match self.park {
                Some(park) => {
                    let park = park.raw().saturating_sub(self.at.raw());
                    let goal = Coord::from_raw(edge.raw().saturating_add(park));
                    self.go(HomePhase::Parks, goal);
                }
                None => self.done(),
            },
            // It was held on its way.
            (phase, _) if !arrived => self.go(phase, self.goal),
            (HomePhase::Leaves | HomePhase::BacksOff, _) if closed => return Err(HomeFault::Stuck),
            // It was closed that far away, and may close later than it opens.
            (HomePhase::Leaves, _) => {
                return seek(self, Coord::from_raw(self.back.raw().saturating_mul(2)));
            }
            (HomePhase::BacksOff, edge) => {
                let end = self.towards(edge.unwrap_or(here), self.back);
                self.edge = None;
                self.go(HomePhase::Latches, end);
                return Ok(true);
            }
            (HomePhase::Seeks | HomePhase::Latches, None) => return Err(HomeFault::Missing),
            (HomePhase::Parks, _) => self.done(),
        }
        Ok(false)
    }
}
