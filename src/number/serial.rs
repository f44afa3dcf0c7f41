//! Running numbers that wrap around.
//!
//! A machine that never stops passes `u32::MAX` one day: the nodes of a path after a year or so, the servo cycles
//! at 1 kHz after seven weeks. Two numbers in use at a time are never far apart, so their order is that of
//! their wrapping difference, as with the sequence numbers of TCP (RFC 9293, section 3.4): below half the
//! range it counts forwards, else backwards. There is no `<`, which would be wrong at the wrap.

use core::marker::PhantomData;

/// What is numbered: nodes of the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nodes {}

/// What is numbered: servo cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cycles {}

/// The running number of one of the things numbered by `Kind`; numbers of different kinds cannot be
/// compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Serial<Kind> {
    raw: u32,
    kind: PhantomData<Kind>,
}

/// Running number of a node of the path.
pub type NodeSerial = Serial<Nodes>;

/// Running number of a servo cycle.
pub type CycleSerial = Serial<Cycles>;

/// Differences from here on count backwards.
const HALF: u32 = 1 << 31;

impl<Kind: Copy> Serial<Kind> {
    /// The first number of all.
    pub const ZERO: Self = Self::from_raw(0);

    /// A number from how it is stored.
    #[inline]
    pub const fn from_raw(raw: u32) -> Self {
        Self { raw, kind: PhantomData }
    }

    /// How it is stored, in an atomic or on a wire.
    #[inline]
    pub const fn raw(self) -> u32 {
        self.raw
    }

    /// The next number.
    #[inline]
    #[must_use]
    pub const fn next(self) -> Self {
        self.plus(1)
    }

    /// The number `count` further on.
    #[inline]
    #[must_use]
    pub const fn plus(self, count: u32) -> Self {
        Self::from_raw(self.raw.wrapping_add(count))
    }

    /// The number before this one.
    #[inline]
    #[must_use]
    pub const fn previous(self) -> Self {
        self.minus(1)
    }

    /// The number `count` before it.
    #[inline]
    #[must_use]
    pub const fn minus(self, count: u32) -> Self {
        Self::from_raw(self.raw.wrapping_sub(count))
    }

    /// How far this number is behind `earlier`; `None` if it comes before it.
    #[inline]
    pub const fn since(self, earlier: Self) -> Option<u32> {
        let ahead = self.raw.wrapping_sub(earlier.raw);
        if ahead < HALF { Some(ahead) } else { None }
    }

    /// Whether this number comes before another.
    #[inline]
    pub const fn is_before(self, other: Self) -> bool {
        self.since(other).is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_holds_across_the_wrap() {
        let last = NodeSerial::from_raw(u32::MAX);
        assert_eq!(last.next(), NodeSerial::ZERO);
        assert_eq!(NodeSerial::ZERO.previous(), last);
        assert!(last.is_before(last.next()));
        assert!(!last.next().is_before(last));
        assert!(!last.is_before(last));
        assert_eq!(last.plus(5).since(last), Some(5));
        assert_eq!(last.since(last.plus(5)), None);
        assert_eq!(last.since(last), Some(0));
    }

    /// The furthest that two numbers may lie apart.
    #[test]
    fn half_the_range_counts_forwards() {
        for raw in [0, 7, u32::MAX - 3, HALF] {
            let here = CycleSerial::from_raw(raw);
            assert_eq!(here.plus(HALF - 1).since(here), Some(HALF - 1));
            assert_eq!(here.plus(HALF).since(here), None);
            assert!(here.is_before(here.plus(HALF - 1)));
        }
    }
}
