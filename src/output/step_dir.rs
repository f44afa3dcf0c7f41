//! Steps and directions.

use super::scale::Scale;
use crate::number::Coord;
use core::fmt;
use embedded_hal::digital::OutputPin;

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
    /// rounded up to whole ticks, and one at least.
    pub const fn from_ns(
        timer_hz: u32,
        cycle_us: u32,
        [pulse, pause, setup, hold]: [u32; 4],
    ) -> Self {
        Self {
            ticks: (timer_hz as u64 * cycle_us as u64 / 1_000_000) as u32,
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
    let ticks = (timer_hz as u64 * ns as u64).div_ceil(1_000_000_000) as u32;
    if ticks == 0 { 1 } else { ticks }
}

/// Why an axis cannot be driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StepError<E> {
    /// The axis may be faster than the timing allows.
    TooFast {
        /// Steps per servo cycle at its greatest velocity.
        steps: u32,
        /// Steps that fit into one.
        most: u32,
    },
    /// A pulse, pause, set-up or hold time of 0 ticks.
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
            Self::NoTime => f.write_str("pulse, pause, set-up and hold must be 1 tick at least"),
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
/// difference to the setpoint: no step can be lost or made twice, whatever happens in between.
#[derive(Debug)]
pub struct StepDir<STEP, DIR> {
    step: STEP,
    dir: DIR,
    timing: StepTiming,
    scale: Scale,
    /// Steps made.
    at: i64,
    /// Steps of this servo cycle, and whether they go back.
    count: u32,
    back: bool,
    /// Of those, how many have become due and not been made.
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
        (start, most): (Coord, u32),
    ) -> Result<Self, StepError<E>> {
        let StepTiming { pulse, pause, setup, hold, .. } = timing;
        if pulse == 0 || pause == 0 || setup == 0 || hold == 0 {
            return Err(StepError::NoTime);
        }
        if most > timing.most_steps() {
            return Err(StepError::TooFast { steps: most, most: timing.most_steps() });
        }
        step.set_low().map_err(StepError::Pin)?;
        dir.set_low().map_err(StepError::Pin)?;
        Ok(Self {
            step,
            dir,
            timing,
            scale,
            at: scale.steps(start),
            count: 0,
            back: false,
            due: 0,
            phase: 0,
            level: false,
            high: 0,
            wait: setup,
            hold: 0,
        })
    }

    /// Takes the setpoint of a servo cycle. Returns how many steps of the one before have not been made:
    /// 0 as long as the axis keeps to its limits and [`StepDir::tick`] has been called often enough.
    pub fn begin(&mut self, setpoint: Coord) -> u32 {
        let left = self.due;
        let delta = self.scale.steps(setpoint).saturating_sub(self.at);
        self.back = delta < 0;
        // More than fit into a cycle are owed on.
        self.count = delta.unsigned_abs().min(u64::from(self.timing.ticks)) as u32;
        self.due = 0;
        // The first step comes after half a period: so neighbouring cycles fit together.
        self.phase = self.timing.ticks / 2;
        left
    }

    /// One tick of the step timer: at most one edge.
    ///
    /// Cost: some ten instructions without a step due, twice as many with.
    ///
    /// # Errors
    /// The pin's.
    pub fn tick(&mut self) -> Result<(), E> {
        self.phase += self.count;
        if self.phase >= self.timing.ticks {
            self.phase -= self.timing.ticks;
            self.due += 1;
        }
        self.hold = self.hold.saturating_sub(1);
        if self.high > 0 {
            self.high -= 1;
            if self.high == 0 {
                self.wait = self.timing.pause;
                self.hold = self.timing.hold;
                return self.step.set_low();
            }
            return Ok(());
        }
        self.wait = self.wait.saturating_sub(1);
        if self.due == 0 {
            return Ok(());
        }
        if self.back != self.level {
            if self.hold > 0 {
                return Ok(());
            }
            self.level = self.back;
            self.wait = self.wait.max(self.timing.setup);
            return if self.back { self.dir.set_high() } else { self.dir.set_low() };
        }
        if self.wait > 0 {
            return Ok(());
        }
        self.due -= 1;
        self.at += if self.back { -1 } else { 1 };
        self.high = self.timing.pulse;
        self.step.set_high()
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
