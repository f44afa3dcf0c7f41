//! The linear system of a sweep: symmetric, positive definite, of half-width 3, with one right-hand side per axis.

use crate::number::Scalar;
use crate::number::list::{part, part_mut};
use crate::number::vector::Vector;
use core::ops::Range;
use heapless::Vec;

/// The band matrix and the right-hand sides of a sweep over at most `SIZE` control points.
pub struct System<S, const N: usize, const SIZE: usize> {
    /// Row by row, from the diagonal on.
    rows: Vec<[S; 4], SIZE>,
    right: Vec<Vector<S, N>, SIZE>,
}

/// Sum of weighted squares in the four control points of a span: kept apart until it is complete, for the registers hold it.
pub(super) struct Sum<S, const N: usize> {
    /// Upper triangle; the rest is not used.
    rows: [[S; 4]; 4],
    right: [Vector<S, N>; 4],
}

impl<S: Scalar, const N: usize> Sum<S, N> {
    pub(super) const fn new() -> Self {
        Self { rows: [[S::ZERO; 4]; 4], right: [[S::ZERO; N]; 4] }
    }

    /// Adds weight (row . x + value)^2 / 2.
    #[inline]
    pub(super) fn add(&mut self, weight: S, row: &[S; 4], value: &Vector<S, N>) {
        for a in 0..4 {
            let pull = weight * row[a];
            for b in a..4 {
                self.rows[a][b] += pull * row[b];
            }
            for (sum, x) in self.right[a].iter_mut().zip(value) {
                *sum -= pull * *x;
            }
        }
    }
}

impl<S: Scalar, const N: usize, const SIZE: usize> System<S, N, SIZE> {
    /// One that is empty: [`super::sweep::Tube::improve`] fills it.
    pub const fn new() -> Self {
        Self { rows: Vec::new(), right: Vec::new() }
    }

    /// Begins anew, for the sums of spans in ascending order, from that on which ends at the first of the free control
    /// points if there is one.
    pub(super) fn begin(&mut self, free: &Range<usize>) {
        self.rows.clear();
        self.right.clear();
        // What no span ends at, or is not free; the others are put in by the span that ends there.
        let first = free.start.max(3);
        let has_room = self.rows.resize(first, [S::ZERO; 4]).is_ok()
            & self.right.resize(first, [S::ZERO; N]).is_ok();
        debug_assert!(has_room, "no room for what is not free");
    }

    /// What has been solved for, one row for a control point.
    pub(super) fn solution(&self) -> &[Vector<S, N>] {
        &self.right
    }

    /// Adds the squares of a span whose first control point is `at`; those that are not `free` stay where they are.
    #[inline]
    pub(super) fn add(&mut self, at: usize, free: &Range<usize>, sum: &Sum<S, N>) {
        for a in 0..4 {
            let i = at + a;
            if !free.contains(&i) {
                continue;
            }
            if a == 3 {
                debug_assert_eq!(i, self.rows.len(), "spans in ascending order");
                let row = [sum.rows[3][3], S::ZERO, S::ZERO, S::ZERO];
                let pushed = self.rows.push(row).is_ok() & self.right.push(sum.right[3]).is_ok();
                debug_assert!(pushed, "no room for a control point");
                continue;
            }
            let (Some(sums), Some(right)) = (self.rows.get_mut(i), self.right.get_mut(i)) else {
                return;
            };
            for (sum, x) in sums.iter_mut().zip(&sum.rows[a][a..]) {
                *sum += *x;
            }
            for (sum, x) in right.iter_mut().zip(&sum.right[a]) {
                *sum += *x;
            }
        }
    }

    /// Solves the rows of the free control points in place, by L D L^T; couplings to others are left out.
    pub(super) fn solve(&mut self, free: &Range<usize>) {
        let mut rows = part_mut(&mut self.rows, free.clone());
        let mut rights = part_mut(&mut self.right, free.clone());
        while let ([row, later @ ..], [right, later_rights @ ..]) = (rows, rights) {
            let [d, rest @ ..] = *row;
            let per = S::ONE / d;
            let lower = rest.map(|x| x * per);
            let coupled = later.iter_mut().zip(&mut *later_rights).zip(lower).enumerate();
            for (a, ((row, sums), factor)) in coupled {
                for (x, y) in row.iter_mut().zip(&rest[a..]) {
                    *x -= factor * *y;
                }
                for (sum, x) in sums.iter_mut().zip(&*right) {
                    *sum -= factor * *x;
                }
            }
            *row = [per, lower[0], lower[1], lower[2]];
            (rows, rights) = (later, later_rights);
        }
        let rows = part(&self.rows, free.clone()).iter();
        let rights = part_mut(&mut self.right, free.clone());
        for (i, [per, lower @ ..]) in rows.enumerate().rev() {
            let Some((first, later)) = rights.get_mut(i..).and_then(<[_]>::split_first_mut) else {
                return;
            };
            for (n, x) in first.iter_mut().enumerate() {
                *x = *x * *per;
                for (l, right) in lower.iter().zip(&*later) {
                    *x -= *l * right[n];
                }
            }
        }
    }
}

impl<S: Scalar, const N: usize, const SIZE: usize> Default for System<S, N, SIZE> {
    fn default() -> Self {
        Self::new()
    }
}
