//! The pieces of the lines of a run that have tags of their own.

use crate::number::optional::Optional;
use crate::number::{Interval, Length, Scalar};
use crate::path::straight::{self, NEAR};
use heapless::Vec;

/// Pieces that are remembered; of more, the tag of the next is shown.
const PIECES: usize = 10;
/// Longer than any piece, mm.
const FAR: f64 = 1.0e12;

/// A piece of a line with a tag of its own.
#[derive(Clone, Copy)]
struct TaggedPiece<S> {
    /// Where it ends.
    to: Length,
    /// mm.
    length: S,
    tag: u32,
}

impl<S: Scalar> TaggedPiece<S> {
    fn from(&self) -> Length {
        self.to - Length::from_mm(self.length)
    }
}

/// The pieces that no span has shown, in order, and before them those at whose ends cells may still end.
pub struct Pieces<S> {
    list: Vec<TaggedPiece<S>, PIECES>,
    /// Where the first of those began for which there was no room since the last.
    lost: Optional<Length>,
    /// What ends up to here is shown.
    shown_to: Length,
}

impl<S: Scalar> Pieces<S> {
    pub const fn new() -> Self {
        Self { list: Vec::new(), lost: Optional::NONE, shown_to: Length::ZERO }
    }

    pub fn clear(&mut self) {
        self.list.clear();
        self.lost.set(None);
        self.shown_to = Length::ZERO;
    }

    /// Takes note of a piece and its tag. Where there is no room the tag of the next is shown for it: not that of its
    /// line, which may be one behind.
    // Once in the image.
    #[inline(never)]
    pub fn note(&mut self, Interval { from, to }: Interval, tag: u32) {
        if self.list.is_full()
            && let Some(first) = self.list.first().copied()
            && first.to <= self.shown_to
        {
            self.release_before(first.to);
        }
        let from = self.lost.take().map_or(from, |lost| lost.min(from));
        if self.list.push(TaggedPiece { to, length: (to - from).to_mm(), tag }).is_err() {
            self.lost.set(Some(from));
        }
    }

    /// The same of what is left of a piece behind the last one, if that is more than so many mm.
    #[inline(never)]
    pub fn note_rest(&mut self, Interval { from, to }: Interval, least: S, tag: u32) {
        let from = self.list.last().map_or(from, |piece| from.max(piece.to));
        if (to - from).to_mm::<S>() > least {
            self.note(Interval { from, to }, tag);
        }
    }

    /// The tag of what lies around an arc length, if it is not that of its line, which ends at `end` and shows the tag of
    /// its last piece: a piece before that end comes before it.
    pub fn tag_at(&self, s: Length, end: Length) -> Option<u32> {
        let piece = self.list.iter().find(|piece| s < piece.to)?;
        (piece.from() <= s || piece.from() < end).then_some(piece.tag)
    }

    /// Whether any ends up to an arc length.
    pub fn ends_before(&self, s: Length) -> bool {
        self.list.first().is_some_and(|first| first.to <= s)
    }

    /// The end of a piece of at least so many mm that a cell over an interval is cut at, and its tag, if there is one.
    #[inline(never)]
    pub fn end_in(&self, interval: Interval, least: S) -> Option<(Length, u32)> {
        let pieces = self.list.iter().filter(|piece| piece.length >= least);
        straight::end_in(interval, Length::ZERO, pieces.map(|piece| (piece.to, piece.tag)))
    }

    /// The end of a piece of at least so many mm that is near enough to where an interval ends to be its end.
    pub fn end_near(&self, Interval { from, to }: Interval, least: S) -> Option<Length> {
        let near = (to - from) / NEAR;
        let is_near = |p: &&TaggedPiece<S>| p.to - to < near && to - p.to < near;
        self.list.iter().filter(|p| p.length >= least).find(is_near).map(|p| p.to)
    }

    /// The spans up to an arc length show their tags: of what ends before, pieces of at least so many mm are kept while there is room, for cells to
    /// end there.
    pub fn shown_before(&mut self, s: Length, least: S) {
        self.shown_to = s;
        self.release(s, least);
    }

    /// Forgets what lies before an arc length.
    pub fn release_before(&mut self, s: Length) {
        self.release(s, S::of(FAR));
    }

    /// Forgets the pieces before an arc length that are shorter than so many mm.
    // Once in the image.
    #[inline(never)]
    fn release(&mut self, s: Length, least: S) {
        let mut kept = 0;
        for i in 0..self.list.len() {
            if let Some(piece) = self.list.get(i).copied()
                && (piece.to > s || piece.length >= least)
                && let Some(place) = self.list.get_mut(kept)
            {
                *place = piece;
                kept += 1;
            }
        }
        self.list.truncate(kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left of a piece behind the last is noted if it is long enough.
    #[test]
    fn the_rest_of_a_piece_is_noted_if_it_is_long_enough() {
        let at = |mm: f64| Length::from_mm(mm);
        let mut pieces = Pieces::<f64>::new();
        let whole = Interval { from: at(0.0), to: at(2.0) };
        pieces.note_rest(whole, 2.5, 1);
        assert_eq!(pieces.tag_at(at(1.0), at(3.0)), None);
        pieces.note_rest(whole, 1.5, 1);
        pieces.note_rest(whole, 0.0, 2);
        pieces.note_rest(Interval { to: at(2.5), ..whole }, 0.4, 3);
        let tags = [0.5, 1.9, 2.1].map(|s| pieces.tag_at(at(s), at(3.0)));
        assert_eq!(tags, [Some(1), Some(1), Some(3)]);
    }

    #[test]
    fn tags_are_found_where_their_pieces_lie() {
        let at = |mm: f64| Length::from_mm(mm);
        let piece = |from: f64, to: f64| Interval { from: at(from), to: at(to) };
        let mut pieces = Pieces::<f64>::new();
        pieces.note(piece(1.0, 2.0), 7);
        pieces.note(piece(2.0, 2.5), 8);
        assert_eq!(pieces.list.last().map(|piece| piece.to), Some(at(2.5)));
        let tags = [0.5, 1.0, 1.9, 2.0, 2.5].map(|s| pieces.tag_at(at(s), at(s)));
        assert_eq!(pieces.tag_at(at(0.5), at(1.5)), Some(7), "before the end of the line");
        assert_eq!(tags, [None, Some(7), Some(7), Some(8), None]);
        pieces.release_before(at(2.0));
        assert_eq!(
            (pieces.tag_at(at(1.5), at(1.5)), pieces.tag_at(at(2.2), at(2.2))),
            (None, Some(8))
        );
        // Of more than there is room for, the first are kept.
        for k in 0..20 {
            pieces.note(piece(3.0 + f64::from(k), 4.0 + f64::from(k)), k);
        }
        assert_eq!(pieces.tag_at(at(3.5), at(3.5)), Some(0));
        assert_eq!(pieces.tag_at(at(22.5), at(22.5)), None);
        // And what the next stands for, once there is room.
        pieces.release_before(at(5.0));
        pieces.note(piece(30.0, 31.0), 40);
        assert_eq!(pieces.tag_at(at(22.5), at(22.5)), Some(40));
    }
}
