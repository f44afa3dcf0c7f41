//! Which limits bound which block: they may change between blocks.

use super::{Config, Limits};
use crate::number::Scalar;

/// Sets of limits that may be in effect along the window and the look-ahead besides the newest: what a block has been taken
/// with bounds it until it has been run. Without the feature `limits` there is but one, and nothing is kept.
const OLDER: usize = if cfg!(feature = "limits") { 4 } else { 0 };

/// Whether a set has limits for where what follows the setpoints bears more than elsewhere.
const FREE: u8 = if cfg!(feature = "shaping") { 0x80 } else { 0 };

/// Number of a set of limits: the sets follow each other along the path. With a mark where its free limits count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetNumber(u8);

impl SetNumber {
    /// That of the first.
    pub const FIRST: Self = Self(0);

    /// Whether it is another.
    #[inline]
    pub fn differs(self, other: Self) -> bool {
        (OLDER != 0 || FREE != 0) && self != other
    }

    /// The same set, where its free limits count.
    #[cfg(feature = "shaping")]
    pub fn freed(self) -> Self {
        Self(self.0 | FREE)
    }

    /// The set.
    const fn plain(self) -> Self {
        Self(self.0 & !FREE)
    }

    /// Where it is kept. Numbers go round at a multiple of the room: neighbours never share a place.
    const fn place(self) -> usize {
        match (self.plain().0 as usize).checked_rem(OLDER) {
            Some(place) => place,
            None => 0,
        }
    }
}

/// The sets before the newest.
#[derive(Clone, Debug)]
pub struct OlderLimits<S, const N: usize> {
    sets: [Limits<S, N>; OLDER],
    #[cfg(feature = "shaping")]
    free: [Limits<S, N>; OLDER],
    newest: SetNumber,
}

impl<S: Scalar, const N: usize> OlderLimits<S, N> {
    /// The memory of none: all zeros.
    pub const NONE: Self = Self {
        sets: [Limits::UNSET; OLDER],
        #[cfg(feature = "shaping")]
        free: [Limits::UNSET; OLDER],
        newest: SetNumber::FIRST,
    };

    /// Number of the newest set.
    #[cfg(feature = "limits")]
    pub fn newest(&self) -> SetNumber {
        self.newest
    }

    /// A new set comes after the newest, which is that of `config`. Returns whether there was room for it: the path from the motion on
    /// begins with the set `first`.
    #[cfg(feature = "limits")]
    pub fn keep(&mut self, config: &Config<S, N>, first: SetNumber) -> bool {
        let SetNumber(newest) = self.newest;
        let between = SetNumber(newest.wrapping_sub(first.plain().0)).plain();
        if usize::from(between.0) >= OLDER {
            return false;
        }
        let place = self.newest.place();
        if let Some(slot) = self.sets.get_mut(place) {
            *slot = config.limits;
        }
        #[cfg(feature = "shaping")]
        if let Some(slot) = self.free.get_mut(place) {
            *slot = config.free;
        }
        self.newest = SetNumber(newest.wrapping_add(1)).plain();
        true
    }
}

/// All sets that are in effect somewhere.
#[derive(Clone, Copy, Debug)]
pub struct LimitSets<'a, S, const N: usize> {
    newest: &'a Limits<S, N>,
    #[cfg(feature = "shaping")]
    free: &'a Limits<S, N>,
    older: &'a OlderLimits<S, N>,
}

impl<'a, S: Scalar, const N: usize> LimitSets<'a, S, N> {
    pub fn new(config: &'a Config<S, N>, older: &'a OlderLimits<S, N>) -> Self {
        Self {
            newest: &config.limits,
            #[cfg(feature = "shaping")]
            free: &config.free,
            older,
        }
    }

    /// One set everywhere.
    #[cfg(test)]
    pub fn only(limits: &'a Limits<S, N>) -> Self {
        Self {
            newest: limits,
            #[cfg(feature = "shaping")]
            free: limits,
            older: std::boxed::Box::leak(std::boxed::Box::new(OlderLimits::NONE)),
        }
    }

    /// The limits of a block.
    #[inline]
    pub fn of(self, set: SetNumber) -> &'a Limits<S, N> {
        #[cfg(feature = "shaping")]
        if set != set.plain() {
            let newest = OLDER == 0 || set.plain() == self.older.newest;
            return self.older.free.get(set.place()).filter(|_| !newest).unwrap_or(self.free);
        }
        if OLDER == 0 || set == self.older.newest {
            return self.newest;
        }
        self.older.sets.get(set.place()).unwrap_or(self.newest)
    }

    /// The time scale on which the machine's motion changes, s.
    pub fn time_scale(self) -> S {
        self.newest.time_scale()
    }
}
