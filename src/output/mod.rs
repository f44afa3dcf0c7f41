//! From setpoints to drives.
//!
//! Three ways out of the servo interrupt, over [embedded-hal](https://docs.rs/embedded-hal) 1.0 traits:
//!
//! - [`StepDir`]: step and direction. A step timer, several ten thousand times a second, spreads the steps
//!   of every servo cycle evenly over the next one; at its end as many steps are out as the rounded
//!   setpoint asks for, never one more or less.
//! - [`Analogue`]: a velocity or a power as a duty cycle; [`PositionLoop`] closes the loop around a
//!   drive that takes velocities.
//! - [`Drive`]: whatever else there is - a DAC, CAN, EtherCAT - as one function of the setpoint.

mod analogue;
#[cfg(feature = "kinematics")]
mod motors;
mod scale;
#[cfg(feature = "shaping")]
mod shaper;
mod step_dir;

pub use analogue::{Analogue, FollowingError, PositionLoop};
pub use scale::{Scale, ScaleError};
#[cfg(feature = "shaping")]
pub use shaper::{Shape, Shaper, ShaperError, ShaperKind};
pub use step_dir::{EdgeTimes, StepDir, StepError, StepTiming};

use crate::servo::Setpoint;

/// Something that follows setpoints: called once per servo cycle, in the interrupt.
pub trait Drive<S, const N: usize> {
    /// Why it does not.
    type Error;

    /// Goes where the setpoint says by the end of this servo cycle.
    ///
    /// # Errors
    /// The drive's own; the caller should stop the machine.
    fn drive(&mut self, setpoint: &Setpoint<S, N>) -> Result<(), Self::Error>;
}
