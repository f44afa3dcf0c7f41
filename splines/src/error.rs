//! What may be wrong with a spline.

use core::fmt;

/// Why a spline was not taken.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SplineError {
    /// Fewer control points than a cubic spline needs (closed: more than its degree).
    TooFew {
        /// Control points given.
        controls: usize,
    },
    /// More control points or knots than there is room for.
    TooMany {
        /// Control points given.
        controls: usize,
        /// Control points there is room for.
        room: usize,
    },
    /// The number of knots fits none of the conventions.
    KnotCount {
        /// Knots given.
        knots: usize,
        /// Control points given.
        controls: usize,
    },
    /// An end knot is not repeated as the convention asks for.
    EndKnot {
        /// Index of the knot.
        index: usize,
        /// The value given.
        value: f64,
    },
    /// A knot is not greater than the one before; repeated inner knots would break the continuity of
    /// curvature (split the spline there), or a knot interval is not positive.
    KnotOrder {
        /// Index of the knot.
        index: usize,
        /// The value given.
        value: f64,
    },
    /// A number is not finite.
    NotFinite {
        /// Index of the control point, or of the knot.
        index: usize,
    },
    /// A parameter outside its range.
    OutOfRange {
        /// What it is.
        what: &'static str,
        /// The value given.
        value: f64,
        /// Least value accepted.
        least: f64,
        /// Greatest value accepted.
        greatest: f64,
    },
}

impl fmt::Display for SplineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew { controls } => {
                write!(f, "{controls} control points are too few for a cubic spline (4, closed: 5)")
            }
            Self::TooMany { controls, room } => {
                write!(f, "{controls} control points where there is room for {room}")
            }
            Self::KnotCount { knots, controls } => write!(
                f,
                "{knots} knots for {controls} control points: an open spline has {} (each value \
                 once), {} (threefold at the ends) or {} (fourfold), a closed one {controls} \
                 intervals",
                controls.saturating_sub(2),
                controls + 2,
                controls + 4
            ),
            Self::EndKnot { index, value } => {
                write!(f, "knot {index} is {value}; it must equal its neighbour at the end")
            }
            Self::KnotOrder { index, value } => {
                write!(f, "knot {index} is {value}; every inner knot must be greater than the last")
            }
            Self::NotFinite { index } => write!(f, "number {index} is not finite"),
            Self::OutOfRange { what, value, least, greatest } => {
                write!(f, "{what} is {value}; it must be from {least} to {greatest}")
            }
        }
    }
}

impl core::error::Error for SplineError {}
