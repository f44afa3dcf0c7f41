//! How the core is set up for a machine.

#[cfg(feature = "shaping")]
use super::Follower;
#[cfg(feature = "travel")]
use super::Travel;
use super::{ConfigError, Limits, Quantity, defaults};
use crate::number::Scalar;

/// What positions are told to, mm.
#[cfg(feature = "shaping")]
const NANOMETRE: f64 = 1.0e-6;

/// A cell takes at least this share of a servo cycle, a standstill too: a tick passes few of them.
pub(crate) const LEAST_CYCLE_SHARE: f64 = 0.25;

/// How the corners between straight lines are rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CornerMode<S> {
    /// The whole tolerance band is used, the edge length comes in closed form
    /// `L = 4 delta / sin(turn)`, and neighbouring corners share a leg by need. The default.
    Band,
    /// As printed in Guo, Yan, Wang 2023, sections 3.2 to 3.5: `e* = delta / 2`, the next corner
    /// starts a fraction `lambda` of the remaining leg away, and the halving rule. Control points are the printed ones to
    /// the rounding of coordinates, and a motion that does not rest within a transition keeps to its printed curve to 0.5 %
    /// of `delta`.
    ///
    /// The routines begin anew, without `lambda`, where the motion rests: so it does where a turn is beyond
    /// [`CornerMode::STOP_COSINE`] (160 degrees), where less than half a micrometre is left for a transition, and at an
    /// exact stop. For corners between programmed lines; arcs and curves are joined and followed as in the other mode.
    Paper {
        /// Share of the remaining leg kept straight between two transitions (eq. 8), 0 to 0.99.
        lambda: S,
    },
}

impl<S> CornerMode<S> {
    /// Cosine of the turn (160 degrees) beyond which a corner is an exact stop, in either mode: there a stop is faster
    /// than the rounding. (At 166 degrees no path by more than 1.2 %, at 152 a star by 8.5 %.)
    pub const STOP_COSINE: f64 = -0.94;
}

/// Everything the core needs to know of a machine. Make it with [`Config::new`] and change the
/// fields that differ; it is checked when the core is built from it, against the ranges of
/// [`Quantity::range`](super::Quantity::range).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Config<S, const N: usize> {
    /// Limits of the axes. [`Planner::set_limits`](crate::Planner::set_limits) changes them between blocks (feature `limits`).
    pub limits: Limits<S, N>,
    /// Limits of acceleration and jerk for stops that must be short ([`Controls::quick_hold`](crate::Controls::quick_hold)):
    /// of each, the greater of this and of what the block under way is run with. `None`: no more than that.
    pub stop_limits: Option<Limits<S, N>>,
    /// How far the axes may go (feature `travel`). [`Planner::set_travel`](crate::Planner::set_travel) changes it.
    #[cfg(feature = "travel")]
    pub travel: Travel<N>,
    /// What follows the setpoints late or not exactly (feature `shaping`).
    #[cfg(feature = "shaping")]
    pub follower: Follower<S, N>,
    /// The limits before what follows bounds them: set by the core.
    #[cfg(feature = "shaping")]
    pub(crate) free: Limits<S, N>,
    /// Servo cycle, s: the time between two calls of `tick`.
    pub cycle: S,
    /// Tolerance of blocks that name none, mm: greatest distance from the programmed path.
    pub tolerance: S,
    /// How corners are rounded.
    pub corner: CornerMode<S>,
    /// Least time by which a new plan is handed over before it takes effect, s. The planner measures, in servo
    /// cycles, what its plans take, and begins them earlier where that is more. Where less than twice as much is left
    /// of the plan under way, half of what is left.
    pub lead: S,
    /// How long a start from rest waits for the look-ahead to fill, s.
    pub start_delay: S,
    /// Most improvement steps (Newton iterations) of one planning step: the bound on its work, 15 to 1000.
    /// 10 to 20 are needed as a rule; as many again are allowed if the first do not lead to a motion, and half
    /// as many for the answer to an operator's command.
    pub iterations: u16,
    /// Sweeps in which a new stretch of a run of short lines is smoothed before four of its spans are handed
    /// on, 0 to 100; one of which most has been smoothed before takes a quarter as many. 0 leaves the spline as it is laid. Every
    /// number gives a path inside the tolerance: up to eight more are made where the sweeps have led far out of it, and what
    /// is still outside is moved by less. A sweep costs a banded factorisation over at most 48 control points.
    pub sweeps: u16,
}

