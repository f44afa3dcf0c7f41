//! Steps and directions.

use super::scale::Scale;
use crate::number::Coord;
use core::fmt;
use embedded_hal::digital::OutputPin;

/// What a drive's data sheet asks of the edges, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EdgeTimes {
    /// Least width of a pulse.
    pub pulse: u32,
    /// Least time between two pulses.
    pub pause: u32,
    /// Least time from a change of direction to the next step.
    pub setup: u32,
    /// Least time from the end of a pulse to a change of direction.
    pub hold: u32,
}

/// What the drive asks of the edges, in ticks of the step timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StepTiming {
    /// Ticks per servo cycle.
    pub ticks: u32,
    /// Least width of a pulse.
    pub pulse: u32,
    /// Least time between two pulses.
    pub pause: u32,
    /// Least time from a change of direction to the next step.
    pub setup: u32,
    /// Least time from the end of a pulse to a change of direction.
    pub hold: u32,
}

impl StepTiming {
    /// From a data sheet: rate of the step timer, Hz; servo cycle, µs; the drive's times, ns. Times are
    /// rounded up to whole ticks, and one at least; the ticks of a servo cycle are rounded down, to none where
    /// the timer is slower than the cycle, which [`StepDir::new`] refuses.
    pub const fn from_ns(timer_hz: u32, cycle_us: u32, drive: EdgeTimes) -> Self {
        let EdgeTimes { pulse, pause, setup, hold } = drive;
        let ticks = timer_hz as u64 * cycle_us as u64 / 1_000_000;
        Self {
            ticks: if ticks > u32::MAX as u64 { u32::MAX } else { ticks as u32 },
            pulse: whole_ticks(timer_hz, pulse),
            pause: whole_ticks(timer_hz, pause),
            setup: whole_ticks(timer_hz, setup),
            hold: whole_ticks(timer_hz, hold),
        }
    }

    /// Most steps that fit into a servo cycle, also if it begins with a change of direction.
    pub const fn most_steps(&self) -> u32 {
        let period = self.pulse.saturating_add(self.pause);
        let turn = self.setup.saturating_add(self.hold);
        match self.ticks.saturating_sub(turn).checked_div(period) {
            Some(steps) => steps,
            None => 0,
        }
    }
}

const fn whole_ticks(timer_hz: u32, ns: u32) -> u32 {
    // 2^64 / 1e9 is more than 2^32.
    let ticks = (timer_hz as u64 * ns as u64).div_ceil(1_000_000_000);
    if ticks == 0 {
        1
    } else if ticks > u32::MAX as u64 {
        u32::MAX
    } else {
        ticks as u32
    }
}

/// Why an axis cannot be driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StepError<E> {
    /// The axis may be faster than the timing allows.
    TooFast {
        /// Steps per servo cycle at its greatest velocity.
        steps: u32,
        /// Steps that fit into one.
        most: u32,
    },
    /// A servo cycle, pulse, pause, set-up or hold time of 0 ticks.
    NoTime,
    /// A pin did not take its level.
    Pin(E),
}

