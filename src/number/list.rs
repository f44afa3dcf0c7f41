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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_beyond_the_end_are_none_or_empty() {
        let mut list = [1, 2, 3, 4, 5];
        assert_eq!(some::<_, 3>(&list, 2), Some(&[3, 4, 5]));
        assert_eq!(some::<_, 3>(&list, 3), None);
        assert_eq!(some::<_, 1>(&list, usize::MAX), None);
        assert_eq!(part(&list, 1..3), [2, 3]);
        assert!(part(&list, 3..6).is_empty());
        if let Some([first, _]) = some_mut(&mut list, 3) {
            *first = 9;
        }
        part_mut(&mut list, 0..1).fill(7);
        part_mut(&mut list, 0..9).fill(0);
        assert_eq!(list, [7, 2, 3, 9, 5]);
    }
}
