//! What has a range: settings of the machine and numbers of a block. The one table of what is accepted.

use crate::number::{Range, RangeError, Scalar};

/// Greatest tolerance, mm.
const GREATEST_TOLERANCE: f64 = 1.0e3;

/// A quantity of a machine description or of a block; [`Quantity::range`] is what is accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Quantity {
    /// Axis velocity, mm/s or degrees/s.
    Velocity,
    /// Axis acceleration, mm/s2 or degrees/s2.
    Acceleration,
    /// Axis jerk, mm/s3 or degrees/s3.
    Jerk,
    /// Servo cycle, s.
    Cycle,
    /// Default tolerance, mm.
    Tolerance,
    /// Lead of the plan over the execution, s.
    Lead,
    /// Wait for more blocks before a start from rest, s.
    StartDelay,
    /// Overlap factor lambda of the paper.
    Lambda,
    /// Improvement steps of one planning step.
    Iterations,
    /// Smoothing sweeps over a run.
    Sweeps,
    /// Tolerance of a curve, mm.
    CurveTolerance,
    /// Feed of a block, mm/s.
    Feed,
    /// Duration of an inverse-time block, s.
    Duration,
    /// Time of a dwell, s.
    Dwell,
    /// Time after which a jog at a velocity ends, s.
    JogTime,
    /// Tolerance that is kept free for what follows the setpoints, mm.
    Reserve,
    /// Time in which what follows the setpoints comes to rest, s.
    Settle,
}

impl Quantity {
    /// The settings of a [`Config`](super::Config), beside the limits of the axes.
    pub const SETTINGS: [Self; 7] = [
        Self::Cycle,
        Self::Tolerance,
        Self::Lead,
        Self::StartDelay,
        Self::Lambda,
        Self::Iterations,
        Self::Sweeps,
    ];

    /// Least and greatest value accepted. Within these the core's arithmetic is sound, and a setting at
    /// either end costs little time: fewer iterations than the least make motions that are slower than a stop
    /// at every corner, and beyond the greatest numbers of iterations and sweeps nothing is gained.
    // A table: one line for one quantity, also where two are equal.
    #[allow(clippy::match_same_arms)]
    pub const fn range(self) -> Range {
        match self {
            Self::Velocity => Range::new(1.0e-6, 1.0e6),
            Self::Acceleration => Range::new(1.0e-4, 1.0e8),
            Self::Jerk => Range::new(1.0e-3, 1.0e11),
            Self::Cycle => Range::new(1.0e-6, 0.01),
            Self::Tolerance => Range::new(0.0, GREATEST_TOLERANCE),
            Self::CurveTolerance => Range::new(1.0e-4, GREATEST_TOLERANCE),
            Self::StartDelay => Range::new(0.0, 1.0e3),
            Self::Lead => Range::new(0.0, 10.0),
            Self::Lambda => Range::new(0.0, 0.99),
            Self::Iterations => Range::new(15.0, 1000.0),
            Self::Sweeps => Range::new(0.0, 100.0),
            Self::Feed => Range::new(1.0e-9, 1.0e6),
            Self::Duration => Range::new(1.0e-6, 1.0e6),
            Self::Dwell => Range::new(0.0, 1.0e6),
            Self::JogTime => Range::new(1.0e-3, 60.0),
            Self::Reserve => Range::new(0.0, GREATEST_TOLERANCE),
            Self::Settle => Range::new(0.0, 10.0),
        }
    }

    /// Whether a value lies in the range, or what is wrong with it.
    pub(crate) fn check<S: Scalar>(self, value: S) -> Result<(), RangeError> {
        self.range().check(value)
    }

    /// Name and unit.
    pub(crate) const fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Velocity => ("velocity", "mm/s"),
            Self::Acceleration => ("acceleration", "mm/s2"),
            Self::Jerk => ("jerk", "mm/s3"),
            Self::Cycle => ("servo cycle", "s"),
            Self::Tolerance | Self::CurveTolerance => ("tolerance", "mm"),
            Self::Lead => ("lead", "s"),
            Self::StartDelay => ("start delay", "s"),
            Self::Lambda => ("lambda", ""),
            Self::Iterations => ("number of iterations", ""),
            Self::Sweeps => ("number of sweeps", ""),
            Self::Feed => ("feed", "mm/s"),
            Self::Duration => ("duration", "s"),
            Self::Dwell => ("dwell", "s"),
            Self::JogTime => ("time of a jog", "s"),
            Self::Reserve => ("reserve of the tolerance", "mm"),
            Self::Settle => ("time to settle", "s"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_range_holds_something_in_either_scalar() {
        let others = [
            Quantity::Velocity,
            Quantity::Acceleration,
            Quantity::Jerk,
            Quantity::CurveTolerance,
            Quantity::Feed,
            Quantity::Duration,
            Quantity::Dwell,
            Quantity::JogTime,
        ];
        for quantity in Quantity::SETTINGS.into_iter().chain(others) {
            let Range { least, greatest } = quantity.range();
            assert!(least < greatest, "{quantity:?}");
            // The ends are accepted as the type rounds them.
            for end in [least, greatest] {
                assert!(quantity.check(end).is_ok() && quantity.check(end as f32).is_ok());
            }
            for beyond in [least - 1.0e-6, greatest * 1.001, f64::NAN, f64::INFINITY] {
                let error = quantity.check(beyond).unwrap_err();
                assert_eq!((error.least, error.greatest), (least, greatest), "{quantity:?}");
            }
        }
    }
}