impl<S: Scalar, const N: usize> Config<S, N> {
    /// The memory of one: all zeros, which [`Config::check`] refuses.
    pub(crate) const UNSET: Self = Self {
        limits: Limits::UNSET,
        // `None` is not zero, as the flag of an axis leaves room for it.
        stop_limits: Some(Limits::UNSET),
        #[cfg(feature = "travel")]
        travel: Travel::UNSET,
        #[cfg(feature = "shaping")]
        follower: Follower::NONE,
        #[cfg(feature = "shaping")]
        free: Limits::UNSET,
        cycle: S::ZERO,
        tolerance: S::ZERO,
        corner: CornerMode::Band,
        lead: S::ZERO,
        start_delay: S::ZERO,
        iterations: 0,
        sweeps: 0,
    };

    /// The settings of [`defaults`]: 1 ms servo cycle, 0.01 mm tolerance, full band corners.
    pub fn new(limits: Limits<S, N>) -> Self {
        Self {
            limits,
            stop_limits: None,
            #[cfg(feature = "travel")]
            travel: Travel::OPEN,
            #[cfg(feature = "shaping")]
            follower: Follower::NONE,
            #[cfg(feature = "shaping")]
            free: limits,
            cycle: S::of(defaults::CYCLE),
            tolerance: S::of(defaults::TOLERANCE),
            corner: CornerMode::Band,
            lead: S::of(defaults::LEAD),
            start_delay: S::of(defaults::START_DELAY),
            iterations: defaults::ITERATIONS,
            sweeps: defaults::SWEEPS,
        }
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] names the first setting out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        for quantity in Quantity::SETTINGS {
            let named = |error| ConfigError::Setting { quantity, error };
            quantity.check(self.setting(quantity)).map_err(named)?;
        }
        #[cfg(feature = "shaping")]
        self.check_follower()?;
        Ok(())
    }

    #[cfg(feature = "shaping")]
    fn check_follower(&self) -> Result<(), ConfigError> {
        let Follower { reserve, settle, acceleration, .. } = &self.follower;
        for (quantity, value) in [(Quantity::Reserve, *reserve), (Quantity::Settle, *settle)] {
            let named = |error| ConfigError::Setting { quantity, error };
            quantity.check(value).map_err(named)?;
        }
        #[cfg(feature = "kinematics")]
        if !self.follows_motors_of(&self.limits) {
            return Err(ConfigError::Unlike);
        }
        for (axis, value) in acceleration.iter().enumerate() {
            let quantity = Quantity::Acceleration;
            let named = |error| ConfigError::AxisLimit { axis, quantity, error };
            if *value != S::ZERO {
                quantity.check(*value).map_err(named)?;
            }
        }
        Ok(())
    }

    /// Whether motors, if limits name some, are followed as axes are: the mean of a sum is the sum of means only where these are
    /// the same.
    #[cfg(feature = "kinematics")]
    pub(crate) fn follows_motors_of(&self, limits: &Limits<S, N>) -> bool {
        !limits.names_motors()
            || self.settle() == S::ZERO
            || self.keeps_straight(&[S::ONE; N], S::ONE)
    }

    /// Limits from now on: those that what follows the setpoints can bear, and the limits themselves where it need not.
    pub(crate) fn limit(&mut self, limits: &Limits<S, N>) {
        self.limits = self.bearable(limits);
        #[cfg(feature = "shaping")]
        {
            self.free = *limits;
        }
    }

    /// The limits before that.
    #[cfg(feature = "shaping")]
    pub(crate) fn given(&self) -> &Limits<S, N> {
        &self.free
    }

    /// The same where everything follows.
    #[cfg(not(feature = "shaping"))]
    pub(crate) fn given(&self) -> &Limits<S, N> {
        &self.limits
    }

    /// Limits that what follows the setpoints can bear.
    #[cfg(feature = "shaping")]
    pub(crate) fn bearable(&self, limits: &Limits<S, N>) -> Limits<S, N> {
        self.follower.bound(limits, self.cycle)
    }

    /// The same where everything follows.
    #[cfg(not(feature = "shaping"))]
    #[allow(clippy::unused_self)]
    pub(crate) fn bearable(&self, limits: &Limits<S, N>) -> Limits<S, N> {
        *limits
    }

    /// Whether a line of that direction and length, mm, stays straight though it be run by more than can be borne at its ends.
    #[cfg(feature = "shaping")]
    pub(crate) fn bears_less(&self, direction: &[S; N], length: S) -> bool {
        self.free != self.limits && self.keeps_straight(direction, length)
    }

    /// What it takes of every tolerance, mm.
    #[cfg(feature = "shaping")]
    pub(crate) fn reserve(&self) -> S {
        self.follower.reserve
    }

    /// The same where everything follows.
    #[cfg(not(feature = "shaping"))]
    #[allow(clippy::unused_self)]
    pub(crate) const fn reserve(&self) -> S {
        S::ZERO
    }

    /// Whether a line of that direction and length, mm, stays straight. An axis that goes no farther than what positions are told to
    /// stands: where a jog or an abort has ended, the machine may be off the last nanometre.
    #[cfg(feature = "shaping")]
    pub(crate) fn keeps_straight(&self, direction: &[S; N], length: S) -> bool {
        let goes = |share: &&S| share.abs() * length > S::of(NANOMETRE);
        self.follower.alike || direction.iter().filter(goes).count() <= 1
    }

    /// The same where everything follows.
    #[cfg(not(feature = "shaping"))]
    #[allow(clippy::unused_self)]
    pub(crate) const fn keeps_straight(&self, _: &[S; N], _: S) -> bool {
        true
    }

    /// How long it comes to rest after the setpoints, s.
    #[cfg(feature = "shaping")]
    pub(crate) fn settle(&self) -> S {
        self.follower.settle
    }

    /// The same where everything follows.
    #[cfg(not(feature = "shaping"))]
    #[allow(clippy::unused_self)]
    pub(crate) const fn settle(&self) -> S {
        S::ZERO
    }

    /// The value of a setting; that of one which does not count is one that is accepted.
    fn setting(&self, quantity: Quantity) -> S {
        match (quantity, self.corner) {
            (Quantity::Cycle, _) => self.cycle,
            (Quantity::Tolerance, _) => self.tolerance,
            (Quantity::Lead, _) => self.lead,
            (Quantity::StartDelay, _) => self.start_delay,
            (Quantity::Lambda, CornerMode::Paper { lambda }) => lambda,
            (Quantity::Iterations, _) => S::from_u32(u32::from(self.iterations)),
            (Quantity::Sweeps, _) => S::from_u32(u32::from(self.sweeps)),
            _ => S::of(quantity.range().least),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::AxisLimits;

    fn config() -> Config<f32, 2> {
        let axis = AxisLimits { velocity: 200.0, acceleration: 2000.0, jerk: 5.0e4, rotary: false };
        Config::new(Limits::new([axis; 2]).unwrap())
    }

    #[test]
    fn defaults_are_accepted() {
        assert_eq!(config().check(), Ok(()));
    }

    #[test]
    fn a_setting_out_of_range_is_named() {
        let named = |change: fn(&mut Config<f32, 2>)| {
            let mut config = config();
            change(&mut config);
            match config.check() {
                Err(ConfigError::Setting { quantity, .. }) => Some(quantity),
                _ => None,
            }
        };
        assert_eq!(named(|c| c.cycle = 0.0), Some(Quantity::Cycle));
        assert_eq!(named(|c| c.tolerance = f32::NAN), Some(Quantity::Tolerance));
        assert_eq!(named(|c| c.lead = 11.0), Some(Quantity::Lead));
        assert_eq!(named(|c| c.start_delay = -1.0), Some(Quantity::StartDelay));
        assert_eq!(named(|c| c.iterations = 14), Some(Quantity::Iterations));
        assert_eq!(named(|c| c.sweeps = 101), Some(Quantity::Sweeps));
        let lambda = |c: &mut Config<f32, 2>| c.corner = CornerMode::Paper { lambda: 1.0 };
        assert_eq!(named(lambda), Some(Quantity::Lambda));
        // The ends of a range are accepted as the type rounds them.
        assert_eq!(named(|c| c.cycle = 0.01), None);
    }
}
