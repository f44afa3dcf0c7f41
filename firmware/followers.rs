//! What follows the interpolator in the servo cycle: input shaping (feature `shaping`), and outputs in time with the path (feature
//! `outputs`). The same for every board of this folder; without the features it is nothing.

use crate::machine::AXES;
#[cfg(feature = "shaping")]
use splineway::output::{Shape, Shaper};
use splineway::{Config, Interpolator, Scalar, Setpoint};

/// Axes that vibrate (feature `shaping`), and the servo cycles that are remembered of them: one and a half periods of the lowest
/// frequency, and two more.
#[cfg(feature = "shaping")]
pub const SHAPES: [Option<Shape>; AXES] = [None; AXES];
#[cfg(feature = "shaping")]
const HISTORY: usize = 64;

/// An output that has switched in time with the path (feature `outputs`); without it there is none.
#[cfg(feature = "outputs")]
pub type Switched<S> = splineway::Switched<S>;
#[cfg(not(feature = "outputs"))]
pub type Switched<S> = core::marker::PhantomData<S>;

/// What follows the interpolator in the servo cycle: shapers, and outputs, which switch where the machine is.
pub struct Followers<S: Scalar> {
    #[cfg(feature = "shaping")]
    shaper: Shaper<S, AXES, HISTORY>,
    scalar: core::marker::PhantomData<S>,
}

impl<S: Scalar> Followers<S> {
    /// Before the core is set up.
    pub const fn new() -> Self {
        Self {
            #[cfg(feature = "shaping")]
            shaper: Shaper::new(),
            scalar: core::marker::PhantomData,
        }
    }

    /// For a machine, which is told what the shapers ask of the motion. `None`: they cannot be.
    #[cfg_attr(
        not(feature = "shaping"),
        allow(unused_mut, clippy::unused_self, clippy::unnecessary_wraps)
    )]
    pub fn set(&mut self, mut config: Config<S, AXES>) -> Option<Config<S, AXES>> {
        #[cfg(feature = "shaping")]
        {
            self.shaper.set(SHAPES, &config).ok()?;
            config.follower = self.shaper.follower(&config);
        }
        Some(config)
    }

    /// A servo cycle: where the axes are to be at its end, and the power of a tool then. `switch` is told what switches in it. Without
    /// `outputs` the power is the speed along the path.
    #[cfg_attr(not(feature = "shaping"), allow(clippy::unused_self))]
    #[cfg_attr(not(feature = "outputs"), allow(clippy::needless_pass_by_value, unused_variables))]
    pub fn tick(
        &mut self,
        interpolator: &mut Interpolator<'_, S, AXES>,
        switch: impl FnMut(Switched<S>),
    ) -> (Setpoint<S, AXES>, S) {
        let setpoint = interpolator.tick();
        #[cfg(feature = "shaping")]
        let setpoint = self.shaper.shape(&setpoint);
        #[cfg(feature = "outputs")]
        let power = interpolator.switch(&setpoint, switch);
        #[cfg(not(feature = "outputs"))]
        let power = setpoint.path_speed;
        (setpoint, power)
    }
}
