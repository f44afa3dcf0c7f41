//! Step and direction of all axes, beside each other.

use splineway::output::StepDir;
use splineway::{Activity, Coord, Scalar, Setpoint};

/// Where the axes are to be at the end of a servo cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Targets<const N: usize> {
    /// Place of every axis.
    pub place: [Coord; N],
    /// These are other coordinates for the place where the axes are ([`Activity::Set`]), not another place.
    pub set: bool,
}

impl<const N: usize> Targets<N> {
    /// Those of a setpoint.
    pub fn new<S: Scalar>(setpoint: &Setpoint<S, N>) -> Self {
        Self {
            place: core::array::from_fn(|axis| setpoint.position(axis)),
            set: setpoint.activity == Activity::Set,
        }
    }
}

/// What a tick of the step timer was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Beat {
    /// Number of the tick in its servo cycle. 0: a servo cycle has begun, and its targets have been taken: the next are to be
    /// worked out.
    pub tick: u32,
    /// An axis has not made all steps of the cycle before.
    pub lagged: bool,
}

/// The axes of a machine, each with step and direction; all begin their servo cycles at the same tick.
#[derive(Debug)]
pub struct Drives<STEP, DIR, const N: usize> {
    axes: [StepDir<STEP, DIR>; N],
    ticks: u32,
    tick: u32,
}

impl<STEP, DIR, E, const N: usize> Drives<STEP, DIR, N>
where
    STEP: embedded_hal::digital::OutputPin<Error = E>,
    DIR: embedded_hal::digital::OutputPin<Error = E>,
{
    /// Axes at rest; `ticks` is what their timing has: ticks of the step timer in a servo cycle.
    pub const fn new(axes: [StepDir<STEP, DIR>; N], ticks: u32) -> Self {
        Self { axes, ticks, tick: 0 }
    }

    /// One tick of every axis. At the beginning of a servo cycle it asks for the targets.
    ///
    /// Cost: that of [`StepDir::tick`] for every axis, and once per servo cycle that of [`StepDir::begin`].
    ///
    /// # Errors
    /// A pin's, after all axes have had their tick; the edge is tried again at the next.
    #[inline]
    pub fn tick(&mut self, targets: impl FnOnce() -> Targets<N>) -> Result<Beat, E> {
        let mut beat = Beat { tick: self.tick, lagged: false };
        if self.tick == 0 {
            let Targets { place, set } = targets();
            for (axis, place) in self.axes.iter_mut().zip(place) {
                if set {
                    axis.rebase(place);
                }
                beat.lagged |= axis.begin(place) > 0;
            }
        }
        self.tick = if self.tick + 1 < self.ticks { self.tick + 1 } else { 0 };
        let mut done = Ok(beat);
        for axis in &mut self.axes {
            if let Err(error) = axis.tick() {
                done = Err(error);
            }
        }
        done
    }

    /// Steps that an axis has made, counted from the machine's zero; 0 of one that is not there.
    pub fn steps(&self, axis: usize) -> i64 {
        self.axes.get(axis).map_or(0, StepDir::steps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::convert::Infallible;
    use embedded_hal::digital::{ErrorType, OutputPin};
    use splineway::output::{Scale, StepTiming};

    struct Pin;

    impl ErrorType for Pin {
        type Error = Infallible;
    }

    impl OutputPin for Pin {
        fn set_low(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
    }

    const TIMING: StepTiming = StepTiming { ticks: 50, pulse: 1, pause: 1, setup: 1, hold: 1 };

    fn drives() -> Drives<Pin, Pin, 2> {
        let scale = Scale::new(1, 1000).unwrap();
        let axis = || StepDir::new(Pin, Pin, scale, TIMING, Coord::ZERO, 20).unwrap();
        Drives::new([axis(), axis()], TIMING.ticks)
    }

    fn at(steps: [i64; 2]) -> Targets<2> {
        Targets { place: steps.map(|steps| Coord::from_nm(1000 * steps).unwrap()), set: false }
    }

    /// A servo cycle; how often the targets were asked for, and whether an axis lagged behind.
    fn cycle(drives: &mut Drives<Pin, Pin, 2>, targets: Targets<2>) -> (u32, bool) {
        let (mut asked, mut lagged) = (0, false);
        for tick in 0..TIMING.ticks {
            let beat = drives.tick(|| {
                asked += 1;
                targets
            });
            let beat = beat.unwrap();
            assert_eq!(beat.tick, tick);
            lagged |= beat.lagged;
        }
        (asked, lagged)
    }

    #[test]
    fn a_servo_cycle_is_the_same_for_all_axes() {
        let mut drives = drives();
        for place in [[5, -3], [0, 7], [0, 7]] {
            assert_eq!(cycle(&mut drives, at(place)), (1, false));
            assert_eq!([0, 1].map(|axis| drives.steps(axis)), place);
        }
    }

    #[test]
    fn an_axis_that_lags_behind_is_told() {
        let mut drives = drives();
        assert_eq!(cycle(&mut drives, at([30, 0])), (1, false));
        assert_eq!(cycle(&mut drives, at([30, 0])), (1, true));
        assert_eq!(drives.steps(0), 30);
    }

    #[test]
    fn other_coordinates_move_nothing() {
        let mut drives = drives();
        cycle(&mut drives, at([5, 5]));
        assert_eq!(cycle(&mut drives, Targets { set: true, ..at([1000, -7]) }), (1, false));
        assert_eq!([0, 1].map(|axis| drives.steps(axis)), [1000, -7]);
        assert_eq!(cycle(&mut drives, at([1001, -7])), (1, false));
        assert_eq!(drives.steps(0), 1001);
    }
}
