//! Weights by which an axis is shaped: impulses and where they lie, over whole servo cycles.

use crate::number::{Range, RangeError, Scalar};
use core::f64::consts::PI;
use core::fmt;
use heapless::Vec;

/// How an axis is shaped. All weights are positive and their sum is one: no axis becomes faster, or accelerates or jerks more,
/// than its setpoints.
///
/// Singer, Seering 1990 (ZV), Singhose, Seering, Singer 1994 (EI); MZV as in the firmware Klipper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ShaperKind {
    /// Two impulses, half a period apart: no vibration at exactly the frequency given. The shortest.
    Zv,
    /// Three impulses over three quarters of a period: as exact, and wider.
    Mzv,
    /// Three impulses over a period: at the frequency 5 % of the vibration is left, and no more than that from 0.82 to 1.18 of it.
    Ei,
    /// A half wave over one and a half periods, without leaps in acceleration: what lies above the frequency is damped too.
    Smooth,
}

/// An axis that vibrates, and what is to be done about it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Shape {
    /// How it is shaped.
    pub kind: ShaperKind,
    /// Frequency of the vibration, Hz, as it is seen (with its damping).
    pub frequency: f64,
    /// Damping ratio of the vibration, 0 to 0.5; 0.05 to 0.1 as a rule.
    pub damping: f64,
}

/// A shaper that cannot be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ShaperError {
    /// The machine moves, or has not settled: other weights would be a step. At rest they are none.
    Moving,
    /// The servo cycle is not one that the core accepts.
    Cycle(RangeError),
    /// The damping of an axis.
    Damping {
        /// Index of the axis.
        axis: usize,
        /// The value given, and the range.
        error: RangeError,
    },
    /// The frequency of an axis: so low that its past is longer than `HISTORY`, or beyond a quarter of that of servo cycles.
    Frequency {
        /// Index of the axis.
        axis: usize,
        /// The value given, and the range, Hz.
        error: RangeError,
    },
    /// The axes together: each waits for the slowest, and the past of this one becomes longer than `HISTORY`.
    TooLong {
        /// Index of the axis.
        axis: usize,
        /// Servo cycles that it would take.
        cycles: usize,
        /// Servo cycles that there are.
        greatest: usize,
    },
}

impl fmt::Display for ShaperError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Moving => f.write_str("the machine moves; its shapers can be changed at rest"),
            Self::Cycle(RangeError { value, least, greatest }) => {
                write!(f, "servo cycle is {value} s; it must be {least} to {greatest}")
            }
            Self::Damping { axis, error: RangeError { value, least, greatest } } => {
                write!(f, "damping of axis {axis} is {value}; it must be {least} to {greatest}")
            }
            Self::Frequency { axis, error: RangeError { value, least, greatest } } => {
                write!(
                    f,
                    "frequency of axis {axis} is {value} Hz; it must be {least} to {greatest}"
                )
            }
            Self::TooLong { axis, cycles, greatest } => {
                write!(
                    f,
                    "shaping of axis {axis} takes {cycles} servo cycles; there is room for {greatest}"
                )
            }
        }
    }
}

impl core::error::Error for ShaperError {}

/// Damping ratios that are accepted.
const DAMPING: Range = Range::new(0.0, 0.5);
/// Periods of a smooth shaper.
const SMOOTH: f64 = 1.5;
/// Vibration that EI leaves at its frequency.
const LEFT: f64 = 0.05;

impl Shape {
    /// How long its weights reach back, s.
    pub fn length(&self) -> f64 {
        self.periods() / self.frequency
    }

    /// The same in periods of the vibration.
    const fn periods(&self) -> f64 {
        match self.kind {
            ShaperKind::Zv => 0.5,
            ShaperKind::Mzv => 0.75,
            ShaperKind::Ei => 1.0,
            ShaperKind::Smooth => SMOOTH,
        }
    }

    pub(super) fn check(&self, axis: usize, cycle: f64, history: usize) -> Result<(), ShaperError> {
        DAMPING.check(self.damping).map_err(|error| ShaperError::Damping { axis, error })?;
        let room = (history.saturating_sub(2)) as f64 * cycle;
        let least = self.periods() / room;
        Range::new(least, 0.25 / cycle)
            .check(self.frequency)
            .map_err(|error| ShaperError::Frequency { axis, error })
    }

