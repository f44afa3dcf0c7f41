//! What a construction costs: a number that counts what is done with it.

use std::cell::Cell;
use std::ops::{Add, Div, Mul, Neg, Sub};

thread_local! {
    static COUNT: Cell<Effort> = const { Cell::new(Effort { operations: 0, roots: 0 }) };
}

/// Operations that were done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Additions, subtractions, multiplications and divisions.
    pub operations: u32,
    /// Square roots.
    pub roots: u32,
}

/// A number: plain, or one that counts.
pub trait Number:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The square root.
    fn root(self) -> Self;
}

impl Number for f64 {
    fn root(self) -> Self {
        self.sqrt()
    }
}

/// A number that counts: what a compiler knows beforehand costs nothing.
#[derive(Clone, Copy, Debug)]
pub struct Tally {
    value: f64,
    known: bool,
}

impl Tally {
    /// A value that is not known beforehand.
    pub fn input(value: f64) -> Self {
        Self { value, known: false }
    }

    fn is(self, value: f64) -> bool {
        self.known && self.value.to_bits() == value.to_bits()
    }

    /// The result of an operation on two of them.
    fn counted(self, other: Self, value: f64) -> Self {
        let known = self.known && other.known;
        if !known {
            count(1, 0);
        }
        Self { value, known }
    }
}

fn count(operations: u32, roots: u32) {
    COUNT.with(|count| {
        let Effort { operations: o, roots: r } = count.get();
        count.set(Effort { operations: o + operations, roots: r + roots });
    });
}

impl From<f64> for Tally {
    fn from(value: f64) -> Self {
        Self { value, known: true }
    }
}

impl Add for Tally {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        match (self.is(0.0), other.is(0.0)) {
            (true, _) => other,
            (_, true) => self,
            _ => self.counted(other, self.value + other.value),
        }
    }
}

impl Sub for Tally {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        if other.is(0.0) { self } else { self.counted(other, self.value - other.value) }
    }
}

impl Mul for Tally {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        match (self, other) {
            (a, b) | (b, a) if a.is(0.0) || b.is(1.0) => a,
            (a, b) | (b, a) if a.is(-1.0) => -b,
            _ => self.counted(other, self.value * other.value),
        }
    }
}

impl Div for Tally {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self.counted(other, self.value / other.value)
    }
}

impl Neg for Tally {
    type Output = Self;
    /// A change of sign goes with the next operation.
    fn neg(self) -> Self {
        Self { value: -self.value, known: self.known }
    }
}

impl Number for Tally {
    fn root(self) -> Self {
        if !self.known {
            count(0, 1);
        }
        Self { value: self.value.sqrt(), known: self.known }
    }
}

/// What a computation costs, in this thread.
pub fn effort<R>(computation: impl FnOnce() -> R) -> Effort {
    let before = COUNT.with(Cell::get);
    let _ = computation();
    let after = COUNT.with(Cell::get);
    Effort { operations: after.operations - before.operations, roots: after.roots - before.roots }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_operation_counts_once() {
        let spent = effort(|| {
            let (a, b) = (Tally::input(3.0), Tally::input(4.0));
            -(a * a + b * b).root() / Tally::from(2.0) - a
        });
        assert_eq!(spent, Effort { operations: 5, roots: 1 });
        let (a, zero) = (Tally::input(3.0), Tally::from(0.0));
        let known = || Tally::from(2.0) * Tally::from(3.0) + (a * zero + a * Tally::from(-1.0));
        assert_eq!(effort(known), Effort { operations: 1, roots: 0 });
        assert_eq!(effort(|| 1.0f64 + 2.0), Effort::default());
    }
}