impl<E: fmt::Debug> fmt::Display for StepError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFast { steps, most } => {
                write!(f, "{steps} steps per servo cycle at full speed; {most} fit into one")
            }
            Self::NoTime => {
                f.write_str("servo cycle, pulse, pause, set-up and hold must be 1 tick at least")
            }
            Self::Pin(error) => write!(f, "a pin does not take its level: {error:?}"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for StepError<E> {}

/// One axis with step and direction.
///
/// Once per servo cycle [`StepDir::begin`] takes the new setpoint; [`StepDir::tick`], called `ticks` times
/// until the next, gives the steps, spread evenly. The axis so is one servo cycle behind its
/// setpoint, all axes alike. Steps are counted when they are made, and what is owed is always the
/// difference to the setpoint: no step can be lost or made twice, whatever happens in between. Where ticks
/// are missing the axis falls behind, which [`StepDir::begin`] says; where a servo cycle is late it stands at
/// its setpoint and waits.
#[derive(Debug)]
pub struct StepDir<STEP, DIR> {
    step: STEP,
    dir: DIR,
    timing: StepTiming,
    scale: Scale,
    /// Most steps of a servo cycle.
    most: u32,
    /// Steps made, and where the last setpoint is.
    at: i64,
    target: i64,
    /// Steps of this servo cycle, and whether they go back.
    count: u32,
    back: bool,
    /// Of those, how many have not become due yet, and how many have and have not been made.
    ahead: u32,
    due: u32,
    /// Where between two steps the cycle is, in `count` per tick and `ticks` per step.
    phase: u32,
    /// Level of the direction pin.
    level: bool,
    /// Ticks until the pulse under way ends; 0 between pulses.
    high: u32,
    /// Ticks until the next step may be made, and until the direction may change.
    wait: u32,
    hold: u32,
}

impl<STEP, DIR, E> StepDir<STEP, DIR>
where
    STEP: OutputPin<Error = E>,
    DIR: OutputPin<Error = E>,
{
    /// An axis that stands at `start`, both pins low. `most` is the number of steps per servo cycle at the
    /// axis's greatest velocity (rounded up).
    ///
    /// # Errors
    /// [`StepError::TooFast`] or [`StepError::NoTime`] if the timing does not allow it;
    /// [`StepError::Pin`].
    pub fn new(
        mut step: STEP,
        mut dir: DIR,
        scale: Scale,
        timing: StepTiming,
        start: Coord,
        most: u32,
    ) -> Result<Self, StepError<E>> {
        let StepTiming { ticks, pulse, pause, setup, hold } = timing;
        if ticks == 0 || pulse == 0 || pause == 0 || setup == 0 || hold == 0 {
            return Err(StepError::NoTime);
        }
        if most > timing.most_steps() {
            return Err(StepError::TooFast { steps: most, most: timing.most_steps() });
        }
        step.set_low().map_err(StepError::Pin)?;
        dir.set_low().map_err(StepError::Pin)?;
        let at = scale.steps(start);
        Ok(Self {
            step,
            dir,
            timing,
            scale,
            most,
            at,
            target: at,
            count: 0,
            back: false,
            ahead: 0,
            due: 0,
            phase: 0,
            level: false,
            high: 0,
            wait: setup,
            hold: 0,
        })
    }

    /// Takes the setpoint of a servo cycle. Returns how many steps to the one before have not been made:
    /// 0 as long as the axis keeps to its limits and [`StepDir::tick`] has been called often enough. They
    /// are owed on, and made as fast as the axis's greatest velocity allows.
    pub fn begin(&mut self, setpoint: Coord) -> u32 {
        let owed = |to: i64, at: i64| u32::try_from(to.abs_diff(at)).unwrap_or(u32::MAX);
        let left = owed(self.target, self.at);
        self.target = self.scale.steps(setpoint);
        self.back = self.target < self.at;
        self.count = owed(self.target, self.at).min(self.most);
        (self.ahead, self.due) = (self.count, 0);
        // The first step comes after half a period: so neighbouring cycles fit together.
        self.phase = self.timing.ticks / 2;
        left
    }

    /// Takes other coordinates for the place of the last setpoint
    /// ([`Activity::Set`](crate::Activity) of homing): no step is made for it, and none that is owed is lost.
    pub fn rebase(&mut self, setpoint: Coord) {
        let target = self.scale.steps(setpoint);
        self.at = self.at.saturating_add(target.saturating_sub(self.target));
        self.target = target;
    }

    /// One tick of the step timer: at most one edge.
    ///
    /// Cost: some ten instructions without a step due, twice as many with.
    ///
    /// # Errors
    /// The pin's; the edge is tried again at the next tick, and not counted before.
    pub fn tick(&mut self) -> Result<(), E> {
        debug_assert!(self.ahead + self.due <= self.count, "more steps than are owed");
        debug_assert!(self.phase < self.timing.ticks, "a phase beyond its step");
        if self.ahead > 0 {
            let left = self.timing.ticks - self.phase;
            if self.count >= left {
                self.phase = self.count - left;
                self.due += 1;
                self.ahead -= 1;
            } else {
                self.phase += self.count;
            }
        }
        self.hold = self.hold.saturating_sub(1);
        if self.high > 1 {
            self.high -= 1;
            return Ok(());
        }
        if self.high == 1 {
            self.step.set_low()?;
            self.high = 0;
            self.wait = self.timing.pause;
            self.hold = self.timing.hold;
            return Ok(());
        }
        self.wait = self.wait.saturating_sub(1);
        if self.due == 0 && self.ahead == 0 {
            return Ok(());
        }
        // As early as may be: the first step may be due before the set-up time is over.
        if self.back != self.level {
            if self.hold > 0 {
                return Ok(());
            }
            if self.back {
                self.dir.set_high()?;
            } else {
                self.dir.set_low()?;
            }
            self.level = self.back;
            self.wait = self.wait.max(self.timing.setup);
            return Ok(());
        }
        if self.due == 0 || self.wait > 0 {
            return Ok(());
        }
        self.step.set_high()?;
        self.due -= 1;
        self.at += if self.back { -1 } else { 1 };
        self.high = self.timing.pulse;
        Ok(())
    }

    /// Steps made, counted from the machine's zero.
    pub fn steps(&self) -> i64 {
        self.at
    }

    /// Gives the pins back.
    pub fn release(self) -> (STEP, DIR) {
        (self.step, self.dir)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::convert::Infallible;
    use embedded_hal::digital::ErrorType;
    use std::vec::Vec;

    /// A level.
    #[derive(Default)]
    struct Pin(bool);

    impl ErrorType for Pin {
        type Error = Infallible;
    }

    impl OutputPin for Pin {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.0 = false;
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Infallible> {
            self.0 = true;
            Ok(())
        }
    }

    const TIMING: StepTiming = StepTiming { ticks: 100, pulse: 2, pause: 2, setup: 3, hold: 2 };

    /// An axis of 1,000 nm per step.
    fn axis(most: u32) -> StepDir<Pin, Pin> {
        let scale = Scale::new(1, 1000).unwrap();
        StepDir::new(Pin::default(), Pin::default(), scale, TIMING, Coord::ZERO, most).unwrap()
    }

    fn at(steps: i64) -> Coord {
        Coord::from_nm(steps * 1000).unwrap()
    }

    /// Ticks of a servo cycle at which a pulse rises.
    fn cycle(axis: &mut StepDir<Pin, Pin>) -> Vec<u32> {
        let mut rises = Vec::new();
        for tick in 0..TIMING.ticks {
            let before = axis.step.0;
            axis.tick().unwrap();
            if axis.step.0 && !before {
                rises.push(tick);
            }
        }
        rises
    }

    #[test]
    fn as_many_steps_as_the_rounded_setpoint_asks_for_spread_evenly() {
        let mut axis = axis(20);
        for target in [7, 7, 20, 3, -12, -12, 0] {
            let before = axis.steps();
            assert_eq!(axis.begin(at(target)), 0);
            let rises = cycle(&mut axis);
            assert_eq!(rises.len() as u64, target.abs_diff(before));
            assert_eq!(axis.steps(), target);
            let even = TIMING.ticks / (rises.len() as u32).max(1);
            assert!(
                rises.windows(2).all(|pair| (pair[1] - pair[0]).abs_diff(even) <= 1),
                "{rises:?}"
            );
        }
        assert!(axis.dir.0 == axis.back && axis.steps() == 0);
    }

    /// What does not fit into a cycle is told, owed on, and made as fast as the axis goes.
    #[test]
    fn missing_steps_are_told_and_made_up_for() {
        let mut axis = axis(10);
        axis.begin(at(25));
        cycle(&mut axis);
        assert_eq!((axis.steps(), axis.begin(at(25))), (10, 15));
        cycle(&mut axis);
        assert_eq!((axis.steps(), axis.begin(at(25))), (20, 5));
        cycle(&mut axis);
        assert_eq!((axis.steps(), axis.begin(at(25))), (25, 0));
    }

    #[test]
    fn times_become_whole_ticks_rounded_up() {
        let drive = EdgeTimes { pulse: 1, pause: 10_000, setup: 10_001, hold: 0 };
        let timing = StepTiming::from_ns(100_000, 1000, drive);
        assert_eq!(timing, StepTiming { ticks: 100, pulse: 1, pause: 1, setup: 2, hold: 1 });
        assert_eq!(TIMING.most_steps(), 23);
    }

    #[test]
    fn other_coordinates_are_no_steps() {
        let mut axis = axis(20);
        axis.begin(at(7));
        assert_eq!(cycle(&mut axis).len(), 7);
        axis.rebase(at(-500));
        assert_eq!((axis.begin(at(-500)), cycle(&mut axis).len(), axis.at), (0, 0, -500));
        axis.begin(at(-503));
        assert_eq!((cycle(&mut axis).len(), axis.at), (3, -503));
        // What is owed is made up for.
        axis.begin(at(-500));
        axis.rebase(at(100));
        assert_eq!((axis.begin(at(100)), cycle(&mut axis).len(), axis.at), (3, 3, 100));
    }
}