    /// Tells how much weight lies how many cycles back, the newest first; more than asked for by a common factor.
    pub(super) fn weigh(&self, cycle: f64, mut tell: impl FnMut(f64, f64)) {
        let period = 1.0 / (self.frequency * cycle);
        let root = libm::sqrt(1.0 - self.damping * self.damping);
        // What is left of a vibration after so many periods.
        let decay = |periods: f64| libm::exp(-2.0 * PI * self.damping / root * periods);
        let mut impulse = |periods: f64, weight: f64| {
            tell(periods * period, weight * decay(periods));
        };
        match self.kind {
            ShaperKind::Zv => {
                impulse(0.0, 0.5);
                impulse(0.5, 0.5);
            }
            ShaperKind::Mzv => {
                let side = 1.0 - core::f64::consts::FRAC_1_SQRT_2;
                impulse(0.0, side);
                impulse(0.375, 1.0 - 2.0 * side);
                impulse(0.75, side);
            }
            ShaperKind::Ei => {
                impulse(0.0, (1.0 + LEFT) / 4.0);
                impulse(0.5, (1.0 - LEFT) / 2.0);
                impulse(1.0, (1.0 + LEFT) / 4.0);
            }
            ShaperKind::Smooth => {
                // At least seven of them; no more than the past has cycles, which was checked.
                let count = libm::ceil(SMOOTH * period) as u32;
                for n in 1..count {
                    let part = f64::from(n) / f64::from(count);
                    impulse(SMOOTH * part, libm::sin(PI * part));
                }
            }
        }
    }
}

/// What lies so many cycles back counts so much.
#[derive(Clone, Copy, Debug)]
pub struct Tap<S> {
    pub back: usize,
    pub weight: S,
}

/// The weights of one axis.
#[derive(Debug)]
pub struct Kernel<S, const HISTORY: usize> {
    pub taps: Vec<Tap<S>, HISTORY>,
    /// Half the variance of the time that it looks back, s2: an axis is off where it was a mean time before by no more than
    /// this times its acceleration.
    pub spread: f64,
}

impl<S: Scalar, const HISTORY: usize> Kernel<S, HISTORY> {
    /// Everything counts now.
    pub const NONE: Self = Self { taps: Vec::new(), spread: 0.0 };

    /// Mean time that a shape looks back, cycles.
    pub fn mean(shape: &Shape, cycle: f64) -> f64 {
        let (mut sum, mut moment) = (0.0, 0.0);
        shape.weigh(cycle, |back, weight| {
            sum += weight;
            moment += weight * back;
        });
        moment / sum
    }

    /// Servo cycles that a shape (or none) takes that looks back `wait` cycles further.
    pub fn cycles(shape: Option<&Shape>, wait: f64, cycle: f64) -> usize {
        let mut most = 0.0_f64;
        each(shape, wait, cycle, |back, _| most = most.max(back));
        libm::ceil(most) as usize + 1
    }

    /// Becomes a shape (or none) that looks back `wait` cycles further, and takes no more cycles than there is room for
    /// ([`Kernel::cycles`]). What lies between two cycles counts in both, by how near it is.
    pub fn set(&mut self, shape: Option<&Shape>, wait: f64, cycle: f64) {
        let mut sum = 0.0;
        each(shape, wait, cycle, |_, weight| sum += weight);
        self.taps.clear();
        let (mut mean, mut square) = (0.0, 0.0);
        each(shape, wait, cycle, |back, weight| {
            let whole = libm::floor(back);
            let part = back - whole;
            for (at, share) in [(whole, 1.0 - part), (whole + 1.0, part)] {
                let share = share * weight / sum;
                if share > 0.0 {
                    mean += share * at;
                    square += share * at * at;
                    self.add(at as usize, S::of(share));
                }
            }
        });
        self.spread = 0.5 * (square - mean * mean).max(0.0) * cycle * cycle;
    }

    /// More weight at a place: the last two, or behind them.
    fn add(&mut self, back: usize, weight: S) {
        match self.taps.iter_mut().rev().take(2).find(|tap| tap.back == back) {
            Some(tap) => tap.weight += weight,
            // As many as there are cycles.
            None => drop(self.taps.push(Tap { back, weight })),
        }
    }
}

