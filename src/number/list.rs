//! Parts of lists, without a way to panic.

use core::ops::Range;

/// `M` neighbours from `at` on; `None` if the list ends before.
#[inline]
pub fn some<T, const M: usize>(list: &[T], at: usize) -> Option<&[T; M]> {
    list.get(at..)?.first_chunk()
}

/// The same, to be changed.
#[inline]
pub fn some_mut<T, const M: usize>(list: &mut [T], at: usize) -> Option<&mut [T; M]> {
    list.get_mut(at..)?.first_chunk_mut()
}

/// A part of a list; empty if the list ends before.
#[inline]
pub fn part<T>(list: &[T], range: Range<usize>) -> &[T] {
    list.get(range).unwrap_or(&[])
}

/// The same, to be changed.
#[inline]
pub fn part_mut<T>(list: &mut [T], range: Range<usize>) -> &mut [T] {
    list.get_mut(range).unwrap_or(&mut [])
}
