//! Numbers that two contexts share without locks and without `unsafe`: atomics, word by word.
//!
//! A value of more than one word is not read whole by itself; whoever shares it says by another
//! atomic when it may be read.

use super::atomic::AtomicU32;
use super::{ArcLength, Coord};
use core::sync::atomic::Ordering::Relaxed;

/// Shared storage of a `T`.
pub trait Shared<T>: Sync + Send {
    /// Zero.
    const ZERO: Self;
    /// The value, as last stored.
    fn load(&self) -> T;
    /// Stores a value.
    fn store(&self, value: T);
}

impl Shared<f32> for AtomicU32 {
    // Made anew wherever it is named, which is the intention.
    #[allow(clippy::declare_interior_mutable_const)]
    const ZERO: Self = Self::new(0);
    #[inline]
    fn load(&self) -> f32 {
        f32::from_bits(Self::load(self, Relaxed))
    }
    #[inline]
    fn store(&self, value: f32) {
        Self::store(self, value.to_bits(), Relaxed);
    }
}

/// Two words, the lower one first: the targets have no 64-bit atomics.
type Pair = [AtomicU32; 2];

fn load_pair(pair: &Pair) -> u64 {
    u64::from(pair[0].load(Relaxed)) | u64::from(pair[1].load(Relaxed)) << 32
}

fn store_pair(pair: &Pair, value: u64) {
    pair[0].store(value as u32, Relaxed);
    pair[1].store((value >> 32) as u32, Relaxed);
}

impl Shared<f64> for Pair {
    #[allow(clippy::declare_interior_mutable_const)]
    const ZERO: Self = [AtomicU32::new(0), AtomicU32::new(0)];
    #[inline]
    fn load(&self) -> f64 {
        f64::from_bits(load_pair(self))
    }
    #[inline]
    fn store(&self, value: f64) {
        store_pair(self, value.to_bits());
    }
}

impl Shared<Coord> for Pair {
    #[allow(clippy::declare_interior_mutable_const)]
    const ZERO: Self = [AtomicU32::new(0), AtomicU32::new(0)];
    #[inline]
    fn load(&self) -> Coord {
        Coord::from_raw(load_pair(self).cast_signed())
    }
    #[inline]
    fn store(&self, value: Coord) {
        store_pair(self, value.raw().cast_unsigned());
    }
}

impl Shared<ArcLength> for Pair {
    #[allow(clippy::declare_interior_mutable_const)]
    const ZERO: Self = [AtomicU32::new(0), AtomicU32::new(0)];
    #[inline]
    fn load(&self) -> ArcLength {
        ArcLength::from_raw(load_pair(self).cast_signed())
    }
    #[inline]
    fn store(&self, value: ArcLength) {
        store_pair(self, value.raw().cast_unsigned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stored_is_loaded_to_the_bit() {
        let word = <AtomicU32 as Shared<f32>>::ZERO;
        for x in [0.0f32, -0.0, 1.5e-30, f32::INFINITY, f32::NAN] {
            Shared::<f32>::store(&word, x);
            assert_eq!(Shared::<f32>::load(&word).to_bits(), x.to_bits());
        }
        let pair = <Pair as Shared<f64>>::ZERO;
        for x in [-0.0f64, 1.5e-300, -f64::MAX, f64::NAN] {
            Shared::<f64>::store(&pair, x);
            assert_eq!(Shared::<f64>::load(&pair).to_bits(), x.to_bits());
        }
        for raw in [0, -1, i64::MIN, i64::MAX, 1 << 32, -(1 << 32)] {
            Shared::<Coord>::store(&pair, Coord::from_raw(raw));
            assert_eq!(Shared::<Coord>::load(&pair), Coord::from_raw(raw));
            Shared::<ArcLength>::store(&pair, ArcLength::from_raw(raw));
            assert_eq!(Shared::<ArcLength>::load(&pair), ArcLength::from_raw(raw));
        }
    }
}