/// Tells what counts how much, by how far it lies back.
fn each(shape: Option<&Shape>, wait: f64, cycle: f64, mut tell: impl FnMut(f64, f64)) {
    match shape {
        Some(shape) => shape.weigh(cycle, |back, weight| tell(back + wait, weight)),
        None => tell(wait, 1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec as List;

    const KINDS: [ShaperKind; 4] =
        [ShaperKind::Zv, ShaperKind::Mzv, ShaperKind::Ei, ShaperKind::Smooth];

    fn shape(kind: ShaperKind, frequency: f64, damping: f64) -> Shape {
        Shape { kind, frequency, damping }
    }

    fn kernel(shape: &Shape, wait: f64, cycle: f64) -> Kernel<f64, 256> {
        let mut kernel = Kernel::NONE;
        kernel.set(Some(shape), wait, cycle);
        assert!(
            kernel.taps.last().unwrap().back < Kernel::<f64, 256>::cycles(Some(shape), wait, cycle)
        );
        assert!(kernel.taps.windows(2).all(|two| two[0].back < two[1].back));
        kernel
    }

    /// Share of the vibration of a step that is left, at a frequency, by the vector sum of impulses.
    fn left(kernel: &Kernel<f64, 256>, frequency: f64, damping: f64, cycle: f64) -> f64 {
        let seen = 2.0 * PI * frequency;
        let decay = seen * damping / libm::sqrt(1.0 - damping * damping);
        let last = kernel.taps.last().unwrap().back as f64 * cycle;
        let (mut x, mut y) = (0.0, 0.0);
        for tap in &kernel.taps {
            let t = tap.back as f64 * cycle;
            let size = tap.weight * libm::exp(decay * (t - last));
            x += size * libm::cos(seen * t);
            y += size * libm::sin(seen * t);
        }
        libm::hypot(x, y)
    }

    #[test]
    fn the_vibration_is_gone_at_its_frequency() {
        for kind in KINDS {
            for damping in [0.0, 0.1, 0.3] {
                for (frequency, cycle) in [(25.0, 1.0e-3), (41.7, 1.0e-3), (60.0, 2.5e-4)] {
                    let shape = shape(kind, frequency, damping);
                    let kernel = kernel(&shape, 0.3, cycle);
                    let sum: f64 = kernel.taps.iter().map(|tap| tap.weight).sum();
                    assert!((sum - 1.0).abs() < 1.0e-12);
                    let most = if kind == ShaperKind::Ei { 0.06 } else { 0.015 };
                    let left = left(&kernel, frequency, damping, cycle);
                    assert!(left < most, "{kind:?} {frequency} {damping}: {left}");
                }
            }
        }
    }

    #[test]
    fn robust_shapers_are_wider() {
        let width = |kind: ShaperKind| {
            let kernel = kernel(&shape(kind, 40.0, 0.0), 0.0, 1.0e-3);
            let seen: List<f64> = (0..200)
                .map(|n| 20.0 + 0.2 * f64::from(n))
                .filter(|&f| left(&kernel, f, 0.0, 1.0e-3) < 0.05)
                .collect();
            (seen.last().unwrap() - seen.first().unwrap()) / 40.0
        };
        let [zv, mzv, ei, _] = KINDS.map(width);
        assert!(zv < mzv && mzv < ei, "{zv} {mzv} {ei}");
        assert!(ei > 0.3, "{ei}");
    }

    #[test]
    fn what_cannot_be_is_named() {
        let check = |shape: Shape| shape.check(1, 1.0e-3, 64);
        assert_eq!(check(shape(ShaperKind::Ei, 40.0, 0.1)), Ok(()));
        for bad in [10.0, 0.0, -1.0, f64::NAN, f64::INFINITY, 300.0] {
            let error = check(shape(ShaperKind::Ei, bad, 0.1)).unwrap_err();
            assert!(matches!(error, ShaperError::Frequency { axis: 1, .. }), "{error}");
        }
        for bad in [-0.1, 0.6, f64::NAN] {
            let error = check(shape(ShaperKind::Zv, 40.0, bad)).unwrap_err();
            assert!(matches!(error, ShaperError::Damping { axis: 1, .. }), "{error}");
        }
        assert_eq!(Kernel::<f32, 16>::cycles(None, 20.5, 1.0e-3), 22);
        assert_eq!(Kernel::<f32, 16>::cycles(None, 20.0, 1.0e-3), 21);
    }
}
